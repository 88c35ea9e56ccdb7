//! The read-out: radiosity at any surface points from a solved network (design §1, step 8). Like
//! [`mod@crate::bake`], this file knows an order of passes, and nothing of how they run.

use crate::effects::{Name, Spent};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, Point, Psi, kind};
use crate::params::{Direct, Params};
use crate::progress::{Event, Progress};
use crate::stream::{Stream, stream};
use crate::twin::direct::{DirectRays, Samples};
use crate::twin::gather::Gathered;
use crate::twin::math::seed_of;
use std::time::Instant;

/// Points in flight.
const CHUNK: usize = 32_768;
/// Most gather rays in flight.
const HITS: usize = 262_144;
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
const BRIGHT: f64 = 3.0;
/// How many times as many rounds such a point may have.
const MORE: u32 = 8;
/// Most rays of direct light between two moments at which the caller may stop.
const DIRECT_RAYS: u32 = 1 << 21;
/// Samples of direct light at a gather ray's hit.
const HIT: Samples = Samples { emitter: 2, cosine: 1 };
/// Hits nearer than this many node spacings ask for light by a ray of their own.
const CLOSE: f64 = 0.5;
/// Bounces in a slot before the nodes' light is taken all the same.
pub(crate) const BOUNCES: u32 = 8;
/// Rays that tell how near a point's surroundings are.
const NEAR_PROBES: u32 = 8;
/// Rays that tell whether a dark point is covered.
const DEAD_PROBES: u32 = 32;

/// Light at a point, scaled W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Shade {
    /// Direct irradiance D.
    pub direct: [f64; 3],
    /// All irradiance.
    pub irradiance: [f64; 3],
    /// Covered: no front face in sight, nor any emitter.
    pub covered: bool,
}

/// What the read-out knows of a solution as a whole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Whole {
    /// Node spacing, local.
    pub spacing: f64,
    /// The surface's mean irradiance, scaled W/m², or a bound of it; infinite where that is not known.
    pub usual: f64,
}

/// Shades points with the surface and the light that are set on the engine.
pub(crate) fn shade<E: Engine>(
    engine: &mut E,
    params: &Params,
    whole: Whole,
    points: &[Point],
    progress: &mut Progress,
) -> Result<Vec<Shade>> {
    // Those of a tile together: neighbouring invocations then walk the same part of the hierarchy.
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by_key(|&i| points[i as usize].tile);
    let mut out = vec![Shade::default(); points.len()];
    for (i, places) in order.chunks(CHUNK).enumerate() {
        let chunk: Vec<Point> = places.iter().map(|&i| points[i as usize]).collect();
        let shades = shade_chunk(engine, params, whole, &chunk, seed_of(params.seed, i as u32), progress)?;
        for (&i, shade) in places.iter().zip(shades) {
            out[i as usize] = shade;
        }
        progress.event(Event::Points { done: (i * CHUNK + places.len()) as u64, total: points.len() as u64 })?;
    }
    Ok(out)
}

