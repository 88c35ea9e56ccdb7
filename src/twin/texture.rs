//! What varies over a triangle: reflectance, emission, and what is cut out (`wgsl/lib/texture.wgsl`).
//!
//! A scene with maps has one array of texels of four words ([`crate::scene::Geometry::texels`]; `src/scene/atlas.rs` packs it).
//! Each triangle has six first, two a map: the image coordinates of its corners, where the image begins, and its size. An
//! image is of one resolution, that of a ray's footprint on the triangle, its values are those of the surface (four
//! floats a texel: nothing is lost), and what lies between texels is interpolated. A cut-out is a bit a texel.

use crate::layout::{NONE, Tri};
use crate::scene::Geometry;
use glam::Vec3;

/// Texels of a triangle's maps.
pub const RECORD: usize = 6;
/// The maps of a triangle, by their place in its record.
pub const RHO: usize = 0;
/// Emission.
pub const EMIT: usize = 1;
/// What is cut out.
pub const MASK: usize = 2;
/// Bits of a side in an image's size; the bit above says that it is clamped to its edge.
pub const SIDE: u32 = 0x7fff;
/// The bit that says so.
pub const CLAMP: u32 = 0x8000;

/// A map at a place of a triangle.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// First texel of the image.
    at: u32,
    /// Width, and height from bit 16 on.
    size: u32,
    u: f32,
    v: f32,
}

/// A map of a triangle at barycentric coordinates; none where it has none.
fn place(geometry: &Geometry, tri: u32, map: usize, b1: f32, b2: f32) -> Option<Place> {
    let first = RECORD * tri as usize + 2 * map;
    let [u0, v0, u1, v1] = geometry.texels[first].map(f32::from_bits);
    let [u2, v2, at, size] = geometry.texels[first + 1];
    if at == NONE {
        return None;
    }
    let (u2, v2) = (f32::from_bits(u2), f32::from_bits(v2));
    Some(Place { at, size, u: u0 + (u1 - u0) * b1 + (u2 - u0) * b2, v: v0 + (v1 - v0) * b1 + (v2 - v0) * b2 })
}

/// The two texels beside a coordinate, and the share of the second.
fn beside(u: f32, side: u32) -> (u32, u32, f32) {
    let n = (side & SIDE) as i32;
    let mut x = u * n as f32 - 0.5;
    if side & CLAMP != 0 {
        x = x.max(-0.5).min(n as f32 - 0.5);
        let low = x.floor();
        let i = low as i32;
        return (i.max(0) as u32, (i + 1).min(n - 1) as u32, x - low);
    }
    let low = x.floor();
    let i = (low as i32 % n + n) % n;
    (i as u32, if i + 1 == n { 0 } else { i as u32 + 1 }, x - low)
}

/// The texel that holds a coordinate.
fn nearest(u: f32, side: u32) -> u32 {
    let n = (side & SIDE) as i32;
    let x = u * n as f32;
    if side & CLAMP != 0 {
        return x.max(0.0).min(n as f32 - 1.0) as u32;
    }
    ((x.floor() as i32 % n + n) % n) as u32
}

/// An image between its texels.
fn bilinear(geometry: &Geometry, p: Place) -> Vec3 {
    let (x0, x1, a) = beside(p.u, p.size);
    let (y0, y1, b) = beside(p.v, p.size >> 16);
    let (top, bottom) = (p.at + y0 * (p.size & SIDE), p.at + y1 * (p.size & SIDE));
    let texel = |t: u32| {
        let [x, y, z, _] = geometry.texels[t as usize].map(f32::from_bits);
        Vec3::new(x, y, z)
    };
    let upper = texel(top + x0) * (1.0 - a) + texel(top + x1) * a;
    let lower = texel(bottom + x0) * (1.0 - a) + texel(bottom + x1) * a;
    upper * (1.0 - b) + lower * b
}

/// Whether a triangle has a map of a sort.
pub fn has(geometry: &Geometry, tri: u32, map: usize) -> bool {
    !geometry.texels.is_empty() && geometry.texels[RECORD * tri as usize + 2 * map + 1][2] != NONE
}

/// Reflectance of a triangle at barycentric coordinates.
pub fn rho(geometry: &Geometry, tri: u32, b1: f32, b2: f32) -> Vec3 {
    let plain = Vec3::from(geometry.materials[geometry.tris[tri as usize].material as usize].rho);
    if !geometry.textured {
        return plain;
    }
    place(geometry, tri, RHO, b1, b2).map_or(plain, |p| bilinear(geometry, p))
}

