//! A solved network: what a bake leaves, and what queries, pictures and files are made from.

mod baked;
pub(crate) mod check;
mod file;
pub(crate) mod picture;
pub(crate) mod sections;
mod vertices;

pub(crate) use baked::Baked;
pub use picture::{Camera, Image};

use crate::engine::Backend;
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::layout::{NONE, Node, NodeLight, Point};
use crate::output::report::Report;
use crate::params::{Method, Params};
use crate::pass::GpuEngine;
use crate::progress::{Event, Flow, Progress};
use crate::relight::{Change, relight};
use crate::scene::{Geometry, Scene};
use crate::shade::{Shade, Whole, shade};
use crate::twin::TwinEngine;
use crate::twin::assign::Surface;
use crate::twin::jacobi::System;
use crate::twin::trace::{barycentric, surface_point};
use crate::twin::winner::Feature;
use glam::Vec3;

/// A point to be answered: position (metres) and the normal of the side asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position, metres.
    pub p: [f64; 3],
    /// Normal; its length does not matter.
    pub n: [f64; 3],
}

/// How far an answer can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// On a surface.
    Ok,
    /// No surface that faces this way lies within 1e-3 of the scene's size.
    OffSurface,
    /// Covered by other surfaces: no light can reach it.
    Covered,
    /// On an ideal mirror, which has no radiosity: what it shows depends on whence one looks (pictures follow it).
    Mirror,
}

/// Light at a point, W/m² in linear Rec.709 RGB. All zero where off the surface, and on mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Whether there is light to speak of.
    pub status: Status,
    /// Radiosity B = E + rho H.
    pub b: [f64; 3],
    /// Irradiance H, direct light included.
    pub h: [f64; 3],
    /// Direct irradiance D; 0 where the network carried it (`--direct network`) and no gather was made.
    pub d: [f64; 3],
}

/// A solved network with its scene.
#[derive(Clone, Debug)]
pub struct Solution {
    scene: Scene,
    geometry: Geometry,
    params: Params,
    surface: Surface,
    light: Vec<NodeLight>,
    cells: Vec<Feature>,
    system: System,
    report: Report,
    /// What its bake found, where it was relit since.
    baked: Option<Baked>,
}

impl Solution {
    pub(crate) fn new(
        scene: Scene,
        geometry: Geometry,
        params: Params,
        surface: Surface,
        light: Vec<NodeLight>,
        cells: Vec<Feature>,
        system: System,
        report: Report,
    ) -> Solution {
        Solution { scene, geometry, params, surface, light, cells, system, report, baked: None }
    }

    /// As one that was relit, of a bake that found this.
    pub(crate) fn relit(self, baked: Baked) -> Solution {
        Solution { baked: Some(baked), ..self }
    }

    /// What its bake found, where it was relit since.
    pub(crate) fn baked(&self) -> Option<&Baked> {
        self.baked.as_ref()
    }

