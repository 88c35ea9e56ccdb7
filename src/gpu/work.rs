//! What is asked of the device, piece by piece, and who hands it over: raycell's own queue at once, or
//! the host's frames in slices.

use super::frames::Frames;
use super::{Gpu, Job};
use crate::error::Result;
use std::ops::Range;
use std::sync::Arc;

/// Called once with what became of a mapping.
pub(crate) type Mapped = Box<dyn FnOnce(std::result::Result<(), wgpu::BufferAsyncError>) + Send>;

/// A piece of work, in the order in which it must be done.
pub(crate) enum Work {
    /// Bytes from one buffer to another.
    Copy { from: wgpu::Buffer, start: u64, to: wgpu::Buffer, at: u64, bytes: u64 },
    /// Rows of texels from a buffer to a texture.
    Fill { from: wgpu::Buffer, bytes_per_row: u32, to: wgpu::Texture, at: wgpu::Origin3d, size: wgpu::Extent3d },
    /// Zero bits.
    Clear { buffer: wgpu::Buffer, start: u64, bytes: u64 },
    /// Items of a job, no more than it allows a dispatch.
    Dispatch { job: Arc<Job>, items: Range<u32> },
    /// Jobs for no items at all, so that the driver's compiler runs.
    Warm { jobs: Vec<Arc<Job>> },
    /// Maps a staging buffer as soon as all before is done.
    Map { staging: wgpu::Buffer, then: Mapped },
}

impl Work {
    /// Records all of it.
    pub(super) fn record(self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) {
        match self {
            Work::Copy { from, start, to, at, bytes } => encoder.copy_buffer_to_buffer(&from, start, &to, at, Some(bytes)),
            Work::Fill { from, bytes_per_row, to, at, size } => {
                let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None };
                encoder.copy_buffer_to_texture(
                    wgpu::TexelCopyBufferInfo { buffer: &from, layout },
                    wgpu::TexelCopyTextureInfo { origin: at, ..to.as_image_copy() },
                    size,
                );
            }
            Work::Clear { buffer, start, bytes } => encoder.clear_buffer(&buffer, start, Some(bytes)),
            Work::Dispatch { job, items } => job.encode_part(device, items, &mut encoder.begin_compute_pass(&Default::default())),
            Work::Warm { jobs } => {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                jobs.iter().for_each(|job| job.encode_empty(&mut pass));
            }
            Work::Map { staging, then } => encoder.map_buffer_on_submit(&staging, wgpu::MapMode::Read, .., then),
        }
    }
}

impl Work {
    /// Bytes that it moves.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Work::Copy { bytes, .. } | Work::Clear { bytes, .. } => *bytes,
            Work::Fill { from, .. } => from.size(),
            Work::Dispatch { .. } | Work::Warm { .. } | Work::Map { .. } => 0,
        }
    }

    /// Keeps the first `most` bytes of a longer copy or clear, and returns the rest. `most` is a multiple of 4.
    pub(super) fn split(&mut self, most: u64) -> Option<Work> {
        match self {
            Work::Copy { from, start, to, at, bytes } if *bytes > most => {
                let rest = *bytes - most;
                *bytes = most;
                Some(Work::Copy { from: from.clone(), start: *start + most, to: to.clone(), at: *at + most, bytes: rest })
            }
            Work::Clear { buffer, start, bytes } if *bytes > most => {
                let rest = *bytes - most;
                *bytes = most;
                Some(Work::Clear { buffer: buffer.clone(), start: *start + most, bytes: rest })
            }
            _ => None,
        }
    }
}

/// Who hands work over to the device.
#[derive(Debug)]
pub(super) enum Route {
    /// raycell does, at once.
    Queue(wgpu::Queue),
    /// The host does, with its frames.
    Host(Arc<Frames>),
}

#[doc(hidden)]
impl Gpu {
    /// Whether work waits for a host's frames.
    pub(super) fn in_frames(&self) -> bool {
        matches!(self.route, Route::Host(_))
    }

    /// Hands work over; does not wait. Errors: those of recording it; [`crate::Error::Cancelled`] where the host is gone.
    pub(super) fn hand(&self, stage: impl Fn() -> String, work: Work) -> Result<()> {
        match &self.route {
            Route::Queue(queue) => self.submit(queue, stage, |encoder| match (work, self.times.timer()) {
                (Work::Dispatch { job, items }, Some(timer)) => {
                    let record = |pass: &mut wgpu::ComputePass| job.encode_part(&self.device, items, pass);
                    self.times.pass(timer, &self.device, encoder, job.name.into(), record);
                }
                (work, _) => work.record(&self.device, encoder),
            }),
            Route::Host(frames) => frames.push(work),
        }
    }

    /// Submits what `record` records, by itself.
    pub(super) fn submit(
        &self,
        queue: &wgpu::Queue,
        stage: impl Fn() -> String,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<()> {
        self.scoped(stage, || {
            let mut encoder = self.device.create_command_encoder(&Default::default());
            record(&mut encoder);
            queue.submit([encoder.finish()]);
        })
    }
}
