//! Reads cells as coefficients (design §1, step 5; evidence: local linear nodes).

use crate::layout::{Link, Node, NodeLight, NodeSource, Plane, Slot};
use crate::twin::coefficients::Sums;
use crate::twin::fixed::UNIT;
use crate::twin::jacobi::System;
use std::collections::BTreeMap;

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

/// Keeps the `cap` slots of largest value, ties by node, in node order, and beyond the cap the largest of each `kind` of
/// nodes that would have none left. Returns them, each with the factor that restores its kind's sum, and the value dropped.
fn cap_row(row: &[Slot], cap: usize, kind: impl Fn(&Slot) -> u32) -> (Vec<(Slot, f64)>, f64) {
    if row.len() <= cap {
        return (row.iter().map(|s| (*s, 1.0)).collect(), 0.0);
    }
    let mut order: Vec<&Slot> = row.iter().collect();
    order.sort_by_key(|s| (std::cmp::Reverse(s.value.units()), s.key));
    // Of each kind: all, and what is kept.
    let mut sums: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
    let mut kept: Vec<Slot> = Vec::new();
    for (i, s) in order.into_iter().enumerate() {
        let value = s.value.value(UNIT);
        let sum = sums.entry(kind(s)).or_default();
        if i < cap || (sum[1] == 0.0 && value > 0.0) {
            kept.push(*s);
            sum[1] += value;
        }
        sum[0] += value;
    }
    kept.sort_by_key(|s| s.key);
    let lost = sums.values().map(|s| s[0] - s[1]).sum();
    let factor = |s: &Slot| sums.get(&kind(s)).map_or(1.0, |s| if s[1] > 0.0 { s[0] / s[1] } else { 0.0 });
    (kept.iter().map(|s| (*s, factor(s))).collect(), lost)
}

/// Gives what rounding took from a row's sums, which are to be `want`, to its largest link: at a reflectance of .9999 a
/// row sum that is off by 1e-7 makes a furnace 1e-3 too bright (hard case E03).
fn settle(row: &mut [Link], want: [f64; 3]) {
    let sum = |part: fn(&Link) -> f32| row.iter().map(|l| f64::from(part(l))).sum::<f64>();
    let rest = [want[0] - sum(|l| l.value), want[1] - sum(|l| l.first), want[2] - sum(|l| l.second)];
    if let Some(l) = row.iter_mut().max_by(|a, b| a.value.total_cmp(&b.value)) {
        l.value = (f64::from(l.value) + rest[0]) as f32;
        l.first = (f64::from(l.first) + rest[1]) as f32;
        l.second = (f64::from(l.second) + rest[2]) as f32;
    }
}

/// Share by which the sum of a row may miss what it is a sum of by rounding alone: more is light that no node speaks for.
const ROUNDING: f64 = 1e-5;

/// Builds the system from the sums over all rays. Sets each node's `mean`, which the read-out needs.
///
/// Constant light is carried exactly, also where slots are dropped: a node's row of values sums to the share of its mass
/// that came from surfaces, so no energy is created, and its moments to those of all these rays, so that no slope is.
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
    let mut deposits: Vec<Vec<(u32, [f64; 3])>> = vec![Vec::new(); nodes.len()];
    // What each node's deposits come to before any is dropped, and the largest of them.
    let mut whole = vec![[0.0; 3]; nodes.len()];
    let mut largest: Vec<Option<(u32, Slot)>> = vec![None; nodes.len()];
    // About the mean of the node's mass.
    let centred = |s: &Slot, factor: f64, node: &Node| {
        let v = s.value.value(UNIT) * factor;
        let about = |m: f64, k: usize| m * factor - v * f64::from(node.mean[k]);
        [v, about(s.first.value(UNIT), 0), about(s.second.value(UNIT), 1)]
    };
    out.system.cell_offsets.push(0);
    for c in 0..sums.flux.len() {
        let flux = sums.flux[c].flux.value(UNIT);
        // Materials are kept apart: what is dropped of one must not be reflected by another.
        let (row, lost) = cap_row(&sums.gather[c], cap, |s| nodes[s.key as usize - 1].material);
        all += flux;
        dropped += lost;
        let start = out.system.cell_links.len();
        if flux > 0.0 {
            let total: f64 = sums.gather[c].iter().map(|s| s.value.value(UNIT)).sum();
            let flux = if (total / flux - 1.0).abs() < ROUNDING { total } else { flux };
            let mut want = [0.0; 3];
            for (s, factor) in row {
                let [value, first, second] = centred(&s, factor, &nodes[s.key as usize - 1]).map(|x| x / flux);
                want = [want[0] + value, want[1] + first, want[2] + second];
                let link = Link { other: s.key - 1, value: value as f32, first: first as f32, second: second as f32 };
                out.system.cell_links.push(link);
            }
            settle(&mut out.system.cell_links[start..], want);
        }
        out.system.cell_offsets.push(out.system.cell_links.len() as u32);
        let source = sums.flux[c].source.map(|s| if flux > 0.0 { (s.value(UNIT) / flux) as f32 } else { 0.0 });
        out.system.source.push([source[0], source[1], source[2], 0.0]);

        for s in &sums.deposit[c] {
            let j = s.key as usize - 1;
            let part = centred(s, 1.0, &nodes[j]);
            whole[j] = [0, 1, 2].map(|k| whole[j][k] + part[k]);
            if largest[j].is_none_or(|(_, l)| l.value.units() < s.value.units()) {
                largest[j] = Some((c as u32, *s));
            }
        }
        let (row, lost) = cap_row(&sums.deposit[c], cap, |_| 0);
        all += flux;
        dropped += lost;
        for (s, factor) in row {
            let j = s.key as usize - 1;
            deposits[j].push((c as u32, centred(&s, factor, &nodes[j])));
        }
    }

    // A node whose deposits were all dropped keeps the largest. Then rows are scaled and shifted to what they were as a
    // whole, over the node's mass, which counts what came from the sky and from back faces, too.
    out.system.node_offsets.push(0);
    for (j, mut row) in deposits.into_iter().enumerate() {
        if let (true, Some((c, s))) = (row.iter().all(|(_, d)| d[0] <= 0.0), largest[j]) {
            row = vec![(c, centred(&s, 1.0, &nodes[j]))];
        }
        let m = sums.nodes[j].mass.value(UNIT);
        out.mass.push(m);
        out.system.node_source.push(NodeLight::default());
        let kept = row.iter().fold([0.0; 3], |sum, (_, d)| [0, 1, 2].map(|k| sum[k] + d[k]));
        let start = out.system.node_links.len();
        if kept[0] > 0.0 && m > 0.0 {
            let scale = whole[j][0] / kept[0];
            let shift = [1, 2].map(|k| (whole[j][k] - scale * kept[k]) / whole[j][0]);
            for (c, d) in row {
                let v = d[0] * scale;
                let [first, second] = [0, 1].map(|k| ((d[k + 1] * scale + v * shift[k]) / m) as f32);
                out.system.node_links.push(Link { other: c, value: (v / m) as f32, first, second });
            }
            settle(&mut out.system.node_links[start..], whole[j].map(|x| x / m));
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
