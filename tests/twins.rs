//! Each GPU pass against its plain-Rust twin, at awkward sizes.
//!
//! Without any adapter the tests pass with a note, unless `RAYCELL_REQUIRE_GPU` is set.

mod common;

use raycell::engine::Engine;
use raycell::gpu::device::{BackendChoice, list_adapters, open};
use raycell::gpu::sentinel::{self, Counts};
use raycell::gpu::{Gpu, LIGHT};
use raycell::layout::{
    CellFlux, CellOutput, CellSums, DirectSum, Fixed, Link, NONE, NodeLight, NodeSums, Plane, Point, Psi, Sample, Slot, Tile,
    kind,
};
use raycell::network::nodes::place_nodes;
use raycell::pass::{self, GpuEngine, SceneBuffers, SurfaceBuffers};
use raycell::progress::{Flow, Progress};
use raycell::scene::{Geometry, Material};
use raycell::twin::assign::Surface;
use raycell::twin::direct::Samples;
use raycell::twin::fixed::FEATURE_UNIT;
use raycell::twin::gather::Gathered;
use raycell::twin::jacobi::System;
use raycell::twin::respond::Net;
use raycell::twin::winner::{Feature, Metric};
use raycell::twin::{self, TwinEngine};
use raycell::{Backend, Error, Params, Scene, bake, wgpu};

/// A device of the test's own: some leave its flags raised.
fn gpu() -> Option<Gpu> {
    common::open()
}

/// Sizes that every cheap pass is tried at: empty, around a workgroup, ragged, beyond 65,535 workgroups.
const SIZES: [usize; 7] = [0, 1, 63, 64, 65, 10_007, 65_535 * 64 + 77];

#[test]
fn dispatches_reach_every_item_once() {
    let Some(gpu) = gpu() else { return };
    for n in SIZES {
        for chunk in [LIGHT, u32::MAX] {
            let n = n as u32;
            assert_eq!(sentinel::count(&gpu, n, 3, chunk).unwrap(), Counts::expected(n, 3));
        }
    }
}

#[test]
fn buffers_hold_what_was_written() {
    let Some(gpu) = gpu() else { return };
    for n in SIZES {
        let data: Vec<u32> = (0..n as u32).map(|i| i.wrapping_mul(2654435761)).collect();
        let vec = gpu.upload("data", &data).unwrap();
        assert_eq!(gpu.read(&vec).unwrap(), data);
        // Odd bytes survive the padding to four.
        let bytes: Vec<u8> = data.iter().take(4099).map(|&x| x as u8).collect();
        let vec = gpu.alloc::<u32>("odd", bytes.len().div_ceil(4)).unwrap();
        assert_eq!(gpu.read(&vec).unwrap(), vec![0; bytes.len().div_ceil(4)]);
    }
}

#[test]
fn too_large_a_buffer_is_a_typed_error() {
    let Some(gpu) = gpu() else { return };
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    let e = gpu.alloc::<u64>("huge", limit as usize / 8 + 1).unwrap_err();
    assert!(matches!(e, Error::Limit { limit: "max_storage_buffer_binding_size", .. }), "{e}");
}

#[test]
fn an_unknown_adapter_is_a_typed_error_that_lists_what_there_is() {
    let e = open(BackendChoice::Auto, Some("no such adapter")).unwrap_err();
    assert!(matches!(e, Error::NoSuchDevice { .. }), "{e}");
    for line in list_adapters(BackendChoice::Auto, None).unwrap() {
        assert!(e.to_string().contains(&line.info.name), "{e}");
    }
}

#[test]
fn a_poor_device_is_refused_and_a_destroyed_one_fails_typed() {
    let Some(gpu) = gpu() else { return };
    gpu.device.destroy();
    let result = gpu.upload("data", &[1u32, 2, 3]).and_then(|v| gpu.read(&v));
    assert!(matches!(result, Err(Error::DeviceLost { .. })), "{result:?}");
    // A new device works as before.
    let open = open(BackendChoice::Auto, None).unwrap();
    let limits = open.device.limits();
    assert!(limits.max_storage_buffers_per_shader_stage >= 8);
    let _: wgpu::Limits = Gpu::required_limits();
    Gpu::new(&open.device, &open.queue).unwrap();
}

// ---------------------------------------------------------------------------------------------
// Passes against their twins
// ---------------------------------------------------------------------------------------------

/// Sizes that every pass is tried at.
const FEW: [usize; 6] = [0, 1, 63, 64, 65, 10_007];
/// 65,536 workgroups, one more than a dispatch may have; with 32-byte records just 128 MiB.
const MANY: usize = 65_536 * 64;
/// What is larger than this repeats a few points, and gets few samples.
const REPEATS: usize = 100_000;

/// [`MANY`] items less a ragged few, still beyond 65,535 workgroups; or, where a binding of that many
/// records of `bytes` is more than the device has, as many as it holds. That a dispatch is cut well
/// beyond the limit, whatever the kernel, is what `dispatches_reach_every_item_once` shows.
fn many(gpu: &Gpu, bytes: usize) -> usize {
    let limits = gpu.device.limits();
    let fits = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) as usize / bytes;
    let n = MANY.min(fits) - 30;
    eprintln!("{n} items of {bytes} bytes, {} workgroups", n.div_ceil(64));
    n
}

/// A quad as two triangles.
fn quad(out: &mut Vec<([[f64; 3]; 3], u32)>, a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3], material: u32) {
    out.push(([a, b, c], material));
    out.push(([a, c, d], material));
}

