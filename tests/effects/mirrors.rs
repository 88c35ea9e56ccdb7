//! Ideal mirrors: by their images, by the room unfolded, by a path-traced reference; each kernel by its twin.

use crate::common::{gpu, rrmse};
use raycell::accuracy::reference::{Goal, Reference, sample_points};
use raycell::effects::{Name, analyse};
use raycell::engine::Engine;
use raycell::layout::{DirectSum, Node, NodeSource, Point, kind};
use raycell::network::nodes::place_nodes;
use raycell::network::tiles;
use raycell::pass::GpuEngine;
use raycell::progress::Progress;
use raycell::scene::{Geometry, LoadOptions, Material, shapes};
use raycell::solution::{Camera, Status};
use raycell::twin::TwinEngine;
use raycell::twin::direct::Samples;
use raycell::{Backend, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::f64::consts::PI;
use std::path::Path;

pub fn backend() -> Option<Backend> {
    gpu().map(Backend::Gpu)
}

pub fn solve(backend: &Backend, scene: &Scene, params: &Params) -> Solution {
    bake(backend, scene, params, &mut |_| Flow::Continue).unwrap()
}

/// Radiosities of a path-traced reference, `paths` at each of `count` points.
pub fn reference(scene: &Scene, count: usize, paths: u64) -> (Vec<SurfacePoint>, Vec<[f64; 3]>) {
    let geometry = Geometry::new(scene).unwrap();
    let points = sample_points(&geometry, count, 3);
    let mut reference = Reference::new(scene, &geometry, Path::new("points"), points.clone(), 4).unwrap();
    let goal = Goal { noise: 0.0, paths, time: None };
    reference.run(goal, &mut Progress::new(&mut |_| Flow::Continue)).unwrap();
    let truth = reference.truth();
    // A few thousand paths: what is held against it must be farther off than its noise.
    assert!(truth.noise() < 0.02, "noise {}", truth.noise());
    (points, truth.b)
}

pub fn radiosity(backend: &Backend, solution: &Solution, points: &[SurfacePoint]) -> Vec<[f64; 3]> {
    solution.query(backend, points).unwrap().iter().map(|a| a.b).collect()
}

/// Form factor of a point on y = 0, upwards, to a rectangle at y = h, downwards, whose corners are (x, z) apart from it.
fn to_rectangle(h: f64, [x0, x1]: [f64; 2], [z0, z1]: [f64; 2]) -> f64 {
    let corner = |x: f64, z: f64| {
        let (a, b) = (x / h, z / h);
        let (ra, rb) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
        (a / ra * (b / ra).atan() + b / rb * (a / rb).atan()) / (2.0 * PI)
    };
    corner(x1, z1) - corner(x0, z1) - corner(x1, z0) + corner(x0, z0)
}

/// The same in flatland, to a segment.
fn to_segment(h: f64, [x0, x1]: [f64; 2]) -> f64 {
    let sine = |x: f64| x / x.hypot(h);
    0.5 * (sine(x1) - sine(x0))
}

/// What is seen of a lamp from `x0` to `x1` between mirrors at 0 and 1, from x: the sum of its images.
fn images(mirror: f64, x: f64, x0: f64, x1: f64, factor: impl Fn([f64; 2]) -> f64) -> f64 {
    (-400i32..=400)
        .map(|k| {
            let cell = f64::from(k);
            let [a, b] = if k % 2 == 0 { [cell + x0, cell + x1] } else { [cell + 1.0 - x1, cell + 1.0 - x0] };
            mirror.powi(k.abs()) * factor([a - x, b - x])
        })
        .sum()
}

#[test]
fn a_lamp_between_two_mirrors_is_the_sum_of_its_images() {
    let Some(gpu) = backend() else { return };
    let (mirror, (x0, x1), (z0, z1)) = (0.8, (0.1, 0.6), (-0.25, 0.25));
    let materials = |m: Material| vec![Material::new("floor", [0.5; 3], [0.0; 3]), m, Material::new("lamp", [0.0; 3], [1.0; 3])];
    let wall = |x: f64, front: bool| {
        let [a, b] = if front { [-0.5, 0.5] } else { [0.5, -0.5] };
        shapes::quad([[x, 0.0, a], [x, 1.0, a], [x, 1.0, b], [x, 0.0, b]], 1)
    };
    let floor = shapes::quad([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 0.0, -0.5]], 0);
    let lamp = shapes::quad([[x0, 1.0, z0], [x1, 1.0, z0], [x1, 1.0, z1], [x0, 1.0, z1]], 2);
    let walls = [wall(0.0, true), wall(1.0, false), floor, lamp].concat();
    let solid = |m| Scene::from_triangles("images", &walls, materials(m)).unwrap();
    // Fronts are on the left.
    let segments = [
        ([[0.0, 0.0], [1.0, 0.0]], 0),
        ([[0.0, 1.0], [0.0, 0.0]], 1),
        ([[1.0, 0.0], [1.0, 1.0]], 1),
        ([[x1, 1.0], [x0, 1.0]], 2),
    ];
    let flat = |m| Scene::from_segments("images", &segments, materials(m)).unwrap();

    let xs: Vec<f64> = (0..32).map(|i| (f64::from(i) + 0.5) / 32.0).collect();
    let zs = |x: f64| 0.4 * (7.0 * x).sin();
    for (flatland, with, black) in [
        (false, solid(Material::new_mirror("mirror", mirror)), solid(Material::new("black", [0.0; 3], [0.0; 3]))),
        (true, flat(Material::new_mirror("mirror", mirror)), flat(Material::new("black", [0.0; 3], [0.0; 3]))),
    ] {
        let z = |x: f64| if flatland { 0.0 } else { zs(x) };
        let points: Vec<SurfacePoint> = xs.iter().map(|&x| SurfacePoint { p: [x, 0.0, z(x)], n: [0.0, 1.0, 0.0] }).collect();
        let want: Vec<[f64; 3]> = xs
            .iter()
            .map(|&x| {
                let rectangle = |xs: [f64; 2]| to_rectangle(1.0, xs, [z0 - z(x), z1 - z(x)]);
                let segment = |xs: [f64; 2]| to_segment(1.0, xs);
                let f = if flatland { images(mirror, x, x0, x1, segment) } else { images(mirror, x, x0, x1, rectangle) };
                [0.5 * PI * f; 3]
            })
            .collect();
        // Nothing is reflected twice diffusely: the floor sees itself nowhere, in no mirror.
        let mut params = Params { rays: 4_096, ..Params::default() };
        for backend in [&gpu, &Backend::Cpu] {
            let got = radiosity(backend, &solve(backend, &with, &params), &points);
            let (off, mean) =
                (rrmse(&got, &want), got.iter().map(|b| b[0]).sum::<f64>() / want.iter().map(|b| b[0]).sum::<f64>());
            eprintln!("flatland {flatland}: {off:.5}, mean {mean:.5}");
            // 2,048 cosine directions at most find what comes over mirrors: 1 % at a point, .2 % of the mean.
            assert!(off < 0.02 && (mean - 1.0).abs() < 0.005, "{flatland}: {off} {mean}");
            params.direct_samples = 2_048;
        }
        let without = radiosity(&gpu, &solve(&gpu, &black, &params), &points);
        assert!(rrmse(&without, &want) > 0.2, "{}", rrmse(&without, &want));
    }
}

