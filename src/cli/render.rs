//! `raycell render`: a picture, from a solution or straight from a scene.

use super::console::Console;
use super::exit::Done;
use super::log::Log;
use super::shared::camera::{self, Camera};
use super::shared::interrupt::{heed, interrupt};
use super::shared::kept::warn_if_partial;
use super::shared::machine::{Device, Machine};
use super::shared::network::{self, Network};
use super::shared::scene::{self, Reading};
use crate::error::{Error, Result};
use crate::output::image;
use crate::progress::Event;
use crate::scene::LoadOptions;
use crate::solution::{self, Solution};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  raycell render out/solution.rcell --eye 2.8,2.7,-8 --target 2.8,2.7,2.8 -o view.png
      A picture to look at; its exposure is chosen from the picture.
  raycell render out/solution.rcell --camera room.json --width 1920 --height 1080 -o view.exr
      Linear radiance, W/m2/sr, for further work.
  raycell render room.obj --camera room.json --exposure 2 -o view.png
      Straight from a scene: bakes first, and keeps no solution.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Solution (.rcell), or a scene (.obj, .gltf, .glb, .toml) to be baked first.
    pub input: PathBuf,
    /// Picture: .exr for linear radiance, .png for a tone-mapped one.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub camera: Camera,
    #[command(flatten)]
    pub network: Network,
    #[command(flatten)]
    pub device: Device,
}

pub fn run(flags: Flags, console: &Console) -> Result<Done> {
    let begin = Instant::now();
    image::check_name(&flags.output)?;
    let camera = camera::camera(&flags.camera)?;
    let wanted = |camera: Option<solution::Camera>| {
        let range = "give --eye and --target, or --camera FILE";
        camera.ok_or(Error::InvalidParam { name: "camera", value: "none".into(), range })
    };
    let mut log = Log::new(console);
    let stop = interrupt();
    let is_solution = flags.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("rcell"));
    let (machine, solution, camera) = if is_solution {
        let camera = wanted(camera)?;
        if flags.camera.view.is_some() || scene::options(&flags.reading) != LoadOptions::default() {
            log.warning("--unit, --up, --kd-space, --two-sided, --strict and --view are for scene files; this is a solution");
        }
        let n = &flags.network;
        if n.seed.is_some() || n.rays.is_some() || n.cells.is_some() || n.direct.is_some() || n.norm.is_some() {
            log.warning("--seed, --rays, --cells, --direct and --norm shape a bake; this solution is already baked");
        }
        let solution = Solution::load(&flags.input)?;
        warn_if_partial(&solution, &log);
        (Machine::open(&flags.device, &log)?, solution, camera)
    } else {
        let params = network::params(&flags.network)?;
        let scene = scene::load(&flags.input, &flags.reading, &mut log, &stop)?;
        let camera = wanted(scene::camera(camera, flags.camera.view.as_deref(), &scene)?)?;
        let machine = Machine::open(&flags.device, &log)?;
        let baked = crate::bake(&machine.backend, &scene, &params, &mut |event| heed(&mut log, &stop, event));
        let solution = machine.judge("the bake", baked)?;
        (machine, solution, camera)
    };
    log.event(&Event::Stage { name: "readout" });
    let picture = solution.render_with(&machine.backend, &camera, &mut |event| heed(&mut log, &stop, event));
    let picture = machine.judge("the picture", picture)?;
    log.finish();
    let tone = image::write(&flags.output, &picture, flags.camera.exposure)?;
    let note = tone.map_or(" (linear radiance)".into(), |t| format!(" ({t})"));
    log.line(&format!("wrote {}{note}", flags.output.display()));
    Ok(Done::new(json!({
        "command": "render",
        "output": flags.output.display().to_string(),
        "width": camera.width,
        "height": camera.height,
        "exposure": tone.map(|t| t.exposure),
        "seconds": begin.elapsed().as_secs_f64(),
    })))
}
