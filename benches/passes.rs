//! What the heavy passes cost on the Cornell box, on a device and by their twins, and a whole small bake.
//!
//! A pass is timed only after its answer has been held against the twin's. `benches/README.md` says how
//! to compare two versions.

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use raycell::engine::Engine;
use raycell::gpu::{Gpu, device};
use raycell::layout::{NodeLight, Tile};
use raycell::network::nodes::place_nodes;
use raycell::pass::GpuEngine;
use raycell::progress::Progress;
use raycell::radiosity::coefficients;
use raycell::scene::Geometry;
use raycell::twin::assign::Surface;
use raycell::twin::direct::Samples;
use raycell::twin::jacobi::System;
use raycell::twin::winner::{Feature, Metric};
use raycell::twin::{TwinEngine, coefficients::Sums};
use raycell::{Backend, Flow, Params, Scene, bake};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

/// Rays of a batch.
const RAYS: u32 = 8_192;
/// Rays of the whole bake.
const BAKE: u32 = 65_536;
/// Cells of the networks that rays find their winners in.
const CELLS: [usize; 2] = [1_024, 4_096];
/// Sweeps of a call of Jacobi.
const SWEEPS: u32 = 8;
const SAMPLES: Samples = Samples { emitter: 2, cosine: 1 };

/// The scene, and what the passes need of each other, by the twins.
struct Case {
    geometry: Geometry,
    tiles: Vec<Tile>,
    surface: Surface,
    metric: Metric,
    brightness: Vec<f32>,
    system: System,
    light: Vec<NodeLight>,
}

fn scene() -> Scene {
    Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell/scene.obj")).unwrap()
}

impl Case {
    fn new() -> Case {
        let geometry = Geometry::new(&scene()).unwrap();
        let params = Params::default();
        // Starts uniform over the area.
        let mut sum = 0.0;
        let tiles = (0..geometry.tiles as usize)
            .map(|t| {
                sum += geometry.tile_area(t) / geometry.area;
                let last = t + 1 == geometry.tiles as usize;
                let cdf = if last { u32::MAX } else { (sum * 4294967296.0).min(4294967295.0) as u32 };
                Tile { cdf, density: (1.0 / geometry.area) as f32 }
            })
            .collect();
        let mut engine = TwinEngine::new(&geometry);
        let density = vec![1.0; geometry.tiles as usize];
        let surface = place_nodes(
            &mut engine,
            &geometry,
            &density,
            400,
            params.lambda as f32,
            5,
            true,
            &mut Progress::new(&mut |_| Flow::Continue),
        )
        .unwrap();
        let metric = Metric { inv_unit: (1.0 / geometry.unit) as f32, lambda: params.lambda as f32, mu: params.mu as f32 };
        let brightness = vec![1.0; geometry.tiles as usize];
        let mut case = Case { geometry, tiles, surface, metric, brightness, system: System::default(), light: Vec::new() };

        // A linear system out of these rays.
        let mut engine = TwinEngine::new(&case.geometry);
        let mut batch = case.rays(&mut engine);
        let cells = case.cells(&mut engine, &batch, CELLS[0]);
        engine.winner(&mut batch, 0..2 * RAYS as usize, &cells).unwrap();
        let normalise = (1.0 / (2.0 * case.geometry.area)) as f32;
        let sums: Sums = engine.coefficients(&[batch], true, normalise, RAYS as f32, cells.len(), &mut || Ok(())).unwrap();
        let mut nodes = case.surface.nodes.clone();
        case.system = coefficients::build(&sums, &mut nodes, params.ridge, params.slots as usize, RAYS as f64).system;
        case.light = vec![NodeLight { h: [1.0, 0.5, 0.25], ..NodeLight::default() }; nodes.len()];
        case
    }

    /// A batch with all that `winner` and `coefficients` ask for.
    fn rays<E: Engine>(&self, engine: &mut E) -> E::Batch {
        engine.set_surface(&self.surface).unwrap();
        let mut batch = engine.emit(&self.tiles, 3, 0, RAYS, RAYS).unwrap();
        engine.direct(&mut batch, None, 7, 0, 1, SAMPLES).unwrap();
        engine.assign(&mut batch).unwrap();
        engine.feature(&mut batch, self.metric, &self.brightness).unwrap();
        batch
    }

    /// Every so-many-th ray as a cell.
    fn cells<E: Engine>(&self, engine: &mut E, batch: &E::Batch, count: usize) -> Vec<Feature> {
        let features = engine.features(batch, 0..2 * RAYS as usize).unwrap();
        features.into_iter().step_by(2 * RAYS as usize / count).take(count).collect()
    }