/// A room whose walls at x = 1 and z = 1 are mirrors, with a lamp and a block; or, unfolded, the room four times.
fn corner_room(mirror: Option<f64>) -> Scene {
    let (white, red, lamp, silver) = (0, 1, 2, 3);
    // The sides -x, +x, -y, +y, -z, +z.
    let [left, right, floor, ceiling, front, back] =
        shapes::sides([0.0; 3], [1.0; 3], [red, silver, white, white, white, silver]);
    let lit =
        shapes::moved(shapes::quad([[0.3, 0.999, 0.2], [0.7, 0.999, 0.2], [0.7, 0.999, 0.6], [0.3, 0.999, 0.6]], lamp), |p| p);
    let block = shapes::block([0.45, 0.0, 0.5], [0.8, 0.4, 0.75], white);
    let room = [left, floor, ceiling, front, lit, block].concat();
    let materials = vec![
        Material::new("white", [0.7; 3], [0.0; 3]),
        Material::new("red", [0.6, 0.2, 0.1], [0.0; 3]),
        Material::new("lamp", [0.3; 3], [5.0; 3]),
        Material::new_mirror("silver", mirror.unwrap_or(0.5)),
    ];
    let all = match mirror {
        Some(_) => [room, right, back].concat(),
        None => {
            let in_x = shapes::flipped(shapes::moved(room.clone(), |[x, y, z]| [2.0 - x, y, z]));
            let two = [room, in_x].concat();
            let in_z = shapes::flipped(shapes::moved(two.clone(), |[x, y, z]| [x, y, 2.0 - z]));
            [two, in_z].concat()
        }
    };
    Scene::from_triangles("corner", &all, materials).unwrap()
}

