//! Light that no surface sends, over mirrors and through a medium: held against integrals, and against a path-traced reference.

use crate::common::rrmse;
use crate::mirrors::{radiosity, reference};
use crate::sky::{UP, backend, direct, floor, near, same_on_the_device, solve};
use raycell::scene::{Environment, Light, LightKind, Material, SkyMap, shapes};
use raycell::{Camera, Params, Scene, SurfacePoint};
use std::f64::consts::PI;

const SIGMA: f64 = 0.4;

/// The integral of what comes from above over cos, by a million directions.
fn from_above(seen: impl Fn([f64; 3]) -> f64) -> f64 {
    let n = 1_000;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let (u, turn) = ((f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n) * 2.0 * PI);
            let r = u.sqrt();
            sum += seen([r * turn.cos(), (1.0 - u).sqrt(), r * turn.sin()]);
        }
    }
    PI * sum / f64::from(n * n)
}

/// How far it is from p to where a box ends.
fn way_out(p: [f64; 3], d: [f64; 3], [low, high]: [[f64; 3]; 2]) -> f64 {
    let side = |k: usize| ((if d[k] > 0.0 { high[k] } else { low[k] }) - p[k]) / d[k];
    (0..3).map(|k| if d[k] == 0.0 { f64::MAX } else { side(k) }).fold(f64::MAX, f64::min)
}

/// The floor of 2 x 2 m, with a speck 1.5 m above a corner: its box is that high.
fn under_haze() -> (Scene, [[f64; 3]; 2]) {
    let quad = shapes::quad([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]], 0);
    let speck = ([[1.0, 1.5, 1.0], [0.999, 1.5, 1.0], [1.0, 1.5, 0.999]], 0);
    let scene = Scene::from_triangles("haze", &[quad, vec![speck]].concat(), vec![Material::new("grey", [0.5; 3], [0.0; 3])]);
    (Scene { absorption: SIGMA, ..scene.unwrap() }, [[-1.0, 0.0, -1.0], [1.0, 1.5, 1.0]])
}

fn places() -> Vec<SurfacePoint> {
    [[0.0, 0.0, 0.0], [0.6, 0.0, -0.3], [-0.95, 0.0, 0.9]].map(|p| SurfacePoint { p, n: UP }).to_vec()
}

#[test]
fn a_sky_above_a_haze_has_its_integral() {
    let (scene, around) = under_haze();
    let l = [0.5, 1.0, 2.0];
    // Of one radiance, and of a map of two halves: what is seen along +x, and along -x.
    let halves = SkyMap { width: 2, height: 1, rgb: vec![[1.0; 3], [3.0; 3]] };
    let along_x = |d: [f64; 3]| if d[0] > 0.0 { 3.0 } else { 1.0 };
    let (even, mapped) = (Environment::constant(l), Environment { radiance: l, ..Environment::mapped(halves) });
    for (what, environment, of) in [("even", even, (|_| 1.0) as fn([f64; 3]) -> f64), ("halves", mapped, along_x)] {
        let scene = Scene { environment: Some(environment), ..scene.clone() };
        for (at, d) in places().iter().zip(direct(&scene, &places(), 256)) {
            let want = from_above(|d| of(d) * (-SIGMA * way_out(at.p, d, around)).exp());
            assert!(near(d, l.map(|l| l * want), 3e-3), "{what} at {:?}: {d:?} {want}", at.p);
            assert!(want < 0.8 * from_above(of));
        }
        same_on_the_device(&scene, what);
    }
}

