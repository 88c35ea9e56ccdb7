//! Form factors between all pairs of patches: the N^2 coefficients of classical radiosity (Goral et al. 1984).

use super::sampled::{POINTS, Sampled};
use super::{Mesh, Patch};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Material, NodeLight, Point};
use crate::progress::Progress;
use crate::scene::Geometry;
use crate::twin::math::hash;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Kernel evaluations of a pair, by the distance of both middles in sizes of the larger patch: from so far on, so many.
const EVALUATIONS: [(f64, u32); 3] = [(4.0, 1), (2.0, 4), (1.3, 16)];
/// The same for pairs that are nearer still: every point of one with every point of the other.
const NEAR: u32 = (POINTS * POINTS) as u32;
/// Evaluations in flight.
const FLIGHT: usize = 1 << 18;

/// The matrix: H_i = sum_j F_ij B_j.
#[derive(Clone, Debug, Default)]
pub struct Exchange {
    /// Start of each patch's row; one more entry than patches.
    pub offsets: Vec<usize>,
    /// The patch that sends.
    pub other: Vec<u32>,
    /// F_ij, not 0.
    pub value: Vec<f32>,
    /// Evaluations of the kernel.
    pub evaluations: u64,
}

/// Kernel evaluations that a pair of patches deserves.
pub fn evaluations(x: &Patch, y: &Patch) -> u32 {
    let far = x.shape.centre().distance(y.shape.centre()) / x.shape.size().max(y.shape.size());
    EVALUATIONS.iter().find(|e| far >= e.0).map_or(NEAR, |e| e.1)
}

/// Which points of both patches `n` evaluations of pair (x, y) are made at. Few take points from different rows and
/// columns of both.
pub fn places(x: u32, y: u32, n: u32) -> impl Iterator<Item = (usize, usize)> {
    let h = hash(hash(x).wrapping_add(y)) as usize;
    (0..n as usize).map(move |s| {
        let (a, b) = match n {
            NEAR => (s / POINTS, s % POINTS),
            _ if n as usize == POINTS => (s, h + 7 * s),
            _ => (h + 5 * s, (h >> 8) + 5 * (s ^ (h >> 16) & 3)),
        };
        (a % POINTS, b % POINTS)
    })
}

/// Appends the pairs of points that `n` evaluations of a pair of patches are made at.
fn push_pairs(sampled: &Sampled, x: usize, y: usize, n: u32, points: &mut Vec<Point>, weights: &mut Vec<f32>) {
    for (a, b) in places(x as u32, y as u32, n) {
        let (a, b) = (x * POINTS + a, y * POINTS + b);
        points.extend([sampled.points[a], sampled.points[b]]);
        weights.push(sampled.stretch[a] * sampled.stretch[b]);
    }
}

/// Whether two patches face each other in any part.
pub fn facing(geometry: &Geometry, mesh: &Mesh, x: &Patch, y: &Patch) -> bool {
    let plane = |p: &Patch| {
        let tri = &geometry.tris[mesh.charts[p.chart as usize].tris[0] as usize];
        (tri.plane, Vec3::from(tri.normal).as_dvec3())
    };
    let ((px, nx), (py, ny)) = (plane(x), plane(y));
    let before = |n: DVec3, from: &Patch, to: &Patch| to.shape.outline().iter().any(|c| n.dot(*c - from.shape.corners[0]) > 0.0);
    px != py && before(nx, x, y) && before(ny, y, x)
}

impl Exchange {
    /// Evaluates the kernel at points of all pairs of patches that face each other. F is reciprocal, so a pair is
    /// evaluated once; rows are then scaled to sum to the visible share of each patch's view.
    pub fn new<E: Engine>(
        engine: &mut E,
        geometry: &Geometry,
        mesh: &Mesh,
        sampled: &Sampled,
        progress: &mut Progress,
    ) -> Result<Exchange> {
        let patches = &mesh.patches;
        let n = patches.len();
        // S_ij = A_i A_j <G V> of j > i, row by row.
        let mut upper: Vec<Vec<(u32, f32)>> = vec![Vec::new(); n];
        let mut evaluated = 0u64;
        let (mut points, mut weights, mut spans) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..n {
            let row: Vec<(u32, u32)> = (i + 1..n)
                .into_par_iter()
                .filter(|&j| facing(geometry, mesh, &patches[i], &patches[j]))
                .map(|j| (j as u32, evaluations(&patches[i], &patches[j])))
                .collect();
            for (j, count) in row {
                push_pairs(sampled, i, j as usize, count, &mut points, &mut weights);
                spans.push((i as u32, j, count));
            }
            if weights.len() >= FLIGHT || i + 1 == n {
                let mut at = 0;
                evaluated += weights.len() as u64;
                let values = engine.kernel(&points)?;
                for &(i, j, count) in &spans {
                    let own = at..at + count as usize;
                    at = own.end;
                    let sum: f64 = own.map(|k| values[k] as f64 * weights[k] as f64).sum();
                    if sum > 0.0 {
                        let s = sum / count as f64 * patches[i as usize].area * patches[j as usize].area;
                        upper[i as usize].push((j, s as f32));
                    }
                }
                points.clear();
                weights.clear();
                spans.clear();
                progress.tick()?;
            }
        }

        // Whole rows: what is below the diagonal is what is above it.
        let mut length = vec![0usize; n];
        for (i, row) in upper.iter().enumerate() {
            length[i] += row.len();
            row.iter().for_each(|&(j, _)| length[j as usize] += 1);
        }
        let mut out = Exchange { offsets: vec![0], evaluations: evaluated, ..Exchange::default() };
        for l in &length {
            out.offsets.push(out.offsets.last().unwrap_or(&0) + l);
        }
        let all = out.offsets[n];
        (out.other, out.value) = (vec![0; all], vec![0.0; all]);
        let mut next = out.offsets[..n].to_vec();
        let mut put = |row: usize, other: u32, s: f32| {
            (out.other[next[row]], out.value[next[row]]) = (other, s);
            next[row] += 1;
        };
        for (i, row) in upper.iter().enumerate() {
            for &(j, s) in row {
                put(i, j, s);
                put(j as usize, i as u32, s);
            }
        }
        for i in 0..n {
            let row = &mut out.value[out.offsets[i]..out.offsets[i + 1]];
            let sum: f64 = row.iter().map(|&s| s as f64).sum();
            let factor = if sum > 0.0 { sampled.visible[i] / sum } else { 0.0 };
            row.iter_mut().for_each(|s| *s = (*s as f64 * factor) as f32);
        }
        Ok(out)
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let own = self.offsets[i]..self.offsets[i + 1];
        self.other[own.clone()].iter().zip(&self.value[own]).map(|(&j, &f)| (j as usize, f as f64))
    }

