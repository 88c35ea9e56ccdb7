//! `raycell doctor`: what is wrong with a scene.

use super::exit::{DONE, Done, FOUND};
use super::shared::scene::{self, Reading};
use crate::doctor;
use crate::error::Result;
use crate::scene::Scene;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  raycell doctor room.obj
      A line a fault: its name, the object, a number, and the cure. Nothing where nothing is wrong.
  raycell doctor room.obj --json
      The same for a script. Exit code 0: clean; 1: something was found; 2: not readable.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Scene to look at: .obj with its .mtl, .gltf, .glb or .toml.
    pub scene: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
}

pub fn run(flags: Flags) -> Result<Done> {
    let scene = Scene::read_with(&flags.scene, &scene::options(&flags.reading))?;
    let findings = doctor::examine(&scene)?;
    let text = findings.iter().map(|f| format!("{}: {f}\n", f.check.name())).collect();
    let code = if findings.is_empty() { DONE } else { FOUND };
    let object = json!({"command": "doctor", "scene": scene.name, "findings": findings});
    Ok(Done { code, ..Done::new(object).text(text) })
}
