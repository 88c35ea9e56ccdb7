//! A system whose "cells" are single places that send: the ends at which a learned kernel is read.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Link, NONE, Node, NodeLight, Plane, Point, Psi, kind};
use crate::radiosity::coefficients::Coefficients;
use crate::scene::Geometry;
use crate::twin::direct::Samples;
use crate::twin::jacobi::System;
use crate::twin::trace::{barycentric, surface_point};
use glam::Vec3;

/// Samples of direct light at a sending place.
const DIRECT: Samples = Samples { emitter: 24, cosine: 8 };
/// Rounds of them.
const ROUNDS: u32 = 8;
/// Cosine rays that tell how much of a node's hemisphere holds surface.
const VIEW_RAYS: u32 = 256;

/// What sends, the nodes that speak for it, and what it sends by itself.
#[derive(Clone, Debug, Default)]
pub struct Ends {
    /// The places; empty where ends are wider than a point.
    pub points: Vec<Point>,
    /// Weights over the nodes.
    pub gather: Vec<Vec<Link>>,
    /// E, or rho D where direct light is exact; scaled W/m², the fourth number is unused.
    pub sent: Vec<[f32; 4]>,
}

impl Ends {
    /// Looks places up in the surface network that is set on the engine.
    pub fn new<E: Engine>(engine: &mut E, geometry: &Geometry, points: Vec<Point>, exact: bool, seed: u32) -> Result<Ends> {
        let mut batch = engine.upload(&points)?;
        engine.assign(&mut batch)?;
        let gather = engine.psi(&batch)?.iter().map(weights).collect();
        let direct = if exact {
            engine.direct(&mut batch, None, seed, 0, ROUNDS, DIRECT)?;
            engine.direct_sums(&batch)?
        } else {
            Vec::new()
        };
        let sent = |i: usize| {
            let m = geometry.material_at(&points[i]);
            let s = match direct.get(i).map(|d| d.mean()) {
                Some(d) => [0, 1, 2].map(|k| m.rho[k] * d[k]),
                None => m.emit,
            };
            [s[0], s[1], s[2], 0.0]
        };
        let sent = (0..points.len()).map(sent).collect();
        Ok(Ends { points, gather, sent })
    }

    /// The system of these ends and the rows of weights with which they arrive at the nodes. `stored`: numbers that
    /// the network keeps. `visible`: rows are scaled to sum to this.
    pub fn system(&self, nodes: &[Node], mut rows: Vec<Vec<Link>>, visible: Option<&[f64]>, stored: u64) -> Coefficients {
        let mut system = System { cell_offsets: vec![0], node_offsets: vec![0], ..System::default() };
        for row in &self.gather {
            system.cell_links.extend(row);
            system.cell_offsets.push(system.cell_links.len() as u32);
        }
        system.source = self.sent.clone();
        let mut mass = Vec::new();
        for (j, row) in rows.iter_mut().enumerate() {
            let sum: f64 = row.iter().map(|l| l.value as f64).sum();
            if let Some(visible) = visible.filter(|_| sum > 0.0) {
                row.iter_mut().for_each(|l| l.value = (l.value as f64 * visible[j] / sum) as f32);
            }
            mass.push(sum.max(0.0));
            system.node_links.append(row);
            system.node_offsets.push(system.node_links.len() as u32);
        }
        system.planes = nodes.iter().map(|n| Plane { material: n.material, ..Plane::default() }).collect();
        system.node_source = vec![NodeLight::default(); nodes.len()];
        Coefficients { system, mass, stored, ..Coefficients::default() }
    }
}

/// A point's weights over the nodes; an orphan borrows the value of the node it names.
fn weights(psi: &Psi) -> Vec<Link> {
    let link = |other: u32, value: f32| Link { other, value, ..Link::default() };
    match psi.is_orphan() {
        true if psi.node[0] == NONE => Vec::new(),
        true => vec![link(psi.node[0], 1.0)],
        false => (0..4).filter(|&k| psi.weight[k] > 0.0).map(|k| link(psi.node[k], psi.weight[k])).collect(),
    }
}

/// The nodes as surface points.
fn places(geometry: &Geometry, nodes: &[Node]) -> Vec<Point> {
    let place = |node: &Node| {
        let own = geometry.tris.iter().enumerate().filter(|(_, t)| t.plane == node.plane && t.normal == node.n);
        // A node lies in one triangle of its piece; rounding may put it a little outside.
        let outside = |(_, t): &(usize, &_)| {
            let (b1, b2) = barycentric(geometry.flatland, t, Vec3::from(node.p));
            (-b1).max(-b2).max(b1 + b2 - 1.0)
        };
        let nearest = own.min_by(|a, b| outside(a).total_cmp(&outside(b)));
        nearest.map_or(Point { tri: NONE, tile: NONE, ..Point::default() }, |(i, t)| {
            let (b1, b2) = barycentric(geometry.flatland, t, Vec3::from(node.p));
            Point { p: node.p, ..surface_point(geometry, i as u32, b1.clamp(0.0, 1.0), b2.clamp(0.0, 1.0)) }
        })
    };
    nodes.iter().map(place).collect()
}

/// The share of each node's hemisphere that holds front faces, and of their light that arrives, by cosine rays: what its row
/// should sum to.
pub fn visible<E: Engine>(engine: &mut E, geometry: &Geometry, nodes: &[Node], seed: u32) -> Result<Vec<f64>> {
    let from = engine.upload(&places(geometry, nodes))?;
    let rays = engine.shoot(&from, seed, 0, VIEW_RAYS)?;
    let hits = engine.points(&rays)?;
    let front = |p: &&Point| p.kind == kind::FRONT;
    let share = |own: &[Point]| own.iter().filter(front).map(|p| geometry.arriving(p)).sum::<f64>() / own.len() as f64;
    Ok(hits.chunks_exact(VIEW_RAYS as usize).map(share).collect())
}
