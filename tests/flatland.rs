//! Flatland against closed forms, dense solutions of its own, and itself: on the processor, and on a GPU where there is
//! one (without any adapter that half passes with a note, unless `RAYCELL_REQUIRE_GPU` is set).
//!
//! `cargo test --release --test flatland -- --nocapture` shows the errors;
//! `cargo test --release --test flatland -- --ignored` writes `tests/data/flatland_*.truth.csv` anew.

mod common;

use common::{gpu, root};
use raycell::engine::Engine;
use raycell::layout::{DirectSum, Point, Psi, kind};
use raycell::network::nodes::place_nodes;
use raycell::network::tiles::starts;
use raycell::pass::GpuEngine;
use raycell::progress::{Flow, Progress};
use raycell::scene::{Geometry, Material};
use raycell::twin::direct::Samples;
use raycell::twin::{self, TwinEngine};
use raycell::{Answer, Backend, Direct, Error, Norm, Params, Scene, Solution, SurfacePoint, bake};
use std::f64::consts::PI;

fn shipped(name: &str) -> Scene {
    Scene::load(root(&format!("scenes/flatland/{name}.toml"))).unwrap()
}

/// A grey material that emits radiosity `e`.
fn grey(rho: f64, e: f64) -> Material {
    Material::new("grey", [rho; 3], [e / PI; 3])
}

type Segment = [[f64; 2]; 2];

/// The sides of the unit square, fronts inwards: bottom, right, top, left.
const SQUARE: [Segment; 4] =
    [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 1.0]], [[1.0, 1.0], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]];

/// The unit square of one reflectance, each side with its own emitted radiosity.
fn square(rho: f64, e: [f64; 4]) -> Scene {
    let sides: Vec<_> = SQUARE.iter().enumerate().map(|(i, &s)| (s, i as u32)).collect();
    Scene::from_segments("square", &sides, e.map(|e| grey(rho, e)).to_vec()).unwrap()
}

/// `n` points along a segment, evenly, asked for from its front.
fn along([a, b]: Segment, n: usize) -> Vec<SurfacePoint> {
    let place = |i: usize| {
        let t = (i as f64 + 0.5) / n as f64;
        SurfacePoint { p: [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), 0.0], n: [a[1] - b[1], b[0] - a[0], 0.0] }
    };
    (0..n).map(place).collect()
}

fn solve(backend: &Backend, scene: &Scene, params: &Params) -> Solution {
    bake(backend, scene, params, &mut |_| Flow::Continue).unwrap()
}

/// The mean radiosity, a band, at `n` points of a segment.
fn mean_b(solution: &Solution, side: Segment, n: usize) -> f64 {
    let answers = solution.query(&Backend::Cpu, &along(side, n)).unwrap();
    answers.iter().map(|a| a.b[1]).sum::<f64>() / n as f64
}

fn off(name: &str, got: f64, want: f64, limit: f64) {
    let error = got / want - 1.0;
    eprintln!("{name}: {got:.6} ({want:.6}), off by {:+.4} %", 100.0 * error);
    assert!(error.abs() <= limit, "{name}: {got} is not {want} to {limit}");
}

const RAYS: u32 = 65_536;

/// F_ij of all segments by the rays of pass `emit`: the flux mu(i, j) = A_i F_ij that they carry, both ways.
fn form_factors(segments: &[Segment]) -> Vec<Vec<f64>> {
    let all: Vec<_> = segments.iter().map(|&s| (s, 0)).collect();
    let scene = Scene::from_segments("segments", &all, vec![grey(0.5, 1.0)]).unwrap();
    let g = Geometry::new(&scene).unwrap();
    let tiles = starts(&g, &vec![0.0; g.tiles as usize], 0.0);
    let rays = twin::emit::emit(&g, &tiles, 5, 0, 4 * RAYS, 4 * RAYS);
    let mut f = vec![vec![0.0; segments.len()]; segments.len()];
    for ray in rays.chunks_exact(2).filter(|r| r[0].kind == kind::FRONT) {
        let [i, j] = [0, 1].map(|k| g.source[ray[k].tri as usize] as usize);
        let w = ray[0].weight as f64 / g.scale;
        f[i][j] += w / scene.area(i);
        f[j][i] += w / scene.area(j);
    }
    f
}

