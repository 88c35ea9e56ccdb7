//! Sweeps of an iteration to a stated distance from its fixed point, or a stated number of them.

use super::components::Components;
use super::gauss_seidel::GaussSeidel;
use super::refined;
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::layout::NodeLight;
use crate::params::{Params, Solver};
use crate::progress::{Event, Progress};
use crate::scene::{Geometry, Scene};
use crate::twin::jacobi::System;
use serde::{Deserialize, Serialize};

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Solved {
    /// Sweeps done.
    pub sweeps: u32,
    /// Last change between sweeps, relative to the largest irradiance.
    pub residual: f64,
    /// Measured contraction factor of the iteration.
    pub contraction: f64,
    /// Bound on the relative distance from the fixed point: residual * factor / (1 - factor).
    pub error_bound: f64,
    /// Whether sweeps were accelerated ([`refined`]).
    #[serde(default)]
    pub accelerated: bool,
}

/// Contraction factor above which sweeps are accelerated: plain ones would be some 60 and more.
const SLOW: f64 = 0.8;
/// Share of its most beyond which a node counts as lit by a mode.
const LIT: f32 = 0.1;
/// Looks without progress after which rounding is taken to have the last word.
const STUCK: u32 = 32;
/// Sweeps between looks at the residual.
const STRIDE: u32 = 8;
/// Sweeps of a series between two moments at which the caller may stop.
const SERIES: u32 = 64;

/// The largest irradiance, and the largest change as if every room were as bright as the brightest: a dim room beside it
/// must not stop short. `rooms` numbers each node's; where it is empty there is one.
fn norms(a: &[NodeLight], b: &[NodeLight], rooms: &[u32]) -> (f64, f64) {
    let mut each = vec![(0.0f64, 0.0f64); rooms.iter().max().map_or(1, |&m| m as usize + 1)];
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        let (change, size) = &mut each[rooms.get(i).map_or(0, |&r| r as usize)];
        for k in 0..3 {
            let step = (x.h[k] as f64 - y.h[k] as f64).abs();
            // A maximum would pass over a NaN.
            *change = if step.is_finite() { change.max(step) } else { f64::INFINITY };
            *size = size.max((y.h[k] as f64).abs());
        }
    }
    let largest = each.iter().fold(0.0, |m: f64, x| m.max(x.1));
    let change = each.iter().map(|&(change, size)| if size > 0.0 { change * (largest / size) } else { change });
    (change.fold(0.0, f64::max), largest)
}

/// Makes so many sweeps from a light.
pub type Sweep<'a> = dyn FnMut(&[NodeLight], u32) -> Result<Vec<NodeLight>> + 'a;

/// When an iteration ends.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Relative distance from the fixed point that is near enough.
    pub tolerance: f64,
    /// Most sweeps.
    pub max_sweeps: u32,
    /// So many sweeps and no other end: a series that is broken off.
    pub exactly: Option<u32>,
    /// The contraction factor where it was measured beforehand, else 0.
    pub factor: f64,
}

impl Rule {
    /// The rule of a bake whose sweeps add `bounces` reflections at most.
    pub fn new(params: &Params, bounces: Option<u32>) -> Rule {
        Rule { tolerance: params.tolerance, max_sweeps: params.max_sweeps, exactly: bounces, factor: 0.0 }
    }
}

/// Solves a system from darkness with the solver asked for: all reflections, or `bounces` sweeps. Where all are counted the
/// contraction is measured first, and slow sweeps of Jacobi's are accelerated.
///
/// Errors: [`Error::NotContractive`] where light would grow; those of [`iterate`].
pub fn solve<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    system: &System,
    params: &Params,
    bounces: Option<u32>,
    progress: &mut Progress,
    scene: &Scene,
) -> Result<(Vec<NodeLight>, Solved)> {
    let dark = vec![NodeLight::default(); system.planes.len()];
    let mut rule = Rule::new(params, bounces);
    if bounces.is_none() {
        engine.set_system(&refined::unlit(system))?;
        let mode = refined::measure(engine, system.planes.len(), progress)?;
        if mode.factor >= 1.0 {
            // Of the nodes that the growing light reaches, the brightest material.
            let lit = |j: usize| mode.light[j].h.iter().any(|h| h.abs() >= LIT);
            let reached = (0..mode.light.len()).filter(|&j| lit(j)).map(|j| system.planes[j].material as usize);
            return Err(grows(mode.factor, geometry, reached, scene));
        }
        rule.factor = mode.factor;
    }
    let rooms = Components::of(system).numbers();
    match params.solver {
        Solver::Jacobi if rule.factor > SLOW => refined::solve(engine, system, &geometry.materials, &rooms, rule, progress),
        Solver::Jacobi => {
            engine.set_system(system)?;
            iterate(&mut |light, n| engine.jacobi(light, n), geometry, dark, &rooms, rule, progress, scene)
        }
        Solver::GaussSeidel => {
            let host = GaussSeidel::new(system, &geometry.materials);
            iterate(&mut |light, n| Ok(host.sweeps(light, n)), geometry, dark, &rooms, rule, progress, scene)
        }
    }
}

