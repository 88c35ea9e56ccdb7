//! A learned kernel as coefficients by Nystroem's method: H(y_j) = sum_q f(x_q, y_j) w_q B(x_q), with the network's
//! answer f in place of G V (K. Atkinson, "The Numerical Solution of Integral Equations of the Second Kind", 1997,
//! chapter 4).

use super::coefficients::Coefficients;
use super::ends::Ends;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Link, NONE, Node, Point};
use crate::network::nodes::sample_points;
use crate::network::pairs::{PairMetric, end, facing, node_end};
use crate::network::supervised::{Settings, Supervised};
use crate::network::tiles::mean;
use crate::scene::Geometry;

/// Quadrature points a node.
const POINTS_PER_NODE: usize = 2;
/// Share of the quadrature points that lie on what emits, at least: a small light takes part with more than its area.
const ON_EMITTERS: f64 = 0.1;
/// Answers in flight.
const ANSWERS: usize = 1 << 18;

/// Quadrature points and their weights, local area each.
pub fn quadrature(geometry: &Geometry, nodes: usize, seed: u32) -> (Vec<Point>, Vec<f32>) {
    let count = (POINTS_PER_NODE * nodes).max(1);
    let live = |t: usize| geometry.is_live(geometry.tile_tri[t] as usize);
    let shine = |t: usize| mean(&geometry.material_of(geometry.tile_tri[t] as usize).emit.map(f64::from));
    let power: f64 = (0..geometry.tiles as usize).map(|t| shine(t) * geometry.tile_area(t)).sum();
    let density: Vec<f64> = (0..geometry.tiles as usize)
        .map(|t| match (live(t), power > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0 / geometry.area,
            (true, true) => (1.0 - ON_EMITTERS) / geometry.area + ON_EMITTERS * shine(t) / power,
        })
        .collect();
    let shares: Vec<f64> = (0..density.len()).map(|t| density[t] * geometry.tile_area(t)).collect();
    let points = sample_points(geometry, &shares, count as u32, seed);
    let weights = points.iter().map(|p| (1.0 / (density[p.tile as usize] * points.len() as f64)) as f32).collect();
    (points, weights)
}

/// Reads the network between quadrature points and nodes. `mask`: answers between places that do not face each other are 0.
pub fn build<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    net: &Supervised,
    settings: &Settings,
    metric: PairMetric,
    nodes: &[Node],
    (ends, weights): (&Ends, &[f32]),
    mask: bool,
    visible: Option<&[f64]>,
) -> Result<Coefficients> {
    let mut rows: Vec<Vec<Link>> = Vec::with_capacity(nodes.len());
    for chunk in nodes.chunks((ANSWERS / ends.points.len().max(1)).max(1)) {
        let (mut inputs, mut of) = (Vec::new(), Vec::new());
        for node in chunk {
            let y = node_end(node);
            for (q, point) in ends.points.iter().enumerate() {
                let x = end(geometry, point);
                if !mask || facing(x, y) {
                    inputs.push(metric.input(x, y));
                    of.push(q as u32);
                }
            }
            of.push(NONE);
        }
        let mut answers = net.answer(engine, settings, &inputs)?.into_iter();
        for own in of.split(|&q| q == NONE).take(chunk.len()) {
            let row = own.iter().zip(&mut answers).map(|(&q, f)| Link {
                other: q,
                // The kernel is never negative, and was clamped; a plane may leave that range.
                value: f.clamp(0.0, 1.0) * metric.clamp * weights[q as usize],
                ..Link::default()
            });
            rows.push(row.filter(|l| l.value > 0.0).collect());
        }
    }
    Ok(ends.system(nodes, rows, visible, net.stored(settings)))
}
