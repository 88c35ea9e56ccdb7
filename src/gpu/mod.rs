//! How raycell talks to wgpu; no physics here.
//!
//! [`Gpu`] works on a device that its host owns: it never makes one, never prints, and waits only in
//! [`Gpu::read`] and [`Gpu::wait`]. [`device`] opens a device for those who have none.

#[doc(hidden)]
pub mod buffer;
pub mod device;
#[doc(hidden)]
pub mod dispatch;
mod failure;
pub(crate) mod frames;
#[doc(hidden)]
pub mod kernel;
mod pace;
#[doc(hidden)]
pub mod paged;
mod publish;
#[doc(hidden)]
pub mod readback;
#[doc(hidden)]
pub mod sentinel;
#[doc(hidden)]
pub mod specialise;
pub(crate) mod stamps;
#[doc(hidden)]
pub mod wgsl;
mod work;

#[doc(hidden)]
pub use buffer::{Bound, GpuVec};
#[doc(hidden)]
pub use dispatch::{HEAVY, Job, LIGHT};
pub use failure::Watch;
#[doc(hidden)]
pub use kernel::{Access, Constants, Kernel, Pipeline};
#[doc(hidden)]
pub use paged::Records;

use crate::error::{Error, Result};
use bytemuck::Pod;
use frames::Frames;
use pace::Paces;
use stamps::Times;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex};
use work::Route;

/// A device, its queue, and the kernels compiled for it.
#[derive(Debug)]
pub struct Gpu {
    /// The host's device.
    pub device: wgpu::Device,
    route: Route,
    kernels: Mutex<HashMap<kernel::Key, Arc<Pipeline>>>,
    times: Times,
    paces: Paces,
    /// A flag a kernel, raised where a loop did not come to its end.
    status: GpuVec<u32>,
    /// Bytes that vectors hold on the device.
    bytes: Arc<AtomicU64>,
    /// Bytes that a binding may hold.
    binding: u64,
    /// Bytes of a scene's records beyond which they are paged.
    whole: u64,
    /// Invocations in a workgroup.
    group: u32,
}

/// Storage buffers a kernel may bind.
const STORAGE_BUFFERS: u32 = 8;
/// Bytes a binding must be able to hold.
const BINDING_BYTES: u64 = 128 << 20;
/// Workgroups in a dimension.
const GROUPS: u32 = 65_535;
/// Invocations that a workgroup may have in core WebGPU.
const INVOCATIONS: u32 = 256;

impl Gpu {
    /// Features a device needs: none.
    pub fn required_features() -> wgpu::Features {
        wgpu::Features::empty()
    }

    /// Limits a device needs: those of core WebGPU that the kernels use, on top of wgpu's lowest.
    pub fn required_limits() -> wgpu::Limits {
        wgpu::Limits {
            max_storage_buffers_per_shader_stage: STORAGE_BUFFERS,
            max_storage_buffer_binding_size: BINDING_BYTES,
            max_compute_invocations_per_workgroup: INVOCATIONS,
            max_compute_workgroup_size_x: INVOCATIONS,
            max_compute_workgroups_per_dimension: GROUPS,
            ..wgpu::Limits::downlevel_defaults()
        }
    }