/// A room open at one side, with a lamp, a block on its floor and a floating sheet: rays meet front
/// faces, back faces and the sky, and there is floor that nothing sees.
fn room_scene() -> Scene {
    let mut t = Vec::new();
    // Floor, ceiling, back and side walls face inwards; y = -1 is open.
    quad(&mut t, [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], 0);
    quad(&mut t, [-1.0, -1.0, 2.0], [-1.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, -1.0, 2.0], 0);
    quad(&mut t, [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0], 0);
    quad(&mut t, [-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, 1.0, 2.0], [-1.0, -1.0, 2.0], 1);
    quad(&mut t, [1.0, -1.0, 0.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [1.0, 1.0, 0.0], 2);
    // The lamp faces down.
    quad(&mut t, [-0.3, -0.2, 1.98], [-0.3, 0.3, 1.98], [0.3, 0.3, 1.98], [0.3, -0.2, 1.98], 3);
    // A block without a bottom: the floor below it is covered.
    let (l, h) = ([-0.5, 0.1, 0.0], [0.1, 0.7, 0.8]);
    quad(&mut t, [l[0], l[1], h[2]], [h[0], l[1], h[2]], [h[0], h[1], h[2]], [l[0], h[1], h[2]], 0);
    quad(&mut t, [l[0], l[1], l[2]], [h[0], l[1], l[2]], [h[0], l[1], h[2]], [l[0], l[1], h[2]], 0);
    quad(&mut t, [h[0], h[1], l[2]], [l[0], h[1], l[2]], [l[0], h[1], h[2]], [h[0], h[1], h[2]], 0);
    quad(&mut t, [l[0], h[1], l[2]], [l[0], l[1], l[2]], [l[0], l[1], h[2]], [l[0], h[1], h[2]], 0);
    quad(&mut t, [h[0], l[1], l[2]], [h[0], h[1], l[2]], [h[0], h[1], h[2]], [h[0], l[1], h[2]], 0);
    // A sheet that faces up only.
    quad(&mut t, [0.4, -0.6, 0.5], [0.9, -0.6, 0.5], [0.9, 0.2, 0.6], [0.4, 0.2, 0.6], 1);
    let material = Material::new;
    let materials = vec![
        material("white", [0.75, 0.75, 0.72], [0.0; 3]),
        material("red", [0.6, 0.05, 0.05], [0.0; 3]),
        material("green", [0.1, 0.5, 0.1], [0.0; 3]),
        material("lamp", [0.3; 3], [17.0, 12.0, 4.0]),
    ];
    Scene::from_triangles("room", &t, materials).unwrap()
}

fn room() -> Geometry {
    Geometry::new(&room_scene()).unwrap()
}

/// Uniform start tiles over all area.
fn tiles(g: &Geometry) -> Vec<Tile> {
    let mut sum = 0.0;
    (0..g.tiles as usize)
        .map(|t| {
            sum += g.tile_area(t) / g.area;
            let cdf = if t + 1 == g.tiles as usize { u32::MAX } else { (sum * 4294967296.0).min(4294967295.0) as u32 };
            Tile { cdf, density: (1.0 / g.area) as f32 }
        })
        .collect()
}

/// Rays of the room by the twin, `points` ends of them, and what is known about those.
struct Case {
    geometry: Geometry,
    surface: Surface,
    points: Vec<Point>,
    psi: Vec<Psi>,
    features: Vec<Feature>,
}

const METRIC: Metric = Metric { inv_unit: 0.7, lambda: 0.3, mu: 0.3 };

fn case(points: usize) -> Case {
    if points > REPEATS {
        let c = case(10_007);
        // An even number of points is repeated, so that rays stay whole.
        fn repeat<T: Copy>(of: &[T], n: usize) -> Vec<T> {
            of.iter().cycle().take(n.next_multiple_of(2)).copied().collect()
        }
        return Case {
            points: repeat(&c.points, points),
            psi: repeat(&c.psi, points),
            features: repeat(&c.features, points),
            ..c
        };
    }
    let geometry = room();
    let tiles = tiles(&geometry);
    let density = vec![1.0; geometry.tiles as usize];
    let surface = place_nodes(
        &mut TwinEngine::new(&geometry),
        &geometry,
        &density,
        300,
        0.3,
        5,
        true,
        &mut Progress::new(&mut |_| Flow::Continue),
    )
    .unwrap();
    let rays = points.div_ceil(2) as u32;
    let mut points_ = twin::emit::emit(&geometry, &tiles, 11, 0, rays, rays.max(1));
    points_.truncate(points.next_multiple_of(2));
    let psi = twin::assign::assign(&geometry, &surface, &points_);
    let features = twin::winner::feature(&geometry, METRIC, &brightness(&geometry), &points_);
    Case { geometry, surface, points: points_, psi, features }
}

fn brightness(g: &Geometry) -> Vec<f32> {
    (0..g.tiles).map(|t| (t % 17) as f32 * 0.25).collect()
}

/// |a - b| within an absolute and a relative tolerance.
fn close(a: f32, b: f32, abs: f32, rel: f32) -> bool {
    (a - b).abs() <= abs + rel * a.abs().max(b.abs())
}

/// Share of the pairs that differ. A ray that grazes an edge, or a sum that rounds the other way, may
/// fall out differently where multiply-adds are contracted; on lavapipe none does.
fn share<T>(a: &[T], b: &[T], same: impl Fn(&T, &T) -> bool) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| !same(a, b)).count() as f64 / a.len().max(1) as f64
}

fn same_point(a: &Point, b: &Point) -> bool {
    (a.kind, a.tri, a.tile) == (b.kind, b.tri, b.tile)
        && (0..3).all(|k| close(a.p[k], b.p[k], 2e-6, 1e-6))
        && close(a.weight, b.weight, 1e-12, 1e-4)
        && close(a.density, b.density, 0.0, 1e-6)
}

fn same3(a: &[f32], b: &[f32]) -> bool {
    (0..3).all(|k| close(a[k], b[k], 1e-6, 1e-4))
}

#[test]
fn emit_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    let g = room();
    let scene = SceneBuffers::new(&gpu, &g).unwrap();
    let tiles = tiles(&g);
    let device_tiles = gpu.upload("tiles", &tiles).unwrap();
    // A ray is two points: in 128 MiB fit 2,097,152 rays, 32,768 workgroups.
    for n in FEW.into_iter().chain([many(&gpu, 64)]) {
        let want = twin::emit::emit(&g, &tiles, 3, 77, n as u32, 10_007);
        let got = gpu.read(&pass::emit::emit(&gpu, &scene, &device_tiles, 3, 77, n as u32, 10_007).unwrap()).unwrap();
        gpu.check_finished().unwrap();
        assert!(share(&want, &got, same_point) <= 1e-3, "{n}: {}", share(&want, &got, same_point));
        if n > 1_000 {
            for k in [kind::DEAD, kind::FRONT, kind::SKY, kind::BACK] {
                assert!(want.iter().any(|p| p.kind == k), "the scene shows every kind of ray, also {k}");
            }
        }
    }
}

