//! The way of a ray (`wgsl/lib/way.wgsl`): along ideal mirrors to what is no mirror, through an absorbing medium.
//!
//! Unfolded along planar mirrors a way is straight, so the density of cosine rays is G of its whole length and a ray
//! still serves both ways with w = 1/(p(s) + p(t)). What arrives is T = product of the mirrors' reflectances x
//! exp(-sigma length). The medium fills the scene's bounding box; beyond it nothing is absorbed.

use super::trace::{Hit, Ray, closest_from, position};
use crate::layout::{NONE, kind};
use crate::scene::Geometry;
use glam::Vec3;

/// Most mirrors on a way.
pub const MIRRORS: u32 = 64;
/// Product of reflectances below which a way is given up. Both this and [`MIRRORS`] are the same from either end.
pub const LEAST: f32 = 1e-4;

/// A way from a surface point to where it ends.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// One of [`kind`]; [`kind::LOST`] where it was given up between mirrors.
    pub kind: u32,
    /// What is there; `t` is the whole length (of a way to the sky [`f32::MAX`]).
    pub hit: Hit,
    /// Direction on arrival.
    pub direction: Vec3,
    /// Mirrors that it met.
    pub mirrors: u32,
    /// T: the share of the light that arrives; 0 where it was given up.
    pub share: f32,
    /// The share that mirrors took, all that was given up included. The medium took the rest.
    pub mirrored: f32,
}

/// e^-x for x >= 0, by polynomials: the same bits on every driver, where the built-in differs.
pub fn fade(x: f32) -> f32 {
    let y = x * -std::f32::consts::LOG2_E;
    let whole = (y + 0.5).floor();
    if whole < -126.0 {
        return 0.0;
    }
    let f = (y - whole) * std::f32::consts::LN_2;
    let p = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0))))));
    p * f32::from_bits(((whole as i32 + 127) as u32) << 23)
}

/// What arrives of light between two points of the medium that see each other.
pub fn between(geometry: &Geometry, a: Vec3, b: Vec3) -> f32 {
    let d = b - a;
    if geometry.sigma > 0.0 { fade(geometry.sigma * d.dot(d).sqrt()) } else { 1.0 }
}

/// How far it is in a direction (unit) to where the scene's bounding box ends.
pub fn way_out(geometry: &Geometry, p: Vec3, direction: Vec3) -> f32 {
    let root = &geometry.nodes[0];
    let (low, high) = (Vec3::from(root.min), Vec3::from(root.max));
    let mut out = f32::MAX;
    for k in 0..3 {
        if direction[k].abs() > 1e-20 {
            let side = if direction[k] > 0.0 { high[k] } else { low[k] };
            out = out.min((side - p[k]) / direction[k]);
        }
    }
    out.max(0.0)
}

/// What arrives of light that comes to a point from a direction (unit), from `length` away: beyond the box there is no medium.
pub fn from_without(geometry: &Geometry, p: Vec3, direction: Vec3, length: f32) -> f32 {
    if geometry.sigma > 0.0 { fade(geometry.sigma * length.min(way_out(geometry, p, direction))) } else { 1.0 }
}

/// How far it is in a direction (unit) to where the scene's bounding box begins; 0 from within, and where it is missed.
pub fn way_in(geometry: &Geometry, p: Vec3, direction: Vec3) -> f32 {
    let root = &geometry.nodes[0];
    let (low, high) = (Vec3::from(root.min), Vec3::from(root.max));
    let (mut enter, mut leave) = (0.0f32, f32::MAX);
    for k in 0..3 {
        if direction[k].abs() > 1e-20 {
            let sides = [(low[k] - p[k]) / direction[k], (high[k] - p[k]) / direction[k]];
            enter = enter.max(sides[0].min(sides[1]));
            leave = leave.min(sides[0].max(sides[1]));
        }
    }
    if enter < leave { enter } else { 0.0 }
}

