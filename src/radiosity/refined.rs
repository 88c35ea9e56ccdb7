//! The solve at high reflectance: GMRES, swept by the engine in f32, around residuals in f64 on the host.
//!
//! Plain sweeps take ln(1e-5)/ln(rho) = 115,000 of them at a reflectance of .9999, and end where f32 can tell no step from
//! rounding, 5e-4 from the fixed point (hard case E01). Here the engine's sweeps only say where to go; how far it still
//! is, the host says in f64, and both take turns (iterative refinement: C. Moler, J. ACM 14(2), 1967).
//! The colour bands are three systems of one shape: they go in step, each with numbers of its own.

use super::solver::{Rule, Solved};
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::layout::{Material, NodeLight};
use crate::progress::{Event, Progress};
use crate::twin::jacobi::System;
use crate::twin::math::{hash, unit};
use glam::DVec3;
use rayon::prelude::*;

/// Sweeps of the power iteration between two looks; few, so that no light leaves the range of f32.
const POWER_STRIDE: u32 = 4;
/// Looks of the power iteration: 20 sweeps in all.
const POWER_LOOKS: u32 = 5;
/// Vectors that GMRES keeps.
const DEPTH: usize = 32;
/// Part of a residual that is left where sweeps in f32 have nothing more to say of it.
const LEAST: f64 = 1e-5;
/// Residuals that must not fall, one after the other, until rounding has the last word.
const STUCK: u32 = 3;

/// A node's light in f64: H and its gradient along both tangents.
pub(crate) type Light = [DVec3; 3];

pub(crate) fn wide(l: &NodeLight) -> Light {
    [l.h, l.g0, l.g1].map(|x| DVec3::from_array(x.map(f64::from)))
}

pub(crate) fn narrow(l: &Light) -> NodeLight {
    let [h, g0, g1] = l.map(|x| x.as_vec3().to_array());
    NodeLight { h, g0, g1, ..NodeLight::default() }
}

/// The system with nothing that shines: a sweep of it is the operator alone.
pub fn unlit(system: &System) -> System {
    System {
        source: vec![[0.0; 4]; system.source.len()],
        node_source: vec![NodeLight::default(); system.node_source.len()],
        ..system.clone()
    }
}

/// How much light is left of a sweep, in the mode that fades last, and the nodes' light in that mode.
#[derive(Clone, Debug)]
pub struct Mode {
    /// The contraction factor: the largest of the bands.
    pub factor: f64,
    /// The mode, at most 1 in each band.
    pub light: Vec<NodeLight>,
}

/// Measures the contraction of the unlit system that is set on the engine, by power iteration.
///
/// Errors: those of the engine.
pub fn measure<E: Engine>(engine: &mut E, nodes: usize, progress: &mut Progress) -> Result<Mode> {
    // All light at once, and something of every other mode.
    let start = |j: usize| NodeLight { h: [0.5 + unit(hash(j as u32 + 1)); 3], ..NodeLight::default() };
    let mut mode = Mode { factor: 0.0, light: (0..nodes).map(start).collect() };
    for _ in 0..POWER_LOOKS {
        let next = engine.jacobi(&mode.light, POWER_STRIDE)?;
        progress.tick()?;
        let size = |light: &[NodeLight]| {
            light.iter().map(|l| DVec3::from_array(l.h.map(f64::from))).fold(DVec3::ZERO, |sum, h| sum + h * h)
        };
        let growth = size(&next) / size(&mode.light);
        let band = |g: f64| if g > 0.0 { g.powf(0.5 / f64::from(POWER_STRIDE)) } else { 0.0 };
        mode.factor = band(growth.x).max(band(growth.y)).max(band(growth.z));
        let most = next.iter().fold(DVec3::ZERO, |most, l| most.max(DVec3::from_array(l.h.map(|h| f64::from(h.abs())))));
        if !mode.factor.is_finite() || !most.is_finite() {
            mode.factor = f64::INFINITY;
            break;
        }
        let scale = most.to_array().map(|m| if m > 0.0 { (1.0 / m) as f32 } else { 0.0 });
        let scaled = |x: [f32; 3]| [0, 1, 2].map(|k| x[k] * scale[k]);
        mode.light = (next.iter())
            .map(|l| NodeLight { h: scaled(l.h), g0: scaled(l.g0), g1: scaled(l.g1), ..NodeLight::default() })
            .collect();
    }
    Ok(mode)
}

