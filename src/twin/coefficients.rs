//! Pass `coefficients`: the cells' measured footprints on the nodes (design §1, step 5).

use super::assign::Surface;
use super::fixed::{UNIT, encode};
use super::math::tangents;
use crate::layout::{CellFlux, DirectSum, NONE, Node, NodeSums, Point, Psi, Slot, kind};
use crate::scene::Geometry;
use glam::Vec3;
use std::collections::BTreeMap;

/// Sums over all rays; order-free, so that batches may come as they like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Gather side of each cell: the emitter ends' weights, slots by ascending node.
    pub gather: Vec<Vec<Slot>>,
    /// Deposit side of each cell: the receiver ends' weights, slots by ascending node.
    pub deposit: Vec<Vec<Slot>>,
    /// Flux and source of each cell.
    pub flux: Vec<CellFlux>,
    /// Mass and moments of each node.
    pub nodes: Vec<NodeSums>,
}

/// Offsets of a point from a node along the node's tangents.
pub fn offsets(node: &Node, p: Vec3) -> (f32, f32) {
    let (t1, t2) = tangents(Vec3::from(node.n));
    let d = p - Vec3::from(node.p);
    (d.dot(t1), d.dot(t2))
}

fn add(row: &mut BTreeMap<u32, Slot>, carried: f32, node: u32, value: f32, first: f32, second: f32) {
    let slot = row.entry(node).or_insert(Slot { key: node + 1, ..Slot::default() });
    slot.value.add(encode(value * carried, UNIT));
    slot.first.add(encode(first * carried, UNIT));
    slot.second.add(encode(second * carried, UNIT));
}

/// Sums one batch of rays. `winners` names the cell of each directed ray; `direct` holds D at every
/// point where direct light is exact, and is `None` where the network carries it. Weights are
/// multiplied by `normalise` so that all rays together weigh at most 1; `rays` is their number n.
pub fn coefficients(
    geometry: &Geometry,
    surface: &Surface,
    points: &[Point],
    psi: &[Psi],
    winners: &[u32],
    direct: Option<&[DirectSum]>,
    normalise: f32,
    rays: f32,
    cells: usize,
) -> Sums {
    let mut gather = vec![BTreeMap::new(); cells];
    let mut deposit = vec![BTreeMap::new(); cells];
    let mut flux = vec![CellFlux::default(); cells];
    let mut nodes = vec![NodeSums::default(); surface.nodes.len()];

    for d in 0..points.len() {
        let y = &points[d];
        let w = y.weight * normalise;
        if w <= 0.0 {
            continue;
        }
        // Whatever arrives around a node has mass, also from the sky and from back faces.
        for k in 0..4 {
            if psi[d].weight[k] > 0.0 {
                let node = psi[d].node[k] as usize;
                let (a, b) = offsets(&surface.nodes[node], Vec3::from(y.p));
                let v = w * psi[d].weight[k];
                let s = &mut nodes[node];
                s.mass.add(encode(v, UNIT));
                s.first[0].add(encode(v * a, UNIT));
                s.first[1].add(encode(v * b, UNIT));
                s.second[0].add(encode(v * a * a, UNIT));
                s.second[1].add(encode(v * a * b, UNIT));
                s.second[2].add(encode(v * b * b, UNIT));
                s.square.add(encode((v * rays) * v, UNIT));
            }
        }
        if y.kind != kind::FRONT || winners[d] == NONE {
            continue;
        }
        let cell = winners[d] as usize;
        // Masses take the whole ray, cells what of its light arrives.
        let carried = if geometry.is_lossy() { points[d | 1].density } else { 1.0 };
        // The receiver end deposits.
        for k in 0..4 {
            if psi[d].weight[k] > 0.0 {
                let node = psi[d].node[k];
                let (a, b) = offsets(&surface.nodes[node as usize], Vec3::from(y.p));
                let v = w * psi[d].weight[k];
                add(&mut deposit[cell], carried, node, v, v * a, v * b);
            }
        }
        // The emitter end gathers; an orphan borrows the value of the node it names.
        let (x, px) = (&points[d ^ 1], &psi[d ^ 1]);
        if px.is_orphan() {
            if px.node[0] != NONE {
                add(&mut gather[cell], carried, px.node[0], w, 0.0, 0.0);
            }
        } else {
            for k in 0..4 {
                if px.weight[k] > 0.0 {
                    let node = px.node[k];
                    let (a, b) = offsets(&surface.nodes[node as usize], Vec3::from(x.p));
                    let v = w * px.weight[k];
                    add(&mut gather[cell], carried, node, v, v * a, v * b);
                }
            }
        }
        // The emitter end sends by itself.
        let material = geometry.material_at(x);
        let source = match direct {
            Some(direct) => Vec3::from(material.rho) * Vec3::from(direct[d ^ 1].mean()),
            None => Vec3::from(material.emit),
        };
        let w = w * carried;
        flux[cell].flux.add(encode(w, UNIT));
        for k in 0..3 {
            flux[cell].source[k].add(encode(w * source[k], UNIT));
        }
    }
    let rows = |maps: Vec<BTreeMap<u32, Slot>>| maps.into_iter().map(|m| m.into_values().collect()).collect();
    Sums { gather: rows(gather), deposit: rows(deposit), flux, nodes }
}

impl Sums {
    /// Adds another batch.
    pub fn merge(&mut self, other: Sums) {
        // Without cells there are nodes all the same.
        if self.nodes.is_empty() {
            *self = other;
            return;
        }
        fn merge_rows(mine: &mut [Vec<Slot>], theirs: Vec<Vec<Slot>>) {
            for (row, more) in mine.iter_mut().zip(theirs) {
                for slot in more {
                    match row.binary_search_by_key(&slot.key, |s| s.key) {
                        Ok(i) => {
                            row[i].value.add(slot.value.units());
                            row[i].first.add(slot.first.units());
                            row[i].second.add(slot.second.units());
                        }
                        Err(i) => row.insert(i, slot),
                    }
                }
            }
        }
        merge_rows(&mut self.gather, other.gather);
        merge_rows(&mut self.deposit, other.deposit);
        for (a, b) in self.flux.iter_mut().zip(other.flux) {
            a.flux.add(b.flux.units());
            for k in 0..3 {
                a.source[k].add(b.source[k].units());
            }
        }
        for (a, b) in self.nodes.iter_mut().zip(other.nodes) {
            a.mass.add(b.mass.units());
            a.square.add(b.square.units());
            for k in 0..2 {
                a.first[k].add(b.first[k].units());
            }
            for k in 0..3 {
                a.second[k].add(b.second[k].units());
            }
        }
    }
}
