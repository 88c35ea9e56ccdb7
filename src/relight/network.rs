//! New light through the coefficients that a bake has left.

use super::known::{Known, carried, reflected, sum};
use super::sources::Looks;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::NodeLight;
use crate::output::report::SolverReport;
use crate::params::Params;
use crate::progress::{Event, Progress};
use crate::radiosity::refined::{Light, narrow, wide};
use crate::radiosity::solver::{self, Solved};
use crate::scene::{Geometry, Scene};
use crate::solution::Baked;
use crate::twin::TwinEngine;
use crate::twin::assign::Surface;
use crate::twin::jacobi::System;
use glam::DVec3;

/// Solves until the combination of known light fits what it makes.
const ROUNDS: u32 = 2;
/// Links up to which sweeps take the host less than a device's dispatches.
const FEW_LINKS: usize = 1 << 20;

/// New light on the nodes, and what is known of it.
pub(super) struct Relit {
    /// The nodes' light, in the changed scene's scale.
    pub light: Vec<NodeLight>,
    pub solved: Solved,
    pub solver: SolverReport,
    /// What each tile sends; empty where it was not asked.
    pub bright: Vec<f64>,
    /// Error beyond the bake's, as a share of the mean radiosity.
    pub extra: f64,
    /// Share of the new light that the bake's rays carry.
    pub known: f64,
    /// Rays drawn for the new light that would scatter as little.
    pub effective: f64,
}

impl Relit {
    /// The bake's light times a factor a band.
    pub fn scaled(baked: &Baked, factors: [f64; 3], solver: &SolverReport, rays: f64) -> Relit {
        let times = |x: [f32; 3]| [0, 1, 2].map(|k| (f64::from(x[k]) * factors[k]) as f32);
        let scaled = |l: &NodeLight| NodeLight { h: times(l.h), g0: times(l.g0), g1: times(l.g1), ..NodeLight::default() };
        Relit {
            light: baked.light.iter().map(scaled).collect(),
            solved: Solved { error_bound: solver.error_bound.unwrap_or(0.0), ..Solved::default() },
            solver: solver.clone(),
            bright: Vec::new(),
            extra: 0.0,
            known: 1.0,
            effective: rays,
        }
    }
}

/// What a relight is given.
pub(super) struct Job<'a> {
    pub params: &'a Params,
    /// The changed scene.
    pub scene: &'a Scene,
    /// The baked scene, and the changed one.
    pub before: &'a Geometry,
    pub after: &'a Geometry,
    /// The nodes, as they lie in the changed scene.
    pub surface: &'a Surface,
    /// The bake's coefficients; `node_source` is what its rays made of its direct light.
    pub system: &'a System,
    pub baked: &'a Baked,
}

