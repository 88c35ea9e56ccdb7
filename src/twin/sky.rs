//! The sky's part of pass `direct` (`wgsl/lib/sky.wgsl`): light from where no surface is.
//!
//! Of a constant sky cosine directions find the irradiance E V without noise where nothing stands before it. Of a map half of the
//! samples are drawn from it, by radiance times solid angle, in integers; both are weighted by the balance heuristic (Veach
//! 1997, 9.2): a direction counts E p_c/(n_m p_m + n_c p_c), where E = pi L, p_c = cos/pi, and p_m is the map's density. Over mirrors
//! cosine directions alone find it. A medium takes of it what the way through the scene's bounding box is long.

use super::direct::Samples;
use super::math::{PI, cos_sin_turn, cosine_direction, invert_cdf, seed_of, unit};
use super::sobol::sobol4;
use super::trace::ray_blocked;
use super::way::{Way, follow, from_without};
use crate::layout::kind;
use crate::scene::{Geometry, Sky};
use glam::Vec3;

/// Texels before the rows.
const HEAD: u32 = 2;
/// What tells its sequence from that of the emitters.
const STREAM: u32 = 0x5ca1_ab1e;

/// A direction from a map, or of one.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The direction, of unit length.
    pub direction: Vec3,
    /// E = pi L, scaled W/m².
    pub radiosity: Vec3,
    /// Density with which the map draws it, 1/sr.
    pub density: f32,
}

impl Sky {
    fn word(&self, texel: u32, k: usize) -> u32 {
        self.texels[texel as usize][k]
    }

    fn float(&self, texel: u32, k: usize) -> f32 {
        f32::from_bits(self.word(texel, k))
    }

    fn size(&self) -> (u32, u32) {
        (self.word(0, 0), self.word(0, 1))
    }

    /// A texel of the map, seen in a direction within it.
    fn texel(&self, row: u32, column: u32, direction: Vec3) -> Seen {
        let (width, height) = self.size();
        let first = HEAD + height + row * width;
        let at = first + column;
        let radiosity = Vec3::new(self.float(at, 0), self.float(at, 1), self.float(at, 2));
        let above = if row == 0 { 0 } else { self.word(HEAD + row - 1, 0) };
        let before = if column == 0 { 0 } else { self.word(at - 1, 3) };
        // Shares as the integers have them, over the texel's solid angle.
        let share = (self.word(HEAD + row, 0) - above) as f32 * INTERVAL * ((self.word(at, 3) - before) as f32 * INTERVAL);
        let angle = self.float(HEAD + row, 2) * (2.0 * PI / width as f32);
        Seen { direction, radiosity, density: share / angle }
    }

    /// A direction of the map, drawn by radiance and solid angle.
    pub fn draw(&self, u: u32, v: u32) -> Seen {
        let (width, height) = self.size();
        let (row, down) = invert_cdf(height, |i| self.word(HEAD + i, 0), u);
        let first = HEAD + height + row * width;
        let (column, across) = invert_cdf(width, |i| self.word(first + i, 3), v);
        let turn = (column as f32 + across) / width as f32 - self.float(0, 2);
        let (c, s) = cos_sin_turn(turn - turn.floor());
        let up = self.float(HEAD + row, 1) - self.float(HEAD + row, 2) * down;
        let flat = (1.0 - up * up).max(0.0).sqrt();
        self.texel(row, column, Vec3::new(-s * flat, up, c * flat))
    }

    /// What is seen in a direction of unit length.
    pub fn look(&self, direction: Vec3) -> Seen {
        let (width, height) = self.size();
        if width == 0 {
            let radiosity = Vec3::new(self.float(1, 0), self.float(1, 1), self.float(1, 2));
            return Seen { direction, radiosity, density: 0.0 };
        }
        let turn = turn_of(direction.z, -direction.x) + self.float(0, 2);
        let column = (((turn - turn.floor()) * width as f32) as u32).min(width - 1);
        let flat = (direction.x * direction.x + direction.z * direction.z).sqrt();
        let row = ((2.0 * turn_of(direction.y, flat) * height as f32) as u32).min(height - 1);
        self.texel(row, column, direction)
    }
}

/// 2^-32: a step of a fixed-point distribution.
const INTERVAL: f32 = 1.0 / 4294967296.0;

