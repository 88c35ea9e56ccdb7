//! An absorbing medium: a sphere's closed form, by every method; a path-traced reference.

use crate::common::rrmse;
use crate::mirrors::{ROOM, backend, radiosity, reference, solve};
use raycell::effects::{Name, analyse};
use raycell::params::{Direct, Method};
use raycell::scene::{Geometry, LoadOptions, Material, shapes};
use raycell::{Backend, Flow, Params, Scene, Solution, SurfacePoint};
use std::f64::consts::PI;
use std::path::Path;

/// Mean share of the light that arrives of a cosine chord in a sphere of optical radius x (chords are 2 R cos, and cosines
/// have the density 2 cos).
fn chord(x: f64) -> f64 {
    0.5 / (x * x) * (1.0 - (1.0 + 2.0 * x) * (-2.0 * x).exp())
}

const RHO: f64 = 0.6;

/// A sphere that shines and reflects everywhere alike, of a radius that gives it the mean chord of one of 1 m: its faces lie
/// within it, and the mean chord of any convex body is 4 V / A.
fn sphere(absorption: f64) -> Scene {
    let shell = shapes::flipped(shapes::sphere(3, 0));
    let corners = |t: &([[f64; 3]; 3], u32)| t.0.map(glam::DVec3::from_array);
    let volume: f64 = shell.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)).abs() / 6.0).sum();
    let area: f64 = shell.iter().map(corners).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
    let radius = 4.0 / 3.0 / (4.0 * volume / area);
    let shell = shapes::moved(shell, |p| p.map(|x| radius * x));
    let scene = Scene::from_triangles("sphere", &shell, vec![Material::new("all", [RHO; 3], [1.0; 3])]).unwrap();
    Scene { absorption, ..scene }
}

fn points(scene: &Scene, count: usize) -> Vec<SurfacePoint> {
    raycell::accuracy::reference::sample_points(&Geometry::new(scene).unwrap(), count, 2)
}

#[test]
fn a_sphere_full_of_a_medium_has_its_closed_form() {
    let Some(gpu) = backend() else { return };
    for (x, backend) in [(0.25, &gpu), (1.5, &gpu), (1.5, &Backend::Cpu)] {
        let scene = sphere(x);
        let t = chord(x);
        let want = PI / (1.0 - RHO * t);
        let points = points(&scene, 48);
        let params = Params { rays: 16_384, direct_samples: 1_024, ..Params::default() };
        let solution = solve(backend, &scene, &params);
        let b = radiosity(backend, &solution, &points);
        let off = rrmse(&b, &vec![[want; 3]; b.len()]);
        let mean = b.iter().map(|b| b[0]).sum::<f64>() / b.len() as f64 / want;
        eprintln!("optical radius {x}: {off:.5}, mean {mean:.5}");
        // 1,280 facets of the right mean chord: chords are spread otherwise by some .1 %.
        assert!(off < 0.015 && (mean - 1.0).abs() < 0.005, "{x}: {off} {mean}");
        // Without the medium B is E/(1 - rho).
        let clear = solve(backend, &Scene { absorption: 0.0, ..scene.clone() }, &params);
        let without = radiosity(backend, &clear, &points);
        assert!(rrmse(&without, &vec![[want; 3]; b.len()]) > 0.2);
        assert!(clear.report().energy.medium.is_none());

        // The account: the medium takes 1 - T of all that is sent.
        let energy = &solution.report().energy;
        let area: f64 = (0..scene.faces.len()).map(|f| scene.area(f)).sum();
        let took = energy.medium.unwrap()[0] / (want * area * (1.0 - t));
        assert!((took - 1.0).abs() < 0.01 && energy.imbalance.unwrap().abs() < 0.01, "{took} {energy:?}");
        assert!(energy.mirrors.is_none() && energy.medium.unwrap()[0] < energy.absorbed.unwrap()[0]);
    }
}

#[test]
fn every_method_knows_the_medium() {
    let Some(backend) = backend() else { return };
    let scene = sphere(1.0);
    let want = PI / (1.0 - RHO * chord(1.0));
    let points = points(&scene, 24);
    let small = Params { rays: 8_192, direct_samples: 512, ..Params::default() };
    for params in [
        Params { method: Method::Rays, ..small.clone() },
        Params { method: Method::Fem, patches: 600, ..small.clone() },
        Params { method: Method::Hierarchical, patches: 600, ..small.clone() },
        Params { direct: Direct::Network, ..small.clone() },
    ] {
        let b = radiosity(&backend, &solve(&backend, &scene, &params), &points);
        let off = rrmse(&b, &vec![[want; 3]; b.len()]);
        eprintln!("{:?} {:?}: {off:.4}", params.method, params.direct);
        assert!(off < 0.03, "{:?}: {off}", params.method);
    }
}

