//! `raycell bake`: check everything that was given, train, solve, read out, and only then write.

use super::console::Console;
use super::exit::{self, Done, Failure};
use super::log::Log;
use super::shared::camera::{self, Camera};
use super::shared::goal::{self, Quality};
use super::shared::interrupt::{heed, interrupt};
use super::shared::kept::{self, Kept};
use super::shared::machine::{Device, Machine};
use super::shared::network::{self, Network};
use super::shared::results::{Asked, Shown, Vertices, check_folder};
use super::shared::scene::{self, Reading};
use crate::accuracy::{self, Climb};
use crate::bake_from;
use crate::checkpoint::Checkpoint;
use crate::error::{Error, Result};
use crate::memory;
use crate::output::report::Report;
use crate::output::{atomic, points, report};
use crate::params::{EVERYWHERE, Params};
use crate::scene::Scene;
use crate::solution::Solution;
use clap::Args;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  raycell bake room.obj
      Light a scene; the results lie in the folder out.
  raycell bake room.obj --camera room.json -o lit
      Also lit/picture.exr and lit/picture.png, seen by the camera in room.json.
  raycell bake room.obj --points points.csv --vertices=glb
      Also the light at points of your choice, and a mesh with the light in its vertex colours.
  raycell bake room.obj --target-error 2%
      As fine as it takes for an error of 2 % at most, by an estimate that needs no truth.
  raycell bake room.obj --time-budget 30s --points points.csv
      The best that 30 seconds can buy, and how good that is.
  raycell bake room.obj --rays 4194304 --seed 7
      Finer: the error falls about as rays^-0.3. Another seed shows how much is noise.
  raycell bake room.obj --rays 4194304 --seed 7 --resume
      Go on with that bake after Ctrl-C, a lost device or a power cut: the result is the same, to the byte.
  raycell bake room.obj --method fem --patches 3200 --solver gauss-seidel
      The same room by finite elements, to compare; --bounces 1 shows the first reflection alone.
  raycell bake room.obj --json --quiet
      For scripts: the report, and nothing else, on stdout.
  raycell bake room.obj --backend cpu --rays 16384
      Without any driver: slow, for small things.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Scene to light: .obj with its .mtl, .gltf, .glb or .toml.
    pub scene: PathBuf,
    /// Folder for the results, made where it does not exist.
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub output: PathBuf,
    /// Also answer these points: CSV with px,py,pz,nx,ny,nz; written to points.csv.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Also write the light at every vertex: vertices.ply, or with =glb vertices.glb.
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true, default_missing_value = "ply")]
    pub vertices: Option<Vertices>,
    /// Go on with the bake in DIR that was stopped, instead of beginning again.
    ///
    /// Everything else must be asked for as then; the result is, byte for byte, that of a bake that was not stopped.
    /// Where DIR holds no checkpoint the bake begins, and where it is done already only points, vertices and pictures
    /// are read out: a script may always give it.
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub camera: Camera,
    #[command(flatten)]
    pub goal: goal::Flags,
    #[command(flatten)]
    pub network: Network,
    #[command(flatten)]
    pub device: Device,
}