    /// Takes a host's device and runs the sentinel kernel on it.
    ///
    /// Errors: [`Error::Limit`] where the device was made with less than [`Gpu::required_limits`],
    /// [`Error::Unfinished`] where the driver does not do what the kernels rely on, [`Error::Device`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Gpu> {
        let gpu = Self::routed(device, Route::Queue(queue.clone()))?;
        sentinel::check(&gpu)?;
        Ok(gpu)
    }

    /// As [`Gpu::new`], for work that waits for the host's frames; the first of them compiles `kernels`.
    pub(crate) fn hosted(device: &wgpu::Device, frames: Arc<Frames>, kernels: &[Kernel]) -> Result<Gpu> {
        let gpu = Self::routed(device, Route::Host(frames))?;
        gpu.warm_up_all(kernels)?;
        sentinel::check(&gpu)?;
        Ok(gpu)
    }

    /// Refuses a device that was made with less than the kernels need.
    pub(crate) fn check_limits(device: &wgpu::Device) -> Result<()> {
        let mut lacking = None;
        Self::required_limits().check_limits_with_fail_fn(&device.limits(), true, |limit, need, have| {
            lacking = Some(Error::Limit {
                what: "raycell".into(),
                limit,
                need,
                have,
                cure: "make the device with Gpu::required_limits()",
            });
        });
        lacking.map_or(Ok(()), Err)
    }

    fn routed(device: &wgpu::Device, route: Route) -> Result<Gpu> {
        Self::check_limits(device)?;
        let device = device.clone();
        let bytes = Arc::default();
        let binding = device.limits().max_storage_buffer_binding_size;
        let status = GpuVec::allocate(&device, &bytes, binding, "status", wgsl::KERNELS.len(), None)?;
        Ok(Gpu {
            device,
            route,
            kernels: Mutex::default(),
            times: Times::default(),
            paces: Paces::default(),
            status,
            bytes,
            binding,
            whole: binding,
            group: kernel::WORKGROUP,
        })
    }

    /// The same with workgroups of another size, 32 to 256: no result may depend on it (hard case G04).
    #[doc(hidden)]
    pub fn with_group(self, group: u32) -> Gpu {
        Gpu { group, kernels: Mutex::default(), ..self }
    }

    /// The same with smaller bindings than the device has: what exceeds them is paged, or refused.
    #[doc(hidden)]
    pub fn with_bindings_of(self, bytes: u64) -> Gpu {
        let binding = bytes.min(self.binding);
        Gpu { binding, whole: binding, ..self }
    }

    /// The same with all scenes paged, whatever their size.
    #[doc(hidden)]
    pub fn with_paged_scenes(self) -> Gpu {
        Gpu { whole: 0, ..self }
    }

    /// From now on every dispatch is waited for and timed: for tests, and to see that none is long.
    #[doc(hidden)]
    pub fn measure_dispatches(&self) {
        self.paces.measure_all();
    }

    /// Seconds of each kernel's longest dispatch, of those that were timed.
    #[doc(hidden)]
    pub fn longest_dispatches(&self) -> BTreeMap<&'static str, f64> {
        self.paces.longest()
    }

    /// The buffer of finished flags, to bind as `status`.
    #[doc(hidden)]
    pub fn status(&self) -> &wgpu::Buffer {
        self.status.buffer()
    }

    /// The place of a kernel in `status`, for its `params.flag`.
    #[doc(hidden)]
    pub fn flag(&self, kernel: &Kernel) -> u32 {
        wgsl::KERNELS.iter().position(|(name, _)| *name == kernel.name).unwrap_or(0) as u32
    }

    /// Waits, and says whether all that ran came to its end. Call it before results are trusted.
    ///
    /// Errors: [`Error::Unfinished`] naming the kernel, [`Error::Device`].
    #[doc(hidden)]
    pub fn check_finished(&self) -> Result<()> {
        self.judge(&self.read(&self.status)?)
    }

    /// [`Gpu::read_range`] of what kernels have finished: waits once for both.
    #[doc(hidden)]
    pub fn read_finished<T: Pod>(&self, vec: &GpuVec<T>, start: usize, len: usize) -> Result<Vec<T>> {
        let status = self.begin_read(&self.status, 0, self.status.len())?;
        let wanted = self.begin_read(vec, start, len)?;
        self.judge(&self.end_read(status)?)?;
        self.end_read(wanted)
    }

    fn judge(&self, raised: &[u32]) -> Result<()> {
        match raised.iter().position(|&flag| flag != 0) {
            None => Ok(()),
            Some(k) => {
                // The next run starts afresh.
                self.clear(&self.status)?;
                Err(Error::Unfinished { kernel: wgsl::KERNELS[k].0, why: "a loop was left early".into() })
            }
        }
    }

    /// Runs `work` within error scopes, so that its errors come back typed instead of reaching the
    /// host's handler.
    pub(crate) fn scoped<T>(&self, stage: impl Fn() -> String, work: impl FnOnce() -> T) -> Result<T> {
        scoped(&self.device, stage, work)
    }
}

/// [`Gpu::scoped`] without a [`Gpu`].
pub(crate) fn scoped<T>(device: &wgpu::Device, stage: impl Fn() -> String, work: impl FnOnce() -> T) -> Result<T> {
    let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let value = work();
    // On native backends these futures are ready at once.
    let errors = [validation.pop(), internal.pop(), memory.pop()].map(pollster::block_on);
    match errors.into_iter().flatten().next() {
        None => Ok(value),
        Some(e) => Err(failure::of(device, stage(), e)),
    }
}
