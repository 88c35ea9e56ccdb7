//! Reads cells as coefficients (design §1, step 5; evidence: local linear nodes).

use crate::layout::{Link, Node, NodeLight, NodeSource, Plane, Slot};
use crate::twin::coefficients::Sums;
use crate::twin::fixed::UNIT;
use crate::twin::jacobi::System;

/// Effective samples below which a node has no gradient.
const LEAST_SAMPLES: f64 = 6.0;

/// A system ready to solve, and what was left out.
#[derive(Clone, Debug, Default)]
pub struct Coefficients {
    /// The system.
    pub system: System,
    /// Mass m_j of each node, as a share of all rays' weight; slots beyond the cap count.
    pub mass: Vec<f64>,
    /// Gather and deposit slots kept; of other methods than the network, their coefficients.
    pub stored: u64,
    /// Evaluations of the kernel that they took; a network takes none.
    pub evaluations: u64,
    /// Rays that look around on patches; a network has none.
    pub looks: u64,
    /// Share of the gather and deposit mass in slots beyond the cap.
    pub dropped: f64,
}

/// Keeps the `cap` slots of largest value, ties by node, in node order; returns them with the factor
/// that restores the row's sum, and the mass dropped.
fn cap_row(row: &[Slot], cap: usize) -> (Vec<Slot>, f64, f64) {
    let total: f64 = row.iter().map(|s| s.value.value(UNIT)).sum();
    let mut kept: Vec<Slot> = row.to_vec();
    if kept.len() > cap {
        kept.sort_by_key(|s| (std::cmp::Reverse(s.value.units()), s.key));
        kept.truncate(cap);
        kept.sort_by_key(|s| s.key);
    }
    let sum: f64 = kept.iter().map(|s| s.value.value(UNIT)).sum();
    (kept, if sum > 0.0 { total / sum } else { 0.0 }, total - sum)
}

