//! Training of the cells: epochs of winner, accumulate and adapt on the engine; insertion and deletion here.

use super::complex::Complex;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{CellSums, FEATURE_DIM};
use crate::progress::{Event, Progress};
use crate::twin::winner::Feature;

/// Rays an epoch shows each cell.
const RAYS_PER_CELL: usize = 16;
/// How strongly neighbours draw a cell while the network grows.
const ETA: f32 = 0.05;
/// Epochs of pure Lloyd iteration at the end.
const LLOYD: usize = 3;
/// Cells with fewer rays than this share of the mean are starved.
const STARVED: f64 = 0.05;

/// What training did, for the report.
#[derive(Clone, Copy, Debug, Default)]
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

/// Grows a network to `target` cells on the features of `batches`, which hold `lengths` directed rays. Epochs walk through the batches in turn, so that they see fresh rays as long as there are any.
/// Returns the cells and what was done.
pub fn grow<E: Engine>(
    engine: &mut E,
    batches: &mut [E::Batch],
    lengths: &[usize],
    target: usize,
    progress: &mut Progress,
) -> Result<(Vec<Feature>, Training)> {
    let mut training = Training::default();

    // Start from three rays that count, far enough apart to span a triangle.
    let mut cells: Vec<Feature> = Vec::new();
    let sample = engine.features(&batches[0], 0..lengths[0].min(4096))?;
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
    let mut complex = Complex::triangle();

    let (mut batch, mut at) = (0, 0);
    let mut lloyd = 0;
    loop {
        // Show the cells their share of rays.
        let share = (RAYS_PER_CELL * cells.len() * 2).max(512);
        if at + share.min(lengths[batch]) > lengths[batch] {
            (batch, at) = ((batch + 1) % batches.len(), 0);
        }
        let want = share.min(lengths[batch]);
        let range = at..at + want;
        at += want;
        engine.winner(&mut batches[batch], range.clone(), &cells)?;
        let sums = engine.accumulate(&batches[batch], range, &cells)?;
        let growing = cells.len() < target;
        let (offsets, neighbours) = complex.adjacency();
        cells = engine.adapt(&cells, &sums, &offsets, &neighbours, if growing { ETA } else { 0.0 })?;
        training.epochs += 1;
        progress.event(Event::Cells { count: cells.len() as u64 })?;
        if growing {
            insert(&mut cells, &mut complex, &sums, target);
            if training.epochs.is_multiple_of(3) {
                training.deleted += delete_starved(&mut cells, &mut complex, &sums);
            }
        } else {
            lloyd += 1;
            if lloyd == LLOYD {
                break;
            }
        }
        debug_assert_eq!(complex.check(), Ok(()));
        if training.epochs > 200 {
            break; // Deletion and insertion keep each other busy: what there is will do.
        }
    }
    Ok((cells, training))
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
