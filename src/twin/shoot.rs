//! Pass `shoot`: cosine rays from given points; the hits are points again, for probes and final gathers.

use super::math::{cosine_direction, seed_of, unit};
use super::sobol::sobol4;
use super::trace::surface_point;
use super::way::follow;
use crate::layout::{NONE, Point, kind};
use crate::scene::Geometry;
use glam::Vec3;
use rayon::prelude::*;

/// Rays `first..first + rays` of each point's own sequence (seeded by its index in `points`), `rays`
/// consecutive hits a point. A hit's `weight` is its distance (local), its `kind` what was met, its `density` the share of
/// its light that arrives where some is lost on the way.
pub fn shoot(geometry: &Geometry, points: &[Point], seed: u32, first: u32, rays: u32) -> Vec<Point> {
    (0..points.len() as u32 * rays)
        .into_par_iter()
        .map(|r| {
            let (i, k) = (r / rays, first + r % rays);
            let from = &points[i as usize];
            if from.tri == NONE {
                return Point { tri: NONE, tile: NONE, kind: kind::DEAD, ..Point::default() };
            }
            let n = Vec3::from(geometry.tris[from.tri as usize].normal);
            let u = sobol4(k, seed_of(seed, i));
            let direction = cosine_direction(geometry.flatland, n, unit(u[0]), unit(u[1]));
            let way = follow(geometry, from.tri, Vec3::from(from.p), direction);
            let (met, hit) = (way.kind, way.hit);
            let mut p = Point { tri: NONE, tile: NONE, ..Point::default() };
            if hit.tri != NONE {
                p = surface_point(geometry, hit.tri, hit.b1, hit.b2);
                p.weight = hit.t;
            }
            p.kind = met;
            if geometry.is_lossy() {
                p.density = way.share;
            }
            p
        })
        .collect()
}
