//! Training of the cells: epochs of winner, accumulate and adapt on the engine; insertion and deletion here.

use super::complex::Complex;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{CellSums, FEATURE_DIM};
use crate::twin::math::seed_of;
use crate::twin::winner::Feature;
use serde::{Deserialize, Serialize};

/// Rays an epoch shows each cell.
const RAYS_PER_CELL: usize = 16;
/// How strongly neighbours draw a cell while the network grows.
const ETA: f32 = 0.05;
/// Epochs of pure Lloyd iteration at the end.
const LLOYD: u32 = 3;
/// Cells with fewer rays than this share of the mean are starved.
const STARVED: f64 = 0.05;

/// What training did, for the report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Training {
    /// Epochs run.
    pub epochs: u32,
    /// Cells deleted.
    pub deleted: u32,
}

/// The middle of two features.
fn middle(a: &Feature, b: &Feature) -> Feature {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

fn distance2(a: &Feature, b: &Feature) -> f32 {
    (0..FEATURE_DIM).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum()
}

/// A network that grows, between two epochs.
#[derive(Clone, Debug)]
pub struct Growth {
    /// The cells.
    pub cells: Vec<Feature>,
    /// Their topology.
    pub complex: Complex,
    /// What was done so far.
    pub training: Training,
    /// The batch whose rays come next.
    pub batch: usize,
    /// The directed ray of it that comes next.
    pub at: usize,
    /// Epochs of pure Lloyd iteration done.
    pub lloyd: u32,
    /// Whether it is grown.
    pub done: bool,
}

impl Growth {
    /// Three cells: features of `sample` that count, far enough apart to span a triangle.
    pub fn start(sample: &[Feature]) -> Growth {
        let mut cells: Vec<Feature> = Vec::new();
        for f in sample.iter().filter(|f| f.iter().any(|&x| x != 0.0)) {
            if cells.iter().all(|c| distance2(c, f) > 1e-4) {
                cells.push(*f);
            }
            if cells.len() == 3 {
                break;
            }
        }
        while cells.len() < 3 {
            // All rays alike (or none): any three cells serve.
            let mut f = sample.first().copied().unwrap_or_default();
            f[0] += 1e-3 * cells.len() as f32;
            cells.push(f);
        }
        Growth { cells, complex: Complex::simplex(2), training: Training::default(), batch: 0, at: 0, lloyd: 0, done: false }
    }

    /// Rays drawn at random for cells, `count` of them where there are so many that count both ways; nothing is
    /// trained, and the complex is empty. What growth is held against.
    pub fn random<E: Engine>(engine: &mut E, batches: &[E::Batch], lengths: &[usize], count: usize, seed: u32) -> Result<Growth> {
        let mut sample = Vec::new();
        for (batch, &length) in batches.iter().zip(lengths) {
            sample.extend(engine.features(batch, 0..length)?.into_iter().filter(|f| f.iter().any(|&x| x != 0.0)));
        }
        // One from each of so many equal shares of the sequence.
        let place = |c: usize| {
            let (first, end) = (c * sample.len() / count, (c + 1) * sample.len() / count);
            first + seed_of(seed, c as u32) as usize % (end - first).max(1)
        };
        let cells = (0..count.min(sample.len())).map(|c| sample[place(c)]).collect();
        Ok(Growth { cells, complex: Complex::empty(), training: Training::default(), batch: 0, at: 0, lloyd: 0, done: true })
    }

    /// An epoch on the way to `target` cells: shows the cells their share of the features of `batches`, which hold
    /// `lengths` directed rays, and moves, inserts and deletes. Epochs walk through the batches in turn, so that
    /// they see fresh rays as long as there are any. On an error nothing has changed.
    pub fn epoch<E: Engine>(&mut self, engine: &mut E, batches: &mut [E::Batch], lengths: &[usize], target: usize) -> Result<()> {
        let (mut batch, mut at) = (self.batch, self.at);
        let share = (RAYS_PER_CELL * self.cells.len() * 2).max(512);
        if at + share.min(lengths[batch]) > lengths[batch] {
            (batch, at) = ((batch + 1) % batches.len(), 0);
        }
        let range = at..at + share.min(lengths[batch]);
        engine.winner(&mut batches[batch], range.clone(), &self.cells)?;
        let sums = engine.accumulate(&batches[batch], range.clone(), &self.cells)?;
        let growing = self.cells.len() < target;
        let (offsets, neighbours) = self.complex.adjacency();
        self.cells = engine.adapt(&self.cells, &sums, &offsets, &neighbours, if growing { ETA } else { 0.0 })?;

        (self.batch, self.at) = (batch, range.end);
        self.training.epochs += 1;
        if growing {
            insert(&mut self.cells, &mut self.complex, &sums, target);
            if self.training.epochs.is_multiple_of(3) {
                self.training.deleted += delete_starved(&mut self.cells, &mut self.complex, &sums);
            }
        } else {
            self.lloyd += 1;
        }
        debug_assert_eq!(self.complex.check(), Ok(()));
        // Deletion and insertion may keep each other busy: then what there is will do.
        self.done = self.lloyd == LLOYD || self.training.epochs > 200;
        Ok(())
    }
}

/// Splits the longest edge of the cells with the highest resource, at most doubling the network.
fn insert(cells: &mut Vec<Feature>, complex: &mut Complex, sums: &[CellSums], target: usize) {
    let mut order: Vec<usize> = (0..sums.len()).filter(|&c| sums[c].distortion.units() > 0).collect();
    order.sort_by_key(|&c| (std::cmp::Reverse(sums[c].distortion.units()), c));
    for c in order.into_iter().take(target - cells.len()) {
        let q = c as u32;
        let Some(f) = complex.neighbours(q).into_iter().max_by(|&a, &b| {
            distance2(&cells[c], &cells[a as usize]).total_cmp(&distance2(&cells[c], &cells[b as usize])).then(b.cmp(&a))
        }) else {
            continue;
        };
        complex.split(q, f);
        cells.push(middle(&cells[c], &cells[f as usize]));
    }
}

/// Deletes cells that won too few rays; cells inserted since are spared. Returns how many went.
fn delete_starved(cells: &mut Vec<Feature>, complex: &mut Complex, sums: &[CellSums]) -> u32 {
    let total: i64 = sums.iter().map(|s| s.count.units()).sum();
    let least = STARVED * total as f64 / sums.len() as f64;
    let doomed: Vec<bool> = (0..cells.len()).map(|c| c < sums.len() && (sums[c].count.units() as f64) < least).collect();
    let before = cells.len();
    if doomed.contains(&true)
        && let Some(map) = complex.delete(&doomed)
    {
        *cells = cells.iter().zip(&map).filter(|(_, m)| m.is_some()).map(|(c, _)| *c).collect();
    }
    (before - cells.len()) as u32
}
