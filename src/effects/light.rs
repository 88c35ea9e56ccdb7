//! A first look at a scene's light: paths of the plain-Rust twins.

use crate::layout::kind;
use crate::network::tiles;
use crate::scene::Geometry;
use crate::twin::direct::{Samples, from_emitter, from_way, round};
use crate::twin::lights::{from_lights, surfaceless};
use crate::twin::math::{cosine_direction, invert_cdf, kernel_g, seed_of, unit};
use crate::twin::sky::from_sky;
use crate::twin::sobol::sobol4;
use crate::twin::texture;
use crate::twin::trace::{place_on, position, segment_blocked};
use crate::twin::way::follow;
use glam::Vec3;
use rayon::prelude::*;

/// Paths, each from a point of its own.
const PATHS: u32 = 2_048;
/// Most reflections of a path.
const BOUNCES: usize = 64;
/// Samples of direct light at a path's ends.
const END: Samples = Samples { emitter: 2, cosine: 1 };
/// Light that may be left when reflections are counted no further.
const LEFT: f64 = 1e-3;
/// Their seed: the look is not part of a bake.
const SEED: u32 = 0x100c;

/// What was seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Look {
    /// Share of the lines of sight to emitters that is blocked, of those that would carry light.
    pub blocked: f64,
    /// Number of those lines.
    pub lines: u32,
    /// Share of the arriving light that has been reflected before.
    pub reflected: f64,
    /// Share of the light that arrives straight which comes from the sky, and from lights without a surface.
    pub sky: f64,
    /// See `sky`.
    pub lights: f64,
    /// Share of the rays from surfaces that meet a mirror.
    pub over_mirrors: f64,
    /// Share of their light that the medium takes on the way.
    pub in_medium: f64,
    /// Reflections after which less than a thousandth of the arriving light is still to come.
    pub bounces: usize,
}

/// What one path finds.
struct Path {
    /// Whether a line to an emitter would carry light, and whether it is blocked.
    line: Option<bool>,
    /// What of the light that arrives straight comes from the sky and from lights without a surface.
    surfaceless: [f32; 2],
    /// Whether its first ray meets a mirror, and what the medium takes on that ray's way.
    way: (bool, f32),
    /// Light that arrives after so many reflections, mean over the bands.
    light: [f32; BOUNCES + 1],
}

impl Look {
    /// Looks at a scene.
    pub fn at(geometry: &Geometry) -> Look {
        if !geometry.shines() || geometry.area <= 0.0 {
            return Look::default();
        }
        let starts = tiles::starts(geometry, &vec![0.0; geometry.tiles as usize], 0.0);
        let points = tiles::drawn(geometry, &starts, SEED, PATHS);
        let paths: Vec<Path> =
            points.par_iter().enumerate().map(|(i, p)| path(geometry, p.tri, Vec3::from(p.p), i as u32)).collect();
        let lines = paths.iter().filter_map(|p| p.line);
        let (count, blocked) = lines.fold((0, 0), |(n, b), is| (n + 1, b + u32::from(is)));
        // In a fixed order: the same words every time.
        let sum = |n: usize| paths.iter().map(|p| f64::from(p.light[n])).sum::<f64>();
        let by_bounce: Vec<f64> = (0..=BOUNCES).map(sum).collect();
        let all: f64 = by_bounce.iter().sum();
        let share = |of: &dyn Fn(&Path) -> f64| paths.iter().map(of).sum::<f64>() / paths.len() as f64;
        let seen = Look {
            blocked: f64::from(blocked) / f64::from(count.max(1)),
            lines: count,
            over_mirrors: share(&|p| f64::from(u8::from(p.way.0))),
            in_medium: share(&|p| p.way.1.into()),
            ..Look::default()
        };
        if all <= 0.0 {
            return seen;
        }
        let mut left = all;
        let bounces = by_bounce.iter().position(|light| {
            left -= light;
            left < LEFT * all
        });
        let share =
            |of: usize| paths.iter().map(|p| f64::from(p.surfaceless[of])).sum::<f64>() / by_bounce[0].max(f64::MIN_POSITIVE);
        let reflected = 1.0 - by_bounce[0] / all;
        Look { reflected, bounces: bounces.unwrap_or(BOUNCES), sky: share(0), lights: share(1), ..seen }
    }
}

