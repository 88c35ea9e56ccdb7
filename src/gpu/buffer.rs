//! Typed buffers on the device.

use super::Gpu;
use crate::error::{Error, Result};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Fewest bytes allocated; and never less than an element, so that an empty vector still binds.
const MIN_BYTES: u64 = 16;

/// A vector on the device. Cloning clones the handle, not the data.
#[derive(Clone, Debug)]
pub struct GpuVec<T> {
    buffer: wgpu::Buffer,
    len: usize,
    label: &'static str,
    of: PhantomData<T>,
    /// Counts the bytes as long as any clone lives.
    _held: Arc<Held>,
}

/// Bytes that count in [`Gpu::device_bytes`] while this lives.
#[derive(Debug)]
struct Held {
    bytes: u64,
    total: Arc<AtomicU64>,
}

impl Drop for Held {
    fn drop(&mut self) {
        self.total.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl<T> GpuVec<T> {
    /// Elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// What it holds, for messages.
    pub fn label(&self) -> &'static str {
        self.label
    }

    /// The buffer, to bind. It may be longer than the vector: kernels take lengths from their parameters.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

impl<T: Pod> GpuVec<T> {
    /// See [`Gpu::alloc`].
    pub(super) fn allocate(device: &wgpu::Device, total: &Arc<AtomicU64>, label: &'static str, len: usize) -> Result<GpuVec<T>> {
        let too_large = |limit, need, have| Error::Limit {
            what: format!("buffer '{label}' of {len} elements"),
            limit,
            need,
            have,
            cure: "use fewer rays, cells or nodes, or a device with larger buffers",
        };
        let limits = device.limits();
        let need = (len as u64).saturating_mul(size_of::<T>() as u64);
        if need > limits.max_storage_buffer_binding_size {
            return Err(too_large("max_storage_buffer_binding_size", need, limits.max_storage_buffer_binding_size));
        }
        if need > limits.max_buffer_size {
            return Err(too_large("max_buffer_size", need, limits.max_buffer_size));
        }
        let name = format!("raycell.{label}");
        let buffer = super::scoped(
            device,
            || format!("allocating {need} bytes for '{label}'"),
            || {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(&name),
                    size: need.next_multiple_of(4).max(MIN_BYTES).max(size_of::<T>() as u64),
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            },
        )?;
        total.fetch_add(buffer.size(), Ordering::Relaxed);
        let held = Arc::new(Held { bytes: buffer.size(), total: total.clone() });
        Ok(GpuVec { buffer, len, label, of: PhantomData, _held: held })
    }
}

#[doc(hidden)]
impl Gpu {
    /// Bytes that vectors hold on the device now.
    pub fn device_bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// A vector of `len` zeroed elements.
    ///
    /// Errors: [`Error::Limit`] where it exceeds the device's binding or buffer size, [`Error::OutOfMemory`] where memory is short.
    pub fn alloc<T: Pod>(&self, label: &'static str, len: usize) -> Result<GpuVec<T>> {
        GpuVec::allocate(&self.device, &self.bytes, label, len)
    }

    /// A vector with the contents of a slice. Errors: those of [`Gpu::alloc`].
    pub fn upload<T: Pod>(&self, label: &'static str, data: &[T]) -> Result<GpuVec<T>> {
        let vec = self.alloc(label, data.len())?;
        self.write(&vec, 0, data)?;
        Ok(vec)
    }

    /// Overwrites elements from `start`.
    ///
    /// Errors: [`Error::Limit`] where the slice does not fit, [`Error::Device`].
    pub fn write<T: Pod>(&self, vec: &GpuVec<T>, start: usize, data: &[T]) -> Result<()> {
        if start + data.len() > vec.len {
            return Err(Error::Limit {
                what: format!("a write to buffer '{}'", vec.label),
                limit: "length",
                need: (start + data.len()) as u64,
                have: vec.len as u64,
                cure: "this is a mistake in raycell: please report it",
            });
        }
        if data.is_empty() {
            return Ok(());
        }
        self.scoped(
            || format!("uploading '{}'", vec.label),
            || self.queue.write_buffer(&vec.buffer, (start * size_of::<T>()) as u64, bytemuck::cast_slice(data)),
        )
    }

    /// Fills a vector with zero bits.
    pub fn clear<T: Pod>(&self, vec: &GpuVec<T>) -> Result<()> {
        self.scoped(
            || format!("clearing '{}'", vec.label),
            || {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                encoder.clear_buffer(&vec.buffer, 0, None);
                self.queue.submit([encoder.finish()]);
            },
        )
    }

    /// Copies `len` elements between vectors. Errors: [`Error::Device`] where a range does not fit.
    pub fn copy<T: Pod>(&self, from: &GpuVec<T>, start: usize, to: &GpuVec<T>, at: usize, len: usize) -> Result<()> {
        if len == 0 {
            return Ok(());
        }
        let bytes = |n: usize| (n * size_of::<T>()) as u64;
        self.scoped(
            || format!("copying '{}' to '{}'", from.label, to.label),
            || {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                encoder.copy_buffer_to_buffer(&from.buffer, bytes(start), &to.buffer, bytes(at), Some(bytes(len)));
                self.queue.submit([encoder.finish()]);
            },
        )
    }
}