#[test]
fn a_room_with_mirrors_is_the_room_unfolded() {
    let Some(backend) = backend() else { return };
    let params = |rays| Params { rays, direct_samples: 2_048, ..Params::default() };
    let (folded, unfolded) = (corner_room(Some(1.0 - 1e-6)), corner_room(None));
    let points = sample_points(&Geometry::new(&folded).unwrap(), 128, 9);
    let (few, many) = (solve(&backend, &folded, &params(65_536)), solve(&backend, &unfolded, &params(131_072)));
    let (a, b) = (radiosity(&backend, &few, &points), radiosity(&backend, &many, &points));
    let off = rrmse(&a, &b);
    let mean = |b: &[[f64; 3]]| b.iter().map(|b| b[1]).sum::<f64>();
    eprintln!("mean {:.4}", mean(&a) / mean(&b));
    // Both are estimates, of four times the area the one; what they say of their own errors bounds what lies between.
    let stated = |s: &Solution| s.report().estimated_error.as_ref().unwrap().high;
    eprintln!("{off:.4}, stated {:.4} and {:.4}", stated(&few), stated(&many));
    assert!(off < stated(&few).hypot(stated(&many)) && off < 0.05, "{off}: {} {}", stated(&few), stated(&many));
    // And black mirrors are far off.
    let mut black = folded.clone();
    black.materials[3].mirror = 0.0;
    let dark = radiosity(&backend, &solve(&backend, &black, &params(16_384)), &points);
    assert!(rrmse(&dark, &b) > 0.3, "{}", rrmse(&dark, &b));
    // The account: mirrors of .999999 take next to nothing.
    let energy = &few.report().energy;
    let emitted = energy.emitted.unwrap()[0];
    assert!(energy.mirrors.unwrap()[0] < 1e-3 * emitted && energy.imbalance.unwrap().abs() < 0.02, "{energy:?}");
}