    /// What arrives at each patch from what all others send.
    pub fn carry(&self, sent: &[DVec3]) -> Vec<DVec3> {
        (0..sent.len()).into_par_iter().map(|i| self.row(i).map(|(j, f)| sent[j] * f).sum()).collect()
    }
}

/// The matrix with the scene's materials and light: what a solver sweeps.
pub struct Transport<'a> {
    exchange: &'a Exchange,
    rho: Vec<DVec3>,
    /// What arrives before any reflection that the sweeps add.
    known: Vec<DVec3>,
}

impl Transport<'_> {
    /// What the patches send by themselves: rho D where direct light is exact, else E.
    pub fn new<'a>(geometry: &Geometry, mesh: &Mesh, sampled: &Sampled, exchange: &'a Exchange, exact: bool) -> Transport<'a> {
        let own = own_light(geometry, mesh, &mesh.patches, sampled, exact);
        let known = exchange.carry(&own.iter().map(|o| o.1).collect::<Vec<_>>());
        Transport { exchange, rho: own.into_iter().map(|o| o.0).collect(), known }
    }

    /// `sweeps` Jacobi sweeps from a light; sums in f64, gradients 0.
    pub fn jacobi(&self, light: &[NodeLight], sweeps: u32) -> Vec<NodeLight> {
        let mut h = open(light);
        for _ in 0..sweeps {
            let sent: Vec<DVec3> = h.iter().zip(&self.rho).map(|(h, r)| *h * *r).collect();
            h = self.exchange.carry(&sent);
            h.iter_mut().zip(&self.known).for_each(|(h, k)| *h += *k);
        }
        close(&h)
    }

    /// `sweeps` Gauss-Seidel sweeps over the patches in order.
    pub fn gauss_seidel(&self, light: &[NodeLight], sweeps: u32) -> Vec<NodeLight> {
        let mut h = open(light);
        for _ in 0..sweeps {
            for i in 0..h.len() {
                h[i] = self.known[i] + self.exchange.row(i).map(|(j, f)| h[j] * self.rho[j] * f).sum::<DVec3>();
            }
        }
        close(&h)
    }
}

/// Reflectance of each patch, and what it sends by itself.
pub fn own_light(geometry: &Geometry, mesh: &Mesh, patches: &[Patch], sampled: &Sampled, exact: bool) -> Vec<(DVec3, DVec3)> {
    let wide = |x: [f32; 3]| DVec3::from_array(x.map(f64::from));
    // Where textures make it vary, the mean over a patch's points.
    let mean = |i: usize| {
        let (mut m, mut all) = (Material::default(), 0.0);
        for k in i * POINTS..(i + 1) * POINTS {
            let (here, w) = (geometry.material_at(&sampled.points[k]), sampled.stretch[k]);
            let add = |sum: [f32; 3], x: [f32; 3]| [0, 1, 2].map(|b| sum[b] + w * x[b]);
            (m.rho, m.emit) = (add(m.rho, here.rho), add(m.emit, here.emit));
            all += w;
        }
        Material { rho: m.rho.map(|x| x / all), emit: m.emit.map(|x| x / all), ..m }
    };
    patches
        .iter()
        .zip(&sampled.direct)
        .enumerate()
        .map(|(i, (p, &d))| {
            let plain = geometry.material_of(mesh.charts[p.chart as usize].tris[0] as usize);
            let m = if geometry.textured { mean(i) } else { *plain };
            (wide(m.rho), if exact { wide(m.rho) * DVec3::from_array(d) } else { wide(m.emit) })
        })
        .collect()
}

/// The irradiances of a light, wide.
pub fn open(light: &[NodeLight]) -> Vec<DVec3> {
    light.iter().map(|l| DVec3::from_array(l.h.map(f64::from))).collect()
}

/// A light of irradiances.
pub fn close(h: &[DVec3]) -> Vec<NodeLight> {
    h.iter().map(|h| NodeLight { h: h.as_vec3().to_array(), ..NodeLight::default() }).collect()
}
