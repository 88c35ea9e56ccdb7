//! The bake: the one place that knows the order of the passes (design §1).
//!
//! 1. Table direct light on tiles; start rays where it has to be carried on.
//! 2. Pilot network: a coarse solution that says where light goes.
//! 3. Full network: rays by importance, nodes where light changes quickly, cells grown on the rays.
//! 4. Read the cells as coefficients, solve, account for every watt.

use crate::doctor;
use crate::engine::{Backend, Engine};
use crate::error::Result;
use crate::layout::{NodeLight, Tile};
use crate::network::{growth, nodes, tiles, tiles::mean};
use crate::output::report::{Report, SceneReport, Seconds, SolverReport};
use crate::params::{Direct, Params};
use crate::pass::GpuEngine;
use crate::progress::{Event, Flow, Progress};
use crate::radiosity::components::{Components, Splitter};
use crate::radiosity::winding::Winding;
use crate::radiosity::{coefficients, energy, solver};
use crate::scene::{Geometry, Scene};
use crate::solution::Solution;
use crate::stream::{Stream, stream};
use crate::twin::TwinEngine;
use crate::twin::assign::Surface;
use crate::twin::direct::Samples;
use crate::twin::math::seed_of;
use crate::twin::winner::{Feature, Metric};
use std::collections::BTreeMap;
use std::time::Instant;

/// Rays of the pilot network.
const PILOT_RAYS: u32 = 65_536;
/// Cells of the pilot network.
const PILOT_CELLS: u32 = 512;
/// Nodes of the pilot network.
const PILOT_NODES: usize = 400;
/// Rays in a batch.
#[doc(hidden)]
pub const BATCH: u32 = 65_536;

/// A trained and solved network.
pub(crate) struct Network<E: Engine> {
    pub surface: Surface,
    pub light: Vec<NodeLight>,
    pub cells: Vec<Feature>,
    pub coefficients: coefficients::Coefficients,
    pub solved: solver::Solved,
    pub training: growth::Training,
    batches: Vec<E::Batch>,
}

/// What a network is trained on.
struct Stage<'a> {
    rays: u32,
    cells: u32,
    nodes: usize,
    tiles: &'a [Tile],
    brightness: &'a [f64],
    density: &'a [f64],
    refinements: u32,
    seeds: [u32; 3],
    /// The network that counts: its stages are told, and its points are many.
    told: bool,
}

/// Wall time a stage, added up.
#[derive(Default)]
pub(crate) struct Clock {
    pub seconds: BTreeMap<&'static str, f64>,
}

impl Clock {
    /// Runs `work` as part of stage `name`.
    pub fn time<E: Engine, T>(
        &mut self,
        engine: &mut E,
        name: &'static str,
        work: impl FnOnce(&mut E) -> Result<T>,
    ) -> Result<T> {
        let start = Instant::now();
        let out = work(engine)?;
        engine.finish()?;
        *self.seconds.entry(name).or_default() += start.elapsed().as_secs_f64();
        Ok(out)
    }

    pub fn get(&self, name: &str) -> Option<f64> {
        self.seconds.get(name).copied()
    }
}

/// Bakes a scene: trains the network, solves for the light.
///
/// Blocks until done; `progress` hears what happens and may stop it. Errors: those of
/// [`Scene::check`] and [`Params::check`], of the device, [`crate::Error::NotContractive`],
/// [`crate::Error::Cancelled`].
pub fn bake(backend: &Backend, scene: &Scene, params: &Params, progress: &mut dyn FnMut(&Event) -> Flow) -> Result<Solution> {
    params.check()?;
    let mut progress = Progress::new(progress);
    progress.event(Event::Stage { name: "bvh" })?;
    let start = Instant::now();
    let geometry = Geometry::new(scene)?;
    let bvh = start.elapsed().as_secs_f64();
    for warning in doctor::warnings(scene, &geometry) {
        progress.event(Event::Warning(warning))?;
    }
    let mut solution = match backend {
        Backend::Cpu => run(&mut TwinEngine::new(&geometry), scene, &geometry, params, &mut progress)?,
        Backend::Gpu(gpu) => run(&mut GpuEngine::new(gpu, &geometry)?, scene, &geometry, params, &mut progress)?,
    };
    let report = solution.report_mut();
    report.seconds.bvh = Some(bvh);
    report.seconds.total = Some(start.elapsed().as_secs_f64());
    Ok(solution)
}

