//! What a scene does not call for costs nothing: shown by counters, and by the same bytes.

use crate::common::{gpu, impossible, root};
use raycell::engine::Engine;
use raycell::layout::NodeLight;
use raycell::network::tiles;
use raycell::pass::GpuEngine;
use raycell::scene::{Geometry, Material, shapes};
use raycell::twin::TwinEngine;
use raycell::twin::direct::Samples;
use raycell::{Backend, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::process::Command;

fn few() -> Params {
    Params { rays: 16_384, ..Params::default() }
}

fn solve(backend: &Backend, scene: &Scene, params: &Params) -> Solution {
    bake(backend, scene, params, &mut |_| Flow::Continue).unwrap()
}

fn backend() -> Option<Backend> {
    gpu().map(Backend::Gpu)
}

/// What shadow rays decide: direct light, and the nodes that speak for points.
fn found<E: Engine>(engine: &mut E, geometry: &Geometry) -> (Vec<u8>, u64) {
    let starts = tiles::starts(geometry, &vec![0.0; geometry.tiles as usize], 0.0);
    let points = tiles::drawn(geometry, &starts, 7, 4_000);
    let mut batch = engine.upload(&points).unwrap();
    engine.direct(&mut batch, None, 3, 0, 2, Samples { emitter: 4, cosine: 2 }).unwrap();
    let sums = engine.direct_sums(&batch).unwrap();
    (bytemuck::cast_slice(&sums).to_vec(), engine.shadow_rays())
}

#[test]
fn a_convex_room_casts_no_shadow_ray_and_misses_none() {
    let Some(gpu) = gpu() else { return };
    let materials = vec![Material::new("wall", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.2; 3], [3.0; 3])];
    let scene = Scene::from_triangles("room", &shapes::room([0.0; 3], [1.0, 2.0, 3.0], [0, 0, 0, 1, 0, 0]), materials).unwrap();
    let without = Geometry::new(&scene).unwrap();
    assert!(!without.occludes);
    let with = Geometry { occludes: true, ..without.clone() };
    let (a, cast) = found(&mut GpuEngine::new(&gpu, &with).unwrap(), &with);
    let (b, none) = found(&mut GpuEngine::new(&gpu, &without).unwrap(), &without);
    assert_eq!((cast, none), (4_000 * 2 * 4, 0));
    assert!(a == b, "the light differs without shadow rays");
    let (a, cast) = found(&mut TwinEngine::new(&with), &with);
    let (b, none) = found(&mut TwinEngine::new(&without), &without);
    assert_eq!((cast, none), (4_000 * 2 * 4, 0));
    assert!(a == b, "the twin's light differs without shadow rays");
    // And the report says so.
    let backend = Backend::Gpu(gpu);
    assert_eq!(solve(&backend, &scene, &few()).report().extra["shadow_rays"], 0);
    let cornell = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
    assert!(solve(&backend, &cornell, &few()).report().extra["shadow_rays"].as_u64().unwrap() > 0);
}

/// Cornell's geometry and lamp with other reflectances.
fn cornell(rho: f64) -> Scene {
    let mut scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
    scene.materials.iter_mut().for_each(|m| m.reflectance = [rho; 3]);
    scene
}

#[test]
fn black_surfaces_need_no_training() {
    let Some(backend) = backend() else { return };
    let points = crate::common::truth("cornell").points;
    let (black, pale) = (cornell(0.0), cornell(1e-6));
    let solution = solve(&backend, &black, &few());
    let report = solution.report();
    assert_eq!((report.rays, report.cells, report.nodes, report.coefficients), (0, 0, 0, 0));
    assert!(!report.partial && report.energy.imbalance.unwrap().abs() < 0.01, "{:?}", report.energy);
    let answers = solution.query(&backend, &points).unwrap();
    assert_eq!(impossible(&answers, &black, 0.0), None);
    // The same light as where a network would find next to nothing.
    let other = solve(&backend, &pale, &few());
    assert_eq!(other.report().rays, 16_384);
    let other = other.query(&backend, &points).unwrap();
    assert!(answers.iter().all(|a| a.h == a.d));
    let [here, there] = [&answers, &other].map(|all| all.iter().map(|a| a.h).collect::<Vec<_>>());
    // Direct light is sampled to 0.4 % at most points, to some percent in deep penumbras.
    let off = crate::common::rrmse(&here, &there);
    assert!(off < 0.01, "{off}");
    // It is saved and read like any other.
    let dir = tempfile::tempdir().unwrap();
    solution.save(&dir.path().join("s.rcell")).unwrap();
    let again = Solution::load(&dir.path().join("s.rcell")).unwrap();
    assert_eq!(again.light(), &[] as &[NodeLight]);
    assert_eq!(again.query(&backend, &points[..8]).unwrap()[..], solution.query(&backend, &points[..8]).unwrap()[..]);
    let centre = SurfacePoint { p: [2.78, 0.0, 2.0], n: [0.0, 1.0, 0.0] };
    assert!(again.query(&backend, &[centre]).unwrap()[0].h[0] > 0.0);
}

fn explain(args: &[&str]) -> (String, Option<i32>) {
    let out = Command::new(env!("CARGO_BIN_EXE_raycell")).current_dir(root("")).arg("explain").args(args).output().unwrap();
    (String::from_utf8(out.stdout).unwrap(), out.status.code())
}

#[test]
fn a_scene_is_explained() {
    let (text, code) = explain(&["scenes/furnace/scene.obj"]);
    assert_eq!(code, Some(0));
    let line = |name: &str| text.lines().find(|l| l.get(5..).is_some_and(|l| l.starts_with(name))).unwrap().to_string();
    assert!(line("occlusion").starts_with("off") && line("colour").starts_with("off"), "{text}");
    assert!(line("direct").starts_with("on") && line("interreflection").starts_with("on"), "{text}");
    let (text, _) = explain(&["scenes/cornell/scene.obj", "--json"]);
    let object: serde_json::Value = serde_json::from_str(&text).unwrap();
    let effects = object["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 12);
    assert!(effects.iter().all(|e| !e["why"].as_str().unwrap().is_empty() && !e["cost"].as_str().unwrap().is_empty()));
    let of = |name: &str| effects.iter().find(|e| e["name"] == name).unwrap();
    assert!(of("occlusion")["on"] == true && of("colour")["on"] == true && of("flatland")["on"] == false);
}