#[test]
fn rays_carry_the_form_factors_of_strings() {
    // Hottel's strings. Of a quarter of a million low-discrepancy rays a share F is known to 5 sigma of as many
    // independent ones with plenty to spare.
    let known = |name: &str, got: f64, want: f64| {
        let limit = 5.0 * (want * (1.0 - want) / RAYS as f64).sqrt();
        eprintln!("{name}: {got:.6} ({want:.6})");
        assert!((got - want).abs() <= limit, "{name}: {got} is not {want} to {limit}");
    };
    let f = form_factors(&SQUARE);
    known("opposite", f[0][2], 2f64.sqrt() - 1.0);
    known("adjacent", f[0][1], 1.0 - 0.5f64.sqrt());
    known("adjacent", f[3][0], 1.0 - 0.5f64.sqrt());
    // A blocker half way between the plates, facing both ways; the room's sides keep every ray in.
    let blocker = [[0.25, 0.5], [0.75, 0.5]];
    let f = form_factors(&[SQUARE.to_vec(), vec![blocker, [blocker[1], blocker[0]]]].concat());
    known("blocked", f[0][2], 5f64.sqrt() / 2.0 - 1.0);
    // A fin from the floor to half the height.
    let fin = [[0.5, 0.0], [0.5, 0.5]];
    let f = form_factors(&[SQUARE.to_vec(), vec![fin, [fin[1], fin[0]]]].concat());
    known("partition", f[3][1], (2f64.sqrt() - 1.0) / 2.0);
    // To the top: nothing passes, and nothing leaks where the segments meet.
    let wall = [[0.5, 0.0], [0.5, 1.0]];
    let halves =
        [[[0.0, 0.0], [0.5, 0.0]], [[0.5, 0.0], [1.0, 0.0]], SQUARE[1], [[1.0, 1.0], [0.5, 1.0]], [[0.5, 1.0], [0.0, 1.0]]];
    let f = form_factors(&[halves.to_vec(), vec![SQUARE[3], wall, [wall[1], wall[0]]]].concat());
    assert_eq!(f[5][2], 0.0);
}

#[test]
fn direct_light_is_that_of_strings() {
    // One side shines on black ones: mean irradiance is the form factor. The samples stop at a relative standard error
    // of 0.4 % a point; of 100 points less is left.
    let solution = solve(&Backend::Cpu, &square(0.0, [1.0, 0.0, 0.0, 0.0]), &Params { rays: 4096, ..Params::default() });
    for (side, want) in [(1, 1.0 - 0.5f64.sqrt()), (2, 2f64.sqrt() - 1.0), (3, 1.0 - 0.5f64.sqrt())] {
        let answers = solution.query(&Backend::Cpu, &along(SQUARE[side], 100)).unwrap();
        off("direct", answers.iter().map(|a| a.d[0]).sum::<f64>() / 100.0, want, 0.002);
    }
}

#[test]
fn the_furnace_is_even() {
    for direct in [Direct::Exact, Direct::Network] {
        for (rho, limit) in [(0.5, 0.005), (0.9, 0.01)] {
            let solution = solve(&Backend::Cpu, &square(rho, [1.0; 4]), &Params { rays: RAYS, direct, ..Params::default() });
            let b: Vec<Answer> = SQUARE.iter().flat_map(|&s| solution.query(&Backend::Cpu, &along(s, 50)).unwrap()).collect();
            let worst = b.iter().map(|a| (a.b[0] * (1.0 - rho) - 1.0).abs()).fold(0.0, f64::max);
            eprintln!("furnace {rho} {direct:?}: off by {:.3} % at most", 100.0 * worst);
            assert!(worst <= limit, "{direct:?} {rho}: {worst}");
            // Irradiance is B itself in a furnace.
            assert!(b.iter().all(|a| (a.h[0] / a.b[0] - 1.0).abs() <= limit));
        }
    }
}

