//! Drivers that are missing, misnamed, lost, or out of memory: a typed error each, and never a panic.

use raycell::gpu::{Gpu, device};
use raycell::selftest::{Spoil, run_with};
use raycell::{Backend, Error, Event, Flow, Params, Scene, bake};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;

fn open() -> device::OpenDevice {
    device::open(device::BackendChoice::Auto, None).expect("a Vulkan driver: ci/setup installs one")
}

fn furnace() -> String {
    format!("{}/scenes/furnace/scene.obj", env!("CARGO_MANIFEST_DIR"))
}

/// Runs the program in `dir` with variables set.
fn run(dir: &Path, variables: &[(&str, &str)], args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raycell"));
    command.current_dir(dir).args(args).envs(variables.iter().copied()).output().unwrap()
}

/// A machine without a driver: Mesa and the Vulkan loader find nothing.
const BARE: &[(&str, &str)] = &[
    ("VK_DRIVER_FILES", "/nonexistent"),
    ("VK_ICD_FILENAMES", "/nonexistent"),
    ("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent"),
    ("LIBGL_DRIVERS_PATH", "/nonexistent"),
];

#[test]
fn without_a_driver_the_cure_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let scene = furnace();
    let output = run(dir.path(), BARE, &["bake", &scene, "-o", "out"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{stderr}");
    for part in ["raycell: error: no usable GPU device", "ci/setup", "--backend cpu"] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);

    let output = run(dir.path(), BARE, &["adapters"]);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0));
    assert!(stdout.starts_with("no adapter; ci/setup") && stdout.contains("--backend cpu"), "{stdout}");

    // What needs no device does not ask for one.
    assert_eq!(run(dir.path(), BARE, &["doctor", &scene]).status.code(), Some(0));
    let output = run(dir.path(), BARE, &["bake", &scene, "--backend", "cpu", "--rays", "1024", "-o", "out"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn what_is_asked_for_and_not_there_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let there = open().info.name;
    for (variable, value, known) in [
        ("WGPU_BACKEND", "abacus", "vulkan, metal, dx12, gl"),
        ("WGPU_BACKEND", "vulkan,abacus", "vulkan, metal, dx12, gl"),
        ("WGPU_POWER_PREF", "enormous", "low, high, none"),
        ("WGPU_ADAPTER_NAME", "no-such-thing", there.as_str()),
    ] {
        let output = run(dir.path(), &[(variable, value)], &["bake", &furnace(), "-o", "out"]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{variable}={value}: {stderr}");
        assert!(stderr.contains(&format!("raycell: error: {variable}={value}")), "{stderr}");
        assert!(stderr.contains(known) && stderr.contains("--backend cpu"), "{stderr}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    // The listing says of each adapter why not; a variable without a meaning stops it, too.
    let output = run(dir.path(), &[("WGPU_ADAPTER_NAME", "no-such-thing")], &["adapters"]);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(stdout.contains("not used, its name does not contain 'no-such-thing'") && !stdout.contains("would be"), "{stdout}");
    assert_eq!(run(dir.path(), &[("WGPU_BACKEND", "abacus")], &["adapters"]).status.code(), Some(3));
}

#[test]
fn wgpus_variables_are_heeded() {
    let dir = tempfile::tempdir().unwrap();
    let name = open().info.name;
    let chosen = |variables: &[(&str, &str)], args: &[&str]| -> Vec<(String, String)> {
        let output = run(dir.path(), variables, args);
        let listed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let lines = listed["adapters"].as_array().unwrap().clone();
        let chosen = lines.into_iter().filter(|a| a["chosen"] == true);
        chosen.map(|a| (a["name"].as_str().unwrap().into(), a["backend"].as_str().unwrap().into())).collect()
    };
    let list = ["adapters", "--json"];
    let usual = chosen(&[], &list);
    assert_eq!(usual.len(), 1);
    assert_eq!(usual[0].0, name);
    for variables in [
        [("WGPU_ADAPTER_NAME", name.as_str())],
        [("WGPU_BACKEND", usual[0].1.as_str())],
        [("WGPU_BACKEND", "")],
        [("WGPU_ADAPTER_NAME", "")],
        [("WGPU_POWER_PREF", "none")],
    ] {
        assert_eq!(chosen(&variables, &list), usual, "{variables:?}");
    }
    // Metal and DX12 are on no one machine; flags win over variables.
    let foreign = if cfg!(windows) { "metal" } else { "dx12" };
    assert_eq!(chosen(&[("WGPU_BACKEND", foreign)], &list), []);
    let flag = ["adapters", "--json", "--backend", &usual[0].1];
    assert_eq!(chosen(&[("WGPU_BACKEND", foreign)], &flag), usual);
}

#[test]
fn a_lost_device_is_told_as_such() {
    let scene = Scene::load(furnace()).unwrap();
    let params = Params { rays: 16_384, ..Params::default() };
    // Lost before the first kernel, among the rays, and while it solves.
    for stage in ["pilot", "train", "solve"] {
        let open = open();
        let gpu = Gpu::new(&open.device, &open.queue).unwrap();
        let result = bake(&Backend::Gpu(Arc::new(gpu)), &scene, &params, &mut |event| {
            if matches!(event, Event::Stage { name } if *name == stage) {
                open.device.destroy();
            }
            Flow::Continue
        });
        // By itself, as in a host that has handlers of its own; and as the program sees it.
        assert!(matches!(result, Err(Error::DeviceLost { .. })), "{stage}: {:?}", result.err());
        let judged = open.watch.judge("the bake", result);
        assert!(matches!(judged, Err(Error::DeviceLost { .. })), "{stage}: {:?}", judged.err());
    }
}

#[test]
fn too_much_memory_is_a_limit() {
    let open = open();
    let gpu = Gpu::new(&open.device, &open.queue).unwrap();
    for len in [1 << 40, usize::MAX] {
        let error = gpu.alloc::<u32>("everything", len).unwrap_err();
        assert!(matches!(error, Error::Limit { .. }), "{error:?}");
        assert!(error.to_string().contains("'everything'"), "{error}");
    }
}

#[test]
fn this_driver_passes_the_self_test() {
    let dir = tempfile::tempdir().unwrap();
    let output = run(dir.path(), &[], &["selftest", "--json"]);
    let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((output.status.code(), told["failed"].to_string().as_str()), (Some(0), "[]"), "{told:#}");
    let outcomes = told["outcomes"].as_array().unwrap();
    assert!(outcomes.len() >= 60 && told["cases"].as_u64().unwrap() >= 25, "{told:#}");
    // What it says is what passes: a number within its tolerance.
    for o in outcomes {
        let number = |key: &str| o[key].as_f64().unwrap();
        assert!((number("got") - number("truth")).abs() <= number("tolerance"), "{o}");
        assert_eq!((&o["pass"], &o["error"]), (&true.into(), &serde_json::Value::Null), "{o}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn the_self_test_finds_what_is_wrong() {
    let open = open();
    let gpu = Backend::Gpu(Arc::new(Gpu::new(&open.device, &open.queue).unwrap()));
    let failed = |cases: &[&str], spoil: Spoil| -> (usize, usize) {
        let names: Vec<String> = cases.iter().map(|c| c.to_string()).collect();
        let outcomes = run_with(&gpu, &names, spoil, &mut |_| Flow::Continue).unwrap();
        (outcomes.iter().filter(|o| !o.pass).count(), outcomes.len())
    };
    // Light that is solved for with another norm than its truth has.
    assert_eq!(failed(&["E19"], Spoil::Nothing).0, 0);
    let (wrong, all) = failed(&["E19"], Spoil::Norm);
    assert!(wrong == all && all == 4, "{wrong} of {all}");
    // Other truths: also those that are exact.
    let (wrong, all) = failed(&["H06", "H10", "G01", "A06", "A11", "A12", "A17", "D02", "E13"], Spoil::Truths);
    assert!(wrong == all && all >= 20, "{wrong} of {all}");
    // A device that is gone is an error of its own.
    open.device.destroy();
    let lost = run_with(&gpu, &["A11".into()], Spoil::Nothing, &mut |_| Flow::Continue);
    assert!(matches!(lost, Err(Error::DeviceLost { .. })), "{lost:?}");
}

/// Set in the child that [`memory_that_runs_out_is_told_as_such`] starts.
const CHILD: &str = "RAYCELL_TEST_OUT_OF_MEMORY";

/// A driver in host memory runs out where the process may not have more: in a child with 4 GiB.
#[test]
#[cfg(target_os = "linux")]
fn memory_that_runs_out_is_told_as_such() {
    if std::env::var_os(CHILD).is_some() {
        let open = open();
        let gpu = Gpu::new(&open.device, &open.queue).unwrap();
        let mut held = Vec::new();
        let error = loop {
            match gpu.alloc::<u32>("one of many", 16 << 20) {
                Ok(vec) => held.push(vec),
                Err(e) => break e,
            }
            assert!(held.len() < 128, "8 GiB were had of 4");
        };
        assert!(matches!(error, Error::OutOfMemory { .. }), "{error:?}");
        assert!(error.to_string().contains("--rays"), "{error}");
        return;
    }
    if open().info.device_type != raycell::wgpu::DeviceType::Cpu {
        return; // a GPU's memory is not the process's
    }
    let this = std::env::current_exe().unwrap();
    let script = format!("ulimit -v 4194304; exec '{}' memory_that_runs_out", this.display());
    let output = Command::new("sh").args(["-c", &script]).env(CHILD, "1").output().unwrap();
    assert!(output.status.success(), "{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
}
