//! Pass `accumulate`: what the rays of a training epoch leave in their cells. Twin: [`crate::twin::accumulate`].

use super::params;
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{CellSums, Point};
use crate::twin::winner::Feature;
use std::ops::Range;

params!(
    /// Parameters of `wgsl/accumulate.wgsl`.
    {
        /// First directed ray.
        start: u32,
        /// Padding.
        pad0: u32,
    }
);

pub(super) const KERNEL: Kernel =
    Kernel::new("accumulate", &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Write]);

/// Sums features, squared distances and counts by winner, over the directed rays of a range.
pub fn accumulate(
    gpu: &Gpu,
    points: &GpuVec<Point>,
    features: &GpuVec<Feature>,
    winners: &GpuVec<u32>,
    range: Range<usize>,
    cells: &GpuVec<Feature>,
) -> Result<GpuVec<CellSums>> {
    let sums = gpu.alloc("cell sums", cells.len())?;
    let params = Params { start: range.start as u32, ..Params::default() };
    let buffers = [points.buffer(), features.buffer(), winners.buffer(), cells.buffer(), sums.buffer()];
    gpu.run(&KERNEL, &params, &buffers, range.len(), LIGHT)?;
    Ok(sums)
}
