//! Pass `jacobi`: sweeps of the iteration. Twin: [`crate::twin::jacobi`].
//!
//! Two kernels: `beta` finds what each cell sends, `update` what arrives at each node.

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{Link, NodeLight, Plane};
use crate::twin::jacobi::System;

/// Sweeps in a submission, at most.
const SWEEPS: usize = 32;
/// Links that a submission reads, at most: what keeps it short.
const LINKS: usize = 1 << 24;

params!(
    /// Parameters of `wgsl/beta.wgsl` and `wgsl/update.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Padding.
        pad0: u32,
    }
);

pub(super) const BETA: Kernel = Kernel::new(
    "beta",
    &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write],
);
pub(super) const UPDATE: Kernel =
    Kernel::new("update", &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write]);

/// A linear system on the device.
#[derive(Clone, Debug)]
pub struct SystemBuffers {
    cell_offsets: GpuVec<u32>,
    cell_links: GpuVec<Link>,
    source: GpuVec<[f32; 4]>,
    node_offsets: GpuVec<u32>,
    node_links: GpuVec<Link>,
    planes: GpuVec<Plane>,
    known: GpuVec<NodeLight>,
    beta: GpuVec<[f32; 4]>,
}

impl SystemBuffers {
    /// Uploads a system.
    pub fn new(gpu: &Gpu, system: &System) -> Result<SystemBuffers> {
        Ok(SystemBuffers {
            cell_offsets: gpu.upload("cell offsets", &system.cell_offsets)?,
            cell_links: gpu.upload("cell links", &system.cell_links)?,
            source: gpu.upload("source", &system.source)?,
            node_offsets: gpu.upload("node offsets", &system.node_offsets)?,
            node_links: gpu.upload("node links", &system.node_links)?,
            planes: gpu.upload("planes", &system.planes)?,
            known: gpu.upload("known light", &system.node_source)?,
            beta: gpu.alloc("beta", system.source.len())?,
        })
    }
}

/// Sweeps `light` in place.
pub fn jacobi(gpu: &Gpu, scene: &SceneBuffers, system: &SystemBuffers, light: &GpuVec<NodeLight>, sweeps: u32) -> Result<()> {
    let beta = [
        system.cell_offsets.buffer(),
        system.cell_links.buffer(),
        system.source.buffer(),
        system.planes.buffer(),
        scene.materials.buffer(),
        light.buffer(),
        system.beta.buffer(),
        gpu.status(),
    ];
    let update = [
        system.node_offsets.buffer(),
        system.node_links.buffer(),
        system.planes.buffer(),
        system.known.buffer(),
        system.beta.buffer(),
        light.buffer(),
        gpu.status(),
    ];
    let params = |kernel| Params { flag: gpu.flag(kernel), ..Params::default() };
    let beta = gpu.prepare(&BETA, &params(&BETA), &beta, system.source.len(), LIGHT)?;
    let update = gpu.prepare(&UPDATE, &params(&UPDATE), &update, system.planes.len(), LIGHT)?;
    let links = system.cell_links.len() + system.node_links.len();
    let most = (LINKS / links.max(1)).clamp(1, SWEEPS);
    let mut left = sweeps as usize;
    while left > 0 {
        let now = left.min(most);
        gpu.run_jobs(&[&beta, &update], now)?;
        left -= now;
    }
    Ok(())
}
