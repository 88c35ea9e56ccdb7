//! The doctor: one fault is found by its name, its object and its cure, and nothing else; what is sound is
//! left in peace.

use raycell::doctor::{Check, Finding, Severity, examine};
use raycell::scene::{LoadOptions, Material};
use raycell::{Error, Scene};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn findings(name: &str) -> Vec<Finding> {
    examine(&Scene::read(path(name)).unwrap()).unwrap()
}

/// Scenes with one fault each: what must be found, in which object (none: the whole scene), the number and a
/// part of the cure. `tests/data/broken/make.py` makes them.
const BROKEN: &[(&str, Check, Option<&str>, f64, &str)] = &[
    ("degenerate", Check::Degenerate, Some("crate"), 1.0, "merge their vertices"),
    ("duplicate", Check::Duplicate, Some("floor"), 2.0, "delete the copy"),
    ("flipped", Check::Flipped, Some("crate"), 12.0, "flip their normals"),
    ("flipped_face", Check::Flipped, Some("crate"), 1.0, "flip their normals"),
    ("flipped_wall", Check::Flipped, Some("left"), 2.0, "flip their normals"),
    ("hole", Check::Open, Some("crate"), 1.0, "fill the missing faces"),
    ("slit", Check::Open, Some("left"), 0.004, "snap the edges"),
    ("intersecting", Check::Intersecting, Some("left"), 8.0, "move them apart"),
    ("overlapping", Check::Overlapping, Some("floor"), 2.0, "move one off the other"),
    ("far", Check::FarFromOrigin, None, 1e6, "move it to the origin"),
    ("kilometres", Check::Unit, None, 5000.0, "--unit"),
    ("tiny", Check::Unit, None, 0.005, "--unit"),
    ("reflectance", Check::Reflectance, Some("floor"), 1.2, "below 1 (a white wall"),
    ("nan", Check::Reflectance, Some("floor"), f64::NAN, "below 1 (a white wall"),
    ("lamp_away", Check::EmitterFacingAway, Some("lamp"), 2.0, "turn the lamp round"),
    ("no_emitter", Check::NoEmitter, None, 0.0, "Ke"),
];

#[test]
fn one_fault_is_one_finding() {
    for &(name, check, object, number, cure) in BROKEN {
        let file = format!("tests/data/broken/{name}.obj");
        let found = findings(&file);
        assert_eq!(found.iter().map(|f| f.check).collect::<Vec<_>>(), [check], "{name}: {found:#?}");
        let f = &found[0];
        assert_eq!(f.object, object.map_or(path(&file).display().to_string(), String::from), "{name}");
        // Numbers are counts, or lengths that single precision has rounded: to 2^-24 of the room, and on the way.
        let right = if number.is_nan() { f.number.is_nan() } else { (f.number - number).abs() <= 1e-6 + 1e-5 * number };
        assert!(right, "{name}: {} {}", f.number, f.unit);
        assert!(f.cure.contains(cure), "{name}: {f}");
        assert!(f.message.contains(&f.object), "{name}: {f}");
        assert_eq!(f.severity == Severity::Error, check == Check::Reflectance, "{name}");
    }
}

#[test]
fn pairs_are_named() {
    for (name, pair) in [("intersecting", ["left", "crate"]), ("overlapping", ["floor", "rug"]), ("slit", ["left", "floor"])] {
        let f = &findings(&format!("tests/data/broken/{name}.obj"))[0];
        assert_eq!([Some(f.object.as_str()), f.other.as_deref()], pair.map(Some), "{name}");
    }
}

#[test]
fn examples_point_at_the_fault() {
    let f = &findings("tests/data/broken/slit.obj")[0];
    let [x, y, _] = f.place.unwrap();
    assert!(x.abs() < 1e-5 && (y - 0.002).abs() < 1e-5, "{f}");
    let scene = Scene::read(path("tests/data/broken/flipped_face.obj")).unwrap();
    let f = &examine(&scene).unwrap()[0];
    let face = scene.faces[f.face.unwrap() as usize];
    assert_eq!(scene.objects[face.object as usize], "crate");
}

#[test]
fn what_is_sound_is_left_in_peace() {
    assert_eq!(findings("tests/data/broken/sound.obj"), []);
    // Every scene that is shipped, in every format.
    let mut seen = 0;
    for folder in std::fs::read_dir(path("scenes")).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()) {
        for file in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if ["obj", "gltf", "glb", "toml"].iter().any(|e| file.extension().is_some_and(|x| x == *e)) {
                let mut found = examine(&Scene::read(&file).unwrap()).unwrap();
                // The court's lights are in its TOML.
                if file.ends_with("court.obj") {
                    assert_eq!(found.remove(0).check, Check::NoEmitter);
                }
                assert_eq!(found, [], "{}", file.display());
                seen += 1;
            }
        }
    }
    assert!(seen >= 6, "{seen}");
}