/// One sweep in f64.
pub fn sweep(system: &System, materials: &[Material], light: &[Light]) -> Vec<Light> {
    let rho: Vec<DVec3> = (0..system.planes.len()).map(|j| DVec3::from_array(system.rho(materials, j).map(f64::from))).collect();
    let beta: Vec<DVec3> = (0..system.source.len())
        .into_par_iter()
        .map(|c| {
            let [r, g, b, _] = system.source[c].map(f64::from);
            let row = &system.cell_links[system.cell_offsets[c] as usize..system.cell_offsets[c + 1] as usize];
            row.iter().fold(DVec3::new(r, g, b), |sum, l| {
                let [h, g0, g1] = light[l.other as usize];
                sum + rho[l.other as usize] * (h * f64::from(l.value) + g0 * f64::from(l.first) + g1 * f64::from(l.second))
            })
        })
        .collect();
    (0..system.planes.len())
        .into_par_iter()
        .map(|j| {
            let row = &system.node_links[system.node_offsets[j] as usize..system.node_offsets[j + 1] as usize];
            let [h, m1, m2] = row.iter().fold(wide(&system.node_source[j]), |[h, m1, m2], l| {
                let b = beta[l.other as usize];
                [h + b * f64::from(l.value), m1 + b * f64::from(l.first), m2 + b * f64::from(l.second)]
            });
            let p = &system.planes[j];
            let [i11, i12, i22] = [p.i11, p.i12, p.i22].map(f64::from);
            [h, m1 * i11 + m2 * i12, m1 * i12 + m2 * i22]
        })
        .collect()
}

/// What makes gradients commensurate with values: the squared extent of each node, 0 where it has no gradient.
fn extents(system: &System) -> Vec<f64> {
    system.planes.iter().map(|p| if p.i11 + p.i22 > 0.0 { 2.0 / f64::from(p.i11 + p.i22) } else { 0.0 }).collect()
}

/// The bands' inner products. In order, so that they are the same every time.
fn dot(extents: &[f64], a: &[Light], b: &[Light]) -> DVec3 {
    (a.iter().zip(b).zip(extents)).fold(DVec3::ZERO, |sum, ((a, b), s)| sum + a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]) * *s)
}

/// `a += b * by`
fn add(a: &mut [Light], b: &[Light], by: DVec3) {
    for (a, b) in a.iter_mut().zip(b) {
        for k in 0..3 {
            a[k] += b[k] * by;
        }
    }
}

fn root(x: DVec3) -> DVec3 {
    DVec3::from_array(x.to_array().map(|x| x.max(0.0).sqrt()))
}

/// 1/x, and 0 for 0: a band without light has nothing to solve.
fn inverse(x: DVec3) -> DVec3 {
    DVec3::from_array(x.to_array().map(|x| if x != 0.0 { 1.0 / x } else { 0.0 }))
}

fn largest(light: &[Light]) -> f64 {
    light.iter().fold(0.0, |most, l| most.max(l[0].abs().max_element()))
}

/// What one round of GMRES adds to a light whose residual is `residual`, and the sweeps it took. The unlit system is set on
/// the engine.
fn correction<E: Engine>(
    engine: &mut E,
    extents: &[f64],
    residual: &[Light],
    most: u32,
    progress: &mut Progress,
) -> Result<(Vec<Light>, u32)> {
    let size = root(dot(extents, residual, residual));
    let scaled = |v: &[Light], by: DVec3| -> Vec<Light> { v.iter().map(|l| l.map(|x| x * by)).collect() };
    let mut basis = vec![scaled(residual, inverse(size))];
    // The Hessenberg matrix turned into a triangle by rotations, a column each; and the right side.
    let mut columns: Vec<Vec<DVec3>> = Vec::new();
    let mut turns: Vec<[DVec3; 2]> = Vec::new();
    let mut right = vec![size];
    let mut sweeps = 0;
    while columns.len() < DEPTH && sweeps < most {
        let last = &basis[basis.len() - 1];
        let swept = engine.jacobi(&last.iter().map(narrow).collect::<Vec<_>>(), 1)?;
        progress.tick()?;
        sweeps += 1;
        // (I - A) v, made orthogonal to the basis.
        let mut next: Vec<Light> = last.iter().zip(&swept).map(|(v, a)| [0, 1, 2].map(|k| v[k] - wide(a)[k])).collect();
        let mut column = Vec::new();
        for v in &basis {
            let along = dot(extents, v, &next);
            add(&mut next, v, -along);
            column.push(along);
        }
        let mut below = root(dot(extents, &next, &next));
        if !below.is_finite() {
            return Err(Error::NotFinite { what: "the solution".into() });
        }
        basis.push(scaled(&next, inverse(below)));
        for (i, [c, s]) in turns.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (*c * a + *s * b, *c * b - *s * a);
        }
        let i = columns.len();
        // A band that is solved already has a row of zeros: it turns by nothing.
        let long = root(column[i] * column[i] + below * below);
        let turn = [column[i] * inverse(long), below * inverse(long)];
        column[i] = long;
        below = -turn[1] * right[i];
        right[i] *= turn[0];
        right.push(below);
        turns.push(turn);
        columns.push(column);
        let left = below.abs() * inverse(size);
        if left.max_element() < LEAST {
            break;
        }
    }
    // Back substitution.
    let n = columns.len();
    let mut weights = vec![DVec3::ZERO; n];
    for i in (0..n).rev() {
        let known = (i + 1..n).fold(right[i], |sum, k| sum - columns[k][i] * weights[k]);
        weights[i] = known * inverse(columns[i][i]);
    }
    let mut sum = vec![[DVec3::ZERO; 3]; residual.len()];
    for (v, &by) in basis.iter().zip(&weights) {
        add(&mut sum, v, by);
    }
    Ok((sum, sweeps))
}

