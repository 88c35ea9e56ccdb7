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
    dir.refuses("query s.obj --backend cpu --points p.csv -o out.csv", 2, &["s.obj: this is not a raycell file"]);
    dir.refuses("query gone.rcell --backend cpu --points p.csv -o out.csv", 2, &["cannot read gone.rcell"]);
}

#[test]
fn no_device_is_3_and_never_the_twin_in_silence() {
    let dir = grey();
    dir.refuses(
        "bake s.obj --adapter no-such-thing",
        3,
        &["raycell: error: --adapter no-such-thing names nothing to run on; there is: ", "--backend cpu"],
    );
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
    dir.refuses("bakee s.obj", 2, &["bakee", "'bake'"]);
    dir.refuses("bake a.obj b.obj", 2, &["b.obj"]);
    for args in ["--help", "-h", "--version", "bake --help", "help render", "--json --help"] {
        assert_eq!(dir.run(args).status.code(), Some(0), "{args}");
    }
    assert!(stdout(&dir.run("--version")).contains("\nwgpu "));
    // Short help is for a glance, long help teaches.
    let (short, long) = (stdout(&dir.run("bake -h")), stdout(&dir.run("bake --help")));
    assert!(!short.contains("Examples:") && long.contains("Examples:\n  raycell bake "), "{short}\n{long}");
}

/// What a command printed.
fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

/// The one JSON object that a command printed.
fn object(output: &Output) -> serde_json::Value {
    let text = stdout(output);
    assert_eq!(text.lines().count(), 1, "{text}");
    serde_json::from_str(&text).expect(&text)
}

