//! Sums: cases G of `docs/hard_cases.md`.

use super::common::{gpu, impossible, known, open, root};
use raycell::engine::Engine;
use raycell::gpu::sentinel::{self, Counts};
use raycell::layout::{CellSums, Fixed, Point, kind};
use raycell::network::tiles::starts;
use raycell::pass::{self, GpuEngine};
use raycell::scene::Geometry;
use raycell::twin::fixed::{FEATURE_UNIT, encode};
use raycell::twin::math::hash;
use raycell::twin::winner::Feature;
use raycell::twin::{self, TwinEngine};
use raycell::{Backend, Error, Flow, Params, Scene, SurfacePoint, bake};
use std::collections::BTreeSet;
use std::sync::Arc;

fn cornell() -> Scene {
    Scene::load(root("scenes/cornell/scene.obj")).unwrap()
}

/// Everything that a bake leaves, as bytes.
fn bytes(backend: &Backend, scene: &Scene, params: &Params) -> Vec<u8> {
    let solution = bake(backend, scene, params, &mut |_| Flow::Continue).unwrap();
    let system = solution.system();
    [
        bytemuck::cast_slice::<_, u8>(solution.light()),
        bytemuck::cast_slice(solution.nodes()),
        bytemuck::cast_slice(solution.cells()),
        bytemuck::cast_slice(&system.cell_links),
        bytemuck::cast_slice(&system.node_links),
        bytemuck::cast_slice(&system.node_source),
    ]
    .concat()
}

/// Sums of numbers by the kernel `accumulate`, all in one cell; each stands in all 13 components of a feature.
fn summed(numbers: &[f32]) -> Option<CellSums> {
    let gpu = gpu()?;
    let features: Vec<Feature> = numbers.iter().map(|&x| std::array::from_fn(|k| if k < 13 { x } else { 0.0 })).collect();
    let points = vec![Point { kind: kind::FRONT, ..Point::default() }; features.len()];
    let (points, features) = (gpu.upload("points", &points).unwrap(), gpu.upload("features", &features).unwrap());
    let winners = gpu.upload("winners", &vec![0u32; numbers.len()]).unwrap();
    let cells = gpu.upload("cells", &[[0.0f32; 16]]).unwrap();
    let sums = pass::accumulate::accumulate(&gpu, &points, &features, &winners, 0..numbers.len(), &cells).unwrap();
    gpu.check_finished().unwrap();
    Some(gpu.read(&sums).unwrap()[0])
}

#[test]
fn g01_a_hundred_million_terms() {
    for (term, want) in [(1.0f32, known("SUM-1")), (0.1, known("SUM-0.1"))] {
        let mut sum = Fixed::default();
        let units = encode(term, FEATURE_UNIT);
        for _ in 0..100_000_000 {
            sum.add(std::hint::black_box(units));
        }
        let got = sum.value(FEATURE_UNIT);
        assert!((got / want - 1.0).abs() < 1e-15, "{term}: {got} {want}");
        // On the device: sums of integers have no order, so they are exact at any length.
        if let Some(sums) = summed(&vec![term; 1 << 18]) {
            let exact = i64::from(1 << 18) * units;
            assert!(sums.feature.iter().all(|s| s.units() == exact) && sums.count.units() == 1 << 18, "{term}: {sums:?}");
        }
    }
    // Bounded sums never wrap: what would not fit saturates a term at a time, and ranges are tabled in src/twin/fixed.rs.
    assert_eq!((encode(1e30, FEATURE_UNIT), encode(-1e30, FEATURE_UNIT)), (i64::MAX, i64::MIN));
}

#[test]
fn g02_what_is_relied_on_instead_of_error_free_transforms() {
    // No kernel rests on TwoSum or Kahan's sum, which compilers may take apart. The pair that breaks them, 1e8 and 0.1f,
    // keeps every bit in an integer of two words.
    let (big, small) = (1e8f32, 0.1f32);
    if let Some(sums) = summed(&[big, small]) {
        let rest = sums.feature[0].units() - encode(big, FEATURE_UNIT);
        let error = (rest as f64 / f64::from(FEATURE_UNIT)) as f32;
        assert_eq!(error.to_bits(), 0x3DCC_CCCD, "{error}");
    }
    // What is relied on, carry between words, bit casts and exponents that may be changed as bits, is tested at every start.
    let Some(gpu) = gpu() else { return };
    for (items, trips) in [(1, 0), (192, 30_000), (100_003, 7)] {
        assert_eq!(sentinel::count(&gpu, items, trips, 4096).unwrap(), Counts::expected(items, trips));
    }
    sentinel::check(&gpu).unwrap();
}

