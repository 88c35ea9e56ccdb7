//! Flux mode: the network learns the light flow itself (design §1).
//!
//! 1. Table direct light on tiles; start rays where it has to be carried on.
//! 2. Pilot network: a coarse solution that says where light goes.
//! 3. Full network: rays by importance, nodes where light changes quickly, cells grown on the rays.
//! 4. Read the cells as coefficients, solve, account for every watt.

use super::Clock;
use crate::accuracy::estimate;
use crate::checkpoint::{Checkpoint, Pilot, once};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, Node, NodeSource, Tile};
use crate::network::candidates;
use crate::network::growth::Growth;
use crate::network::nodes;
use crate::network::tiles::{self, Looks, mean};
use crate::params::{Cells, Direct, Params};
use crate::progress::{Event, Progress};
use crate::radiosity::components::{Components, Peaks, Splitter};
use crate::radiosity::winding::Winding;
use crate::radiosity::{coefficients, energy, solver};
use crate::scene::{Geometry, Scene};
use crate::stream::{Stream, stream};
use crate::twin::assign::Surface;
use crate::twin::direct::Samples;
use crate::twin::math::seed_of;
use crate::twin::winner::Metric;

/// Rays of the pilot network.
const PILOT_RAYS: u32 = 65_536;
/// Cells of the pilot network.
const PILOT_CELLS: u32 = 512;
/// Nodes of the pilot network; of one of few rays half as many.
const PILOT_NODES: usize = 400;
/// The same in flatland.
const PILOT_FLAT_NODES: usize = 100;
/// What few rays are.
const FEW_RAYS: u32 = 16_384;
/// Tiles that are looked at before any light is known, for each ray of a small pilot.
const LOOKS: u32 = 4;
/// Most rays in a batch.
pub const BATCH: u32 = 65_536;
/// Features that cells start from.
const FIRST_FEATURES: usize = 4_096;

/// What a network is trained on.
pub(super) struct Stage {
    rays: u32,
    cells: u32,
    nodes: usize,
    tiles: Vec<Tile>,
    /// What each tile sends.
    pub brightness: Vec<f64>,
    density: Vec<f64>,
    refinements: u32,
    seeds: [u32; 3],
    /// The network that counts: its stages are told, and its points are many.
    told: bool,
}

/// Nodes, and rays with what is known at their ends.
pub(super) struct Traced<B> {
    pub surface: Surface,
    pub batches: Vec<B>,
    /// Points of each batch.
    pub lengths: Vec<usize>,
}

/// The order of the passes, on any engine. Fills the checkpoint.
pub fn run<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<()> {
    if params.direct == Direct::Exact && !geometry.reflects() {
        // All light is direct, and the read-out finds it: there is nothing to train on.
        return account(engine, geometry, params, &mut [], saved, clock, progress);
    }
    let stage = full(engine, scene, geometry, params, saved, clock, progress)?;
    let mut batches = network(engine, scene, geometry, params, &stage, saved, clock, progress)?;
    account(engine, geometry, params, &mut batches, saved, clock, progress)
}

/// What the full network is trained on: asks the pilot.
pub(super) fn full<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<Stage> {
    let exact = params.direct == Direct::Exact;
    let count = params.node_count(geometry.pieces, geometry.flatland);
    if saved.pilot.is_none() {
        progress.event(Event::Stage { name: "pilot" })?;
        saved.pilot = Some(pilot(engine, scene, geometry, params, saved, clock, progress)?);
        // Its rays have told what they had to tell.
        (saved.tiles, saved.network) = Default::default();
        saved.keep(progress)?;
    }
    let Pilot { carried, density, .. } = saved.pilot.clone().unwrap_or_default();

    // Shared out by less than its light, a dark part still gets rays enough to be read.
    let gamma = if exact { params.gamma } else { 1.0 };
    let wanted: Vec<f64> = carried.iter().map(|c| c.powf(gamma)).collect();
    Ok(Stage {
        rays: params.rays,
        cells: params.cells(),
        nodes: count,
        tiles: tiles::starts(geometry, &wanted, params.alpha),
        brightness: carried,
        density,
        refinements: params.refinements,
        told: true,
        seeds: [Stream::Nodes, Stream::Rays, Stream::Ends].map(|s| stream(params.seed, s)),
    })
}

