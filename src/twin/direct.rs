//! Pass `direct`: irradiance straight from emitters, by multiple importance sampling (design §1, step 7).
//!
//! `emitter` samples of the emitters' area and `cosine` directions a round, weighted by the balance
//! heuristic: a sample at x with area density p and kernel G counts E G / (n_e p + n_c G), which never
//! exceeds E / n_c, also where emitters touch receivers. Where every emitter is far, G / p is small, cosine directions would
//! hardly ever meet one, and none are shot: n_c is 0, and a sample counts at most [`FAR`] E / n_e. In scenes with mirrors they
//! always are, as light over mirrors comes from them alone.

use super::lights::{self, surfaceless};
use super::math::{cosine_direction, geometric, invert_cdf, kernel_g, seed_of, unit};
use super::sky;
use super::sobol::sobol4;
use super::texture;
use super::trace::{Hit, place_on, position, segment_blocked};
use super::way::{Way, between, follow};
use crate::layout::{DirectSum, NONE, Point, kind};
use crate::scene::Geometry;
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Samples of one round.
#[derive(Clone, Copy, Debug)]
pub struct Samples {
    /// On the emitters' area.
    pub emitter: u32,
    /// Cosine-distributed directions.
    pub cosine: u32,
}

/// Rays of direct light by what they are for; those that carry no light count, too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DirectRays {
    /// Samples of the emitters' area.
    pub samples: u64,
    /// Lines of sight to them that are walked.
    pub lines: u64,
    /// Cosine directions that are shot because there are mirrors.
    pub directions: u64,
    /// Lines of sight to the sky.
    pub sky: u64,
    /// Lines of sight to lights without a surface.
    pub lights: u64,
}

impl DirectRays {
    /// Adds `times` such rays.
    pub fn add(&mut self, rays: &DirectRays, times: u64) {
        self.samples += times * rays.samples;
        self.lines += times * rays.lines;
        self.directions += times * rays.directions;
        self.sky += times * rays.sky;
        self.lights += times * rays.lights;
    }

    /// Those since `earlier`.
    pub fn since(&self, earlier: &DirectRays) -> DirectRays {
        DirectRays {
            samples: self.samples - earlier.samples,
            lines: self.lines - earlier.lines,
            directions: self.directions - earlier.directions,
            sky: self.sky - earlier.sky,
            lights: self.lights - earlier.lights,
        }
    }

    /// Lines of sight that are walked.
    pub fn shadow(&self) -> u64 {
        self.lines + self.sky + self.lights
    }
}

/// What shines in a scene, as far as it tells how many rays a round takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources {
    emitters: bool,
    occludes: bool,
    mirrors: bool,
    /// Suns that are a direction, and that have a disc.
    suns: [u32; 2],
    /// Points and spots.
    local: u32,
    /// Whether the sky is a map, where there is one.
    sky: Option<bool>,
}

impl Sources {
    /// Those of a scene.
    pub fn of(geometry: &Geometry) -> Sources {
        let Geometry { lights, sky, .. } = geometry;
        let discs = lights.all[..lights.suns as usize].iter().filter(|l| l.slope > 0.0).count() as u32;
        Sources {
            emitters: !geometry.emitters.is_empty(),
            occludes: geometry.occludes,
            mirrors: geometry.mirrors,
            suns: [lights.suns - discs, discs],
            local: lights.all.len() as u32 - lights.suns,
            sky: sky.mapped(),
        }
    }

    /// Lights without a surface.
    pub fn lights(&self) -> u32 {
        self.suns[0] + self.suns[1] + self.local
    }

    /// Rays of a round at a point.
    pub fn rays(&self, samples: Samples) -> DirectRays {
        let of = |is: bool, rays: u32| if is { u64::from(rays) } else { 0 };
        let lights = self.suns[0] + self.suns[1] * lights::sun_rays(samples) + self.local.min(lights::FEW);
        DirectRays {
            samples: of(self.emitters, samples.emitter),
            lines: of(self.emitters && self.occludes, samples.emitter),
            directions: of(self.emitters && self.mirrors, samples.cosine),
            sky: self.sky.map_or(0, |mapped| sky::samples_of(mapped, samples).iter().map(|&n| u64::from(n)).sum()),
            lights: lights.into(),
        }
    }
}

/// What one sample (u, v) of the emitters' area brings to a surface point, beside cosine directions: E G / (n_e p + n_c G).
pub fn from_emitter(geometry: &Geometry, tri: u32, p: Vec3, u: u32, v: u32, samples: Samples) -> Vec3 {
    match unshadowed(geometry, tri, p, u, v, samples) {
        Some(lit) if !lit.blocked(geometry, tri, p) => lit.light,
        _ => Vec3::ZERO,
    }
}

