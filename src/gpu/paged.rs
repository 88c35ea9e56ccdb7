//! A scene's records beyond one binding: texels of an array texture.
//!
//! Core WebGPU binds 128 MiB of a storage buffer and eight buffers to a kernel, which a scene of two million triangles
//! exceeds. Texels bind beside the buffers, and an array of textures of the least size that WebGPU grants holds 16 GiB. A record is
//! read bit by bit (`textureLoad` of `u32`), so results are those of buffers. Only scenes that need it pay: they have another text of
//! each kernel ([`super::wgsl`]).

use super::buffer::{self, Bound, Held};
use super::work::Work;
use super::{Gpu, GpuVec};
use crate::error::{Error, Result};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::Arc;

/// Texels in a row, and rows in a layer: `ROW` in `wgsl/lib/layout.wgsl`; the least that WebGPU grants.
pub const ROW: usize = 2048;
/// Bytes of a texel.
const TEXEL: usize = 16;
/// Rows that are copied at a time: 8 MiB.
const ROWS: usize = 256;

/// How paged records are bound.
pub(super) const BINDING: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2Array,
    multisampled: false,
};

/// Records that a kernel reads: in a buffer, or paged.
#[derive(Clone, Debug)]
pub enum Records<T> {
    /// In one binding.
    Whole(GpuVec<T>),
    /// In texels.
    Paged(Pages<T>),
}

/// Records as texels, in order; each takes whole texels.
#[derive(Clone, Debug)]
pub struct Pages<T> {
    view: wgpu::TextureView,
    of: PhantomData<T>,
    _held: Arc<Held>,
}

impl<T: Pod> Records<T> {
    /// Uploads records into a buffer, or `paged`.
    ///
    /// Errors: [`Error::Limit`] where they exceed what the device holds, [`Error::OutOfMemory`], [`Error::Device`].
    pub fn upload(gpu: &Gpu, label: &'static str, records: &[T], paged: bool) -> Result<Records<T>> {
        if paged { Self::page(gpu, label, records) } else { Ok(Records::Whole(gpu.upload(label, records)?)) }
    }

    /// Uploads records as texels.
    pub(crate) fn page(gpu: &Gpu, label: &'static str, records: &[T]) -> Result<Records<T>> {
        const { assert!(size_of::<T>().is_multiple_of(TEXEL)) };
        let bytes: &[u8] = bytemuck::cast_slice(records);
        let rows = bytes.len().div_ceil(TEXEL * ROW).max(1);
        let layers = rows.div_ceil(ROW);
        let most = gpu.device.limits().max_texture_array_layers;
        if layers > most as usize {
            return Err(Error::Limit {
                what: format!("texture '{label}' of {} records", records.len()),
                limit: "max_texture_array_layers",
                need: layers as u64,
                have: most.into(),
                cure: "use fewer triangles",
            });
        }
        let size = wgpu::Extent3d { width: ROW as u32, height: rows.min(ROW) as u32, depth_or_array_layers: layers as u32 };
        let texture = gpu.scoped(
            || format!("allocating texture '{label}'"),
            || {
                gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(&format!("raycell.{label}")),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::Rgba32Uint,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                })
            },
        )?;
        for (k, part) in bytes.chunks(ROWS * ROW * TEXEL).enumerate() {
            // The last row is filled up.
            let height = part.len().div_ceil(ROW * TEXEL);
            let from = buffer::make(&gpu.device, label, (height * ROW * TEXEL) as u64, wgpu::BufferUsages::COPY_SRC, Some(part))?;
            let row = k * ROWS;
            let work = Work::Fill {
                from,
                bytes_per_row: (ROW * TEXEL) as u32,
                to: texture.clone(),
                at: wgpu::Origin3d { x: 0, y: (row % ROW) as u32, z: (row / ROW) as u32 },
                size: wgpu::Extent3d { width: ROW as u32, height: height as u32, depth_or_array_layers: 1 },
            };
            gpu.hand(|| format!("filling texture '{label}'"), work)?;
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let held = Held::new(&gpu.bytes, (rows.min(ROW) * layers * ROW * TEXEL) as u64);
        Ok(Records::Paged(Pages { view, of: PhantomData, _held: held }))
    }

    /// What a kernel binds.
    pub fn bound(&self) -> Bound {
        match self {
            Records::Whole(vec) => vec.bound(),
            Records::Paged(pages) => Bound::Texels(pages.view.clone()),
        }
    }
}

#[doc(hidden)]
impl Gpu {
    /// Whether records of so many bytes must be paged.
    pub fn must_page(&self, bytes: usize) -> bool {
        bytes as u64 > self.whole
    }
}
