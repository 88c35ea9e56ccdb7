//! Whole bakes on a GPU (a software one counts) against what is known: path-traced truths, closed
//! forms, and each other.
//!
//! Without any adapter the tests pass with a note, unless `RAYCELL_REQUIRE_GPU` is set. Bakes are
//! shared between the tests; `cargo test --release --test bake -- --nocapture` shows the tables.

mod common;

use common::{gpu, radiosity, root, rrmse, truth};
use raycell::accuracy::norms::Errors;
use raycell::accuracy::truth::{Flag, Truth};
use raycell::gpu::Gpu;
use raycell::output::points;
use raycell::scene::shapes::{quad, sides};
use raycell::scene::{Geometry, Material};
use raycell::{Answer, Backend, Direct, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Instant;

/// A bake of a shipped scene and its answers at the truth's points.
struct Baked {
    solution: Solution,
    answers: Vec<Answer>,
}

/// What tells one bake from another.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Key {
    scene: &'static str,
    seed: u32,
    rays: u32,
    network: bool,
    cpu: bool,
    /// Bakes that must not be shared, to be compared with each other.
    again: bool,
}

/// A bake at default settings.
fn default(scene: &'static str) -> Key {
    Key { scene, seed: 1, rays: Params::default().rays, network: false, cpu: false, again: false }
}

/// The bake, made once. One at a time: each uses all of the machine.
fn baked(gpu: &Arc<Gpu>, key: Key) -> Arc<Baked> {
    type Bakes = HashMap<Key, Arc<Baked>>;
    static BAKES: OnceLock<Mutex<Bakes>> = OnceLock::new();
    let mut bakes = BAKES.get_or_init(Mutex::default).lock().unwrap_or_else(|e| e.into_inner());
    if let Some(baked) = bakes.get(&key) {
        return baked.clone();
    }
    let start = Instant::now();
    let backend = if key.cpu { Backend::Cpu } else { Backend::Gpu(gpu.clone()) };
    let scene = Scene::load(root(&format!("scenes/{}/scene.obj", key.scene))).unwrap();
    let solution = bake_with(&backend, &scene, &key);
    let answers = solution.query(&backend, &truth(key.scene).points).unwrap();
    eprintln!("{} (seed {}, {} rays): {:.1} s", key.scene, key.seed, key.rays, start.elapsed().as_secs_f64());
    let baked = Arc::new(Baked { solution, answers });
    bakes.insert(key, baked.clone());
    baked
}

fn bake_with(backend: &Backend, scene: &Scene, key: &Key) -> Solution {
    let direct = if key.network { Direct::Network } else { Direct::Exact };
    let params = Params { seed: key.seed, rays: key.rays, direct, ..Params::default() };
    bake(backend, scene, &params, &mut |_| Flow::Continue).unwrap()
}

fn mean(x: &[f64; 3]) -> f64 {
    (x[0] + x[1] + x[2]) / 3.0
}

fn sum(b: &[[f64; 3]]) -> f64 {
    b.iter().flatten().sum()
}

/// Limits of a scene: RRMSE, RRMSE without the worst 1 % of points, median relative error, |sum ratio - 1|.
const LIMITS: [(&str, bool, [f64; 4]); 7] = [
    ("furnace", false, [0.005, 0.005, 0.004, 0.002]),
    ("cornell", false, CORNELL),
    ("cornell_tess", false, CORNELL),
    ("blocker", false, [0.012, 0.008, 0.004, 0.005]),
    ("city", false, [0.045, 0.035, 0.03, 0.01]),
    ("corridor", false, [0.035, 0.03, 0.08, 0.01]),
    ("cornell", true, CORNELL_NETWORK),
];
const CORNELL: [f64; 4] = [0.024, 0.018, 0.009, 0.005];
const CORNELL_NETWORK: [f64; 4] = [0.06, 0.05, 0.021, 0.01];