#[test]
fn shoot_and_gather_equal_their_twins() {
    let Some(gpu) = gpu() else { return };
    // 65,536 workgroups fit 128 MiB.
    for n in FEW.into_iter().chain([many(&gpu, 32)]) {
        let c = case(n);
        let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
        let points = gpu.upload("points", &c.points).unwrap();
        let rays = if n > REPEATS { 1 } else { 5 };
        let want = twin::shoot::shoot(&c.geometry, &c.points, 9, 2, rays);
        let hits = pass::shoot::shoot(&gpu, &scene, &points, 9, 2, rays).unwrap();
        let got = gpu.read(&hits).unwrap();
        assert!(share(&want, &got, same_point) <= 1e-3, "{n}: {}", share(&want, &got, same_point));

        // Gather from the twin's hits, dark and lit.
        let hits = gpu.upload("hits", &want).unwrap();
        let light: Vec<[f32; 4]> = (0..want.len()).map(|i| [0.1, 0.01 * (i % 7) as f32, 2.0, 0.0]).collect();
        let direct: Vec<DirectSum> = (0..want.len())
            .map(|i| DirectSum { sum: [1.0, 2.0, (i % 5) as f32], rounds: (i % 3) as u32, ..DirectSum::default() })
            .collect();
        let (device_light, device_direct) = (gpu.upload("light", &light).unwrap(), gpu.upload("direct", &direct).unwrap());
        for (lit, exact) in [(false, false), (true, false), (true, true)] {
            let want = twin::gather::gather(
                &c.geometry,
                &want,
                if lit { &light } else { &[] },
                exact.then_some(direct.as_slice()),
                rays,
            );
            let got =
                pass::gather::gather(&gpu, &scene, &hits, lit.then_some(&device_light), exact.then_some(&device_direct), rays)
                    .unwrap();
            let got = pass::gather::decode(&gpu.read(&got).unwrap());
            let same = |a: &Gathered, b: &Gathered| {
                same3(&a.irradiance, &b.irradiance)
                    && close(a.square, b.square, 1e-6, 1e-4)
                    && close(a.nearness, b.nearness, 1e-6, 1e-4)
                    && close(a.front, b.front, 1e-6, 0.0)
                    && close(a.back, b.back, 1e-6, 0.0)
            };
            assert_eq!(share(&want, &got, same), 0.0, "{n}");
        }
        gpu.check_finished().unwrap();
    }
}

#[test]
fn kernel_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    // A pair is two points: in 128 MiB fit 2,097,152 pairs, 32,768 workgroups.
    for n in FEW.into_iter().chain([many(&gpu, 64)]) {
        // Pairs of unrelated points: some see each other, some do not.
        let c = case(2 * n);
        let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
        let mut points = c.points;
        let half = points.len() / 2;
        for i in (1..half).step_by(2) {
            points.swap(i, 2 * half - i);
        }
        let want = twin::kernel::kernel(&c.geometry, &points);
        let got = pass::kernel::kernel(&gpu, &scene, &gpu.upload("points", &points).unwrap()).unwrap();
        let got = gpu.read(&got).unwrap();
        gpu.check_finished().unwrap();
        assert!(share(&want, &got, |a, b| close(*a, *b, 1e-12, 1e-4)) <= 1e-3, "{n}");
        assert!(n < 1000 || want.iter().filter(|&&g| g > 0.0).count() > n / 20);
    }
}

#[test]
fn direct_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    // 65,536 workgroups fit 128 MiB.
    for n in FEW.into_iter().chain([many(&gpu, 32)]) {
        let c = case(n);
        let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
        let points = gpu.upload("points", &c.points).unwrap();
        // Two out of three points, two calls of several rounds; or all points, a round of one sample each.
        let large = n > REPEATS;
        let active: Vec<u32> = (0..c.points.len() as u32).filter(|i| large || i % 3 != 1).collect();
        let samples = if large { Samples { emitter: 1, cosine: 1 } } else { Samples { emitter: 3, cosine: 2 } };
        let calls: &[(u32, u32)] = if large { &[(2, 1)] } else { &[(0, 4), (4, 7)] };
        let mut want = vec![DirectSum::default(); c.points.len()];
        let sums = gpu.alloc("sums", c.points.len()).unwrap();
        let device_active = gpu.upload("active", &active).unwrap();
        for &(first, rounds) in calls {
            twin::direct::direct(&c.geometry, &c.points, &active, 21, first, rounds, samples, &mut want);
            pass::direct::direct(&gpu, &scene, &points, &device_active, 21, first, rounds, samples, &sums).unwrap();
        }
        let got = gpu.read(&sums).unwrap();
        gpu.check_finished().unwrap();
        let same =
            |a: &DirectSum, b: &DirectSum| a.rounds == b.rounds && same3(&a.sum, &b.sum) && close(a.square, b.square, 1e-6, 1e-4);
        // A point takes up to 55 rays, each with its own chance of grazing an edge.
        assert!(share(&want, &got, same) <= 1e-2, "{n}: {}", share(&want, &got, same));
    }
}