fn path(geometry: &Geometry, mut tri: u32, mut p: Vec3, i: u32) -> Path {
    let mean = |v: Vec3| (v.x + v.y + v.z) / 3.0;
    let line = line(geometry, tri, p, sobol4(i, seed_of(SEED, 1)));
    let mut light = [0.0; BOUNCES + 1];
    light[0] = mean(round(geometry, tri, p, seed_of(SEED, i), 0, END));
    let mut surfaceless = [0.0; 2];
    if !geometry.sky.is_empty() {
        surfaceless[0] = mean(from_sky(geometry, tri, p, seed_of(SEED, i), 0, END));
    }
    if !geometry.lights.is_empty() {
        surfaceless[1] = mean(from_lights(geometry, tri, p, seed_of(SEED, i), 0, END));
    }
    let mut through = Vec3::ONE;
    let mut first = (false, 0.0);
    for (n, arrived) in light.iter_mut().enumerate().skip(1) {
        let u = sobol4(i, seed_of(SEED, 2 * n as u32));
        let direction =
            cosine_direction(geometry.flatland, Vec3::from(geometry.tris[tri as usize].normal), unit(u[0]), unit(u[1]));
        let way = follow(geometry, tri, p, direction);
        let hit = way.hit;
        if n == 1 {
            first = (way.mirrors > 0, 1.0 - way.share - way.mirrored);
        }
        if way.kind != kind::FRONT {
            break;
        }
        let there = &geometry.tris[hit.tri as usize];
        through *= texture::rho(geometry, hit.tri, hit.b1, hit.b2) * way.share;
        if through == Vec3::ZERO {
            break;
        }
        (tri, p) = (hit.tri, position(geometry.flatland, there, hit.b1, hit.b2));
        let u = sobol4(i, seed_of(SEED, 2 * n as u32 + 1));
        *arrived = mean(through * direct(geometry, tri, p, u));
    }
    Path { line, surfaceless, way: first, light }
}

/// Direct light at a path's later ends: one sample of the emitters, and one direction.
fn direct(geometry: &Geometry, tri: u32, p: Vec3, u: [u32; 4]) -> Vec3 {
    let one = Samples { emitter: 1, cosine: 1 };
    let n = Vec3::from(geometry.tris[tri as usize].normal);
    let direction = cosine_direction(geometry.flatland, n, unit(u[2]), unit(u[3]));
    let mut light = surfaceless(geometry, tri, p, u[3], 0, one);
    if geometry.emitters.is_empty() {
        return light;
    }
    light += from_emitter(geometry, tri, p, u[0], u[1], one);
    let way = follow(geometry, tri, p, direction);
    if way.kind == kind::FRONT {
        light += from_way(geometry, n, &way, one);
    }
    light
}

/// Whether something stands between a point and a place on an emitter that face each other; none where they do not.
fn line(geometry: &Geometry, tri: u32, p: Vec3, u: [u32; 4]) -> Option<bool> {
    if geometry.emitters.is_empty() {
        return None;
    }
    let here = &geometry.tris[tri as usize];
    let (e, place) = invert_cdf(geometry.emitters.len() as u32, |e| geometry.emitters[e as usize].cdf, u[0]);
    let there = &geometry.tris[geometry.emitters[e as usize].tri as usize];
    let (b1, b2) = place_on(geometry.flatland, place, unit(u[1]));
    let x = position(geometry.flatland, there, b1, b2);
    let g = kernel_g(geometry.flatland, x, Vec3::from(there.normal), p, Vec3::from(here.normal));
    (g > 0.0 && there.plane != here.plane).then(|| segment_blocked(geometry, p, x, [here.plane, there.plane]))
}