/// A room with a block, open at z = 0: light leaves it, through what medium there is on its way.
fn open_room(absorption: f64) -> Scene {
    let [left, right, floor, ceiling, _, back] = shapes::sides([0.0; 3], [2.0, 1.0, 2.0], [0, 0, 0, 0, 0, 0]);
    let lamp = shapes::quad([[0.6, 0.99, 0.8], [1.2, 0.99, 0.8], [1.2, 0.99, 1.4], [0.6, 0.99, 1.4]], 1);
    let block = shapes::block([0.4, 0.0, 0.5], [0.9, 0.5, 1.0], 0);
    let all = [left, right, floor, ceiling, back, lamp, block].concat();
    let materials = vec![Material::new("white", [0.75, 0.6, 0.5], [0.0; 3]), Material::new("lamp", [0.2; 3], [4.0; 3])];
    Scene { absorption, ..Scene::from_triangles("open", &all, materials).unwrap() }
}

#[test]
fn a_room_full_of_a_medium_meets_its_reference_and_not_without_it() {
    let Some(backend) = backend() else { return };
    let scene = open_room(0.5);
    let (points, truth) = reference(&scene, 96, 4_096);
    let params = Params { rays: 65_536, direct_samples: 2_048, ..Params::default() };
    let solution = solve(&backend, &scene, &params);
    let off = rrmse(&radiosity(&backend, &solution, &points), &truth);
    let mut without = scene.clone();
    "-medium".parse::<raycell::effects::Switches>().unwrap().apply(&mut without).unwrap();
    assert_eq!(without.absorption, 0.0);
    let wrong = rrmse(&radiosity(&backend, &solve(&backend, &without, &params), &points), &truth);
    eprintln!("{off:.4} with the medium, {wrong:.4} without");
    assert!(off < 0.04 && wrong > 3.0 * off, "{off} {wrong}");
    let energy = &solution.report().energy;
    assert!(energy.imbalance.unwrap().abs() < 0.02 && energy.escaped.unwrap()[0] > 0.0, "{energy:?}");
    // A file holds its medium.
    let dir = tempfile::tempdir().unwrap();
    solution.save(&dir.path().join("s.rcell")).unwrap();
    let again = Solution::load(&dir.path().join("s.rcell")).unwrap();
    assert_eq!(again.scene().absorption, 0.5);
    assert_eq!(again.query(&backend, &points[..4]).unwrap(), solution.query(&backend, &points[..4]).unwrap());
    // And the camera looks through it: 1 m through it, from 1 m outside.
    let camera = raycell::solution::Camera {
        eye: [1.5, 0.7, -1.0],
        target: [1.5, 0.7, 2.0],
        up: [0.0, 1.0, 0.0],
        vfov_degrees: 1.0,
        width: 1,
        height: 1,
    };
    let seen = f64::from(again.render(&backend, &camera).unwrap().rgb[0][0]);
    let wall = again.query(&backend, &[SurfacePoint { p: [1.5, 0.7, 2.0], n: [0.0, 0.0, -1.0] }]).unwrap()[0].b[0];
    let want = wall / PI * (-0.5f64 * 2.0).exp();
    // Pictures take fewer samples: 3 % of direct light.
    assert!((seen - want).abs() < 0.08 * want, "{seen} {want}");
}

#[test]
fn the_medium_is_read_and_explained() {
    let load = |text: &str| {
        let text = format!("{text}{ROOM}[[material]]\nname = \"a\"\nreflectance = 0.5\n");
        let mut read = |_: &Path| Ok(text.as_bytes().to_vec());
        Scene::load_from(Path::new("s.toml"), &LoadOptions::default(), &mut read, &mut |_| Flow::Continue)
    };
    assert_eq!(load("[medium]\nabsorption = 0.25\n").unwrap().absorption, 0.25);
    for (text, part) in [
        ("[medium]\nabsorption = -1\n", "0 or more"),
        ("[medium]\nabsorption = nan\n", "0 or more"),
        // What scatters is refused by name.
        ("[medium]\nabsorption = 0.1\nscattering = 0.2\n", "scattering"),
        ("[medium]\nscattering = 0.2\n", "scattering"),
    ] {
        let told = load(text).unwrap_err().to_string();
        assert!(told.contains(part) && told.contains("s.toml:"), "{text}: {told}");
    }
    let bad = Scene { absorption: f64::NAN, ..sphere(0.0) };
    assert!(bad.check().unwrap_err().to_string().contains("absorption = NaN"));

    let effects = |scene: &Scene| analyse(scene).unwrap().into_iter().find(|e| e.name == Name::Medium.word()).unwrap();
    assert!(!effects(&sphere(0.0)).on);
    let on = effects(&sphere(1.0));
    let share = 1.0 - chord(1.0);
    assert!(on.on && (on.share.unwrap() - share).abs() < 0.02, "{on:?} {share}");
}
