//! Results back to the host. The only file that waits for the device.

use super::work::{Route, Work};
use super::{Gpu, GpuVec, failure};
use crate::error::Result;
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::mpsc;

/// How long a callback may take once the work is done.
const CALLBACK: std::time::Duration = std::time::Duration::from_secs(10);

/// Contents that are on their way to the host.
#[must_use]
#[doc(hidden)]
pub struct Pending<T> {
    label: &'static str,
    staging: Option<wgpu::Buffer>,
    arrived: mpsc::Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    len: usize,
    of: PhantomData<T>,
}

#[doc(hidden)]
impl Gpu {
    /// Waits until all work handed over so far is done.
    pub fn wait(&self) -> Result<()> {
        match &self.route {
            Route::Queue(_) => self.poll(),
            // A frame's mapping comes after all before it.
            Route::Host(_) => self.read_range(&self.status, 0, 1).map(drop),
        }
    }

    fn poll(&self) -> Result<()> {
        match self.device.poll(wgpu::PollType::wait_indefinitely()) {
            Ok(_) => Ok(()),
            Err(e) => Err(failure::or_lost(&self.device, "waiting".into(), e.to_string())),
        }
    }

    /// The contents of a vector; waits for all that was handed over before.
    pub fn read<T: Pod>(&self, vec: &GpuVec<T>) -> Result<Vec<T>> {
        self.read_range(vec, 0, vec.len())
    }

    /// `len` elements of a vector from `start`; waits for all that was handed over before.
    pub fn read_range<T: Pod>(&self, vec: &GpuVec<T>, start: usize, len: usize) -> Result<Vec<T>> {
        let pending = self.begin_read(vec, start, len)?;
        self.end_read(pending)
    }

    /// Asks for `len` elements of a vector from `start`, and does not wait.
    pub fn begin_read<T: Pod>(&self, vec: &GpuVec<T>, start: usize, len: usize) -> Result<Pending<T>> {
        let (send, arrived) = mpsc::channel();
        let mut pending = Pending { label: vec.label(), staging: None, arrived, len, of: PhantomData };
        if len == 0 {
            return Ok(pending);
        }
        let stage = || format!("reading '{}' back", vec.label());
        // Copies go in units of four bytes.
        let bytes = (len * size_of::<T>()).next_multiple_of(4) as u64;
        let staging = self.scoped(stage, || {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("raycell.staging"),
                size: bytes,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        })?;
        let start = (start * size_of::<T>()) as u64;
        self.hand(stage, Work::Copy { from: vec.buffer().clone(), start, to: staging.clone(), at: 0, bytes })?;
        let wake = self.waker();
        let then = Box::new(move |result| {
            // The receiver is gone only when its reader has already failed.
            let _ = send.send(result);
            wake();
        });
        self.hand(stage, Work::Map { staging: staging.clone(), then })?;
        pending.staging = Some(staging);
        Ok(pending)
    }

    /// Waits for what [`Gpu::begin_read`] asked for.
    pub fn end_read<T: Pod>(&self, pending: Pending<T>) -> Result<Vec<T>> {
        let Pending { label, staging, arrived, len, .. } = pending;
        let Some(staging) = staging else { return Ok(Vec::new()) };
        let fail = |why: String| failure::or_lost(&self.device, format!("reading '{label}' back"), why);
        let result = match &self.route {
            Route::Queue(_) => {
                self.poll()?;
                // Where several threads share the device, another's wait may be the one that is calling back.
                arrived.recv_timeout(CALLBACK).map_err(|_| fail("the device was lost".into()))?
            }
            Route::Host(frames) => frames.wait_for(&arrived)?,
        };
        result.map_err(|e| fail(e.to_string()))?;
        let view = staging.get_mapped_range(..).map_err(|e| fail(e.to_string()))?;
        let mut out = vec![T::zeroed(); len];
        let bytes = len * size_of::<T>();
        bytemuck::cast_slice_mut::<T, u8>(&mut out).copy_from_slice(&view[..bytes]);
        Ok(out)
    }

    /// What a callback calls so that a waiting bake looks again.
    fn waker(&self) -> impl FnOnce() + Send + 'static {
        let frames = match &self.route {
            Route::Queue(_) => None,
            Route::Host(frames) => Some(frames.clone()),
        };
        move || {
            if let Some(frames) = frames {
                frames.wake();
            }
        }
    }
}
