//! Light at the scene's vertices, for meshes with vertex colours.

use super::{Solution, narrow};
use crate::engine::Backend;
use crate::error::Result;
use crate::layout::Point;
use crate::output::mesh::{Mesh, Part, Vertex};
use crate::params::Params;
use crate::progress::{Event, Flow};
use crate::scene::{Space, wall};
use crate::twin::trace::surface_point;
use glam::Vec3;
use std::collections::HashMap;

/// Least cosine between the normals of faces that share a vertex: one degree.
const SAME_WAY: f32 = 0.99985;
/// How far a vertex's sample is moved towards its triangle's centroid, as a share of the way: on the
/// very edge the neighbour face is in contact, and no light passes.
const NUDGE: f32 = 1e-3;

/// An output vertex: where its light is taken.
struct Corner {
    vertex: u32,
    normal: Vec3,
    /// The largest triangle around it, and which corner of it.
    tri: u32,
    corner: usize,
}

impl Solution {
    /// Radiosity at every vertex: one output vertex for each vertex, material and direction of face
    /// (to a degree). Triangles that were dropped (no area, duplicates) are left out. A flatland scene's segments become
    /// walls, lit as their foot is.
    ///
    /// Errors: those of the device; [`crate::Error::NotFinite`]; [`crate::Error::Overflow`].
    pub fn vertices(&self, backend: &Backend) -> Result<Mesh> {
        self.vertices_with(backend, &mut |_| Flow::Continue)
    }

    /// As [`Solution::vertices`], telling its progress.
    pub fn vertices_with(&self, backend: &Backend, tell: &mut dyn FnMut(&Event) -> Flow) -> Result<Mesh> {
        Ok(self.drawn(self.faces_with(backend, tell)?))
    }

    /// Lit faces as they are drawn: flatland's segments as walls.
    pub(crate) fn drawn(&self, mesh: Mesh) -> Mesh {
        match self.scene.space {
            Space::Solid => mesh,
            Space::Flatland { height } => walls(mesh, height),
        }
    }

    /// The lit faces as the scene has them: flatland's segments as triangles whose last two corners are one.
    pub(crate) fn faces_with(&self, backend: &Backend, tell: &mut dyn FnMut(&Event) -> Flow) -> Result<Mesh> {
        let (corners, mesh) = self.corners();
        let points: Vec<Point> = corners
            .iter()
            .map(|c| {
                let mut b = [NUDGE / 3.0; 3];
                b[c.corner] += 1.0 - NUDGE;
                // A segment's second and third corner are one.
                let [b1, b2] = if self.geometry.flatland { [b[1] + b[2], 0.0] } else { [b[1], b[2]] };
                surface_point(&self.geometry, c.tri, b1, b2)
            })
            .collect();
        // Vertices come by the hundred thousand: gather at contacts and in slots only, with fewer rays.
        let params = Params {
            gather_rays: self.params.gather_rays.min(256),
            gather_threshold: self.params.gather_threshold.min(0.6),
            direct_tolerance: self.params.direct_tolerance.max(0.01),
            ..self.params.clone()
        };
        let shades = self.shade(backend, &params, &points, tell)?;
        let vertices = corners
            .iter()
            .zip(points.iter().zip(&shades))
            .map(|(c, (point, shade))| {
                let what = || format!("the light at vertex {}", c.vertex);
                let b = narrow(self.answer(point, shade, what)?.b, what)?;
                Ok(Vertex { p: self.scene.vertices[c.vertex as usize], n: c.normal.to_array(), b })
            })
            .collect::<Result<_>>()?;
        Ok(Mesh { vertices, ..mesh })
    }

    /// Where the vertices' light is taken, and the mesh without its vertices, in the order of the scene's faces.
    fn corners(&self) -> (Vec<Corner>, Mesh) {
        let geometry = &self.geometry;
        let mut order: Vec<u32> = (0..geometry.tris.len() as u32).collect();
        order.sort_unstable_by_key(|&t| geometry.source[t as usize]);
        let mut corners: Vec<Corner> = Vec::new();
        let mut at: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
        let (mut part, mut parts) = (Vec::new(), Vec::new());
        let mut part_of: HashMap<(u32, u32), u32> = HashMap::new();
        let faces = order
            .iter()
            .map(|&tri| {
                let t = &geometry.tris[tri as usize];
                let normal = Vec3::from(t.normal);
                let face = &self.scene.faces[geometry.source[tri as usize] as usize];
                part.push(*part_of.entry((face.object, face.material)).or_insert_with(|| {
                    let object = self.scene.objects.get(face.object as usize).cloned().unwrap_or_default();
                    parts.push(Part { object, material: self.scene.materials[face.material as usize].name.clone() });
                    parts.len() as u32 - 1
                }));
                [0, 1, 2].map(|corner| {
                    let vertex = face.vertices[corner];
                    let here = at.entry((vertex, face.material)).or_default();
                    if let Some(&k) = here.iter().find(|&&k| corners[k as usize].normal.dot(normal) > SAME_WAY) {
                        let c = &mut corners[k as usize];
                        if geometry.areas[tri as usize] > geometry.areas[c.tri as usize] {
                            (c.tri, c.corner) = (tri, corner);
                        }
                        return k;
                    }
                    here.push(corners.len() as u32);
                    corners.push(Corner { vertex, normal, tri, corner });
                    corners.len() as u32 - 1
                })
            })
            .collect();
        let sources = order.iter().map(|&t| geometry.source[t as usize]).collect();
        (corners, Mesh { vertices: Vec::new(), faces, sources, part, parts })
    }
}

/// The walls on lit segments: two triangles each, with the light of the ground all the way up.
fn walls(mesh: Mesh, height: f64) -> Mesh {
    let up = mesh.vertices.len() as u32;
    let top = mesh.vertices.iter().map(|v| Vertex { p: [v.p[0], v.p[1], height], ..*v });
    let twice = |x: &Vec<u32>| x.iter().flat_map(|&x| [x, x]).collect();
    Mesh {
        faces: mesh.faces.iter().flat_map(|&[a, b, _]| wall(a, b, up)).collect(),
        sources: twice(&mesh.sources),
        part: twice(&mesh.part),
        vertices: mesh.vertices.iter().copied().chain(top).collect(),
        parts: mesh.parts,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Params, Scene};

    #[test]
    fn a_cube_has_a_vertex_a_face_corner() {
        let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace/scene.obj")).unwrap();
        let params = Params { rays: 8192, ..Params::default() };
        let solution = crate::bake(&Backend::Cpu, &scene, &params, &mut |_| Flow::Continue).unwrap();
        let mesh = solution.vertices(&Backend::Cpu).unwrap();
        // Six sides with four corners each, whatever the diagonals.
        assert_eq!((mesh.vertices.len(), mesh.faces.len()), (24, 12));
        for face in &mesh.faces {
            let [a, b, c] = face.map(|v| mesh.vertices[v as usize]);
            assert!(a.n == b.n && b.n == c.n);
            let side = (0..3).any(|k| a.p[k] == b.p[k] && b.p[k] == c.p[k] && a.n[k].abs() == 1.0);
            assert!(side, "{a:?} {b:?} {c:?}");
        }
        // B = pi Ke / (1 - rho) everywhere, in the corners too.
        for v in &mesh.vertices {
            assert!((v.b[0] as f64 / (5.0 * std::f64::consts::PI) - 1.0).abs() < 0.05, "{v:?}");
        }
    }
}
