//! Scenes whose records exceed a binding: triangles and hierarchy as texels, lists that tiles share.

use crate::common::{gpu, impossible, open, root};
use glam::DVec3;
use raycell::accuracy::{self, Climb, Goal};
use raycell::gpu::Gpu;
use raycell::layout::Psi;
use raycell::network::{groups, nodes::surface_of, tiles};
use raycell::pass::{self, SceneBuffers, SurfaceBuffers};
use raycell::scene::{Geometry, shapes};
use raycell::{Backend, Checkpoint, Event, Flow, Method, Params, Scene, Solution, SurfacePoint, bake, twin};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Points on the scene, one on each `step`-th face.
fn points(scene: &Scene, step: usize) -> Vec<SurfacePoint> {
    let on = |f: usize| {
        let [a, b, c] = scene.corners(f).map(DVec3::from);
        SurfacePoint { p: ((a + b + c) / 3.0).to_array(), n: (b - a).cross(c - a).normalize().to_array() }
    };
    (0..scene.faces.len()).step_by(step).map(on).collect()
}

/// A bake with its read-out as bytes.
fn bytes(gpu: Arc<Gpu>, scene: &Scene, params: &Params) -> (Vec<u8>, Vec<[f64; 3]>) {
    let backend = Backend::Gpu(gpu);
    let solution = bake(&backend, scene, params, &mut |_| Flow::Continue).unwrap();
    let answers = solution.query(&backend, &points(scene, scene.faces.len().div_ceil(64))).unwrap();
    assert_eq!(impossible(&answers, scene, 0.1), None);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("solution.rcell");
    solution.save(&path).unwrap();
    (std::fs::read(path).unwrap(), answers.iter().map(|a| a.b).collect())
}

/// Every kernel that reads triangles has its paged text run here: all methods, both ways of direct light, both spaces.
#[test]
fn paged_scenes_give_the_same_bytes() {
    let (Some(whole), Some(paged)) = (gpu(), open()) else { return };
    let paged = Arc::new(paged.with_paged_scenes());
    let quick = Params { rays: 8_192, ..Params::default() };
    for (name, params) in [
        ("cornell/scene.obj", quick.clone()),
        ("cornell/scene.obj", Params { direct: raycell::Direct::Network, ..quick.clone() }),
        ("cornell/scene.obj", Params { method: Method::Rays, ..quick.clone() }),
        ("blocker/scene.obj", Params { method: Method::Fem, patches: 300, ..quick.clone() }),
        ("flatland/l_room.toml", quick.clone()),
    ] {
        let scene = Scene::load(root("scenes").join(name)).unwrap();
        let (want, got) = (bytes(whole.clone(), &scene, &params), bytes(paged.clone(), &scene, &params));
        assert!(want == got, "{name} {:?}", params.method);
    }
    assert!(paged.compile_seconds().iter().any(|(name, _)| *name == "kernel"), "fem has run the pass kernel");
}

/// A scene that exceeds bindings of 16 MiB by its triangles alone.
#[test]
fn a_scene_beyond_low_bindings_gives_the_same_bytes() {
    let (Some(whole), Some(low)) = (gpu(), open()) else { return };
    let low = Arc::new(low.with_bindings_of(16 << 20));
    let scene = shapes::bumpy_room(270_000);
    assert!(low.must_page(scene.faces.len() * 64) && !whole.must_page(scene.faces.len() * 64));
    let params = Params { rays: 8_192, ..Params::default() };
    assert!(bytes(whole, &scene, &params) == bytes(low, &scene, &params));
}