/// The order of the passes, on any engine.
fn run<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    progress: &mut Progress,
) -> Result<Solution> {
    let mut clock = Clock::default();
    let exact = params.direct == Direct::Exact;
    let names: Vec<String> = scene.materials.iter().map(|m| m.name.clone()).collect();

    // Table what each tile sends before any bounce: E, or rho D where direct light is exact.
    progress.event(Event::Stage { name: "pilot" })?;
    let places = tiles::places(geometry, stream(params.seed, Stream::TilePlace));
    let direct =
        clock.time(engine, "direct", |engine| tiles::direct(engine, &places, stream(params.seed, Stream::TileDirect)))?;
    let sent: Vec<[f64; 3]> = (0..places.len())
        .map(|t| {
            let m = geometry.material_at(&places[t]);
            let d = direct[t].mean();
            [0, 1, 2].map(|k| if exact { (m.rho[k] * d[k]) as f64 } else { m.emit[k] as f64 })
        })
        .collect();

    // Pilot: where does light go?
    let uniform = vec![1.0; geometry.tiles as usize];
    let first: Vec<f64> = sent.iter().map(mean).collect();
    let pilot = network(
        engine,
        geometry,
        params,
        &Stage {
            rays: PILOT_RAYS.min(params.rays),
            cells: PILOT_CELLS,
            nodes: PILOT_NODES,
            tiles: &tiles::starts(geometry, &first, params.alpha),
            brightness: &first,
            density: &uniform,
            refinements: 0,
            told: false,
            seeds: [Stream::PilotNodes, Stream::PilotRays, Stream::PilotEnds].map(|s| stream(params.seed, s)),
        },
        &mut clock,
        progress,
        &names,
    )?;

    // What the pilot's rays met from behind is wound the wrong way round.
    let winding = Winding::count(scene, geometry, &engine.points(&pilot.batches[0])?).warnings(scene);
    for warning in &winding {
        progress.event(Event::Warning(warning.clone()))?;
    }

    // Importance: what each tile sends in the pilot's light.
    let carried: Vec<f64> = clock.time(engine, "train", |engine| {
        engine.set_light(&pilot.light)?;
        let mut h = Vec::new();
        for chunk in places.chunks(BATCH as usize) {
            let mut batch = engine.upload(chunk)?;
            engine.assign(&mut batch)?;
            engine.readout(&mut batch)?;
            h.extend(engine.irradiance(&batch)?);
        }
        Ok((0..places.len())
            .map(|t| {
                let rho = geometry.material_at(&places[t]).rho;
                mean(&[0, 1, 2].map(|k| sent[t][k] + (rho[k] * h[t][k]) as f64))
            })
            .collect())
    })?;
    let count = params.node_count(geometry.pieces);
    let density = clock.time(engine, "train", |engine| tiles::node_density(engine, geometry, &pilot.batches, &carried, count))?;
    drop(pilot);

    // The full network. Shared out by less than its light, a dark part still gets rays enough to be read.
    let gamma = if exact { params.gamma } else { 1.0 };
    let wanted: Vec<f64> = carried.iter().map(|c| c.powf(gamma)).collect();
    let mut full = network(
        engine,
        geometry,
        params,
        &Stage {
            rays: params.rays,
            cells: params.cells(),
            nodes: count,
            tiles: &tiles::starts(geometry, &wanted, params.alpha),
            brightness: &carried,
            density: &density,
            refinements: params.refinements,
            told: true,
            seeds: [Stream::Nodes, Stream::Rays, Stream::Ends].map(|s| stream(params.seed, s)),
        },
        &mut clock,
        progress,
        &names,
    )?;
    let seed = stream(params.seed, Stream::Emission);
    let energy =
        clock.time(engine, "energy", |engine| energy::account(engine, geometry, seed, exact, &full.light, &mut full.batches))?;

    // Training is everything up to the winners; its parts are told beside it.
    let train: f64 = ["train", "emit", "nodes", "assign", "grow", "winner"].iter().filter_map(|s| clock.get(s)).sum();
    let mut report = Report {
        raycell: env!("CARGO_PKG_VERSION").into(),
        scene: SceneReport {
            path: scene.name.clone(),
            triangles: geometry.tris.len() as u64,
            dropped: (geometry.degenerate.len() + geometry.duplicate.len()) as u64,
        },
        seed: params.seed,
        params: params.clone(),
        cells: full.coefficients.system.source.len() as u64,
        nodes: full.surface.nodes.len() as u64,
        coefficients: full.coefficients.stored,
        rays: params.rays as u64,
        seconds: Seconds {
            compile: Some(engine.compile_seconds()),
            train: Some(train),
            coefficients: clock.get("coefficients"),
            solve: clock.get("solve"),
            direct: clock.get("direct"),
            ..Seconds::default()
        },
        solver: SolverReport {
            method: "jacobi".into(),
            sweeps: full.solved.sweeps as u64,
            residual: Some(full.solved.residual),
            error_bound: Some(full.solved.error_bound),
        },
        energy,
        warnings: [doctor::warnings(scene, geometry), winding].concat(),
        ..Report::default()
    };
    report.memory_bytes.device = Some(engine.device_bytes());
    for (key, value) in [
        ("rays_per_second", serde_json::json!(params.rays as f64 / train.max(1e-9))),
        ("epochs", serde_json::json!(full.training.epochs)),
        ("cells_deleted", serde_json::json!(full.training.deleted)),
        ("contraction", serde_json::json!(full.solved.contraction)),
        ("dropped_coefficient_mass", serde_json::json!(full.coefficients.dropped)),
        ("planar_pieces", serde_json::json!(geometry.pieces)),
        ("emission_scale", serde_json::json!(geometry.emission_scale)),
        ("stages", serde_json::json!(clock.seconds)),
    ] {
        report.extra.insert(key.into(), value);
    }
    Ok(Solution::new(
        scene.clone(),
        geometry.clone(),
        params.clone(),
        full.surface,
        full.light,
        full.cells,
        &full.coefficients,
        report,
    ))
}

