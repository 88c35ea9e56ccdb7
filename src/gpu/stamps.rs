//! How long the device is at a pass, by its own timestamps. No result depends on them.

use super::Gpu;
use super::work::Route;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

/// A device that tells the time of its passes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Timer {
    /// Nanoseconds a tick.
    period: f64,
}

impl Timer {
    /// A timer, where the host's device has timestamps.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Option<Timer> {
        device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| Timer { period: queue.get_timestamp_period().into() })
    }
}

/// Two timestamps around a pass.
pub(super) struct Stamps {
    set: wgpu::QuerySet,
    period: f64,
}

impl Stamps {
    pub fn new(device: &wgpu::Device, timer: &Timer) -> Stamps {
        let descriptor = wgpu::QuerySetDescriptor { label: Some("raycell.time"), ty: wgpu::QueryType::Timestamp, count: 2 };
        Stamps { set: device.create_query_set(&descriptor), period: timer.period }
    }

    pub fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Has the seconds between the two sent to `then`; none where they could not be read.
    pub fn read(
        self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        then: impl FnOnce(Option<f64>) + Send + 'static,
    ) {
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size: 16, usage, mapped_at_creation: false })
        };
        let resolved = buffer("raycell.time", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let staging = buffer("raycell.time.staging", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        encoder.resolve_query_set(&self.set, 0..2, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &staging, 0, 16);
        let mapped = staging.clone();
        encoder.map_buffer_on_submit(&staging, wgpu::MapMode::Read, .., move |result| {
            let view = result.ok().and_then(|()| mapped.get_mapped_range(..).ok());
            let ticks = view.map(|view| bytemuck::pod_read_unaligned::<[u64; 2]>(&view));
            // Drivers that reset their clock within a pass tell nothing.
            let seconds = ticks.and_then(|[a, b]| b.checked_sub(a)).map(|t| t as f64 * self.period * 1e-9);
            then(seconds.filter(|s| *s > 0.0));
        });
    }
}

/// Seconds of each kernel, added up as they arrive.
#[derive(Debug, Default)]
pub(super) struct Times {
    timer: OnceLock<Timer>,
    seconds: Arc<Mutex<BTreeMap<String, f64>>>,
}

#[doc(hidden)]
impl Gpu {
    /// From now on every kernel is timed by the device; says whether it can be. Only where raycell submits.
    pub fn time_kernels(&self) -> bool {
        let timer = match &self.route {
            Route::Queue(queue) => Timer::new(&self.device, queue),
            Route::Host(_) => None,
        };
        timer.is_some_and(|timer| self.times.timer.set(timer).is_ok())
    }

    /// Device seconds of each kernel since the last call, of what has been waited for.
    pub fn take_kernel_seconds(&self) -> BTreeMap<String, f64> {
        std::mem::take(&mut *self.times.seconds.lock().unwrap_or_else(|e| e.into_inner()))
    }
}

impl Times {
    /// The clock, where kernels are to be timed.
    pub fn timer(&self) -> Option<&Timer> {
        self.timer.get()
    }

    /// Records a compute pass between two timestamps.
    pub fn pass(
        &self,
        timer: &Timer,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        name: String,
        record: impl FnOnce(&mut wgpu::ComputePass),
    ) {
        let stamps = Stamps::new(device, timer);
        let timestamp_writes = Some(stamps.writes());
        record(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("raycell"), timestamp_writes }));
        let seconds = self.seconds.clone();
        stamps.read(device, encoder, move |took| {
            *seconds.lock().unwrap_or_else(|e| e.into_inner()).entry(name).or_default() += took.unwrap_or(0.0);
        });
    }
}
