//! Keeps rooms apart that see nothing of each other: a cell whose rays serve several of them is split,
//! so that a dark room beside a lit one stays exactly dark.

use crate::disjoint::Disjoint;
use crate::layout::{Material, NONE, Node, Point, Psi, kind};
use crate::scene::{Geometry, power_of_two_for};
use crate::twin::jacobi::System;
use std::collections::HashMap;

/// Room for read-outs above the brightest source, by gradients and by what reflection adds: the gain leaves sums below 1/4.
const HEADROOM: f64 = 4.0;
/// Largest gain, and one over the smallest.
const MOST: f64 = 1.2676506002282294e30; // 2^100

/// Sets of nodes that exchange light.
pub struct Components(Disjoint);

impl Components {
    /// Every node by itself.
    pub fn new(nodes: usize) -> Components {
        Components(Disjoint::new(nodes))
    }

    /// Joins the nodes at both ends of every ray that counts both ways.
    pub fn join(&mut self, points: &[Point], psi: &[Psi]) {
        for r in 0..points.len() / 2 {
            if points[2 * r].kind != kind::FRONT {
                continue;
            }
            let mut first = NONE;
            for s in &psi[2 * r..2 * r + 2] {
                for k in 0..4 {
                    if s.node[k] == NONE {
                        continue;
                    }
                    first = if first == NONE { s.node[k] } else { self.0.join(first, s.node[k]) };
                }
            }
        }
    }

    /// Of a system: the nodes of each cell are joined.
    pub fn of(system: &System) -> Components {
        let mut all = Components::new(system.planes.len());
        let cells = system.source.len();
        let mut first = vec![NONE; cells];
        let mut meet = |cell: usize, node: u32| {
            first[cell] = if first[cell] == NONE { node } else { all.0.join(first[cell], node) };
        };
        for c in 0..cells {
            for l in &system.cell_links[system.cell_offsets[c] as usize..system.cell_offsets[c + 1] as usize] {
                meet(c, l.other);
            }
        }
        for j in 0..system.planes.len() {
            for l in &system.node_links[system.node_offsets[j] as usize..system.node_offsets[j + 1] as usize] {
                meet(l.other as usize, j as u32);
            }
        }
        all
    }

    /// Of rows: each node's own, and the nodes in it.
    pub fn of_rows(offsets: &[usize], other: &[u32]) -> Components {
        let count = offsets.len().saturating_sub(1);
        let mut all = Components::new(count);
        for i in 0..count {
            for &o in &other[offsets[i]..offsets[i + 1]] {
                all.0.join(i as u32, o);
            }
        }
        all
    }

    /// The number of each node's component.
    pub fn numbers(self) -> Vec<u32> {
        self.0.numbers()
    }

    /// The component that a ray serves, [`NONE`] where neither end has a node.
    fn of_ray(&mut self, psi: &[Psi]) -> u32 {
        let node = psi[0].node[0].min(psi[1].node[0]);
        if node == NONE { NONE } else { self.0.root(node) }
    }
}

/// Gives every component its own cell; the first met keeps the cell's number, others are appended.
#[derive(Default)]
pub struct Splitter {
    first: Vec<u32>,
    others: HashMap<(u32, u32), u32>,
    cells: u32,
}

impl Splitter {
    /// For a network of `cells` cells.
    pub fn new(cells: usize) -> Splitter {
        Splitter { first: vec![NONE; cells], others: HashMap::new(), cells: cells as u32 }
    }

    /// Cells in all, those appended included.
    pub fn cells(&self) -> usize {
        self.cells as usize
    }

    /// Renames the winners of a batch. Returns whether any changed.
    pub fn split(&mut self, components: &mut Components, points: &[Point], psi: &[Psi], winners: &mut [u32]) -> bool {
        let mut changed = false;
        for d in 0..points.len() {
            if points[d].kind != kind::FRONT || winners[d] == NONE {
                continue;
            }
            let component = components.of_ray(&psi[d & !1..(d & !1) + 2]);
            if component == NONE {
                continue;
            }
            let cell = winners[d] as usize;
            if self.first[cell] == NONE {
                self.first[cell] = component;
            } else if self.first[cell] != component {
                let next = &mut self.cells;
                winners[d] = *self.others.entry((winners[d], component)).or_insert_with(|| {
                    *next += 1;
                    *next - 1
                });
                changed = true;
            }
        }
        changed
    }
}