#[test]
fn scenes_agree_with_their_truths() {
    let Some(gpu) = gpu() else { return };
    let mut table = String::from("\nscene                 RRMSE       without 1 %  median       p90     sum ratio - 1\n");
    let mut failed = Vec::new();
    for (scene, network, limits) in LIMITS {
        let truth = Truth::read(&root(&format!("tests/data/{scene}.truth.csv"))).unwrap();
        let baked = baked(&gpu, Key { network, ..default(scene) });
        let b = radiosity(&baked.answers);
        let e = Errors::new(&b, &truth);
        let got = [e.with_noise, e.trimmed, e.median, e.bias];
        let name = format!("{scene}{}", if network { " network" } else { "" });
        let cell = |k: usize| format!("{:6.2}/{:<5.1}", 100.0 * got[k], 100.0 * limits[k]);
        let p90 = 100.0 * e.p90;
        table += &format!("{name:20} {} {} {} {p90:6.2} {}  %\n", cell(0), cell(1), cell(2), cell(3));
        for k in 0..4 {
            if got[k].abs() > limits[k] {
                failed.push(format!("{name}: {:.4} > {}", got[k].abs(), limits[k]));
            }
        }
        let black = (0..b.len()).filter(|&i| truth.flags[i] == Flag::Good && mean(&b[i]) <= 0.0).count();
        if black > 0 {
            failed.push(format!("{name}: {black} black points"));
        }
    }
    eprintln!("{table}");
    assert!(failed.is_empty(), "{}\n{table}", failed.join("\n"));
}

#[test]
fn tessellation_does_not_matter() {
    let Some(gpu) = gpu() else { return };
    let [plain, tessellated] = ["cornell", "cornell_tess"].map(|scene| {
        let truth = truth(scene).b;
        (1..=3).map(|seed| rrmse(&radiosity(&baked(&gpu, Key { seed, ..default(scene) }).answers), &truth)).sum::<f64>() / 3.0
    });
    eprintln!("cornell {plain:.4}, cornell_tess {tessellated:.4}, means over 3 seeds");
    assert!((plain - tessellated).abs() <= 0.005, "{plain} {tessellated}");
}

#[test]
fn energy_is_accounted_for() {
    let Some(gpu) = gpu() else { return };
    for name in ["cornell", "blocker", "city"] {
        let baked = baked(&gpu, default(name));
        let energy = &baked.solution.report().energy;
        eprintln!("{name}: imbalance {:+.5}", energy.imbalance.unwrap());
        assert!(energy.imbalance.unwrap().abs() < 0.01, "{name}: {energy:?}");
        // What is emitted is no estimate.
        let scene = baked.solution.scene();
        let mut emitted = [0.0; 3];
        for (i, face) in scene.faces.iter().enumerate() {
            let [a, b, c] = scene.corners(i).map(glam::DVec3::from_array);
            let area = 0.5 * (b - a).cross(c - a).length();
            for k in 0..3 {
                emitted[k] += PI * scene.materials[face.material as usize].emission[k] * area;
            }
        }
        for (got, want) in energy.emitted.unwrap().iter().zip(emitted) {
            assert!((got / want - 1.0).abs() < 1e-6, "{name}: {got} {want}");
        }
    }
}

#[test]
fn the_same_seed_leaves_the_same_bytes() {
    let Some(gpu) = gpu() else { return };
    let dir = tempfile::tempdir().unwrap();
    let bytes = |key: Key| {
        let baked = baked(&gpu, key);
        let (csv, rcell) = (dir.path().join("points.csv"), dir.path().join("solution.rcell"));
        points::write(&csv, &truth("cornell").points, &baked.answers).unwrap();
        baked.solution.save(&rcell).unwrap();
        [csv, rcell].map(|path| std::fs::read(path).unwrap())
    };
    let once = bytes(default("cornell"));
    let again = bytes(Key { again: true, ..default("cornell") });
    let other = bytes(Key { seed: 2, ..default("cornell") });
    for k in 0..2 {
        assert!(once[k] == again[k], "file {k} differs");
        assert!(once[k] != other[k], "file {k} does not depend on the seed");
    }
}

