//! Which sides light meets: paths from the emitters, diffuse from front to front, ended by a back.

use super::mesh::Mesh;
use super::rays::{Dice, Sight};
use crate::twin::math::invert_cdf;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Paths shot.
const PATHS: u32 = 1 << 15;
/// Most surfaces a path meets.
const LENGTH: usize = 8;

/// How often light has met each patch.
pub struct Met {
    /// On its front.
    pub front: Vec<u32>,
    /// On its back.
    pub back: Vec<u32>,
}

/// Sends light through the scene. Every emitter shines equally per area and brightness; no surface swallows
/// a part of it, black ones swallow all.
pub fn meet(mesh: &Mesh) -> Met {
    let counters = || -> Vec<AtomicU32> { mesh.patch_area.iter().map(|_| AtomicU32::new(0)).collect() };
    let (front, back) = (counters(), counters());
    let emitters = &mesh.geometry.emitters;
    let paths = if emitters.is_empty() { 0 } else { PATHS };
    (0..paths).into_par_iter().for_each(|i| {
        let mut dice = Dice::new(1, i);
        // Emitters by power, evenly along the distribution.
        let u = ((i as f64 + dice.roll() as f64) / paths as f64 * 4294967296.0) as u32;
        let tri = emitters[invert_cdf(emitters.len() as u32, |e| emitters[e as usize].cdf, u).0 as usize].tri;
        let (mut sight, mut at) = mesh.look_from(tri, true, &mut dice);
        for _ in 0..LENGTH {
            match sight {
                Sight::Void => return,
                Sight::Back(t, _) => {
                    back[mesh.patch[t as usize] as usize].fetch_add(1, Relaxed);
                    return;
                }
                Sight::Front(t, _) => {
                    front[mesh.patch[t as usize] as usize].fetch_add(1, Relaxed);
                    // A mirror sends light on; where to does not matter here.
                    let mirror = mesh.geometry.tris[t as usize].mirror() > 0.0;
                    if !mirror && mesh.geometry.material_of(t as usize).rho.iter().all(|&r| r <= 0.0) {
                        return;
                    }
                    let tri = &mesh.geometry.tris[t as usize];
                    (sight, at) = mesh.look_about(at, Vec3::from(tri.normal), tri.plane, &mut dice);
                }
            }
        }
    });
    let counts = |c: Vec<AtomicU32>| c.into_iter().map(AtomicU32::into_inner).collect();
    Met { front: counts(front), back: counts(back) }
}
