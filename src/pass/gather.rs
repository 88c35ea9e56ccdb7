//! Pass `gather`: the mean over a point's cosine rays of what their hits reflect. Twin: [`crate::twin::gather`].

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{DirectSum, Point};
use crate::twin::gather::Gathered;

/// Most hits of a point in a dispatch: the loop budget.
const HITS: u32 = 8192;

params!(
    /// Parameters of `wgsl/gather.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Consecutive hits a point.
        rays: u32,
        /// First hit of the dispatch, of each point.
        first: u32,
        /// End of its hits.
        end: u32,
        /// 1: the hits' irradiance is known.
        lit: u32,
        /// 1: so is their direct light.
        exact: u32,
    }
);

pub(super) const KERNEL: Kernel = Kernel::new(
    "gather",
    &[Access::Scene, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write, Access::Texels],
);

/// Averages `rays` consecutive hits a point: irradiance and nearness, then the shares of front and of
/// back hits, two vectors a point ([`decode`] names them).
pub fn gather(
    gpu: &Gpu,
    scene: &SceneBuffers,
    hits: &GpuVec<Point>,
    light: Option<&GpuVec<[f32; 4]>>,
    direct: Option<&GpuVec<DirectSum>>,
    rays: u32,
) -> Result<GpuVec<[f32; 4]>> {
    let points = hits.len() / rays as usize;
    let gathered = gpu.alloc("gathered", 2 * points)?;
    let no_light = gpu.alloc("no light", 0)?;
    let no_direct = gpu.alloc("no direct light", 0)?;
    let buffers = [
        scene.tris.bound(),
        scene.materials.bound(),
        hits.bound(),
        light.unwrap_or(&no_light).bound(),
        direct.unwrap_or(&no_direct).bound(),
        gathered.bound(),
        gpu.status().into(),
        scene.texels(),
    ];
    let mut first = 0;
    while first < rays {
        let end = (first + HITS).min(rays);
        let (lit, exact) = (light.is_some() as u32, direct.is_some() as u32);
        let params = Params { flag: gpu.flag(&KERNEL), rays, first, end, lit, exact, ..Params::default() };
        gpu.run(&scene.summing(KERNEL), &params, &buffers, points, LIGHT / (end - first))?;
        first = end;
    }
    Ok(gathered)
}

/// The results of [`gather`] by name.
pub fn decode(gathered: &[[f32; 4]]) -> Vec<Gathered> {
    gathered
        .chunks_exact(2)
        .map(|v| {
            let [[r, g, b, nearness], [front, back, square, _]] = [v[0], v[1]];
            Gathered { irradiance: [r, g, b], square, nearness, front, back }
        })
        .collect()
}
