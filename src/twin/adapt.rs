//! Pass `adapt`: cells move to the mean of their rays, drawn by their topological neighbours.

use super::fixed::FEATURE_UNIT;
use super::winner::Feature;
use crate::layout::{CellSums, FEATURE_DIM, Fixed};

/// A sum of features as f32, word by word as the kernel does it.
fn value(f: Fixed) -> f32 {
    f.hi as i32 as f32 + f.lo as f32 / FEATURE_UNIT
}

/// w_c <- (S_c + eta mean_n S_n) / (n_c + eta mean_n n_n) over the neighbours n (CSR), `eta` = 0: Lloyd.
/// Cells without a ray stay where they are.
pub fn adapt(cells: &[Feature], sums: &[CellSums], offsets: &[u32], neighbours: &[u32], eta: f32) -> Vec<Feature> {
    (0..cells.len())
        .map(|c| {
            let (start, end) = (offsets[c] as usize, offsets[c + 1] as usize);
            let share = if end > start { eta / (end - start) as f32 } else { 0.0 };
            let mut count = sums[c].count.lo as f32;
            let mut moved = [0.0; FEATURE_DIM];
            for k in 0..FEATURE_DIM {
                moved[k] = value(sums[c].feature[k]);
            }
            if share > 0.0 {
                for &n in &neighbours[start..end] {
                    count += share * sums[n as usize].count.lo as f32;
                    for k in 0..FEATURE_DIM {
                        moved[k] += share * value(sums[n as usize].feature[k]);
                    }
                }
            }
            let mut cell = cells[c];
            if count > 0.0 {
                for k in 0..FEATURE_DIM {
                    cell[k] = moved[k] / count;
                }
            }
            cell
        })
        .collect()
}
