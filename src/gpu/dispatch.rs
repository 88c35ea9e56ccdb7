//! One-dimensional work of any length, cut into dispatches.
//!
//! Every kernel's `Params` starts with `base` and `count`: invocation `i < count` of a dispatch works on
//! item `base + i`. The host writes both; the rest of `Params` belongs to the pass.

use super::paged::Records;
use super::work::{Route, Work};
use super::{Access, Bound, Gpu, GpuVec, Kernel, Pipeline, kernel::WORKGROUP};
use crate::error::{Error, Result};
use bytemuck::Pod;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// Most items in a dispatch: what 65,535 workgroups serve.
pub const MAX_CHUNK: u32 = 65_535 * WORKGROUP;
/// Items in a dispatch of a kernel whose invocations trace rays or search cells: short enough for a
/// watchdog of two seconds on a slow device.
pub const HEAVY: u32 = 1 << 18;
/// Items in a dispatch of a kernel whose invocations do a few dozen operations.
pub const LIGHT: u32 = 1 << 20;

/// Bytes that stand in for any kernel's parameters, or an element of any of its buffers.
const STAND_IN: usize = 256;

/// A kernel bound to its buffers and cut into dispatches; it can be run again and again.
#[derive(Debug)]
pub struct Job {
    pub(super) name: &'static str,
    pub(super) items: u32,
    /// Most items in a dispatch.
    pub(super) chunk: u32,
    /// Work of an item, where 1 is all that a pass allows a dispatch.
    pub(super) share: f64,
    pipeline: Arc<Pipeline>,
    buffers: Vec<Bound>,
    /// The parameters; `base` and `count` are not yet right.
    params: Vec<u8>,
    /// A slot for each dispatch of the whole job, and an empty one.
    whole: Slots,
}

/// Parameters of several dispatches in one uniform buffer, bound with a job's buffers.
#[derive(Debug)]
pub(super) struct Slots {
    bind_group: wgpu::BindGroup,
    stride: u32,
}

impl Slots {
    /// Lays out the parameters of a dispatch for each range of items. The buffer is written without the queue.
    fn new(
        device: &wgpu::Device,
        label: &str,
        pipeline: &Pipeline,
        buffers: &[Bound],
        params: &[u8],
        ranges: &[Range<u32>],
    ) -> Slots {
        let size = params.len().next_multiple_of(16);
        let stride = size.next_multiple_of(device.limits().min_uniform_buffer_offset_alignment as usize);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (stride * ranges.len()) as u64,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: true,
        });
        let mut bytes = vec![0u8; stride * ranges.len()];
        for (slot, range) in bytes.chunks_exact_mut(stride).zip(ranges) {
            slot[..params.len()].copy_from_slice(params);
            slot[..8].copy_from_slice(bytemuck::bytes_of(&[range.start, range.len() as u32]));
        }
        super::buffer::fill(&uniform, &bytes);
        let head = wgpu::BufferBinding { buffer: &uniform, offset: 0, size: wgpu::BufferSize::new(size as u64) };
        let entries: Vec<wgpu::BindGroupEntry> = pipeline
            .bindings
            .iter()
            .map(|&binding| {
                let resource = match binding.checked_sub(1) {
                    None => wgpu::BindingResource::Buffer(head.clone()),
                    Some(i) => buffers[i as usize].resource(),
                };
                wgpu::BindGroupEntry { binding, resource }
            })
            .collect();
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &pipeline.layout,
            entries: &entries,
        });
        Slots { bind_group, stride: stride as u32 }
    }
}

impl Job {
    /// The dispatches of the whole job.
    fn ranges(items: u32, chunk: u32) -> Vec<Range<u32>> {
        (0..items.div_ceil(chunk)).map(|step| step * chunk..items.min((step + 1).saturating_mul(chunk))).collect()
    }