/// Sweeps from `start` until the distance from the fixed point is below the rule's tolerance times the largest
/// irradiance, in each of the `rooms` that see nothing of each other (a number each node; one room where empty). "Small steps" alone are false convergence (hard case
/// E02): the step is divided by 1 - the measured factor.
///
/// Errors: [`Error::NotContractive`] where the iteration grows; [`Error::NotFinite`].
pub fn iterate(
    sweep: &mut Sweep,
    geometry: &Geometry,
    start: Vec<NodeLight>,
    rooms: &[u32],
    rule: Rule,
    progress: &mut Progress,
    scene: &Scene,
) -> Result<(Vec<NodeLight>, Solved)> {
    if let Some(sweeps) = rule.exactly {
        return series(sweep, start, rooms, sweeps, progress);
    }
    let mut light = start;
    let mut solved = Solved { contraction: rule.factor, ..Solved::default() };
    let (mut last_change, mut least_change) = (f64::NAN, f64::INFINITY);
    let (mut grew, mut stuck) = (0, 0);
    while solved.sweeps < rule.max_sweeps {
        // Sweep, with the last step by itself so that its change can be seen.
        let before = sweep(&light, STRIDE - 1)?;
        light = sweep(&before, 1)?;
        solved.sweeps += STRIDE;
        let (change, size) = norms(&before, &light, rooms);
        if !change.is_finite() || !size.is_finite() {
            return Err(Error::NotFinite { what: "the solution".into() });
        }
        if size == 0.0 {
            solved = Solved { sweeps: solved.sweeps, ..Solved::default() };
            return Ok((light, solved));
        }
        solved.residual = change / size;
        // f32 carries no more than this; a stuck last digit is neither progress nor divergence.
        let floor = 4.0 * f32::EPSILON as f64;
        if last_change > 0.0 && change > 0.0 {
            let factor = (change / last_change).powf(1.0 / STRIDE as f64);
            // What was measured beforehand is better than what late steps, near rounding, seem to say.
            if rule.factor == 0.0 && solved.residual > floor && factor < 1.0 {
                solved.contraction = factor;
            }
            // Rounding makes the steps wander; only steps well above the smallest seen are growth.
            grew = if change > 4.0 * least_change { grew + 1 } else { 0 };
            stuck = if change < 0.9999 * least_change { 0 } else { stuck + 1 };
            if grew >= 6 {
                return Err(grows(factor, geometry, 0..geometry.materials.len(), scene));
            }
        }
        least_change = least_change.min(change);
        last_change = change;
        let factor = solved.contraction.clamp(0.0, 0.999_999);
        solved.error_bound = solved.residual.max(f32::EPSILON as f64) * factor / (1.0 - factor);
        progress.event(Event::Sweep { n: solved.sweeps, residual: solved.error_bound })?;
        if solved.sweeps >= 2 * STRIDE
            && (solved.error_bound < rule.tolerance || solved.residual <= floor || (stuck >= STUCK && grew == 0))
        {
            break;
        }
    }
    Ok((light, solved))
}

/// A stated number of sweeps.
fn series(
    sweep: &mut Sweep,
    mut light: Vec<NodeLight>,
    rooms: &[u32],
    sweeps: u32,
    progress: &mut Progress,
) -> Result<(Vec<NodeLight>, Solved)> {
    let mut solved = Solved::default();
    while solved.sweeps < sweeps {
        let now = SERIES.min(sweeps - solved.sweeps);
        let next = sweep(&light, now)?;
        let (change, size) = norms(&light, &next, rooms);
        if !change.is_finite() || !size.is_finite() {
            return Err(Error::NotFinite { what: "the solution".into() });
        }
        light = next;
        solved.sweeps += now;
        solved.residual = if size > 0.0 { change / size } else { 0.0 };
        progress.event(Event::Sweep { n: solved.sweeps, residual: solved.residual })?;
    }
    Ok((light, solved))
}

/// The error of a light that grows, by the brightest of some materials.
fn grows(factor: f64, geometry: &Geometry, materials: impl Iterator<Item = usize>, scene: &Scene) -> Error {
    let most = |m: usize| f64::from(geometry.most_rho[m]);
    // The first of several.
    let best = materials.map(|m| (most(m), m)).fold((0.0, 0), |best, one| if one.0 > best.0 { one } else { best });
    let material = scene.materials.get(best.1).map_or(String::new(), |m| m.name.clone());
    Error::NotContractive { factor, max_rho: best.0, material }
}