/// The angle of (c, s), in turns, in [0, 1): a polynomial (Cephes' atanf), for the same bits on every driver.
pub fn turn_of(c: f32, s: f32) -> f32 {
    let (a, b) = (c.abs(), s.abs());
    let most = a.max(b);
    if most == 0.0 {
        return 0.0;
    }
    let ratio = a.min(b) / most;
    let beyond = ratio > 0.414_213_57;
    let x = if beyond { (ratio - 1.0) / (ratio + 1.0) } else { ratio };
    let z = x * x;
    let arc = (((8.053_744_5e-2 * z - 1.387_768_6e-1) * z + 1.997_771_1e-1) * z - 3.333_295e-1) * z * x + x;
    let mut turn = arc * (0.5 / PI) + if beyond { 0.125 } else { 0.0 };
    if b > a {
        turn = 0.25 - turn;
    }
    if c < 0.0 {
        turn = 0.5 - turn;
    }
    if s < 0.0 {
        turn = 1.0 - turn;
    }
    if turn >= 1.0 { 0.0 } else { turn }
}

/// Samples of a round: directions of the map, and cosine directions.
pub fn samples_of(mapped: bool, samples: Samples) -> [u32; 2] {
    if mapped { [samples.emitter, samples.cosine.max(1)] } else { [0, (samples.emitter + samples.cosine).max(1)] }
}

/// What a cosine direction from a point of normal `n` brings where it meets nothing, beside samples of the map.
pub fn from_direction(geometry: &Geometry, n: Vec3, direction: Vec3, [nm, nc]: [u32; 2]) -> Vec3 {
    let seen = geometry.sky.look(direction);
    if nm == 0 {
        return seen.radiosity / nc as f32;
    }
    weighted(&seen, n.dot(direction), [nm, nc])
}

/// What a direction of the map brings to a point of normal `n` where nothing stands before it, beside cosine directions.
fn weighted(seen: &Seen, cos: f32, [nm, nc]: [u32; 2]) -> Vec3 {
    if cos <= 0.0 {
        return Vec3::ZERO;
    }
    let cosine = cos / PI;
    seen.radiosity * (cosine / (nm as f32 * seen.density + nc as f32 * cosine))
}

/// What one direction of the map brings to a point.
pub fn from_map(geometry: &Geometry, tri: u32, p: Vec3, u: u32, v: u32, samples: [u32; 2]) -> Vec3 {
    let here = &geometry.tris[tri as usize];
    let seen = geometry.sky.draw(u, v);
    let light = weighted(&seen, Vec3::from(here.normal).dot(seen.direction), samples);
    if light != Vec3::ZERO && !ray_blocked(geometry, here, p, seen.direction, f32::MAX) {
        return light * from_without(geometry, p, seen.direction, f32::MAX);
    }
    Vec3::ZERO
}

/// What a way to the sky that began in a cosine direction from a point of normal `n` brings, beside samples of the map. No
/// sample of the map goes over a mirror: such light comes from cosine directions alone, E T / n_c.
pub fn from_way(geometry: &Geometry, n: Vec3, way: &Way, [nm, nc]: [u32; 2]) -> Vec3 {
    if way.mirrors > 0 {
        return geometry.sky.look(way.direction).radiosity * (way.share / nc as f32);
    }
    from_direction(geometry, n, way.direction, [nm, nc]) * way.share
}

/// One round's estimate of the sky's irradiance at a surface point.
pub fn from_sky(geometry: &Geometry, tri: u32, p: Vec3, seed: u32, round: u32, samples: Samples) -> Vec3 {
    let [nm, nc] = samples_of(geometry.sky.is_mapped(), samples);
    let here = &geometry.tris[tri as usize];
    let (n, seed) = (Vec3::from(here.normal), seed_of(seed, STREAM));
    let mut sum = Vec3::ZERO;
    for k in round * nm..(round + 1) * nm {
        let u = sobol4(k, seed);
        sum += from_map(geometry, tri, p, u[0], u[1], [nm, nc]);
    }
    for k in round * nc..(round + 1) * nc {
        let u = sobol4(k, seed);
        let direction = cosine_direction(geometry.flatland, n, unit(u[2]), unit(u[3]));
        if geometry.mirrors {
            let way = follow(geometry, tri, p, direction);
            if way.kind == kind::SKY {
                sum += from_way(geometry, n, &way, [nm, nc]);
            }
        } else if !ray_blocked(geometry, here, p, direction, f32::MAX) {
            sum += from_direction(geometry, n, direction, [nm, nc]) * from_without(geometry, p, direction, f32::MAX);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_of_a_direction_is_known_to_rounding() {
        for i in 0..100_000u32 {
            let turn = i as f64 / 100_000.0;
            let (s, c) = (turn * std::f64::consts::TAU).sin_cos();
            let got = f64::from(turn_of(7.0 * c as f32, 7.0 * s as f32));
            let off = (got - turn).abs();
            assert!(off.min(1.0 - off) < 2e-7, "{turn} {got}");
        }
        assert_eq!(turn_of(0.0, 0.0), 0.0);
        assert!(turn_of(1.0, -1e-30) < 1.0);
    }
}