/// Powers of two that bring what each room receives by itself near 1, a node each. `rooms` numbers each node's; where it is
/// empty there is one. Rooms see nothing of each other, so each may have a unit of its own, and none is too dim to be solved.
fn units(own: &[Light], rooms: &[u32]) -> Vec<f64> {
    let room = |j: usize| rooms.get(j).map_or(0, |&r| r as usize);
    let mut most = vec![0.0f64; rooms.iter().max().map_or(1, |&m| m as usize + 1)];
    for (j, l) in own.iter().enumerate() {
        most[room(j)] = most[room(j)].max(l[0].abs().max_element());
    }
    let unit = |x: f64| if x > 0.0 && x.is_finite() { 2f64.powi(x.log2().round() as i32) } else { 1.0 };
    (0..own.len()).map(|j| unit(most[room(j)])).collect()
}

/// Solves a system, whose contraction the rule tells, from darkness; the unlit one is set on the engine. What it tells is
/// measured on the light that it returns.
///
/// Errors: [`Error::NotFinite`]; those of the engine.
pub fn solve<E: Engine>(
    engine: &mut E,
    system: &System,
    materials: &[Material],
    rooms: &[u32],
    rule: Rule,
    progress: &mut Progress,
) -> Result<(Vec<NodeLight>, Solved)> {
    let (extents, factor) = (extents(system), rule.factor);
    let mut light = vec![[DVec3::ZERO; 3]; system.planes.len()];
    // Light is in the rooms' own units until it is given back.
    let units = units(&sweep(system, materials, &light), rooms);
    let times = |light: &[Light], by: &dyn Fn(f64) -> f64| -> Vec<Light> {
        light.iter().zip(&units).map(|(l, &unit)| l.map(|x| x * by(unit))).collect()
    };
    let (into, out) = (|unit: f64| 1.0 / unit, |unit: f64| unit);
    let mut best = light.clone();
    let mut solved = Solved { contraction: factor, accelerated: true, ..Solved::default() };
    let (mut least, mut away, mut stuck) = (f64::INFINITY, f64::INFINITY, 0);
    loop {
        let swept = times(&sweep(system, materials, &times(&light, &out)), &into);
        solved.sweeps += 1;
        let residual: Vec<Light> = swept.iter().zip(&light).map(|(s, l)| [0, 1, 2].map(|k| s[k] - l[k])).collect();
        let (change, size) = (largest(&residual), largest(&swept));
        if !change.is_finite() || !size.is_finite() {
            return Err(Error::NotFinite { what: "the solution".into() });
        }
        if size == 0.0 {
            return Ok((times(&light, &out).iter().map(narrow).collect(), Solved { residual: 0.0, error_bound: 0.0, ..solved }));
        }
        stuck = if change < 0.5 * least { 0 } else { stuck + 1 };
        if change < least {
            least = change;
            best.clone_from(&light);
            solved.residual = change / size;
            away = solved.residual / (1.0 - factor);
            // Light is kept in f32.
            solved.error_bound = away + f64::from(f32::EPSILON);
        }
        progress.event(Event::Sweep { n: solved.sweeps, residual: solved.error_bound })?;
        if away < rule.tolerance || stuck >= STUCK || solved.sweeps >= rule.max_sweeps {
            return Ok((times(&best, &out).iter().map(narrow).collect(), solved));
        }
        let most = rule.max_sweeps - solved.sweeps;
        let (more, sweeps) = correction(engine, &extents, &residual, most, progress)?;
        add(&mut light, &more, DVec3::ONE);
        solved.sweeps += sweeps;
    }
}