#[test]
fn a_room_with_mirrors_meets_its_reference_and_not_without_them() {
    let Some(backend) = backend() else { return };
    let scene = corner_room(Some(0.8));
    let (points, truth) = reference(&scene, 192, 8_192);
    let params = Params { rays: 65_536, direct_samples: 2_048, ..Params::default() };
    let solution = solve(&backend, &scene, &params);
    let off = rrmse(&radiosity(&backend, &solution, &points), &truth);
    let mut without = scene.clone();
    "-mirrors".parse::<raycell::effects::Switches>().unwrap().apply(&mut without).unwrap();
    assert_eq!((without.materials[3].mirror, without.materials[3].reflectance), (0.0, [0.8; 3]));
    let wrong = rrmse(&radiosity(&backend, &solve(&backend, &without, &params), &points), &truth);
    let mean = |b: &[[f64; 3]]| b.iter().map(|b| b[1]).sum::<f64>();
    eprintln!("mean {:.4}", mean(&radiosity(&backend, &solution, &points)) / mean(&truth));
    eprintln!("{off:.4} with mirrors, {wrong:.4} without");
    assert!(off < 0.04 && wrong > 3.0 * off, "{off} {wrong}");

    // What mirrors absorb is theirs: all is accounted for.
    let energy = &solution.report().energy;
    let [emitted, absorbed, mirrors] = [energy.emitted, energy.absorbed, energy.mirrors].map(|e| e.unwrap()[1]);
    assert!(mirrors > 0.05 * emitted && mirrors < absorbed && energy.medium.is_none(), "{energy:?}");
    assert!(energy.imbalance.unwrap().abs() < 0.02 && energy.given_up.unwrap() < 1e-4, "{energy:?}");

    // A file holds its mirrors, and a point on one is told of.
    let dir = tempfile::tempdir().unwrap();
    solution.save(&dir.path().join("s.rcell")).unwrap();
    let again = Solution::load(&dir.path().join("s.rcell")).unwrap();
    let few = [points[0], SurfacePoint { p: [1.0, 0.5, 0.5], n: [-1.0, 0.0, 0.0] }];
    let (a, b) = (solution.query(&backend, &few).unwrap(), again.query(&backend, &few).unwrap());
    assert_eq!(a, b);
    assert_eq!((a[0].status, a[1].status, a[1].b), (Status::Ok, Status::Mirror, [0.0; 3]));

    // A picture follows a mirror to the lamp: radiance 5, four fifths of it.
    let camera =
        Camera { eye: [0.5, 0.9, 0.1], target: [1.5, 0.999, 0.25], up: [0.0, 1.0, 0.0], vfov_degrees: 2.0, width: 1, height: 1 };
    let direct = again.render(&backend, &Camera { target: [0.5, 0.999, 0.25], up: [1.0, 0.0, 0.0], ..camera }).unwrap().rgb[0];
    let seen = again.render(&backend, &camera).unwrap().rgb[0];
    assert!((direct[0] - seen[0] / 0.8).abs() < 0.15 * direct[0] && direct[0] > 4.9, "{direct:?} {seen:?}");
    // Patches know no mirrors, and the seed paper's mode knows none.
    for (params, name) in [
        (Params { method: raycell::params::Method::Fem, ..params.clone() }, "method = fem"),
        (Params { mode: raycell::params::Mode::Paper, ..params.clone() }, "mode = paper"),
    ] {
        let told = bake(&backend, &scene, &params, &mut |_| Flow::Continue).unwrap_err().to_string();
        assert!(told.contains(name) && told.contains("mirrors"), "{told}");
    }
}

#[test]
fn mirrors_are_explained_and_are_no_holes() {
    let scene = corner_room(Some(0.8));
    let effects = analyse(&scene).unwrap();
    let of = |name: Name| effects.iter().find(|e| e.name == name.word()).unwrap();
    assert!(of(Name::Mirrors).on && of(Name::Mirrors).why.contains("'silver' reflects 80 %"), "{:?}", of(Name::Mirrors));
    assert!(!of(Name::Medium).on);
    let findings = raycell::doctor::examine(&scene).unwrap();
    let mut diffuse = scene.clone();
    diffuse.materials[3] = Material::new("silver", [0.8; 3], [0.0; 3]);
    assert_eq!(findings, raycell::doctor::examine(&diffuse).unwrap());
    // Light that mirrors alone bring makes a wall no wrong one: the lamp looks into a mirror, which shows it the wall.
    let mut wrong = corner_room(Some(0.8));
    wrong.materials[3].mirror = 1.0;
    let told = wrong.check().unwrap_err().to_string();
    assert!(told.contains("'silver'") && told.contains("below 1"), "{told}");
    wrong.materials[3] = Material { emission: [1.0; 3], ..Material::new_mirror("silver", 0.5) };
    assert!(wrong.check().unwrap_err().to_string().contains("shines"));
    assert!(raycell::doctor::examine(&wrong).unwrap().iter().any(|f| f.to_string().contains("shines")));
}

/// |a - b| within an absolute and a relative tolerance.
fn close(a: f32, b: f32, abs: f32, rel: f32) -> bool {
    (a - b).abs() <= abs + rel * a.abs().max(b.abs())
}

fn share<T>(a: &[T], b: &[T], same: impl Fn(&T, &T) -> bool) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| !same(a, b)).count() as f64 / a.len().max(1) as f64
}

