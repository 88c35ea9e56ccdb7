//! Lights without a surface in pass `direct` (`wgsl/lib/lights.wgsl`): suns, points and spots, one shadow ray a sample.
//!
//! A sun of irradiance E is drawn from its disc as seen along its axis, so that a place that sees all of it gets
//! E cos without noise where it faces it: its radiance is E/(pi sin^2 a), the density cos/(pi sin^2 a) about the axis. Points and spots
//! bring I cos/r^2, spots times their falloff. Where they are more than [`FEW`], a round asks as many by what each would bring.
//! Mirrors do not send it on; a medium takes of it on its way through the scene's bounding box.

use super::direct::Samples;
use super::math::{cos_sin_turn, seed_of, tangents, unit};
use super::sky::from_sky;
use super::sobol::sobol4;
use super::trace::ray_blocked;
use super::way::from_without;
use crate::layout::Lamp;
use crate::scene::Geometry;
use glam::Vec3;

/// Points and spots that a round asks; where there are no more, all.
pub const FEW: u32 = 8;
/// What tells their sequences from those of emitters and sky.
const STREAM: u32 = 0x50f7_11fe;

/// One round's estimate of the irradiance from lights and sky at a surface point: what no surface sends.
pub fn surfaceless(geometry: &Geometry, tri: u32, p: Vec3, seed: u32, round: u32, samples: Samples) -> Vec3 {
    let mut sum = Vec3::ZERO;
    if !geometry.sky.is_empty() {
        sum += from_sky(geometry, tri, p, seed, round, samples);
    }
    if !geometry.lights.is_empty() {
        sum += from_lights(geometry, tri, p, seed, round, samples);
    }
    sum
}

/// Shadow rays of a sun that has a disc in a round; of one that is a direction it is one.
pub fn sun_rays(samples: Samples) -> u32 {
    (samples.emitter / 4).max(1)
}

/// A direction towards a sun, and what comes from there to a surface of normal `n`.
fn from_sun(light: &Lamp, n: Vec3, u: f32, v: f32) -> (Vec3, Vec3) {
    let axis = Vec3::from(light.p);
    let (t1, t2) = tangents(axis);
    let (c, s) = cos_sin_turn(v);
    let r = light.slope * u.sqrt();
    let up = (1.0 - r * r).max(0.0).sqrt();
    let direction = t1 * (r * c) + t2 * (r * s) + axis * up;
    (direction, Vec3::from(light.value) * (n.dot(direction).max(0.0) / up))
}

/// The way to a point or spot light, and what comes from there to a surface of normal `n`.
fn from_point(light: &Lamp, p: Vec3, n: Vec3) -> (Vec3, Vec3) {
    let way = Vec3::from(light.p) - p;
    let r2 = way.dot(way);
    if r2 <= 0.0 || r2.is_nan() {
        return (way, Vec3::ZERO);
    }
    let r = r2.sqrt();
    let cos = (n.dot(way) / r).max(0.0);
    let fall = ((-Vec3::from(light.d).dot(way) / r) * light.slope + light.offset).clamp(0.0, 1.0);
    (way, Vec3::from(light.value) * (fall * fall * ((cos / r) / r)))
}

/// Radiance from a direction (unit) in which nothing stands, scaled W/m²/sr: the sky's, and that of suns that have a size.
pub(crate) fn radiance(geometry: &Geometry, direction: Vec3) -> [f64; 3] {
    let mut sum = [0.0; 3];
    if !geometry.sky.is_empty() {
        sum = geometry.sky.look(direction).radiosity.to_array().map(|e| f64::from(e) / std::f64::consts::PI);
    }
    for sun in &geometry.lights.all[..geometry.lights.suns as usize] {
        let axis = Vec3::from(sun.p).as_dvec3();
        let (sine, off) = (f64::from(sun.slope), axis.cross(direction.as_dvec3()).length());
        if axis.dot(direction.as_dvec3()) > 0.0 && off < sine {
            for k in 0..3 {
                sum[k] += f64::from(sun.value[k]) / (std::f64::consts::PI * sine * sine);
            }
        }
    }
    sum
}

/// One round's estimate of the lights' irradiance at a surface point.
pub fn from_lights(geometry: &Geometry, tri: u32, p: Vec3, seed: u32, round: u32, samples: Samples) -> Vec3 {
    let here = &geometry.tris[tri as usize];
    let (n, seed) = (Vec3::from(here.normal), seed_of(seed, STREAM));
    let lights = &geometry.lights;
    let mut sum = Vec3::ZERO;
    for i in 0..lights.suns {
        let sun = &lights.all[i as usize];
        let rays = if sun.slope > 0.0 { sun_rays(samples) } else { 1 };
        for k in round * rays..(round + 1) * rays {
            let u = sobol4(k, seed_of(seed, i));
            let (direction, light) = from_sun(sun, n, unit(u[0]), unit(u[1]));
            if light != Vec3::ZERO && !ray_blocked(geometry, here, p, direction, f32::MAX) {
                sum += light * (from_without(geometry, p, direction, f32::MAX) / rays as f32);
            }
        }
    }
    let local = &lights.all[lights.suns as usize..];
    // All of them, or as many as FEW, drawn at even steps along the sum of what they bring.
    let all = local.len() as u32 <= FEW;
    let mut step = 0.0;
    if !all {
        local.iter().for_each(|light| step += from_point(light, p, n).1.element_sum());
        step *= 1.0 / FEW as f32;
    }
    let mut next = step * unit(sobol4(round, seed)[2]);
    let mut passed = 0.0;
    for light in local {
        let (way, light) = from_point(light, p, n);
        let brings = light.element_sum();
        if brings <= 0.0 {
            continue;
        }
        let mut share = 1.0;
        if !all {
            passed += brings;
            let times = ((passed - next) / step).ceil().max(0.0);
            next += times * step;
            share = times * step / brings;
        }
        if share > 0.0 && !ray_blocked(geometry, here, p, way, 1.0) {
            let r = way.dot(way).sqrt();
            sum += light * (share * from_without(geometry, p, way * (1.0 / r), r));
        }
    }
    sum
}