/// Both backends draw the same rays. A rounding apart, a ray may meet another triangle or win another
/// cell, and training carries that on: where they differ, the other is a second draw of the same
/// estimator. So they differ by no more than two seeds do; measured against the scatter of three
/// pairs of seeds, with a quarter on top for the scatter of that.
#[test]
fn the_processor_and_the_gpu_agree() {
    let Some(gpu) = gpu() else { return };
    let few = Key { rays: 65_536, ..default("cornell") };
    let on = |seed: u32, cpu: bool| radiosity(&baked(&gpu, Key { seed, cpu, ..few.clone() }).answers);
    let [a, b, c] = [1, 2, 3].map(|seed| on(seed, false));
    let scatter = ((rrmse(&a, &b).powi(2) + rrmse(&b, &c).powi(2) + rrmse(&c, &a).powi(2)) / 3.0).sqrt();
    let apart = rrmse(&on(1, true), &a);
    eprintln!("twin and GPU {apart:.5} apart, seeds {scatter:.5}");
    assert!(apart <= 1.25 * scatter, "{apart} {scatter}");
    // In sum, too.
    let ratio = sum(&on(1, true)) / sum(&a) - 1.0;
    assert!(ratio.abs() < 0.005, "{ratio}");
}

fn materials() -> Vec<Material> {
    vec![
        Material::new("grey", [0.5, 0.6, 0.4], [0.0; 3]),
        Material::new("shining", [0.5, 0.6, 0.4], [1.0; 3]),
        Material::new("lamp", [0.0; 3], [10.0, 8.0, 6.0]),
    ]
}

/// A unit cube of which the half x < 1/2 shines: light and dark touch along whole walls, where direct
/// light has its steepest steps.
///
/// Each mode is held to its lines of the Cornell box (an RRMSE, a ratio of sums) by its truth, so two
/// answers within them differ by no more than the sum of both, by the triangle inequality. And a closed
/// cube of one reflectance rho absorbs what it emits: the mean of H over the walls is
/// (pi Ke/2)/(1 - rho) exactly, which each mode meets within its line for sums.
#[test]
fn exact_and_network_light_agree_in_a_half_lit_cube() {
    let Some(gpu) = gpu() else { return };
    let half = |low: f64, high: f64, m: u32, skip: usize| {
        let sides = sides([low, 0.0, 0.0], [high, 1.0, 1.0], [m; 6]);
        (0..6).filter(|&s| s != skip).flat_map(|s| sides[s].clone()).collect::<Vec<_>>()
    };
    let scene = Scene::from_triangles("cube", &[half(0.0, 0.5, 1, 1), half(0.5, 1.0, 0, 0)].concat(), materials()).unwrap();

    let mut points = Vec::new();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            for i in 0..64 {
                let (u, v) = ((i % 8) as f64 / 8.0 + 0.0625, (i / 8) as f64 / 8.0 + 0.0625);
                let (mut p, mut n) = ([0.0; 3], [0.0; 3]);
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, u, v);
                n[axis] = 1.0 - 2.0 * side;
                points.push(SurfacePoint { p, n });
            }
        }
    }
    let lines = [(false, CORNELL), (true, CORNELL_NETWORK)];
    let answers = lines.map(|(network, limits)| {
        let key = Key { network, rays: 131_072, ..default("cube") };
        let backend = Backend::Gpu(gpu.clone());
        let answers = bake_with(&backend, &scene, &key).query(&backend, &points).unwrap();
        for (k, rho) in materials()[0].reflectance.iter().enumerate() {
            let mean = answers.iter().map(|a| a.h[k]).sum::<f64>() / answers.len() as f64;
            let ratio = mean / (PI * 0.5 / (1.0 - rho));
            eprintln!("cube, network {network}: mean H, band {k}: {ratio:.5} of what must be");
            assert!((ratio - 1.0).abs() < limits[3], "network {network}: {ratio}");
        }
        radiosity(&answers)
    });
    let apart = rrmse(&answers[1], &answers[0]);
    eprintln!("cube: exact and network {apart:.4} apart");
    assert!(apart <= lines[0].1[0] + lines[1].1[0], "{apart}");
    let ratio = sum(&answers[1]) / sum(&answers[0]) - 1.0;
    assert!(ratio.abs() <= lines[0].1[3] + lines[1].1[3], "{ratio}");
}

