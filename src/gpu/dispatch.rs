//! One-dimensional work of any length, cut into dispatches.
//!
//! Every kernel's `Params` starts with `base` and `count`: invocation `i < count` of a dispatch works on
//! item `base + i`. The host writes both; the rest of `Params` belongs to the pass.

use super::{Gpu, Kernel, Pipeline, kernel::WORKGROUP};
use crate::error::{Error, Result};
use bytemuck::Pod;
use std::sync::Arc;
use std::time::Instant;

/// Most items in a dispatch: what 65,535 workgroups serve.
pub const MAX_CHUNK: u32 = 65_535 * WORKGROUP;
/// Items in a dispatch of a kernel whose invocations trace rays or search cells: short enough for a
/// watchdog of two seconds on a slow device.
pub const HEAVY: u32 = 1 << 18;
/// Items in a dispatch of a kernel whose invocations do a few dozen operations.
pub const LIGHT: u32 = 1 << 20;

/// A kernel bound to its buffers and cut into dispatches; it can be run again and again.
#[derive(Debug)]
pub struct Job {
    name: &'static str,
    pipeline: Arc<Pipeline>,
    bind_group: wgpu::BindGroup,
    /// Offset of the parameters and number of workgroups, a dispatch each.
    steps: Vec<(u32, u32)>,
}

impl Job {
    /// Records dispatch `step` of the job.
    fn encode_step(&self, step: usize, pass: &mut wgpu::ComputePass) {
        let (offset, groups) = self.steps[step];
        pass.set_pipeline(&self.pipeline.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[offset]);
        pass.dispatch_workgroups(groups, 1, 1);
    }

    /// Records the whole job into a pass. Errors show when the pass is submitted.
    pub fn encode(&self, pass: &mut wgpu::ComputePass) {
        for step in 0..self.steps.len() {
            self.encode_step(step, pass);
        }
    }
}

#[doc(hidden)]
impl Gpu {
    /// Binds a kernel to its buffers for `items` items, at most `chunk` a dispatch.
    ///
    /// `params` holds `base` and `count` in its first eight bytes; both are overwritten.
    pub fn prepare<P: Pod>(
        &self,
        kernel: &Kernel,
        params: &P,
        buffers: &[&wgpu::Buffer],
        items: usize,
        chunk: u32,
    ) -> Result<Job> {
        assert_eq!(buffers.len(), kernel.buffers.len(), "{}: buffers", kernel.name);
        let items = u32::try_from(items).map_err(|_| Error::Limit {
            what: format!("kernel {}", kernel.name),
            limit: "number of items",
            need: items as u64,
            have: u32::MAX.into(),
            cure: "use fewer rays or points",
        })?;
        let pipeline = self.pipeline(kernel)?;
        let chunk = chunk.clamp(WORKGROUP, MAX_CHUNK);

        // Lay the parameters of all dispatches out in one uniform buffer.
        let size = size_of::<P>().next_multiple_of(16);
        let stride = (self.device.limits().min_uniform_buffer_offset_alignment as usize).max(size.next_multiple_of(16));
        let stride = stride.next_multiple_of(self.device.limits().min_uniform_buffer_offset_alignment as usize);
        let count = items.div_ceil(chunk) as usize;
        // One more slot stays empty: a dispatch of no items, for the driver's compiler.
        let mut bytes = vec![0u8; stride * (count + 1)];
        let mut steps = Vec::with_capacity(count);
        for step in 0..count {
            let base = step as u32 * chunk;
            let here = chunk.min(items - base);
            let slot = &mut bytes[step * stride..][..size];
            slot[..size_of::<P>()].copy_from_slice(bytemuck::bytes_of(params));
            slot[..8].copy_from_slice(bytemuck::bytes_of(&[base, here]));
            steps.push(((step * stride) as u32, here.div_ceil(WORKGROUP)));
        }

        let label = format!("raycell.{}", kernel.name);
        let bind_group = self.scoped(
            || format!("binding {}", kernel.name),
            || {
                let uniform = self.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(&label),
                    size: bytes.len() as u64,
                    usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                self.queue.write_buffer(&uniform, 0, &bytes);
                let head = wgpu::BufferBinding { buffer: &uniform, offset: 0, size: wgpu::BufferSize::new(size as u64) };
                let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::Buffer(head) }];
                entries.extend(
                    buffers
                        .iter()
                        .enumerate()
                        .map(|(i, b)| wgpu::BindGroupEntry { binding: i as u32 + 1, resource: b.as_entire_binding() }),
                );
                self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(&label),
                    layout: &pipeline.layout,
                    entries: &entries,
                })
            },
        )?;
        let job = Job { name: kernel.name, pipeline, bind_group, steps };
        if job.pipeline.warm.get().is_none() {
            self.warm_up(&job, (stride * count) as u32)?;
        }
        Ok(job)
    }

    /// Dispatches a kernel for no items and waits, so that its compiling is timed apart from its work.
    fn warm_up(&self, job: &Job, empty: u32) -> Result<()> {
        self.wait()?;
        let start = Instant::now();
        let empty =
            Job { name: job.name, pipeline: job.pipeline.clone(), bind_group: job.bind_group.clone(), steps: vec![(empty, 1)] };
        self.run_job(&empty)?;
        self.wait()?;
        job.pipeline.warm.get_or_init(|| start.elapsed().as_secs_f64());
        Ok(())
    }

    /// Runs a job, one submission a dispatch, so that no submission is long. Does not wait.
    pub fn run_job(&self, job: &Job) -> Result<()> {
        for step in 0..job.steps.len() {
            self.scoped(
                || job.name.to_string(),
                || {
                    let mut encoder = self.device.create_command_encoder(&Default::default());
                    let mut pass = encoder.begin_compute_pass(&Default::default());
                    job.encode_step(step, &mut pass);
                    drop(pass);
                    self.queue.submit([encoder.finish()]);
                },
            )?;
        }
        Ok(())
    }

    /// Runs short jobs one after the other, `times` over, in one submission. Does not wait.
    pub fn run_jobs(&self, jobs: &[&Job], times: usize) -> Result<()> {
        self.scoped(
            || jobs.iter().map(|j| j.name).collect::<Vec<_>>().join(", "),
            || {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                let mut pass = encoder.begin_compute_pass(&Default::default());
                for _ in 0..times {
                    jobs.iter().for_each(|job| job.encode(&mut pass));
                }
                drop(pass);
                self.queue.submit([encoder.finish()]);
            },
        )
    }

    /// [`Gpu::prepare`] and [`Gpu::run_job`].
    pub fn run<P: Pod>(&self, kernel: &Kernel, params: &P, buffers: &[&wgpu::Buffer], items: usize, chunk: u32) -> Result<()> {
        if items == 0 {
            return Ok(());
        }
        self.run_job(&self.prepare(kernel, params, buffers, items, chunk)?)
    }
}
