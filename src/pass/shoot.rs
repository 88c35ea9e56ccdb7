//! Pass `shoot`: cosine rays from given points. Twin: [`crate::twin::shoot`].

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::Point;

params!(
    /// Parameters of `wgsl/shoot.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Seed; each point has a sequence of its own.
        seed: u32,
        /// First ray of each point's sequence.
        first: u32,
        /// Consecutive hits a point.
        rays: u32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
    }
);

pub(super) const KERNEL: Kernel =
    Kernel::new("shoot", &[Access::Scene, Access::Scene, Access::Read, Access::Write, Access::Write, Access::Texels]);

/// Rays `first..first + rays` of each point's own sequence, `rays` consecutive hits a point.
pub fn shoot(gpu: &Gpu, scene: &SceneBuffers, points: &GpuVec<Point>, seed: u32, first: u32, rays: u32) -> Result<GpuVec<Point>> {
    let count = points.len() * rays as usize;
    let hits = gpu.alloc("hits", count)?;
    let params = Params { flag: gpu.flag(&KERNEL), seed, first, rays, ..Params::default() };
    let buffers = [scene.nodes.bound(), scene.tris.bound(), points.bound(), hits.bound(), gpu.status().into(), scene.texels()];
    gpu.run(&scene.kernel(KERNEL), &params, &buffers, count, HEAVY)?;
    Ok(hits)
}