/// Follows a direction (unit) from a point on triangle `tri`, or from any point where that is [`NONE`].
pub fn follow(geometry: &Geometry, tri: u32, p: Vec3, direction: Vec3) -> Way {
    let (mut at, mut left, mut length, mut gloss) = (p, tri, 0.0, 1.0);
    let mut way = Way { kind: kind::SKY, hit: Hit::none(f32::MAX), direction, mirrors: 0, share: 1.0, mirrored: 0.0 };
    loop {
        let side = geometry.tris.get(left as usize).map_or((NONE, Vec3::ZERO), |t| (t.plane, Vec3::from(t.normal)));
        let ray = Ray { origin: at, direction: way.direction, t_max: f32::MAX, skip: [side.0, NONE] };
        let hit = closest_from(geometry, &ray, side.1);
        if geometry.sigma > 0.0 {
            let leg = if hit.tri == NONE { way_out(geometry, at, way.direction) } else { hit.t };
            way.share *= fade(geometry.sigma * leg);
        }
        if hit.tri == NONE {
            return way;
        }
        let there = &geometry.tris[hit.tri as usize];
        let across = Vec3::from(there.normal).dot(way.direction);
        length += hit.t;
        let mirror = there.mirror();
        if across >= 0.0 || mirror <= 0.0 {
            way.kind = if across < 0.0 { kind::FRONT } else { kind::BACK };
            way.hit = Hit { t: length, ..hit };
            return way;
        }
        // Reflect, unless next to nothing is left.
        way.mirrors += 1;
        gloss *= mirror;
        let on = way.share * mirror;
        way.mirrored += way.share - on;
        way.share = on;
        if gloss < LEAST || way.mirrors == MIRRORS {
            (way.kind, way.mirrored, way.share) = (kind::LOST, way.mirrored + way.share, 0.0);
            return way;
        }
        at = position(geometry.flatland, there, hit.b1, hit.b2);
        left = hit.tri;
        way.direction -= Vec3::from(there.normal) * (2.0 * across);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Scene, shapes};

    #[test]
    fn fade_is_the_exponential() {
        for i in 0..100_000 {
            let x = i as f32 * 1e-3;
            let want = f64::from(-x).exp();
            // 2 ulp, and what rounding of x log2 e to 24 bits leaves.
            assert!((f64::from(fade(x)) - want).abs() <= want * f64::from(2.5e-7 + 1.2e-7 * x) + 1e-38, "{x}: {}", fade(x));
        }
        assert_eq!((fade(0.0), fade(100.0), fade(f32::MAX)), (1.0, 0.0, 0.0));
    }

    /// Two mirrors that face each other along x, the other walls diffuse.
    #[test]
    fn a_way_between_two_mirrors_is_its_unfolded_one() {
        let materials = vec![Material::new("wall", [0.5; 3], [0.0; 3]), Material::new_mirror("mirror", 0.9)];
        let room = shapes::room([0.0; 3], [1.0; 3], [1, 1, 0, 0, 0, 0]);
        let scene = Scene { absorption: 0.25, ..Scene::from_triangles("room", &room, materials).unwrap() };
        let geometry = Geometry::new(&scene).unwrap();
        // From the floor, upwards by 1 and along x by 2.6: over the mirrors at 1 and 2.
        let floor = geometry.locate([0.3, 0.0, 0.5], [0.0, 1.0, 0.0]).unwrap();
        let way = follow(&geometry, floor.tri, Vec3::from(floor.p), Vec3::new(2.6, 1.0, 0.05).normalize());
        let length = Vec3::new(2.6, 1.0, 0.05).length();
        assert_eq!((way.kind, way.mirrors), (kind::FRONT, 2));
        let end = geometry.to_world(position(false, &geometry.tris[way.hit.tri as usize], way.hit.b1, way.hit.b2).to_array());
        // 0.3 + 2.6 = 2.9, folded twice.
        for (got, want) in end.iter().zip([0.9, 1.0, 0.55]) {
            assert!((got - want).abs() < 1e-5, "{end:?}");
        }
        let want = 0.9f32.powi(2) * (-0.25 * length).exp();
        assert!((way.share - want).abs() < 1e-5 && (way.hit.t / geometry.scale as f32 - length).abs() < 1e-5, "{way:?}");
        assert!(way.mirrored > 0.0 && way.mirrored + way.share < 1.0);
        // Along x it never ends: given up, and all accounted for.
        let lost = follow(&geometry, NONE, Vec3::ZERO, Vec3::X);
        assert_eq!((lost.kind, lost.mirrors, lost.share), (kind::LOST, MIRRORS, 0.0));
        assert!(lost.mirrored < 1.0 && lost.mirrored > 0.1, "{lost:?}");
    }
}