#[test]
fn the_norm_of_1997_loses_what_it_must() {
    // b = 1/(1 - rho/pi): rows sum to 1/pi.
    for (rho, want) in [(0.5, 1.18928), (0.9, 1.4015)] {
        let params = Params { rays: RAYS, norm: Norm::Paper1997, ..Params::default() };
        let solution = solve(&Backend::Cpu, &square(rho, [1.0; 4]), &params);
        for side in SQUARE {
            off("paper1997", mean_b(&solution, side, 20), want, 0.002);
            // What arrives is the share 1/pi of what surrounds the point.
            for a in solution.query(&Backend::Cpu, &along(side, 5)).unwrap() {
                assert!((a.h[0] * PI / a.b[0] - 1.0).abs() < 0.005 && (a.b[0] - 1.0 - rho * a.h[0]).abs() < 1e-6, "{a:?}");
            }
        }
        assert!(solution.report().warnings.iter().any(|w| w.contains("1/pi")), "{:?}", solution.report().warnings);
    }
    let solid = Scene::load(root("scenes/furnace/scene.obj")).unwrap();
    let params = Params { rays: 1024, norm: Norm::Paper1997, ..Params::default() };
    let refused = bake(&Backend::Cpu, &solid, &params, &mut |_| Flow::Continue).map(|_| ());
    assert!(matches!(refused, Err(Error::InvalidParam { name: "norm", .. })), "{refused:?}");
}

#[test]
fn the_lit_square_has_its_means() {
    // Means of b where the bottom side alone shines (dense Nystroem, graded Gauss, 11 digits); they sum to 1/(1 - rho).
    let truths = [
        (0.5, [1.1486301912981856, 0.26959682702195115, 0.31217615465799264]),
        (0.9, [3.0922999014660637, 2.283025905579403, 2.3416482873791233]),
    ];
    for direct in [Direct::Exact, Direct::Network] {
        for (rho, [bottom, side, top]) in truths {
            let params = Params { rays: 2 * RAYS, direct, ..Params::default() };
            let solution = solve(&Backend::Cpu, &square(rho, [1.0, 0.0, 0.0, 0.0]), &params);
            for (s, want) in SQUARE.into_iter().zip([bottom, side, top, side]) {
                off(&format!("lit square {rho} {direct:?}"), mean_b(&solution, s, 100), want, 0.003);
            }
        }
    }
}

#[test]
fn the_circle_keeps_its_first_harmonic() {
    // e = 1 + cos theta on a polygon of 400 sides gives b = 1/(1 - rho) + cos(theta)/(1 + rho/3): the kernel's
    // eigenvalues on a circle are 1/(1 - 4 n^2).
    let corner = |i: usize| [(2.0 * PI * i as f64 / 400.0).cos(), (2.0 * PI * i as f64 / 400.0).sin()];
    let theta = |i: usize| 2.0 * PI * (i as f64 + 0.5) / 400.0;
    let segments: Vec<_> = (0..400).map(|i| ([corner(i), corner((i + 1) % 400)], i as u32)).collect();
    for rho in [0.5, 0.9] {
        let materials = (0..400).map(|i| grey(rho, 1.0 + theta(i).cos())).collect();
        let scene = Scene::from_segments("circle", &segments, materials).unwrap();
        let solution = solve(&Backend::Cpu, &scene, &Params { rays: 2 * RAYS, ..Params::default() });
        let points: Vec<SurfacePoint> = segments.iter().flat_map(|s| along(s.0, 1)).collect();
        let b = solution.query(&Backend::Cpu, &points).unwrap();
        let mean = |weight: &dyn Fn(usize) -> f64| (0..400).map(|i| b[i].b[0] * weight(i)).sum::<f64>() / 400.0;
        off(&format!("circle {rho}, mean"), mean(&|_| 1.0), 1.0 / (1.0 - rho), 0.003);
        off(&format!("circle {rho}, first harmonic"), mean(&|i| 2.0 * theta(i).cos()), 1.0 / (1.0 + rho / 3.0), 0.01);
    }
}

/// A flatland room for the passes: open to the left, with a blocker, a fin that faces both ways, a covered floor under
/// a box, and a light.
fn room() -> Geometry {
    let t = |a: [f64; 2], b: [f64; 2], m: u32| ([a, b], m);
    let segments = [
        t([0.0, 0.0], [2.0, 0.0], 0),
        t([2.0, 0.0], [2.0, 1.0], 1),
        t([2.0, 1.0], [1.2, 1.0], 0),
        t([1.2, 1.0], [0.8, 1.0], 2),
        t([0.8, 1.0], [0.0, 1.0], 0),
        // The blocker faces up only.
        t([0.7, 0.5], [0.3, 0.6], 1),
        t([1.5, 0.0], [1.5, 0.4], 1),
        t([1.5, 0.4], [1.5, 0.0], 1),
        // A box without a bottom.
        t([0.8, 0.0], [0.8, 0.2], 0),
        t([0.8, 0.2], [1.1, 0.2], 0),
        t([1.1, 0.2], [1.1, 0.0], 0),
    ]
    .map(|(s, m)| if m == 1 && s[0] == [0.7, 0.5] { ([s[1], s[0]], m) } else { (s, m) });
    let materials = vec![grey(0.7, 0.0), Material::new("red", [0.6, 0.1, 0.1], [0.0; 3]), grey(0.5, 2.0)];
    Geometry::new(&Scene::from_segments("room", &segments, materials).unwrap()).unwrap()
}