/// Scenes in which ways end in every manner: at fronts, backs, in the sky, between mirrors.
fn ways() -> Vec<Geometry> {
    let mut room = corner_room(Some(0.95));
    // The wall at z = 0 goes, and the ceiling becomes a mirror too; a mirror faces another at the floor's end.
    room.faces.retain(|f| !(0..3).all(|k| room.vertices[f.vertices[k] as usize][2] == 0.0));
    let both = Scene { absorption: 0.3, ..room.clone() };
    let fog = Scene { absorption: 2.0, ..corner_room(None) };
    let segments = [
        ([[0.0, 0.0], [1.0, 0.0]], 0),
        ([[0.0, 1.0], [0.0, 0.0]], 1),
        ([[1.0, 0.0], [1.0, 1.0]], 1),
        ([[0.7, 0.9], [0.2, 0.9]], 2),
    ];
    let flat = vec![
        Material::new("floor", [0.5; 3], [0.0; 3]),
        Material::new_mirror("mirror", 0.5),
        Material::new("lamp", [0.2; 3], [1.0; 3]),
    ];
    let flat = Scene { absorption: 0.2, ..Scene::from_segments("flat", &segments, flat).unwrap() };
    [room, both, fog, flat].iter().map(|s| Geometry::new(s).unwrap()).collect()
}

