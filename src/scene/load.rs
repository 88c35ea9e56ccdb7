//! Scene files, whatever their kind: what a reader may be told, where it gets its bytes, and what is done
//! to every scene once it is read.

use super::{Scene, Space, View, gltf, obj, sides, toml, transform};
use crate::error::{Error, Result};
use crate::progress::{Event, Flow, Progress};
use std::io;
use std::path::Path;

/// How the numbers of an MTL's `Kd` are meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum KdSpace {
    /// As reflectances, linear Rec.709.
    #[default]
    Linear,
    /// As colours on a screen, sRGB; they are made linear.
    Srgb,
}

/// Which axis of a file points up. In a scene it is y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// As in a scene.
    #[default]
    Y,
    /// As in Blender, CAD and maps: (x, y, z) becomes (x, z, -y).
    Z,
}

/// How a scene file is to be read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoadOptions {
    /// How `Kd` of an MTL is meant; glTF and TOML are linear whatever this says.
    pub kd_space: KdSpace,
    /// Refuses what else would be worth a warning.
    pub strict: bool,
    /// Gives every triangle a twin of opposite winding: both sides reflect, and both sides of an emitter shine.
    pub two_sided: bool,
    /// Metres in a unit of the file, positive and finite.
    pub unit: f64,
    /// The file's upward axis.
    pub up: Up,
}

impl Default for LoadOptions {
    fn default() -> LoadOptions {
        LoadOptions { kd_space: KdSpace::Linear, strict: false, two_sided: false, unit: 1.0, up: Up::Y }
    }
}

/// What the readers of all formats share: options, bytes by path, progress.
pub(super) struct Reader<'a> {
    pub options: LoadOptions,
    pub progress: Progress<'a>,
    files: &'a mut dyn FnMut(&Path) -> io::Result<Vec<u8>>,
}

impl Reader<'_> {
    /// A file that must be there.
    pub fn read(&mut self, path: &Path) -> Result<Vec<u8>> {
        self.try_read(path).map_err(|source| Error::Read { path: path.into(), source })
    }

    /// A file that may be missing.
    pub fn try_read(&mut self, path: &Path) -> io::Result<Vec<u8>> {
        (self.files)(path)
    }
}

impl Scene {
    /// Reads a scene file by its extension: `.obj` with its `.mtl`, `.gltf`, `.glb` or `.toml` (`docs/scenes.md`).
    ///
    /// Errors: [`Error::Read`], [`Error::Format`], and those of [`Scene::check`].
    pub fn load(path: impl AsRef<Path>) -> Result<Scene> {
        Scene::load_with(path, &LoadOptions::default())
    }

    /// [`Scene::load`] without [`Scene::check`], for [`crate::doctor`], who has more to say of a sick scene.
    ///
    /// Errors: [`Error::Read`], [`Error::Format`].
    pub fn read(path: impl AsRef<Path>) -> Result<Scene> {
        Scene::read_with(path, &LoadOptions::default())
    }

    /// As [`Scene::read`], as the options say, `strict` apart. Errors: also [`Error::InvalidParam`].
    pub fn read_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene> {
        read_from(path.as_ref(), options, &mut |path| std::fs::read(path), &mut |_| Flow::Continue)
    }

    /// As [`Scene::load`], as the options say. Errors: also [`Error::InvalidParam`].
    pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Scene> {
        Scene::load_from(path.as_ref(), options, &mut |path| std::fs::read(path), &mut |_| Flow::Continue)
    }

    /// As [`Scene::load_with`], with the bytes of the scene and of every file it names from `files`, a disk or
    /// not, and `tell` hearing [`Event::Read`]. Files are asked for by their path relative to that of the scene's.
    ///
    /// Errors: also [`Error::Cancelled`].
    pub fn load_from(
        path: &Path,
        options: &LoadOptions,
        files: &mut dyn FnMut(&Path) -> io::Result<Vec<u8>>,
        tell: &mut dyn FnMut(&Event) -> Flow,
    ) -> Result<Scene> {
        let scene = read_from(path, options, files, tell)?;
        if let (true, [first, more @ ..]) = (options.strict, &scene.warnings[..]) {
            let (what, cure) = first.split_once("; ").unwrap_or((first, "correct it"));
            let more = if more.is_empty() { String::new() } else { format!(" (and {} more)", more.len()) };
            return Err(Error::Strict { what: format!("{what}{more}"), cure: cure.into() });
        }
        scene.check()?;
        Ok(scene)
    }
}

fn read_from(
    path: &Path,
    options: &LoadOptions,
    files: &mut dyn FnMut(&Path) -> io::Result<Vec<u8>>,
    tell: &mut dyn FnMut(&Event) -> Flow,
) -> Result<Scene> {
    if !(options.unit > 0.0 && options.unit.is_finite()) {
        let range = "give the metres in a unit of the file, a positive number";
        return Err(Error::InvalidParam { name: "unit", value: options.unit.to_string(), range });
    }
    let mut reader = Reader { options: options.clone(), progress: Progress::new(tell), files };
    let mut scene = match kind(path)? {
        Kind::Obj => obj::read(path, &mut reader, &[])?,
        Kind::Gltf => gltf::read(path, &mut reader)?,
        Kind::Toml => toml::read(path, &mut reader)?,
    };
    if !scene.materials.iter().any(|m| m.maps().iter().any(Option::is_some)) {
        // Coordinates of no map.
        (scene.textures, scene.uvs, scene.face_uvs) = Default::default();
    }
    place(&mut scene, options.unit, options.up);
    if options.two_sided {
        sides::mirror(&mut scene, |_| true);
    }
    Ok(scene)
}

/// The formats.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Obj,
    Gltf,
    Toml,
}

/// The format that a file's name tells.
pub(super) fn kind(path: &Path) -> Result<Kind> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "obj" => Ok(Kind::Obj),
        "gltf" | "glb" => Ok(Kind::Gltf),
        "toml" => Ok(Kind::Toml),
        _ => Err(Error::Format {
            path: path.into(),
            line: None,
            what: "the name does not tell a format of scenes".into(),
            cure: "name the file .obj, .gltf, .glb or .toml, or export it as one of these".into(),
        }),
    }
}

/// A file's position in metres, y up.
pub(super) fn to_metres([x, y, z]: [f64; 3], unit: f64, up: Up) -> [f64; 3] {
    let v = match up {
        Up::Y => [x, y, z],
        Up::Z => [x, z, -y],
    };
    v.map(|c| c * unit)
}

/// Brings a scene as a file has it to metres, y up.
pub(super) fn place(scene: &mut Scene, unit: f64, up: Up) {
    if (unit, up) == (1.0, Up::Y) {
        return;
    }
    for v in &mut scene.vertices {
        *v = to_metres(*v, unit, up);
    }
    if let Space::Flatland { height } = &mut scene.space {
        *height *= unit;
    }
    for View { camera, .. } in &mut scene.cameras {
        camera.eye = to_metres(camera.eye, unit, up);
        camera.target = to_metres(camera.target, unit, up);
        camera.up = to_metres(camera.up, 1.0, up);
    }
    for light in &mut scene.lights {
        transform::place(&mut light.kind, |p| *p = to_metres(*p, unit, up), |d| *d = to_metres(*d, 1.0, up));
    }
}
