//! `raycell sweep`: the error of every method along a ladder of settings, against what it costs.
//!
//! [`ladder`] says which runs, [`record`] keeps what they found, [`fit`] draws lines through them, `looks` shows what
//! errors look like, [`plots`] and [`page`] are for reading.

pub mod fit;
pub mod ladder;
mod looks;
pub mod page;
pub mod plots;
pub mod record;

use super::norms::Errors;
use super::reference::{Goal, Reference, sample_points};
use super::truth::Truth;
use crate::checkpoint::{bytes, digest};
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::memory;
use crate::output::atomic;
use crate::output::report::AdapterReport;
use crate::plot::{Drawing, Fault};
use crate::progress::{Event, Flow, Progress};
use crate::scene::{Geometry, Scene};
use crate::solution::Camera;
use ladder::{Kind, Rung, Sizes, rungs};
use looks::Looks;
use plots::Peer;
use record::{Record, ReferenceRecord, Row};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Share of a sweep's time that its own reference may take.
const REFERENCE_SHARE: f64 = 0.1;

/// What is swept, on what, and where to.
pub struct Ways<'a> {
    /// Folder that gets the files; it exists.
    pub dir: &'a Path,
    pub scene: &'a Scene,
    pub geometry: &'a Geometry,
    pub backend: &'a Backend,
    /// What the backend is, for telling.
    pub adapter: Option<AdapterReport>,
}

/// How much of it.
#[derive(Clone, Debug)]
pub struct Options {
    pub kinds: Vec<Kind>,
    pub sizes: Sizes,
    pub seeds: u32,
    /// Whether points are read out with final gathers.
    pub gather: bool,
    /// What all may take; runs that would go beyond are left out.
    pub time: Duration,
    /// A truth; none: one is made.
    pub reference: Option<PathBuf>,
    /// Points of a reference of our own.
    pub points: usize,
    /// When it is good enough.
    pub noise: f64,
    /// Paths a point at which it is good enough, whatever its noise; none: noise and time decide.
    pub paths: Option<u64>,
    /// Where pictures are taken from; none: a place that sees much.
    pub camera: Option<Camera>,
    /// Another program's curve: benches/peers' CSV.
    pub peers: Option<PathBuf>,
}

/// Runs what is missing, and writes everything anew. `say` gets a line a run.
///
/// Errors: those of bakes; [`Error::Format`] where the folder holds another sweep; [`Error::Cancelled`]: the runs that
/// were made lie in the folder then, with their page.
pub fn run(ways: &Ways, options: &Options, tell: &mut dyn FnMut(&Event) -> Flow, say: &dyn Fn(&str)) -> Result<Record> {
    let start = Instant::now();
    let peers = options.peers.as_deref().map(read_peers).transpose()?.unwrap_or_default();
    let (truth, reference) = reference(ways, options, tell, say)?;
    let now = Record {
        raycell: env!("CARGO_PKG_VERSION").into(),
        scene: ways.scene.name.clone(),
        triangles: ways.geometry.tris.len() as u64,
        of: digest(&[bytes(&ways.geometry.tris), bytes(&ways.geometry.materials), bytes(&[ways.geometry.scale])]),
        adapter: ways.adapter.clone(),
        reference,
        gather: options.gather,
        ..Record::default()
    };
    let mut record = match Record::read(ways.dir)? {
        None => now,
        Some(there) => match there.difference(&now) {
            None => Record { left_out: Vec::new(), ..there },
            Some(what) => {
                return Err(Error::Format {
                    path: ways.dir.join("sweep.json"),
                    line: None,
                    what: format!("this folder holds another sweep: {what} differs"),
                    cure: "give another folder with -o, or delete this one".into(),
                });
            }
        },
    };
    let worked = climb(ways, options, &truth, &mut record, start, tell, say);
    if !record.rows.is_empty() {
        // Also of what there is when it was stopped.
        record.write(ways.dir)?;
        publish(ways.dir, &record, &peers)?;
    }
    worked.map(|()| record)
}