#[test]
fn suns_points_and_spots_fade_by_what_they_pass() {
    let (scene, around) = under_haze();
    // Within the haze, and above it.
    for (height, within) in [(1.0, 1.0), (4.0, 1.5 / 4.0)] {
        let light = Light::point("bulb", [3.0, 2.0, 1.0], [0.2, height, 0.1]);
        let lit = Scene { lights: vec![light], ..scene.clone() };
        for (at, d) in places().iter().zip(direct(&lit, &places(), 1)) {
            let way = [0.2 - at.p[0], height, 0.1 - at.p[2]];
            let r = way.iter().map(|x| x * x).sum::<f64>().sqrt();
            let fade = (-SIGMA * way_out(at.p, way.map(|x| x / r), around).min(r)).exp();
            if at.p[0] == 0.0 {
                assert!((fade - (-SIGMA * within * r).exp()).abs() < 1e-12);
            }
            assert!(near(d, [3.0, 2.0, 1.0].map(|i| i * height / r.powi(3) * fade), 1e-4), "{height} at {:?}: {d:?}", at.p);
        }
        same_on_the_device(&lit, "bulb");
    }
    let direction = [-0.48, -0.6, 0.64];
    for angle in [0.0, 0.5] {
        let sun = Light { name: "sun".into(), intensity: [5.0; 3], kind: LightKind::Sun { direction, angle } };
        let lit = Scene { lights: vec![sun], ..scene.clone() };
        for (at, d) in places().iter().zip(direct(&lit, &places(), 8)) {
            let want = 5.0 * 0.6 * (-SIGMA * way_out(at.p, direction.map(|x| -x), around)).exp();
            assert!(near(d, [want; 3], 5e-3), "{angle} at {:?}: {d:?} {want}", at.p);
        }
        same_on_the_device(&lit, "sun");
    }
    // More than eight, of which eight are drawn.
    let bulbs = (0..12).map(|i| Light::point("bulb", [1.0 + f64::from(i); 3], [0.15 * f64::from(i) - 0.8, 0.5, 0.2])).collect();
    same_on_the_device(&Scene { lights: bulbs, ..scene }, "many bulbs");
}

/// A floor with a mirror of 2 m by 1 m along its edge at x = -1.
fn beside_a_mirror(rho: f64, mirror: f64) -> Scene {
    let quad = shapes::quad([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]], 0);
    let wall = shapes::quad([[-1.0, 0.0, 1.0], [-1.0, 0.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, 1.0, 1.0]], 1);
    let materials = vec![Material::new("grey", [rho; 3], [0.0; 3]), Material::new_mirror("silver", mirror)];
    Scene::from_triangles("beside", &[quad, wall].concat(), materials).unwrap()
}

#[test]
fn a_mirror_sends_the_sky_on() {
    let mirror = 0.8;
    let halves = SkyMap { width: 2, height: 1, rgb: vec![[1.0; 3], [3.0; 3]] };
    let along_x = |d: [f64; 3]| if d[0] > 0.0 { 3.0 } else { 1.0 };
    let skies = [
        ("even", Environment::constant([1.0; 3]), (|_| 1.0) as fn([f64; 3]) -> f64),
        ("halves", Environment::mapped(halves), along_x),
    ];
    for (what, environment, of) in skies {
        for absorption in [0.0, SIGMA] {
            let scene = Scene { environment: Some(environment.clone()), absorption, ..beside_a_mirror(0.5, mirror) };
            let around = [[-1.0, 0.0, -1.0], [1.0, 1.0, 1.0]];
            let want = |p: [f64; 3], mirror: f64| {
                from_above(|d| {
                    let t = (-1.0 - p[0]) / d[0];
                    let meets = [p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]];
                    let fade = |length: f64| (-absorption * length).exp();
                    if t > 0.0 && meets[1] < 1.0 && meets[2].abs() < 1.0 {
                        let back = [-d[0], d[1], d[2]];
                        return mirror * of(back) * fade(t + way_out(meets, back, around));
                    }
                    of(d) * fade(way_out(p, d, around))
                })
            };
            for (at, d) in places().iter().zip(direct(&scene, &places(), 512)) {
                let (with, without) = (want(at.p, mirror), want(at.p, 0.0));
                assert!(near(d, [with; 3], 5e-3), "{what} {absorption} at {:?}: {d:?} {with}", at.p);
                assert!(at.p[0] > 0.5 || with > 1.05 * without, "the mirror matters: {with} {without}");
            }
            same_on_the_device(&scene, what);
        }
    }
    // The camera sees the sky in the mirror: that of +x.
    let sky = Environment::mapped(SkyMap { width: 2, height: 1, rgb: vec![[1.0; 3], [3.0; 3]] });
    let scene = Scene { environment: Some(sky), ..beside_a_mirror(0.5, mirror) };
    let Some(backend) = backend() else { return };
    let solution = solve(&backend, &scene, &Params { rays: 2_048, ..Params::default() });
    let camera = Camera { eye: [0.5, 0.5, 0.0], target: [-1.0, 0.6, 0.0], up: UP, vfov_degrees: 1.0, width: 1, height: 1 };
    let seen = f64::from(solution.render(&backend, &camera).unwrap().rgb[0][0]);
    assert!((seen - 3.0 * mirror).abs() < 1e-4, "{seen}");
}