/// What several samples of the emitters' area bring together, for one shadow ray: `samples.emitter` of them, spread evenly
/// from (u, v) on, of which `pick` chooses one by what each would bring if nothing stood between, and whether it is seen
/// decides for all (resampling; Talbot et al. 2005). The mean is that of as many calls of [`from_emitter`].
pub(crate) fn from_emitters(geometry: &Geometry, tri: u32, p: Vec3, [u, v]: [u32; 2], pick: f32, samples: Samples) -> Vec3 {
    let step = (u32::MAX / samples.emitter.max(1)).wrapping_add(1);
    let (mut sum, mut chosen) = (0.0, None);
    let mut left = pick;
    for k in 0..samples.emitter {
        let (u, v) = (u.wrapping_add(k.wrapping_mul(step)), v.wrapping_add(k.wrapping_mul(GOLDEN)));
        let Some(lit) = unshadowed(geometry, tri, p, u, v, samples) else { continue };
        let brings = lit.light.element_sum();
        if brings <= 0.0 {
            continue;
        }
        sum += brings;
        // One random number serves all choices: what is left of it is uniform again.
        let share = brings / sum;
        if left < share {
            left /= share;
            chosen = Some((lit, brings));
        } else {
            left = (left - share) / (1.0 - share);
        }
    }
    match chosen {
        Some((lit, brings)) if !lit.blocked(geometry, tri, p) => lit.light * (sum / brings),
        _ => Vec3::ZERO,
    }
}

/// 2^32 over the golden ratio: multiples of it are spread evenly.
const GOLDEN: u32 = 0x9e37_79b9;

/// A sample of the emitters' area that may light a point.
struct Lit {
    /// What it brings if nothing stands between.
    light: Vec3,
    x: Vec3,
    plane: u32,
}

impl Lit {
    fn blocked(&self, geometry: &Geometry, tri: u32, p: Vec3) -> bool {
        segment_blocked(geometry, p, self.x, [geometry.tris[tri as usize].plane, self.plane])
    }
}

/// The sample (u, v) of the emitters' area, if it and the point face each other.
fn unshadowed(geometry: &Geometry, tri: u32, p: Vec3, u: u32, v: u32, samples: Samples) -> Option<Lit> {
    let here = &geometry.tris[tri as usize];
    let (e, place) = invert_cdf(geometry.emitters.len() as u32, |e| geometry.emitters[e as usize].cdf, u);
    let emitter = geometry.emitters[e as usize];
    let there = &geometry.tris[emitter.tri as usize];
    let (b1, b2) = place_on(geometry.flatland, place, unit(v));
    let x = position(geometry.flatland, there, b1, b2);
    let g = kernel_g(geometry.flatland, x, Vec3::from(there.normal), p, Vec3::from(here.normal));
    if g > 0.0 && there.plane != here.plane && texture::is_there(geometry, emitter.tri, b1, b2) {
        let (ne, nc) = (samples.emitter as f32, samples.cosine as f32);
        let light = texture::emit(geometry, emitter.tri, b1, b2) * (g / (ne * emitter.density + nc * g));
        return Some(Lit { light: light * between(geometry, p, x), x, plane: there.plane });
    }
    None
}

/// What a cosine direction from a point of normal `n` brings straight from the front face that it meets, beside samples
/// of the emitters' area: E G / (n_e p + n_c G).
pub fn from_direction(geometry: &Geometry, n: Vec3, direction: Vec3, hit: &Hit, samples: Samples) -> Vec3 {
    let there = &geometry.tris[hit.tri as usize];
    let emit = texture::emit(geometry, hit.tri, hit.b1, hit.b2);
    let total = emit.x + emit.y + emit.z;
    if total > 0.0 {
        let cos_y = n.dot(direction);
        let cos_x = -Vec3::from(there.normal).dot(direction);
        let g = geometric(geometry.flatland, cos_x, cos_y, hit.t);
        let (ne, nc) = (samples.emitter as f32, samples.cosine as f32);
        if let Some(density) = texture::density(geometry, hit.tri) {
            return emit * (g / (ne * density + nc * g));
        }
        return emit * (g / (ne * total * geometry.emitter_density + nc * g));
    }
    Vec3::ZERO
}

