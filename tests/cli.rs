//! Black-box tests of the program: exit codes, messages, and nothing written on bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const TRIANGLE: &str = "mtllib s.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A fresh folder in which the program runs.
struct Dir(tempfile::TempDir);

impl Dir {
    fn new() -> Dir {
        Dir(tempfile::tempdir().expect("a temporary folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn with(self, name: &str, text: &str) -> Dir {
        fs::write(self.path(name), text).expect("a file in the temporary folder");
        self
    }

    fn command(&self, args: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raycell"));
        command.current_dir(self.0.path()).args(args.split_whitespace());
        command
    }

    fn run(&self, args: &str) -> Output {
        self.command(args).output().expect("the program starts")
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(self.0.path()).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Runs, and asserts the code, each part of stderr, and that no file was made.
    fn refuses(&self, args: &str, code: i32, parts: &[&str]) {
        let before = self.names();
        let output = self.run(args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "raycell {args}\n~~~\n{stderr}\n~~~");
        for part in parts {
            assert!(stderr.contains(part), "raycell {args}: expected {part:?} in\n~~~\n{stderr}\n~~~");
        }
        assert!(!stderr.contains("panicked"), "{stderr}");
        assert_eq!(self.names(), before, "raycell {args} wrote something");
    }
}

fn grey() -> Dir {
    Dir::new().with("s.obj", TRIANGLE).with("s.mtl", "newmtl m\nKd 0.5 0.5 0.5\nKe 1 1 1\n")
}

#[test]
fn bad_scenes_are_refused_by_name() {
    let dir = || Dir::new().with("s.mtl", "newmtl m\nKd 0.5 0.5 0.5\n");
    let bake = "bake s.obj --backend cpu -o out";
    dir().refuses(bake, 2, &["raycell: error: cannot read s.obj"]);
    for (obj, part) in [
        ("", "s.obj: the scene has no triangle"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "s.obj: the scene has no triangle"),
        ("v 0 0 0\nv 0 nan 0\nf 1 1 2\n", "s.obj:2: vertex 1 is not finite"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "s.obj:4: index 9 is out of range (there are 3)"),
        ("v 0 0 0\nv 1 0\n", "s.obj:2: 'v 1 0' does not hold three numbers"),
        ("\u{0}\u{1}PNG", "s.obj: the scene has no triangle"),
    ] {
        dir().with("s.obj", obj).refuses(bake, 2, &["raycell: error: ", part]);
    }
    for (kd, part) in [("1.5 0 0", "reflectance 1.5 in the red band"), ("0 -1 0", "green"), ("0 0 nan", "blue"), ("x", "s.mtl:2")]
    {
        Dir::new().with("s.obj", TRIANGLE).with("s.mtl", &format!("newmtl m\nKd {kd}\n")).refuses(bake, 2, &[part]);
    }
    let folder = Dir::new();
    fs::create_dir(folder.path("s.obj")).unwrap();
    folder.refuses(bake, 2, &["cannot read s.obj"]);
}

#[test]
fn bad_companions_are_refused() {
    let dir = grey().with("p.csv", "px,py,pz,nx,ny\n").with("c.json", "{\"camera\": {\"eye\": [0,0]}}").with("file", "");
    for (args, part) in [
        ("bake s.obj --backend cpu --points gone.csv", "cannot read gone.csv"),
        ("bake s.obj --backend cpu --points p.csv", "p.csv:1: column 'nz' is missing"),
        ("bake s.obj --backend cpu --camera gone.json", "cannot read gone.json"),
        ("bake s.obj --backend cpu --camera c.json", "c.json:1:"),
        ("bake s.obj --backend cpu -o file", "cannot write file"),
        ("bake s.obj --backend cpu --rays 5", "rays = 5 is out of range"),
        ("bake s.obj --backend cpu --cells 1", "cells = 1 is out of range"),
        ("bake s.obj --backend cpu --eye 0,0,1 --target 0,0,1", "eye and target must differ"),
        ("bake s.obj --backend cpu --eye 0,0,1", "both an eye and a target"),
        ("bake s.obj --backend cpu --eye 1,2 --target 0,0,1", "three numbers"),
        ("render s.obj --backend cpu -o a.png", "--eye and --target"),
        ("render s.obj --backend cpu -o a.gif --eye 0,0,1 --target 0,0,0", ".exr"),
        ("query s.obj --points p.csv -o out.csv", "p.csv:1"),
    ] {
        dir.refuses(args, 2, &[part]);
    }
    let dir = grey().with("p.csv", "px,py,pz,nx,ny,nz\n").with("short.rcell", "\u{89}");
    dir.refuses("query s.obj --backend cpu --points p.csv -o out.csv", 2, &["s.obj: this is not a raycell solution"]);
    dir.refuses("query gone.rcell --backend cpu --points p.csv -o out.csv", 2, &["cannot read gone.rcell"]);
}

#[test]
fn promised_flags_and_commands_are_refused_by_name() {
    let dir = grey();
    for flag in [
        "--target-error 5",
        "--time-budget=3",
        "--mode paper",
        "--effects auto",
        "--quality final",
        "--json",
        "--resume",
        "--two-sided",
        "--strict",
        "--kd-space srgb",
    ] {
        let name = flag.split([' ', '=']).next().unwrap();
        dir.refuses(&format!("bake s.obj --backend cpu {flag}"), 2, &[&format!("raycell: error: {name} is not built yet; ")]);
    }
    for command in ["relight x.rcell", "sweep s.obj", "paper all", "explain s.obj"] {
        let name = command.split(' ').next().unwrap();
        dir.refuses(command, 2, &[&format!("raycell: error: {name} is not built yet; ")]);
    }
}

#[test]
fn no_device_is_3_and_never_the_twin_in_silence() {
    let dir = grey();
    dir.refuses("bake s.obj --adapter no-such-thing", 3, &["raycell: error: no usable GPU device", "--backend cpu"]);
    let listed = dir.run("adapters --backend vulkan --adapter no-such-thing");
    let text = String::from_utf8_lossy(&listed.stdout);
    assert!(listed.status.success() && text.contains("--backend cpu") && !text.contains("would be used"), "{text}");
}

#[test]
fn usage_errors_are_2_and_help_is_0() {
    let dir = Dir::new();
    dir.refuses("", 2, &["Usage"]);
    dir.refuses("bake", 2, &["SCENE"]);
    dir.refuses("bake s.obj --nonsense", 2, &["--nonsense"]);
    dir.refuses("bake s.obj --backend abacus", 2, &["abacus", "vulkan"]);
    for args in ["--help", "--version", "bake --help", "render --help"] {
        assert_eq!(dir.run(args).status.code(), Some(0), "{args}");
    }
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let dir = Dir::new();
    for args in ["adapters", "--help", "bake gone.obj"] {
        let mut child = dir.command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        drop(child.stderr.take());
        assert_ne!(child.wait().unwrap().code(), Some(101), "{args}");
    }
}

/// The columns of a CSV file's rows.
fn rows(path: &Path) -> Vec<Vec<String>> {
    fs::read_to_string(path).unwrap().lines().map(|l| l.split(',').map(str::to_string).collect()).collect()
}

#[test]
fn a_bake_leaves_what_was_asked_for() {
    // A closed room whose walls all shine: light everywhere, and the same everywhere.
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace/scene.obj");
    let dir = Dir::new()
        .with("p.csv", "nx,ny,nz,px,py,pz\n0,1,0,0.5,0,0.5\n0,-1,0,0.5,0,0.5\n")
        .with("c.json", r#"{"camera": {"eye": [0.5, 0.5, 0.5], "target": [0.5, 0, 0.6], "vfov": 40}}"#);
    let small = "--backend cpu --rays 4096";
    let args = format!("bake {scene} {small} --points p.csv --camera c.json --width 8 --height 6 --vertices");
    let output = dir.run(&args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(output.stdout.is_empty() && stderr.contains("wrote out/points.csv (1 of 2"), "{stderr}");
    for name in ["solution.rcell", "report.json", "points.csv", "vertices.ply", "picture.exr", "picture.png"] {
        assert!(dir.path("out").join(name).is_file(), "{name}");
    }
    let answers = rows(&dir.path("out/points.csv"));
    assert_eq!(answers[1][15], "ok");
    let b: f64 = answers[1][6].parse().unwrap();
    assert!((b / (5.0 * std::f64::consts::PI) - 1.0).abs() < 0.1, "{b}");
    assert_eq!((answers[2][6].as_str(), answers[2][15].as_str()), ("", "off_surface"));
    let report: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("out/report.json")).unwrap()).unwrap();
    assert_eq!((&report["rays"], &report["scene"]["triangles"]), (&4096.into(), &12.into()));
    assert!(report["estimated_error"].is_null() && report["effects"].is_null());

    // Again: the same bytes, and not a word.
    let again = dir.run(&format!("{args} -o two --quiet"));
    assert!(again.stderr.is_empty() && again.stdout.is_empty(), "{}", String::from_utf8_lossy(&again.stderr));
    for name in ["solution.rcell", "points.csv", "picture.png"] {
        assert_eq!(fs::read(dir.path("out").join(name)).unwrap(), fs::read(dir.path("two").join(name)).unwrap(), "{name}");
    }

    // The solution answers by itself.
    let output = dir.run("query out/solution.rcell --backend cpu --points p.csv -o q.csv");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read(dir.path("q.csv")).unwrap(), fs::read(dir.path("out/points.csv")).unwrap());
    let output = dir.run("render out/solution.rcell --backend cpu --camera c.json --width 8 --height 6 -o a.exr");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read(dir.path("a.exr")).unwrap(), fs::read(dir.path("out/picture.exr")).unwrap());
}