#[test]
fn no_light_leaks_into_a_dark_room() {
    let Some(gpu) = gpu() else { return };
    // Two closed rooms, a wall of 0.1 between them, on one floor slab that runs through below it.
    let mut triangles = quad([[0.0; 3], [0.0, 0.0, 1.0], [2.1, 0.0, 1.0], [2.1, 0.0, 0.0]], 0);
    for (low, ceiling) in [(0.0, 2), (1.1, 0)] {
        let sides = sides([low, 0.0, 0.0], [low + 1.0, 1.0, 1.0], [0, 0, 0, ceiling, 0, 0]);
        triangles.extend((0..6).filter(|&s| s != 2).flat_map(|s| sides[s].clone()));
    }
    let scene = Scene::from_triangles("rooms", &triangles, materials()).unwrap();
    // Walls, floor and ceiling of a room, up to a hair from its edges.
    let points = |x: f64| {
        let places = [1e-4, 0.02, 0.3, 0.6, 0.97, 0.9999];
        let mut points = Vec::new();
        for (&u, &v) in places.iter().flat_map(|u| places.iter().map(move |v| (u, v))) {
            points.push(SurfacePoint { p: [x + u, 0.0, v], n: [0.0, 1.0, 0.0] });
            points.push(SurfacePoint { p: [x + u, 1.0, v], n: [0.0, -1.0, 0.0] });
            points.push(SurfacePoint { p: [x, u, v], n: [1.0, 0.0, 0.0] });
            points.push(SurfacePoint { p: [x + 1.0, u, v], n: [-1.0, 0.0, 0.0] });
            points.push(SurfacePoint { p: [x + u, v, 0.0], n: [0.0, 0.0, 1.0] });
        }
        points
    };
    for network in [false, true] {
        let backend = Backend::Gpu(gpu.clone());
        let solution = bake_with(&backend, &scene, &Key { network, rays: 65_536, ..default("rooms") });
        let dark = solution.query(&backend, &points(1.1)).unwrap();
        for (answer, point) in dark.iter().zip(points(1.1)) {
            assert!(answer.status != raycell::Status::OffSurface, "{point:?}");
            assert!(answer.b == [0.0; 3] && answer.h == [0.0; 3], "network {network}: {point:?} {answer:?}");
        }
        let lit = solution.query(&backend, &points(0.0)).unwrap();
        assert!(lit.iter().all(|a| a.b.iter().all(|b| *b > 0.0)), "network {network}");
    }
}

/// A flat shape to draw points from: its lower edge `from..to`, and either a side (a parallelogram) or
/// an apex (a triangle).
#[derive(Clone, Copy)]
struct Shape {
    from: glam::DVec3,
    to: glam::DVec3,
    top: glam::DVec3,
    triangle: bool,
}

impl Shape {
    /// The point of (t, s), s drawn towards the lower edge by `power`; and its weight, 1/density.
    fn at(&self, t: f64, s: f64, power: i32) -> (glam::DVec3, f64) {
        let h = s.powi(power);
        let stretch = power as f64 * s.powi(power - 1);
        let width = if self.triangle { 1.0 - h } else { 1.0 };
        let p = self.from + (self.to - self.from) * (t * width) + (self.top - self.from) * h;
        (p, (self.to - self.from).cross(self.top - self.from).length() * width * stretch)
    }

    fn normal(&self) -> [f64; 3] {
        (self.to - self.from).cross(self.top - self.from).normalize().to_array()
    }
}