    /// What the bake did.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// For later stages to add to.
    #[doc(hidden)]
    pub fn report_mut(&mut self) -> &mut Report {
        &mut self.report
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Nodes of the surface network, local units.
    #[doc(hidden)]
    pub fn nodes(&self) -> &[Node] {
        &self.surface.nodes
    }

    /// Light of the nodes, scaled W/m².
    #[doc(hidden)]
    pub fn light(&self) -> &[NodeLight] {
        &self.light
    }

    /// The scene as the passes see it.
    #[doc(hidden)]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Cells of the network: reference rays in feature space.
    #[doc(hidden)]
    pub fn cells(&self) -> &[Feature] {
        &self.cells
    }

    /// The cells read as coefficients: what new emissions are solved with.
    #[doc(hidden)]
    pub fn system(&self) -> &System {
        &self.system
    }

    /// This solution with other light: emission, groups of lamps, reflectance. The network stays as it is and is only solved
    /// anew, or, where it cannot carry the new light well, the changed scene is baked; [`Report::relit`] tells which, why, and
    /// what it adds to the error. Of a solution that was relit before, the bake it came from is the ground: errors do not add up.
    ///
    /// Errors: [`Error::UnknownName`], [`Error::InvalidReflectance`], [`Error::InvalidEmission`], [`Error::InvalidParam`] for a
    /// factor out of range, or where rays may never be traced but must be; [`Error::NotContractive`]; those of the device,
    /// [`Error::Cancelled`].
    pub fn relight(&self, backend: &Backend, change: &Change, tell: &mut dyn FnMut(&Event) -> Flow) -> Result<Solution> {
        relight(self, backend, change, tell)
    }

    /// Whether the bake that it is of was stopped; [`Report::reached`] says how far it came.
    pub fn is_partial(&self) -> bool {
        self.report.partial
    }

    /// The parameters of its bake.
    pub(crate) fn params(&self) -> &Params {
        &self.params
    }

    /// Its nodes, and which of them may speak where.
    pub(crate) fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Node spacing, local. A partial solution has the nodes of its pilot, or none; patches have a node each.
    pub(crate) fn spacing(&self) -> f64 {
        let patches = matches!(self.params.method, Method::Fem | Method::Hierarchical);
        let nodes = match self.is_partial() || patches {
            true => self.surface.nodes.len().max(1),
            false => self.params.node_count(0, self.geometry.flatland),
        };
        self.geometry.spacing(nodes)
    }

    /// What the read-out knows of it as a whole.
    pub(crate) fn whole(&self) -> Whole {
        let light: f64 = self.light.iter().map(|l| f64::from(l.h.iter().sum::<f32>()) / 3.0).sum();
        let usual = match self.geometry.is_surfaceless() {
            // How much of the sky's light finds its way in is not known.
            true => f64::INFINITY,
            false => self.geometry.power_density() + light / self.light.len().max(1) as f64,
        };
        Whole { spacing: self.spacing(), usual }
    }

    /// Shades points given as triangle and place, as carefully as `params` say.
    fn shade(
        &self,
        backend: &Backend,
        params: &Params,
        points: &[Point],
        tell: &mut dyn FnMut(&Event) -> Flow,
    ) -> Result<Vec<Shade>> {
        fn on<E: Engine>(
            s: &Solution,
            engine: &mut E,
            params: &Params,
            points: &[Point],
            progress: &mut Progress,
        ) -> Result<Vec<Shade>> {
            engine.set_surface(&s.surface)?;
            engine.set_light(&s.light)?;
            shade(engine, params, s.whole(), points, progress)
        }
        let mut progress = Progress::new(tell);
        // Where nothing reflects there is nothing to gather.
        let dark = Params { gather_rays: 0, ..params.clone() };
        let params = if self.geometry.reflects() { params } else { &dark };
        match backend {
            Backend::Cpu => on(self, &mut TwinEngine::new(&self.geometry), params, points, &mut progress),
            Backend::Gpu(gpu) => on(self, &mut GpuEngine::new(gpu, &self.geometry)?, params, points, &mut progress),
        }
    }

    /// Radiosity at any points, in their order. Errors: those of the device; [`Error::NotFinite`].
    pub fn query(&self, backend: &Backend, points: &[SurfacePoint]) -> Result<Vec<Answer>> {
        self.query_with(backend, points, &mut |_| Flow::Continue)
    }

    /// As [`Solution::query`], telling its progress.
    pub fn query_with(
        &self,
        backend: &Backend,
        points: &[SurfacePoint],
        tell: &mut dyn FnMut(&Event) -> Flow,
    ) -> Result<Vec<Answer>> {
        let found: Vec<Point> = points
            .iter()
            .map(|p| match self.geometry.locate(p.p, p.n) {
                Some(at) => {
                    let (b1, b2) = barycentric(self.geometry.flatland, &self.geometry.tris[at.tri as usize], Vec3::from(at.p));
                    surface_point(&self.geometry, at.tri, b1.clamp(0.0, 1.0), b2.clamp(0.0, 1.0))
                }
                None => Point { tri: NONE, tile: NONE, ..Point::default() },
            })
            .collect();
        let shades = self.shade(backend, &self.params, &found, tell)?;
        found.iter().zip(shades).enumerate().map(|(i, (p, s))| self.answer(p, &s, || format!("the light at point {i}"))).collect()
    }

    /// Turns a shade into user units.
    fn answer(&self, point: &Point, shade: &Shade, what: impl Fn() -> String) -> Result<Answer> {
        let nothing = |status| Ok(Answer { status, b: [0.0; 3], h: [0.0; 3], d: [0.0; 3] });
        if point.tri == NONE {
            return nothing(Status::OffSurface);
        }
        if self.geometry.tris[point.tri as usize].mirror() > 0.0 {
            return nothing(Status::Mirror);
        }
        let (reflectance, emission) = self.geometry.shown(&self.scene, point.tri, Vec3::from(point.p));
        let unscale = self.geometry.arrives / self.geometry.emission_scale;
        let h = shade.irradiance.map(|x| x * unscale);
        let b = [0, 1, 2].map(|k| std::f64::consts::PI * emission[k] + reflectance[k] * h[k]);
        if !b.iter().chain(&h).all(|x| x.is_finite()) {
            return Err(Error::NotFinite { what: what() });
        }
        let status = if shade.covered { Status::Covered } else { Status::Ok };
        Ok(Answer { status, b, h, d: shade.direct.map(|x| x * unscale) })
    }
}

/// Numbers of a mesh or a picture. Errors: [`Error::Overflow`] rather than infinity.
fn narrow(wide: [f64; 3], what: impl Fn() -> String) -> Result<[f32; 3]> {
    match wide.into_iter().find(|&x| (x as f32).is_infinite()) {
        Some(value) => Err(Error::Overflow { what: what(), value }),
        None => Ok(wide.map(|x| x as f32)),
    }
}