fn close(a: f32, b: f32, abs: f32, rel: f32) -> bool {
    (a - b).abs() <= abs + rel * a.abs().max(b.abs())
}

/// Share of the pairs that differ: a ray that grazes an end may fall out differently where multiply-adds are contracted.
fn share<T>(a: &[T], b: &[T], same: impl Fn(&T, &T) -> bool) -> f64 {
    assert!(a.len() == b.len() && !a.is_empty());
    a.iter().zip(b).filter(|(a, b)| !same(a, b)).count() as f64 / a.len() as f64
}

fn same_point(a: &Point, b: &Point) -> bool {
    (a.kind, a.tri, a.tile) == (b.kind, b.tri, b.tile)
        && (0..3).all(|k| close(a.p[k], b.p[k], 2e-6, 1e-6))
        && close(a.weight, b.weight, 1e-12, 1e-4)
        && close(a.density, b.density, 0.0, 1e-6)
}

#[test]
fn passes_equal_their_twins() {
    let Some(gpu) = gpu() else { return };
    let g = room();
    let (mut cpu, mut dev) = (TwinEngine::new(&g), GpuEngine::new(&gpu, &g).unwrap());
    let tiles = starts(&g, &vec![0.0; g.tiles as usize], 0.0);

    // emit: rays of every kind.
    let want = cpu.emit(&tiles, 3, 77, 10_007, 10_007).unwrap();
    let got = dev.emit(&tiles, 3, 77, 10_007, 10_007).unwrap();
    let (want, got) = (cpu.points(&want).unwrap(), dev.points(&got).unwrap());
    assert!(share(&want, &got, same_point) <= 1e-3, "emit: {}", share(&want, &got, same_point));
    for k in [kind::DEAD, kind::FRONT, kind::SKY, kind::BACK] {
        assert!(want.iter().any(|p| p.kind == k), "the room shows every kind of ray, also {k}");
    }
    assert!(want.iter().all(|p| p.p[2] == 0.0));
    let rays = want;
    let (mut a, mut b) = (cpu.upload(&rays).unwrap(), dev.upload(&rays).unwrap());

    // shoot and gather.
    let (ha, hb) = (cpu.shoot(&a, 9, 2, 5).unwrap(), dev.shoot(&b, 9, 2, 5).unwrap());
    let (pa, pb) = (cpu.points(&ha).unwrap(), dev.points(&hb).unwrap());
    assert!(share(&pa, &pb, same_point) <= 1e-3, "shoot: {}", share(&pa, &pb, same_point));
    let (ga, gb) = (cpu.gather(&ha, 5, false, false).unwrap(), dev.gather(&hb, 5, false, false).unwrap());
    let same = |a: &twin::gather::Gathered, b: &twin::gather::Gathered| {
        close(a.nearness, b.nearness, 1e-6, 1e-4) && (a.front - b.front).abs() < 1e-6 && (a.back - b.back).abs() < 1e-6
    };
    // A gather takes five rays, each with its own chance of grazing an end.
    assert!(share(&ga, &gb, same) <= 5e-3, "gather: {}", share(&ga, &gb, same));

    // kernel, on unrelated pairs.
    let mut pairs = rays.clone();
    let half = pairs.len() / 2;
    for i in (1..half).step_by(2) {
        pairs.swap(i, 2 * half - i);
    }
    let (ka, kb) = (cpu.kernel(&pairs).unwrap(), dev.kernel(&pairs).unwrap());
    assert!(share(&ka, &kb, |a, b| close(*a, *b, 1e-12, 1e-4)) <= 1e-3, "kernel");
    assert!(ka.iter().filter(|&&k| k > 0.0).count() > ka.len() / 20);

    // direct.
    let samples = Samples { emitter: 3, cosine: 2 };
    for (first, rounds) in [(0, 4), (4, 7)] {
        cpu.direct(&mut a, None, 21, first, rounds, samples).unwrap();
        dev.direct(&mut b, None, 21, first, rounds, samples).unwrap();
    }
    let (da, db) = (cpu.direct_sums(&a).unwrap(), dev.direct_sums(&b).unwrap());
    let same = |a: &DirectSum, b: &DirectSum| a.rounds == b.rounds && (0..3).all(|k| close(a.sum[k], b.sum[k], 1e-6, 1e-4));
    assert!(share(&da, &db, same) <= 1e-2, "direct: {}", share(&da, &db, same));
    assert!(da.iter().filter(|d| d.sum[0] > 0.0).count() > da.len() / 4);

    // assign.
    let density = vec![1.0; g.tiles as usize];
    let surface = place_nodes(&mut cpu, &g, &density, 100, 0.3, 5, true, &mut Progress::new(&mut |_| Flow::Continue)).unwrap();
    dev.set_surface(&surface).unwrap();
    cpu.assign(&mut a).unwrap();
    dev.assign(&mut b).unwrap();
    let (sa, sb) = (cpu.psi(&a).unwrap(), dev.psi(&b).unwrap());
    let same = |a: &Psi, b: &Psi| a.node == b.node && (0..4).all(|k| close(a.weight[k], b.weight[k], 1e-5, 1e-4));
    assert!(share(&sa, &sb, same) <= 1e-3, "assign: {}", share(&sa, &sb, same));

    // The same device serves a scene in three dimensions in between.
    let solid = Geometry::new(&Scene::load(root("scenes/cornell/scene.obj")).unwrap()).unwrap();
    let tiles = starts(&solid, &vec![0.0; solid.tiles as usize], 0.0);
    let (mut cpu, mut dev) = (TwinEngine::new(&solid), GpuEngine::new(&gpu, &solid).unwrap());
    let want = cpu.emit(&tiles, 3, 0, 1000, 1000).unwrap();
    let got = dev.emit(&tiles, 3, 0, 1000, 1000).unwrap();
    assert!(share(&cpu.points(&want).unwrap(), &dev.points(&got).unwrap(), same_point) <= 2e-3);
}