#[test]
fn assign_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    // 65,536 workgroups fit 128 MiB.
    for n in FEW.into_iter().chain([many(&gpu, 32)]) {
        let c = case(n);
        let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
        let surface = SurfaceBuffers::new(&gpu, &c.surface).unwrap();
        let points = gpu.upload("points", &c.points).unwrap();
        // Any order gives the same.
        let order: Vec<u32> = (0..c.points.len() as u32).rev().collect();
        let order = gpu.upload("order", &order).unwrap();
        let got = gpu.read(&pass::assign::assign(&gpu, &scene, &surface, &points, &order).unwrap()).unwrap();
        gpu.check_finished().unwrap();
        let same = |a: &Psi, b: &Psi| a.node == b.node && (0..4).all(|k| close(a.weight[k], b.weight[k], 1e-5, 1e-4));
        assert!(share(&c.psi, &got, same) <= 1e-3, "{n}: {}", share(&c.psi, &got, same));
    }
}

#[test]
fn feature_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    // In 128 MiB fit 2,097,152 features, 32,768 workgroups.
    for n in FEW.into_iter().chain([many(&gpu, 64)]) {
        let c = case(n);
        let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
        let points = gpu.upload("points", &c.points).unwrap();
        let brightness = gpu.upload("brightness", &brightness(&c.geometry)).unwrap();
        let got = gpu.read(&pass::feature::feature(&gpu, &scene, METRIC, &brightness, &points).unwrap()).unwrap();
        let same = |a: &Feature, b: &Feature| (0..16).all(|k| close(a[k], b[k], 1e-7, 1e-6));
        assert_eq!(share(&c.features, &got, same), 0.0, "{n}");
    }
}

/// Features that are cheap to make: a few distinct numbers in each component, so that ties occur.
fn cheap_features(n: usize, seed: u32) -> Vec<Feature> {
    (0..n as u32)
        .map(|i| {
            std::array::from_fn(
                |k| {
                    if k < 13 { (twin::math::hash(seed ^ (i * 16 + k as u32)) % 5) as f32 * 0.25 - 0.5 } else { 0.0 }
                },
            )
        })
        .collect()
}

#[test]
fn winner_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    for (n, cells) in [(0, 5), (1, 1), (63, 64), (64, 3), (65, 0), (10_007, 321), (301, 40_000)] {
        let (features, centres) = (cheap_features(n, 1), cheap_features(cells, 2));
        let want = twin::winner::winner(&features, &centres);
        let device_features = gpu.upload("features", &features).unwrap();
        let device_cells = pass::winner::CellBlocks::new(&gpu, &centres).unwrap();
        let winners = gpu.upload("winners", &vec![7; n]).unwrap();
        let order = gpu.upload("order", &(0..n as u32).collect::<Vec<_>>()).unwrap();
        pass::winner::winner(&gpu, &device_features, &order, &device_cells, &winners).unwrap();
        assert_eq!(share(&want, &gpu.read(&winners).unwrap(), |a, b| a == b), 0.0, "{n} {cells}");

        // A part of the features, backwards, leaves the rest alone.
        if n > 60 {
            let winners = gpu.upload("winners", &vec![7; n]).unwrap();
            let order = gpu.upload("order", &(5..n as u32 - 6).rev().collect::<Vec<_>>()).unwrap();
            pass::winner::winner(&gpu, &device_features, &order, &device_cells, &winners).unwrap();
            let got = gpu.read(&winners).unwrap();
            assert_eq!(got[..5], [7; 5]);
            assert_eq!(got[n - 6..], [7; 6]);
            assert_eq!(got[5..n - 6], want[5..n - 6]);
        }
        gpu.check_finished().unwrap();
    }
}

/// A network of `n` cells at random places, each with the next three for neighbours.
fn outputs(n: usize) -> (Vec<CellOutput>, Vec<u32>, Vec<u32>) {
    let number = |i: u32| 2.0 * twin::math::unit(twin::math::hash(i ^ 0x5eed)) - 1.0;
    let one = |i: u32| CellOutput {
        slope: std::array::from_fn(|k| 0.1 * number(32 * i + k as u32)),
        value: number(32 * i + 13),
        width: 0.6 + 0.5 * number(32 * i + 14),
        pad0: 0.0,
    };
    let n = n as u32;
    let rows = (0..n).flat_map(|c| (1..4).map(move |k| (c + k) % n)).collect();
    ((0..n).map(one).collect(), (0..=n).map(|c| 3 * c).collect(), rows)
}

#[test]
fn respond_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    for n in FEW.into_iter().chain([many(&gpu, 64)]) {
        for linear in [false, true] {
            // Of many inputs most have no winner: they take no time.
            let (inputs, cells) = (cheap_features(n, 3), cheap_features(37, 4));
            let (outputs, offsets, neighbours) = outputs(cells.len());
            let net = Net { cells: &cells, outputs: &outputs, offsets: &offsets, neighbours: &neighbours, linear };
            let sample = |i: usize| {
                let h = twin::math::hash(i as u32);
                let winner = if h.is_multiple_of(9) || (n > REPEATS && !i.is_multiple_of(211)) { NONE } else { h % 37 };
                let goal = twin::math::unit(twin::math::hash(h)) - 0.5;
                Sample { winner, goal, weight: 1.0 + (h % 7) as f32, output: 7.0 }
            };
            let mut want: Vec<Sample> = (0..n).map(sample).collect();
            let device_inputs = gpu.upload("inputs", &inputs).unwrap();
            let device_samples = gpu.upload("samples", &want).unwrap();
            let sums = twin::respond::respond(net, &inputs, &mut want);
            let device_sums = pass::respond::respond(&gpu, net, &device_inputs, &device_samples).unwrap();
            let got = gpu.read(&device_samples).unwrap();
            let got_sums = gpu.read(&device_sums).unwrap();
            gpu.check_finished().unwrap();
            // exp is good to a few units in the last place of its argument, which is below 90 here.
            let same = |a: &Sample, b: &Sample| {
                (a.winner, a.goal, a.weight) == (b.winner, b.goal, b.weight) && close(a.output, b.output, 1e-6, 1e-4)
            };
            assert_eq!(share(&want, &got, same), 0.0, "{n} {linear}");
            let near = |a: Fixed, b: Fixed, terms: f64| {
                let (a, b) = (a.value(FEATURE_UNIT), b.value(FEATURE_UNIT));
                (a - b).abs() <= 1e-4 * (1.0 + terms)
            };
            for (a, b) in sums.iter().zip(&got_sums) {
                // Sums of what the host gave are exact; the others differ by what the exponentials do, a term each.
                assert_eq!((a.feature, a.count, a.share), (b.feature, b.count, b.share));
                let terms = sums.iter().map(|s| s.activation.value(FEATURE_UNIT)).sum::<f64>() / 10.0;
                assert!(near(a.error, b.error, terms) && near(a.gain, b.gain, terms) && near(a.activation, b.activation, terms));
            }
        }
    }
}

