//! Bakes that are stopped and go on: wherever that happens, the bytes are those of a bake that was not stopped.
//!
//! Without any adapter the tests pass with a note, unless `RAYCELL_REQUIRE_GPU` is set.

mod common;

use common::root;
use raycell::output::{ply, points};
use raycell::twin::math::hash;
use raycell::{Backend, Checkpoint, Error, Event, Flow, Params, Scene, SurfacePoint, bake_from};
use std::path::Path;
use std::time::{Duration, Instant};

/// Rays of the quick test: a whole batch and a ragged one.
const RAYS: u32 = 98_304;

/// What bakes run on, or a note that there is nothing.
fn backend() -> Option<Backend> {
    common::gpu().map(Backend::Gpu)
}

/// A bake with its read-out, and what is asked of it.
struct Job {
    backend: Backend,
    scene: Scene,
    params: Params,
    points: Vec<SurfacePoint>,
}

impl Job {
    fn cornell(backend: Backend, rays: u32) -> Job {
        let mut points = points::read(&root("tests/data/cornell.truth.csv")).unwrap();
        points.truncate(64);
        let scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
        Job { backend, scene, params: Params { rays, ..Params::default() }, points }
    }

    /// Bakes and reads out as the program does: the bytes of solution.rcell, points.csv and vertices.ply.
    fn run(&self, saved: &mut Checkpoint, dir: &Path, tell: &mut dyn FnMut(&Event) -> Flow) -> raycell::Result<[Vec<u8>; 3]> {
        let solution = bake_from(&self.backend, &self.scene, &self.params, saved, tell)?;
        let answers = solution.query_with(&self.backend, &self.points, tell)?;
        let mesh = solution.vertices_with(&self.backend, tell)?;
        let paths = ["solution.rcell", "points.csv", "vertices.ply"].map(|name| dir.join(name));
        solution.save(&paths[0])?;
        points::write(&paths[1], &self.points, &answers)?;
        ply::write(&paths[2], &mesh)?;
        Ok(paths.map(|path| std::fs::read(path).unwrap()))
    }

    /// Stops at a random event of each of `moments` parts of a bake, goes on from the file, and compares.
    fn is_the_same_wherever_it_stops(&self, moments: u32, seed: u32) {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("checkpoint.rcell");
        let mut events = 0;
        let straight = self
            .run(&mut Checkpoint::default(), dir.path(), &mut |_| {
                events += 1;
                Flow::Continue
            })
            .unwrap();
        let mut reached = std::collections::BTreeSet::new();
        for moment in 0..moments {
            let [first, end] = [moment, moment + 1].map(|part| part * events / moments);
            let last = first + hash(seed + moment) % (end - first);
            let (mut left, mut saved) = (last, Checkpoint::default());
            let stopped = self.run(&mut saved, dir.path(), &mut |_| {
                left = left.wrapping_sub(1);
                if left == u32::MAX { Flow::Stop } else { Flow::Continue }
            });
            assert!(matches!(stopped, Err(Error::Cancelled)), "event {last}");
            let begin = Instant::now();
            saved.save(&file).unwrap();
            let took = begin.elapsed();
            let size = std::fs::metadata(&file).unwrap().len();
            let mut again = Checkpoint::load(&file).unwrap();
            assert_eq!(again.reached(), saved.reached());
            let bytes = self.run(&mut again, dir.path(), &mut |_| Flow::Continue).unwrap();
            let where_ = saved.reached().unwrap_or("read-out".into());
            eprintln!("stopped at event {last} of {events} ({where_}, {size} bytes in {took:?})");
            for (k, name) in ["solution.rcell", "points.csv", "vertices.ply"].iter().enumerate() {
                assert!(bytes[k] == straight[k], "{name} differs after a stop at event {last} ({where_})");
            }
            reached.insert(where_);
        }
        assert!(reached.len() > moments as usize / 3, "the moments lie apart: {reached:?}");
    }
}

#[test]
fn stopped_at_twenty_moments_cornell_gives_the_same_bytes() {
    let Some(backend) = backend() else { return };
    Job::cornell(backend, RAYS).is_the_same_wherever_it_stops(20, 7);
}

/// The same with default settings: minutes.
#[test]
#[ignore = "takes minutes: cargo test --release --test resume -- --ignored"]
fn stopped_at_twenty_moments_a_default_bake_gives_the_same_bytes() {
    let Some(backend) = backend() else { return };
    Job::cornell(backend, Params::default().rays).is_the_same_wherever_it_stops(20, 1);
}