/// What rays tell of the nodes before any reflection: the brightest source of light that they bring to each and, where
/// textures make it vary, the mean reflectance around each.
pub struct Peaks {
    most: Vec<f32>,
    /// Sums of w psi rho, a band each, and of w psi, over the emitter ends of all rays; empty where no reflectance varies.
    rho: Vec<[f64; 4]>,
}

impl Peaks {
    /// Nothing yet.
    pub fn new(nodes: usize) -> Peaks {
        Peaks { most: vec![0.0; nodes], rho: Vec::new() }
    }

    /// Takes in a batch: rho D of the emitter ends, `direct` being each point's D, or E where it is `None`.
    pub fn see(&mut self, geometry: &Geometry, points: &[Point], psi: &[Psi], direct: Option<&[[f32; 3]]>) {
        for d in (0..points.len()).filter(|&d| points[d].kind == kind::FRONT) {
            let m = geometry.material_at(&points[d ^ 1]);
            let sent = direct.map_or(m.emit, |direct| [0, 1, 2].map(|k| m.rho[k] * direct[d ^ 1][k]));
            let most = sent.iter().fold(0.0, |a: f32, &b| a.max(b));
            for k in (0..4).filter(|&k| psi[d].weight[k] > 0.0) {
                let peak = &mut self.most[psi[d].node[k] as usize];
                *peak = peak.max(most);
            }
            if geometry.textured {
                self.rho.resize(self.most.len(), [0.0; 4]);
                // What of a ray arrives is what it counts.
                let share = if geometry.is_lossy() { points[d | 1].density } else { 1.0 };
                let at = &psi[d ^ 1];
                for k in (0..4).filter(|&k| at.weight[k] > 0.0) {
                    let (w, sum) = (f64::from(points[d].weight * share * at.weight[k]), &mut self.rho[at.node[k] as usize]);
                    for band in 0..3 {
                        sum[band] += w * f64::from(m.rho[band]);
                    }
                    sum[3] += w;
                }
            }
        }
    }

    /// A material for each node, with the reflectance that rays have met around it: what the cells' rays reflect, filtered over
    /// their footprint. Empty where no reflectance varies.
    pub fn materials(&self, geometry: &Geometry, nodes: &[Node]) -> Vec<Material> {
        let of = |(sum, node): (&[f64; 4], &Node)| {
            let m = geometry.materials[node.material as usize];
            let rho = if sum[3] > 0.0 { [0, 1, 2].map(|k| (sum[k] / sum[3]) as f32) } else { m.rho };
            Material { rho, ..m }
        };
        self.rho.iter().zip(nodes).map(of).collect()
    }

    /// Sets the nodes' gains, one for each component: the power of two that brings its brightest light near 1. A room of
    /// 1e-6 W/m2 beside one of 1e9 would otherwise vanish in the fixed-point sums.
    pub fn set_gains(&self, geometry: &Geometry, rooms: &[u32], nodes: &mut [Node]) {
        let count = rooms.iter().max().map_or(0, |&m| m as usize + 1);
        let mut most = vec![(0.0f64, 0.0f64); count];
        for (i, &room) in rooms.iter().enumerate() {
            let rho = geometry.most_rho[nodes[i].material as usize];
            let (peak, reflectance) = &mut most[room as usize];
            *peak = peak.max(f64::from(self.most[i]));
            *reflectance = reflectance.max(f64::from(rho));
        }
        for (node, &room) in nodes.iter_mut().zip(rooms) {
            let (peak, rho) = most[room as usize];
            // No light is brighter than the brightest source over 1 - rho.
            let bound = HEADROOM * peak / (1.0 - rho).max(1e-7);
            node.gain = if peak > 0.0 { power_of_two_for(bound).clamp(1.0 / MOST, MOST) as f32 } else { 1.0 };
        }
    }
}
