//! Keeps rooms apart that see nothing of each other: a cell whose rays serve several of them is split,
//! so that a dark room beside a lit one stays exactly dark.

use crate::disjoint::Disjoint;
use crate::layout::{NONE, Point, Psi, kind};
use std::collections::HashMap;

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