/// Trains and solves one network.
fn network<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    stage: &Stage,
    clock: &mut Clock,
    progress: &mut Progress,
    names: &[String],
) -> Result<Network<E>> {
    let exact = params.direct == Direct::Exact;
    let [node_seed, ray_seed, end_seed] = stage.seeds;
    let tell = |progress: &mut Progress, name| if stage.told { progress.event(Event::Stage { name }) } else { Ok(()) };
    tell(progress, "train")?;

    // Place the nodes.
    let mut surface = clock.time(engine, "nodes", |engine| {
        nodes::place_nodes(engine, geometry, stage.density, stage.nodes, params.lambda as f32, node_seed, stage.told)
    })?;

    // Shoot all rays, find what both ends see of the emitters and which nodes speak for them.
    let area: f64 = (0..geometry.tiles as usize).map(|t| geometry.tile_area(t)).sum();
    let rms =
        ((0..stage.brightness.len()).map(|t| stage.brightness[t].powi(2) * geometry.tile_area(t)).sum::<f64>() / area).sqrt();
    let brightness: Vec<f32> = stage.brightness.iter().map(|b| if rms > 0.0 { (b / rms) as f32 } else { 0.0 }).collect();
    let metric = Metric { inv_unit: (1.0 / geometry.unit) as f32, lambda: params.lambda as f32, mu: params.mu as f32 };
    let (mut batches, mut lengths) = (Vec::new(), Vec::new());
    for first in (0..stage.rays).step_by(BATCH as usize) {
        let count = BATCH.min(stage.rays - first);
        let mut batch = clock.time(engine, "emit", |engine| engine.emit(stage.tiles, ray_seed, first, count, stage.rays))?;
        if exact {
            let samples = Samples { emitter: params.end_samples, cosine: 1 };
            clock.time(engine, "direct", |engine| engine.direct(&mut batch, None, seed_of(end_seed, first), 0, 1, samples))?;
        }
        clock.time(engine, "assign", |engine| engine.assign(&mut batch))?;
        clock.time(engine, "train", |engine| engine.feature(&mut batch, metric, &brightness))?;
        batches.push(batch);
        lengths.push(2 * count as usize);
        progress.event(Event::Rays { done: (first + count) as u64, total: stage.rays as u64 })?;
    }

    // Grow the cells, then let every ray find its own.
    let (cells, training) =
        clock.time(engine, "grow", |engine| growth::grow(engine, &mut batches, &lengths, stage.cells as usize, progress))?;
    clock.time(engine, "winner", |engine| {
        for (batch, &points) in batches.iter_mut().zip(&lengths) {
            engine.winner(batch, 0..points, &cells)?;
        }
        Ok(())
    })?;

    // Rooms that see nothing of each other get cells of their own.
    let cell_count = clock.time(engine, "coefficients", |engine| {
        let mut components = Components::new(surface.nodes.len());
        let mut seen = Vec::new();
        for batch in &batches {
            let (points, psi) = (engine.points(batch)?, engine.psi(batch)?);
            components.join(&points, &psi);
            seen.push((points, psi));
        }
        let mut splitter = Splitter::new(cells.len());
        for (batch, (points, psi)) in batches.iter_mut().zip(seen) {
            let mut winners = engine.winners(batch)?;
            if splitter.split(&mut components, &points, &psi, &mut winners) {
                engine.set_winners(batch, &winners)?;
            }
        }
        Ok(splitter.cells())
    })?;

    // Read the cells as coefficients.
    tell(progress, "coefficients")?;
    // All rays together weigh 2 A / (1 - alpha) at most.
    let normalise = ((1.0 - params.alpha) / (2.0 * geometry.area.max(f64::MIN_POSITIVE))) as f32;
    let built = clock.time(engine, "coefficients", |engine| {
        let sums = engine.coefficients(&batches, exact, normalise, stage.rays as f32, cell_count)?;
        let mut built = coefficients::build(&sums, &mut surface.nodes, params.ridge, params.slots as usize, stage.rays as f64);
        engine.set_surface(&surface)?;
        if exact {
            // The first bounce is known at every ray's end; it needs no cell.
            built.system.source.fill([0.0; 4]);
            let sums = engine.deposit(&batches, false, normalise)?;
            built.system.node_source = coefficients::known(&sums, &surface.nodes, &built.mass);
        }
        Ok(built)
    })?;

    // Solve; then let the rays carry the solution on, each from its own end: what the cells leave out
    // fades with every sweep.
    tell(progress, "solve")?;
    let (light, solved) = clock.time(engine, "solve", |engine| {
        engine.set_system(&built.system)?;
        let dark = vec![NodeLight::default(); surface.nodes.len()];
        let (mut light, solved) = solver::solve(engine, geometry, dark, params.tolerance, params.max_sweeps, progress, names)?;
        for _ in 0..if exact { stage.refinements } else { 0 } {
            engine.set_light(&light)?;
            for batch in &mut batches {
                engine.readout(batch)?;
            }
            let sums = engine.deposit(&batches, true, normalise)?;
            let by_rays = coefficients::known(&sums, &surface.nodes, &built.mass);
            light = coefficients::fit(&by_rays, &built.system.planes);
        }
        Ok((light, solved))
    })?;
    Ok(Network { surface, light, cells, coefficients: built, solved, training, batches })
}
