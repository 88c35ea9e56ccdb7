//! Typed buffers on the device.

use super::Gpu;
use super::work::Work;
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

/// What a kernel's binding is given.
#[derive(Clone, Debug)]
pub enum Bound {
    /// A storage buffer.
    Buffer(wgpu::Buffer),
    /// Records as texels.
    Texels(wgpu::TextureView),
    /// Nothing: the data of an effect that the scene does not call for; no pipeline of it has the binding.
    Absent,
}

impl Bound {
    /// As a bind group takes it.
    pub(super) fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Bound::Buffer(buffer) => buffer.as_entire_binding(),
            Bound::Texels(view) => wgpu::BindingResource::TextureView(view),
            Bound::Absent => unreachable!("a kernel reads data of an effect that it was not told of"),
        }
    }
}

impl From<&wgpu::Buffer> for Bound {
    fn from(buffer: &wgpu::Buffer) -> Bound {
        Bound::Buffer(buffer.clone())
    }
}

impl From<&&wgpu::Buffer> for Bound {
    fn from(buffer: &&wgpu::Buffer) -> Bound {
        Bound::Buffer((*buffer).clone())
    }
}

impl From<&Bound> for Bound {
    fn from(bound: &Bound) -> Bound {
        bound.clone()
    }
}

/// Bytes that count in [`Gpu::device_bytes`] while this lives.
#[derive(Debug)]
pub(super) struct Held {
    bytes: u64,
    total: Arc<AtomicU64>,
}

impl Held {
    pub(super) fn new(total: &Arc<AtomicU64>, bytes: u64) -> Arc<Held> {
        total.fetch_add(bytes, Ordering::Relaxed);
        Arc::new(Held { bytes, total: total.clone() })
    }
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

    /// The same, beside bindings that may be no buffers.
    pub fn bound(&self) -> Bound {
        Bound::Buffer(self.buffer.clone())
    }
}

impl<T: Pod> GpuVec<T> {
    /// See [`Gpu::alloc`] and, where there is `data`, [`Gpu::upload`].
    pub(super) fn allocate(
        device: &wgpu::Device,
        total: &Arc<AtomicU64>,
        binding: u64,
        label: &'static str,
        len: usize,
        data: Option<&[T]>,
    ) -> Result<GpuVec<T>> {
        let too_large = |limit, need, have| Error::Limit {
            what: format!("buffer '{label}' of {len} elements"),
            limit,
            need,
            have,
            cure: "use fewer rays, cells or nodes, or a device with larger buffers",
        };
        let limits = device.limits();
        let need = (len as u64).saturating_mul(size_of::<T>() as u64);
        if need > binding {
            return Err(too_large("max_storage_buffer_binding_size", need, binding));
        }
        if need > limits.max_buffer_size {
            return Err(too_large("max_buffer_size", need, limits.max_buffer_size));
        }
        use wgpu::BufferUsages as Usage;
        let size = need.next_multiple_of(4).max(MIN_BYTES).max(size_of::<T>() as u64);
        let usage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let buffer = make(device, label, size, usage, data.map(bytemuck::cast_slice))?;
        let held = Held::new(total, buffer.size());
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
        let vec = GpuVec::allocate(&self.device, &self.bytes, self.binding, label, len, None)?;
        // wgpu would clear it within the first submission that uses it; a host's frames take it in parts.
        if self.in_frames() {
            self.clear(&vec)?;
        }
        Ok(vec)
    }

    /// A vector with the contents of a slice. Errors: those of [`Gpu::alloc`].
    pub fn upload<T: Pod>(&self, label: &'static str, data: &[T]) -> Result<GpuVec<T>> {
        GpuVec::allocate(&self.device, &self.bytes, self.binding, label, data.len(), Some(data))
    }

    /// Fills a vector with zero bits.
    pub fn clear<T: Pod>(&self, vec: &GpuVec<T>) -> Result<()> {
        self.hand(
            || format!("clearing '{}'", vec.label),
            Work::Clear { buffer: vec.buffer.clone(), start: 0, bytes: vec.buffer.size() },
        )
    }
}

/// A buffer of `size` bytes that begins with `bytes`, or holds zeros. Errors: [`Error::OutOfMemory`], [`Error::Device`].
pub(super) fn make(
    device: &wgpu::Device,
    label: &str,
    size: u64,
    usage: wgpu::BufferUsages,
    bytes: Option<&[u8]>,
) -> Result<wgpu::Buffer> {
    let name = format!("raycell.{label}");
    let mapped_at_creation = bytes.is_some();
    super::scoped(
        device,
        || format!("allocating {size} bytes for '{label}'"),
        || {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor { label: Some(&name), size, usage, mapped_at_creation });
            if let Some(bytes) = bytes {
                fill(&buffer, bytes);
            }
            buffer
        },
    )
}

/// Writes the contents of a buffer that was made mapped, and unmaps it. Where making it has failed, the
/// error scope around tells.
pub(super) fn fill(buffer: &wgpu::Buffer, bytes: &[u8]) {
    if let Ok(mut view) = buffer.get_mapped_range_mut(..) {
        view.slice(..bytes.len()).copy_from_slice(bytes);
    }
    buffer.unmap();
}