/// Where did every watt go?
pub(super) fn account<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    batches: &mut [E::Batch],
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<()> {
    let seed = stream(params.seed, Stream::Emission);
    let light = &saved.network.light;
    let energy =
        clock.time(engine, "energy", |engine| energy::account(engine, geometry, seed, params, light, batches, progress))?;
    saved.energy = Some(energy);
    saved.network.direct = Vec::new();
    clock.compile = Some(engine.compile_seconds());
    clock.device_bytes = Some(engine.device_bytes());
    clock.direct_rays = Some(engine.direct_rays());
    clock.band_bytes = Some(engine.band_bytes());
    saved.keep(progress)
}

/// The pilot network: where does light go?
fn pilot<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<Pilot> {
    // Table what each tile sends before any bounce: E, or rho D where direct light is exact.
    // Few rays need no fine importance: what a whole neighbourhood of small tiles sends is looked up once.
    let rays = pilot_rays(params.rays);
    let few = rays < PILOT_RAYS;
    let looks = looks(geometry, rays);
    let places = tiles::places_of(geometry, &looks.tiles, stream(params.seed, Stream::TilePlace));
    let seed = stream(params.seed, Stream::TileDirect);
    let direct = once(&mut saved.tiles, || {
        let rounds = if few { 1 } else { 2 };
        clock.time(engine, "direct", |engine| tiles::direct(engine, &places, seed, rounds, progress))
    })?;
    let exact = params.direct == Direct::Exact;
    let sent: Vec<[f64; 3]> = (0..geometry.tiles as usize)
        .map(|t| {
            let m = geometry.material_of(geometry.tile_tri[t] as usize);
            let m = if geometry.textured { geometry.material_at(&places[looks.of[t] as usize]) } else { *m };
            let d = direct[looks.of[t] as usize].mean();
            [0, 1, 2].map(|k| if exact { (m.rho[k] * d[k]) as f64 } else { m.emit[k] as f64 })
        })
        .collect();
    saved.keep(progress)?;

    let first: Vec<f64> = sent.iter().map(mean).collect();
    let nodes = if geometry.flatland { PILOT_FLAT_NODES } else { PILOT_NODES };
    let stage = Stage {
        rays,
        cells: PILOT_CELLS,
        nodes: if rays < FEW_RAYS { nodes / 2 } else { nodes },
        tiles: tiles::starts(geometry, &first, params.alpha),
        brightness: first,
        density: vec![1.0; geometry.tiles as usize],
        refinements: 0,
        told: false,
        seeds: [Stream::PilotNodes, Stream::PilotRays, Stream::PilotEnds].map(|s| stream(params.seed, s)),
    };
    let batches = network(engine, scene, geometry, params, &stage, saved, clock, progress)?;

    // What the pilot's rays met from behind is wound the wrong way round.
    let winding = Winding::count(scene, geometry, &engine.points(&batches[0])?).warnings(scene);
    for warning in &winding {
        progress.event(Event::Warning(warning.clone()))?;
    }

    // Importance: what each tile sends in the pilot's light.
    let (nodes, light) = (saved.network.nodes.clone().unwrap_or_default(), saved.network.light.clone());
    let carried: Vec<f64> = clock.time(engine, "train", |engine| {
        engine.set_light(&light)?;
        let mut h = Vec::new();
        for chunk in places.chunks(BATCH as usize) {
            let mut batch = engine.upload(chunk)?;
            engine.assign(&mut batch)?;
            engine.readout(&mut batch)?;
            h.extend(engine.irradiance(&batch)?);
        }
        Ok((0..sent.len())
            .map(|t| {
                let rho = if geometry.textured {
                    geometry.material_at(&places[looks.of[t] as usize]).rho
                } else {
                    geometry.material_of(geometry.tile_tri[t] as usize).rho
                };
                mean(&[0, 1, 2].map(|k| sent[t][k] + (rho[k] * h[looks.of[t] as usize][k]) as f64))
            })
            .collect())
    })?;
    progress.tick()?;
    // Of the usual number of nodes, so that bakes of all sizes have the same pilot.
    let usual = Params::default().node_count(geometry.pieces, geometry.flatland);
    let density = clock.time(engine, "train", |engine| tiles::node_density(engine, geometry, &batches, &carried, usual))?;
    Ok(Pilot { nodes, light, carried, density, winding })
}

