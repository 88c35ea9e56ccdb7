//! `raycell query`: light at points, from a solution.

use super::console::Console;
use super::exit::Done;
use super::log::Log;
use super::shared::interrupt::{heed, interrupt};
use super::shared::kept::warn_if_partial;
use super::shared::machine::{Device, Machine};
use super::shared::points::off_surface;
use crate::error::Result;
use crate::output::points;
use crate::progress::Event;
use crate::solution::{Solution, Status, SurfacePoint};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  raycell query out/solution.rcell --points points.csv -o light.csv
      Radiosity, irradiance and direct irradiance (W/m2) for every row of points.csv.
  raycell query out/solution.rcell --points points.csv -o light.csv --json
      Also how many points are off every surface, for a script.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Solution that a bake has written.
    pub solution: PathBuf,
    /// Points: CSV with the columns px,py,pz,nx,ny,nz.
    #[arg(long, value_name = "FILE")]
    pub points: PathBuf,
    /// Answers, row by row.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub device: Device,
}

pub fn run(flags: Flags, console: &Console) -> Result<Done> {
    let begin = Instant::now();
    let points_in: Vec<SurfacePoint> = points::read(&flags.points)?;
    let solution = Solution::load(&flags.solution)?;
    let mut log = Log::new(console);
    warn_if_partial(&solution, &log);
    let machine = Machine::open(&flags.device, &log)?;
    log.event(&Event::Stage { name: "readout" });
    let stop = interrupt();
    let answers = solution.query_with(&machine.backend, &points_in, &mut |event| heed(&mut log, &stop, event));
    let answers = machine.judge("the points", answers)?;
    log.finish();
    points::write(&flags.output, &points_in, &answers)?;
    log.line(&format!("wrote {}{}", flags.output.display(), off_surface(&answers)));
    let count = |status| answers.iter().filter(|a| a.status == status).count();
    Ok(Done::new(json!({
        "command": "query",
        "output": flags.output.display().to_string(),
        "points": answers.len(),
        "off_surface": count(Status::OffSurface),
        "covered": count(Status::Covered),
        "mirror": count(Status::Mirror),
        "seconds": begin.elapsed().as_secs_f64(),
    })))
}
