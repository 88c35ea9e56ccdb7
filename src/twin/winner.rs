//! Passes `feature` and `winner`: a ray as a point of feature space, and its best-matching cell.

use crate::layout::{FEATURE_DIM, FEATURE_STRIDE, NONE, Point, kind};
use crate::scene::Geometry;
use rayon::prelude::*;

/// A feature or a cell centre: [`FEATURE_DIM`] numbers and zeros.
pub type Feature = [f32; FEATURE_STRIDE];

/// The metric of ray space.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// 1/L, per local length.
    pub inv_unit: f32,
    /// Weight lambda of normals.
    pub lambda: f32,
    /// Weight mu of the emitter end's brightness.
    pub mu: f32,
}

/// The features of directed rays: directed ray d runs from point d^1 to point d. `brightness` holds
/// B/B_rms of each tile. Rays that do not count both ways get zeros.
pub fn feature(geometry: &Geometry, metric: Metric, brightness: &[f32], points: &[Point]) -> Vec<Feature> {
    (0..points.len())
        .into_par_iter()
        .map(|d| {
            let (y, x) = (&points[d], &points[d ^ 1]);
            let mut f = [0.0; FEATURE_STRIDE];
            if y.kind != kind::FRONT {
                return f;
            }
            let (nx, ny) = (geometry.tris[x.tri as usize].normal, geometry.tris[y.tri as usize].normal);
            for k in 0..3 {
                f[k] = x.p[k] * metric.inv_unit;
                f[3 + k] = nx[k] * metric.lambda;
                f[6 + k] = y.p[k] * metric.inv_unit;
                f[9 + k] = ny[k] * metric.lambda;
            }
            f[12] = metric.mu * brightness[x.tile as usize].min(3.0);
            f
        })
        .collect()
}

/// The cell nearest to each feature, ties to the lowest index; [`NONE`] where there is no cell.
/// Distances are sums of squared differences, never expanded (hard case F09).
pub fn winner(features: &[Feature], cells: &[Feature]) -> Vec<u32> {
    const LANES: usize = 16;
    // Cells by component, a block of lanes at a time, so that the compiler can use vectors.
    let blocks: Vec<[[f32; LANES]; FEATURE_DIM]> = cells
        .chunks(LANES)
        .map(|chunk| std::array::from_fn(|k| std::array::from_fn(|l| chunk.get(l).map_or(f32::MAX, |c| c[k]))))
        .collect();
    features
        .par_iter()
        .map(|f| {
            let mut best = (f32::MAX, NONE);
            for (b, block) in blocks.iter().enumerate() {
                let mut d = [0.0f32; LANES];
                for k in 0..FEATURE_DIM {
                    for l in 0..LANES {
                        let e = f[k] - block[k][l];
                        d[l] += e * e;
                    }
                }
                for (l, &d) in d.iter().enumerate() {
                    if d < best.0 {
                        best = (d, (b * LANES + l) as u32);
                    }
                }
            }
            best.1
        })
        .collect()
}
