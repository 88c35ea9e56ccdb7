//! Pass `emit`: start points by importance, cosine directions, first hits (design §1, step 1).

use super::math::{cosine_direction, invert_cdf, seed_of, unit};
use super::sobol::sobol4;
use super::texture::is_there;
use super::trace::{place_in_tile, position, surface_point, tile_of};
use super::way::follow;
use crate::layout::{NONE, Point, Tile, kind};
use crate::scene::Geometry;
use glam::Vec3;
use rayon::prelude::*;

/// Cosine rays that decide whether a start without a front hit is dead.
pub const PROBES: u32 = 11;
/// Probes after which a start that has seen sky only is taken for alive.
pub const SKY_PROBES: u32 = 4;

/// What a cosine ray from a surface point met, along mirrors; the hit's `t` is the whole length of its way.
pub fn first_hit(geometry: &Geometry, tri: u32, p: Vec3, direction: Vec3) -> (u32, super::trace::Hit) {
    let way = follow(geometry, tri, p, direction);
    (way.kind, way.hit)
}

/// Whether a point that has not yet seen a front face is dead: no front hit in all probes, and back
/// faces in at least a quarter of them. Floor under a box, strips behind a wall.
pub fn is_dead(geometry: &Geometry, tri: u32, p: Vec3, seed: u32, first: u32) -> bool {
    let n = Vec3::from(geometry.tris[tri as usize].normal);
    let mut back = (first == kind::BACK) as u32;
    for k in 0..PROBES {
        let u = sobol4(k, seed);
        let (met, _) = first_hit(geometry, tri, p, cosine_direction(geometry.flatland, n, unit(u[2]), unit(u[3])));
        if met == kind::FRONT {
            return false;
        }
        back += (met == kind::BACK) as u32;
        if back == 0 && k + 1 == SKY_PROBES {
            return false;
        }
    }
    4 * back > PROBES
}

/// Shoots rays `first..first + count` of the sequence; `total` divides the weights. Two points a ray.
///
/// A front hit counts both ways with w = 1/(n (p(s) + p(t))); a ray to the sky or to a back face one
/// way with w = 1/(n p(s)). The end of a ray to the sky holds the direction in which it leaves, of one to a back face
/// that in which it was shot.
pub fn emit(geometry: &Geometry, tiles: &[Tile], seed: u32, first: u32, count: u32, total: u32) -> Vec<Point> {
    (first..first + count)
        .into_par_iter()
        .flat_map_iter(|i| {
            let u = sobol4(i, seed);
            let (tile, place) = invert_cdf(tiles.len() as u32, |t| tiles[t as usize].cdf, u[0]);
            let tri = geometry.tile_tri[tile as usize];
            let t = &geometry.tris[tri as usize];
            let (b1, b2) = place_in_tile(geometry.flatland, t.cuts(), tile - t.first_tile, place, unit(u[1]));
            let p = position(geometry.flatland, t, b1, b2);
            let direction = cosine_direction(geometry.flatland, Vec3::from(t.normal), unit(u[2]), unit(u[3]));
            if !is_there(geometry, tri, b1, b2) {
                // What is cut out sends nothing and receives nothing.
                let s = Point { p: p.to_array(), tri, tile, density: tiles[tile as usize].density, ..Point::default() };
                let end = Point { p: direction.to_array(), tri: NONE, tile: NONE, ..Point::default() };
                return [s, end];
            }
            let way = follow(geometry, tri, p, direction);
            let (met, hit) = (way.kind, way.hit);
            let density = tiles[tile as usize].density;
            let n = total as f32;
            let mut s = Point { p: p.to_array(), tri, tile, kind: met, weight: 0.0, density };
            let mut end = Point { p: direction.to_array(), tri: NONE, tile: NONE, kind: met, weight: 0.0, density: 0.0 };
            if met == kind::FRONT {
                end = surface_point(geometry, hit.tri, hit.b1, hit.b2);
                end.kind = met;
                end.density =
                    tiles[tile_of(geometry.flatland, &geometry.tris[hit.tri as usize], hit.b1, hit.b2) as usize].density;
                s.weight = 1.0 / (n * (density + end.density));
                end.weight = s.weight;
            } else if is_dead(geometry, tri, p, seed_of(seed, i), met) {
                s.kind = kind::DEAD;
                end.kind = kind::DEAD;
            } else {
                s.weight = 1.0 / (n * density);
            }
            if geometry.is_lossy() {
                (s.density, end.density) = (way.mirrored, way.share);
                if met == kind::SKY {
                    end.p = way.direction.to_array();
                }
            }
            [s, end]
        })
        .collect()
}