/// The scene with each segment cut into `n`.
fn cut(scene: &Scene, n: usize) -> Scene {
    let mut segments = Vec::new();
    for (i, face) in scene.faces.iter().enumerate() {
        let [a, b, _] = scene.corners(i);
        let at = |k: usize| [0, 1].map(|c| a[c] + (b[c] - a[c]) * k as f64 / n as f64);
        segments.extend((0..n).map(|k| ([at(k), at(k + 1)], face.material)));
    }
    Scene::from_segments("cut", &segments, scene.materials.clone()).unwrap()
}

/// sqrt(mean (B - B*)^2)/mean B* of the reflected radiosity B - E, the first band.
fn error(answers: &[Answer], truth: &[f64], emitted: &[f64]) -> f64 {
    let n = truth.len() as f64;
    let square: f64 = answers.iter().zip(truth).map(|(a, t)| (a.b[0] - t).powi(2)).sum();
    let level: f64 = truth.iter().zip(emitted).map(|(t, e)| t - e).sum::<f64>() / n;
    (square / n).sqrt() / level
}

/// Points of a shipped flatland scene with their radiosity, and what they emit.
fn truth(name: &str) -> (Vec<SurfacePoint>, Vec<f64>, Vec<f64>) {
    let truth = common::truth(&format!("flatland_{name}"));
    let emitted = common::emitted(&shipped(name), &truth.points);
    let first = |b: &[[f64; 3]]| b.iter().map(|b| b[0]).collect();
    (truth.points, first(&truth.b), first(&emitted))
}

#[test]
fn shipped_scenes_agree_with_their_truths() {
    // Limits: half as much again as was measured, means of three seeds.
    for (name, limits) in [("box", [0.0035, 0.007]), ("plates", [0.0035, 0.004]), ("l_room", [0.005, 0.03])] {
        let (points, b, e) = truth(name);
        for (direct, limit) in [Direct::Exact, Direct::Network].into_iter().zip(limits) {
            let errors = [1, 2, 3].map(|seed| {
                let params = Params { rays: 2 * RAYS, direct, seed, ..Params::default() };
                let solution = solve(&Backend::Cpu, &shipped(name), &params);
                error(&solution.query(&Backend::Cpu, &points).unwrap(), &b, &e)
            });
            let mean = errors.iter().sum::<f64>() / 3.0;
            eprintln!("{name} {direct:?}: {:.3} % of {errors:.5?}", 100.0 * mean);
            assert!(mean <= limit, "{name} {direct:?}: {mean}");
        }
    }
}