#[test]
fn winner_serves_more_than_65_535_workgroups() {
    let Some(gpu) = gpu() else { return };
    // An invocation serves eight features, more than fit a binding at once; so the order names the first
    // one again and again, and each of the others once, spread over all of it: 65,536 workgroups.
    let (features, centres) = (cheap_features(many(&gpu, 64), 1), cheap_features(8, 2));
    let mut order = vec![0u32; 8 * MANY - 100];
    let stride = order.len() / features.len();
    for j in 0..features.len() {
        order[stride * j + j % stride] = j as u32;
    }
    let want = twin::winner::winner(&features, &centres);
    let device_features = gpu.upload("features", &features).unwrap();
    let device_cells = pass::winner::CellBlocks::new(&gpu, &centres).unwrap();
    let winners = gpu.upload("winners", &vec![77; features.len()]).unwrap();
    let order = gpu.upload("order", &order).unwrap();
    pass::winner::winner(&gpu, &device_features, &order, &device_cells, &winners).unwrap();
    gpu.check_finished().unwrap();
    assert!(want == gpu.read(&winners).unwrap());
}

#[test]
fn winner_is_nearest_and_the_first_of_equals() {
    let Some(gpu) = gpu() else { return };
    let run = |features: &[Feature], cells: &[Feature]| {
        // Like receivers follow each other, as in a bake.
        let mut order: Vec<u32> = (0..features.len() as u32).collect();
        let key = |&i: &u32| ((features[i as usize][6] * 100.0).floor(), features[i as usize][7]);
        order.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap());
        let (device_features, order) = (gpu.upload("features", features).unwrap(), gpu.upload("order", &order).unwrap());
        let cells = pass::winner::CellBlocks::new(&gpu, cells).unwrap();
        let winners = gpu.upload("winners", &vec![7_777_777; features.len()]).unwrap();
        pass::winner::winner(&gpu, &device_features, &order, &cells, &winners).unwrap();
        gpu.check_finished().unwrap();
        gpu.read(&winners).unwrap()
    };
    // Numbers of all kinds; receivers lie on a sheet that is rather flat.
    let scattered = |n: usize, seed: u32| -> Vec<Feature> {
        let number = |i: u32| 2.0 * twin::math::unit(twin::math::hash(seed ^ twin::math::hash(i))) - 1.0;
        let wide = |k: usize| if k == 6 || k == 7 { 1.0 } else { 0.1 };
        (0..n as u32).map(|i| std::array::from_fn(|k| if k < 13 { wide(k) * number(16 * i + k as u32) } else { 0.0 })).collect()
    };
    let distance = |a: &Feature, b: &Feature| (0..13).map(|k| a[k] as f64 - b[k] as f64).map(|e| e * e).sum::<f64>().sqrt();
    for cells in [1usize, 2, 63, 64, 65, 1_000, 100_000] {
        // Every cell finds itself, the last one too; of three in one place it is the first.
        for distinct in [cells, cells.div_ceil(3)] {
            let centres: Vec<Feature> = scattered(distinct, 3).iter().cycle().take(cells).copied().collect();
            let got = run(&centres, &centres);
            for (i, &c) in got.iter().enumerate() {
                assert_eq!(c as usize, i % distinct, "{cells} {distinct}: {i}");
            }
        }

        // What is found is nearest up to rounding, also among cells that are a last bit apart.
        let features = scattered(301, 1);
        for distinct in [cells, cells.div_ceil(3)] {
            let mut centres: Vec<Feature> = scattered(distinct, 2).iter().cycle().take(cells).copied().collect();
            for (i, centre) in centres.iter_mut().enumerate() {
                let x = &mut centre[i % 13];
                *x = f32::from_bits(x.to_bits() + (i / distinct) as u32);
            }
            let got = run(&features, &centres);
            for (f, &c) in features.iter().zip(&got) {
                let least = centres.iter().map(|w| distance(f, w)).fold(f64::MAX, f64::min);
                let d = distance(f, &centres[c as usize]);
                assert!(d <= least * (1.0 + 16.0 * 2f64.powi(-24)), "{cells} {distinct}: {d} {least}");
            }
        }
    }
}

