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
    /// Bit 0: H is known at every point; bit 1: D is, and emitter ends send rho D, not E.
    pub known: u32,
    /// What weights are multiplied by.
    pub normalise: f32,
}

pub(super) const KERNEL: Kernel = Kernel::new(
    "deposit",
    &[
        Access::Read,
        Access::Read,
        Access::Read,
        Access::Scene,
        Access::Read,
        Access::Read,
        Access::Read,
        Access::Write,
        Access::Texels,
    ],
);

/// Adds one batch to `sums`, one a node; see [`crate::twin::deposit::deposit`].
pub fn deposit(
    gpu: &Gpu,
    scene: &SceneBuffers,
    surface: &SurfaceBuffers,
    points: &GpuVec<Point>,
    psi: &GpuVec<Psi>,
    direct: Option<&GpuVec<DirectSum>>,
    light: Option<&GpuVec<[f32; 4]>>,
    normalise: f32,
    sums: &GpuVec<NodeSource>,
) -> Result<()> {
    let dark = gpu.alloc("no light", 0)?;
    let none = gpu.alloc("no direct light", 0)?;
    let known = light.is_some() as u32 | (direct.is_some() as u32) << 1;
    let params = Params { known, normalise, ..Params::default() };
    let buffers = [
        points.bound(),
        psi.bound(),
        surface.nodes.bound(),
        scene.tris.bound(),
        scene.materials.bound(),
        direct.unwrap_or(&none).bound(),
        light.unwrap_or(&dark).bound(),
        sums.bound(),
        scene.texels(),
    ];
    gpu.run(&scene.summing(KERNEL), &params, &buffers, points.len(), LIGHT)
}