fn shade_chunk<E: Engine>(
    engine: &mut E,
    params: &Params,
    whole: Whole,
    points: &[Point],
    seed: u32,
    progress: &mut Progress,
) -> Result<Vec<Shade>> {
    let (exact, spacing) = (params.direct == Direct::Exact, whole.spacing);
    let mut watch = Watch::start(engine);
    let mut batch = engine.upload(points)?;

    // The network's light.
    engine.assign(&mut batch)?;
    engine.readout(&mut batch)?;
    let network = engine.irradiance(&batch)?;
    let psi = engine.psi(&batch)?;
    watch.of_network(engine, progress)?;

    // Exact direct light, as many rounds as its scatter asks for.
    let direct = if exact {
        let all: Vec<u32> = (0..points.len() as u32).collect();
        sample_direct(engine, params, whole.usual, &mut batch, &all, &network, stream(seed, Stream::PointDirect), progress)?
    } else {
        vec![DirectSum::default(); points.len()]
    };
    watch.of_direct(engine, progress)?;

    // Look around: who sits in a slot?
    let gathers = gathers(params);
    let all: Vec<u32> = (0..points.len() as u32).collect();
    let probe_seed = stream(seed, Stream::PointProbe);
    let near = if gathers { probe(engine, points, &all, probe_seed, NEAR_PROBES, progress)? } else { Vec::new() };
    // And who is covered? Only where no emitter is seen.
    let direct: Vec<[f64; 3]> = direct.iter().map(|d| d.mean().map(f64::from)).collect();
    let dark: Vec<u32> = all.into_iter().filter(|&i| direct[i as usize] == [0.0; 3]).collect();
    let mut covered = vec![false; points.len()];
    for (&i, seen) in dark.iter().zip(probe(engine, points, &dark, seed_of(probe_seed, DEAD_PROBES), DEAD_PROBES, progress)?) {
        covered[i as usize] = seen.is_dead();
    }
    let mut wanted = Vec::new();
    let mut shades: Vec<Shade> = Vec::new();
    for i in 0..points.len() {
        let irradiance = [0, 1, 2].map(|k| if covered[i] { 0.0 } else { direct[i][k] + network[i][k] as f64 });
        // All dark, and not covered: planes through the nodes around may have gone below 0 there.
        let lost = direct[i] == [0.0; 3] && network[i][..3] == [0.0; 3];
        if gathers && !covered[i] && (lost || wants_gather(params, spacing, near[i].nearness, &psi[i])) {
            wanted.push(i);
        }
        shades.push(Shade { direct: direct[i], irradiance, covered: covered[i] });
    }

    watch.of_network(engine, progress)?;

    // Final gather where the network is not fine enough.
    let rays = params.gather_rays;
    let step = (HITS / rays.max(1) as usize).max(1);
    for (c, chunk) in wanted.chunks(step).enumerate() {
        let own: Vec<Point> = chunk.iter().map(|&i| points[i]).collect();
        let mut from = engine.upload(&own)?;
        let mut hits = engine.shoot(&from, seed_of(stream(seed, Stream::PointGather), c as u32), 0, rays)?;
        light_hits(engine, params, spacing, &mut hits, seed_of(stream(seed, Stream::HitDirect), c as u32), BOUNCES, progress)?;
        let gathered = engine.gather(&hits, rays, true, exact)?;
        progress.tick()?;
        // The network carried direct light too; a gathered point takes it exactly.
        let own_direct = if exact {
            None
        } else {
            let all: Vec<u32> = (0..own.len() as u32).collect();
            let light: Vec<[f32; 4]> = chunk.iter().map(|&i| network[i]).collect();
            Some(sample_direct(
                engine,
                params,
                whole.usual,
                &mut from,
                &all,
                &light,
                seed_of(stream(seed, Stream::PointDirect), c as u32),
                progress,
            )?)
        };
        for (k, &i) in chunk.iter().enumerate() {
            let s = &mut shades[i];
            if let Some(own) = &own_direct {
                s.direct = own[k].mean().map(f64::from);
            }
            s.irradiance = [0, 1, 2].map(|b| s.direct[b] + gathered[k].irradiance[b] as f64);
        }
    }
    watch.of_gather(engine, wanted.len() as u64 * u64::from(rays), progress)?;
    Ok(shades)
}

/// Tells what parts of a read-out take. Each part ends with something read back.
struct Watch {
    start: Instant,
    compiled: f64,
    rays: DirectRays,
}

impl Watch {
    fn start<E: Engine>(engine: &E) -> Watch {
        Watch { start: Instant::now(), compiled: engine.compile_seconds(), rays: engine.direct_rays() }
    }

    /// Seconds and rays of the part that ends here.
    fn lap<E: Engine>(&mut self, engine: &E) -> (f64, DirectRays) {
        let now = Watch::start(engine);
        let seconds = (now.start - self.start).as_secs_f64() - (now.compiled - self.compiled);
        let rays = now.rays.since(&self.rays);
        *self = now;
        (seconds.max(0.0), rays)
    }

    fn tell(spent: &Spent, progress: &mut Progress) -> Result<()> {
        spent.parts().try_for_each(|(effect, seconds)| progress.event(Event::Spent { effect, seconds }))
    }

    /// The network's light, and whether it will do.
    fn of_network<E: Engine>(&mut self, engine: &E, progress: &mut Progress) -> Result<()> {
        let mut spent = Spent::default();
        spent.add(Name::Interreflection, self.lap(engine).0);
        Watch::tell(&spent, progress)
    }