/// Places the nodes and shoots the rays, as far as they are not in the checkpoint already.
pub(super) fn trace<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    stage: &Stage,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<Traced<E::Batch>> {
    let exact = params.direct == Direct::Exact;
    let [node_seed, ray_seed, end_seed] = stage.seeds;
    if stage.told {
        progress.event(Event::Stage { name: "train" })?;
    }

    // Place the nodes.
    let lambda = params.lambda as f32;
    let mark = stage.told && candidates::worth_marking(geometry, stage.rays);
    let surface = clock.time(engine, "nodes", |engine| match &saved.network.nodes {
        Some(nodes) => {
            // Rays are assigned to all nodes; which of them none has met is found later.
            let all = nodes.iter().map(|n| Node { gain: n.gain.abs(), ..*n }).collect();
            let surface = nodes::surface_of(geometry, all, lambda, mark);
            engine.set_surface(&surface)?;
            Ok(surface)
        }
        None => nodes::place_nodes(engine, geometry, &stage.density, stage.nodes, lambda, node_seed, mark, progress),
    })?;
    saved.network.nodes = Some(surface.nodes.clone());
    saved.keep(progress)?;

    // Shoot all rays, find what both ends see of the emitters and which nodes speak for them. Rays come again
    // from their seeds; what their ends see is kept.
    let area: f64 = (0..geometry.tiles as usize).map(|t| geometry.tile_area(t)).sum();
    let rms =
        ((0..stage.brightness.len()).map(|t| stage.brightness[t].powi(2) * geometry.tile_area(t)).sum::<f64>() / area).sqrt();
    let brightness: Vec<f32> = stage.brightness.iter().map(|b| if rms > 0.0 { (b / rms) as f32 } else { 0.0 }).collect();
    let metric = Metric { inv_unit: (1.0 / geometry.unit) as f32, lambda, mu: params.mu as f32 };
    let (mut batches, mut lengths) = (Vec::new(), Vec::new());
    let batch_rays = if stage.told { batch_rays(stage.rays) } else { BATCH };
    for first in (0..stage.rays).step_by(batch_rays as usize) {
        let count = batch_rays.min(stage.rays - first);
        let mut batch = clock.time(engine, "emit", |engine| engine.emit(&stage.tiles, ray_seed, first, count, stage.rays))?;
        progress.tick()?;
        let net = &mut saved.network;
        net.rays = net.rays.max(first + count);
        if exact {
            let ends = 2 * first as usize..2 * (first + count) as usize;
            clock.time(engine, "direct", |engine| match net.direct.get(ends) {
                Some(known) => engine.set_direct(&mut batch, &known.iter().map(|&d| DirectSum::once(d)).collect::<Vec<_>>()),
                None => {
                    let samples = Samples { emitter: params.end_samples, cosine: 1 };
                    engine.direct(&mut batch, None, seed_of(end_seed, first), 0, 1, samples)?;
                    net.direct.extend(engine.direct_sums(&batch)?.iter().map(|d| d.sum));
                    Ok(())
                }
            })?;
            progress.tick()?;
        }
        clock.time(engine, "assign", |engine| {
            engine.assign(&mut batch)?;
            let (points, mut psi) = (engine.points(&batch)?, engine.psi(&batch)?);
            if nodes::lend(geometry, &points, &mut psi) { engine.set_psi(&mut batch, &psi) } else { Ok(()) }
        })?;
        if net.coefficients.is_none() {
            clock.time(engine, "train", |engine| engine.feature(&mut batch, metric, &brightness))?;
        }
        batches.push(batch);
        lengths.push(2 * count as usize);
        saved.keep(progress)?;
        progress.event(Event::Rays { done: (first + count) as u64, total: stage.rays as u64 })?;
    }
    Ok(Traced { surface, batches, lengths })
}