/// The truth that errors are measured by: read, or made and kept.
fn reference(
    ways: &Ways,
    options: &Options,
    tell: &mut dyn FnMut(&Event) -> Flow,
    say: &dyn Fn(&str),
) -> Result<(Truth, ReferenceRecord)> {
    let told = |truth: &Truth, path: &Path, paths| ReferenceRecord {
        path: path.display().to_string(),
        points: truth.points.len(),
        noise: truth.noise(),
        paths,
        of: digest(&[bytes(truth.b.as_flattened()), bytes(truth.stderr.as_flattened())]),
    };
    if let Some(path) = &options.reference {
        let truth = Truth::read(path)?;
        if truth.mean() <= 0.0 {
            return Err(dark(path));
        }
        let record = told(&truth, path, None);
        return Ok((truth, record));
    }
    let (path, state) = (ways.dir.join("reference.csv"), ways.dir.join("reference.json"));
    let mut tracer = {
        let points = sample_points(ways.geometry, options.points, 1);
        if points.is_empty() {
            return Err(dark(Path::new(&ways.scene.name)));
        }
        Reference::new(ways.scene, ways.geometry, &path, points, 1)?
    };
    tracer.resume(&state)?;
    // One that is done stays what it is: errors measured by it lie in the record.
    let there = Truth::read(&path).ok().filter(|there| *there == tracer.truth());
    let truth = match there {
        Some(there) => there,
        None => {
            let progress = &mut Progress::new(tell);
            progress.event(Event::Stage { name: "reference" })?;
            let time = (options.paths.is_none()).then(|| options.time.mul_f64(REFERENCE_SHARE));
            let goal = Goal { noise: options.noise, paths: options.paths.unwrap_or(u64::MAX), time };
            let traced = tracer.run(goal, progress);
            tracer.save(&state)?;
            traced?;
            let truth = tracer.truth();
            if truth.mean() <= 0.0 {
                return Err(dark(Path::new(&ways.scene.name)));
            }
            truth.write(&path)?;
            let noise = 100.0 * truth.noise();
            say(&format!("reference: {} points, {} paths a point, noise {noise:.2} %", truth.points.len(), tracer.paths()));
            truth
        }
    };
    let record = told(&truth, &path, Some(tracer.paths()));
    Ok((truth, record))
}

fn dark(path: &Path) -> Error {
    Error::Format {
        path: path.into(),
        line: None,
        what: "no light reaches any point: there is nothing to measure an error by".into(),
        cure: "give the scene an emitter (Ke) that lights a surface".into(),
    }
}

/// Makes the runs that are missing, smallest first.
fn climb(
    ways: &Ways,
    options: &Options,
    truth: &Truth,
    record: &mut Record,
    start: Instant,
    tell: &mut dyn FnMut(&Event) -> Flow,
    say: &dyn Fn(&str),
) -> Result<()> {
    let all = rungs(&options.kinds, &options.sizes, options.seeds);
    let missing: Vec<Rung> = all.iter().copied().filter(|r| record.find(r).is_none()).collect();
    if missing.is_empty() {
        say(&format!("all {} runs are there", all.len()));
        return Ok(());
    }
    let camera = match options.camera {
        Some(camera) => looks::small(camera),
        None => looks::choose(ways.scene, ways.geometry)?,
    };
    let looks = Looks::new(ways, camera, &mut Progress::new(tell))?;

    if let Flow::Stop = tell(&Event::Stage { name: "runs" }) {
        return Err(Error::Cancelled);
    }

    // Of a run's own events the caller hears when it may stop, and a warning once.
    let mut heard: Vec<String> = Vec::new();
    let mut hush = |event: &Event| match event {
        Event::Warning(text) if !heard.contains(text) => {
            heard.push(text.clone());
            tell(event)
        }
        _ => tell(&Event::Tick),
    };
    if matches!(ways.backend, Backend::Gpu(_)) {
        say("compiling the kernels, in runs that do not count");
        for &kind in options.kinds.iter().filter(|&&k| missing.iter().any(|r| r.kind == k)) {
            let smallest = if kind.size() == ladder::Size::Rays { 1_024 } else { 32 };
            // What fails here fails again where it counts.
            match make(ways, options, truth, &Rung { kind, size: smallest, seed: 1 }, &mut hush) {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                _ => continue,
            }
        }
    }

    let mut closed: Vec<Kind> = Vec::new();
    for (i, rung) in missing.iter().enumerate() {
        let name = format!("{}, {}, seed {}", rung.kind.title(), rung.kind.setting(rung.size), rung.seed);
        if closed.contains(&rung.kind) {
            record.left_out.push(format!("{name}: a smaller one was left out"));
            continue;
        }
        // The nearest smaller run of the kind tells how long it will take.
        let before = record.of_kind(rung.kind).into_iter().rfind(|r| r.size <= rung.size);
        let foreseen = before.map_or(0.0, |r| r.bake * (rung.size as f64 / r.size as f64).powf(rung.kind.growth()) + r.readout);
        if start.elapsed().as_secs_f64() + foreseen > options.time.as_secs_f64() {
            record.left_out.push(format!("{name}: it would go beyond {} min", options.time.as_secs_f64() / 60.0));
            closed.push(rung.kind);
            continue;
        }
        match make(ways, options, truth, rung, &mut hush) {
            Ok((row, solution)) => {
                say(&format!("{} of {}: {name}: RRMSE {:.2} %, {:.1} s", i + 1, missing.len(), 100.0 * row.rrmse, row.seconds()));
                let error = row.rrmse;
                record.rows.push(row);
                if let (Some(looks), 1) = (&looks, rung.seed) {
                    looks.show(ways.backend, &solution, rung, error, &mut record.looks, &mut hush)?;
                }
                record.write(ways.dir)?;
            }
            Err(error @ (Error::NotContractive { .. } | Error::InvalidParam { .. })) => {
                say(&format!("{} of {}: {name}: {error}", i + 1, missing.len()));
                record.left_out.push(format!("{name}: {error}"));
                closed.push(rung.kind);
            }
            Err(error) => return Err(error),
        }
    }
    if !record.left_out.is_empty() {
        let n = record.left_out.len();
        say(&format!("{n} runs were left out; the page says why (--minutes gives them time)"));
    }
    Ok(())
}

