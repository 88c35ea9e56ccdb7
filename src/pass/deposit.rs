//! Pass `deposit`: what rays bring to the nodes from emitter ends whose light is known. Twin: [`crate::twin::deposit`].

use super::coefficients::Rays;
use super::{SceneBuffers, SurfaceBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::{DirectSum, NodeSource};

params!(
    /// Parameters of `wgsl/deposit.wgsl`.
    {
        /// 1: the network's light at the ends is known.
        lit: u32,
        /// What weights are multiplied by.
        normalise: f32,
    }
);

const KERNEL: Kernel = Kernel {
    name: "deposit",
    buffers: &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write],
};

/// Adds what one batch of rays brings to `sums`; `light` is the network's irradiance at their ends, where known.
pub fn deposit(
    gpu: &Gpu,
    scene: &SceneBuffers,
    surface: &SurfaceBuffers,
    rays: Rays,
    light: Option<&GpuVec<[f32; 4]>>,
    normalise: f32,
    sums: &GpuVec<NodeSource>,
) -> Result<()> {
    let no_direct = gpu.alloc::<DirectSum>("no direct light", 0)?;
    let no_light = gpu.alloc("no light", 0)?;
    let params = Params { lit: light.is_some() as u32, normalise, ..Params::default() };
    let buffers = [
        rays.points.buffer(),
        rays.psi.buffer(),
        scene.tris.buffer(),
        scene.materials.buffer(),
        rays.direct.unwrap_or(&no_direct).buffer(),
        light.unwrap_or(&no_light).buffer(),
        surface.nodes.buffer(),
        sums.buffer(),
    ];
    gpu.run(&KERNEL, &params, &buffers, rays.points.len(), HEAVY)
}
