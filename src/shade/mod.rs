//! The read-out: radiosity at any surface points from a solved network (design §1, step 8). Like
//! [`mod@crate::bake`], this file knows an order of passes, and nothing of how they run.

mod direct;
mod gather;

pub(crate) use direct::{direct_error, first_rounds};
pub(crate) use gather::{BOUNCES, Brought, gather_variance, gathers, look, wants_gather};

use crate::effects::{Name, Spent};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, Point};
use crate::params::{Direct, Params};
use crate::progress::{Event, Progress};
use crate::stream::{Stream, stream};
use crate::twin::direct::DirectRays;
use crate::twin::gather::Gathered;
use crate::twin::math::seed_of;
use direct::sample_direct;
use gather::{HITS, gather};
use std::time::Instant;

/// Points in flight.
const CHUNK: usize = 32_768;
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
    let exact = params.direct == Direct::Exact;
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
        let wants = || wants_gather(params, whole.spacing, near[i].nearness, &psi[i], &network[i], &direct[i]);
        if gathers && !covered[i] && (lost || wants()) {
            wanted.push(i);
        }
        shades.push(Shade { direct: direct[i], irradiance, covered: covered[i] });
    }

    watch.of_network(engine, progress)?;

    // Final gather where the network is not fine enough.
    let own: Vec<Point> = wanted.iter().map(|&i| points[i]).collect();
    if !exact && !own.is_empty() {
        // The network carried direct light too; a gathered point takes it exactly.
        let all: Vec<u32> = (0..own.len() as u32).collect();
        let light: Vec<[f32; 4]> = wanted.iter().map(|&i| network[i]).collect();
        let mut from = engine.upload(&own)?;
        let seed = stream(seed, Stream::PointDirect);
        let found = sample_direct(engine, params, whole.usual, &mut from, &all, &light, seed, progress)?;
        wanted.iter().zip(found).for_each(|(&i, d)| shades[i].direct = d.mean().map(f64::from));
    }
    let straight: Vec<[f64; 3]> = wanted.iter().map(|&i| shades[i].direct).collect();
    let (brought, shot) = gather(engine, params, whole, &own, &straight, seed, progress)?;
    for (&i, brought) in wanted.iter().zip(brought) {
        let s = &mut shades[i];
        s.irradiance = [0, 1, 2].map(|k| s.direct[k] + brought[k]);
    }
    watch.of_gather(engine, shot, progress)?;
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
