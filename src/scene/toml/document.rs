//! What a `.toml` scene may say: its tables and keys, as `docs/scenes.md` describes them.

use crate::scene::{KdSpace, Up};
use serde::Deserialize;
use toml::Spanned;

/// The whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    #[serde(default)]
    pub file: Vec<Spanned<File>>,
    #[serde(default)]
    pub mesh: Vec<Spanned<Mesh>>,
    #[serde(default)]
    pub segment: Vec<Spanned<Segment>>,
    pub height: Option<Spanned<f64>>,
    #[serde(default)]
    pub material: Vec<Spanned<Material>>,
    #[serde(default)]
    pub camera: Vec<Spanned<Camera>>,
    #[serde(default)]
    pub light: Vec<Spanned<Light>>,
    pub environment: Option<Spanned<Environment>>,
    pub medium: Option<Spanned<Medium>>,
}

/// What fills the scene.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Medium {
    pub absorption: f64,
}

/// Another scene file, and where it stands.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    pub path: String,
    #[serde(default = "one")]
    pub unit: f64,
    #[serde(default)]
    pub up: Up,
    pub kd_space: Option<KdSpace>,
    #[serde(default)]
    pub two_sided: bool,
    pub scale: Option<Values>,
    pub rotate: Option<[f64; 3]>,
    pub translate: Option<[f64; 3]>,
    pub matrix: Option<[[f64; 4]; 4]>,
}

/// A mesh, written out.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    pub name: String,
    pub material: String,
    pub vertices: Vec<[f64; 3]>,
    pub faces: Vec<Vec<u32>>,
    /// Texture coordinates, one a vertex, v upwards.
    #[serde(default)]
    pub uvs: Vec<[f64; 2]>,
    #[serde(default)]
    pub two_sided: bool,
}

/// Flatland segments from point to point.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    pub name: String,
    pub material: String,
    pub points: Vec<[f64; 2]>,
    #[serde(default)]
    pub closed: bool,
    #[serde(default)]
    pub side: Side,
    #[serde(default)]
    pub two_sided: bool,
}

/// The front of a segment, for one who walks from its first point to the next and sees x to the right of y.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    #[default]
    Left,
    Right,
}

/// What a material is like, over what the files say.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub name: String,
    pub reflectance: Option<Values>,
    pub mirror: Option<f64>,
    pub radiance: Option<Values>,
    pub radiosity: Option<Values>,
    pub lumens: Option<f64>,
    pub color: Option<[f64; 3]>,
    pub reflectance_map: Option<String>,
    pub emission_map: Option<String>,
    pub alpha_map: Option<String>,
    pub alpha_cutoff: Option<f64>,
    #[serde(default)]
    pub two_sided: bool,
}

/// A camera.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub name: String,
    pub eye: [f64; 3],
    pub target: [f64; 3],
    pub up: Option<[f64; 3]>,
    #[serde(default = "forty")]
    pub vfov: f64,
    #[serde(default = "pixels")]
    pub width: u32,
    #[serde(default = "pixels")]
    pub height: u32,
}

/// A light without a surface.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    pub name: String,
    pub kind: LightKind,
    pub irradiance: Option<Values>,
    pub intensity: Option<Values>,
    pub position: Option<[f64; 3]>,
    pub direction: Option<[f64; 3]>,
    pub target: Option<[f64; 3]>,
    pub angle: Option<f64>,
    pub inner: Option<f64>,
    pub outer: Option<f64>,
}

/// How it shines.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightKind {
    Sun,
    Point,
    Spot,
}

/// What is around the scene.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Environment {
    pub radiance: Option<Values>,
    pub radiosity: Option<Values>,
    pub map: Option<String>,
    pub rotation: Option<f64>,
}

/// One number for all three, or three.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "give a number, or three in brackets")]
pub enum Values {
    One(f64),
    Three([f64; 3]),
}

impl Values {
    pub fn three(self) -> [f64; 3] {
        match self {
            Values::One(x) => [x; 3],
            Values::Three(v) => v,
        }
    }
}

fn one() -> f64 {
    1.0
}

fn forty() -> f64 {
    40.0
}

fn pixels() -> u32 {
    512
}
