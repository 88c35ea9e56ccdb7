//! Small maths that twins and kernels share operation by operation (`wgsl/lib/math.wgsl`). All f32.

use glam::Vec3;

/// pi
pub const PI: f32 = std::f32::consts::PI;

/// A 32-bit hash with good avalanche (lowbias32, Chris Wellons): turns counters into seeds.
pub fn hash(x: u32) -> u32 {
    let mut x = x;
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846ca68b);
    x ^ (x >> 16)
}

/// The seed of item `i` of stream `seed`.
pub fn seed_of(seed: u32, i: u32) -> u32 {
    hash(seed ^ hash(i.wrapping_add(0x9e3779b9)))
}

/// A u32 as a number in [0, 1): the upper 24 bits, so that it never rounds up to 1 (hard case B12).
pub fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16777216.0)
}

/// Two tangents of a unit normal (Duff et al., JCGT 6(1), 2017).
pub fn tangents(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// (cos, sin) of a turn `u` in [0, 1), by polynomials: the same bits on every driver, where the
/// built-ins differ (WGSL allows 2^-11).
pub fn cos_sin_turn(u: f32) -> (f32, f32) {
    let quarter = (4.0 * u + 0.5).floor();
    let x = (u - 0.25 * quarter) * (2.0 * PI);
    let x2 = x * x;
    let s = x * (1.0 + x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0)))));
    let c = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    match quarter as u32 & 3 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}

/// A cosine-distributed direction about `n` (Malley's method): density cos/pi. In flatland within the plane, its
/// sine uniform: density cos/2.
pub fn cosine_direction(flatland: bool, n: Vec3, u: f32, v: f32) -> Vec3 {
    if flatland {
        return Vec3::new(n.y, -n.x, 0.0) * (2.0 * u - 1.0) + n * (2.0 * (u * (1.0 - u)).sqrt());
    }
    let (t1, t2) = tangents(n);
    let (c, s) = cos_sin_turn(v);
    let r = u.sqrt();
    let z = (1.0 - u).max(0.0).sqrt();
    t1 * (r * c) + t2 * (r * s) + n * z
}

/// G of two cosines at distance r: cos cos / (pi r^2), in flatland cos cos / (2 r). Divided step by step, so that
/// nothing under- or overflows (hard case A17).
pub fn geometric(flatland: bool, cos_x: f32, cos_y: f32, r: f32) -> f32 {
    if flatland { (cos_x / r) * cos_y * 0.5 } else { (cos_x / r) * (cos_y / r) / PI }
}

/// The kernel's geometry part G(x, y), [`geometric`] of both ends' cosines. Each is clamped by itself (A11).
pub fn kernel_g(flatland: bool, x: Vec3, nx: Vec3, y: Vec3, ny: Vec3) -> f32 {
    let d = y - x;
    let r2 = d.dot(d);
    if r2 <= 0.0 || r2.is_nan() {
        return 0.0;
    }
    let r = r2.sqrt();
    let cos_x = (nx.dot(d) / r).max(0.0);
    let cos_y = (-ny.dot(d) / r).max(0.0);
    geometric(flatland, cos_x, cos_y, r)
}

/// First index whose cumulative value exceeds `u`, clamped to the last: inversion of a fixed-point
/// distribution. `cdf(i)` must not decrease. Returns the index and the place within its interval, in [0, 1).
pub fn invert_cdf(len: u32, cdf: impl Fn(u32) -> u32, u: u32) -> (u32, f32) {
    // Empty intervals at the end share the last value: stay below it.
    let u = u.min(u32::MAX - 1);
    let (mut low, mut high) = (0u32, len - 1);
    while low < high {
        let middle = (low + high) / 2;
        if cdf(middle) > u {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    let start = if low == 0 { 0 } else { cdf(low - 1) };
    let width = (cdf(low) - start).max(1);
    let place = ((u - start) as f32 + 0.5) / width as f32;
    (low, place.min(1.0 - 1.0 / 16777216.0))
}