#[test]
fn kernels_equal_their_twins() {
    let Some(gpu) = gpu() else { return };
    let mut kinds = Vec::new();
    for g in ways() {
        let (mut device, mut twin) = (GpuEngine::new(&gpu, &g).unwrap(), TwinEngine::new(&g));
        let same_point = |a: &Point, b: &Point| {
            (a.kind, a.tri) == (b.kind, b.tri)
                && (0..3).all(|k| close(a.p[k], b.p[k], 2e-5, 1e-5))
                && close(a.weight, b.weight, 1e-12, 1e-4)
                && close(a.density, b.density, 1e-5, 1e-4)
        };
        // Rays. A way over many mirrors passes many edges, and rounding grows with its length.
        let starts = tiles::starts(&g, &vec![0.0; g.tiles as usize], 0.0);
        let (a, b) = (twin.emit(&starts, 3, 0, 8_000, 8_000).unwrap(), device.emit(&starts, 3, 0, 8_000, 8_000).unwrap());
        let (rays, got) = (twin.points(&a).unwrap(), device.points(&b).unwrap());
        assert!(share(&rays, &got, same_point) < 4e-3, "emit: {}", share(&rays, &got, same_point));
        kinds.extend(rays.iter().map(|p| p.kind));
        assert!(rays.chunks_exact(2).any(|r| r[1].density < 0.96 && r[1].density > 0.0), "some light is lost");

        // Shot rays, and what they gather.
        let from: Vec<Point> = rays.iter().copied().filter(|p| p.tri != raycell::layout::NONE).take(3_000).collect();
        let (mut a, mut b) = (twin.upload(&from).unwrap(), device.upload(&from).unwrap());
        let (x, y) = (twin.shoot(&a, 5, 0, 2).unwrap(), device.shoot(&b, 5, 0, 2).unwrap());
        let (hits, got) = (twin.points(&x).unwrap(), device.points(&y).unwrap());
        assert!(share(&hits, &got, same_point) < 4e-3, "shoot: {}", share(&hits, &got, same_point));
        let light: Vec<[f32; 4]> = (0..hits.len()).map(|i| [0.1, 0.01 * (i % 7) as f32, 2.0, 0.0]).collect();
        let (mut x, mut y) = (twin.upload(&hits).unwrap(), device.upload(&hits).unwrap());
        twin.set_irradiance(&mut x, &light).unwrap();
        device.set_irradiance(&mut y, &light).unwrap();
        let (x, y) = (twin.gather(&x, 2, true, false).unwrap(), device.gather(&y, 2, true, false).unwrap());
        let same = |a: &[f32; 3], b: &[f32; 3]| (0..3).all(|k| close(a[k], b[k], 1e-6, 1e-4));
        assert_eq!(share(&x, &y, |a, b| same(&a.irradiance, &b.irradiance) && a.front == b.front), 0.0, "gather");

        // Direct light.
        let samples = Samples { emitter: 3, cosine: 2 };
        twin.direct(&mut a, None, 21, 0, 4, samples).unwrap();
        device.direct(&mut b, None, 21, 0, 4, samples).unwrap();
        let (x, y) = (twin.direct_sums(&a).unwrap(), device.direct_sums(&b).unwrap());
        // 20 rays a point.
        let off = share(&x, &y, |a: &DirectSum, b| same(&a.sum, &b.sum));
        assert!(off < 2e-2, "direct: {off}");
        assert!(x.iter().filter(|s| s.sum[0] > 0.0).count() > x.len() / 4);

        // The kernel between unrelated points.
        let pairs: Vec<Point> = (0..2_000).flat_map(|i| [from[i % from.len()], from[(7 * i + 3) % from.len()]]).collect();
        let (x, y) = (twin.kernel(&pairs).unwrap(), device.kernel(&pairs).unwrap());
        assert!(share(&x, &y, |a, b| close(*a, *b, 1e-12, 1e-4)) < 2e-3, "kernel");

        // What rays carry to nodes and cells, from the same rays.
        let quiet: &mut dyn FnMut(&raycell::Event) -> Flow = &mut |_| Flow::Continue;
        let density = vec![1.0; g.tiles as usize];
        let surface = place_nodes(&mut twin, &g, &density, 100, 0.3, 5, true, &mut Progress::new(quiet)).unwrap();
        let surface =
            raycell::twin::assign::Surface { nodes: surface.nodes.iter().map(|n| Node { gain: 0.5, ..*n }).collect(), ..surface };
        let direct: Vec<DirectSum> = (0..rays.len()).map(|i| DirectSum::once([0.5, 0.1, 0.01 * (i % 9) as f32])).collect();
        let winners: Vec<u32> = (0..rays.len() as u32).map(|i| i % 13).collect();
        let (mut a, mut b) = (twin.upload(&rays).unwrap(), device.upload(&rays).unwrap());
        fn set<E: Engine>(
            engine: &mut E,
            batch: &mut E::Batch,
            surface: &raycell::twin::assign::Surface,
            direct: &[DirectSum],
            winners: &[u32],
        ) {
            engine.set_surface(surface).unwrap();
            engine.set_direct(batch, direct).unwrap();
            engine.set_winners(batch, winners).unwrap();
            engine.assign(batch).unwrap();
        }
        set(&mut twin, &mut a, &surface, &direct, &winners);
        set(&mut device, &mut b, &surface, &direct, &winners);
        let normalise = 0.4 / g.area as f32;
        let (a, b) = ([a], [b]);
        let known = (twin.deposit(&a, true, false, normalise).unwrap(), device.deposit(&b, true, false, normalise).unwrap());
        let unit = raycell::twin::fixed::UNIT;
        let all = |s: &[NodeSource]| s.iter().map(|s| s.value[0].value(unit)).sum::<f64>();
        let (x, y) = (all(&known.0), all(&known.1));
        assert!(x > 0.0 && (x - y).abs() < 1e-3 * x, "deposit: {x} {y}");
        let (x, y) = (
            twin.coefficients(&a, true, normalise, 8_000.0, 13, &mut || Ok(())).unwrap(),
            device.coefficients(&b, true, normalise, 8_000.0, 13, &mut || Ok(())).unwrap(),
        );
        type Sums = raycell::twin::coefficients::Sums;
        let sums = |s: &Sums| {
            let rows = |rows: &[Vec<raycell::layout::Slot>]| rows.iter().flatten().map(|s| s.value.value(unit)).sum::<f64>();
            let flux = s.flux.iter().map(|f| f.flux.value(unit)).sum::<f64>();
            let mass = s.nodes.iter().map(|n| n.mass.value(unit)).sum::<f64>();
            [rows(&s.gather), rows(&s.deposit), flux, mass, s.flux.iter().map(|f| f.source[0].value(unit)).sum()]
        };
        for (x, y) in sums(&x).into_iter().zip(sums(&y)) {
            assert!(x > 0.0 && (x - y).abs() < 1e-3 * x, "coefficients: {x} {y}");
        }
        // Masses take whole rays, flux what arrives: by hand.
        let front = rays.iter().enumerate().filter(|(_, p)| p.kind == kind::FRONT);
        let arrives: f64 = front.map(|(d, p)| f64::from(p.weight) * f64::from(rays[d | 1].density)).sum();
        let [.., flux, mass, _] = sums(&x);
        assert!((flux / f64::from(normalise) / arrives - 1.0).abs() < 1e-4 && mass > flux, "{flux} {arrives} {mass}");
    }
    for k in [kind::FRONT, kind::SKY, kind::BACK, kind::LOST] {
        assert!(kinds.contains(&k), "no way ends as {k}");
    }
}