pub fn run(flags: Flags, console: &Console) -> std::result::Result<Done, Failure> {
    let begin = Instant::now();
    let goal = flags.goal.goal()?;
    let mut params = network::params(&flags.network)?;
    if flags.goal.quality == Some(Quality::Final) && flags.network.gather.is_none() {
        params.gather_threshold = EVERYWHERE;
    }
    let camera = camera::camera(&flags.camera)?;
    let points_in = flags.points.as_deref().map(points::read).transpose()?;
    check_folder(&flags.output)?;
    let mut log = Log::new(console);
    let stop = interrupt();
    let scene = scene::load(&flags.scene, &flags.reading, &mut log, &stop)?;
    let camera = scene::camera(camera, flags.camera.view.as_deref(), &scene)?;
    let load = begin.elapsed();
    let opening = Instant::now();
    let machine = Machine::open(&flags.device, &log)?;
    let opening = opening.elapsed();
    let dir = &flags.output;
    std::fs::create_dir_all(dir).map_err(|source| Error::Write { path: dir.clone(), source })?;
    atomic::check_folder(dir)?;

    // Bake and read out; everything is read out before the first result appears.
    let mut there = if flags.resume { kept::already(dir, &scene, &params, goal.is_some()) } else { None };
    let mut kept = Kept::open(dir, flags.resume && (there.is_none() || goal.is_some()), &log)?;
    let asked = Asked { points: points_in.as_deref(), camera, vertices: flags.vertices.is_some() };
    let fill = |report: &mut Report| {
        report.adapter = machine.adapter.clone();
        report.memory_bytes.host = memory::peak();
        report.seconds.load = Some(load.as_secs_f64());
        report.seconds.open = Some(opening.as_secs_f64());
        report.seconds.compile = Some(machine.backend.compile_seconds());
        report.seconds.total = Some(begin.elapsed().as_secs_f64());
    };
    let mut safe = false;
    let climbed = goal.map(|goal| {
        let mut reached = |solution: &Solution| {
            solution.save(&dir.join("solution.rcell"))?;
            let mut report = solution.report().clone();
            fill(&mut report);
            report::write(&dir.join("report.json"), &report)?;
            safe = true;
            Ok(())
        };
        let mut readout = |solution: &Solution| asked.cost(&machine, solution);
        // Opening the device is start-up.
        let climb = Climb {
            goal,
            checkpoint: &mut kept.checkpoint,
            solution: there.take(),
            begin: begin + opening,
            reached: &mut reached,
            readout: &mut readout,
        };
        let climbed = accuracy::climb(&machine.backend, &scene, &params, climb, &mut |event| heed(&mut log, &stop, event));
        machine.judge("the bake", climbed)
    });
    let baked = there.is_none();
    let worked = climbed
        .map_or(Ok(there), |climbed| climbed.map(Some))
        .and_then(|there| work(&machine, &scene, &params, there, &mut kept.checkpoint, &asked, &mut log, &stop));
    let (mut solution, shown) = match worked {
        Ok(found) => found,
        Err(error) => {
            log.finish();
            return Err(kept.stopped(error, &scene, &params, safe, fill));
        }
    };
    log.finish();

    let wrote = |name: &str, note: &str| log.line(&format!("wrote {}{note}", dir.join(name).display()));
    shown.write(dir, points_in.as_deref(), flags.vertices, flags.camera.exposure, &log)?;
    if baked {
        solution.save(&dir.join("solution.rcell"))?;
        wrote("solution.rcell", "");
        let report = solution.report_mut();
        fill(report);
        shown.tell(report);
        if report.target.as_ref().is_some_and(|target| target.rungs.is_empty()) {
            // Nothing was baked: what the bake took was told then.
            kept::recall(report, dir);
        }
        report::write(&dir.join("report.json"), report)?;
        wrote("report.json", "");
        kept.done()?;
    }
    let target = solution.report().target.as_ref();
    if let Some(missed) = target.and_then(|t| t.missed.as_ref()) {
        log.warning(&format!("the target was missed: {missed}"));
    }
    let code = if target.is_some_and(|t| t.met == Some(false)) { exit::MISSED } else { exit::DONE };
    Ok(Done { code, ..Done::new(serde_json::to_value(solution.report()).unwrap_or_default()) })
}

/// Bakes where that is not done already, and reads out.
fn work(
    machine: &Machine,
    scene: &Scene,
    params: &Params,
    there: Option<Solution>,
    checkpoint: &mut Checkpoint,
    asked: &Asked,
    log: &mut Log,
    stop: &AtomicBool,
) -> Result<(Solution, Shown)> {
    let backend = &machine.backend;
    let solution = match there {
        Some(solution) => {
            log.line("the bake is done already: only reading out");
            solution
        }
        None => {
            let baked = bake_from(backend, scene, params, checkpoint, &mut |event| heed(log, stop, event));
            machine.judge("the bake", baked)?
        }
    };
    let shown = asked.show(machine, &solution, log, stop)?;
    Ok((solution, shown))
}