    fn encode_slot(&self, slots: &Slots, slot: usize, items: u32, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.pipeline.pipeline);
        pass.set_bind_group(0, &slots.bind_group, &[slot as u32 * slots.stride]);
        pass.dispatch_workgroups(items.div_ceil(self.pipeline.group), 1, 1);
    }

    /// Records dispatch `step` of the job.
    fn encode_step(&self, step: usize, pass: &mut wgpu::ComputePass) {
        let start = step as u32 * self.chunk;
        self.encode_slot(&self.whole, step, self.chunk.min(self.items - start), pass);
    }

    /// Records the whole job into a pass. Errors show when the pass is submitted.
    pub fn encode(&self, pass: &mut wgpu::ComputePass) {
        for step in 0..self.items.div_ceil(self.chunk) as usize {
            self.encode_step(step, pass);
        }
    }

    /// Records a dispatch of no items.
    pub(super) fn encode_empty(&self, pass: &mut wgpu::ComputePass) {
        // One workgroup that finds nothing to do.
        self.encode_slot(&self.whole, self.items.div_ceil(self.chunk) as usize, 1, pass);
    }

    /// Records one dispatch of some of the items, at most [`Job::chunk`].
    pub(super) fn encode_part(&self, device: &wgpu::Device, part: Range<u32>, pass: &mut wgpu::ComputePass) {
        if part.start.is_multiple_of(self.chunk) && (part.len() as u32 == self.chunk || part.end == self.items) {
            return self.encode_step((part.start / self.chunk) as usize, pass);
        }
        let items = part.len() as u32;
        let slots = Slots::new(device, self.name, &self.pipeline, &self.buffers, &self.params, &[part]);
        self.encode_slot(&slots, 0, items, pass);
    }
}

#[doc(hidden)]
impl Gpu {
    /// Binds a kernel to its buffers for `items` items, at most `chunk` a dispatch.
    ///
    /// `params` holds `base` and `count` in its first eight bytes; both are overwritten.
    pub fn prepare<P: Pod, B>(&self, kernel: &Kernel, params: &P, buffers: &[B], items: usize, chunk: u32) -> Result<Arc<Job>>
    where
        for<'a> &'a B: Into<Bound>,
    {
        assert_eq!(buffers.len(), kernel.buffers.len(), "{}: buffers", kernel.name);
        let items = u32::try_from(items).map_err(|_| Error::Limit {
            what: format!("kernel {}", kernel.name),
            limit: "number of items",
            need: items as u64,
            have: u32::MAX.into(),
            cure: "use fewer rays or points",
        })?;
        let params = bytemuck::bytes_of(params).to_vec();
        let buffers = buffers.iter().map(Into::into).collect();
        let job = self.bind(kernel, params, buffers, items, chunk)?;
        if job.pipeline.warm.get().is_none() {
            self.warm_up(vec![job.clone()])?;
        }
        Ok(job)
    }

    fn bind(&self, kernel: &Kernel, params: Vec<u8>, buffers: Vec<Bound>, items: u32, chunk: u32) -> Result<Arc<Job>> {
        let pipeline = self.pipeline(kernel)?;
        let share = 1.0 / f64::from(chunk.max(1));
        let most = MAX_CHUNK / WORKGROUP * self.group.min(WORKGROUP);
        let chunk = (chunk - chunk % WORKGROUP).clamp(WORKGROUP, most);
        // One more slot stays empty: a dispatch of no items, for the driver's compiler.
        let mut ranges = Job::ranges(items, chunk);
        ranges.push(0..0);
        let label = format!("raycell.{}", kernel.name);
        let whole = self.scoped(
            || format!("binding {}", kernel.name),
            || Slots::new(&self.device, &label, &pipeline, &buffers, &params, &ranges),
        )?;
        Ok(Arc::new(Job { name: kernel.name, items, chunk, share, pipeline, buffers, params, whole }))
    }