#[test]
fn only_lamps_without_a_surface_are_missing_over_mirrors() {
    let Some(backend) = backend() else { return };
    let told = |scene: &Scene| -> Vec<String> {
        let solution = solve(&backend, scene, &Params { rays: 1_024, ..Params::default() });
        solution.report().warnings.iter().filter(|w| w.contains("over mirrors") || w.contains("absorbed")).cloned().collect()
    };
    let sky = Scene { environment: Some(Environment::constant([1.0; 3])), absorption: 0.1, ..beside_a_mirror(0.5, 0.8) };
    assert_eq!(told(&sky), [""; 0]);
    let bulb = Light::point("bulb", [1.0; 3], [0.0, 0.5, 0.0]);
    let lit = Scene { lights: vec![bulb.clone()], ..sky };
    let words = told(&lit);
    assert!(words.len() == 1 && words[0].contains("suns, points and spots"), "{words:?}");
    assert_eq!(told(&Scene { lights: vec![bulb], absorption: 0.1, ..floor(0.5) }), [""; 0]);
}

/// A hazy yard: a block before a mirror, under a sky that is brighter on one side, with a lamp.
fn yard() -> Scene {
    let mut scene = beside_a_mirror(0.6, 0.85);
    let block = shapes::block([-0.4, 0.0, -0.3], [0.0, 0.5, 0.2], 0);
    let beside = Scene::from_triangles("block", &block, scene.materials.clone()).unwrap();
    let first = scene.vertices.len() as u32;
    scene.vertices.extend(beside.vertices);
    scene.faces.extend(beside.faces.iter().map(|f| {
        let mut face = *f;
        face.vertices.iter_mut().for_each(|v| *v += first);
        face.object = 0;
        face
    }));
    scene.environment =
        Some(Environment::mapped(SkyMap { width: 4, height: 2, rgb: (0..8).map(|i| [0.2 + i as f32, 1.0, 2.0]).collect() }));
    scene.absorption = 0.3;
    scene
}

#[test]
fn a_hazy_yard_meets_its_reference_and_not_without_its_parts() {
    let Some(backend) = backend() else { return };
    let scene = yard();
    let (points, truth) = reference(&scene, 96, 4_096);
    let params = Params { rays: 32_768, direct_samples: 2_048, ..Params::default() };
    let off = |scene: &Scene| {
        let solution = solve(&backend, scene, &params);
        let off = rrmse(&radiosity(&backend, &solution, &points), &truth);
        (off, solution.report().energy.imbalance.unwrap())
    };
    let (whole, imbalance) = off(&scene);
    let (dark, _) = off(&Scene { environment: Some(Environment::constant([1.0; 3])), ..scene.clone() });
    let (clear, _) = off(&Scene { absorption: 0.0, ..scene.clone() });
    let mut blind = scene.clone();
    blind.materials[1].mirror = 1e-3;
    let (blind, _) = off(&blind);
    eprintln!("{whole:.4}; another sky {dark:.4}, without haze {clear:.4}, a blind mirror {blind:.4}");
    assert!(whole < 0.03 && imbalance.abs() < 0.02, "{whole} {imbalance}");
    assert!(dark > 3.0 * whole && clear > 3.0 * whole && blind > 3.0 * whole, "{whole}: {dark} {clear} {blind}");
}
