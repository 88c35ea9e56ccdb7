//! Bad winding, as a bake's own rays show it: surfaces that light meets from behind, emitters that light nothing.

use crate::layout::{NONE, Point, TWIN, kind};
use crate::scene::{Geometry, Scene};
use crate::twin::emit::first_hit;
use crate::twin::math::{cosine_direction, seed_of, unit};
use crate::twin::sobol::sobol4;
use crate::twin::trace::{place_on, position};
use glam::Vec3;
use rayon::prelude::*;

/// Share of hits from behind that is worth a warning.
const SHARE: f64 = 0.01;
/// Hits from behind that are no accident of rounding along edges.
const LEAST: u32 = 10;
/// Rays that an emitting object shoots.
const RAYS: u32 = 256;

/// What the rays of a batch met, for each object of the scene.
pub struct Winding {
    /// Hits, and those of them on back faces.
    hits: Vec<[u32; 2]>,
    /// What the emitter's own rays met: front faces, back faces, nothing. `None`: the object does not emit.
    emitters: Vec<Option<[u32; 3]>>,
}

impl Winding {
    /// Counts the rays of a batch, two points each, as the bake shot them. A ray that met a back face holds its
    /// direction only and is shot once more here; rays of dead starts (floor under a box) tell nothing.
    pub fn count(scene: &Scene, geometry: &Geometry, points: &[Point]) -> Winding {
        let object = |tri: u32| scene.faces[geometry.source[tri as usize] as usize].object as usize;
        let met = |ray: &[Point]| match ray[0].kind {
            kind::FRONT => Some((object(ray[1].tri), 0)),
            kind::BACK => {
                // The device's ray may just miss here.
                let (_, hit) = first_hit(geometry, ray[0].tri, ray[0].p.into(), ray[1].p.into());
                (hit.tri != NONE).then(|| (object(hit.tri), 1))
            }
            _ => None,
        };
        let mut hits = vec![[0; 2]; scene.objects.len()];
        for (object, back) in points.par_chunks_exact(2).filter_map(met).collect::<Vec<_>>() {
            hits[object][0] += 1;
            hits[object][1] += back;
        }

        // Emitters, each by its own area: of small ones a batch holds no ray.
        let mut shining = vec![Vec::new(); scene.objects.len()];
        // One that shines both ways is not wound wrong.
        for e in geometry.emitters.iter().filter(|e| geometry.tris[e.tri as usize].plane & TWIN == 0) {
            shining[object(e.tri)].push(e.tri);
        }
        let emitters = shining.par_iter().map(|tris| (!tris.is_empty()).then(|| shoot(geometry, tris))).collect();
        Winding { hits, emitters }
    }

    /// Warnings that name the object, a number and the cure.
    pub fn warnings(&self, scene: &Scene) -> Vec<String> {
        let cure = "flip its faces in the modeller, or bake with --two-sided";
        let mut out = Vec::new();
        for (o, name) in scene.objects.iter().enumerate() {
            let [hits, back] = self.hits[o];
            let share = back as f64 / (hits as f64).max(1.0);
            if back >= LEAST && share > SHARE {
                out.push(format!("object '{name}': {:.1} % of the rays that meet it meet its back; {cure}", 100.0 * share));
            }
            match self.emitters[o] {
                Some([0, 0, nothing]) if nothing > 0 => {
                    out.push(format!("object '{name}' shines, but out of the scene only; {cure}"))
                }
                Some([0, back, _]) if back > 0 => out.push(format!("object '{name}' shines, but on back faces only; {cure}")),
                _ => {}
            }
        }
        out
    }
}

/// What cosine rays from an object's emitting triangles meet: front faces, back faces, nothing.
fn shoot(geometry: &Geometry, tris: &[u32]) -> [u32; 3] {
    let mut met = [0; 3];
    for k in 0..RAYS {
        let tri = tris[(k as u64 * tris.len() as u64 / RAYS as u64) as usize];
        let [a, b, c, d] = sobol4(k, seed_of(0, tri)).map(unit);
        let t = &geometry.tris[tri as usize];
        let (b1, b2) = place_on(geometry.flatland, a, b);
        let direction = cosine_direction(geometry.flatland, Vec3::from(t.normal), c, d);
        let (kind, _) = first_hit(geometry, tri, position(geometry.flatland, t, b1, b2), direction);
        met[match kind {
            kind::FRONT => 0,
            kind::BACK => 1,
            _ => 2,
        }] += 1;
    }
    met
}
