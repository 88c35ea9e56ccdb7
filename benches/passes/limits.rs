//! What the machine can do through the driver: a chain of multiply-adds, and a triad a = b + s c.

use wgpu::util::DeviceExt;

/// Invocations of the multiply-add kernel, trips of its loop, multiply-adds a trip.
const LANES: u32 = 1 << 16;
const TRIPS: u32 = 1 << 10;
const CHAIN: u32 = 32;
/// Vectors of four numbers in each array of the triad: beyond any cache.
const VECTORS: u32 = 1 << 21;
const WORKGROUP: u32 = 64;

const SHADERS: &str = include_str!("limits.wgsl");

/// Two kernels, ready to run.
pub struct Limits {
    device: wgpu::Device,
    queue: wgpu::Queue,
    fma: Job,
    triad: Job,
}

struct Job {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    groups: u32,
    /// What it writes.
    out: wgpu::Buffer,
}

impl Limits {
    /// Floating-point operations of [`Limits::fma`]; a multiply-add is two.
    pub const FLOPS: u64 = 2 * LANES as u64 * TRIPS as u64 * CHAIN as u64;
    /// Bytes that [`Limits::triad`] reads and writes.
    pub const BYTES: u64 = 3 * 16 * VECTORS as u64;

    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Limits {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("limits"),
            source: wgpu::ShaderSource::Wgsl(SHADERS.into()),
        });
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let full = |value: f32, len: u32| {
            let contents: Vec<f32> = vec![value; len as usize];
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: bytemuck::cast_slice(&contents),
                usage,
            })
        };
        let job = |entry: &str, buffers: &[&wgpu::Buffer], items: u32| {
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            });
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, b)| wgpu::BindGroupEntry { binding, resource: b.as_entire_binding() })
                .collect();
            let layout = pipeline.get_bind_group_layout(0);
            let bind_group =
                device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
            Job { pipeline, bind_group, groups: items / WORKGROUP, out: buffers[0].clone() }
        };
        let (a, b, c) = (full(0.0, 4 * VECTORS), full(1.0, 4 * VECTORS), full(2.0, 4 * VECTORS));
        let triad = job("triad", &[&a, &b, &c], VECTORS);
        let fma = job("fma_chain", &[&full(0.25, LANES)], LANES);
        Limits { device: device.clone(), queue: queue.clone(), fma, triad }
    }

    fn run(&self, job: &Job) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&job.pipeline);
            pass.set_bind_group(0, &job.bind_group, &[]);
            pass.dispatch_workgroups(job.groups, 1, 1);
        }
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }

    /// [`Limits::FLOPS`] operations in registers.
    pub fn fma(&self) {
        self.run(&self.fma);
    }

    /// [`Limits::BYTES`] bytes.
    pub fn triad(&self) {
        self.run(&self.triad);
    }

    /// All was computed: each chain ends where it must, each sum is right.
    pub fn check(&self) {
        self.fma();
        // Every chain came to the fixed point of x <- x/2 + 1/2, in as many trips as were asked for.
        assert!(self.read(&self.fma.out, LANES).iter().all(|x| (x - 4.0).abs() < 1e-5));
        self.triad();
        assert!(self.read(&self.triad.out, 4 * VECTORS).iter().all(|x| *x == 7.0));
    }

    fn read(&self, buffer: &wgpu::Buffer, len: u32) -> Vec<f32> {
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * len as u64,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, None);
        self.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        bytemuck::cast_slice(&staging.get_mapped_range(..).unwrap()).to_vec()
    }
}
