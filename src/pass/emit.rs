//! Pass `emit`: start points by importance, cosine directions, first hits. Twin: [`crate::twin::emit`].

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
        /// Padding.
        pad0: u32,
    }
);

const KERNEL: Kernel =
    Kernel { name: "emit", buffers: &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write] };

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
    let params = Params { flag: gpu.flag(&KERNEL), seed, first, total, tiles: tiles.len() as u32, ..Params::default() };
    let buffers =
        [scene.nodes.buffer(), scene.tris.buffer(), tiles.buffer(), scene.tile_tri.buffer(), points.buffer(), gpu.status()];
    gpu.run(&KERNEL, &params, &buffers, count as usize, HEAVY)?;
    Ok(points)
}
