//! Insertion between the worst cell and its farthest neighbour, and deletion of starved ones.

use super::{LEAST_WIDTH, STARVED, Supervised, distance};
use crate::layout::CellOutput;
use crate::twin::winner::Feature;

impl Supervised {
    /// Mean length of a cell's edges.
    pub(super) fn mean_edge(&self, cell: u32) -> f32 {
        let n = self.complex.neighbours(cell);
        n.iter().map(|&n| distance(&self.cells[cell as usize], &self.cells[n as usize])).sum::<f32>() / n.len().max(1) as f32
    }

    /// Sets every width to the mean length of the cell's edges.
    pub(super) fn set_widths(&mut self) {
        let widths: Vec<f32> = (0..self.cells.len() as u32).map(|c| self.mean_edge(c)).collect();
        // Where all cells coincide any width serves, as long as its square is no zero.
        let least = LEAST_WIDTH * widths.iter().copied().fold(LEAST_WIDTH, f32::max);
        for (output, w) in self.outputs.iter_mut().zip(widths) {
            output.width = w.max(least);
        }
    }

    /// Inserts up to `count` cells, one after another, each between the cell with the largest resource and its
    /// farthest neighbour. Stops where no cell has any resource: nothing is left to learn (hard case F03).
    pub fn insert(&mut self, count: usize) {
        for _ in 0..count {
            let mut q = 0;
            for c in 1..self.cells.len() {
                if self.resource[c] > self.resource[q] {
                    q = c;
                }
            }
            if self.resource[q] <= 0.0 {
                return;
            }
            let away = |n: u32| distance(&self.cells[q], &self.cells[n as usize]);
            let far = self.complex.neighbours(q as u32).into_iter().max_by(|&a, &b| away(a).total_cmp(&away(b)).then(b.cmp(&a)));
            let Some(f) = far else { return };
            self.insert_between(q as u32, f);
        }
    }

    /// Inserts a cell in the middle of an edge. Its neighbours give it of their resource what their receptive field
    /// loses, estimated as the mean edge length to the power of k (Fritzke 1994, section 3.2); the sum stays.
    pub(super) fn insert_between(&mut self, q: u32, f: u32) {
        let (a, b) = (&self.cells[q as usize], &self.cells[f as usize]);
        let cell: Feature = std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let (a, b) = (&self.outputs[q as usize], &self.outputs[f as usize]);
        let output = CellOutput {
            slope: std::array::from_fn(|k| 0.5 * (a.slope[k] + b.slope[k])),
            value: 0.5 * (a.value + b.value),
            ..CellOutput::default()
        };
        let around: Vec<u32> = {
            let of_q = self.complex.neighbours(q);
            let shared = self.complex.neighbours(f).into_iter().filter(|n| of_q.contains(n));
            shared.chain([q, f]).collect()
        };
        let k = self.complex.k() as i32;
        let before: Vec<f32> = around.iter().map(|&c| self.mean_edge(c).powi(k)).collect();
        self.complex.split(q, f);
        self.cells.push(cell);
        self.outputs.push(output);
        let (mut resource, mut share, mut wins) = (0.0, 0.0, 0.0);
        for (&c, old) in around.iter().zip(before) {
            let new = self.mean_edge(c).powi(k);
            let given = if old > 0.0 { ((old - new) / old).clamp(0.0, 0.5) as f64 } else { 0.0 };
            for (pool, own) in [
                (&mut resource, &mut self.resource[c as usize]),
                (&mut share, &mut self.share[c as usize]),
                (&mut wins, &mut self.wins[c as usize]),
            ] {
                *pool += given * *own;
                *own -= given * *own;
            }
        }
        self.resource.push(resource);
        self.share.push(share);
        self.wins.push(wins);
    }

    /// Deletes cells that win too few inputs.
    pub(super) fn delete_starved(&mut self) {
        let least = STARVED * self.wins.iter().sum::<f64>() / self.wins.len() as f64;
        let doomed: Vec<bool> = self.wins.iter().map(|&w| w < least).collect();
        if !doomed.contains(&true) {
            return;
        }
        let Some(map) = self.complex.delete(&doomed) else { return };
        let before = self.cells.len();
        fn keep<T: Copy>(all: &mut Vec<T>, map: &[Option<u32>]) {
            *all = all.iter().zip(map).filter(|(_, m)| m.is_some()).map(|(x, _)| *x).collect();
        }
        keep(&mut self.cells, &map);
        keep(&mut self.outputs, &map);
        keep(&mut self.resource, &map);
        keep(&mut self.share, &map);
        keep(&mut self.wins, &map);
        self.deleted += (before - self.cells.len()) as u32;
    }
}