#[test]
fn cutting_lines_changes_nothing() {
    let (points, b, e) = truth("box");
    let (whole, pieces) = (shipped("box"), cut(&shipped("box"), 100));
    // The same rays meet the same places, but for rounding at the cuts.
    let (gw, gp) = (Geometry::new(&whole).unwrap(), Geometry::new(&pieces).unwrap());
    assert_eq!(gw.pieces, gp.pieces);
    let from: Vec<SurfacePoint> = SQUARE.iter().flat_map(|&s| along(s, 500)).collect();
    let place = |g: &Geometry| -> Vec<Point> {
        from.iter()
            .map(|q| {
                let at = g.locate(q.p, q.n).unwrap();
                Point { p: at.p, tri: at.tri, ..Point::default() }
            })
            .collect()
    };
    let (a, c) = (twin::shoot::shoot(&gw, &place(&gw), 1, 0, 8), twin::shoot::shoot(&gp, &place(&gp), 1, 0, 8));
    let moved = share(&a, &c, |a, c| a.kind == c.kind && (0..2).all(|k| (a.p[k] - c.p[k]).abs() < 1e-5));
    assert!(moved <= 1e-3, "{moved}");
    // So do the answers; how cells and nodes fall is another draw.
    let params = Params { rays: 2 * RAYS, ..Params::default() };
    let errors =
        [&whole, &pieces].map(|s| error(&solve(&Backend::Cpu, s, &params).query(&Backend::Cpu, &points).unwrap(), &b, &e));
    eprintln!("whole {:.3} %, in hundred pieces each {:.3} %", 100.0 * errors[0], 100.0 * errors[1]);
    assert!(errors[1] <= 1.5 * errors[0] + 0.001, "{errors:?}");
}

#[test]
fn both_backends_bake_alike_and_files_keep_flatland() {
    let scene = shipped("box");
    let params = Params { rays: 16_384, ..Params::default() };
    let solution = solve(&Backend::Cpu, &scene, &params);
    let points: Vec<SurfacePoint> = along(SQUARE[0], 40);
    let answers = solution.query(&Backend::Cpu, &points).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("box.rcell");
    solution.save(&path).unwrap();
    let loaded = Solution::load(&path).unwrap();
    assert_eq!(loaded.scene().space, scene.space);
    assert_eq!(loaded.query(&Backend::Cpu, &points).unwrap(), answers);
    // Walls: two triangles and four corners a segment, as high as asked, the light of the foot on top.
    let mesh = solution.vertices(&Backend::Cpu).unwrap();
    assert_eq!(mesh.faces.len(), 20);
    for face in &mesh.faces {
        let v = face.map(|i| mesh.vertices[i as usize]);
        let way = |k: usize| glam::DVec3::from_array(v[k].p) - glam::DVec3::from_array(v[0].p);
        assert!(way(1).cross(way(2)).dot(glam::Vec3::from(v[0].n).as_dvec3()) > 0.0, "the front is the lit side");
        assert!(v.iter().all(|v| v.p[2] == 0.0 || v.p[2] == 0.5));
    }
    if let Some(gpu) = gpu() {
        let gpu = Backend::Gpu(gpu);
        let there = solve(&gpu, &scene, &params).query(&gpu, &points).unwrap();
        for (a, b) in answers.iter().zip(&there) {
            // Where a rounding moves a cell, light moves by its noise: 1 % of what is there.
            assert!((a.b[0] - b.b[0]).abs() <= 0.01 * a.b[0], "{a:?} {b:?}");
        }
    }
}