/// One run: bakes, and asks at the reference's points.
fn make(
    ways: &Ways,
    options: &Options,
    truth: &Truth,
    rung: &Rung,
    tell: &mut dyn FnMut(&Event) -> Flow,
) -> Result<(Row, crate::Solution)> {
    let known = memory::forget();
    let solution = crate::bake(ways.backend, ways.scene, &rung.kind.params(rung.size, rung.seed, options.gather), tell)?;
    let begin = Instant::now();
    let answers = solution.query_with(ways.backend, &truth.points, tell)?;
    let readout = begin.elapsed().as_secs_f64();
    let host = if known { memory::peak() } else { None };
    let b: Vec<[f64; 3]> = answers.iter().map(|a| a.b).collect();
    let row = Row::new(rung, solution.report(), &Errors::new(&b, truth), readout, host);
    Ok((row, solution))
}

/// Writes the plots and the page.
fn publish(dir: &Path, record: &Record, peers: &[Peer]) -> Result<()> {
    let put = |name: &str, drawn: std::result::Result<Drawing, Fault>| -> Result<String> {
        let png = dir.join(format!("{name}.png"));
        let drawn = drawn.map_err(|e| Error::Write { path: png.clone(), source: std::io::Error::other(e) })?;
        atomic::write(&png, &drawn.png)?;
        atomic::write(&dir.join(format!("{name}.svg")), drawn.svg.as_bytes())?;
        Ok(drawn.svg)
    };
    let drawings = page::Drawings {
        errors: put("errors", plots::errors(record, peers))?,
        resources: put("resources", plots::resources(record))?,
        stages: put("stages", plots::stages(record))?,
        estimates: plots::estimates(record).map(|drawn| put("estimates", drawn)).transpose()?,
    };
    page::write(dir, record, peers, &drawings)
}

/// Writes an RGB picture as PNG.
fn write_png(path: &Path, rgb: &[[u8; 3]], width: u32, height: u32) -> Result<()> {
    let packed = crate::plot::png(rgb.as_flattened(), width, height);
    let packed = packed.map_err(|e| Error::Write { path: path.into(), source: std::io::Error::other(e) })?;
    atomic::write(path, &packed)
}

/// Reads the curves of other programs: `method,points,seconds,rrmse,median,p90`. raycell's own are left out.
fn read_peers(path: &Path) -> Result<Vec<Peer>> {
    let cure = "the columns are method,points,seconds,rrmse,median,p90, shares not per cents";
    let fail = |line: Option<usize>, what: String| Error::Format { path: path.into(), line, what, cure: cure.into() };
    let text = std::fs::read_to_string(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let mut peers: Vec<Peer> = Vec::new();
    for (i, line) in text.lines().enumerate().skip(1).filter(|(_, l)| !l.trim().is_empty()) {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let numbers: Option<Vec<f64>> = cells.iter().skip(1).map(|c| c.parse().ok()).collect();
        let (Some(numbers), 6) = (numbers, cells.len()) else {
            return Err(fail(Some(i + 1), format!("'{line}' is no such row")));
        };
        if cells[0] == "raycell" {
            continue;
        }
        let (points, run) = (numbers[0] as u64, [numbers[1], numbers[2], numbers[3], numbers[4]]);
        match peers.iter_mut().find(|p| p.name == cells[0] && p.points == points) {
            Some(peer) => peer.runs.push(run),
            None => peers.push(Peer { name: cells[0].into(), points, runs: vec![run] }),
        }
    }
    if peers.is_empty() { Err(fail(None, "there is no other program in it".into())) } else { Ok(peers) }
}
