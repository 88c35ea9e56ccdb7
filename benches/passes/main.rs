//! What every pass costs on the Cornell box, on a device and by its twin, beside what the machine can do, and whole bakes.
//!
//! A pass is timed only after its answer has been held against the twin's. `benches/README.md` says how to compare two
//! versions, and how docs/benchmarks.md is made of this.

mod case;
mod limits;
mod note;

use case::{Case, Held, PASSES};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use limits::Limits;
use note::Note;
use raycell::engine::Engine;
use raycell::gpu::{Gpu, device};
use raycell::pass::GpuEngine;
use raycell::twin::TwinEngine;
use raycell::{Backend, Flow, Params, bake};
use std::sync::Arc;
use std::time::Duration;

/// Rays of whole bakes.
const BAKES: [u32; 3] = [16_384, 65_536, 262_144];

/// Times every pass on one machine.
fn time<E: Engine>(group: &mut BenchmarkGroup<WallTime>, case: &Case, machine: &str, engine: &mut E, held: &mut Held<E>) {
    for pass in PASSES {
        group.throughput(Throughput::Elements(case.elements(pass.name)));
        group.bench_function(BenchmarkId::new(pass.name, machine), |b| {
            b.iter(|| {
                case.run(pass.name, engine, held);
                engine.finish().unwrap();
            })
        });
    }
}

/// Holds the answers of both machines against each other: at most one number in a hundred may differ, where a contracted
/// multiply-add sends a grazing ray elsewhere. On lavapipe none does.
fn validate(case: &Case, twin: &mut TwinEngine, gpu: &mut GpuEngine) {
    let (mut wanted, mut given) = (case.hold(twin), case.hold(gpu));
    for pass in PASSES {
        let name = pass.name;
        case.run(name, twin, &mut wanted);
        case.run(name, gpu, &mut given);
        let (want, got) = (case.answer(name, twin, &wanted), case.answer(name, gpu, &given));
        assert!(want.len() == got.len() && want.iter().any(|x| *x != 0.0), "{name}: {} and {} numbers", want.len(), got.len());
        let off = want.iter().zip(&got).filter(|(a, b)| (*a - *b).abs() > 1e-5 + 1e-4 * a.abs()).count();
        assert!(off * 100 <= want.len(), "{name}: {off} of {} numbers differ from the twin's", want.len());
    }
}

fn open() -> Option<device::OpenDevice> {
    match device::open(device::BackendChoice::Auto, None) {
        Ok(open) => {
            eprintln!("on {} ({:?}, {} {})", open.info.name, open.info.backend, open.info.driver, open.info.driver_info);
            Some(open)
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
    let open = open();
    if let Some(open) = &open {
        let gpu = Gpu::new(&open.device, &open.queue).unwrap();
        validate(&case, &mut twin, &mut GpuEngine::new(&gpu, &case.geometry).unwrap());
    }

    let mut group = c.benchmark_group("pass");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    if let Some(open) = &open {
        let gpu = Gpu::new(&open.device, &open.queue).unwrap();
        let mut engine = GpuEngine::new(&gpu, &case.geometry).unwrap();
        let mut held = case.hold(&mut engine);
        time(&mut group, &case, "device", &mut engine, &mut held);
    }
    let mut held = case.hold(&mut twin);
    time(&mut group, &case, "twin", &mut twin, &mut held);
    group.finish();

    // What the device's own clock says, apart: asking it costs time.
    if let Some(open) = &open {
        let mut note = Note::new(&open.info, &case);
        let gpu = Gpu::new(&open.device, &open.queue).unwrap();
        if gpu.time_kernels() {
            let mut engine = GpuEngine::new(&gpu, &case.geometry).unwrap();
            let mut held = case.hold(&mut engine);
            for pass in PASSES {
                let mut runs: Vec<f64> = (0..5)
                    .map(|_| {
                        engine.finish().unwrap();
                        gpu.take_kernel_seconds();
                        case.run(pass.name, &mut engine, &mut held);
                        engine.finish().unwrap();
                        gpu.take_kernel_seconds().values().sum()
                    })
                    .collect();
                runs.sort_by(f64::total_cmp);
                note.on_device(pass.name, runs[runs.len() / 2]);
            }
        }
        note.write();
    }
}

/// What the machine can do through the same driver.
fn limits(c: &mut Criterion) {
    let Some(open) = open() else { return };
    let limits = Limits::new(&open.device, &open.queue);
    limits.check();
    let mut group = c.benchmark_group("limit");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    group.throughput(Throughput::Elements(Limits::FLOPS)).bench_function("fma", |b| b.iter(|| limits.fma()));
    group.throughput(Throughput::Bytes(Limits::BYTES)).bench_function("triad", |b| b.iter(|| limits.triad()));
    group.finish();
}

fn bakes(c: &mut Criterion) {
    let Some(open) = open() else { return };
    let gpu = Arc::new(Gpu::new(&open.device, &open.queue).unwrap());
    let (backend, scene) = (Backend::Gpu(gpu), case::scene());
    let mut group = c.benchmark_group("bake");
    group.sample_size(10).sampling_mode(SamplingMode::Flat).measurement_time(Duration::from_secs(1));
    for rays in BAKES {
        let params = Params { rays, ..Params::default() };
        let once = || bake(&backend, &scene, &params, &mut |_| Flow::Continue).unwrap();
        group.throughput(Throughput::Elements(rays.into()));
        group.bench_function(BenchmarkId::new("cornell", rays), |b| {
            // All light is somewhere, to 5 % at so few rays.
            let imbalance = once().report().energy.imbalance.unwrap();
            assert!(imbalance.abs() < 0.05, "{imbalance}");
            b.iter(once)
        });
    }
    group.finish();
}

criterion_group!(benches, passes, limits, bakes);
criterion_main!(benches);
