//! Where the light is seen from: flags, the camera file, and the camera they make.

use crate::error::{Error, Result};
use crate::solution;
use clap::Args;
use std::path::{Path, PathBuf};

/// Where the light is seen from. A file first, then the flags over it.
#[derive(Args)]
#[command(next_help_heading = "Camera")]
pub struct Camera {
    /// JSON file with camera{eye,target,up,vfov}; bake also renders picture.exr and picture.png.
    #[arg(long, value_name = "FILE")]
    pub camera: Option<PathBuf>,
    /// Camera of the scene file to render with, where no other flag tells one [default: the first].
    #[arg(long, value_name = "NAME")]
    pub view: Option<String>,
    /// Position, metres.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,
    /// Point looked at.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub target: Option<[f64; 3]>,
    /// Upward direction [default: 0,1,0].
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub up: Option<[f64; 3]>,
    /// Vertical field of view, degrees [default: 40].
    #[arg(long, value_name = "DEGREES")]
    pub vfov: Option<f64>,
    /// Picture width, pixels [default: 512].
    #[arg(long, value_name = "PIXELS")]
    pub width: Option<u32>,
    /// Picture height, pixels [default: 512].
    #[arg(long, value_name = "PIXELS")]
    pub height: Option<u32>,
    /// What radiance is multiplied by in a PNG [default: from the picture].
    #[arg(long, value_name = "FACTOR")]
    pub exposure: Option<f64>,
}

/// The camera that flags and file describe; none where neither says a word.
pub fn camera(flags: &Camera) -> Result<Option<solution::Camera>> {
    let file = flags.camera.as_deref().map(camera_file).transpose()?;
    let refuse = |name, value: String, range| Err(Error::InvalidParam { name, value, range });
    if file.is_none() && flags.eye.is_none() && flags.target.is_none() {
        return Ok(None);
    }
    let file = file.unwrap_or_default();
    let (Some(eye), Some(target)) = (flags.eye.or(file.eye), flags.target.or(file.target)) else {
        return refuse("camera", "incomplete".into(), "give both an eye and a target");
    };
    let camera = solution::Camera {
        eye,
        target,
        up: flags.up.or(file.up).unwrap_or([0.0, 1.0, 0.0]),
        vfov_degrees: flags.vfov.or(file.vfov).unwrap_or(40.0),
        width: flags.width.or(file.width).unwrap_or(512),
        height: flags.height.or(file.height).unwrap_or(512),
    };
    camera.check()?;
    match flags.exposure {
        Some(x) if !(x > 0.0 && x.is_finite()) => refuse("exposure", x.to_string(), "give a positive number"),
        _ => Ok(Some(camera)),
    }
}

#[derive(Default, serde::Deserialize)]
struct CameraFile {
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    vfov: Option<f64>,
    width: Option<u32>,
    height: Option<u32>,
}

fn camera_file(path: &Path) -> Result<CameraFile> {
    #[derive(serde::Deserialize)]
    struct File {
        camera: CameraFile,
    }
    let text = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let file: File = serde_json::from_slice(&text).map_err(|e| Error::Format {
        path: path.into(),
        line: (e.line() > 0).then_some(e.line()),
        what: e.to_string(),
        cure: r#"a camera file holds {"camera": {"eye": [x,y,z], "target": [x,y,z], "up": [x,y,z], "vfov": degrees}}"#.into(),
    })?;
    Ok(file.camera)
}

/// "x,y,z" as three finite numbers.
fn vector(text: &str) -> std::result::Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.and_then(|v| v.try_into().ok()).ok_or_else(|| "give three numbers, as 1,2.5,-3".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors() {
        assert_eq!(vector("1, -2.5,3e2"), Ok([1.0, -2.5, 300.0]));
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "a,b,c"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
    }
}
