//! Pass `emit`: start points by importance, cosine directions, first hits. Twin: [`crate::twin::emit`].
//!
//! Two kernels: `emit` shoots the rays, `probe` takes out those whose start is dead.

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::{Point, Tile};

params!(
    /// Parameters of `wgsl/emit.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Seed of the sequence.
        seed: u32,
        /// First ray of the sequence.
        first: u32,
        /// Rays that the weights are divided by.
        total: u32,
        /// Number of tiles.
        tiles: u32,
        /// Number of rays.
        rays: u32,
        /// Binary digits of a ray's place in the batch; invocations are 2^bits.
        bits: u32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
        /// Padding.
        pad2: u32,
    }
);

/// Parameters of `wgsl/probe.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ProbeParams {
    /// First item.
    pub base: u32,
    /// Items in the dispatch.
    pub count: u32,
    /// Place of the finished flag.
    pub flag: u32,
    /// Seed of the sequence.
    pub seed: u32,
    /// First ray of the sequence.
    pub first: u32,
    /// Padding.
    pub pad0: u32,
    /// Padding.
    pub pad1: u32,
    /// Padding.
    pub pad2: u32,
}

pub(super) const KERNEL: Kernel = Kernel::new(
    "emit",
    &[Access::Scene, Access::Scene, Access::Read, Access::Read, Access::Write, Access::Write, Access::Write, Access::Texels],
);
pub(super) const PROBE: Kernel =
    Kernel::new("probe", &[Access::Scene, Access::Scene, Access::Read, Access::Write, Access::Write, Access::Texels]);

/// Shoots rays `first..first + count` of the sequence; `total` divides the weights. Two points a ray.
pub fn emit(
    gpu: &Gpu,
    scene: &SceneBuffers,
    tiles: &GpuVec<Tile>,
    seed: u32,
    first: u32,
    count: u32,
    total: u32,
) -> Result<GpuVec<Point>> {
    let points = gpu.alloc("points", 2 * count as usize)?;
    let suspects = gpu.alloc::<u32>("suspects", 1 + count as usize)?;
    let bits = count.next_power_of_two().trailing_zeros().max(1);
    let params =
        Params { flag: gpu.flag(&KERNEL), seed, first, total, tiles: tiles.len() as u32, rays: count, bits, ..Params::default() };
    let buffers = [
        scene.nodes.bound(),
        scene.tris.bound(),
        tiles.bound(),
        scene.tile_tri.bound(),
        points.bound(),
        suspects.bound(),
        gpu.status().into(),
        scene.texels(),
    ];
    let invocations = if count == 0 { 0 } else { 1 << bits };
    gpu.run(&scene.kernel(KERNEL), &params, &buffers, invocations, HEAVY)?;
    let params = ProbeParams { flag: gpu.flag(&PROBE), seed, first, ..ProbeParams::default() };
    let buffers =
        [scene.nodes.bound(), scene.tris.bound(), suspects.bound(), points.bound(), gpu.status().into(), scene.texels()];
    gpu.run(&scene.kernel(PROBE), &params, &buffers, count as usize, HEAVY)?;
    Ok(points)
}