#[test]
fn the_cures_that_are_flags_cure() {
    let cured = |name: &str, change: &dyn Fn(&mut LoadOptions)| {
        let mut options = LoadOptions::default();
        change(&mut options);
        let scene = Scene::read_with(path(&format!("tests/data/broken/{name}.obj")), &options).unwrap();
        assert_eq!(examine(&scene).unwrap(), [], "{name}");
    };
    cured("kilometres", &|o| o.unit = 0.001);
    cured("tiny", &|o| o.unit = 1000.0);
    for name in ["flipped", "flipped_face", "flipped_wall"] {
        cured(name, &|o| o.two_sided = true);
    }
}

#[test]
fn no_heap_of_triangles_is_too_odd() {
    // On a coarse grid everything happens at once: shared corners, folds, covers, crossings, thin triangles.
    let grey = Material::new("grey", [0.5; 3], [0.0; 3]);
    let lamp = Material::new("lamp", [0.0; 3], [1.0; 3]);
    let mut state = 1u32;
    let mut die = |sides: u32| {
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        (state >> 16) % sides
    };
    let mut found = 0;
    for round in 0..200 {
        let count = 1 + die(80);
        // Up to what 32-bit floats hold; what lies beyond is no scene.
        let scale = [1.0, 1e-30, 1e30, 1e38][round % 4];
        let triangles: Vec<_> =
            (0..count).map(|_| ([(); 3].map(|_| [(); 3].map(|_| scale * die(4) as f64)), die(8) / 7)).collect();
        match examine(&Scene::from_triangles("heap", &triangles, vec![grey.clone(), lamp.clone()]).unwrap()) {
            Ok(findings) => found += findings.len(),
            Err(e) => assert!(matches!(e, Error::EmptyScene { .. }), "{e}"),
        }
    }
    assert!(found > 400, "{found}");
}

/// Runs the program on a broken scene.
fn doctor(name: &str, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raycell"));
    command.args(["doctor", path(name).to_str().unwrap()]).args(more).output().unwrap()
}

#[test]
fn the_exit_code_tells() {
    for (name, code, line) in [
        ("tests/data/broken/sound.obj", 0, ""),
        ("tests/data/broken/flipped.obj", 1, "flipped: object 'crate': 12 triangles"),
        ("tests/data/broken/reflectance.obj", 1, "reflectance: object 'floor', "),
        ("tests/data/broken/gone.obj", 2, ""),
    ] {
        let output = doctor(name, &[]);
        assert_eq!(output.status.code(), Some(code), "{name}");
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.starts_with(line) && text.lines().count() == usize::from(code == 1), "{name}: {text}");
    }
}

#[test]
fn json_has_all_of_it() {
    let output = doctor("tests/data/broken/slit.obj", &["--json"]);
    assert_eq!(output.status.code(), Some(1));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let f = &report["findings"][0];
    assert_eq!([&f["check"], &f["severity"], &f["object"], &f["other"]], ["open", "warning", "left", "floor"]);
    assert_eq!(f["unit"], "m");
    assert!(f["number"].as_f64().is_some() && f["place"][1].as_f64().is_some() && f["face"].is_u64());
    let sound: serde_json::Value = serde_json::from_slice(&doctor("tests/data/broken/sound.obj", &["--json"]).stdout).unwrap();
    assert_eq!(sound["findings"], serde_json::json!([]));
}

#[test]
fn a_bake_warns_in_the_same_words() {
    let out = tempfile::tempdir().unwrap();
    for name in ["degenerate", "duplicate", "far", "no_emitter"] {
        let file = format!("tests/data/broken/{name}.obj");
        let said = findings(&file)[0].to_string();
        let mut command = Command::new(env!("CARGO_BIN_EXE_raycell"));
        command.arg("bake").arg(path(&file)).args(["--backend", "cpu", "--rays", "1024", "-o"]).arg(out.path());
        let output = command.output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{name}: {stderr}");
        assert!(stderr.contains(&format!("warning: {said}")), "{name}: {said}\n{stderr}");
        let report: serde_json::Value = serde_json::from_slice(&std::fs::read(out.path().join("report.json")).unwrap()).unwrap();
        assert!(report["warnings"].as_array().unwrap().iter().any(|w| *w == *said), "{name}: {}", report["warnings"]);
    }
}
