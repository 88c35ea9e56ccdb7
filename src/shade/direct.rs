//! Direct light at shown points, sampled until its scatter is small.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::DirectSum;
use crate::network::tiles::mean;
use crate::params::Params;
use crate::progress::Progress;
use crate::twin::direct::Samples;

/// Samples of a round of direct light at a shown point. The split into rounds tells the scatter; it changes no estimate.
const ROUND: Samples = Samples { emitter: 24, cosine: 8 };
/// The same where few samples are allowed.
const SMALL_ROUND: Samples = Samples { emitter: 6, cosine: 2 };
/// The same where there are mirrors: light over them comes from cosine directions alone. A round is short, as its ways may be
/// long.
const MIRROR_ROUND: Samples = Samples { emitter: 4, cosine: 12 };
/// Samples below which rounds are small.
const FEW_SAMPLES: u32 = 1_024;
/// Rounds before the error of direct light is looked at.
const FIRST_ROUNDS: u32 = 8;
/// Of all rounds the share that comes before that look where there are mirrors: a lamp that is seen in one only is found by
/// few directions, and what none has found does not scatter.
const FIRST_OVER_MIRRORS: u32 = 4;
/// Samples that have to miss every emitter before a point is taken to see none.
const DARK_SAMPLES: u32 = 256;
/// Light beyond which a point's direct light is found as well as that of a point with so many times the usual light: a patch
/// close by a lamp may be hundreds of times as bright, and as many times as far off, and what is said of the scene's error is then its.
pub(super) const BRIGHT: f64 = 3.0;
/// How many times as many rounds such a point may have.
const MORE: u32 = 8;
/// Most rays of direct light between two moments at which the caller may stop.
const DIRECT_RAYS: u32 = 1 << 21;

/// The samples of a round of direct light at a point, and the most rounds.
fn rounds(params: &Params, mirrors: bool) -> (Samples, u32) {
    let round = if mirrors {
        MIRROR_ROUND
    } else if params.direct_samples < FEW_SAMPLES {
        SMALL_ROUND
    } else {
        ROUND
    };
    (round, (params.direct_samples / (round.emitter + round.cosine)).max(2))
}

/// The samples of a round of direct light, and the rounds before its scatter is looked at.
pub(crate) fn first_rounds(params: &Params, mirrors: bool) -> (Samples, u32) {
    let (round, most) = rounds(params, mirrors);
    (round, if mirrors { (most / FIRST_OVER_MIRRORS).max(2) } else { FIRST_ROUNDS.min((most / 8).max(2)) })
}

/// The standard error that is asked of direct light at a point with so much light, and of the rounds that are allowed how many.
fn goal(params: &Params, usual: f64, light: f64, most: u32) -> (f64, u32) {
    let bright = BRIGHT * usual;
    if light <= bright {
        return (params.direct_tolerance * light, most);
    }
    (params.direct_tolerance * bright, (f64::from(most) * (light / bright).min(f64::from(MORE))) as u32)
}

/// Direct light so far and the network's, mean over the bands.
fn light_of(sum: &DirectSum, network: [f64; 3]) -> f64 {
    mean(&[0, 1, 2].map(|k| f64::from(sum.mean()[k]) + network[k]))
}

/// The standard error that direct light will be left with at a point, from its first rounds.
pub(crate) fn direct_error(params: &Params, usual: f64, mirrors: bool, first: &DirectSum, network: &[f64; 3]) -> f64 {
    let (goal, most) = goal(params, usual, light_of(first, *network), rounds(params, mirrors).1);
    let (mut error, mut rounds) = (f64::from(first.standard_error()), first.rounds);
    while error > goal && rounds < most {
        // As below: what has been shot is doubled.
        rounds *= 2;
        error *= std::f64::consts::FRAC_1_SQRT_2;
    }
    error
}

/// Samples direct light until its standard error is small against all light at the point.
pub(super) fn sample_direct<E: Engine>(
    engine: &mut E,
    params: &Params,
    usual: f64,
    batch: &mut E::Batch,
    all: &[u32],
    network: &[[f32; 4]],
    seed: u32,
    progress: &mut Progress,
) -> Result<Vec<DirectSum>> {
    let mirrors = engine.has_mirrors();
    let (round, most) = rounds(params, mirrors);
    let rays = round.emitter + round.cosine;
    let mut done = 0;
    let mut rounds = first_rounds(params, mirrors).1;
    let mut active = all.to_vec();
    loop {
        // Rounds add up in their order, however many are asked for at a time.
        let end = done + rounds;
        let step = (DIRECT_RAYS / (active.len() as u32 * rays).max(1)).max(1);
        while done < end {
            let rounds = step.min(end - done);
            engine.direct(batch, Some(&active), seed, done, rounds, round)?;
            engine.finish()?;
            done += rounds;
            progress.tick()?;
        }
        let sums = engine.direct_sums(batch)?;
        let mut longest = 0;
        active.retain(|&i| {
            let (s, h) = (&sums[i as usize], network[i as usize]);
            let (goal, most) = goal(params, usual, light_of(s, [0, 1, 2].map(|k| f64::from(h[k]))), most);
            // Where all samples missed they do not scatter, and a small lamp close by is missed by a few.
            let unsure = s.sum == [0.0; 3] && done * rays < DARK_SAMPLES;
            let goes_on = done < most && (unsure || f64::from(s.standard_error()) > goal);
            longest = longest.max(if goes_on { most } else { 0 });
            goes_on
        });
        if active.is_empty() {
            return Ok(sums);
        }
        // Double what has been shot.
        rounds = done.min(longest - done);
    }
}
