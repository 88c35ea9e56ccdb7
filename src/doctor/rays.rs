//! Rays that see: which side of what they meet.

use super::mesh::Mesh;
use crate::layout::NONE;
use crate::twin::math::{cosine_direction, seed_of, unit};
use crate::twin::trace::{Ray, closest, place_on, position};
use glam::Vec3;

/// Nearer than this (local), a ray meets the neighbourhood it comes from.
const NEAR: f32 = 1e-5;

/// What a ray has met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// Nothing.
    Void,
    /// The lit side of a triangle, so far away.
    Front(u32, f32),
    /// The back of a triangle, so far away.
    Back(u32, f32),
}

/// Numbers in [0, 1) from a seed, one after the other.
pub struct Dice(u32, u32);

impl Dice {
    pub fn new(seed: u32, item: u32) -> Dice {
        Dice(seed_of(seed, item), 0)
    }

    pub fn roll(&mut self) -> f32 {
        self.1 += 1;
        unit(seed_of(self.0, self.1))
    }
}

impl Mesh<'_> {
    /// What stands in a direction (unit). `plane` is the planar piece the ray comes from, or [`NONE`].
    pub fn look(&self, origin: Vec3, direction: Vec3, plane: u32) -> Sight {
        let hit = closest(self.geometry, &Ray { origin, direction, t_max: f32::MAX, skip: [plane, NONE] });
        if hit.tri == NONE {
            return Sight::Void;
        }
        let facing = Vec3::from(self.geometry.tris[hit.tri as usize].normal).dot(direction) < 0.0;
        // Of a sheet with two faces, both are equally near: the one that faces the ray is met.
        match (facing, self.mirror[hit.tri as usize]) {
            (true, _) => Sight::Front(hit.tri, hit.t),
            (false, NONE) => Sight::Back(hit.tri, hit.t),
            (false, mirror) => Sight::Front(mirror, hit.t),
        }
    }

    /// What is seen from a random place of a triangle, on its front or its back, and where it lies.
    pub fn look_from(&self, tri: u32, front: bool, dice: &mut Dice) -> (Sight, Vec3) {
        let t = &self.geometry.tris[tri as usize];
        let (b1, b2) = place_on(self.geometry.flatland, dice.roll(), dice.roll());
        let n = Vec3::from(t.normal) * if front { 1.0 } else { -1.0 };
        self.look_about(position(self.geometry.flatland, t, b1, b2), n, t.plane, dice)
    }

    /// What is seen from a place in a random, cosine-distributed direction about `n`, and where it lies.
    pub fn look_about(&self, p: Vec3, n: Vec3, plane: u32, dice: &mut Dice) -> (Sight, Vec3) {
        let direction = cosine_direction(self.geometry.flatland, n, dice.roll(), dice.roll());
        let sight = match self.look(p, direction, plane) {
            Sight::Front(_, t) | Sight::Back(_, t) if t < NEAR => self.look(p + direction * (2.0 * NEAR), direction, plane),
            sight => sight,
        };
        match sight {
            Sight::Void => (sight, p),
            Sight::Front(_, t) | Sight::Back(_, t) => (sight, p + direction * t),
        }
    }
}
