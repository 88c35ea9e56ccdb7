//! Pass `assign`: the nodes that speak for a surface point. Twin: [`crate::twin::assign`].

use super::{SceneBuffers, SurfaceBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::{Point, Psi};

params!(
    /// Parameters of `wgsl/assign.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// 1/L, per local length.
        inv_unit: f32,
        /// Weight of normals.
        lambda: f32,
        /// Where the candidates begin.
        first_list: u32,
        /// Where the starts of lists begin that tiles share; 0: each tile has its own.
        joint: u32,
        /// Padding.
        pad1: u32,
    }
);

pub(super) const KERNEL: Kernel = Kernel::new(
    "assign",
    &[
        Access::Scene,
        Access::Scene,
        Access::Read,
        Access::Read,
        Access::Read,
        Access::Read,
        Access::Write,
        Access::Write,
        Access::Texels,
    ],
);

/// The weights of many points, looked at in the order of `order`, a permutation of them.
pub fn assign(
    gpu: &Gpu,
    scene: &SceneBuffers,
    surface: &SurfaceBuffers,
    points: &GpuVec<Point>,
    order: &GpuVec<u32>,
) -> Result<GpuVec<Psi>> {
    let psi = gpu.alloc("psi", points.len())?;
    let params = Params {
        flag: gpu.flag(&KERNEL),
        inv_unit: surface.inv_unit,
        lambda: surface.lambda,
        first_list: surface.first_list,
        joint: surface.joint,
        ..Params::default()
    };
    let buffers = [
        scene.nodes.bound(),
        scene.tris.bound(),
        surface.nodes.bound(),
        surface.lists.bound(),
        points.bound(),
        order.bound(),
        psi.bound(),
        gpu.status().into(),
        scene.texels(),
    ];
    gpu.run(&scene.kernel(KERNEL), &params, &buffers, points.len(), HEAVY)?;
    Ok(psi)
}
