//! Other light on a solved network, held against bakes of the changed scene.
//!
//! Without any adapter the tests that bake pass with a note, unless `RAYCELL_REQUIRE_GPU` is set.

mod common;

use common::{gpu, radiosity, root, rrmse, truth};
use raycell::output::report::{RelitReport, Report};
use raycell::relight::Retrace;
use raycell::scene::{Material, shapes};
use raycell::{Backend, Change, Error, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::process::Command;
use std::time::Instant;

/// Rays of the bakes: the network is coarse, and so is what the bakes state.
const RAYS: u32 = 65_536;

fn cornell() -> Scene {
    Scene::load(root("scenes/cornell/scene.obj")).unwrap()
}

fn baked(backend: &Backend, scene: &Scene, params: &Params) -> Solution {
    bake(backend, scene, params, &mut |_| Flow::Continue).unwrap()
}

fn relit(from: &Solution, backend: &Backend, change: &Change) -> Solution {
    from.relight(backend, change, &mut |_| Flow::Continue).unwrap()
}

fn told(solution: &Solution) -> &RelitReport {
    solution.report().relit.as_ref().unwrap()
}

fn emission(of: &[(&str, [f64; 3])]) -> Change {
    Change { emission: of.iter().map(|(name, e)| (name.to_string(), *e)).collect(), ..Change::default() }
}

fn reflectance(of: &[(&str, [f64; 3])]) -> Change {
    Change { reflectance: of.iter().map(|(name, rho)| (name.to_string(), *rho)).collect(), ..Change::default() }
}

/// The three changes that relighting is for.
fn cases() -> [(&'static str, Change); 3] {
    [
        ("a new lamp colour", emission(&[("light", [4.0, 12.0, 17.0])])),
        ("the lamp off, a wall lit", emission(&[("light", [0.0; 3]), ("red", [3.0, 2.0, 2.0])])),
        ("new paint on half of it", reflectance(&[("white", [0.4, 0.5, 0.3])])),
    ]
}

/// A scene with such a change, made by hand.
fn changed(mut scene: Scene, change: &Change) -> Scene {
    for m in &mut scene.materials {
        for (_, e) in change.emission.iter().filter(|(name, _)| *name == m.name) {
            m.emission = *e;
        }
        for (_, rho) in change.reflectance.iter().filter(|(name, _)| *name == m.name) {
            m.reflectance = *rho;
        }
    }
    scene
}

fn light(solution: &Solution, backend: &Backend, points: &[SurfacePoint]) -> Vec<[f64; 3]> {
    radiosity(&solution.query(backend, points).unwrap())
}

#[test]
fn relit_is_as_baked_within_what_both_state() {
    let Some(backend) = gpu().map(Backend::Gpu) else { return };
    let params = Params { rays: RAYS, ..Params::default() };
    let from = baked(&backend, &cornell(), &params);
    let points = truth("cornell").points;
    let before = light(&from, &backend, &points);
    for (name, change) in cases() {
        // The network's own answer, also where the bake's word would have rays traced anew.
        let frozen = relit(&from, &backend, &Change { retrace: Retrace::Never, ..change.clone() });
        let full = baked(&backend, &changed(cornell(), &change), &params);
        let [b, truth] = [&frozen, &full].map(|s| light(s, &backend, &points));
        let [mine, its] = [&frozen, &full].map(|s| s.report().estimated_error.clone().unwrap());
        let (off, moved) = (rrmse(&b, &truth), rrmse(&before, &truth));
        eprintln!(
            "{name}: off by {off:.4} (before {moved:.3}), stated {:.4} to {:.4} and {:.4} to {:.4}; {:?}",
            mine.low,
            mine.high,
            its.low,
            its.high,
            told(&frozen)
        );
        assert!(off < mine.high.hypot(its.high), "{name}: {off} {mine:?} {its:?}");
        // Twice what two seeds of a bake differ by is far below what the change makes.
        assert!(off < 0.05 && moved > 5.0 * off, "{name}: {off} {moved}");
        let how = told(&frozen);
        assert_eq!(how.how, if name.contains("colour") { "scaled" } else { "solved" });
        assert!(how.known.unwrap() > 0.5 && how.extra_error.unwrap() < 0.1, "{how:?}");
        if name.contains("wall") {
            assert!(how.effective_rays.unwrap() < 0.8 * f64::from(RAYS), "rays were drawn for the lamp: {how:?}");
        }

        // Where nobody says how, it is either the network's answer, or a bake and says so.
        let auto = relit(&from, &backend, &change);
        match told(&auto).how.as_str() {
            "re-traced" => {
                assert!(told(&auto).why.contains("tuned for other light"), "{:?}", told(&auto));
                assert!(light(&auto, &backend, &points) == truth, "{name}: a re-trace is a bake of the changed scene");
            }
            _ => assert_eq!(auto.light(), frozen.light(), "{name}"),
        }
    }
}

/// A closed room of one reflectance that shines everywhere: radiosity is E / (1 - rho).
fn furnace() -> Scene {
    let room = shapes::room([0.0; 3], [1.0, 1.2, 0.9], [0, 0, 0, 1, 0, 0]);
    let materials = ["walls", "ceiling"].map(|name| Material::new(name, [0.5; 3], [1.0, 2.0, 3.0]));
    let mut scene = Scene::from_triangles("furnace", &room, materials.into()).unwrap();
    scene.objects = vec!["room".into(), "floor".into()];
    scene.faces[4..6].iter_mut().for_each(|f| f.object = 1);
    scene
}

fn small() -> Params {
    Params { rays: 8_192, direct_samples: 256, gather_rays: 64, ..Params::default() }
}

fn inside() -> Vec<SurfacePoint> {
    let at = |x: f64, z: f64| SurfacePoint { p: [x, 0.0, z], n: [0.0, 1.0, 0.0] };
    vec![at(0.5, 0.5), at(0.2, 0.7), at(0.9, 0.1)]
}

#[test]
fn a_furnace_of_other_reflectance_glows_as_its_series() {
    let backend = Backend::Cpu;
    let from = baked(&backend, &furnace(), &small());
    let rho = [0.8, 0.3, 0.6];
    let hot = relit(&from, &backend, &reflectance(&[("walls", rho), ("ceiling", rho)]));
    assert_eq!(told(&hot).how, "solved");
    for b in light(&hot, &backend, &inside()) {
        for k in 0..3 {
            let exact = std::f64::consts::PI * (k + 1) as f64 / (1.0 - rho[k]);
            assert!((b[k] / exact - 1.0).abs() < 0.01, "band {k}: {} for {exact}", b[k]);
        }
    }
    // From there on the ground is still the bake: as if changed at once.
    let [grey, lit] = [reflectance(&[("walls", [0.4; 3])]), emission(&[("ceiling", [7.0, 2.0, 1.0])])];
    let twice = relit(&relit(&hot, &backend, &grey), &backend, &lit);
    let both = Change { reflectance: vec![("ceiling".into(), rho), ("walls".into(), [0.4; 3])], ..lit };
    assert_eq!(twice.light(), relit(&from, &backend, &both).light());
    assert_ne!(twice.light(), hot.light());
}

#[test]
fn light_groups_scale_exactly() {
    let backend = Backend::Cpu;
    let from = baked(&backend, &furnace(), &small());
    let scale = |s: f64| Change { scale: vec![("walls".into(), s), ("ceiling".into(), s)], ..Change::default() };
    let doubled = relit(&from, &backend, &scale(2.0));
    let points = inside();
    let [one, two] = [&from, &doubled].map(|s| s.query(&backend, &points).unwrap());
    for (one, two) in one.iter().zip(&two) {
        assert_eq!((one.b.map(|x| 2.0 * x), one.d.map(|x| 2.0 * x)), (two.b, two.d), "to the bit");
    }
    assert_eq!(told(&doubled).how, "scaled");
    assert_eq!(told(&doubled).extra_error, Some(0.0));
    let [then, now] = [&from, &doubled].map(|s| s.report());
    assert_eq!(now.energy.absorbed.unwrap(), then.energy.absorbed.unwrap().map(|x| 2.0 * x));
    assert_eq!(then.estimated_error.as_ref().unwrap().high, now.estimated_error.as_ref().unwrap().high);
    // By half, it is the bake's light again, also out of a file.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("doubled.rcell");
    doubled.save(&path).unwrap();
    let read = Solution::load(&path).unwrap();
    assert_eq!(read.query(&backend, &points).unwrap(), two);
    assert_eq!(relit(&read, &backend, &scale(0.5)).light(), from.light());
    // One group of two is no multiple of the bake; both groups' parts add up to the whole.
    let part = |name: &str| {
        let off = Change { scale: vec![(name.into(), 0.0)], retrace: Retrace::Never, ..Change::default() };
        let part = relit(&from, &backend, &off);
        assert_eq!(told(&part).how, "solved");
        light(&part, &backend, &points)
    };
    let (walls, ceiling) = (part("ceiling"), part("walls"));
    for i in 0..points.len() {
        let (sum, all) = (walls[i][1] + ceiling[i][1], one[i].b[1]);
        assert!((sum / all - 1.0).abs() < 0.02, "{} and {} of {all}", walls[i][1], ceiling[i][1]);
    }
    // All off is dark.
    let dark = relit(&from, &backend, &scale(0.0));
    assert!(light(&dark, &backend, &points).iter().flatten().all(|&b| b == 0.0));
}

#[test]
fn an_object_changes_alone() {
    let backend = Backend::Cpu;
    let from = baked(&backend, &furnace(), &small());
    let change = Change { retrace: Retrace::Never, ..reflectance(&[("floor", [0.1; 3])]) };
    let dark = relit(&from, &backend, &change);
    let mut scene = furnace();
    scene.materials.push(Material::new("floor", [0.1; 3], [1.0, 2.0, 3.0]));
    scene.faces.iter_mut().filter(|f| f.object == 1).for_each(|f| f.material = 2);
    let full = baked(&backend, &scene, &small());
    let places = [inside(), vec![SurfacePoint { p: [0.5, 1.2, 0.4], n: [0.0, -1.0, 0.0] }]].concat();
    let [a, b, before] = [&dark, &full, &from].map(|s| light(s, &backend, &places));
    // So few rays have sixteen cells, which blur the floor into the walls around it.
    let stated = [&dark, &full].map(|s| s.report().estimated_error.as_ref().unwrap().high);
    assert!(rrmse(&a, &b) < stated[0].hypot(stated[1]), "{a:?} {b:?} {stated:?}");
    assert!(rrmse(&a, &b) < 0.04 && rrmse(&before, &b) > 0.3, "{a:?} {b:?} {before:?}");
    assert_eq!(dark.scene().materials[2].name, "walls (floor)");
    // It is saved with the bake that it came from.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("dark.rcell");
    dark.save(&path).unwrap();
    let read = Solution::load(&path).unwrap();
    assert_eq!(light(&read, &backend, &places), a);
    let back = relit(&read, &backend, &reflectance(&[("walls (floor)", [0.5; 3])]));
    assert_eq!((told(&back).how.as_str(), back.light()), ("scaled", from.light()));
}

#[test]
fn what_the_network_cannot_carry_is_traced_anew_with_a_word() {
    let backend = Backend::Cpu;
    let mut scene = furnace();
    scene.materials[1] = Material::new("ceiling", [0.0; 3], [1.0; 3]);
    let params = Params { rays: 4_096, ..small() };
    let from = baked(&backend, &scene, &params);
    let paint = reflectance(&[("ceiling", [0.5; 3])]);
    let mut warned = Vec::new();
    let anew = from
        .relight(&backend, &paint, &mut |event| {
            if let raycell::Event::Warning(w) = event {
                warned.push(w.clone());
            }
            Flow::Continue
        })
        .unwrap();
    assert!(warned.iter().any(|w| w.contains("black") && w.contains("traced anew")), "{warned:?}");
    assert!(told(&anew).how == "re-traced" && told(&anew).why.contains("black"), "{:?}", told(&anew));
    assert_eq!(anew.light(), baked(&backend, &changed(scene.clone(), &paint), &params).light());
    let never = from.relight(&backend, &Change { retrace: Retrace::Never, ..paint }, &mut |_| Flow::Continue);
    let said = never.map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("retrace = never") && said.contains("black"), "{said}");
    let asked = relit(&from, &backend, &Change { retrace: Retrace::Always, ..emission(&[("ceiling", [2.0; 3])]) });
    assert_eq!((told(&asked).how.as_str(), told(&asked).why.as_str()), ("re-traced", "it was asked for"));
}

#[test]
fn mistakes_are_named() {
    let backend = Backend::Cpu;
    let from = baked(&backend, &furnace(), &Params { rays: 1_024, ..small() });
    let refuse = |change: Change| from.relight(&backend, &change, &mut |_| Flow::Continue).map(|_| ()).unwrap_err();
    match refuse(emission(&[("lamp", [1.0; 3])])) {
        Error::UnknownName { name, known } => {
            assert!(name == "lamp" && known.contains("ceiling, walls") && known.contains("floor, room"), "{known}")
        }
        other => panic!("{other}"),
    }
    assert!(matches!(refuse(reflectance(&[("walls", [0.5, 1.0, 0.5])])), Error::InvalidReflectance { band: "green", .. }));
    assert!(matches!(refuse(emission(&[("walls", [0.0, 0.0, -1.0])])), Error::InvalidEmission { band: "blue", .. }));
    let scale = Change { scale: vec![("walls".into(), -2.0)], ..Change::default() };
    assert!(matches!(refuse(scale), Error::InvalidParam { name: "scale", .. }));
}

#[test]
fn the_program_relights() {
    let dir = tempfile::tempdir().unwrap();
    let raycell = |args: &str| {
        Command::new(env!("CARGO_BIN_EXE_raycell")).current_dir(dir.path()).args(args.split_whitespace()).output().unwrap()
    };
    let scene = Scene { name: "furnace".into(), ..furnace() };
    let path = dir.path().join("bake.rcell");
    baked(&Backend::Cpu, &scene, &Params { rays: 1_024, ..small() }).save(&path).unwrap();
    std::fs::write(dir.path().join("p.csv"), "px,py,pz,nx,ny,nz\n0.5,0,0.5,0,1,0\n").unwrap();
    let output = raycell("relight bake.rcell --backend cpu --scale room=3 --scale ceiling=3 --points p.csv -o a --json --quiet");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The room holds the floor's material, too: its faces are all but the floor's, which stays.
    assert_eq!(object["relit"]["how"], "solved");
    let report = Report::read(&dir.path().join("a")).unwrap();
    let relit = report.relit.unwrap();
    assert_eq!(relit.from.as_deref(), Some("bake.rcell"));
    assert_eq!(relit.changes, ["scale room=3", "scale ceiling=3"]);
    assert!(dir.path().join("a/points.csv").exists());
    let bytes = std::fs::read(dir.path().join("a/solution.rcell")).unwrap();
    assert!(!String::from_utf8_lossy(&bytes).contains("bake.rcell"), "no path in a solution");
    for (args, part) in [
        ("relight bake.rcell --backend cpu --scale lamp=3 -o b", "nothing is called 'lamp'; there is materials: ceiling, walls"),
        ("relight bake.rcell --backend cpu --emission walls=1,2 -o b", "neither one number nor three"),
        ("relight bake.rcell --backend cpu --emission 1,2,3 -o b", "give a name"),
        ("relight bake.rcell --backend cpu --reflectance walls=1 -o b", "reflectance 1 in the red band"),
        ("relight a/solution.rcell --backend cpu --scale walls=1 -o a", "the solution that is relit lies there"),
        ("relight gone.rcell --backend cpu -o b", "cannot read gone.rcell"),
    ] {
        let output = raycell(args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && stderr.contains(part), "{args}: {stderr}");
    }
    assert!(!dir.path().join("b").exists());
}

/// How much faster than a bake: `cargo test --release --test relight -- --ignored --nocapture faster`, on a quiet machine.
#[test]
#[ignore = "a timing: needs a quiet machine"]
fn faster_than_a_bake_by_twenty() {
    let Some(backend) = gpu().map(Backend::Gpu) else { return };
    let params = Params::default();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("solution.rcell");
    // Kernels are compiled once: the first round is not counted.
    let (mut whole, mut each) = (f64::INFINITY, [f64::INFINITY; 3]);
    for round in 0..4 {
        let start = Instant::now();
        let from = baked(&backend, &cornell(), &params);
        if round > 0 {
            whole = whole.min(start.elapsed().as_secs_f64());
        }
        from.save(&path).unwrap();
        for (i, (_, change)) in cases().into_iter().enumerate() {
            for again in 0..4 {
                let start = Instant::now();
                let from = Solution::load(&path).unwrap();
                let out = relit(&from, &backend, &change);
                assert_ne!(told(&out).how, "re-traced", "{:?}", told(&out));
                if round + again > 0 {
                    each[i] = each[i].min(start.elapsed().as_secs_f64());
                }
            }
        }
    }
    for ((name, _), seconds) in cases().iter().zip(each) {
        eprintln!("{name}: {seconds:.3} s with reading, {:.1} times faster than a bake's {whole:.2} s", whole / seconds);
    }
    assert!(each.iter().all(|s| whole / s >= 20.0), "{whole} {each:?}");
}
