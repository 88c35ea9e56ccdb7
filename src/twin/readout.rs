//! Pass `readout`: the network's irradiance at surface points (design §1, step 8).

use super::assign::Surface;
use super::math::tangents;
use crate::layout::{NONE, NodeLight, Point, Psi};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// sum_j psi_j [H_j + G_j . (y - mean_j)], clamped at 0, and by how much the nodes that speak for a point disagree about its
/// light: the standard deviation of what they say, of the mean over the bands. An orphan gets the value of the node it names.
pub fn irradiance(surface: &Surface, light: &[NodeLight], point: &Point, psi: &Psi) -> Vec4 {
    if psi.is_orphan() {
        let named = psi.node[0];
        return if named == NONE { Vec4::ZERO } else { Vec3::from(light[named as usize].h).max(Vec3::ZERO).extend(0.0) };
    }
    let mut sum = Vec3::ZERO;
    let (mut mean, mut square) = (0.0, 0.0);
    for k in 0..4 {
        if psi.weight[k] > 0.0 {
            let node = &surface.nodes[psi.node[k] as usize];
            let l = &light[psi.node[k] as usize];
            let (t1, t2) = tangents(Vec3::from(node.n));
            let d = Vec3::from(point.p) - Vec3::from(node.p);
            let (a, b) = (d.dot(t1) - node.mean[0], d.dot(t2) - node.mean[1]);
            let says = Vec3::from(l.h) + Vec3::from(l.g0) * a + Vec3::from(l.g1) * b;
            sum += says * psi.weight[k];
            let grey = (says.x + says.y + says.z) / 3.0;
            mean += grey * psi.weight[k];
            square += grey * grey * psi.weight[k];
        }
    }
    sum.max(Vec3::ZERO).extend((square - mean * mean).max(0.0).sqrt())
}

/// Irradiance at many points, scaled W/m²; the fourth number is by how much the nodes disagree.
pub fn readout(surface: &Surface, light: &[NodeLight], points: &[Point], psi: &[Psi]) -> Vec<[f32; 4]> {
    points.par_iter().zip(psi).map(|(p, s)| irradiance(surface, light, p, s).to_array()).collect()
}
