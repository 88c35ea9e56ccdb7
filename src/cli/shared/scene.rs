//! How a scene file is read: flags, and the scene they make.

use super::super::log::Log;
use super::goal;
use super::interrupt::heed;
use crate::effects::{Switches, drop_below};
use crate::error::{Error, Result};
use crate::progress::Event;
use crate::scene::{self, KdSpace, LoadOptions, Scene};
use crate::solution::Camera;
use clap::{Args, ValueEnum};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// How the scene file is meant.
#[derive(Args)]
#[command(next_help_heading = "Scene")]
pub struct Reading {
    /// Metres in a unit of the file: 0.001 for millimetres, 0.0254 for inches.
    #[arg(long, value_name = "METRES", default_value = "1")]
    pub unit: f64,
    /// The file's upward axis; z is turned to y.
    #[arg(long, value_enum, default_value = "y")]
    pub up: Up,
    /// How Kd of an MTL is meant: as a reflectance (linear), or as a colour on a screen (srgb).
    #[arg(long, value_enum, default_value = "linear")]
    pub kd_space: Kd,
    /// Light both sides of every surface; emitters shine from both.
    #[arg(long)]
    pub two_sided: bool,
    /// Effects to switch by hand, +name or -name with commas; `raycell explain` lists them.
    #[arg(long, value_name = "auto|LIST", default_value = "auto", allow_hyphen_values = true)]
    pub effects: String,
    /// Leave out effects that bring less than this part of the light, in percent, and say so.
    #[arg(long, value_name = "PCT")]
    pub effects_threshold: Option<String>,
    /// Refuse the scene where reading it would be worth a warning.
    #[arg(long)]
    pub strict: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Up {
    Y,
    Z,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Kd {
    Linear,
    Srgb,
}

/// What the flags say to a reader.
pub fn options(flags: &Reading) -> LoadOptions {
    LoadOptions {
        unit: flags.unit,
        up: match flags.up {
            Up::Y => scene::Up::Y,
            Up::Z => scene::Up::Z,
        },
        kd_space: match flags.kd_space {
            Kd::Linear => KdSpace::Linear,
            Kd::Srgb => KdSpace::Srgb,
        },
        two_sided: flags.two_sided,
        strict: flags.strict,
    }
}

/// The scene of a file, read with a bar.
pub fn load(path: &Path, flags: &Reading, log: &mut Log, stop: &AtomicBool) -> Result<Scene> {
    log.event(&Event::Stage { name: "load" });
    let scene = Scene::load_from(path, &options(flags), &mut |path| std::fs::read(path), &mut |event| heed(log, stop, event))?;
    switched(scene, flags)
}

/// The scene with the effects that the flags ask for.
pub fn switched(mut scene: Scene, flags: &Reading) -> Result<Scene> {
    flags.effects.parse::<Switches>()?.apply(&mut scene)?;
    if let Some(threshold) = &flags.effects_threshold {
        drop_below(&mut scene, goal::percent("--effects-threshold", threshold)?)?;
    }
    Ok(scene)
}

/// The camera to render with: that of the flags, else one of the scene's; none where there is none.
pub fn camera(of_flags: Option<Camera>, view: Option<&str>, scene: &Scene) -> Result<Option<Camera>> {
    let Some(name) = view else {
        return Ok(of_flags.or_else(|| scene.cameras.first().map(|v| v.camera)));
    };
    match scene.cameras.iter().find(|v| v.name == name) {
        Some(view) => Ok(of_flags.or(Some(view.camera))),
        None => Err(Error::InvalidParam {
            name: "--view",
            value: format!("'{name}'"),
            range: "give the name of a camera in the scene file",
        }),
    }
}
