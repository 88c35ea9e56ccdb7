//! A learned kernel as links: a cell stands for the light between its two ends, as much of it as its part of the
//! pairs' measure times its mean answer there, spread around both ends as wide as the inputs lie that it wins.

use super::ends::Ends;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Link, NONE, Node, Point};
use crate::network::nodes::sample_points;
use crate::network::pairs::{PairMetric, end, node_end};
use crate::network::supervised::{Samples, Settings, Supervised};
use crate::radiosity::coefficients::Coefficients;
use crate::scene::Geometry;
use std::collections::BTreeMap;

/// Surface points a node that tell its area.
const POINTS_PER_NODE: usize = 64;
/// Footprints end where they have fallen to exp of minus this.
const REACH: f32 = 6.0;
/// Variance of a footprint, at least, in units of L²: what a cell that won a single input has.
const LEAST_VARIANCE: f32 = 1e-9;

/// Where an end of a pair lies in an input.
const EMITTER: usize = 0;
const RECEIVER: usize = 6;

/// The part of each place in a footprint of Gaussian shape about an end of a link, summing to 1: places, each with an
/// area. Of none in reach the nearest has all.
fn footprint(centre: &[f32; RECEIVER + 6], at: usize, variance: f32, places: &[[f32; 6]], areas: &[f64]) -> Vec<(u32, f64)> {
    let exponents: Vec<f32> = places
        .iter()
        .map(|p| (0..6).map(|k| (p[k] - centre[at + k]) * (p[k] - centre[at + k])).sum::<f32>() / (2.0 * variance))
        .collect();
    let least = exponents.iter().copied().fold(f32::MAX, f32::min);
    let near = exponents.iter().enumerate().filter(|(_, e)| **e - least < REACH);
    let mut out: Vec<(u32, f64)> = near.map(|(i, e)| (i as u32, areas[i] * ((least - e) as f64).exp())).collect();
    let sum: f64 = out.iter().map(|x| x.1).sum();
    out.iter_mut().for_each(|x| x.1 /= sum.max(f64::MIN_POSITIVE));
    out
}

/// Reads every cell as a link between the quadrature points `ends`, of area `weights`, and the nodes. The surface that
/// `ends` was looked up in must be set on the engine.
pub fn build<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    net: &Supervised,
    settings: &Settings,
    metric: PairMetric,
    nodes: &[Node],
    samples: &Samples<[Point; 2]>,
    (ends, weights): (&Ends, &[f32]),
    visible: Option<&[f64]>,
    seed: u32,
) -> Result<Coefficients> {
    // The nodes' areas.
    let live = |t: usize| geometry.is_live(geometry.tile_tri[t] as usize);
    let shares: Vec<f64> = (0..geometry.tiles as usize).map(|t| if live(t) { geometry.tile_area(t) } else { 0.0 }).collect();
    let points = sample_points(geometry, &shares, (POINTS_PER_NODE * nodes.len().max(1)) as u32, seed);
    let mut batch = engine.upload(&points)?;
    engine.assign(&mut batch)?;
    let mut node_areas = vec![0.0; nodes.len()];
    for psi in engine.psi(&batch)? {
        for k in (0..4).filter(|&k| psi.weight[k] > 0.0) {
            node_areas[psi.node[k] as usize] += psi.weight[k] as f64 * geometry.area / points.len() as f64;
        }
    }

    // The cells' parts of the pairs' measure, what the network answers there, and the mean of the inputs. All over the
    // whole part: a cell lies beside that mean, drawn by its neighbours, and a plane's value there is not its mean.
    let counted = || samples.values.iter().zip(&samples.inputs).filter(|(s, _)| s.winner != NONE);
    let [mut part, mut answers] = [(); 2].map(|()| vec![0.0; net.cells.len()]);
    let mut sums = vec![[0.0; RECEIVER + 6]; net.cells.len()];
    for (s, input) in counted() {
        let (cell, weight) = (s.winner as usize, s.weight as f64);
        part[cell] += weight;
        answers[cell] += weight * s.output.clamp(0.0, 1.0) as f64;
        sums[cell].iter_mut().zip(input).for_each(|(sum, &x)| *sum += weight * x as f64);
    }
    let centres: Vec<_> = sums.iter().zip(&part).map(|(sum, part)| sum.map(|x| (x / part) as f32)).collect();

    // How wide each end is.
    let mut spread = vec![[0.0; 2]; net.cells.len()];
    for (s, input) in counted() {
        let cell = s.winner as usize;
        for (sum, at) in spread[cell].iter_mut().zip([EMITTER, RECEIVER]) {
            let d: f32 = (at..at + 6).map(|k| (input[k] - centres[cell][k]) * (input[k] - centres[cell][k])).sum();
            *sum += (s.weight * d) as f64;
        }
    }
    let directions = if geometry.flatland { 1.0 } else { 2.0 };

    // Spread every cell around both its ends.
    let place = |e: ([f32; 3], [f32; 3])| {
        let f = metric.input(e, e);
        [f[0], f[1], f[2], f[3], f[4], f[5]]
    };
    let senders: Vec<[f32; 6]> = ends.points.iter().map(|p| place(end(geometry, p))).collect();
    let receivers: Vec<[f32; 6]> = nodes.iter().map(|n| place(node_end(n))).collect();
    let sender_areas: Vec<f64> = weights.iter().map(|&w| w as f64).collect();
    let mut links = Ends::default();
    let mut rows = vec![Vec::new(); nodes.len()];
    for c in (0..net.cells.len()).filter(|&c| part[c] > 0.0) {
        let variance = spread[c].map(|s| ((s / part[c] / directions) as f32).max(LEAST_VARIANCE));
        let pairs = part[c] * geometry.area * geometry.area / samples.drawn as f64;
        let flux = pairs * answers[c] / part[c] * metric.clamp as f64;
        if flux <= 0.0 {
            continue;
        }
        let (mut gather, mut sent) = (BTreeMap::<u32, f64>::new(), [0.0f32; 4]);
        for (q, share) in footprint(&centres[c], EMITTER, variance[0], &senders, &sender_areas) {
            for l in &ends.gather[q as usize] {
                *gather.entry(l.other).or_default() += share * l.value as f64;
            }
            for k in 0..3 {
                sent[k] += share as f32 * ends.sent[q as usize][k];
            }
        }
        for (j, share) in footprint(&centres[c], RECEIVER, variance[1], &receivers, &node_areas) {
            let value = (share * flux / node_areas[j as usize].max(f64::MIN_POSITIVE)) as f32;
            rows[j as usize].push(Link { other: links.gather.len() as u32, value, ..Link::default() });
        }
        links.gather.push(gather.into_iter().map(|(i, v)| Link { other: i, value: v as f32, ..Link::default() }).collect());
        links.sent.push(sent);
    }
    Ok(links.system(nodes, rows, visible, net.stored(settings)))
}