#[test]
fn form_factors_are_met() {
    use raycell::engine::Engine;
    use raycell::layout::{Point, kind};
    use raycell::pass::{GpuEngine, SceneBuffers, kernel::kernel};
    use raycell::twin::{math::unit, sobol::sobol4};
    let Some(gpu) = gpu() else { return };
    let square = |from: [f64; 3], to: [f64; 3], top: [f64; 3]| Shape {
        from: from.into(),
        to: to.into(),
        top: top.into(),
        triangle: false,
    };
    // Both shapes' lower edges are the shared ones.
    let floor = square([0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 0.0, 0.0]);
    let wall = square([1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]);
    let ceiling = square([0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0]);
    let [a, b, c, d] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(glam::DVec3::from);
    let side = |from, to, top| Shape { from, to, top, triangle: true };
    // The sides of a tetrahedron, seen from inside.
    let sides = [side(b, a, c), side(a, b, d), side(c, a, d), side(b, c, d)];
    assert!(sides.iter().all(|s| s.from.dot(s.normal().into()) < 0.0));

    // Touching shapes: G has no second moment under uniform points, so they crowd at the edge with
    // density s^(-2/3), under which it has one.
    for (name, shapes, power, want) in [
        ("squares with a common edge", vec![floor, wall], 3, 0.20004377607540),
        ("sides of a tetrahedron", sides.to_vec(), 3, 1.0 / 3.0),
        ("opposed squares", vec![floor, ceiling], 1, 0.19982490),
    ] {
        let triangles: Vec<_> = shapes
            .iter()
            .flat_map(|s| {
                let [p, q, r] = [s.from, s.to, s.top].map(|v| v.to_array());
                let opposite = (s.to + s.top - s.from).to_array();
                if s.triangle { vec![([p, q, r], 0)] } else { quad([p, q, opposite, r], 0) }
            })
            .collect();
        let faces = triangles.len() / shapes.len();
        let scene = Scene::from_triangles(name, &triangles, materials()).unwrap();
        let geometry = Geometry::new(&scene).unwrap();
        let place = |p: glam::DVec3, s: &Shape| {
            let at = geometry.locate(p.to_array(), s.normal()).unwrap();
            Point { p: at.p, tri: at.tri, ..Point::default() }
        };
        let check = |how: &str, samples: &[f64]| {
            let n = samples.len() as f64;
            let mean = samples.iter().sum::<f64>() / n;
            let error = (samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
            eprintln!("{name}, {how}: {mean:.6}, is {want:.6}, standard error {error:.6}");
            assert!(
                (mean - want).abs() < 5.0 * error && (mean / want - 1.0).abs() < 0.01,
                "{name}, {how}: {mean} {want} {error}"
            );
        };

        // By the kernel: F = (1/A) sum w_x w_y G V, G per local area.
        const PAIRS: u32 = 1 << 20;
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        // The weights' mean; a triangle's is half its parallelogram.
        let area = shapes[0].at(0.0, 0.0, 1).1 * if shapes[0].triangle { 0.5 } else { 1.0 };
        for i in 0..PAIRS {
            let u = sobol4(i, 7).map(|x| unit(x) as f64 + 0.5 / 16777216.0);
            let ((x, wx), (y, wy)) = (shapes[0].at(u[0], u[1], power), shapes[1].at(u[2], u[3], power));
            points.extend([place(x, &shapes[0]), place(y, &shapes[1])]);
            weights.push(wx * wy / area * geometry.scale * geometry.scale);
        }
        let scene_buffers = SceneBuffers::new(&gpu, &geometry).unwrap();
        let values = kernel(&gpu, &scene_buffers, &gpu.upload("points", &points).unwrap()).unwrap();
        gpu.check_finished().unwrap();
        let values = gpu.read(&values).unwrap();
        let samples: Vec<f64> = values.iter().zip(&weights).map(|(g, w)| *g as f64 * w).collect();
        check("kernel", &samples);

        // By rays: the share of cosine rays from uniform points that meet the other shape.
        let from: Vec<Point> = (0..8192)
            .map(|i| {
                let u = sobol4(i, 3).map(|x| unit(x) as f64);
                // Uniform on a triangle: the height's density falls as 1 - h.
                let s = if shapes[0].triangle { 1.0 - (1.0 - u[1]).sqrt() } else { u[1] };
                place(shapes[0].at(u[0], s, 1).0, &shapes[0])
            })
            .collect();
        let mut engine = GpuEngine::new(&gpu, &geometry).unwrap();
        let batch = engine.upload(&from).unwrap();
        let hits = engine.shoot(&batch, 5, 0, 64).unwrap();
        let hits = engine.points(&hits).unwrap();
        let met = |p: &Point| p.kind == kind::FRONT && geometry.source[p.tri as usize] as usize / faces == 1;
        check("rays", &hits.iter().map(|p| met(p) as u32 as f64).collect::<Vec<_>>());
    }
}
