//! A bake that is to reach something: an error, or the end of its time. It climbs a ladder of sizes, each twice the
//! one before, and each a bake of its own: what comes out depends on the rung that it ended on and on nothing else.

use crate::accuracy::estimate::median_region;
use crate::bake::{Prepared, bake_prepared};
use crate::checkpoint::Checkpoint;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::output::report::{ErrorParts, EstimatedError, RungReport, TargetReport};
use crate::params::Params;
use crate::progress::{Event, Flow};
use crate::scene::Scene;
use crate::solution::Solution;
use std::time::{Duration, Instant};

/// How far over its time a bake may run: a share of it, or this many seconds where that is more.
const GRACE: (f64, f64) = (0.05, 0.5);
/// Rung from which a part that does not fall is believed.
const BELIEVED: u32 = 7;
/// Exponent of the error over rays below which it is said not to fall.
const FLAT: f64 = 0.08;
/// Rays that take as long as all that does not grow with them, until two rungs tell. Measured: 15,000 (cornell, city).
const SETTLED: f64 = 8_192.0;

/// What a bake is to reach; with neither it ends on the first rung.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Relative error that the upper end of the estimate is to be within. Half of the surface, by regions,
    /// is to be within twice as much of its own light.
    pub error: Option<f64>,
    /// Wall time for everything, the read-out included.
    pub budget: Option<Duration>,
}

/// Where a climb is, and what goes with it. See [`climb`].
pub struct Climb<'a> {
    /// What to reach.
    pub goal: Goal,
    /// Work that counts as done before; its rung is gone on with.
    pub checkpoint: &'a mut Checkpoint,
    /// A whole solution of an earlier climb with the same parameters.
    pub solution: Option<Solution>,
    /// When the time began.
    pub begin: Instant,
    /// Called with every solution on the way.
    pub reached: &'a mut dyn FnMut(&Solution) -> Result<()>,
    /// How long the read-out of such a solution takes; asked where that decides whether to go on.
    pub readout: &'a mut dyn FnMut(&Solution) -> Result<Duration>,
}

/// Bakes on larger and larger rungs ([`Params::rung`]) until the goal is reached. Whether it was, and what it took,
/// is in [`crate::output::report::Report::target`] of the solution, which is the last whole one: the goal may be missed.
///
/// Time does not count while kernels are compiled. The first rung is always finished, a later one is given up where
/// its time runs out. Errors: those of [`crate::bake()`].
pub fn climb(
    backend: &Backend,
    scene: &Scene,
    params: &Params,
    climb: Climb,
    progress: &mut dyn FnMut(&Event) -> Flow,
) -> Result<Solution> {
    let Climb { goal, checkpoint, solution, begin, reached, readout } = climb;
    let mut clock = Budget { goal, begin, compile: 0.0, readout: 0.0 };
    let compiled = backend.compile_seconds();
    let mut rungs: Vec<RungReport> = Vec::new();
    let known = |p: &Params| (0..=Params::LAST_RUNG).find(|&n| params.rung(n) == *p);
    let mut best = solution;
    let mut rung = match (&best, checkpoint.params().and_then(known)) {
        (_, Some(rung)) => rung,
        (Some(solution), None) => known(solution.params()).map_or(0, |n| n + 1),
        (None, None) => 0,
    };
    let known = best.as_ref().and_then(|s| s.report().estimated_error.as_ref());
    if known.zip(goal.error).is_some_and(|(estimate, error)| met(estimate, error)) {
        // There is nothing left to do.
        rung = Params::LAST_RUNG + 1;
    }
    let mut missed = None;
    let prepared = if rung <= Params::LAST_RUNG { Some(Prepared::new(scene, params, progress)?) } else { None };
    while let Some(prepared) = prepared.as_ref().filter(|_| rung <= Params::LAST_RUNG) {
        let (start, before) = (Instant::now(), clock.compile);
        let limit = best.as_ref().and_then(|_| clock.end());
        let mut late = false;
        let baked = bake_prepared(backend, prepared, &params.rung(rung), checkpoint, &mut |event| {
            late |= limit.is_some_and(|limit| Instant::now() > limit);
            if late { Flow::Stop } else { progress(event) }
        });
        let solution = match baked {
            Err(Error::Cancelled) if late => break,
            baked => baked?,
        };
        clock.compile = backend.compile_seconds() - compiled;
        let estimate = solution.report().estimated_error.clone().unwrap_or_default();
        rungs.push(RungReport {
            rays: solution.report().params.rays,
            seconds: start.elapsed().as_secs_f64() - (clock.compile - before),
            rrmse: estimate.rrmse,
            low: estimate.low,
            high: estimate.high,
            parts: estimate.parts.clone(),
        });
        reached(&solution)?;
        *checkpoint = checkpoint.next(&params.rung(rung), &params.rung(rung + 1));
        let solution = best.insert(solution);
        if goal.error.is_none() && goal.budget.is_none() || goal.error.is_some_and(|error| met(&estimate, error)) {
            break;
        }
        missed = goal.error.and_then(|error| unreachable(&rungs, error));
        clock.readout = 0.0;
        if missed.is_some() || clock.next(rung, &rungs).is_none() {
            break;
        }
        if goal.budget.is_some() {
            clock.readout = readout(solution)?.as_secs_f64();
            clock.compile = backend.compile_seconds() - compiled;
        }
        rung = match clock.next(rung, &rungs) {
            Some(next) => next,
            None => break,
        };
    }
    let mut best = best.ok_or(Error::Cancelled)?;
    let report = best.report_mut();
    let estimate = report.estimated_error.clone().unwrap_or_default();
    let met = goal.error.map(|error| met(&estimate, error));
    let missed = (met == Some(false)).then(|| missed.unwrap_or_else(|| words(&estimate, &goal, &rungs)));
    report.target = Some(TargetReport { error: goal.error, seconds: goal.budget.map(|b| b.as_secs_f64()), met, missed, rungs });
    Ok(best)
}

