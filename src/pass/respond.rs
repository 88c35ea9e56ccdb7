//! Pass `respond`: the output of a supervised network, and what its errors leave in the cells. Twin:
//! [`crate::twin::respond`].

use super::params;
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{ResponseSums, Sample};
use crate::twin::respond::Net;
use crate::twin::winner::Feature;

params!(
    /// Parameters of `wgsl/respond.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// 1 where the best-matching cell answers alone, by its plane.
        linear: u32,
        /// Where the neighbours' lists begin.
        rows: u32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
        /// Padding.
        pad2: u32,
    }
);

pub(super) const KERNEL: Kernel = Kernel::new(
    "respond",
    &[Access::Read, Access::Write, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write],
);

/// Sets the samples' outputs and sums what they leave in the cells.
pub fn respond(gpu: &Gpu, net: Net, inputs: &GpuVec<Feature>, samples: &GpuVec<Sample>) -> Result<GpuVec<ResponseSums>> {
    let sums = gpu.alloc("response sums", net.cells.len())?;
    let cells = gpu.upload("cells", net.cells)?;
    let outputs = gpu.upload("outputs", net.outputs)?;
    let graph = gpu.upload("graph", &[net.offsets, net.neighbours].concat())?;
    let params =
        Params { flag: gpu.flag(&KERNEL), linear: net.linear as u32, rows: net.offsets.len() as u32, ..Params::default() };
    let buffers =
        [inputs.buffer(), samples.buffer(), cells.buffer(), outputs.buffer(), graph.buffer(), sums.buffer(), gpu.status()];
    gpu.run(&KERNEL, &params, &buffers, inputs.len(), LIGHT)?;
    Ok(sums)
}
