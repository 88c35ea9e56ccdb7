//! Pass `accumulate`: what the rays of a training epoch leave in their cells.

use super::fixed::{FEATURE_UNIT, encode};
use super::winner::Feature;
use crate::layout::{CellSums, FEATURE_DIM, NONE, Point, kind};

/// Sums features, squared distances and counts by winner, over directed rays that count both ways.
pub fn accumulate(points: &[Point], features: &[Feature], winners: &[u32], cells: &[Feature]) -> Vec<CellSums> {
    let mut sums = vec![CellSums::default(); cells.len()];
    for (d, f) in features.iter().enumerate() {
        if points[d].kind != kind::FRONT || winners[d] == NONE {
            continue;
        }
        let cell = &cells[winners[d] as usize];
        let s = &mut sums[winners[d] as usize];
        let mut distance = 0.0;
        for k in 0..FEATURE_DIM {
            s.feature[k].add(encode(f[k], FEATURE_UNIT));
            let e = f[k] - cell[k];
            distance += e * e;
        }
        s.distortion.add(encode(distance, FEATURE_UNIT));
        s.count.add(1);
    }
    sums
}