/// Whether an estimate is within a target.
fn met(estimate: &EstimatedError, error: f64) -> bool {
    estimate.high <= error && median_region(&estimate.regions) <= 2.0 * error
}

/// The time that is left.
struct Budget {
    goal: Goal,
    begin: Instant,
    /// Seconds that do not count.
    compile: f64,
    /// Seconds that the read-out will take.
    readout: f64,
}

impl Budget {
    /// Seconds until a bake must be done; infinite without a budget.
    fn left(&self) -> f64 {
        let budget = self.goal.budget.map_or(f64::INFINITY, |b| b.as_secs_f64());
        budget + self.compile - self.readout - self.begin.elapsed().as_secs_f64()
    }

    /// When a rung has to be given up.
    fn end(&self) -> Option<Instant> {
        let budget = self.goal.budget?.as_secs_f64();
        let grace = (GRACE.0 * budget).max(GRACE.1);
        Instant::now().checked_add(Duration::try_from_secs_f64(self.left() + 0.5 * grace).unwrap_or_default())
    }

    /// The rung to go on with; none where no larger one can be done in time. Towards an error every rung is tried,
    /// so that a climb which was stopped ends where a straight one does; within a time alone the largest that fits.
    fn next(&self, rung: u32, rungs: &[RungReport]) -> Option<u32> {
        let seconds = |n: u32| predicted(rungs, f64::from(1u32 << (n - rung)));
        let fits = |n: &u32| seconds(*n) <= self.left();
        let mut larger = rung + 1..=Params::LAST_RUNG;
        match self.goal.error {
            Some(_) => larger.next().filter(fits),
            None => larger.rev().find(fits),
        }
    }
}

/// Seconds of a rung with `times` the rays of the last: a part that grows with them, and one that does not, where two
/// rungs tell them apart.
fn predicted(rungs: &[RungReport], times: f64) -> f64 {
    let last = &rungs[rungs.len() - 1];
    let rays = f64::from(last.rays);
    let growing = match rungs.len() {
        0 | 1 => last.seconds * rays / (rays + SETTLED),
        n => {
            let before = &rungs[n - 2];
            let ratio = f64::from(before.rays) / f64::from(last.rays);
            ((last.seconds - before.seconds) / (1.0 - ratio)).clamp(0.3 * last.seconds, last.seconds)
        }
    };
    last.seconds - growing + growing * times
}

/// The exponent by which the error falls with the rays, over the last rungs.
fn exponent(rungs: &[RungReport]) -> Option<f64> {
    let (last, first) = (rungs.last()?, rungs.iter().rev().nth(2)?);
    let fall = (first.rrmse / last.rrmse.max(f64::MIN_POSITIVE)).ln();
    Some(fall / (f64::from(last.rays) / f64::from(first.rays)).ln())
}