/// Events are the moments at which a user can stop a bake, so none may be far from the next: half a second
/// on a machine that does nothing else, on which such a bake takes eight.
#[test]
fn no_stop_waits_long() {
    let Some(backend) = backend() else { return };
    let job = Job::cornell(backend, Params::default().rays);
    let dir = tempfile::tempdir().unwrap();
    // Every gap by its last event and place; the shortest of three, for what else runs on this machine. The first run
    // compiles kernels, and a driver's compiler cannot be stopped.
    let mut least: Vec<(Duration, String)> = Vec::new();
    let mut totals = Vec::new();
    for _ in 0..3 {
        let (begin, mut last, mut stage, mut gaps) = (Instant::now(), Instant::now(), String::new(), Vec::new());
        let mut pace = |e: &Event| {
            if *e != Event::Tick {
                stage = format!("{e:?}");
            }
            gaps.push((last.elapsed(), format!("{} after {stage}", gaps.len())));
            last = Instant::now();
            Flow::Continue
        };
        job.run(&mut Checkpoint::default(), dir.path(), &mut pace).unwrap();
        totals.push(begin.elapsed());
        least = if least.is_empty() { gaps } else { least.into_iter().zip(gaps).map(|(a, b)| a.min(b)).collect() };
    }
    least.sort();
    let total = totals.iter().min().unwrap();
    for (gap, place) in least.iter().rev().take(8) {
        eprintln!("{:6.3} s of {:.1} s: {place}", gap.as_secs_f64(), total.as_secs_f64());
    }
    assert!(least.last().unwrap().0 < *total / 12, "{:?} of {total:?}", least.last());
}

/// The program on the Cornell box, in a folder of its own.
#[cfg(unix)]
mod program {
    use super::{RAYS, backend, hash, root};
    use raycell::{Checkpoint, Flow, Params, Scene, bake_from};
    use std::fs;
    use std::path::Path;
    use std::process::{Command, Output, Stdio};
    use std::time::{Duration, Instant};

    fn bake(out: &Path, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raycell"));
        command.args(["bake", "--vertices", "-o"]).arg(out).args(more);
        if !more.iter().any(|flag| flag.starts_with("--rays")) {
            command.args(["--rays", &RAYS.to_string()]);
        }
        command.arg("--points").arg(root("tests/data/cornell.truth.csv")).arg(root("scenes/cornell/scene.obj"));
        command.stderr(Stdio::piped());
        command
    }

    /// Runs until `after`, sends the signal, and waits for the end.
    fn interrupted(mut command: Command, signal: &str, after: Duration) -> Output {
        let child = command.spawn().unwrap();
        std::thread::sleep(after);
        // It may be done already; then there is nobody to hear.
        let _ = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
        child.wait_with_output().unwrap()
    }

