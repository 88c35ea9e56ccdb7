//! Pass `deposit`: what rays bring to the nodes from emitter ends whose light is known. Twin: [`crate::twin::deposit`].

use super::{SceneBuffers, SurfaceBuffers};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{DirectSum, NodeSource, Point, Psi};

/// Parameters of `wgsl/deposit.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Params {
    /// First item.
    pub base: u32,
    /// Items in the dispatch.
    pub count: u32,
    /// 1: H is known at every point.
    pub lit: u32,
    /// What weights are multiplied by.
    pub normalise: f32,
}

pub(super) const KERNEL: Kernel = Kernel::new(
    "deposit",
    &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write],
);

/// Adds one batch to `sums`, one a node; see [`crate::twin::deposit::deposit`].
pub fn deposit(
    gpu: &Gpu,
    scene: &SceneBuffers,
    surface: &SurfaceBuffers,
    points: &GpuVec<Point>,
    psi: &GpuVec<Psi>,
    direct: &GpuVec<DirectSum>,
    light: Option<&GpuVec<[f32; 4]>>,
    normalise: f32,
    sums: &GpuVec<NodeSource>,
) -> Result<()> {
    let dark = gpu.alloc("no light", 0)?;
    let params = Params { lit: light.is_some() as u32, normalise, ..Params::default() };
    let buffers = [
        points.buffer(),
        psi.buffer(),
        surface.nodes.buffer(),
        scene.tris.buffer(),
        scene.materials.buffer(),
        direct.buffer(),
        light.unwrap_or(&dark).buffer(),
        sums.buffer(),
    ];
    gpu.run(&KERNEL, &params, &buffers, points.len(), LIGHT)
}