    /// One answer of every pass in turn, to be held against another machine's.
    fn answers<E: Engine>(&self, engine: &mut E) -> Vec<Vec<f32>> {
        let mut batch = self.rays(engine);
        let mut out = vec![
            engine.points(&batch).unwrap().iter().flat_map(|p| [p.p[0], p.p[1], p.p[2], p.tri as f32]).collect(),
            engine.direct_sums(&batch).unwrap().iter().flat_map(|d| d.sum).collect(),
            engine.psi(&batch).unwrap().iter().flat_map(|s| s.weight).collect(),
        ];
        for count in CELLS {
            let cells = self.cells(engine, &batch, count);
            engine.winner(&mut batch, 0..2 * RAYS as usize, &cells).unwrap();
            out.push(engine.winners(&batch).unwrap().iter().map(|&w| w as f32).collect());
        }
        engine.set_system(&self.system).unwrap();
        out.push(engine.jacobi(&self.light, SWEEPS).unwrap().iter().flat_map(|l| l.h).collect());
        out
    }

    /// Times every pass on one machine.
    fn time<E: Engine>(&self, c: &mut Criterion, machine: &str, engine: &mut E) {
        let mut group = c.benchmark_group("pass");
        group.sample_size(10).sampling_mode(SamplingMode::Flat);
        group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
        group.throughput(Throughput::Elements(RAYS as u64));
        group.bench_function(format!("emit/{machine}"), |b| {
            b.iter(|| {
                let batch = engine.emit(&self.tiles, 3, 0, RAYS, RAYS).unwrap();
                engine.finish().unwrap();
                batch
            })
        });
        let mut batch = self.rays(engine);
        group.throughput(Throughput::Elements(2 * RAYS as u64));
        group.bench_function(format!("direct/{machine}"), |b| {
            b.iter(|| {
                engine.direct(&mut batch, None, 7, 0, 1, SAMPLES).unwrap();
                engine.finish().unwrap();
            })
        });
        group.bench_function(format!("assign/{machine}"), |b| {
            b.iter(|| {
                engine.assign(&mut batch).unwrap();
                engine.finish().unwrap();
            })
        });
        for count in CELLS {
            let cells = self.cells(engine, &batch, count);
            group.bench_function(format!("winner {count}/{machine}"), |b| {
                b.iter(|| {
                    engine.winner(&mut batch, 0..2 * RAYS as usize, &cells).unwrap();
                    engine.finish().unwrap();
                })
            });
        }
        engine.set_system(&self.system).unwrap();
        group.throughput(Throughput::Elements(SWEEPS as u64));
        group.bench_function(format!("jacobi/{machine}"), |b| {
            b.iter(|| engine.jacobi(black_box(&self.light), SWEEPS).unwrap()) // reads the light back
        });
        group.finish();
    }
}

/// Holds the answers of both machines against each other: at most one number in a hundred may differ,
/// where a contracted multiply-add sends a grazing ray elsewhere. On lavapipe none does.
fn validate(want: &[Vec<f32>], got: &[Vec<f32>]) {
    for ((want, got), name) in want.iter().zip(got).zip(["emit", "direct", "assign", "winner", "winner", "jacobi"]) {
        assert!(want.len() == got.len() && want.iter().any(|x| *x != 0.0), "{name}");
        let off = want.iter().zip(got).filter(|(a, b)| (*a - *b).abs() > 1e-5 + 1e-4 * a.abs()).count();
        assert!(off * 100 <= want.len(), "{name}: {off} of {} numbers differ from the twin's", want.len());
    }
}

fn open() -> Option<Arc<Gpu>> {
    match device::open(device::BackendChoice::Auto, None) {
        Ok(open) => {
            eprintln!("on {} ({:?}, {} {})", open.info.name, open.info.backend, open.info.driver, open.info.driver_info);
            Some(Arc::new(Gpu::new(&open.device, &open.queue).unwrap()))
        }
        Err(e) => {
            eprintln!("twins only: {e}");
            None
        }
    }
}

fn passes(c: &mut Criterion) {
    let case = Case::new();
    let mut twin = TwinEngine::new(&case.geometry);
    if let Some(gpu) = open() {
        let mut engine = GpuEngine::new(&gpu, &case.geometry).unwrap();
        validate(&case.answers(&mut twin), &case.answers(&mut engine));
        case.time(c, "device", &mut engine);
    }
    case.time(c, "twin", &mut twin);
}

fn bakes(c: &mut Criterion) {
    let Some(gpu) = open() else { return };
    let (backend, scene) = (Backend::Gpu(gpu), scene());
    let params = Params { rays: BAKE, ..Params::default() };
    let once = || bake(&backend, &scene, &params, &mut |_| Flow::Continue).unwrap();
    // All light is somewhere, to 3 % at so few rays.
    let imbalance = once().report().energy.imbalance.unwrap();
    assert!(imbalance.abs() < 0.03, "{imbalance}");
    let mut group = c.benchmark_group("bake");
    group.sample_size(10).sampling_mode(SamplingMode::Flat).measurement_time(Duration::from_secs(5));
    group.throughput(Throughput::Elements(BAKE as u64)); // rays
    group.bench_function("cornell/device", |b| b.iter(once));
    group.finish();
}

criterion_group!(benches, passes, bakes);
criterion_main!(benches);