#[test]
fn what_is_no_flatland_is_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.toml");
    let refusal = |text: &str| {
        std::fs::write(&path, text).unwrap();
        Scene::load(&path).map(|_| ()).expect_err(text).to_string()
    };
    let segment = "[[segment]]\nname = \"a\"\nmaterial = \"m\"\npoints = [[0, 0], [1, 0]]\n";
    let mesh = "[[mesh]]\nname = \"b\"\nmaterial = \"m\"\nvertices = [[0,0,0],[1,0,0],[0,1,0]]\nfaces = [[0,1,2]]\n";
    for (text, says) in [
        (format!("{segment}{mesh}"), "one kind or the other"),
        (format!("{segment}wide = 3\n"), "wide"),
        (format!("{segment}[[material]]\nname = \"m\"\nradiance = 1\n"), "give radiosity"),
        (format!("{segment}[[material]]\nname = \"m\"\nlumens = 1\n"), "give radiosity"),
        (format!("height = 0\n{segment}"), "more than 0"),
        (format!("height = 1\n{mesh}"), "no [[segment]]"),
        ("[[segment]]\nname = \"a\"\nmaterial = \"m\"\npoints = [[0, 0]]\n".into(), "fewer than two points"),
        ("[[segment]]\nname = \"a\"\nmaterial = \"m\"\npoints = [[0, 0], [nan, 1]]\n".into(), "not finite"),
    ] {
        let said = refusal(&text);
        assert!(said.contains(says) && said.contains("s.toml"), "{said}");
    }
    // In memory: a triangle, or a segment off the plane.
    let mut scene = square(0.5, [1.0; 4]);
    scene.vertices[0][2] = 0.5;
    assert!(matches!(scene.check(), Err(Error::NotFlat { face: 0, .. })));
    let mut scene = square(0.5, [1.0; 4]);
    scene.faces[2].vertices[2] = 0;
    assert!(matches!(scene.check(), Err(Error::NotFlat { face: 2, .. })));
    // Sides and both sides.
    std::fs::write(&path, format!("{segment}side = \"right\"\n\n{segment}two_sided = true\n")).unwrap();
    let scene = Scene::load(&path).unwrap();
    let ways: Vec<f64> = (0..3).map(|f| scene.corners(f)[1][0] - scene.corners(f)[0][0]).collect();
    assert_eq!(ways, [-1.0, 1.0, -1.0]);
}

// ---------------------------------------------------------------------------------------------
// Truths: a dense solution that shares nothing with the passes, in f64
// ---------------------------------------------------------------------------------------------

/// A piece of a segment.
struct Element {
    ends: [glam::DVec2; 2],
    segment: usize,
}

struct Dense {
    segments: Vec<[glam::DVec2; 2]>,
    rho: Vec<f64>,
    e: Vec<f64>,
    elements: Vec<Element>,
    b: Vec<f64>,
}

impl Dense {
    /// Elements of about one length, each of one radiosity; point-to-element factors are analytic, their visibility by
    /// `rays` rays; iterated to 1e-12.
    fn new(scene: &Scene, count: usize, rays: usize) -> Dense {
        let flat = |v: [f64; 3]| glam::DVec2::new(v[0], v[1]);
        let segments: Vec<[glam::DVec2; 2]> = (0..scene.faces.len()).map(|f| [0, 1].map(|k| flat(scene.corners(f)[k]))).collect();
        let material = |f: usize| &scene.materials[scene.faces[f].material as usize];
        let total: f64 = segments.iter().map(|s| s[0].distance(s[1])).sum();
        let mut elements = Vec::new();
        for (segment, s) in segments.iter().enumerate() {
            let n = (s[0].distance(s[1]) / total * count as f64).ceil() as usize;
            let at = |k: usize| s[0].lerp(s[1], k as f64 / n as f64);
            elements.extend((0..n).map(|k| Element { ends: [at(k), at(k + 1)], segment }));
        }
        let mut dense = Dense {
            rho: (0..segments.len()).map(|f| material(f).reflectance[0]).collect(),
            e: (0..segments.len()).map(|f| PI * material(f).emission[0]).collect(),
            b: Vec::new(),
            segments,
            elements,
        };
        use rayon::prelude::*;
        let rows: Vec<Vec<f32>> = dense
            .elements
            .par_iter()
            .map(|y| dense.factors(y.ends[0].midpoint(y.ends[1]), y.segment, rays).into_iter().map(|f| f as f32).collect())
            .collect();
        let mut b: Vec<f64> = dense.elements.iter().map(|x| dense.e[x.segment]).collect();
        loop {
            let next: Vec<f64> = (dense.elements.par_iter().zip(&rows))
                .map(|(y, row)| {
                    dense.e[y.segment] + dense.rho[y.segment] * row.iter().zip(&b).map(|(&f, b)| f as f64 * b).sum::<f64>()
                })
                .collect();
            let change = next.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            b = next;
            if change < 1e-12 {
                break;
            }
        }
        dense.b = b;
        dense
    }

    fn normal(&self, segment: usize) -> glam::DVec2 {
        (self.segments[segment][1] - self.segments[segment][0]).normalize().perp()
    }