#[test]
fn accumulate_and_adapt_equal_their_twins() {
    let Some(gpu) = gpu() else { return };
    // In 128 MiB fit 2,097,152 features, 32,768 workgroups.
    for n in FEW.into_iter().chain([many(&gpu, 64)]) {
        let c = case(n);
        let centres = cheap_features(50, 3);
        let winners = match n {
            0..=REPEATS => twin::winner::winner(&c.features, &centres),
            _ => (0..c.points.len() as u32).map(|i| twin::math::hash(i) % 51).map(|c| if c < 50 { c } else { NONE }).collect(),
        };
        let want = twin::accumulate::accumulate(&c.points, &c.features, &winners, &centres);
        let points = gpu.upload("points", &c.points).unwrap();
        let features = gpu.upload("features", &c.features).unwrap();
        let winners = gpu.upload("winners", &winners).unwrap();
        let cells = gpu.upload("cells", &centres).unwrap();
        let sums = pass::accumulate::accumulate(&gpu, &points, &features, &winners, 0..c.points.len(), &cells).unwrap();
        let got = gpu.read(&sums).unwrap();
        for (w, g) in want.iter().zip(&got) {
            // Features are summed as they are, bit for bit; distances may be contracted.
            assert_eq!((w.feature, w.count), (g.feature, g.count), "{n}");
            let (a, b) = (w.distortion.units() as f64, g.distortion.units() as f64);
            assert!((a - b).abs() <= 1e-5 * a, "{n}: {a} {b}");
        }

        // As few cells as there are; and, once, as many as can be: in 128 MiB fit 1,048,576 sums of 128
        // bytes, 16,384 workgroups. Both ends of a ring and cells far away are neighbours; one cell has none.
        for m in [50].into_iter().chain((n > REPEATS).then(|| many(&gpu, size_of::<CellSums>()))) {
            let centres: Vec<Feature> = centres.iter().cycle().take(m).copied().collect();
            let sums: Vec<CellSums> = got.iter().cycle().take(m).copied().collect();
            let m = m as u32;
            let offsets: Vec<u32> = (0..=m).map(|i| 2 * i.min(m - 1)).collect();
            let neighbours: Vec<u32> = (0..m - 1).flat_map(|i| [(i + 1) % m, twin::math::hash(i) % m]).collect();
            let (device_cells, device_sums) = (gpu.upload("cells", &centres).unwrap(), gpu.upload("sums", &sums).unwrap());
            let (device_offsets, device_neighbours) =
                (gpu.upload("offsets", &offsets).unwrap(), gpu.upload("neighbours", &neighbours).unwrap());
            for eta in [0.0, 0.05] {
                let want = twin::adapt::adapt(&centres, &sums, &offsets, &neighbours, eta);
                let moved =
                    pass::adapt::adapt(&gpu, &device_cells, &device_sums, &device_offsets, &device_neighbours, eta).unwrap();
                let same = |a: &Feature, b: &Feature| (0..16).all(|k| close(a[k], b[k], 1e-6, 1e-5));
                assert_eq!(share(&want, &gpu.read(&moved).unwrap(), same), 0.0, "{n} {m}");
            }
        }
        gpu.check_finished().unwrap();
    }
}

#[test]
fn coefficients_equal_their_twin() {
    let Some(gpu) = gpu() else { return };
    // 65,536 workgroups fit 128 MiB. There, each of 278 cells meets the same 18 rays again and again.
    for (n, cells) in [(0, 3), (1, 1), (63, 9), (64, 9), (65, 9), (10_007, 300), (10_007, 4), (many(&gpu, 32), 278)] {
        let c = case(n);
        let winners: Vec<u32> =
            (0..c.points.len() as u32).map(|i| if i % 31 == 5 { NONE } else { i / 2 % cells as u32 }).collect();
        let direct: Vec<DirectSum> = (0..c.points.len())
            .map(|i| DirectSum { sum: [0.5, 0.25, (i % 5) as f32 * 0.1], rounds: 1 + i as u32 % 3, ..DirectSum::default() })
            .collect();
        let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
        let surface = SurfaceBuffers::new(&gpu, &c.surface).unwrap();
        let points = gpu.upload("points", &c.points).unwrap();
        let psi = gpu.upload("psi", &c.psi).unwrap();
        let device_winners = gpu.upload("winners", &winners).unwrap();
        let device_direct = gpu.upload("direct", &direct).unwrap();
        // All rays together weigh as much, however often they are repeated.
        let normalise = (0.3 / c.geometry.area / (n as f64 / 10_007.0).max(1.0)) as f32;
        let batches = if n > REPEATS { 1 } else { 2 };
        for exact in [false, true].into_iter().skip(2 - batches) {
            let mut want = twin::coefficients::Sums::default();
            // Twice the same batch: batches add up. Four cells see more nodes than a row starts with.
            for _ in 0..batches {
                want.merge(twin::coefficients::coefficients(
                    &c.geometry,
                    &c.surface,
                    &c.points,
                    &c.psi,
                    &winners,
                    exact.then_some(direct.as_slice()),
                    normalise,
                    n as f32,
                    cells,
                ));
            }
            let rays = pass::coefficients::Rays {
                points: &points,
                psi: &psi,
                winners: &device_winners,
                direct: exact.then_some(&device_direct),
            };
            let got = pass::coefficients::coefficients(
                &gpu,
                &scene,
                &surface,
                &[rays, rays][..batches],
                normalise,
                n as f32,
                cells,
                &mut || Ok(()),
            )
            .unwrap();
            gpu.check_finished().unwrap();

            // Integer sums of the same floats; a contracted product may differ in its last bit.
            let near = |a: Fixed, b: Fixed| (a.units() - b.units()).abs() <= (a.units().abs() >> 16) + (1 << 34);
            let rows = |a: &[Vec<Slot>], b: &[Vec<Slot>]| {
                assert_eq!((a.len(), b.len()), (cells, cells));
                for (a, b) in a.iter().zip(b) {
                    let same = |a: &Slot, b: &Slot| {
                        a.key == b.key && near(a.value, b.value) && near(a.first, b.first) && near(a.second, b.second)
                    };
                    assert_eq!(share(a, b, same), 0.0, "{n} {cells}");
                }
            };
            rows(&want.gather, &got.gather);
            rows(&want.deposit, &got.deposit);
            let flux = |a: &CellFlux, b: &CellFlux| near(a.flux, b.flux) && (0..3).all(|k| near(a.source[k], b.source[k]));
            assert_eq!(share(&want.flux, &got.flux, flux), 0.0, "{n} {cells}");
            let nodes = |a: &NodeSums, b: &NodeSums| {
                near(a.mass, b.mass)
                    && near(a.square, b.square)
                    && (0..2).all(|k| near(a.first[k], b.first[k]))
                    && (0..3).all(|k| near(a.second[k], b.second[k]))
            };
            assert_eq!(share(&want.nodes, &got.nodes, nodes), 0.0, "{n} {cells}");
        }
    }
}