/// What tiles share finds the same nodes as lists of their own, on both machines.
#[test]
fn shared_lists_find_the_same_nodes() {
    let scene = shapes::bumpy_room(6_000);
    let mut geometry = Geometry::new(&scene).unwrap();
    assert!(geometry.groups.is_none(), "few tiles have lists of their own");
    let places = tiles::places(&geometry, 3);
    // Every fortieth tile's place is a node.
    let node = |p: &raycell::layout::Point| {
        let tri = &geometry.tris[p.tri as usize];
        raycell::layout::Node { p: p.p, material: tri.material, n: tri.normal, plane: tri.plane, ..Default::default() }
    };
    let nodes: Vec<_> = places.iter().step_by(40).map(node).collect();
    let own = surface_of(&geometry, nodes.clone(), 0.3, false);
    let want = twin::assign::assign(&geometry, &own, &places);
    let groups = groups::group(&geometry);
    geometry.groups = Some(Arc::new(groups));
    let shared = surface_of(&geometry, nodes, 0.3, false);
    assert!(shared.offsets.len() < own.offsets.len(), "{} lists, {} tiles", shared.offsets.len(), own.offsets.len());
    let got = twin::assign::assign(&geometry, &shared, &places);
    let same = |a: &Psi, b: &Psi| a == b;
    let differ = want.iter().zip(&got).filter(|(a, b)| !same(a, b)).count();
    assert_eq!(differ, 0, "of {}", places.len());
    assert!(want.iter().filter(|p| p.node[3] != raycell::layout::NONE).count() > places.len() / 3);

    let Some(gpu) = gpu() else { return };
    let scene = SceneBuffers::new(&gpu, &geometry).unwrap();
    let points = gpu.upload("points", &places).unwrap();
    let order = gpu.upload("order", &(0..places.len() as u32).collect::<Vec<_>>()).unwrap();
    let on = |surface| {
        let psi = pass::assign::assign(&gpu, &scene, &SurfaceBuffers::new(&gpu, surface).unwrap(), &points, &order).unwrap();
        gpu.check_finished().unwrap();
        gpu.read(&psi).unwrap()
    };
    assert!(on(&own) == on(&shared));
}

/// Peak of the process's memory in bytes, which a software driver's device memory is a part of.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| kb * 1024)
}

/// Bakes about so many triangles to an estimated error of 10 %, as `--quality preview` does.
fn preview(gpu: Gpu, triangles: usize) -> Solution {
    let scene = shapes::bumpy_room(triangles);
    eprintln!("{} triangles", scene.faces.len());
    let (backend, begin) = (Backend::Gpu(Arc::new(gpu)), Instant::now());
    let mut tell = |event: &Event| {
        if !matches!(event, Event::Tick | Event::Rays { .. } | Event::Sweep { .. } | Event::Cells { .. }) {
            eprintln!("{:7.1} s, {:5} MiB: {event:?}", begin.elapsed().as_secs_f64(), peak().unwrap_or(0) >> 20);
        }
        Flow::Continue
    };
    let climb = Climb {
        goal: Goal { error: Some(0.1), budget: None },
        checkpoint: &mut Checkpoint::default(),
        solution: None,
        begin,
        reached: &mut |_| Ok(()),
        readout: &mut |_| Ok(Duration::ZERO),
    };
    let solution = accuracy::climb(&backend, &scene, &Params::default(), climb, &mut tell).unwrap();
    let report = solution.report();
    assert_eq!(report.target.as_ref().unwrap().met, Some(true), "{:?}", report.target);
    let answers = solution.query(&backend, &points(&scene, scene.faces.len().div_ceil(200))).unwrap();
    assert_eq!(impossible(&answers, &scene, 0.1), None);
    eprintln!("{:.1} s, {:?}", begin.elapsed().as_secs_f64(), report.extra.get("stages"));
    solution
}

/// Its smaller sibling, [`a_scene_beyond_low_bindings_gives_the_same_bytes`], always runs.
#[test]
#[ignore = "takes minutes: cargo test --release --test hard_cases -- --ignored --nocapture four_million_triangles"]
fn four_million_triangles_bake_within_twelve_gibibytes() {
    let Some(gpu) = open() else { return };
    let solution = preview(gpu, 4_000_000);
    assert!(solution.geometry().tris.len() >= 3_900_000);
    if let Some(peak) = peak() {
        eprintln!("peak {} MiB", peak >> 20);
        assert!(peak < 12 << 30, "{peak} bytes");
    }
}