fn load(files: &[(&str, &str)]) -> raycell::Result<Scene> {
    let mut read = |path: &Path| match files.iter().find(|(name, _)| path == Path::new(name)) {
        Some((_, text)) => Ok(text.as_bytes().to_vec()),
        None => Err(std::io::ErrorKind::NotFound.into()),
    };
    Scene::load_from(Path::new(files[0].0), &LoadOptions::default(), &mut read, &mut |_| Flow::Continue)
}

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

#[test]
fn files_say_mirror() {
    let mtl = |text: &str| {
        let scene = load(&[("s.obj", OBJ), ("m.mtl", &format!("newmtl a\n{text}"))]).unwrap();
        (scene.materials[0].clone(), scene.warnings.join("\n"))
    };
    let silver = |x: f64| Material::new_mirror("a", x);
    assert_eq!(mtl("Kd 0 0 0\nKs 0.9\nillum 3\nNs 1000\n"), (silver(0.9), String::new()));
    assert_eq!(mtl("Kd 0.8\nPm 1\nPr 0\n"), (silver(0.8), String::new()));
    // Tints and what lies beside are told of.
    let (m, told) = mtl("Kd 0.1\nKs 0.9 0.6 0.3\nillum 5\n");
    assert!((m.mirror - 0.6).abs() < 1e-12 && m.reflectance == [0.0; 3], "{m:?}");
    assert!(
        told.contains("Kd is left out") && told.contains("grey one of 0.600") && !told.contains("not supported and"),
        "{told}"
    );
    let (m, told) = mtl("Kd 0\nKs 1 1 1\nillum 3\n");
    assert!(m.mirror == 0.98 && told.contains("reflects everything"), "{told}");
    // Gloss over paint, rough metals and lamps stay what they were, with a word.
    for text in ["Kd 0.5\nKs 0.2\nillum 3\n", "Kd 0.5\nKs 0.6\nillum 2\n", "Kd 0.5\nPm 1\nPr 0.3\n", "Kd 0.5\nPm 1\n"] {
        let (m, told) = mtl(text);
        assert!(m.mirror == 0.0 && m.reflectance == [0.5; 3] && told.contains("not supported and left out"), "{text}: {told}");
    }
    assert_eq!(mtl("Kd 0\nKs 1\nillum 3\nKe 1 1 1\n").0.mirror, 0.0);

    let toml = |text: &str| load(&[("s.toml", &format!("{ROOM}{text}"))]);
    let scene = toml("[[material]]\nname = \"a\"\nmirror = 0.9\n").unwrap();
    assert_eq!((scene.materials[0].clone(), scene.warnings.len()), (silver(0.9), 0));
    for (text, part) in [
        ("mirror = 1.0\n", "in [0, 1)"),
        ("mirror = -0.5\n", "in [0, 1)"),
        ("mirror = 0.5\nreflectance = 0.5\n", "beside a reflectance"),
        ("mirror = 0.5\nradiance = 1\n", "light of its own"),
    ] {
        let told = toml(&format!("[[material]]\nname = \"a\"\n{text}")).unwrap_err().to_string();
        assert!(told.contains(part) && told.contains("s.toml:"), "{text}: {told}");
    }
}

pub const ROOM: &str =
    "[[mesh]]\nname = \"m\"\nmaterial = \"a\"\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]\n";