#[test]
fn with_json_there_is_one_object_whatever_happens() {
    let dir = grey().with("p.csv", "px,py,pz,nx,ny,nz\n0.2,0.2,0,0,0,1\n0.2,0.2,5,0,0,1\n");
    for (args, kind, exit) in [
        ("bake gone.obj --json", "read", 2),
        ("--json bake s.obj --backend cpu --rays 5", "invalid_param", 2),
        ("bake s.obj --json --adapter no-such-thing", "no_such_device", 3),
        ("bakee --json", "usage", 2),
        ("bake s.obj --json --effects everything", "invalid_param", 2),
        ("relight s.rcell --json", "read", 2),
    ] {
        let output = dir.run(args);
        let error = &object(&output)["error"];
        assert_eq!((&error["kind"], &error["exit"]), (&kind.into(), &exit.into()), "{args}");
        assert_eq!(output.status.code(), Some(exit), "{args}");
        // People read the same words.
        let message = error["message"].as_str().unwrap();
        assert!(String::from_utf8_lossy(&output.stderr).contains(message), "{args}: {message}");
    }
    let small = "--backend cpu --rays 1024 --json";
    let output = dir.run(&format!("bake s.obj {small}"));
    assert!(!output.stderr.is_empty());
    let report: serde_json::Value = serde_json::from_slice(&fs::read(dir.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(object(&output), report);
    let output = dir.run("query out/solution.rcell --points p.csv -o q.csv --backend cpu --json --quiet");
    assert_eq!(output.stderr, b"");
    let answer = object(&output);
    assert_eq!((&answer["points"], &answer["off_surface"]), (&2.into(), &1.into()));
    let eye = "--eye 0.2,0.2,3 --target 0.2,0.2,0 --width 4 --height 2";
    let picture = object(&dir.run(&format!("render out/solution.rcell -o a.png --backend cpu --json {eye}")));
    assert_eq!((&picture["width"], &picture["output"]), (&4.into(), &"a.png".into()));
    assert!(picture["exposure"].as_f64().unwrap() > 0.0);
    assert!(object(&dir.run("adapters --json"))["adapters"].is_array());
}

#[test]
fn colour_is_for_terminals_and_for_those_who_insist() {
    let dir = Dir::new();
    let escapes = |args: &str, variable: (&str, &str)| {
        let output = dir.command(args).env_remove("NO_COLOR").env(variable.0, variable.1).output().unwrap();
        output.stderr.contains(&0x1b)
    };
    for args in ["bake gone.obj", "bakee"] {
        // The tests' stderr is a pipe.
        assert!(!escapes(args, ("TERM", "xterm")), "{args}");
        assert!(escapes(&format!("{args} --color always"), ("NO_COLOR", "1")), "{args}");
        assert!(!escapes(&format!("{args} --color=never"), ("CLICOLOR_FORCE", "1")), "{args}");
        assert!(!escapes(args, ("NO_COLOR", "1")), "{args}");
    }
}

#[test]
fn every_example_of_the_help_works() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace");
    let dir = Dir::new()
        .with("room.obj", &fs::read_to_string(format!("{scene}/scene.obj")).unwrap())
        .with("scene.mtl", &fs::read_to_string(format!("{scene}/scene.mtl")).unwrap())
        .with("room.json", &fs::read_to_string(format!("{scene}/scene.json")).unwrap())
        .with("points.csv", "px,py,pz,nx,ny,nz\n0.5,0,0.5,0,1,0\n");
    let mut ran = 0;
    for command in ["bake", "query", "render", "adapters", "man", "completions", ""] {
        let help = stdout(&dir.run(&format!("{command} --help")));
        let (_, examples) = help.split_once("Examples:\n").expect(command);
        for line in examples.lines().filter_map(|l| l.strip_prefix("  raycell ")) {
            let line = line.split(" > ").next().unwrap();
            // The last of a flag counts: the same command, made small and free of drivers.
            let small = match line.split(' ').next().unwrap() {
                _ if line.contains("--help") => "",
                // These find their size themselves.
                _ if line.contains("--target-error") || line.contains("--time-budget") => {
                    "--backend cpu --target-error 20% --time-budget 1s --width 8 --height 8"
                }
                "bake" => "--backend cpu --rays 1024 --width 8 --height 8",
                "render" => "--backend cpu --width 8 --height 8",
                "query" => "--backend cpu",
                _ => "",
            };
            let small = if line.starts_with("render room.obj") { format!("{small} --rays 1024") } else { small.into() };
            let output = dir.run(&format!("{line} {small}"));
            assert_eq!(output.status.code(), Some(0), "{line}\n{}", String::from_utf8_lossy(&output.stderr));
            ran += 1;
        }
    }
    assert!(ran >= 15, "{ran}");
    assert!(dir.path("man1/raycell-bake.1").is_file() && dir.path("lit/picture.exr").is_file());
}

#[test]
fn a_target_that_is_met_already_keeps_the_record_of_its_bake() {
    let dir = grey();
    let report = |args: &str| {
        let output = dir.run(&format!("bake s.obj --backend cpu --target-error 50% {args}"));
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&fs::read(dir.path("out/report.json")).unwrap()).unwrap()
    };
    let (before, after) = (report(""), report("--resume"));
    assert!(before["stages"]["emit"].as_f64().unwrap() > 0.0 && !before["target"]["rungs"].as_array().unwrap().is_empty());
    for key in ["stages", "target", "estimated_error", "memory_bytes"] {
        assert_eq!(before[key], after[key], "{key}");
    }
    assert_eq!(before["seconds"]["train"], after["seconds"]["train"]);
}