    /// Compiles kernels, and has the driver compile them too, before there is work for them: on drivers
    /// that compile in the first submission this keeps later ones short.
    pub(crate) fn warm_up_all(&self, kernels: &[Kernel]) -> Result<()> {
        let slots = kernels.iter().map(|k| k.buffers.len()).max().unwrap_or(0);
        let stand_ins: Vec<GpuVec<[u8; STAND_IN]>> =
            (0..slots).map(|_| self.upload("stand-in", &[[0; STAND_IN]])).collect::<Result<_>>()?;
        let in_texels = |k: &Kernel, access: Access| access == Access::Texels || (k.text.paged && access == Access::Scene);
        let texels = match kernels.iter().any(|k| k.buffers.iter().any(|&a| in_texels(k, a))) {
            true => Some(Records::page(self, "stand-in", &[[0u8; STAND_IN]])?),
            false => None,
        };
        let jobs = kernels.iter().map(|kernel| {
            let buffers = kernel.buffers.iter().zip(&stand_ins).map(|(access, buffer)| match &texels {
                Some(texels) if in_texels(kernel, *access) => texels.bound(),
                _ => buffer.bound(),
            });
            let buffers = buffers.collect();
            self.bind(kernel, vec![0; STAND_IN], buffers, 0, WORKGROUP)
        });
        let jobs = jobs.collect::<Result<Vec<_>>>()?;
        self.warm_up(jobs)
    }

    /// Dispatches kernels for no items and waits, so that compiling is timed apart from work.
    fn warm_up(&self, jobs: Vec<Arc<Job>>) -> Result<()> {
        // In frames it is the first work of all.
        if !self.in_frames() {
            self.wait()?;
        }
        let start = Instant::now();
        self.hand(|| jobs.iter().map(|j| j.name).collect::<Vec<_>>().join(", "), Work::Warm { jobs: jobs.clone() })?;
        self.wait()?;
        for job in &jobs {
            job.pipeline.warm.get_or_init(|| start.elapsed().as_secs_f64() / jobs.len() as f64);
        }
        Ok(())
    }

    /// Runs a job, one submission a dispatch, so that no submission is long. Waits only where raycell submits and the job is
    /// cut, for its first part: by how long that takes the others are cut.
    pub fn run_job(&self, job: &Arc<Job>) -> Result<()> {
        if self.in_frames() {
            // The host's frames cut it.
            for items in Job::ranges(job.items, job.chunk) {
                self.hand(|| job.name.to_string(), Work::Dispatch { job: job.clone(), items })?;
            }
            return Ok(());
        }
        let mut rest = 0..job.items;
        while !rest.is_empty() {
            let (count, measured) = self.paces.next(job, &rest);
            let items = rest.start..rest.start + count;
            rest.start += count;
            if measured {
                self.wait()?;
            }
            let start = Instant::now();
            self.hand(|| job.name.to_string(), Work::Dispatch { job: job.clone(), items })?;
            if measured {
                self.wait()?;
                self.paces.took(job, count, start.elapsed().as_secs_f64());
            }
        }
        Ok(())
    }

    /// Runs short jobs one after the other, `times` over, in one submission where raycell submits. Does not wait.
    pub fn run_jobs(&self, jobs: &[&Arc<Job>], times: usize) -> Result<()> {
        let mut all = (0..times).flat_map(|_| jobs);
        match &self.route {
            Route::Host(_) => all.try_for_each(|job| self.run_job(job)),
            Route::Queue(queue) => {
                let names = || jobs.iter().map(|j| j.name).collect::<Vec<_>>().join(", ");
                let record = |pass: &mut wgpu::ComputePass| all.for_each(|job| job.encode(pass));
                self.submit(queue, names, |encoder| match self.times.timer() {
                    Some(timer) => self.times.pass(timer, &self.device, encoder, names(), record),
                    None => record(&mut encoder.begin_compute_pass(&Default::default())),
                })
            }
        }
    }

    /// [`Gpu::prepare`] and [`Gpu::run_job`].
    pub fn run<P: Pod, B>(&self, kernel: &Kernel, params: &P, buffers: &[B], items: usize, chunk: u32) -> Result<()>
    where
        for<'a> &'a B: Into<Bound>,
    {
        if items == 0 {
            return Ok(());
        }
        self.run_job(&self.prepare(kernel, params, buffers, items, chunk)?)
    }
}