impl Job<'_> {
    /// The order of passes, on an engine of either scene.
    pub fn solve<E: Engine>(&self, then: &mut E, now: &mut E, progress: &mut Progress) -> Result<Relit> {
        let Job { params, before, after, surface, system, baked, .. } = self;

        // Direct light, of the same samples.
        progress.event(Event::Stage { name: "direct" })?;
        now.set_surface(surface)?;
        let looks = Looks::new(now, after, surface, params.seed, progress)?;
        let fit = |direct: Vec<[f32; 3]>| looks.fit(surface, params.ridge, &direct);
        let direct_then = fit(looks.direct(then, params.seed, progress)?);
        let direct = fit(looks.direct(now, params.seed, progress)?);

        // What is known, in the changed scene's scale.
        progress.event(Event::Stage { name: "solve" })?;
        let unit = after.emission_scale / before.emission_scale;
        let rho = |geometry: &Geometry, m: u32| DVec3::from_array(geometry.materials[m as usize].rho.map(f64::from));
        let rho_then: Vec<DVec3> = system.planes.iter().map(|p| rho(before, baked.of[p.material as usize])).collect();
        let rho_now: Vec<DVec3> = system.planes.iter().map(|p| rho(after, p.material)).collect();
        let times = |light: &[Light]| -> Vec<Light> { light.iter().map(|l| l.map(|x| x * unit)).collect() };
        let light_then: Vec<Light> = baked.light.iter().map(wide).collect();
        let areas = looks.areas(surface.nodes.len());
        let known = Known::new(system, &times(&direct_then), &times(&light_then), unit, &rho_then, areas);

        // The first bounce by cells, and what cells miss of as much of all light as is known.
        let first = carried(system, &reflected(&direct, &rho_now));
        let mut light: Vec<NodeLight> = vec![NodeLight::default(); surface.nodes.len()];
        let sent = |light: &[NodeLight]| {
            let all: Vec<Light> = light.iter().map(wide).collect();
            reflected(&sum(&direct, &all, 1.0), &rho_now)
        };
        let mut solved = Solved::default();
        let mut round = (*system).clone();
        let few = system.cell_links.len() + system.node_links.len() <= FEW_LINKS;
        for _ in 0..ROUNDS {
            let missed = known.missed(&known.mix(&sent(&light)));
            round.node_source = sum(&first, &missed, 1.0).iter().map(narrow).collect();
            (light, solved) = match few {
                true => solver::solve(&mut TwinEngine::new(after), after, &round, params, None, progress, self.scene)?,
                false => solver::solve(now, after, &round, params, None, progress, self.scene)?,
            };
        }

        // What is new about it.
        let later: Vec<Light> = light.iter().map(wide).collect();
        let parts = [&direct, &later].map(|l| reflected(l, &rho_now));
        let sent = sum(&parts[0], &parts[1], 1.0);
        let rests = parts.map(|part| sum(&part, &known.of(&known.mix(&part)), -1.0));
        let rest = sum(&rests[0], &rests[1], 1.0);
        let mean_of = |l: &Light| l[0].element_sum() / 3.0;
        let bright: Vec<f64> = sent.iter().map(|l| mean_of(l).max(0.0)).collect();
        let bright_then: Vec<f64> = known.sent().iter().map(|l| mean_of(l).max(0.0)).collect();
        let scatter = self.scatter(&bright, &bright_then, known.areas());
        let area: f64 = known.areas().iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let over = |what: &dyn Fn(usize) -> f64| known.areas().iter().enumerate().map(|(i, a)| a * what(i)).sum::<f64>() / area;
        let norm = |l: &[Light]| over(&|i| l[i][0].length_squared() / 3.0).sqrt();
        let mean = over(&|i| bright[i]);
        let reflects = over(&|i| rho_now[i].length_squared() / 3.0).sqrt();
        let share = |x: f64, of: f64| if of > 0.0 { x / of } else { 0.0 };
        // Each rest is taken to be blurred as the known light of its sort is.
        let blurred = reflects * share((known.blur[0] * norm(&rests[0])).hypot(known.blur[1] * norm(&rests[1])), mean);
        let rays = baked.error.as_ref().and_then(|e| e.parts.rays).unwrap_or(0.0);
        let noise = rays * (scatter - 1.0).max(0.0).sqrt();
        Ok(Relit {
            bright: looks.on_tiles(after, &bright),
            extra: blurred.hypot(noise),
            known: (1.0 - share(norm(&rest), norm(&sent))).max(0.0),
            effective: f64::from(params.rays) / scatter,
            light,
            solved,
            solver: SolverReport {
                method: if solved.accelerated { "jacobi+gmres".into() } else { "jacobi".into() },
                sweeps: u64::from(solved.sweeps),
                residual: Some(solved.residual),
                error_bound: Some(solved.error_bound),
            },
        })
    }

    /// How much more the bake's rays scatter for a light than they did for their own, as a variance relative to the light's square:
    /// rays were drawn where their own light was, and those that meet other light are fewer.
    fn scatter(&self, light: &[f64], own: &[f64], areas: &[f64]) -> f64 {
        let (alpha, gamma) = (self.params.alpha, self.params.gamma);
        let area: f64 = areas.iter().sum();
        let wanted: Vec<f64> = own.iter().map(|b| b.powf(gamma)).collect();
        let all: f64 = wanted.iter().zip(areas).map(|(w, a)| w * a).sum();
        if !(all > 0.0 && area > 0.0) {
            return 1.0;
        }
        let density: Vec<f64> = wanted.iter().map(|w| (1.0 - alpha) / area + alpha * w / all).collect();
        let spread = |light: &[f64]| {
            let over = |what: &dyn Fn(usize) -> f64| areas.iter().enumerate().map(|(i, a)| a * what(i)).sum::<f64>();
            over(&|i| light[i] * light[i] / density[i]) / over(&|i| light[i]).powi(2)
        };
        let (now, then) = (spread(light), spread(own));
        if now.is_finite() && then > 0.0 { now / then } else { 1.0 }
    }
}