#[test]
fn pages_and_completions_tell_every_flag() {
    let dir = Dir::new();
    assert_eq!(dir.run("man -o .").status.code(), Some(0));
    let help = stdout(&dir.run("bake --help"));
    let flags: Vec<&str> = help.split_whitespace().filter(|w| w.starts_with("--") && w.len() > 4).collect();
    let flags: Vec<&str> =
        flags.iter().map(|f| f.trim_end_matches([',', '.', ';', '\'', ')']).split(['=', '[']).next().unwrap()).collect();
    assert!(flags.contains(&"--points") && flags.contains(&"--json"), "{flags:?}");
    let page = fs::read_to_string(dir.path("raycell-bake.1")).unwrap().replace("\\-", "-");
    let texts: Vec<String> =
        ["bash", "zsh", "fish", "powershell", "elvish"].map(|s| stdout(&dir.run(&format!("completions {s}")))).into();
    for flag in flags {
        assert!(page.contains(flag), "{flag} in the manual");
        for text in &texts {
            // Fish writes long flags without their dashes.
            assert!(text.contains(flag) || text.contains(&format!("-l {}", &flag[2..])), "{flag} in\n{text}");
        }
    }
    dir.refuses("completions tcsh", 2, &["tcsh", "fish"]);
}

/// Asserts that a `vertices.glb` holds, corner by corner, what a `vertices.ply` of a scene with one part does.
fn same_light(ply: &[u8], glb: &[u8]) {
    let end = b"end_header\n";
    let header = ply.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let text = String::from_utf8_lossy(&ply[..header]);
    let count = |what: &str| -> usize {
        let (_, rest) = text.split_once(&format!("element {what} ")).unwrap();
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let (vertices, faces) = (count("vertex"), count("face"));
    assert_eq!((vertices, faces), (24, 12));
    let f32_at = |bytes: &[u8], at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let file = gltf::Gltf::from_slice(glb).expect("valid glTF");
    let blob = file.blob.as_deref().unwrap();
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    assert_eq!((file.meshes().count(), primitive.material().name()), (1, Some("furnace")));
    let of = |semantic| primitive.get(&semantic).unwrap().view().unwrap().offset();
    let (positions, colours) = (of(gltf::Semantic::Positions), of(gltf::Semantic::Colors(0)));
    for v in 0..vertices {
        let there = header + 51 * v; // three f64, six f32, three bytes
        for k in 0..3 {
            let p = f64::from_le_bytes(ply[there + 8 * k..there + 8 * k + 8].try_into().unwrap());
            assert_eq!(p as f32, f32_at(blob, positions + 12 * v + 4 * k));
            let b = f32_at(ply, there + 36 + 4 * k);
            assert!(b > 0.0);
            assert_eq!((b as f64 / std::f64::consts::PI) as f32, f32_at(blob, colours + 16 * v + 4 * k));
        }
    }
    let indices = primitive.indices().unwrap().view().unwrap().offset();
    for f in 0..faces {
        let there = header + 51 * vertices + 13 * f;
        assert_eq!(ply[there + 1..there + 13], blob[indices + 12 * f..indices + 12 * f + 12]);
    }
}

#[cfg(unix)]
#[test]
fn names_need_not_be_text() {
    use std::os::unix::ffi::OsStrExt;
    let name = |bytes: &[u8]| std::ffi::OsStr::from_bytes(bytes).to_os_string();
    let dir = Dir::new().with("s.mtl", "newmtl m\nKd 0.5 0.5 0.5\nKe 1 1 1\n");
    fs::write(dir.0.path().join(name(b"sc\xffne.obj")), TRIANGLE).unwrap();
    fs::write(dir.0.path().join(name(b"p\xe9.csv")), "px,py,pz,nx,ny,nz\n0.2,0.2,0,0,0,1\n").unwrap();
    let mut bake = dir.command("bake --backend cpu --rays 1024 --json --points");
    let output = bake.arg(name(b"p\xe9.csv")).arg("-o").arg(name(b"o\xfft")).arg(name(b"sc\xffne.obj")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(object(&output)["scene"]["path"].is_string());
    assert!(dir.0.path().join(name(b"o\xfft")).join("points.csv").is_file());
    let gone = dir.command("bake").arg(name(b"g\xffne.obj")).output().unwrap();
    assert_eq!(gone.status.code(), Some(2));
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let dir = Dir::new();
    for args in ["adapters", "--help", "bake gone.obj", "bake gone.obj --json", "man", "completions bash"] {
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
    assert!(report["estimated_error"]["rrmse"].as_f64().unwrap() > 0.0 && report["effects"][0]["on"] == true);

    // Again: the same bytes, and not a word.
    let again = dir.run(&format!("{args} -o two --quiet"));
    assert!(again.stderr.is_empty() && again.stdout.is_empty(), "{}", String::from_utf8_lossy(&again.stderr));
    for name in ["solution.rcell", "points.csv", "picture.png"] {
        assert_eq!(fs::read(dir.path("out").join(name)).unwrap(), fs::read(dir.path("two").join(name)).unwrap(), "{name}");
    }

    // The same vertices in the other format.
    let output = dir.run(&format!("bake {scene} {small} --vertices=glb -o two --quiet"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    same_light(&fs::read(dir.path("out/vertices.ply")).unwrap(), &fs::read(dir.path("two/vertices.glb")).unwrap());

    // The solution answers by itself.
    let output = dir.run("query out/solution.rcell --backend cpu --points p.csv -o q.csv");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read(dir.path("q.csv")).unwrap(), fs::read(dir.path("out/points.csv")).unwrap());
    let output = dir.run("render out/solution.rcell --backend cpu --camera c.json --width 8 --height 6 -o a.exr");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(fs::read(dir.path("a.exr")).unwrap(), fs::read(dir.path("out/picture.exr")).unwrap());
}

/// A closed room of twelve triangles, one of them a lamp.
fn room() -> Dir {
    let mut obj = String::from("mtllib s.mtl\n");
    for i in 0..8 {
        obj += &format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2 & 1);
    }
    for (i, [a, b, c, d]) in
        [[1, 3, 7, 5], [2, 6, 8, 4], [1, 5, 6, 2], [3, 4, 8, 7], [1, 2, 4, 3], [5, 7, 8, 6]].iter().enumerate()
    {
        obj += &format!("usemtl {}\nf {a} {b} {c}\nusemtl m\nf {a} {c} {d}\n", if i == 3 { "lamp" } else { "m" });
    }
    Dir::new().with("s.obj", &obj).with("s.mtl", "newmtl m\nKd 0.5 0.6 0.4\nnewmtl lamp\nKd 0.2 0.2 0.2\nKe 5 4 3\n")
}

/// A small sweep: its files, its page, and that a second call makes no run again.
#[test]
fn a_sweep_leaves_a_page_and_goes_on() {
    let dir = room();
    let small = "sweep s.obj --backend cpu -o out --points 24 --paths 4096 --seeds 2 --patches 16,48,160 --cells 16 \
                 --eye .1,.2,.3 --target .9,.5,.8 --width 24 --height 16 --rays";
    let sweep = format!("{small} 1024,2048 --methods network,fem,paper,rays,hierarchical,network-direct");
    let output = dir.run(&sweep);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    let file =
        |name: &str| fs::read_to_string(dir.path(&format!("out/{name}"))).unwrap_or_else(|e| panic!("{name}: {e}\n{stderr}"));
    let csv = file("sweep.csv");
    // Two seeds of: two settings of rays, thrice; three of patches, twice; one of cells.
    assert_eq!(csv.lines().count(), 1 + 2 * (3 * 2 + 2 * 3 + 1), "{csv}");
    let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("{name}"));
    for row in csv.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        assert_eq!(cells.len(), header.len(), "{row}");
        let number = |name: &str| cells[column(name)].parse::<f64>().unwrap_or_else(|e| panic!("{name} of {row}: {e}"));
        // The room is simple: whatever has exact direct light is right to a tenth; all light by 1,024 rays to a quarter.
        let most = match cells[0] {
            "paper" => 3.0,
            "network-direct" => 0.25,
            _ => 0.1,
        };
        assert!((0.0..most).contains(&number("rrmse")) && number("reference_noise") > 0.0, "{row}");
        let stages: f64 = header.iter().filter(|h| h.ends_with("_s")).map(|h| number(h)).sum();
        let seconds = number("bake_seconds") + number("readout_seconds");
        assert!(seconds > 0.0 && stages >= 0.999 * seconds && stages < 1.05 * seconds + 0.01, "{row}");
        assert!(number("coefficients") > 0.0 && number("rays") > 0.0, "{row}");
    }
    let html = file("index.html");
    for part in ["cost", "forecast", "errors", "looks", "estimate", "resources", "stages", "runs", "how"] {
        assert!(html.contains(&format!("<h2 id=\"{part}\">")), "{part}");
    }
    assert_eq!(html.matches("<svg").count(), html.matches("http://www.w3.org/2000/svg").count());
    // Packed pictures may hold any word.
    let mut parts = html.split("base64,");
    let words: String = parts.next().into_iter().chain(parts.filter_map(|p| Some(p.split_once('"')?.1))).collect();
    let elsewhere = words.replace("http://www.w3.org/2000/svg", "");
    for word in ["http:", "https:", "src=\"//", "url(", "<script", "<link", "NaN", "inf "] {
        assert!(!elsewhere.contains(word), "{word}");
    }
    for name in ["errors.svg", "resources.svg", "stages.svg"] {
        assert!(file(name).ends_with("</svg>\n"), "{name}");
    }
    for name in ["errors.png", "resources.png", "stages.png", "reference.png"] {
        assert!(fs::read(dir.path(&format!("out/{name}"))).unwrap().starts_with(b"\x89PNG"), "{name}");
    }
    let json: serde_json::Value = serde_json::from_str(&file("sweep.json")).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), 26);

    // Again: nothing is run, and the page is the same. One setting more: only that.
    let again = dir.run(&sweep);
    assert!(String::from_utf8_lossy(&again.stderr).contains("all 26 runs are there"));
    assert_eq!((file("sweep.csv"), file("index.html")), (csv.clone(), html));
    let more = dir.run(&format!("{small} 1024,2048,4096 --methods network --json"));
    let more: serde_json::Value = serde_json::from_slice(&more.stdout).unwrap();
    assert_eq!(more["runs"], 28);
    assert!(more["methods"]["network"]["runs"] == 6 && file("sweep.csv").starts_with(&csv));

    // Another scene has no business here.
    let mtl = fs::read_to_string(dir.path("s.mtl")).unwrap().replace("0.5", "0.51");
    fs::write(dir.path("s.mtl"), mtl).unwrap();
    let other = dir.run(&sweep);
    assert_eq!(other.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&other.stderr).contains("is of another scene"), "{}", String::from_utf8_lossy(&other.stderr));
}

#[test]
fn bad_sweeps_are_refused() {
    let dir = room().with("t.csv", "px,py,pz,nx,ny,nz,B_r,B_g\n").with("p.csv", "method,points\nx\n").with("file", "");
    for (args, part) in [
        ("sweep s.obj --backend cpu --reference gone.csv -o .", "cannot read gone.csv"),
        ("sweep s.obj --backend cpu --reference t.csv -o .", "B_r, B_g and B_b is missing"),
        ("sweep s.obj --backend cpu --peers p.csv -o .", "p.csv:2: 'x' is no such row"),
        ("sweep s.obj --backend cpu --rays 5", "rays = 5 is out of range"),
        ("sweep s.obj --backend cpu --minutes 0", "minutes = 0 is out of range"),
        ("sweep s.obj --backend cpu --methods abacus", "abacus"),
        ("sweep s.obj --backend cpu -o file", "cannot write file"),
    ] {
        dir.refuses(args, 2, &[part]);
    }
    let dark = grey().with("s.mtl", "newmtl m\nKd 0.5 0.5 0.5\n");
    let output = dark.run("sweep s.obj --backend cpu -o out");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no light reaches any point"));
}
