//! Pass `readout`: the network's irradiance at surface points. Twin: [`crate::twin::readout`].

use super::{SurfaceBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{NodeLight, Point, Psi};

params!(
    /// Parameters of `wgsl/readout.wgsl`.
    {
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
    }
);

pub(super) const KERNEL: Kernel =
    Kernel::new("readout", &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Write]);

/// Irradiance at many points, scaled W/m²; the fourth number is unused.
pub fn readout(
    gpu: &Gpu,
    surface: &SurfaceBuffers,
    light: &GpuVec<NodeLight>,
    points: &GpuVec<Point>,
    psi: &GpuVec<Psi>,
) -> Result<GpuVec<[f32; 4]>> {
    let irradiance = gpu.alloc("irradiance", points.len())?;
    let buffers = [surface.nodes.buffer(), light.buffer(), points.buffer(), psi.buffer(), irradiance.buffer()];
    gpu.run(&KERNEL, &Params::default(), &buffers, points.len(), LIGHT)?;
    Ok(irradiance)
}
