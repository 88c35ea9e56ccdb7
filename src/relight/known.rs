//! What a bake knows exactly of its own transport, for the use of other light.
//!
//! The cells A stand for the rays K and blur a little. Of the bake's own light, though, it is known what the rays made of it:
//! in every band K (rho D) is what arrived first, and K (rho H) all that arrived after. What is to be carried now, q, is split
//! into a combination of these six (K knows no colours: what one band sent, any other may use) and a rest. The combination
//! goes the rays' way, and only the rest by cells:
//!
//! K q = A q + sum c_b (K - A) q_b + (K - A) (q - sum c_b q_b), of which the last term is left out. It is the extra error.

use crate::radiosity::refined::{Light, wide};
use crate::twin::jacobi::System;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// What a combination may not grow beyond for little gain: the share of a known light's square that counts as noise.
const RIDGE: f64 = 1e-3;

/// What the rays made of light that is known: where it left, and what the cells missed of it.
pub(super) struct Known {
    /// What nodes sent: rho D, and rho H.
    sent: [Vec<Light>; 2],
    /// What arrived beyond what the cells say, as rows (value and moments).
    missed: [Vec<Light>; 2],
    /// Area of each node.
    areas: Vec<f64>,
    /// What cells miss of reflected light, direct and later, as a share of what was sent (root mean squares over the surface).
    pub blur: [f64; 2],
}

/// How much of each known light is in another: a matrix from its bands to the other's, each.
pub(super) type Mix = [DMat3; 2];

/// What the cells make of light that nodes send: rows of values and moments.
pub(super) fn carried(system: &System, sent: &[Light]) -> Vec<Light> {
    let beta: Vec<DVec3> = (system.cell_offsets.par_windows(2))
        .map(|row| {
            system.cell_links[row[0] as usize..row[1] as usize].iter().fold(DVec3::ZERO, |sum, l| {
                let [h, g0, g1] = sent[l.other as usize];
                sum + h * f64::from(l.value) + g0 * f64::from(l.first) + g1 * f64::from(l.second)
            })
        })
        .collect();
    (system.node_offsets.par_windows(2))
        .map(|row| {
            system.node_links[row[0] as usize..row[1] as usize].iter().fold([DVec3::ZERO; 3], |[h, m1, m2], l| {
                let b = beta[l.other as usize];
                [h + b * f64::from(l.value), m1 + b * f64::from(l.first), m2 + b * f64::from(l.second)]
            })
        })
        .collect()
}

/// The rows that a light was fitted from.
fn rows(system: &System, light: &[Light]) -> Vec<Light> {
    let of = |(l, p): (&Light, &crate::layout::Plane)| {
        let [i11, i12, i22] = [p.i11, p.i12, p.i22].map(f64::from);
        let det = i11 * i22 - i12 * i12;
        match det > 0.0 {
            true => [l[0], (l[1] * i22 - l[2] * i12) / det, (l[2] * i11 - l[1] * i12) / det],
            false => [l[0], DVec3::ZERO, DVec3::ZERO],
        }
    };
    light.iter().zip(&system.planes).map(of).collect()
}

/// Light times a reflectance, a node each.
pub(super) fn reflected(light: &[Light], rho: &[DVec3]) -> Vec<Light> {
    light.iter().zip(rho).map(|(l, rho)| l.map(|x| x * *rho)).collect()
}

pub(super) fn sum(a: &[Light], b: &[Light], by: f64) -> Vec<Light> {
    a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|k| a[k] + b[k] * by)).collect()
}

impl Known {
    /// What a bake with system `system` knows of its direct light D and of its light H (both fitted to the nodes, in one unit;
    /// its `node_source` times `unit` is in it, too).
    pub fn new(system: &System, direct: &[Light], light: &[Light], unit: f64, rho: &[DVec3], areas: Vec<f64>) -> Known {
        let first: Vec<Light> = system.node_source.iter().map(|l| wide(l).map(|x| x * unit)).collect();
        let later = sum(&rows(system, light), &first, -1.0);
        let sent = [reflected(direct, rho), reflected(light, rho)];
        let missed = [sum(&first, &carried(system, &sent[0]), -1.0), sum(&later, &carried(system, &sent[1]), -1.0)];
        let size = |rows: &[Light]| rows.iter().zip(&areas).map(|(l, a)| a * l[0].length_squared()).sum::<f64>();
        let blur = [0, 1].map(|s| {
            let all = size(&sent[s]);
            if all > 0.0 { (size(&missed[s]) / all).sqrt() } else { 0.0 }
        });
        Known { sent, missed, areas, blur }
    }

    /// The combination of what is known that is nearest to what is sent.
    pub fn mix(&self, sent: &[Light]) -> Mix {
        // In units of each one's size, so that one ridge fits all.
        let field = |b: usize, i: usize| self.sent[b / 3][i][0][b % 3];
        let dot = |f: &dyn Fn(usize) -> f64, g: &dyn Fn(usize) -> f64| {
            self.areas.iter().enumerate().map(|(i, a)| a * f(i) * g(i)).sum::<f64>()
        };
        let size: Vec<f64> = (0..6).map(|b| dot(&|i| field(b, i), &|i| field(b, i)).sqrt()).collect();
        let inverse = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
        let mut matrix = [[0.0; 9]; 6];
        for a in 0..6 {
            for b in 0..6 {
                matrix[a][b] = dot(&|i| field(a, i), &|i| field(b, i)) * inverse(size[a]) * inverse(size[b]);
            }
            matrix[a][a] += RIDGE;
            for k in 0..3 {
                matrix[a][6 + k] = dot(&|i| field(a, i), &|i| sent[i][0][k]) * inverse(size[a]);
            }
        }
        // Elimination: the matrix is positive definite.
        for a in 0..6 {
            let pivot = matrix[a];
            for (_, row) in matrix.iter_mut().enumerate().filter(|(b, _)| *b != a) {
                let factor = row[a] / pivot[a];
                for (x, p) in row.iter_mut().zip(&pivot) {
                    *x -= factor * p;
                }
            }
        }
        let weight = |b: usize, k: usize| matrix[b][6 + k] / matrix[b][b] * inverse(size[b]);
        [0, 1].map(|s| DMat3::from_cols_array_2d(&[0, 1, 2].map(|b| [0, 1, 2].map(|k| weight(3 * s + b, k)))))
    }

    /// What is sent by a combination.
    pub fn of(&self, mix: &Mix) -> Vec<Light> {
        combined(&self.sent, mix)
    }

    /// What cells miss of a combination.
    pub fn missed(&self, mix: &Mix) -> Vec<Light> {
        combined(&self.missed, mix)
    }

    /// Area of each node.
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// What nodes sent in all.
    pub fn sent(&self) -> Vec<Light> {
        sum(&self.sent[0], &self.sent[1], 1.0)
    }
}

fn combined(of: &[Vec<Light>; 2], mix: &Mix) -> Vec<Light> {
    of[0].iter().zip(&of[1]).map(|(a, b)| [0, 1, 2].map(|k| mix[0] * a[k] + mix[1] * b[k])).collect()
}