/// Emitted radiosity of a triangle at barycentric coordinates, scaled.
pub fn emit(geometry: &Geometry, tri: u32, b1: f32, b2: f32) -> Vec3 {
    let plain = Vec3::from(geometry.materials[geometry.tris[tri as usize].material as usize].emit);
    if !geometry.textured {
        return plain;
    }
    place(geometry, tri, EMIT, b1, b2).map_or(plain, |p| bilinear(geometry, p))
}

/// Whether a triangle is there at barycentric coordinates: not cut out.
pub fn is_there(geometry: &Geometry, tri: u32, b1: f32, b2: f32) -> bool {
    if !geometry.cut {
        return true;
    }
    let Some(p) = place(geometry, tri, MASK, b1, b2) else { return true };
    let bit = nearest(p.v, p.size >> 16) * (p.size & SIDE) + nearest(p.u, p.size);
    geometry.texels[(p.at + bit / 128) as usize][(bit / 32 % 4) as usize] >> (bit % 32) & 1 == 1
}

/// Barycentric coordinates of a position on a triangle, as the kernels find them: shares of its area.
pub fn shares(flatland: bool, tri: &Tri, p: Vec3) -> (f32, f32) {
    let v0 = Vec3::from(tri.v0);
    let (e1, e2, d) = (Vec3::from(tri.v1) - v0, Vec3::from(tri.v2) - v0, p - v0);
    if flatland {
        return ((d.dot(e1) / e1.dot(e1)).clamp(0.0, 1.0), 0.0);
    }
    let n = Vec3::from(tri.normal);
    let all = e1.cross(e2).dot(n).max(1e-30);
    let b1 = (d.cross(e2).dot(n) / all).clamp(0.0, 1.0);
    let b2 = (e1.cross(d).dot(n) / all).clamp(0.0, 1.0 - b1);
    (b1, b2)
}

/// Sampling density of an emitter that does not shine evenly: one with a map, or cut out. It is that of its mean.
pub fn density(geometry: &Geometry, tri: u32) -> Option<f32> {
    if !has(geometry, tri, EMIT) && !has(geometry, tri, MASK) {
        return None;
    }
    let found = geometry.emitters.binary_search_by_key(&tri, |e| e.tri);
    Some(found.map_or(0.0, |e| geometry.emitters[e].density))
}

/// Samples along an edge of a triangle, at most, that its mean emission is found by.
const MOST: usize = 256;

/// Mean emission of a triangle over all of its area, the part that is cut out dark; in f64, from at least two samples a
/// texel along both edges where the image does not repeat too often.
pub(crate) fn mean_emission(geometry: &Geometry, tri: u32) -> [f64; 3] {
    let m = &geometry.materials[geometry.tris[tri as usize].material as usize];
    let maps: Vec<usize> = [EMIT, MASK].into_iter().filter(|&map| has(geometry, tri, map)).collect();
    if maps.is_empty() || m.emit == [0.0; 3] {
        return m.emit.map(f64::from);
    }
    // Texels along the longest edge.
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
    let mut texels = 0.0f32;
    for &map in &maps {
        let at = corners.map(|(b1, b2)| place(geometry, tri, map, b1, b2));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if let (Some(a), Some(b)) = (at[a], at[b]) {
                let (w, h) = ((a.size & SIDE) as f32, (a.size >> 16 & SIDE) as f32);
                texels = texels.max(((a.u - b.u) * w).abs()).max(((a.v - b.v) * h).abs());
            }
        }
    }
    let n = ((2.0 * texels).ceil() as usize).clamp(4, MOST);
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for i in 0..n {
        for j in 0..if geometry.flatland { 1 } else { n - i } {
            // The middle of the upright part, and of the one upside down beside it.
            for third in [1.0 / 3.0, 2.0 / 3.0] {
                let (b1, b2) = match geometry.flatland {
                    true => ((i as f32 + 1.5 * third - 0.25) / n as f32, 0.0),
                    false => ((i as f32 + third) / n as f32, (j as f32 + third) / n as f32),
                };
                if b1 + b2 >= 1.0 {
                    continue;
                }
                count += 1.0;
                if is_there(geometry, tri, b1, b2) {
                    let e = emit(geometry, tri, b1, b2);
                    sum = [0, 1, 2].map(|k| sum[k] + f64::from(e[k]));
                }
            }
        }
    }
    // What so many samples did not see shines a little all the same: rays may meet it.
    let missed = if sum == [0.0; 3] && n == MOST { 1e-3 } else { 0.0 };
    [0, 1, 2].map(|k| sum[k] / count + missed * f64::from(m.emit[k]))
}
