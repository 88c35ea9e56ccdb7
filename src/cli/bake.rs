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
use super::shared::points::off_surface;
use super::shared::scene::{self, Reading};
use crate::accuracy::{self, Climb};
use crate::bake_from;
use crate::checkpoint::Checkpoint;
use crate::error::{Error, Result};
use crate::memory;
use crate::output::mesh::Mesh;
use crate::output::report::Report;
use crate::output::{atomic, glb, image, ply, points, report};
use crate::params::{EVERYWHERE, Params};
use crate::progress::Event;
use crate::scene::Scene;
use crate::solution::{self, Answer, Image, Solution, SurfacePoint};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

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

#[derive(Clone, Copy, ValueEnum)]
pub enum Vertices {
    /// Radiosity in W/m2, beside colours to look at.
    Ply,
    /// Binary glTF with radiance B/pi in COLOR_0, for engines and viewers.
    Glb,
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
    let Found { mut solution, answers, picture, mesh, readout } = match worked {
        Ok(found) => found,
        Err(error) => {
            log.finish();
            return Err(kept.stopped(error, &scene, &params, safe, fill));
        }
    };
    log.finish();

    let wrote = |name: &str, note: &str| log.line(&format!("wrote {}{note}", dir.join(name).display()));
    if let (Some(p), Some(a)) = (&points_in, &answers) {
        points::write(&dir.join("points.csv"), p, a)?;
        wrote("points.csv", &off_surface(a));
    }
    match (flags.vertices, &mesh) {
        (Some(Vertices::Ply), Some(mesh)) => {
            ply::write(&dir.join("vertices.ply"), mesh)?;
            wrote("vertices.ply", "");
        }
        (Some(Vertices::Glb), Some(mesh)) => {
            glb::write(&dir.join("vertices.glb"), mesh)?;
            wrote("vertices.glb", " (linear radiance in COLOR_0)");
        }
        _ => {}
    }
    if let Some(picture) = &picture {
        image::write(&dir.join("picture.exr"), picture, None)?;
        wrote("picture.exr", " (linear radiance)");
        let tone = image::write(&dir.join("picture.png"), picture, flags.camera.exposure)?;
        wrote("picture.png", &tone.map_or(String::new(), |t| format!(" ({t})")));
    }
    if baked {
        solution.save(&dir.join("solution.rcell"))?;
        wrote("solution.rcell", "");
        let report = solution.report_mut();
        fill(report);
        report.seconds.readout = Some(readout.as_secs_f64());
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

/// What is read out of a bake.
struct Asked<'a> {
    points: Option<&'a [SurfacePoint]>,
    camera: Option<solution::Camera>,
    vertices: bool,
}

/// Points, and pixels a side, that tell how long all of them take.
const SAMPLE: usize = 128;

impl Asked<'_> {
    /// How long the read-out of such a solution takes, from a sample of it.
    fn cost(&self, machine: &Machine, solution: &Solution) -> Result<Duration> {
        let mut seconds = 0.0;
        let mut timed = |all: f64, of: f64, work: &mut dyn FnMut() -> Result<()>| {
            let start = Instant::now();
            let done = work();
            seconds += start.elapsed().as_secs_f64() * (all / of).max(1.0);
            done
        };
        if let Some(points) = self.points.filter(|p| !p.is_empty()) {
            let some: Vec<SurfacePoint> = points.iter().step_by(points.len().div_ceil(SAMPLE)).copied().collect();
            timed(points.len() as f64, some.len() as f64, &mut || solution.query(&machine.backend, &some).map(drop))?;
        }
        if let Some(camera) = self.camera {
            let [width, height] = [camera.width, camera.height].map(|n| n.min(SAMPLE as u32 / 2));
            let small = solution::Camera { width, height, ..camera };
            let pixels = |c: &solution::Camera| f64::from(c.width) * f64::from(c.height);
            timed(pixels(&camera), pixels(&small), &mut || solution.render(&machine.backend, &small).map(drop))?;
        }
        if self.vertices {
            let (nodes, geometry) = (solution.nodes(), solution.geometry());
            let places: Vec<SurfacePoint> = nodes
                .iter()
                .step_by(nodes.len().div_ceil(SAMPLE).max(1))
                .map(|n| SurfacePoint { p: geometry.to_world(n.p), n: n.n.map(f64::from) })
                .collect();
            let all = 3.0 * solution.scene().faces.len() as f64;
            timed(all, places.len().max(1) as f64, &mut || solution.query(&machine.backend, &places).map(drop))?;
        }
        Ok(Duration::from_secs_f64(seconds))
    }
}

/// A bake and what was read out of it.
struct Found {
    solution: Solution,
    answers: Option<Vec<Answer>>,
    picture: Option<Image>,
    mesh: Option<Mesh>,
    readout: Duration,
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
) -> Result<Found> {
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
    let begin = Instant::now();
    log.event(&Event::Stage { name: "readout" });
    let answers = asked.points.map(|p| solution.query_with(backend, p, &mut |event| heed(log, stop, event))).transpose();
    let answers = machine.judge("the points", answers)?;
    let picture = asked.camera.map(|c| solution.render_with(backend, &c, &mut |event| heed(log, stop, event))).transpose();
    let picture = machine.judge("the picture", picture)?;
    let mesh = asked.vertices.then(|| solution.vertices_with(backend, &mut |event| heed(log, stop, event))).transpose();
    let mesh = machine.judge("the vertices", mesh)?;
    Ok(Found { solution, answers, picture, mesh, readout: begin.elapsed() })
}

/// Refuses a folder that cannot be one, before the work and without making it.
fn check_folder(path: &Path) -> Result<()> {
    if path.exists() && !path.is_dir() {
        let source = std::io::Error::from(std::io::ErrorKind::NotADirectory);
        return Err(Error::Write { path: path.into(), source });
    }
    Ok(())
}