    /// F(y -> element), visible part, of every element: half the difference of the sines at its ends.
    fn factors(&self, y: glam::DVec2, segment: usize, rays: usize) -> Vec<f64> {
        let n = self.normal(segment);
        let sine = |p: glam::DVec2| {
            let d = p - y;
            let s = n.perp_dot(d) / d.length();
            if n.dot(d) < 0.0 { s.signum() } else { s }
        };
        let factor = |x: &Element| {
            let middle = x.ends[0].midpoint(x.ends[1]);
            if x.segment == segment || self.normal(x.segment).dot(y - middle) <= 0.0 {
                return 0.0;
            }
            let f = 0.5 * (sine(x.ends[0]) - sine(x.ends[1])).abs();
            let seen =
                |k: &usize| !self.blocked(y, segment, x.ends[0].lerp(x.ends[1], (*k as f64 + 0.5) / rays as f64), x.segment);
            if f > 0.0 { f * (0..rays).filter(seen).count() as f64 / rays as f64 } else { 0.0 }
        };
        self.elements.iter().map(factor).collect()
    }

    fn blocked(&self, y: glam::DVec2, own: usize, x: glam::DVec2, other: usize) -> bool {
        let d = x - y;
        self.segments.iter().enumerate().any(|(s, [a, b])| {
            if s == own || s == other {
                return false;
            }
            let (fa, fb) = (d.perp_dot(*a - y), d.perp_dot(*b - y));
            let t = (*a - y).perp_dot(*b - *a) / d.perp_dot(*b - *a);
            (fa < 0.0) != (fb < 0.0) && t > 0.0 && t < 1.0
        })
    }

    /// Radiosity at a point of a segment.
    fn at(&self, y: glam::DVec2, segment: usize, rays: usize) -> f64 {
        let h: f64 = self.factors(y, segment, rays).iter().zip(&self.b).map(|(f, b)| f * b).sum();
        self.e[segment] + self.rho[segment] * h
    }
}

#[test]
#[ignore = "writes the truths of scenes/flatland, in a minute"]
fn write_the_truths() {
    use rayon::prelude::*;
    for name in ["box", "plates", "l_room"] {
        let scene = shipped(name);
        let (coarse, fine) = (Dense::new(&scene, 2000, 4), Dense::new(&scene, 4000, 4));
        let total: f64 = (0..scene.faces.len()).map(|f| scene.area(f)).sum();
        let place = |i: usize| {
            let mut s = (i as f64 + 0.5) / 512.0 * total;
            let mut f = 0;
            while s > scene.area(f) {
                s -= scene.area(f);
                f += 1;
            }
            (f, fine.segments[f][0].lerp(fine.segments[f][1], s / scene.area(f)))
        };
        let rows: Vec<String> = (0..512usize)
            .into_par_iter()
            .map(|i| {
                let (f, p) = place(i);
                let (b, n) = (fine.at(p, f, 16), fine.normal(f));
                // Twice as fine halves the error at least: what is left is no more than the difference.
                let left = (b - coarse.at(p, f, 16)).abs();
                format!("{},{},0,{},{},0,{b:.8},{b:.8},{b:.8},{left:.3e},{left:.3e},{left:.3e},0", p.x, p.y, n.x, n.y)
            })
            .collect();
        let text = format!("px,py,pz,nx,ny,nz,B_r,B_g,B_b,stderr_r,stderr_g,stderr_b,flag\n{}\n", rows.join("\n"));
        std::fs::write(root(&format!("tests/data/flatland_{name}.truth.csv")), text).unwrap();
        let worst = rows.iter().map(|r| r.split(',').nth(9).unwrap().parse::<f64>().unwrap()).fold(0.0, f64::max);
        eprintln!(
            "{name}: half the elements differ by {worst:.1e} at most; level {}",
            fine.b.iter().sum::<f64>() / fine.b.len() as f64
        );
    }
}

#[test]
fn the_dense_solution_knows_the_lit_square() {
    // The truths' own oracle: what the ignored test writes comes from it. Constant elements err by their size.
    let dense = Dense::new(&square(0.9, [1.0, 0.0, 0.0, 0.0]), 800, 1);
    let mean =
        |s: usize| dense.b.iter().zip(&dense.elements).filter(|(_, x)| x.segment == s).map(|(b, _)| b).sum::<f64>() / 200.0;
    off("dense, bottom", mean(0), 3.0922999014660637, 1e-4);
    off("dense, top", mean(2), 2.3416482873791233, 1e-4);
}
