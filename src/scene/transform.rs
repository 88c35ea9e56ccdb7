//! Placing a part of a scene.

use super::{Face, Scene, View};
use glam::{DMat4, DVec3};

/// What to place: everything a scene holds from these lengths on.
#[derive(Clone, Copy, Debug)]
pub struct From {
    pub vertices: usize,
    pub faces: usize,
    pub cameras: usize,
}

impl From {
    /// The end of a scene as it is: what comes later will be placed.
    pub fn end(scene: &Scene) -> From {
        From { vertices: scene.vertices.len(), faces: scene.faces.len(), cameras: scene.cameras.len() }
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
}
