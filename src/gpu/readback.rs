//! Results back to the host. The only file that waits for the device.

use super::{Gpu, GpuVec, failure};
use crate::error::Result;
use bytemuck::Pod;
use std::sync::mpsc;

/// How long a callback may take once the work is done.
const CALLBACK: std::time::Duration = std::time::Duration::from_secs(10);

#[doc(hidden)]
impl Gpu {
    /// Waits until all submitted work is done.
    pub fn wait(&self) -> Result<()> {
        match self.device.poll(wgpu::PollType::wait_indefinitely()) {
            Ok(_) => Ok(()),
            Err(e) => Err(failure::or_lost(&self.device, "waiting".into(), e.to_string())),
        }
    }

    /// The contents of a vector; waits for all that was submitted before.
    pub fn read<T: Pod>(&self, vec: &GpuVec<T>) -> Result<Vec<T>> {
        self.read_range(vec, 0, vec.len())
    }

    /// `len` elements of a vector from `start`; waits for all that was submitted before.
    pub fn read_range<T: Pod>(&self, vec: &GpuVec<T>, start: usize, len: usize) -> Result<Vec<T>> {
        if len == 0 {
            return Ok(Vec::new());
        }
        let stage = || format!("reading '{}' back", vec.label());
        let fail = |why: String| failure::or_lost(&self.device, stage(), why);
        // Copies go in units of four bytes.
        let bytes = len * size_of::<T>();
        let padded = bytes.next_multiple_of(4) as u64;
        let staging = self.scoped(stage, || {
            let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("raycell.staging"),
                size: padded,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let mut encoder = self.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(vec.buffer(), (start * size_of::<T>()) as u64, &staging, 0, Some(padded));
            self.queue.submit([encoder.finish()]);
            staging
        })?;

        // Map, wait, and hear from the callback what came of it.
        let (send, receive) = mpsc::channel();
        self.scoped(stage, || {
            staging.map_async(wgpu::MapMode::Read, .., move |result| {
                // The receiver is gone only when this function has already failed.
                let _ = send.send(result);
            })
        })?;
        self.wait()?;
        // Where several threads share the device, another's wait may be the one that is calling back.
        match receive.recv_timeout(CALLBACK) {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(fail(e.to_string())),
            Err(_) => return Err(fail("the device was lost".into())),
        }
        let view = staging.get_mapped_range(..).map_err(|e| fail(e.to_string()))?;
        let mut out = vec![T::zeroed(); len];
        bytemuck::cast_slice_mut::<T, u8>(&mut out).copy_from_slice(&view[..bytes]);
        Ok(out)
    }
}
