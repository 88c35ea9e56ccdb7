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
    (bytemuck::cast_slice(&sums).to_vec(), engine.direct_rays().shadow())
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

/// Bakes a shipped scene with its truth's points, and has its time explained.
fn explained_after(scene: &str, name: &str) -> (String, serde_json::Value) {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().to_str().unwrap();
    let points = format!("tests/data/{name}.truth.csv");
    let args = ["bake", scene, "--rays", "32768", "--points", &points, "-o", out, "--quiet"];
    let baked = Command::new(env!("CARGO_BIN_EXE_raycell")).current_dir(root("")).args(args).output().unwrap();
    assert!(baked.status.success(), "{baked:?}");
    let (json, _) = explain(&[scene, "--after", out, "--json"]);
    (explain(&[scene, "--after", out]).0, serde_json::from_str(&json).unwrap())
}

#[test]
fn after_a_bake_the_dearest_effects_are_named() {
    if backend().is_none() {
        return;
    }
    let shares = |object: &serde_json::Value| -> Vec<(String, f64)> {
        let time = object["time"].as_array().unwrap().iter();
        let shares: Vec<_> = time.map(|t| (t["effect"].as_str().unwrap().to_string(), t["share"].as_f64().unwrap())).collect();
        assert!(shares.iter().all(|(_, s)| *s > 0.0 && *s < 1.0), "{shares:?}");
        assert!(shares.is_sorted_by(|a, b| a.1 >= b.1) && shares.iter().map(|(_, s)| s).sum::<f64>() <= 1.0, "{shares:?}");
        let on = |name: &str| object["effects"].as_array().unwrap().iter().any(|e| e["name"] == name && e["on"] == true);
        assert!(shares.iter().all(|(name, _)| on(name)), "{shares:?}");
        shares
    };
    let (text, object) = explained_after("scenes/cornell/scene.obj", "cornell");
    let cornell = shares(&object);
    assert_eq!(cornell[0].0, "interreflection", "{cornell:?}");
    assert!(
        // On a fast device opening it and reading files take a larger share: .37 was left on an H200.
        cornell.iter().any(|(name, _)| name == "occlusion") && cornell.iter().map(|(_, s)| s).sum::<f64>() > 0.3,
        "{cornell:?}"
    );
    let last = text.lines().last().unwrap();
    assert!(last.contains("most of it for interreflection") && last.matches(" %").count() == 4, "{last}");
    // A court is lit by what has no surface.
    let (text, object) = explained_after("scenes/courtyard/scene.toml", "courtyard");
    let court = shares(&object);
    assert!(court[..3].iter().any(|(name, _)| name == "environment"), "{court:?}");
    assert!(court.iter().any(|(name, _)| name == "lights"), "{court:?}");
    assert!(text.lines().last().unwrap().contains("environment"), "{text}");
    // A convex room casts no shadow.
    let (_, object) = explained_after("scenes/furnace/scene.obj", "furnace");
    assert!(shares(&object).iter().all(|(name, _)| name != "occlusion" && name != "lights"));
}

#[test]
fn a_grey_scene_solves_one_band() {
    let Some(backend) = backend() else { return };
    let scene = |tint: f64| {
        let block = shapes::block([0.3, 0.5, 0.5], [0.7, 1.0, 1.0], 0);
        let room = [shapes::room([0.0; 3], [1.0, 2.0, 3.0], [0, 0, 0, 1, 0, 0]), block].concat();
        let materials = vec![Material::new("wall", [0.5, 0.5, 0.5 + tint], [0.0; 3]), Material::new("lamp", [0.2; 3], [3.0; 3])];
        Scene::from_triangles("room", &room, materials).unwrap()
    };
    // A tint that 64 bits tell from grey and that changes nothing to speak of.
    let (grey, tinted) = (solve(&backend, &scene(0.0), &few()), solve(&backend, &scene(1e-6), &few()));
    let bytes = |s: &Solution| s.report().extra["solve_band_bytes"].as_f64().unwrap();
    let sweeps = |s: &Solution| s.report().solver.sweeps;
    assert_eq!(sweeps(&grey), sweeps(&tinted));
    let share = bytes(&grey) / bytes(&tinted);
    assert!(share <= 1.0 / 3.0, "a grey scene moves {share} of the bytes of bands");
    assert!(grey.light().iter().all(|l| l.h == [l.h[0]; 3]));
}

/// What a program of words says of a scene, with effects switched.
fn switched(words: &str) -> (Solution, String) {
    let mut scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
    words.parse::<raycell::effects::Switches>().unwrap().apply(&mut scene).unwrap();
    let solution = solve(&Backend::Cpu, &scene, &Params { rays: 1_024, ..Params::default() });
    let told = solution.report().warnings.join("; ");
    (solution, told)
}

#[test]
fn effects_are_switched_by_hand() {
    let points = crate::common::truth("cornell").points;
    let mean = |s: &Solution| {
        let shown = s.query(&Backend::Cpu, &points).unwrap();
        let sums = shown.iter().map(|p| p.b.iter().sum::<f64>() / 3.0);
        sums.sum::<f64>() / shown.len() as f64
    };
    let (all, quiet) = switched("auto");
    assert!(!quiet.contains("effects:"), "{quiet}");
    // Without reflections less light, without shadows more; each says that it changed the light.
    let (direct, told) = switched("-interreflection");
    assert!(told.contains("interreflection is off because it was asked off"), "{told}");
    assert_eq!(direct.report().rays, 0);
    let (open, told) = switched("-occlusion");
    assert!(told.contains("occlusion is off because"), "{told}");
    assert_eq!(open.report().extra["shadow_rays"], 0);
    let (all_mean, direct_mean, open_mean) = (mean(&all), mean(&direct), mean(&open));
    assert!(direct_mean < 0.9 * all_mean && open_mean > 1.02 * all_mean, "{direct_mean} {all_mean} {open_mean}");
    // A colour is left out of all bands alike, and the file knows.
    let (grey, _) = switched("-colour");
    let dir = tempfile::tempdir().unwrap();
    grey.save(&dir.path().join("s.rcell")).unwrap();
    let back = Solution::load(&dir.path().join("s.rcell")).unwrap();
    assert_eq!(back.scene().effects.to_string(), "-colour");
    assert!(back.light().iter().all(|l| l.h == [l.h[0]; 3]));
    let mut scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
    for (words, part) in
        [("-direct", "change the scene"), ("+medium", "nothing to switch on"), ("+flatland", "nothing to switch on")]
    {
        let told = words.parse::<raycell::effects::Switches>().unwrap().apply(&mut scene).unwrap_err().to_string();
        assert!(told.contains(part), "{words}: {told}");
    }
}

#[test]
fn small_effects_are_left_out_with_a_word() {
    let mut scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
    raycell::effects::drop_below(&mut scene, 1e-4).unwrap();
    assert_eq!(scene.effects, Default::default());
    // Cornell's shadows are a few percent of its lines of sight; its reflections bring more than a tenth.
    raycell::effects::drop_below(&mut scene, 0.9).unwrap();
    let told = scene.warnings.join("; ");
    assert!(told.contains("occlusion is left out, as its part of the light, about"), "{told}");
    assert!(raycell::effects::drop_below(&mut scene, 1.0).is_err());
}