/// As [`from_direction`], of a way along mirrors or through the medium. No sample of the emitters' area goes over a mirror:
/// such light comes from cosine directions alone, E T / n_c.
pub fn from_way(geometry: &Geometry, n: Vec3, way: &Way, samples: Samples) -> Vec3 {
    if way.mirrors > 0 {
        let emit = texture::emit(geometry, way.hit.tri, way.hit.b1, way.hit.b2);
        return emit * (way.share / samples.cosine as f32);
    }
    let light = from_direction(geometry, n, way.direction, &way.hit, samples);
    if geometry.sigma > 0.0 { light * way.share } else { light }
}

/// G / p below which cosine directions are left out.
pub const FAR: f64 = 0.5;
/// Emitters up to which each is asked whether it is near; where there are more, one always may be.
const FEW: usize = 64;

/// The square of the distance from a corner of an emitter, whose other corners are at most `longest` away, beyond which
/// G / p is below [`FAR`] for all of its points; `density` is p.
pub fn near2(flatland: bool, longest: f64, density: f64) -> f32 {
    // G is at most 1/(pi r^2), in flatland 1/(2 r).
    let far = if flatland { 0.5 / (FAR * density) } else { (1.0 / (PI * FAR * density)).sqrt() };
    (far + longest).powi(2) as f32
}

/// Whether cosine directions have a share in what is found at p.
fn is_near(geometry: &Geometry, p: Vec3) -> bool {
    geometry.mirrors
        || geometry.emitters.len() > FEW
        || geometry.emitters.iter().any(|e| {
            let d = p - Vec3::from(geometry.tris[e.tri as usize].v0);
            d.dot(d) < e.near2
        })
}

/// One round's estimate of D at a surface point.
pub fn round(geometry: &Geometry, tri: u32, p: Vec3, seed: u32, round: u32, samples: Samples) -> Vec3 {
    let n = Vec3::from(geometry.tris[tri as usize].normal);
    let mut sum = surfaceless(geometry, tri, p, seed, round, samples);
    if geometry.emitters.is_empty() {
        return sum;
    }
    let samples = Samples { cosine: if is_near(geometry, p) { samples.cosine } else { 0 }, ..samples };
    for k in round * samples.emitter..(round + 1) * samples.emitter {
        let u = sobol4(k, seed);
        sum += from_emitter(geometry, tri, p, u[0], u[1], samples);
    }
    for k in round * samples.cosine..(round + 1) * samples.cosine {
        // Sample the cosine; only front faces of emitters count.
        let u = sobol4(k, seed);
        let direction = cosine_direction(geometry.flatland, n, unit(u[2]), unit(u[3]));
        let way = follow(geometry, tri, p, direction);
        if way.kind == kind::FRONT {
            sum += from_way(geometry, n, &way, samples);
        }
    }
    sum
}

/// Adds rounds `first..first + rounds` to the sums of the points listed in `active`.
/// Points without a triangle are left alone. Each point has its own sequence, seeded by its index.
pub fn direct(
    geometry: &Geometry,
    points: &[Point],
    active: &[u32],
    seed: u32,
    first: u32,
    rounds: u32,
    samples: Samples,
    sums: &mut [DirectSum],
) {
    if !geometry.shines() {
        for &i in active {
            sums[i as usize].rounds += rounds;
        }
        return;
    }
    let updated: Vec<DirectSum> = active
        .par_iter()
        .map(|&i| {
            let point = &points[i as usize];
            let mut s = sums[i as usize];
            if point.tri == NONE {
                return s;
            }
            for r in first..first + rounds {
                let d = round(geometry, point.tri, Vec3::from(point.p), seed_of(seed, i), r, samples);
                let mean = (d.x + d.y + d.z) * (1.0 / 3.0);
                s.sum = (Vec3::from(s.sum) + d).to_array();
                s.square += mean * mean;
                s.rounds += 1;
            }
            s
        })
        .collect();
    for (&i, s) in active.iter().zip(updated) {
        sums[i as usize] = s;
    }
}

impl DirectSum {
    /// A single round that found `sum`; its square is forgotten.
    pub fn once(sum: [f32; 3]) -> DirectSum {
        DirectSum { sum, rounds: 1, ..DirectSum::default() }
    }

    /// The estimate of D so far.
    pub fn mean(&self) -> [f32; 3] {
        self.sum.map(|s| s / self.rounds.max(1) as f32)
    }

    /// Standard error of the band mean, from the scatter between rounds; infinite below two rounds.
    pub fn standard_error(&self) -> f32 {
        if self.rounds < 2 {
            return f32::INFINITY;
        }
        let m = self.rounds as f32;
        let mean = (self.sum[0] + self.sum[1] + self.sum[2]) / (3.0 * m);
        ((self.square / m - mean * mean).max(0.0) / (m - 1.0)).sqrt()
    }
}
