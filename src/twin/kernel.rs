//! Pass `kernel`: G V on a batch of point pairs, for library users, form factors and baselines.

use super::math::kernel_g;
use super::trace::segment_blocked;
use super::way::between;
use crate::layout::{NONE, Point};
use crate::scene::Geometry;
use glam::Vec3;
use rayon::prelude::*;

/// G(x, y) V(x, y), times what the medium lets pass, of consecutive pairs of surface points, per **local** area (multiply by `scale`^2 for
/// per m²). 0 for points of one planar piece, for points without a triangle, and where anything blocks.
pub fn kernel(geometry: &Geometry, points: &[Point]) -> Vec<f32> {
    points
        .par_chunks_exact(2)
        .map(|pair| {
            let (x, y) = (&pair[0], &pair[1]);
            if x.tri == NONE || y.tri == NONE {
                return 0.0;
            }
            let (tx, ty) = (&geometry.tris[x.tri as usize], &geometry.tris[y.tri as usize]);
            if tx.plane == ty.plane {
                return 0.0;
            }
            let (px, py) = (Vec3::from(x.p), Vec3::from(y.p));
            let g = kernel_g(geometry.flatland, px, Vec3::from(tx.normal), py, Vec3::from(ty.normal));
            if g > 0.0 && !segment_blocked(geometry, px, py, [tx.plane, ty.plane]) { g * between(geometry, px, py) } else { 0.0 }
        })
        .collect()
}
