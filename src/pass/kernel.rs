//! Pass `kernel`: G V on a batch of point pairs, for library users, form factors and baselines. Twin: [`crate::twin::kernel`].

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::Point;

params!(
    /// Parameters of `wgsl/kernel.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Padding.
        pad0: u32,
    }
);

pub(super) const KERNEL: Kernel =
    Kernel::new("kernel", &[Access::Scene, Access::Scene, Access::Read, Access::Write, Access::Write, Access::Texels]);

/// G(x, y) V(x, y) of consecutive pairs of surface points, per local area.
pub fn kernel(gpu: &Gpu, scene: &SceneBuffers, points: &GpuVec<Point>) -> Result<GpuVec<f32>> {
    let pairs = points.len() / 2;
    let values = gpu.alloc("values", pairs)?;
    let params = Params { flag: gpu.flag(&KERNEL), ..Params::default() };
    let buffers = [scene.nodes.bound(), scene.tris.bound(), points.bound(), values.bound(), gpu.status().into(), scene.texels()];
    gpu.run(&scene.kernel(KERNEL), &params, &buffers, pairs, HEAVY)?;
    Ok(values)
}
