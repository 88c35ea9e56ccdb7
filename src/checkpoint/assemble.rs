//! A solution from what a bake has found, whole or as far as it came.

use super::{Checkpoint, Learned, Network};
use crate::doctor;
use crate::error::Result;
use crate::layout::{Node, NodeLight, Plane};
use crate::network::candidates::worth_marking;
use crate::network::growth::Growth;
use crate::network::nodes::surface_of;
use crate::output::report::{Report, SceneReport, SolverReport};
use crate::params::Params;
use crate::scene::{Geometry, Scene};
use crate::solution::Solution;
use crate::twin::jacobi::System;
use crate::twin::winner::Feature;

/// Share of all light that may be given up between mirrors without a word.
const GIVEN_UP: f64 = 1e-3;

impl Checkpoint {
    /// The solution as far as the bake came; its report says how far ([`Report::partial`], [`Report::reached`]).
    ///
    /// Until the network is solved the pilot's light is all there is; before that there is none, and points are
    /// answered with direct light and what one final gather brings. Scene and parameters must be the bake's
    /// own. Errors: those of [`Scene::check`].
    pub fn solution(&self, scene: &Scene, params: &Params) -> Result<Solution> {
        let geometry = Geometry::for_bake(scene, params)?;
        Ok(self.assemble(scene, &geometry, params, doctor::warnings(scene, &geometry)))
    }

    pub(crate) fn assemble(&self, scene: &Scene, geometry: &Geometry, params: &Params, warnings: Vec<String>) -> Solution {
        let net = &self.network;
        let mut report = Report {
            raycell: env!("CARGO_PKG_VERSION").into(),
            scene: SceneReport {
                path: scene.name.clone(),
                triangles: geometry.tris.len() as u64,
                dropped: (geometry.degenerate.len() + geometry.duplicate.len()) as u64,
            },
            method: word(&params.method),
            seed: params.seed,
            params: params.clone(),
            partial: !self.is_whole(),
            reached: self.reached(),
            energy: self.energy.clone().unwrap_or_default(),
            warnings: [warnings, self.pilot.as_ref().map_or(Vec::new(), |p| p.winding.clone())].concat(),
            ..Report::default()
        };
        if let Some(share) = report.energy.given_up.filter(|share| *share > GIVEN_UP) {
            report.warnings.push(format!(
                "light is given up after {} mirrors: up to {:.2} % of all; lower the mirrors' reflectance",
                crate::twin::way::MIRRORS,
                100.0 * share
            ));
        }
        let (nodes, light, cells, system) = match (net, &self.pilot) {
            (Network { nodes: Some(nodes), growth, coefficients: Some(c), solved: Some(solved), light, .. }, _) => {
                report.coefficients = c.stored;
                report.kernel_evaluations = c.evaluations;
                report.solver = SolverReport {
                    method: format!("{}{}", word(&params.solver), if solved.accelerated { "+gmres" } else { "" }),
                    sweeps: solved.sweeps as u64,
                    residual: Some(solved.residual),
                    // A series that is broken off has no fixed point.
                    error_bound: params.bounces.is_none().then_some(solved.error_bound),
                };
                (nodes.clone(), light.clone(), cells(growth, &self.learned), c.system.clone())
            }
            // Nothing reflects: there was nothing to solve.
            (_, None) if self.is_whole() => {
                report.solver = SolverReport { method: "none".into(), sweeps: 0, residual: Some(0.0), error_bound: Some(0.0) };
                (Vec::new(), Vec::new(), Vec::new(), unread(&[]))
            }
            (_, Some(pilot)) => (pilot.nodes.clone(), pilot.light.clone(), Vec::new(), unread(&pilot.nodes)),
            _ => (Vec::new(), Vec::new(), Vec::new(), unread(&[])),
        };
        report.cells = self.learned.as_ref().map_or(system.source.len(), |l| l.cells.len()) as u64;
        report.nodes = nodes.len() as u64;
        report.rays = net.rays as u64 + net.coefficients.as_ref().map_or(0, |c| c.looks);
        let known = net.surface.as_ref().filter(|s| s.nodes == nodes).cloned();
        let surface =
            known.unwrap_or_else(|| surface_of(geometry, nodes, params.lambda as f32, worth_marking(geometry, params.rays)));
        Solution::new(scene.clone(), geometry.clone(), params.clone(), surface, light, cells, system, report)
    }

    /// How far the bake came, in words; none where it is whole.
    pub fn reached(&self) -> Option<String> {
        let (net, rays) = (&self.network, self.key.as_ref().map_or(0, |k| k.rays()));
        let full = |text: String| if self.pilot.is_some() { text } else { "pilot".into() };
        match net {
            _ if self.is_whole() => None,
            Network { solved: Some(_), .. } => Some(full(format!("solve, {} refinements", net.refined))),
            Network { coefficients: Some(_), .. } => Some(full("coefficients".into())),
            Network { growth: Some(g), .. } => {
                Some(full(format!("training, {} cells, {} of {} winners", g.cells.len(), net.winners.len() / 2, rays)))
            }
            Network { .. } if net.rays > 0 => Some(full(format!("training, {} of {rays} rays", net.rays))),
            Network { nodes: Some(_), .. } => Some(full("nodes".into())),
            _ => Some("pilot".into()),
        }
    }
}

/// The cells of a trained network.
fn cells(growth: &Option<Growth>, learned: &Option<Learned>) -> Vec<Feature> {
    let trained = growth.as_ref().map(|g| &g.cells).or(learned.as_ref().map(|l| &l.cells));
    trained.cloned().unwrap_or_default()
}

/// A parameter's choice as it is spelled in files.
fn word(choice: &impl serde::Serialize) -> String {
    serde_json::to_value(choice).ok().and_then(|v| v.as_str().map(str::to_string)).unwrap_or_default()
}

/// The system of nodes that no cell speaks of.
pub(crate) fn unread(nodes: &[Node]) -> System {
    System {
        cell_offsets: vec![0],
        node_offsets: vec![0; nodes.len() + 1],
        planes: nodes.iter().map(|n| Plane { material: n.material, ..Plane::default() }).collect(),
        node_source: vec![NodeLight::default(); nodes.len()],
        ..System::default()
    }
}
