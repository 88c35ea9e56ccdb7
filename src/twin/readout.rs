//! Pass `readout`: the network's irradiance at surface points (design §1, step 8).

use super::assign::Surface;
use super::math::tangents;
use crate::layout::{NONE, NodeLight, Point, Psi};
use glam::Vec3;
use rayon::prelude::*;

/// sum_j psi_j [H_j + G_j . (y - mean_j)], clamped at 0; an orphan gets the value of the node it names.
pub fn irradiance(surface: &Surface, light: &[NodeLight], point: &Point, psi: &Psi) -> Vec3 {
    if psi.is_orphan() {
        return if psi.node[0] == NONE { Vec3::ZERO } else { Vec3::from(light[psi.node[0] as usize].h).max(Vec3::ZERO) };
    }
    let mut sum = Vec3::ZERO;
    for k in 0..4 {
        if psi.weight[k] > 0.0 {
            let node = &surface.nodes[psi.node[k] as usize];
            let l = &light[psi.node[k] as usize];
            let (t1, t2) = tangents(Vec3::from(node.n));
            let d = Vec3::from(point.p) - Vec3::from(node.p);
            let (a, b) = (d.dot(t1) - node.mean[0], d.dot(t2) - node.mean[1]);
            sum += (Vec3::from(l.h) + Vec3::from(l.g0) * a + Vec3::from(l.g1) * b) * psi.weight[k];
        }
    }
    sum.max(Vec3::ZERO)
}

/// Irradiance at many points, scaled W/m²; the fourth number is unused.
pub fn readout(surface: &Surface, light: &[NodeLight], points: &[Point], psi: &[Psi]) -> Vec<[f32; 4]> {
    points.par_iter().zip(psi).map(|(p, s)| irradiance(surface, light, p, s).extend(0.0).to_array()).collect()
}
