//! The read-out: radiosity at any surface points from a solved network (design §1, step 8). Like
//! [`mod@crate::bake`], this file knows an order of passes, and nothing of how they run.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, Point, Psi, kind};
use crate::params::{Direct, Params};
use crate::progress::{Event, Progress};
use crate::stream::{Stream, stream};
use crate::twin::direct::Samples;
use crate::twin::math::seed_of;

/// Points in flight.
const CHUNK: usize = 32_768;
/// Most gather rays in flight.
const HITS: usize = 262_144;
/// Samples of a round of direct light at a shown point.
const ROUND: Samples = Samples { emitter: 24, cosine: 8 };
/// Rounds before the error of direct light is looked at.
const FIRST_ROUNDS: u32 = 8;
/// Most rays of direct light between two moments at which the caller may stop.
const DIRECT_RAYS: u32 = 1 << 21;
/// Samples of direct light at a gather ray's hit.
const HIT: Samples = Samples { emitter: 2, cosine: 1 };
/// Hits nearer than this many node spacings ask for light by a ray of their own.
const CLOSE: f64 = 0.5;
/// Bounces in a slot before the nodes' light is taken all the same.
pub(crate) const BOUNCES: u32 = 6;
/// Rays that tell how near a point's surroundings are, and whether it is covered.
const PROBES: u32 = 32;

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

/// Shades points with the surface and the light that are set on the engine. `spacing` is the node
/// spacing, local.
pub(crate) fn shade<E: Engine>(
    engine: &mut E,
    params: &Params,
    spacing: f64,
    points: &[Point],
    progress: &mut Progress,
) -> Result<Vec<Shade>> {
    let mut out = Vec::with_capacity(points.len());
    for (i, chunk) in points.chunks(CHUNK).enumerate() {
        out.extend(shade_chunk(engine, params, spacing, chunk, seed_of(params.seed, i as u32), progress)?);
        progress.event(Event::Points { done: out.len() as u64, total: points.len() as u64 })?;
    }
    Ok(out)
}

fn shade_chunk<E: Engine>(
    engine: &mut E,
    params: &Params,
    spacing: f64,
    points: &[Point],
    seed: u32,
    progress: &mut Progress,
) -> Result<Vec<Shade>> {
    let exact = params.direct == Direct::Exact;
    let mut batch = engine.upload(points)?;

    // The network's light.
    engine.assign(&mut batch)?;
    engine.readout(&mut batch)?;
    let network = engine.irradiance(&batch)?;
    let psi = engine.psi(&batch)?;
    progress.tick()?;

    // Exact direct light, as many rounds as its scatter asks for.
    let direct = if exact {
        let all: Vec<u32> = (0..points.len() as u32).collect();
        sample_direct(engine, params, &mut batch, &all, &network, stream(seed, Stream::PointDirect), progress)?
    } else {
        vec![DirectSum::default(); points.len()]
    };

    // Look around: who is covered, who sits in a slot?
    let mut near = Vec::new();
    let mut shades: Vec<Shade> = Vec::new();
    let probe_seed = stream(seed, Stream::PointProbe);
    let step = HITS / PROBES as usize;
    for (c, chunk) in points.chunks(step).enumerate() {
        let from = engine.upload(chunk)?;
        let hits = engine.shoot(&from, seed_of(probe_seed, c as u32), 0, PROBES)?;
        near.extend(engine.gather(&hits, PROBES, false, false)?);
        progress.tick()?;
    }
    let mut wanted = Vec::new();
    let gathers = gathers(params);
    for i in 0..points.len() {
        let d = direct[i].mean().map(f64::from);
        let covered = near[i].is_dead() && d == [0.0; 3];
        let irradiance = [0, 1, 2].map(|k| if covered { 0.0 } else { d[k] + network[i][k] as f64 });
        if gathers && !covered && wants_gather(params, spacing, near[i].nearness, &psi[i]) {
            wanted.push(i);
        }
        shades.push(Shade { direct: d, irradiance, covered });
    }

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
    Ok(shades)
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

/// Most rounds of direct light at a point.
fn most_rounds(params: &Params) -> u32 {
    (params.direct_samples / (ROUND.emitter + ROUND.cosine)).max(2)
}

/// Rounds of direct light before its scatter is looked at, and the samples of a round.
pub(crate) fn first_rounds(params: &Params) -> (u32, Samples) {
    (FIRST_ROUNDS.min((most_rounds(params) / 8).max(2)), ROUND)
}

/// The standard error that direct light will be left with at a point, from its first rounds.
pub(crate) fn direct_error(params: &Params, first: &DirectSum, network: &[f64; 3]) -> f64 {
    let light = first.mean().iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0 + network.iter().sum::<f64>() / 3.0;
    let (mut error, goal) = (f64::from(first.standard_error()), params.direct_tolerance * light);
    let mut rounds = first.rounds;
    while error > goal && rounds < most_rounds(params) {
        // As below: what has been shot is doubled.
        rounds *= 2;
        error *= std::f64::consts::FRAC_1_SQRT_2;
    }
    error
}

/// Samples direct light until its standard error is small against all light at the point.
fn sample_direct<E: Engine>(
    engine: &mut E,
    params: &Params,
    batch: &mut E::Batch,
    all: &[u32],
    network: &[[f32; 4]],
    seed: u32,
    progress: &mut Progress,
) -> Result<Vec<DirectSum>> {
    let most = most_rounds(params);
    let mut done = 0;
    let mut rounds = first_rounds(params).0;
    let mut active = all.to_vec();
    loop {
        // Rounds add up in their order, however many are asked for at a time.
        let end = done + rounds;
        let step = (DIRECT_RAYS / (active.len() as u32 * (ROUND.emitter + ROUND.cosine)).max(1)).max(1);
        while done < end {
            let rounds = step.min(end - done);
            engine.direct(batch, Some(&active), seed, done, rounds, ROUND)?;
            engine.finish()?;
            done += rounds;
            progress.tick()?;
        }
        let sums = engine.direct_sums(batch)?;
        if done >= most {
            return Ok(sums);
        }
        active.retain(|&i| {
            let (s, h) = (&sums[i as usize], &network[i as usize]);
            let light = s.mean().iter().sum::<f32>() / 3.0 + (h[0] + h[1] + h[2]) / 3.0;
            s.standard_error() > params.direct_tolerance as f32 * light
        });
        if active.is_empty() {
            return Ok(sums);
        }
        // Double what has been shot.
        rounds = done.min(most - done);
    }
}
