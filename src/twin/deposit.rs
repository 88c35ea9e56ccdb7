//! Pass `deposit`: what rays bring to the nodes from emitter ends whose light is known.
//!
//! The known part needs no cell: each ray carries it from its own emitter end to its own nodes.

use super::assign::Surface;
use super::coefficients::offsets;
use super::fixed::{UNIT, encode};
use crate::layout::{DirectSum, NodeSource, Point, Psi, kind};
use crate::scene::Geometry;
use glam::Vec3;

/// Sums w psi s over directed rays that count both ways, with s = rho (D + H) at the emitter end, or E + rho H where
/// `direct` is `None`: the rays then carry direct light, too. `light` holds H at every point, or is empty where H is not known yet (0).
pub fn deposit(
    geometry: &Geometry,
    surface: &Surface,
    points: &[Point],
    psi: &[Psi],
    direct: Option<&[DirectSum]>,
    light: &[[f32; 4]],
    normalise: f32,
) -> Vec<NodeSource> {
    let mut sums = vec![NodeSource::default(); surface.nodes.len()];
    for d in 0..points.len() {
        let y = &points[d];
        if y.kind != kind::FRONT {
            continue;
        }
        let material = geometry.material_at(&points[d ^ 1]);
        let h = light.get(d ^ 1).map_or(Vec3::ZERO, |h| Vec3::from_slice(&h[..3]));
        let mut sent = match direct {
            Some(direct) => Vec3::from(material.rho) * (Vec3::from(direct[d ^ 1].mean()) + h),
            None => Vec3::from(material.rho) * h + Vec3::from(material.emit),
        };
        if geometry.is_lossy() {
            sent *= points[d | 1].density;
        }
        for k in 0..4 {
            if psi[d].weight[k] > 0.0 {
                let node = psi[d].node[k] as usize;
                let (a, b) = offsets(&surface.nodes[node], Vec3::from(y.p));
                let v = ((y.weight * normalise) * psi[d].weight[k]) * surface.nodes[node].gain;
                for band in 0..3 {
                    let s = v * sent[band];
                    sums[node].value[band].add(encode(s, UNIT));
                    sums[node].first[band].add(encode(s * a, UNIT));
                    sums[node].second[band].add(encode(s * b, UNIT));
                }
            }
        }
    }
    sums
}

/// Adds another batch.
pub fn merge(sums: &mut Vec<NodeSource>, more: Vec<NodeSource>) {
    if sums.is_empty() {
        *sums = more;
        return;
    }
    for (sum, more) in sums.iter_mut().zip(&more) {
        sum.add(more);
    }
}
