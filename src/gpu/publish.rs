//! Results for the host's own passes.

use super::work::Work;
use super::{Gpu, buffer};
use crate::error::{Error, Result};

/// Bytes of a row of texels are a multiple of this in a copy.
const ROW: usize = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize;

#[doc(hidden)]
impl Gpu {
    /// A buffer of texels that vertex and storage bindings may read. Errors: [`Error::Limit`], [`Error::Device`].
    pub(crate) fn publish(&self, label: &'static str, texels: &[[f32; 4]]) -> Result<wgpu::Buffer> {
        use wgpu::BufferUsages as Usage;
        self.filled(label, bytemuck::cast_slice(texels), Usage::STORAGE | Usage::VERTEX | Usage::COPY_SRC)
    }

    /// A texture of rows of `width` texels. Errors: [`Error::Limit`] where it is too large, [`Error::Device`].
    pub(crate) fn texture(&self, label: &'static str, width: u32, texels: &[[f32; 4]]) -> Result<wgpu::Texture> {
        let height = texels.len() as u32 / width.max(1);
        let most = self.device.limits().max_texture_dimension_2d;
        if width.max(height) > most {
            return Err(Error::Limit {
                what: format!("texture '{label}'"),
                limit: "max_texture_dimension_2d",
                need: width.max(height).into(),
                have: most.into(),
                cure: "ask for a smaller picture",
            });
        }
        // Rows are padded for the copy.
        let row = width as usize * size_of::<[f32; 4]>();
        let stride = row.next_multiple_of(ROW);
        let mut bytes = vec![0u8; stride * height as usize];
        for (to, from) in bytes.chunks_exact_mut(stride).zip(texels.chunks_exact(width as usize)) {
            to[..row].copy_from_slice(bytemuck::cast_slice(from));
        }
        let from = self.filled(label, &bytes, wgpu::BufferUsages::COPY_SRC)?;
        let texture = self.scoped(
            || format!("allocating texture '{label}'"),
            || {
                self.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(&format!("raycell.{label}")),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::Rgba32Float,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                })
            },
        )?;
        let (at, size) = (wgpu::Origin3d::ZERO, texture.size());
        let work = Work::Fill { from, bytes_per_row: stride as u32, to: texture.clone(), at, size };
        self.hand(|| format!("filling texture '{label}'"), work)?;
        Ok(texture)
    }

    /// A buffer with contents.
    fn filled(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> Result<wgpu::Buffer> {
        let (need, have) = (bytes.len() as u64, self.device.limits().max_buffer_size);
        if need > have {
            return Err(Error::Limit {
                what: format!("buffer '{label}'"),
                limit: "max_buffer_size",
                need,
                have,
                cure: "split the scene, or use a device with larger buffers",
            });
        }
        buffer::make(&self.device, label, need.max(4), usage, Some(bytes))
    }
}
