//! `raycell query`: light at points, from a solution.

use super::log::Log;
use super::shared::interrupt::{heed, interrupt};
use super::shared::machine::{Device, Machine};
use super::shared::points::off_surface;
use crate::error::Result;
use crate::output::points;
use crate::progress::Event;
use crate::solution::{Solution, SurfacePoint};
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
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

pub fn run(flags: Flags) -> Result<()> {
    let points_in: Vec<SurfacePoint> = points::read(&flags.points)?;
    let solution = Solution::load(&flags.solution)?;
    let mut log = Log::new(flags.device.quiet);
    let machine = Machine::open(&flags.device, &log)?;
    log.event(&Event::Stage { name: "readout" });
    let stop = interrupt();
    let answers = solution.query_with(&machine.backend, &points_in, &mut |event| heed(&mut log, &stop, event));
    let answers = machine.judge("the points", answers)?;
    log.finish();
    points::write(&flags.output, &points_in, &answers)?;
    log.line(&format!("wrote {}{}", flags.output.display(), off_surface(&answers)));
    Ok(())
}
