//! Pass `winner`: the best-matching cell of each feature. Twin: [`crate::twin::winner::winner`].

use super::params;
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel};
use crate::twin::winner::Feature;
use std::ops::Range;

/// Features an invocation serves.
const QUERIES: usize = 8;
/// Most cells in a dispatch: the loop budget.
const CELLS: usize = 16_384;
/// Distances in a dispatch, about: what keeps it short.
const WORK: usize = 1 << 28;

params!(
    /// Parameters of `wgsl/winner.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// First feature.
        start: u32,
        /// Features from there.
        features: u32,
        /// First cell of the dispatch.
        first: u32,
        /// End of its cells.
        end: u32,
        /// Padding.
        pad0: u32,
    }
);

const KERNEL: Kernel =
    Kernel { name: "winner", buffers: &[Access::Read, Access::Read, Access::Write, Access::Write, Access::Write] };

/// Writes the cell nearest to each feature of a range, ties to the lowest index, into the same range of
/// `winners`; [`crate::layout::NONE`] where there is no cell.
pub fn winner(
    gpu: &Gpu,
    features: &GpuVec<Feature>,
    range: Range<usize>,
    cells: &GpuVec<Feature>,
    winners: &GpuVec<u32>,
) -> Result<()> {
    // The best distances so far travel from one block of cells to the next.
    let distances = gpu.alloc::<f32>("distances", range.len())?;
    let buffers = [features.buffer(), cells.buffer(), winners.buffer(), distances.buffer(), gpu.status()];
    let mut first = 0;
    loop {
        let end = (first + CELLS).min(cells.len());
        let params = Params {
            flag: gpu.flag(&KERNEL),
            start: range.start as u32,
            features: range.len() as u32,
            first: first as u32,
            end: end as u32,
            ..Params::default()
        };
        let chunk = WORK / (QUERIES * (end - first).max(1));
        gpu.run(&KERNEL, &params, &buffers, range.len().div_ceil(QUERIES), chunk as u32)?;
        first = end;
        if first == cells.len() {
            return Ok(());
        }
    }
}