#[test]
fn fixed_point_words_equal_their_twin() {
    let Some(gpu) = gpu() else { return };
    // Numbers of every size through the flux kernel: a ray each, one cell each.
    let c = case(2);
    let scene = SceneBuffers::new(&gpu, &c.geometry).unwrap();
    let surface = SurfaceBuffers::new(&gpu, &c.surface).unwrap();
    let mut start = *c.points.iter().find(|p| p.tri != NONE).unwrap();
    start.kind = kind::FRONT;
    let weights: Vec<f32> = (0..2_000u32)
        .map(|i| f32::from_bits(twin::math::hash(i) & 0x007f_ffff | (30 + i % 100) << 23))
        .filter(|w| *w < 15.0)
        .collect();
    let points: Vec<Point> =
        weights.iter().flat_map(|&weight| [Point { weight, ..start }, Point { weight: 0.0, ..start }]).collect();
    let psi = vec![Psi::EMPTY; points.len()];
    let winners: Vec<u32> = (0..points.len() as u32).map(|d| d / 2).collect();
    let cells = weights.len();
    let want = twin::coefficients::coefficients(&c.geometry, &c.surface, &points, &psi, &winners, None, 1.0, 1.0, cells);
    let (points, psi) = (gpu.upload("points", &points).unwrap(), gpu.upload("psi", &psi).unwrap());
    let winners = gpu.upload("winners", &winners).unwrap();
    let rays = pass::coefficients::Rays { points: &points, psi: &psi, winners: &winners, direct: None };
    let got = pass::coefficients::coefficients(&gpu, &scene, &surface, &[rays], 1.0, 1.0, cells, &mut || Ok(())).unwrap();
    for i in 0..cells {
        assert_eq!(want.flux[i].flux, got.flux[i].flux, "{} {:x}", weights[i], weights[i].to_bits());
    }
}

#[test]
fn jacobi_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    // In colour, and all grey: one band, to the bits of three.
    for grey in [false, true] {
        let mut g = room();
        if grey {
            g.materials.iter_mut().for_each(|m| m.rho = [m.rho[0]; 3]);
        }
        jacobi_equals_its_twin_in(&gpu, &g, grey);
    }
}

fn jacobi_equals_its_twin_in(gpu: &Gpu, g: &Geometry, grey: bool) {
    let scene = SceneBuffers::new(gpu, g).unwrap();
    for (cells, nodes) in [(0, 0), (1, 1), (63, 65), (64, 64), (65, 63), (10_007, 501), (MANY, 1000), (1000, MANY / 2)] {
        // A few links a cell and a node, small enough to contract.
        let number = |i: usize| (twin::math::hash(i as u32) % 1000) as f32 * 1e-4;
        let links = |rows: usize, others: usize, a_row: usize| {
            let count = |r: usize| if others == 0 { 0 } else { (r + 1) % a_row };
            let mut offsets = vec![0u32];
            let mut links = Vec::new();
            for r in 0..rows {
                for k in 0..count(r) {
                    let i = r * 8 + k;
                    let other = twin::math::hash(i as u32 ^ 77) % others as u32;
                    links.push(Link { other, value: number(i), first: number(i + 1) * 0.1, second: -number(i + 2) * 0.1 });
                }
                offsets.push(links.len() as u32);
            }
            (offsets, links)
        };
        let (cell_offsets, cell_links) = links(cells, nodes, 4);
        let (node_offsets, node_links) = links(nodes, cells, 8);
        let system = System {
            cell_offsets,
            cell_links,
            source: (0..cells).map(|c| if grey { [number(c); 4] } else { [number(c), number(c + 5), 0.0, 0.0] }).collect(),
            node_offsets,
            node_links,
            planes: (0..nodes).map(|j| Plane { i11: 0.5, i12: -0.1, i22: 0.7, material: j as u32 % 4 }).collect(),
            node_source: (0..nodes)
                .map(|j| NodeLight { h: [number(j + 9); 3], g0: [0.1; 3], g1: [-number(j); 3], ..NodeLight::default() })
                .collect(),
            // Nodes of their own reflectance, or of the scene's.
            materials: match nodes % 2 == 1 {
                true => {
                    (0..nodes).map(|j| raycell::layout::Material { rho: [number(j) * 9.0; 3], ..Default::default() }).collect()
                }
                false => Vec::new(),
            },
        };
        let light: Vec<NodeLight> = (0..nodes).map(|j| NodeLight { h: [number(j); 3], ..NodeLight::default() }).collect();
        let sweeps = if cells + nodes > 100_000 { 2 } else { 37 };
        let want = twin::jacobi::jacobi(&system, &g.materials, &light, sweeps);
        let device_system = pass::jacobi::SystemBuffers::new(gpu, &system, grey).unwrap();
        let got = pass::jacobi::jacobi(gpu, &scene, &device_system, &light, sweeps).unwrap();
        gpu.check_finished().unwrap();
        let same = |a: &NodeLight, b: &NodeLight| same3(&a.h, &b.h) && same3(&a.g0, &b.g0) && same3(&a.g1, &b.g1);
        assert_eq!(share(&want, &got, same), 0.0, "{cells} {nodes} {grey}");
        // One band is a quarter of three, whose fourth word lies idle.
        let whole = 2 * (16 * cells + 48 * nodes) as u64;
        assert_eq!(device_system.band_bytes(), if grey { whole / 4 } else { whole });
    }
}

