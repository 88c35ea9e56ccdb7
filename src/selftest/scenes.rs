//! What the cases are tried on.

use crate::error::Result;
use crate::scene::shapes::{Triangles, quad, room};
use crate::scene::{Material, Scene};
use std::f64::consts::PI;

/// A grey material that emits radiosity `e`.
pub fn grey(rho: f64, e: f64) -> Material {
    Material::new("grey", [rho; 3], [e / PI; 3])
}

/// A scene of triangles.
pub fn solid(triangles: &Triangles, materials: &[Material]) -> Result<Scene> {
    Scene::from_triangles("selftest", triangles, materials.to_vec())
}

/// The unit square's sides, fronts inwards: bottom, right, top, left.
pub const SQUARE: [[[f64; 2]; 2]; 4] =
    [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 1.0]], [[1.0, 1.0], [0.0, 1.0]], [[0.0, 1.0], [0.0, 0.0]]];

/// A flatland scene of segments, a material each.
pub fn flat(segments: &[[[f64; 2]; 2]], materials: &[Material]) -> Result<Scene> {
    let segments: Vec<_> = segments.iter().enumerate().map(|(i, &s)| (s, (i % materials.len()) as u32)).collect();
    Scene::from_segments("selftest", &segments, materials.to_vec())
}

/// The unit square [0,1]^2 at a height, facing up or down; the two triangles come as one shape.
pub fn plate(z: f64, up: bool) -> Triangles {
    let [a, b, c, d] = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
    quad(if up { [a, b, c, d] } else { [a, d, c, b] }, 0)
}

/// The unit cube seen from inside, its sides' materials 0 to 5.
pub fn cube() -> Triangles {
    room([0.0; 3], [1.0; 3], [0, 1, 2, 3, 4, 5])
}

/// Turns a place about a skew axis, scales and moves it.
pub fn placed(scale: f64, by: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    let turn = glam::DQuat::from_axis_angle(glam::DVec3::new(0.36, 0.48, 0.8), 1.1);
    move |p| (turn * (glam::DVec3::from(p) - 0.5) * scale + by).to_array()
}
