//! Placing a part of a scene.

use super::{Face, LightKind, Scene, View};
use glam::{DMat4, DVec3};

/// What to place: everything a scene holds from these lengths on.
#[derive(Clone, Copy, Debug)]
pub struct From {
    pub vertices: usize,
    pub faces: usize,
    pub cameras: usize,
    pub lights: usize,
}

impl From {
    /// The end of a scene as it is: what comes later will be placed.
    pub fn end(scene: &Scene) -> From {
        From {
            vertices: scene.vertices.len(),
            faces: scene.faces.len(),
            cameras: scene.cameras.len(),
            lights: scene.lights.len(),
        }
    }
}

/// Moves by a matrix. Where that mirrors, triangles are wound the other way: fronts stay fronts.
pub fn apply(scene: &mut Scene, from: From, matrix: DMat4) {
    if matrix == DMat4::IDENTITY {
        return;
    }
    for v in &mut scene.vertices[from.vertices..] {
        *v = matrix.transform_point3(DVec3::from_array(*v)).to_array();
    }
    if matrix.determinant() < 0.0 {
        for Face { vertices, .. } in &mut scene.faces[from.faces..] {
            vertices.swap(1, 2);
        }
        for corners in scene.face_uvs.iter_mut().skip(from.faces) {
            corners.swap(1, 2);
        }
    }
    for View { camera, .. } in &mut scene.cameras[from.cameras..] {
        for point in [&mut camera.eye, &mut camera.target] {
            *point = matrix.transform_point3(DVec3::from_array(*point)).to_array();
        }
        camera.up = matrix.transform_vector3(DVec3::from_array(camera.up)).to_array();
    }
    let point = |p: &mut [f64; 3]| *p = matrix.transform_point3(DVec3::from_array(*p)).to_array();
    let way = |d: &mut [f64; 3]| *d = matrix.transform_vector3(DVec3::from_array(*d)).to_array();
    scene.lights[from.lights..].iter_mut().for_each(|light| place(&mut light.kind, point, way));
}

/// Moves a light: its place and its direction.
pub fn place(light: &mut LightKind, point: impl Fn(&mut [f64; 3]), way: impl Fn(&mut [f64; 3])) {
    match light {
        LightKind::Sun { direction, .. } => way(direction),
        LightKind::Point { position } => point(position),
        LightKind::Spot { position, direction, .. } => {
            point(position);
            way(direction);
        }
    }
}