#[test]
fn g03_twenty_runs_leave_one_answer() {
    let scene = cornell();
    let params = Params { rays: 1_024, ..Params::default() };
    let backend = gpu().map_or(Backend::Cpu, Backend::Gpu);
    let want = bytes(&backend, &scene, &params);
    for run in 1..20 {
        assert!(bytes(&backend, &scene, &params) == want, "run {run} differs");
    }
    assert!(bytes(&backend, &scene, &Params { seed: 2, ..params }) != want);
}

#[test]
fn g04_workgroups_of_any_size_leave_one_answer() {
    let Some(first) = open() else { return };
    let scene = cornell();
    let params = Params { rays: 4_096, ..Params::default() };
    let want = bytes(&Backend::Gpu(Arc::new(first)), &scene, &params);
    for group in [32, 128, 256] {
        let gpu = open().unwrap().with_group(group);
        sentinel::check(&gpu).unwrap();
        assert!(bytes(&Backend::Gpu(Arc::new(gpu)), &scene, &params) == want, "workgroups of {group}");
    }
}

#[test]
fn g05_the_order_of_triangles_does_not_matter() {
    let scene = cornell();
    let shuffled = |seed: u32| {
        let mut faces: Vec<usize> = (0..scene.faces.len()).collect();
        faces.sort_by_key(|&f| hash(seed ^ hash(f as u32 + 1)));
        let triangles: Vec<_> = faces.iter().map(|&f| (scene.corners(f), scene.faces[f].material)).collect();
        Scene::from_triangles("shuffled", &triangles, scene.materials.clone()).unwrap()
    };
    let points: Vec<SurfacePoint> = super::common::truth("cornell").points.into_iter().step_by(4).collect();

    // What draws nothing is the same to the bit: places, the kernel between them, areas in all.
    let plain = Geometry::new(&scene).unwrap();
    let kernel = |g: &Geometry| {
        let mut pairs: Vec<Point> = points
            .iter()
            .filter_map(|p| g.locate(p.p, p.n))
            .map(|l| Point { p: l.p, tri: l.tri, kind: kind::FRONT, ..Point::default() })
            .collect();
        assert_eq!(pairs.len(), points.len());
        pairs.truncate(pairs.len() / 2 * 2);
        let places: Vec<[u32; 3]> = pairs.iter().map(|p| p.p.map(f32::to_bits)).collect();
        let mut values = vec![TwinEngine::new(g).kernel(&pairs).unwrap()];
        if let Some(gpu) = gpu() {
            values.push(GpuEngine::new(&gpu, g).unwrap().kernel(&pairs).unwrap());
        }
        (places, values.into_iter().map(|v| v.into_iter().map(f32::to_bits).collect::<Vec<_>>()).collect::<Vec<_>>())
    };
    let want = kernel(&plain);
    assert!(want.1[0].iter().filter(|&&k| k != 0).count() > points.len() / 20);
    for seed in 1..=5 {
        let g = Geometry::new(&shuffled(seed)).unwrap();
        assert!(kernel(&g) == want, "seed {seed}");
        assert!((g.area / plain.area - 1.0).abs() < 1e-14 && (g.scale, g.emission_scale) == (plain.scale, plain.emission_scale));
    }

    // Rays are drawn over the triangles in their order, so the rest is a second draw of the same estimator.
    let backend = gpu().map_or(Backend::Cpu, Backend::Gpu);
    let light = |scene: &Scene, seed: u32| -> Vec<f64> {
        let params = Params { seed, rays: 8_192, gather_rays: 0, ..Params::default() };
        let answers = bake(&backend, scene, &params, &mut |_| Flow::Continue).unwrap().query(&backend, &points).unwrap();
        assert_eq!(impossible(&answers, scene, 0.05), None);
        answers.iter().map(|a| a.h.iter().sum::<f64>() / 3.0).collect()
    };
    let ours: Vec<Vec<f64>> = (1..=5).map(|seed| light(&scene, seed)).collect();
    let theirs: Vec<Vec<f64>> = (1..=5).map(|seed| light(&shuffled(seed), seed)).collect();
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let spread = |x: &[f64]| x.iter().map(|v| (v - mean(x)).powi(2)).sum::<f64>() / (x.len() - 1) as f64;
    let totals = [&ours, &theirs].map(|all| all.iter().map(|l| mean(l)).collect::<Vec<f64>>());
    let error = ((spread(&totals[0]) + spread(&totals[1])) / 5.0).sqrt();
    let apart = mean(&totals[0]) - mean(&totals[1]);
    eprintln!("mean light {:.5} and {:.5}, {:.1} standard errors apart", mean(&totals[0]), mean(&totals[1]), apart / error);
    assert!(apart.abs() <= 5.0 * error, "{totals:?}");
    // Nor does any point scatter more: the mean squares of 5 seeds are known to 5 % over so many points.
    let scatter =
        [&ours, &theirs].map(|all| (0..points.len()).map(|i| spread(&all.iter().map(|l| l[i]).collect::<Vec<_>>())).sum::<f64>());
    let between = (0..points.len())
        .map(|i| [&ours, &theirs].map(|all| mean(&all.iter().map(|l| l[i]).collect::<Vec<_>>())))
        .map(|[a, b]| (a - b).powi(2))
        .sum::<f64>();
    // Means of five differ by 2/5 of one's variance.
    let expected = (scatter[0] + scatter[1]) / 5.0;
    eprintln!("scatter {scatter:?}; means differ by {between:.3e}, {expected:.3e} is expected");
    assert!(between < 1.6 * expected && between > 0.4 * expected, "{between} {expected}");
}