    fn words(output: &Output) -> String {
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    #[test]
    fn signals_at_random_times_change_no_byte() {
        if backend().is_none() {
            return;
        }
        let dir = tempfile::tempdir().unwrap();
        let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
        let begin = Instant::now();
        let output = bake(&straight, &[]).output().unwrap();
        assert!(output.status.success(), "{}", words(&output));
        assert!(!straight.join("checkpoint.rcell").exists(), "a bake that is done keeps none");
        let takes = begin.elapsed();

        let mut codes = Vec::new();
        for round in 0..40 {
            // A killed process loses what it had not written yet, so each round must have time for a stage.
            let after = takes.mul_f64(0.15 + 0.35 * (hash(round) as f64 / u32::MAX as f64));
            let signal = ["-INT", "-KILL", "-TERM"][round as usize % 3];
            let output = interrupted(bake(&out, &["--resume"]), signal, after);
            let said = words(&output);
            let json = |name: &str| -> serde_json::Value { serde_json::from_slice(&fs::read(out.join(name)).unwrap()).unwrap() };
            match output.status.code() {
                Some(0) => break,
                None => assert_eq!(signal, "-KILL", "{said}"),
                Some(130) => {
                    codes.push(130);
                    if out.join("checkpoint.rcell").exists() {
                        assert!(said.contains("interrupted; saved ") && said.contains(" --resume "), "{said}");
                        let (report, whole) = (json("report.json"), said.contains("(whole;"));
                        assert_eq!(report["partial"], !whole, "{said}");
                        assert!(report["reached"].is_string());
                        let solution = raycell::Solution::load(&out.join("solution.rcell")).unwrap();
                        assert_eq!(solution.is_partial(), !whole);
                    } else {
                        assert!(said.contains("nothing was written"), "{said}");
                    }
                }
                other => panic!("{signal}: {other:?}\n{said}"),
            }
        }
        assert!(codes.len() > 1, "it was stopped more than once: {codes:?}");
        for name in ["solution.rcell", "points.csv", "vertices.ply"] {
            assert!(fs::read(out.join(name)).unwrap() == fs::read(straight.join(name)).unwrap(), "{name} differs");
        }
        assert!(!out.join("checkpoint.rcell").exists());
    }

    /// Kills the program at random moments, goes on after each, and holds every checkpoint that a kill leaves against the
    /// uninterrupted bake. What lies in the folder under a result's name is whole, always.
    fn survives_kills(kills: u32, rays: u32, seed: u32) {
        let Some(backend) = backend() else { return };
        let dir = tempfile::tempdir().unwrap();
        let (straight, out) = (dir.path().join("straight"), dir.path().join("out"));
        let rays = format!("--rays={rays}");
        let begin = Instant::now();
        let output = bake(&straight, &[&rays]).output().unwrap();
        assert!(output.status.success(), "{}", words(&output));
        let takes = begin.elapsed();
        let names = ["solution.rcell", "points.csv", "vertices.ply"];
        let want = names.map(|name| fs::read(straight.join(name)).unwrap());
        let scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
        let params = Params { rays: rays[7..].parse().unwrap(), ..Params::default() };

        let (mut done, mut kept, mut whole, mut reached) = (0, 0, 0, std::collections::BTreeMap::<String, u32>::new());
        let mut round = 0;
        while done < kills {
            let share = f64::from(hash(seed ^ round)) / f64::from(u32::MAX);
            round += 1;
            let output = interrupted(bake(&out, &[&rays, "--resume"]), "-KILL", takes.mul_f64(share));
            match output.status.code() {
                None => done += 1,
                // It was quicker than the kill.
                Some(0) => {
                    for (name, bytes) in names.iter().zip(&want) {
                        assert!(fs::read(out.join(name)).unwrap() == *bytes, "{name} differs, round {round}");
                    }
                    whole += 1;
                    fs::remove_dir_all(&out).unwrap();
                    continue;
                }
                other => panic!("{other:?}: {}", words(&output)),
            }
            // Whatever is there is whole.
            for (name, bytes) in names.iter().zip(&want) {
                assert!(fs::read(out.join(name)).is_ok_and(|b| b == *bytes) || !out.join(name).exists(), "{name}, round {round}");
            }
            if let Ok(report) = fs::read(out.join("report.json")) {
                serde_json::from_slice::<serde_json::Value>(&report).unwrap();
            }
            let file = out.join("checkpoint.rcell");
            let mut saved = if file.exists() { Checkpoint::load(&file).unwrap() } else { Checkpoint::default() };
            kept += u32::from(file.exists());
            *reached
                .entry(if saved.is_empty() { "nothing".into() } else { saved.reached().unwrap_or("the read-out".into()) })
                .or_default() += 1;
            // Every kill's resume ends as the uninterrupted bake does.
            let resumed = bake_from(&backend, &scene, &params, &mut saved, &mut |_| Flow::Continue).unwrap();
            let path = dir.path().join("resumed.rcell");
            resumed.save(&path).unwrap();
            assert!(fs::read(&path).unwrap() == want[0], "the resume after kill {done} differs");
            if done.is_multiple_of(20) {
                eprintln!("{done} kills, {} s", begin.elapsed().as_secs());
            }
        }
        eprintln!("{done} kills, {kept} checkpoints left, {whole} bakes whole in between; reached {reached:?}");
        assert!(kept > kills / 4, "kills hit bakes that had something to lose");
    }

    #[test]
    fn killed_at_eight_moments_the_program_goes_on_to_the_same_bytes() {
        survives_kills(8, 16_384, 3);
    }

    #[test]
    #[ignore = "ten minutes: cargo test --release --test resume -- --ignored --nocapture killed_at_two_hundred"]
    fn killed_at_two_hundred_moments_the_program_goes_on_to_the_same_bytes() {
        survives_kills(200, 8_192, 11);
    }

    #[test]
    fn what_cannot_be_resumed_is_refused_by_name() {
        if backend().is_none() {
            return;
        }
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("out");
        let file = out.join("checkpoint.rcell");
        for attempt in 1.. {
            let output = interrupted(bake(&out, &[]), "-INT", Duration::from_secs(3 * attempt));
            if file.exists() {
                break;
            }
            assert!(attempt < 10 && output.status.code() == Some(130), "{}", words(&output));
        }
        let kept = fs::read(&file).unwrap();
        for (more, part) in [
            (["--resume", "--seed=2"], "checkpoint.rcell: this checkpoint is of another bake: seed was 1 and is 2; "),
            (["--resume", "--backend=cpu"], "the device was "),
            (["--resume", "--cells=100"], "cells was null and is 100"),
        ] {
            let output = bake(&out, &more).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{}", words(&output));
            assert!(words(&output).contains(part), "{}", words(&output));
            assert!(fs::read(&file).unwrap() == kept, "a refused checkpoint is left alone");
        }
        fs::write(&file, &kept[..kept.len() / 2]).unwrap();
        let output = bake(&out, &["--resume"]).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(words(&output).contains("checkpoint.rcell: the file is truncated; "), "{}", words(&output));
        // Without the flag it is overwritten, with a word.
        let output = interrupted(bake(&out, &[]), "-INT", Duration::from_secs(2));
        assert!(words(&output).contains("--resume would go on from it"), "{}", words(&output));
    }
}