/// Builds the system from the sums over all rays. Sets each node's `mean`, which the read-out needs.
///
/// Rows of values sum to the share of the node's mass that came from surfaces, so no energy is created.
pub fn build(sums: &Sums, nodes: &mut [Node], ridge: f64, cap: usize, rays: f64) -> Coefficients {
    let mut out = Coefficients::default();
    let (mut dropped, mut all) = (0.0, 0.0);

    // Fit each node's frame: the mean of its mass, and the inverse of its ridged second moments.
    out.system.planes = nodes
        .iter_mut()
        .zip(&sums.nodes)
        .map(|(node, s)| {
            let m = s.mass.value(UNIT);
            let mut plane = Plane { material: node.material, ..Plane::default() };
            if m > 0.0 {
                let mean = s.first.map(|f| f.value(UNIT) / m);
                node.mean = mean.map(|x| x as f32);
                let c11 = s.second[0].value(UNIT) / m - mean[0] * mean[0];
                let c12 = s.second[1].value(UNIT) / m - mean[0] * mean[1];
                let c22 = s.second[2].value(UNIT) / m - mean[1] * mean[1];
                let lift = ridge * (c11 + c22);
                let det = (c11 + lift) * (c22 + lift) - c12 * c12;
                let samples = m * m * rays / s.square.value(UNIT).max(f64::MIN_POSITIVE);
                if samples >= LEAST_SAMPLES && det > 0.0 && lift > 0.0 {
                    (plane.i11, plane.i12, plane.i22) =
                        (((c22 + lift) / det) as f32, (-c12 / det) as f32, ((c11 + lift) / det) as f32);
                }
            }
            plane
        })
        .collect();

    // Gather rows, and deposits turned from cells to nodes.
    let mut deposits: Vec<Vec<(u32, f64, f64, f64)>> = vec![Vec::new(); nodes.len()];
    let mut kept_mass = vec![0.0; nodes.len()];
    let mut row_mass = vec![0.0; nodes.len()];
    out.system.cell_offsets.push(0);
    for c in 0..sums.flux.len() {
        let flux = sums.flux[c].flux.value(UNIT);
        let (row, factor, lost) = cap_row(&sums.gather[c], cap);
        all += flux;
        dropped += lost;
        if flux > 0.0 {
            for s in row {
                let mean = nodes[s.key as usize - 1].mean;
                let v = s.value.value(UNIT) * factor / flux;
                out.system.cell_links.push(Link {
                    other: s.key - 1,
                    value: v as f32,
                    first: (s.first.value(UNIT) * factor / flux - v * mean[0] as f64) as f32,
                    second: (s.second.value(UNIT) * factor / flux - v * mean[1] as f64) as f32,
                });
            }
        }
        out.system.cell_offsets.push(out.system.cell_links.len() as u32);
        let source = sums.flux[c].source.map(|s| if flux > 0.0 { (s.value(UNIT) / flux) as f32 } else { 0.0 });
        out.system.source.push([source[0], source[1], source[2], 0.0]);

        for s in &sums.deposit[c] {
            row_mass[s.key as usize - 1] += s.value.value(UNIT);
        }
        let (row, factor, lost) = cap_row(&sums.deposit[c], cap);
        all += flux;
        dropped += lost;
        for s in row {
            let j = s.key as usize - 1;
            let v = s.value.value(UNIT) * factor;
            let (f, g) = (s.first.value(UNIT) * factor, s.second.value(UNIT) * factor);
            kept_mass[j] += v;
            deposits[j].push((c as u32, v, f - v * nodes[j].mean[0] as f64, g - v * nodes[j].mean[1] as f64));
        }
    }

    // A node's mass is what its kept deposits weigh, plus what came from the sky and from back faces.
    out.system.node_offsets.push(0);
    for (j, row) in deposits.iter().enumerate() {
        let m = kept_mass[j] + (sums.nodes[j].mass.value(UNIT) - row_mass[j]).max(0.0);
        out.mass.push(sums.nodes[j].mass.value(UNIT));
        out.system.node_source.push(NodeLight::default());
        for &(c, v, f, g) in row {
            out.system.node_links.push(Link { other: c, value: (v / m) as f32, first: (f / m) as f32, second: (g / m) as f32 });
        }
        out.system.node_offsets.push(out.system.node_links.len() as u32);
    }
    out.stored = (out.system.cell_links.len() + out.system.node_links.len()) as u64;
    out.dropped = if all > 0.0 { dropped / all } else { 0.0 };
    out
}

/// What is known to arrive, as the start of each node's row: h the value, g0 and g1 the moments about the node's mean.
pub fn known(sums: &[NodeSource], nodes: &[Node], mass: &[f64]) -> Vec<NodeLight> {
    let row = |((s, node), &m): ((&NodeSource, &Node), &f64)| {
        let mut light = NodeLight::default();
        for k in 0..3 {
            let weight = m * f64::from(node.gain);
            if weight > 0.0 {
                let h = s.value[k].value(UNIT) / weight;
                light.h[k] = h as f32;
                light.g0[k] = (s.first[k].value(UNIT) / weight - h * node.mean[0] as f64) as f32;
                light.g1[k] = (s.second[k].value(UNIT) / weight - h * node.mean[1] as f64) as f32;
            }
        }
        light
    };
    sums.iter().zip(nodes).zip(mass).map(row).collect()
}

/// Turns rows as of [`known`] into light: each node's value, and its gradient from the moments.
pub fn fit(rows: &[NodeLight], planes: &[Plane]) -> Vec<NodeLight> {
    rows.iter()
        .zip(planes)
        .map(|(r, p)| NodeLight {
            h: r.h,
            g0: [0, 1, 2].map(|k| r.g0[k] * p.i11 + r.g1[k] * p.i12),
            g1: [0, 1, 2].map(|k| r.g0[k] * p.i12 + r.g1[k] * p.i22),
            ..NodeLight::default()
        })
        .collect()
}