    fn of_direct<E: Engine>(&mut self, engine: &E, progress: &mut Progress) -> Result<()> {
        let (mut spent, (seconds, rays)) = (Spent::default(), self.lap(engine));
        spent.add_direct(seconds, &rays);
        Watch::tell(&spent, progress)
    }

    fn of_gather<E: Engine>(&mut self, engine: &E, shot: u64, progress: &mut Progress) -> Result<()> {
        let (mut spent, (seconds, rays)) = (Spent::default(), self.lap(engine));
        spent.add_gather(seconds, shot, &rays);
        Watch::tell(&spent, progress)
    }
}

/// Finds the light at the hits of gather rays: the nodes', and direct light where that is exact.
///
/// A hit much nearer than nodes lie apart is in a slot, or beside a contact, of which no node speaks: its light is what
/// one ray of its own brings, and so on for `bounces` until the light is met outside.
pub(crate) fn light_hits<E: Engine>(
    engine: &mut E,
    params: &Params,
    spacing: f64,
    hits: &mut E::Batch,
    seed: u32,
    bounces: u32,
    progress: &mut Progress,
) -> Result<()> {
    let exact = params.direct == Direct::Exact;
    engine.assign(hits)?;
    engine.readout(hits)?;
    engine.finish()?;
    progress.tick()?;
    if exact {
        engine.direct(hits, None, seed, 0, 1, HIT)?;
    }
    if bounces == 0 {
        return Ok(());
    }
    let points = engine.points(hits)?;
    let near = |p: &Point| p.kind == kind::FRONT && f64::from(p.weight) < CLOSE * spacing;
    let close: Vec<usize> = (0..points.len()).filter(|&i| near(&points[i])).collect();
    if close.is_empty() {
        return Ok(());
    }
    let own: Vec<Point> = close.iter().map(|&i| points[i]).collect();
    let mut from = engine.upload(&own)?;
    let mut next = engine.shoot(&from, stream(seed, Stream::PointGather), 0, 1)?;
    light_hits(engine, params, spacing, &mut next, stream(seed, Stream::HitDirect), bounces - 1, progress)?;
    let brought = engine.gather(&next, 1, true, exact)?;
    let known = match exact {
        true => vec![[0.0; 3]; own.len()],
        false => {
            // The nodes' light would have held it.
            engine.direct(&mut from, None, stream(seed, Stream::PointDirect), 0, 1, HIT)?;
            engine.direct_sums(&from)?.iter().map(DirectSum::mean).collect()
        }
    };
    let mut light = engine.irradiance(hits)?;
    for (k, &i) in close.iter().enumerate() {
        for b in 0..3 {
            light[i][b] = known[k][b] + brought[k].irradiance[b];
        }
    }
    engine.set_irradiance(hits, &light)
}

/// Whether points are gathered for at all: what a gather brings has been reflected once more.
pub(crate) fn gathers(params: &Params) -> bool {
    params.gather_rays > 0 && params.bounces.is_none()
}

/// Whether a point with surroundings so near gets a final gather: nodes are too far apart for it, or none speaks for it.
pub(crate) fn wants_gather(params: &Params, spacing: f64, nearness: f32, psi: &Psi) -> bool {
    nearness as f64 * params.gather_threshold * spacing > 1.0 || psi.is_orphan()
}

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
    (0..3).map(|k| f64::from(sum.mean()[k]) + network[k]).sum::<f64>() / 3.0
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

/// What `rays` cosine rays of each of the listed points meet.
fn probe<E: Engine>(
    engine: &mut E,
    points: &[Point],
    listed: &[u32],
    seed: u32,
    rays: u32,
    progress: &mut Progress,
) -> Result<Vec<Gathered>> {
    let mut met = Vec::with_capacity(listed.len());
    for (c, chunk) in listed.chunks(HITS / rays as usize).enumerate() {
        let from = engine.upload(&chunk.iter().map(|&i| points[i as usize]).collect::<Vec<_>>())?;
        let hits = engine.shoot(&from, seed_of(seed, c as u32), 0, rays)?;
        met.extend(engine.gather(&hits, rays, false, false)?);
        progress.tick()?;
    }
    Ok(met)
}

/// Samples direct light until its standard error is small against all light at the point.
fn sample_direct<E: Engine>(
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
