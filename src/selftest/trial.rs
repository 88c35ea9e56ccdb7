//! A case being tried: the machine, and what it found so far.

use super::{Outcome, Spoil};
use crate::bake::bake;
use crate::engine::{Backend, Engine};
use crate::error::{Error, Result};
use crate::layout::{Point, kind};
use crate::params::Params;
use crate::progress::{Event, Flow};
use crate::scene::{Geometry, Scene};
use crate::solution::{Answer, Solution, SurfacePoint};
use crate::twin::math::unit;
use crate::twin::sobol::sobol4;
use crate::twin::trace::{place_on, surface_point};

/// Seed of all that is drawn: what passes here passes again.
pub const SEED: u32 = 5;
/// Cosine rays a start: few, as across a narrow gap it is the starts that count.
const RAYS: u32 = 16;

pub struct Trial<'a> {
    pub backend: &'a Backend,
    pub spoil: Spoil,
    case: &'static str,
    outcomes: Vec<Outcome>,
    tell: &'a mut dyn FnMut(&Event) -> Flow,
}

/// Runs `work` on an engine for a geometry.
macro_rules! on_engine {
    ($backend:expr, $geometry:expr, $engine:ident => $work:expr) => {
        match $backend {
            Backend::Cpu => {
                let $engine = &mut $crate::twin::TwinEngine::new($geometry);
                $work
            }
            Backend::Gpu(gpu) => {
                let $engine = &mut $crate::pass::GpuEngine::new(gpu, $geometry)?;
                $work
            }
        }
    };
}
pub(super) use on_engine;

impl<'a> Trial<'a> {
    pub fn new(backend: &'a Backend, case: &'static str, spoil: Spoil, tell: &'a mut dyn FnMut(&Event) -> Flow) -> Trial<'a> {
        Trial { backend, spoil, case, outcomes: Vec::new(), tell }
    }

    pub fn outcomes(self) -> Vec<Outcome> {
        self.outcomes
    }

    /// The case ended with an error: that is an outcome, too.
    pub fn failed(&mut self, error: &Error) {
        self.outcomes.push(Outcome {
            case: self.case,
            what: "to come to an end".into(),
            truth: 0.0,
            got: None,
            tolerance: 0.0,
            pass: false,
            error: Some(error.to_string()),
        });
    }

    /// What was found must lie within `tolerance` of the truth; 0 means exactly.
    pub fn near(&mut self, what: impl Into<String>, truth: f64, got: f64, tolerance: f64) {
        let truth = if self.spoil == Spoil::Truths { 1.1 * truth + 0.1 } else { truth };
        // What is no number is near to nothing.
        let pass = (got - truth).abs() <= tolerance;
        self.outcomes.push(Outcome { case: self.case, what: what.into(), truth, got: Some(got), tolerance, pass, error: None });
    }

    /// As [`Trial::near`], of the value that is farthest from the truth.
    pub fn all_near(&mut self, what: impl Into<String>, truth: f64, got: &[f64], tolerance: f64) {
        let off = |x: f64| if x.is_nan() { f64::INFINITY } else { (x - truth).abs() };
        let worst = got.iter().copied().max_by(|a, b| off(*a).total_cmp(&off(*b)));
        self.near(what, truth, worst.unwrap_or(f64::NAN), tolerance);
    }

    /// A share of `n` independent rays: 5 standard errors. Low-discrepancy rays scatter less.
    pub fn share(&mut self, what: impl Into<String>, truth: f64, (got, n): (f64, usize)) {
        self.near(what, truth, got, 5.0 * (truth * (1.0 - truth) / n as f64).sqrt());
    }

    /// Share of the cosine rays from a scene's faces `from` that meet the fronts of its faces `to`; and how many rays
    /// there were, about `rays`.
    pub fn form_factor(
        &mut self,
        scene: &Scene,
        from: impl Fn(u32) -> bool,
        to: impl Fn(u32) -> bool,
        rays: u32,
    ) -> Result<(f64, usize)> {
        let geometry = Geometry::new(scene)?;
        let hits = self.shoot(&geometry, &starts(&geometry, from, rays / RAYS))?;
        let met = |p: &&Point| p.kind == kind::FRONT && to(geometry.source[p.tri as usize]);
        Ok((hits.iter().filter(met).count() as f64 / hits.len() as f64, hits.len()))
    }

    /// What cosine rays from points meet.
    pub fn shoot(&mut self, geometry: &Geometry, from: &[Point]) -> Result<Vec<Point>> {
        on_engine!(self.backend, geometry, engine => {
            let batch = engine.upload(from)?;
            let hits = engine.shoot(&batch, SEED, 0, RAYS)?;
            engine.points(&hits)
        })
    }

    /// G V of pairs of points, per local area.
    pub fn kernel(&mut self, geometry: &Geometry, pairs: &[Point]) -> Result<Vec<f32>> {
        on_engine!(self.backend, geometry, engine => engine.kernel(pairs))
    }

    /// Bakes; only whether to stop is asked for meanwhile.
    pub fn bake(&mut self, scene: &Scene, params: &Params) -> Result<Solution> {
        self.bake_on(self.backend, scene, params)
    }

    /// As [`Trial::bake`], on another machine.
    pub fn bake_on(&mut self, backend: &Backend, scene: &Scene, params: &Params) -> Result<Solution> {
        bake(backend, scene, params, &mut |_| (self.tell)(&Event::Tick))
    }

    /// Bakes, and answers for about `n` points spread over the faces that are meant.
    pub fn light(&mut self, scene: &Scene, params: &Params, faces: impl Fn(u32) -> bool, n: u32) -> Result<Vec<Answer>> {
        let points = spread(scene, faces, n)?;
        self.bake(scene, params)?.query(self.backend, &points)
    }
}

/// `n` points spread evenly over the area of the faces that are meant.
pub fn starts(geometry: &Geometry, faces: impl Fn(u32) -> bool, n: u32) -> Vec<Point> {
    let tris: Vec<usize> = (0..geometry.tris.len()).filter(|&t| faces(geometry.source[t])).collect();
    let mut ends = Vec::new();
    let mut sum = 0.0;
    for &t in &tris {
        sum += geometry.areas[t];
        ends.push(sum);
    }
    let place = |i: u32| {
        let u = sobol4(i, SEED).map(unit);
        let at = ends.partition_point(|&end| end <= f64::from(u[0]) * sum).min(tris.len() - 1);
        let (b1, b2) = place_on(geometry.flatland, u[1], u[2]);
        surface_point(geometry, tris[at] as u32, b1, b2)
    };
    if tris.is_empty() { Vec::new() } else { (0..n).map(place).collect() }
}

/// As [`starts`], as points that a solution is asked for.
pub fn spread(scene: &Scene, faces: impl Fn(u32) -> bool, n: u32) -> Result<Vec<SurfacePoint>> {
    let geometry = Geometry::new(scene)?;
    let ask = |p: &Point| {
        let normal = geometry.tris[p.tri as usize].normal.map(f64::from);
        SurfacePoint { p: geometry.to_world(p.p), n: normal }
    };
    Ok(starts(&geometry, faces, n).iter().map(ask).collect())
}
