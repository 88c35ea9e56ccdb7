//! Pass `feature`: directed rays as points of ray space. Twin: [`crate::twin::winner::feature`].

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::Point;
use crate::twin::winner::{Feature, Metric};

params!(
    /// Parameters of `wgsl/feature.wgsl`.
    {
        /// 1/L, per local length.
        inv_unit: f32,
        /// Weight of normals.
        lambda: f32,
        /// Weight of the emitter end's brightness.
        mu: f32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
        /// Padding.
        pad2: u32,
    }
);

pub(super) const KERNEL: Kernel = Kernel::new("feature", &[Access::Scene, Access::Read, Access::Read, Access::Write]);

/// The features of directed rays; `brightness` holds B/B_rms of each tile.
pub fn feature(
    gpu: &Gpu,
    scene: &SceneBuffers,
    metric: Metric,
    brightness: &GpuVec<f32>,
    points: &GpuVec<Point>,
) -> Result<GpuVec<Feature>> {
    let features = gpu.alloc("features", points.len())?;
    let params = Params { inv_unit: metric.inv_unit, lambda: metric.lambda, mu: metric.mu, ..Params::default() };
    let buffers = [scene.tris.bound(), points.bound(), brightness.bound(), features.bound()];
    gpu.run(&scene.reader(KERNEL), &params, &buffers, points.len(), LIGHT)?;
    Ok(features)
}
