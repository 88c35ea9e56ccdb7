//! Pass `adapt`: cells move to the mean of their rays, drawn by their neighbours. Twin: [`crate::twin::adapt`].

use super::params;
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::CellSums;
use crate::twin::winner::Feature;

params!(
    /// Parameters of `wgsl/adapt.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// How strongly neighbours draw; 0 is Lloyd's iteration.
        eta: f32,
    }
);

pub(super) const KERNEL: Kernel =
    Kernel::new("adapt", &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write]);

/// The cells' next places; their neighbours come in CSR form.
pub fn adapt(
    gpu: &Gpu,
    cells: &GpuVec<Feature>,
    sums: &GpuVec<CellSums>,
    offsets: &GpuVec<u32>,
    neighbours: &GpuVec<u32>,
    eta: f32,
) -> Result<GpuVec<Feature>> {
    let moved = gpu.alloc("cells", cells.len())?;
    let params = Params { flag: gpu.flag(&KERNEL), eta, ..Params::default() };
    let buffers = [cells.buffer(), sums.buffer(), offsets.buffer(), neighbours.buffer(), moved.buffer(), gpu.status()];
    gpu.run(&KERNEL, &params, &buffers, cells.len(), HEAVY)?;
    Ok(moved)
}
