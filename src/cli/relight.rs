//! `raycell relight`: other light on a network that is solved.

use super::console::Console;
use super::exit::{Done, Failure};
use super::log::Log;
use super::shared::camera::{self, Camera};
use super::shared::interrupt::{heed, interrupt};
use super::shared::kept::warn_if_partial;
use super::shared::machine::{Device, Machine};
use super::shared::results::{Asked, Vertices, check_folder};
use crate::error::{Error, Result};
use crate::memory;
use crate::output::{atomic, points, report};
use crate::relight::{self, Change};
use crate::solution::Solution;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  raycell relight out/solution.rcell --emission light=4,12,17 -o blue
      A new lamp colour. The network is not trained again; blue/report.json says how it went.
  raycell relight out/solution.rcell --emission light=0 --emission red=3,2,2 --points points.csv -o wall
      The lamp off and a wall lit instead, and the light at points.
  raycell relight out/solution.rcell --reflectance white=.4,.4,.5 --camera room.json -o grey
      New paint, and a picture of it.
  raycell relight out/solution.rcell --scale lamps_left=0 --scale lamps_right=1.5 -o evening
      Light groups: whatever bears a name, brighter or darker.
  raycell relight out/solution.rcell --emission light=4,12,17 --retrace -o blue
      Traced anew in any case: a bake of the changed scene.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Solution that a bake, or a relight, has written.
    pub solution: PathBuf,
    /// New emitted radiance of a material or an object, W/m2/sr: NAME=R,G,B, or NAME=GREY; again for more.
    #[arg(long, value_name = "NAME=R,G,B", value_parser = bands)]
    pub emission: Vec<(String, [f64; 3])>,
    /// New diffuse reflectance of a material or an object, each band in [0, 1): NAME=R,G,B, or NAME=GREY; again for more.
    #[arg(long, value_name = "NAME=R,G,B", value_parser = bands)]
    pub reflectance: Vec<(String, [f64; 3])>,
    /// What the emission of a material or an object is multiplied by; again for more.
    #[arg(long, value_name = "NAME=FACTOR", value_parser = factor)]
    pub scale: Vec<(String, f64)>,
    /// Whether rays are traced anew: auto does it, with a word, where the network cannot carry the new light as well as
    /// the bake states; --retrace alone is always.
    #[arg(long, value_enum, value_name = "WHEN", num_args = 0..=1, require_equals = true, default_value = "auto", default_missing_value = "always")]
    pub retrace: Retrace,
    /// Folder for the results, made where it does not exist.
    #[arg(short, long, value_name = "DIR", default_value = "relit")]
    pub output: PathBuf,
    /// Also answer these points: CSV with px,py,pz,nx,ny,nz; written to points.csv.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Also write the light at every vertex: vertices.ply, or with =glb vertices.glb.
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true, default_missing_value = "ply")]
    pub vertices: Option<Vertices>,
    #[command(flatten)]
    pub camera: Camera,
    #[command(flatten)]
    pub device: Device,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Retrace {
    Auto,
    Always,
    Never,
}

/// NAME=VALUE; a name may hold an equals sign.
fn named(text: &str) -> std::result::Result<(String, &str), String> {
    let (name, value) = text.rsplit_once('=').ok_or("give a name, =, and what it gets")?;
    if name.is_empty() { Err("the name is missing".into()) } else { Ok((name.into(), value)) }
}

fn number(text: &str) -> std::result::Result<f64, String> {
    text.trim().parse().map_err(|_| format!("'{text}' is no number"))
}

fn bands(text: &str) -> std::result::Result<(String, [f64; 3]), String> {
    let (name, value) = named(text)?;
    let numbers = value.split(',').map(number).collect::<std::result::Result<Vec<f64>, String>>()?;
    match numbers[..] {
        [grey] => Ok((name, [grey; 3])),
        [r, g, b] => Ok((name, [r, g, b])),
        _ => Err(format!("'{value}' is neither one number nor three")),
    }
}

fn factor(text: &str) -> std::result::Result<(String, f64), String> {
    let (name, value) = named(text)?;
    Ok((name, number(value)?))
}

pub fn run(flags: Flags, console: &Console) -> std::result::Result<Done, Failure> {
    let begin = Instant::now();
    let change = Change {
        emission: flags.emission,
        reflectance: flags.reflectance,
        scale: flags.scale,
        retrace: match flags.retrace {
            Retrace::Auto => relight::Retrace::Auto,
            Retrace::Always => relight::Retrace::Always,
            Retrace::Never => relight::Retrace::Never,
        },
    };
    let camera = camera::camera(&flags.camera)?;
    let points_in = flags.points.as_deref().map(points::read).transpose()?;
    let dir = &flags.output;
    check_folder(dir)?;
    let from = Solution::load(&flags.solution)?;
    refuse_own_folder(&flags.solution, dir)?;
    let load = begin.elapsed();
    let mut log = Log::new(console);
    warn_if_partial(&from, &log);
    let stop = interrupt();
    let opening = Instant::now();
    let machine = Machine::open(&flags.device, &log)?;
    let opening = opening.elapsed();

    // Everything is read out before the first result appears.
    let relit = from.relight(&machine.backend, &change, &mut |event| heed(&mut log, &stop, event));
    let mut relit = machine.judge("the relight", relit)?;
    let asked = Asked { points: points_in.as_deref(), camera, vertices: flags.vertices.is_some() };
    let shown = asked.show(&machine, &relit, &mut log, &stop)?;
    log.finish();
    if let Some(told) = &relit.report().relit {
        log.line(&format!("{}: {}", told.how, told.why));
    }

    std::fs::create_dir_all(dir).map_err(|source| Error::Write { path: dir.clone(), source })?;
    atomic::check_folder(dir)?;
    shown.write(dir, points_in.as_deref(), flags.vertices, flags.camera.exposure, &log)?;
    relit.save(&dir.join("solution.rcell"))?;
    log.line(&format!("wrote {}", dir.join("solution.rcell").display()));
    let report = relit.report_mut();
    report.adapter = machine.adapter.clone();
    report.memory_bytes.host = memory::peak();
    report.seconds.load = Some(load.as_secs_f64());
    report.seconds.open = Some(opening.as_secs_f64());
    report.seconds.compile = Some(machine.backend.compile_seconds());
    shown.tell(report);
    report.seconds.total = Some(begin.elapsed().as_secs_f64());
    if let Some(told) = &mut report.relit {
        told.from = Some(flags.solution.display().to_string());
    }
    report::write(&dir.join("report.json"), report)?;
    log.line(&format!("wrote {}", dir.join("report.json").display()));
    Ok(Done::new(serde_json::to_value(relit.report()).unwrap_or_default()))
}

/// Refuses to write over the solution that is read: other lights start from it.
fn refuse_own_folder(solution: &Path, dir: &Path) -> Result<()> {
    let place = |path: &Path| path.canonicalize().ok();
    let there = dir.join("solution.rcell");
    if place(solution).is_some_and(|own| place(&there) == Some(own)) {
        let range = "the solution that is relit lies there; give another folder";
        return Err(Error::InvalidParam { name: "output", value: dir.display().to_string(), range });
    }
    Ok(())
}