/// Trains and solves one network, as far as it is not in the checkpoint already. Returns its rays.
fn network<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    stage: &Stage,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<Vec<E::Batch>> {
    let exact = params.direct == Direct::Exact;
    let tell = |progress: &mut Progress, name| if stage.told { progress.event(Event::Stage { name }) } else { Ok(()) };
    let Traced { mut surface, mut batches, lengths } = trace(engine, geometry, params, stage, saved, clock, progress)?;
    let mark = stage.told && candidates::worth_marking(geometry, stage.rays);
    if let Some(built) = &saved.network.coefficients
        && candidates::leave_out_empty(geometry, &mut surface, &built.mass, mark)
    {
        engine.set_surface(&surface)?;
    }

    if saved.network.coefficients.is_none() {
        // Grow the cells.
        let net = &mut saved.network;
        if net.growth.is_none() {
            net.growth = Some(match params.cells_from {
                Cells::Trained => Growth::start(&engine.features(&batches[0], 0..lengths[0].min(FIRST_FEATURES))?),
                Cells::Random => Growth::random(engine, &batches, &lengths, stage.cells as usize, stage.seeds[1])?,
            });
        }
        while let Some(growth) = saved.network.growth.as_mut().filter(|g| !g.done) {
            clock.time(engine, "grow", |engine| growth.epoch(engine, &mut batches, &lengths, stage.cells as usize))?;
            progress.event(Event::Cells { count: growth.cells.len() as u64 })?;
            saved.keep(progress)?;
        }
        let cells = saved.network.growth.as_ref().map_or(Vec::new(), |g| g.cells.clone());

        // Let every ray find its own.
        let mut first = 0;
        for (batch, &points) in batches.iter_mut().zip(&lengths) {
            let winners = &mut saved.network.winners;
            clock.time(engine, "winner", |engine| match winners.get(first..first + points) {
                Some(known) => engine.set_winners(batch, known),
                None => {
                    engine.winner(batch, 0..points, &cells)?;
                    winners.extend(engine.winners(batch)?);
                    Ok(())
                }
            })?;
            first += points;
            saved.keep(progress)?;
        }

        // Rooms that see nothing of each other get cells of their own, and sums of their own unit.
        let (cell_count, materials) = clock.time(engine, "coefficients", |engine| {
            let mut components = Components::new(surface.nodes.len());
            let mut seen = Vec::new();
            let (mut peaks, mut first) = (Peaks::new(surface.nodes.len()), 0);
            for batch in &batches {
                let (points, psi) = (engine.points(batch)?, engine.psi(batch)?);
                components.join(&points, &psi);
                peaks.see(geometry, &points, &psi, saved.network.direct.get(first..first + points.len()).filter(|_| exact));
                first += points.len();
                seen.push((points, psi));
                progress.tick()?;
            }
            let mut splitter = Splitter::new(cells.len());
            for (batch, (points, psi)) in batches.iter_mut().zip(seen) {
                let mut winners = engine.winners(batch)?;
                if splitter.split(&mut components, &points, &psi, &mut winners) {
                    engine.set_winners(batch, &winners)?;
                }
                progress.tick()?;
            }
            peaks.set_gains(geometry, &components.numbers(), &mut surface.nodes);
            Ok((splitter.cells(), peaks.materials(geometry, &surface.nodes)))
        })?;

        // Read the cells as coefficients.
        tell(progress, "coefficients")?;
        let built = clock.time(engine, "coefficients", |engine| {
            let normalise = normalise(geometry, params);
            let sums = engine.coefficients(&batches, exact, normalise, stage.rays as f32, cell_count, &mut || progress.tick())?;
            let (ridge, slots) = (params.ridge, params.slots as usize);
            let mut built = coefficients::build(&sums, &mut surface.nodes, ridge, slots, stage.rays as f64);
            built.system.materials = materials;
            candidates::leave_out_empty(geometry, &mut surface, &built.mass, mark);
            engine.set_surface(&surface)?;
            if exact {
                // The first bounce is known at every ray's end; it needs no cell.
                built.system.source.fill([0.0; 4]);
                let sums = engine.deposit(&batches, exact, false, normalise)?;
                built.system.node_source = coefficients::known(&sums, &surface.nodes, &built.mass);
            }
            Ok(built)
        })?;
        let net = &mut saved.network;
        net.nodes = Some(surface.nodes.clone());
        net.coefficients = Some(built);
        net.winners = Vec::new();
        saved.keep(progress)?;
    }

    // Solve. With exact direct light the nodes' rows begin with the second reflection; a refinement adds one.
    tell(progress, "solve")?;
    let bounces = params.bounces.filter(|_| stage.told).map(|n| n - exact as u32);
    let refinements = if exact { stage.refinements.min(bounces.unwrap_or(u32::MAX)) } else { 0 };
    let by_cells = bounces.map(|n| n - refinements);
    let built = saved.network.coefficients.clone().unwrap_or_default();
    if saved.network.solved.is_none() {
        let (light, solved) = clock
            .time(engine, "solve", |engine| solver::solve(engine, geometry, &built.system, params, by_cells, progress, scene))?;
        (saved.network.light, saved.network.solved) = (light, Some(solved));
        saved.keep(progress)?;
    }

    // Let the rays carry the solution on, each from its own end: what the cells leave out fades with every sweep.
    while saved.network.refined < refinements {
        let net = &mut saved.network;
        let refined = clock.time(engine, "solve", |engine| {
            engine.set_light(&net.light)?;
            for batch in &mut batches {
                engine.readout(batch)?;
                progress.tick()?;
            }
            let (known, planes) =
                (|sums: &[NodeSource]| coefficients::known(sums, &surface.nodes, &built.mass), &built.system.planes);
            // In halves, whose difference tells the noise.
            let (left, right) = batches.split_at(batches.len() / 2);
            let normalise = normalise(geometry, params);
            let mut sums = engine.deposit(left, exact, true, normalise)?;
            let half = known(&sums);
            for (sum, more) in sums.iter_mut().zip(engine.deposit(right, exact, true, normalise)?) {
                sum.add(&more);
            }
            let all = known(&sums);
            let share = left.len() as f64 / batches.len() as f64;
            if !left.is_empty() {
                net.evidence.noise = Some(estimate::noise(geometry, &surface.nodes, &built.mass, &half, &all, share));
            }
            Ok(coefficients::fit(&all, planes))
        })?;
        let change = estimate::change(geometry, &surface.nodes, &built.mass, &net.light, &refined);
        net.evidence.changes = Some([change, net.evidence.changes.map_or(change, |c| c[0])]);
        net.light = refined;
        net.refined += 1;
        saved.keep(progress)?;
    }
    saved.network.surface = Some(surface);
    Ok(batches)
}

/// Rays in a batch of so many: two batches at least, whose difference tells the noise.
pub(crate) fn batch_rays(rays: u32) -> u32 {
    BATCH.min(rays.div_ceil(2))
}

/// Rays of a bake's pilot.
pub(crate) fn pilot_rays(rays: u32) -> u32 {
    PILOT_RAYS.min(rays)
}

/// The tiles that a pilot of so many rays looks at before any light is known.
pub(crate) fn looks(geometry: &Geometry, rays: u32) -> Looks {
    tiles::looks(geometry, if rays < PILOT_RAYS { LOOKS * rays } else { geometry.tiles })
}

/// What brings the weight of all rays together to 1 at most: they weigh 2 A / (1 - alpha).
pub(super) fn normalise(geometry: &Geometry, params: &Params) -> f32 {
    ((1.0 - params.alpha) / (2.0 * geometry.area.max(f64::MIN_POSITIVE))) as f32
}