#[test]
fn g06_of_equal_cells_the_first_wins() {
    let number = |i: u32| (hash(i) % 1_000) as f32 / 1_000.0;
    for (distinct, copies) in [(1, 300), (7, 100), (513, 9)] {
        let places: Vec<Feature> =
            (0..distinct).map(|i| std::array::from_fn(|k| if k < 13 { number(16 * i + k as u32) } else { 0.0 })).collect();
        let cells: Vec<Feature> = (0..copies).flat_map(|_| places.clone()).collect();
        let want: Vec<u32> = (0..distinct * copies).map(|i| i % distinct).collect();
        assert_eq!(twin::winner::winner(&cells, &cells), want);
        let Some(gpu) = gpu() else { continue };
        let order: Vec<u32> = (0..cells.len() as u32).collect();
        let (features, order) = (gpu.upload("features", &cells).unwrap(), gpu.upload("order", &order).unwrap());
        let winners = gpu.upload("winners", &vec![u32::MAX; cells.len()]).unwrap();
        let blocks = pass::winner::CellBlocks::new(&gpu, &cells).unwrap();
        pass::winner::winner(&gpu, &features, &order, &blocks, &winners).unwrap();
        assert_eq!(gpu.read_finished(&winners, 0, cells.len()).unwrap(), want, "{distinct} {copies}");
    }
}

#[test]
fn g07_ids_beyond_two_to_the_24th() {
    const EDGE: u32 = 1 << 24;
    assert_eq!(f64::from(EDGE), known("LIM-F32-INT"));
    // Rays are numbered: 2^24 - 1 to 2^24 + 3 are five, each its own, the same on both machines.
    let scene = cornell();
    let g = Geometry::new(&scene).unwrap();
    let tiles = starts(&g, &vec![0.0; g.tiles as usize], 0.0);
    let rays = twin::emit::emit(&g, &tiles, 3, EDGE - 1, 5, EDGE);
    let ends = |points: &[Point]| points.chunks_exact(2).map(|r| r[0].p.map(f32::to_bits)).collect::<BTreeSet<_>>();
    assert_eq!(ends(&rays).len(), 5);
    // One by one, too.
    let each: Vec<Point> = (0..5).flat_map(|i| twin::emit::emit(&g, &tiles, 3, EDGE - 1 + i, 1, EDGE)).collect();
    assert_eq!(ends(&each), ends(&rays));
    let Some(gpu) = gpu() else { return };
    let mut engine = GpuEngine::new(&gpu, &g).unwrap();
    let batch = engine.emit(&tiles, 3, EDGE - 1, 5, EDGE).unwrap();
    let got = engine.points(&batch).unwrap();
    for (a, b) in rays.iter().zip(&got) {
        assert!((0..3).all(|k| (a.p[k] - b.p[k]).abs() < 1e-5) && a.tri == b.tri, "{a:?} {b:?}");
    }
    // Items of a kernel: each is counted once, and the sum of their numbers is that of 0 to 2^24 + 3.
    let items = EDGE + 4;
    assert_eq!(sentinel::count(&gpu, items, 0, 1 << 20).unwrap(), Counts::expected(items, 0));
    // Cells carry their number as a float in the kernel `winner`; there are never so many.
    let refused = Params { cells: Some(EDGE + 1), ..Params::default() }.check();
    assert!(matches!(refused, Err(Error::InvalidParam { name: "cells", .. })), "{refused:?}");
}