#[test]
fn deposit_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    let base = case(10_007);
    let scene = SceneBuffers::new(&gpu, &base.geometry).unwrap();
    let surface = SurfaceBuffers::new(&gpu, &base.surface).unwrap();
    for n in FEW.into_iter().map(|n| 2 * n).chain([MANY]) {
        // Many rays repeat a few; the sums are integers, so their order does not show.
        let points: Vec<Point> = base.points.iter().cycle().take(n).copied().collect();
        let psi: Vec<Psi> = base.psi.iter().cycle().take(n).copied().collect();
        let direct: Vec<DirectSum> = (0..n)
            .map(|i| DirectSum { sum: [0.5, 0.25, (i % 5) as f32 * 0.1], rounds: 1 + i as u32 % 3, ..DirectSum::default() })
            .collect();
        let light: Vec<[f32; 4]> = (0..n).map(|i| [0.1, 0.2, (i % 7) as f32 * 0.1, 0.0]).collect();
        let normalise = (0.3 / base.geometry.area / (n.max(1) as f64 / 10_007.0)) as f32;
        let device =
            (gpu.upload("points", &points).unwrap(), gpu.upload("psi", &psi).unwrap(), gpu.upload("direct", &direct).unwrap());
        let device_light = gpu.upload("light", &light).unwrap();
        for (exact, lit) in [(true, false), (true, true), (false, false), (false, true)] {
            let known = if lit { light.as_slice() } else { &[] };
            let sums = exact.then_some(direct.as_slice());
            let want = twin::deposit::deposit(&base.geometry, &base.surface, &points, &psi, sums, known, normalise);
            let sums = gpu.alloc("sums", base.surface.nodes.len()).unwrap();
            let (direct, light) = (exact.then_some(&device.2), lit.then_some(&device_light));
            pass::deposit::deposit(&gpu, &scene, &surface, &device.0, &device.1, direct, light, normalise, &sums).unwrap();
            let got = gpu.read(&sums).unwrap();
            // Where ends send no more than they emit, a few rays may all begin in the dark.
            let least = if exact || lit { 2 } else { 10_007 };
            assert!(n < least || want.iter().any(|s| s.value[0].units() != 0), "something arrives");
            // Integer sums of the same floats; a contracted product may differ in its last bit.
            let near = |a: Fixed, b: Fixed| (a.units() - b.units()).abs() <= (a.units().abs() >> 16) + (1 << 34);
            for (a, b) in want.iter().zip(&got) {
                for k in 0..3 {
                    assert!(near(a.value[k], b.value[k]), "{n} {exact} {lit}: {a:?} {b:?}");
                    assert!(near(a.first[k], b.first[k]) && near(a.second[k], b.second[k]), "{n} {exact} {lit}: {a:?} {b:?}");
                }
            }
        }
    }
}

#[test]
fn readout_equals_its_twin() {
    let Some(gpu) = gpu() else { return };
    let base = case(10_007);
    let surface = SurfaceBuffers::new(&gpu, &base.surface).unwrap();
    let light: Vec<NodeLight> = (0..base.surface.nodes.len())
        .map(|j| NodeLight { h: [1.0, 0.01 * j as f32, -0.5], g0: [0.3; 3], g1: [-0.7; 3], ..NodeLight::default() })
        .collect();
    let device_light = gpu.upload("light", &light).unwrap();
    for n in FEW.into_iter().chain([MANY]) {
        // Many points repeat a few.
        let points: Vec<Point> = base.points.iter().cycle().take(n).copied().collect();
        let psi: Vec<Psi> = base.psi.iter().cycle().take(n).copied().collect();
        let want = twin::readout::readout(&base.surface, &light, &points, &psi);
        let (points, psi) = (gpu.upload("points", &points).unwrap(), gpu.upload("psi", &psi).unwrap());
        let got = gpu.read(&pass::readout::readout(&gpu, &surface, &device_light, &points, &psi).unwrap()).unwrap();
        // By how much nodes disagree is what is left of squares of up to a thousand: where little is, it is rounded.
        let same = |a: &[f32; 4], b: &[f32; 4]| same3(a, b) && close(a[3], b[3], 1e-3 * (1.0 + a[1].abs()), 1e-4);
        assert_eq!(share(&want, &got, same), 0.0, "{n}");
        assert!(n < 2 || want.iter().any(|a| a[3] > 0.1), "{n}: all nodes agree");
    }
}

#[test]
fn same_seed_same_bytes() {
    let Some(gpu) = gpu() else { return };
    let g = room();
    let tiles = tiles(&g);
    let run = || {
        let mut engine = GpuEngine::new(&gpu, &g).unwrap();
        let mut batch = engine.emit(&tiles, 3, 0, 20_000, 20_000).unwrap();
        engine.feature(&mut batch, METRIC, &brightness(&g)).unwrap();
        let cells = cheap_features(20, 8);
        engine.winner(&mut batch, 0..40_000, &cells).unwrap();
        engine.accumulate(&batch, 0..40_000, &cells).unwrap()
    };
    // Many invocations add to few cells; the sums are integers, so their order does not show.
    assert_eq!(run(), run());
}

#[test]
fn a_whole_bake_equals_the_twins() {
    use raycell::solution::SurfacePoint;
    let Some(gpu) = gpu() else { return };
    let gpu = std::sync::Arc::new(gpu);
    let scene = room_scene();
    let params = Params { rays: 16_384, ..Params::default() };
    let points: Vec<SurfacePoint> = (0..200)
        .map(|i| {
            let u = twin::sobol::sobol4(i, 4);
            let at = |x: u32| 1.9 * twin::math::unit(x) as f64 - 0.95;
            match i % 3 {
                0 => SurfacePoint { p: [at(u[0]), at(u[1]), 0.0], n: [0.0, 0.0, 1.0] },
                1 => SurfacePoint { p: [at(u[0]), 1.0, 1.0 + at(u[1])], n: [0.0, -1.0, 0.0] },
                _ => SurfacePoint { p: [-1.0, at(u[0]), 1.0 + at(u[1])], n: [1.0, 0.0, 0.0] },
            }
        })
        .collect();
    let run = |backend: Backend| {
        let solution = bake(&backend, &scene, &params, &mut |_| Flow::Continue).unwrap();
        (solution.report().clone(), solution.query(&backend, &points).unwrap())
    };
    let (cpu, want) = run(Backend::Cpu);
    let (device, got) = run(Backend::Gpu(gpu));
    // The same bytes on lavapipe. Elsewhere a contracted multiply-add may send a ray to another cell, and
    // growth goes its own way from there: then both are solutions of equal worth.
    assert_eq!((cpu.cells, cpu.nodes, cpu.rays), (device.cells, device.nodes, device.rays));
    let norm: f64 = want.iter().map(|a| a.b[1] * a.b[1]).sum();
    let off: f64 = want.iter().zip(&got).map(|(a, b)| (a.b[1] - b.b[1]).powi(2)).sum();
    let off = (off / norm).sqrt();
    eprintln!("answers differ by {off:.1e}");
    assert!(norm > 0.0 && off < 0.03, "{off}");
}
