//! `raycell explain`: which effects a scene calls for, why, and what they cost.

use super::exit::Done;
use super::shared::scene::{self, Reading};
use crate::effects;
use crate::error::Result;
use crate::output::report::Report;
use crate::scene::Scene;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  raycell explain room.obj
      A line an effect: whether the scene calls for it, and on what evidence.
  raycell explain room.obj --after out
      The same, and the three effects that a bake in out spent most of its time on.";

/// Effects that are named by what they took.
const DEAREST: usize = 3;

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Scene to look at: .obj with its .mtl, .gltf, .glb or .toml.
    pub scene: PathBuf,
    #[command(flatten)]
    pub reading: Reading,
    /// Folder of a bake of it: also name the three effects that took most of its time.
    ///
    /// With --json all of them; docs/effects.md says how time is divided.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub after: Option<PathBuf>,
}

pub fn run(flags: Flags) -> Result<Done> {
    let scene = Scene::load_with(&flags.scene, &scene::options(&flags.reading))?;
    let scene = scene::switched(scene, &flags.reading)?;
    let report = flags.after.as_deref().map(Report::read).transpose()?;
    let effects = effects::analyse(&scene)?;
    let mut text = format!(
        "{}: {} {}, {} materials\n",
        scene.name,
        scene.faces.len(),
        if scene.is_flatland() { "segments" } else { "triangles" },
        scene.materials.len()
    );
    let (absent, told): (Vec<_>, Vec<_>) = effects.iter().partition(|e| e.why == effects::NONE);
    for e in told {
        text += &format!("{}  {:15}  {}", if e.on { "on " } else { "off" }, e.name, e.why);
        text += &if e.on { format!("; costs {}\n", e.cost) } else { "\n".into() };
    }
    if !absent.is_empty() {
        let names: Vec<_> = absent.iter().map(|e| e.name.as_str()).collect();
        text += &format!("off  {}: {}\n", names.join(", "), effects::NONE);
    }
    let mut object = json!({"command": "explain", "scene": scene.name, "effects": effects});
    if let Some(report) = report {
        let shares = effects::after(&report);
        let words: Vec<_> = shares.iter().take(DEAREST).map(|(name, share)| format!("{name} {:.0} %", 100.0 * share)).collect();
        if let Some(total) = report.seconds.total {
            let rest = 100.0 * (1.0 - shares.iter().map(|(_, share)| share).sum::<f64>());
            text += &format!("the bake took {total:.1} s, most of it for {}; {rest:.0} % were for no effect\n", words.join(", "));
        }
        object["time"] = shares.iter().map(|(name, share)| json!({"effect": name, "share": share})).collect();
    }
    Ok(Done::new(object).text(text))
}