/// Why a target cannot be met by going on, once that can be told.
fn unreachable(rungs: &[RungReport], error: f64) -> Option<String> {
    let last = rungs.last()?;
    if last.rays < Params::rays_of(BELIEVED) {
        return None;
    }
    let (p, worst) = (exponent(rungs)?, largest(&last.parts));
    if last.rays >= Params::rays_of(Params::LAST_RUNG) {
        return Some(format!("that was the last rung, {} rays; the largest part of the error: {worst}", last.rays));
    }
    let rays = if p > 0.0 { f64::from(last.rays) * (last.high / error).powf(1.0 / p) } else { f64::INFINITY };
    if p < FLAT {
        return Some(format!("more rays do not help any more (the error falls as rays^-{:.2}); what stays: {worst}", p.max(0.0)));
    }
    (rays > 4.0 * f64::from(Params::rays_of(Params::LAST_RUNG))).then(|| {
        format!(
            "it would take about {rays:.1e} rays, and {} is the most; what falls slowest: {worst}",
            Params::rays_of(Params::LAST_RUNG)
        )
    })
}

/// What stood in the way of a target.
fn words(estimate: &EstimatedError, goal: &Goal, rungs: &[RungReport]) -> String {
    let region = 100.0 * median_region(&estimate.regions);
    let high = 100.0 * estimate.high;
    let mut text = match goal.budget {
        Some(budget) => format!("{:.1} s were not enough: ", budget.as_secs_f64()),
        None => String::new(),
    };
    text += &format!(
        "the error may be {high:.2} %, and that of the median region {region:.2} %; the largest part: {}",
        largest(&estimate.parts)
    );
    if let (Some(p), Some(last), Some(error)) = (exponent(rungs).filter(|&p| p >= FLAT), rungs.last(), goal.error) {
        let times = (estimate.high / error).max(median_region(&estimate.regions) / (2.0 * error)).powf(1.0 / p);
        text += &format!("; it would take about {:.0} s", predicted(rungs, times.max(2.0)).max(last.seconds));
    }
    text
}

/// The largest part of an error, in words.
fn largest(parts: &ErrorParts) -> String {
    let named = [
        ("the scatter of rays", parts.rays),
        ("cells", parts.cells),
        ("light between nodes", parts.nodes),
        ("the scatter of direct light", parts.direct),
        ("the scatter of final gathers", parts.gather),
        ("what many reflections make of an error", parts.carried),
        ("the solver", parts.solver),
        ("reflections that were not asked for", parts.truncation),
    ];
    let largest = named.into_iter().filter_map(|(name, part)| Some((name, part?))).max_by(|a, b| a.1.total_cmp(&b.1));
    largest.map_or("none".into(), |(name, part)| format!("{name}, {:.2} %", 100.0 * part))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rung(rays: u32, seconds: f64, rrmse: f64) -> RungReport {
        RungReport { rays, seconds, rrmse, low: rrmse / 1.5, high: 1.5 * rrmse, parts: ErrorParts::default() }
    }

    #[test]
    fn time_grows_with_rays_beside_what_is_always_there() {
        // Of one rung alone 8,192 rays are what does not grow: 1.5 s for 16,384 rays count.
        assert_eq!(predicted(&[rung(1 << 14, 1.5, 0.1)], 4.0), 4.5);
        // 1 s, and 1 s for every 2^14 rays.
        let two = [rung(1 << 14, 2.0, 0.1), rung(1 << 15, 3.0, 0.08)];
        assert!((predicted(&two, 2.0) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_flat_error_is_not_climbed_for_ever() {
        let flat: Vec<RungReport> = (5..8).map(|n| rung(Params::rays_of(n), 1.0, 0.05)).collect();
        assert!(unreachable(&flat, 0.01).unwrap().contains("do not help"), "{flat:?}");
        let falling: Vec<RungReport> = (5..8).map(|n| rung(Params::rays_of(n), 1.0, 0.05 * 0.8f64.powi(n as i32))).collect();
        assert_eq!(unreachable(&falling, 0.01), None);
        assert!(unreachable(&falling, 1e-5).unwrap().contains("it would take"));
    }

    #[test]
    fn the_largest_rung_in_time_is_taken() {
        let goal = Goal { error: None, budget: Some(Duration::from_secs(100)) };
        let budget = Budget { goal, begin: Instant::now(), compile: 0.0, readout: 10.0 };
        // 2/3 s and 1/3, 2/3, 4/3, ... s for the rungs after one of 1 s; 86 s fit in 90, 171 do not.
        assert_eq!(budget.next(0, &[rung(4096, 1.0, 0.1)]), Some(8));
        let both = Budget { goal: Goal { error: Some(0.01), ..goal }, ..budget };
        assert_eq!(both.next(0, &[rung(4096, 1.0, 0.1)]), Some(1));
    }
}
