//! A host with a wgpu device, a queue and a frame loop of its own: raycell bakes inside its frames, and
//! the host's next pass draws with the result, which never leaves the device.
//!
//! ```text
//! cargo run --release --example embed [-- PICTURE.png]
//! ```

use raycell::{Baker, Params, Ready, Scene, wgpu};
use std::error::Error;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// What the host lets a bake have of a frame.
pub const BUDGET: Duration = Duration::from_millis(4);

/// The host's own device: nothing is asked of it for raycell.
pub fn device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    Ok(pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("the host's device"),
        required_limits: wgpu::Limits::default(),
        ..Default::default()
    }))?)
}

/// The host's frame loop. Returns the baked light, and how long recording and submitting took in each
/// frame from the first one that had work.
pub fn frames(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
    params: Params,
) -> raycell::Result<(raycell::Baked, Vec<Duration>)> {
    let mut baker = Baker::new(device, queue, scene, params)?;
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let mut encoder = device.create_command_encoder(&Default::default());
        // The host would record its own passes here.
        let working = baker.encode(&mut encoder, BUDGET)?;
        queue.submit([encoder.finish()]);
        if working && times.is_empty() {
            // The first slice has the driver compile: a host shows its loading picture.
            let _ = device.poll(wgpu::PollType::wait_indefinitely());
        }
        if working || !times.is_empty() {
            times.push(start.elapsed());
        }
        // The host's own poll; it does not wait either.
        let _ = device.poll(wgpu::PollType::Poll);
        match baker.poll_ready()? {
            Ready::Done => return Ok((baker.finish()?, times)),
            Ready::Encode => {}
            // A host with a window would wait for its display.
            Ready::Wait => std::thread::sleep(Duration::from_micros(200)),
        }
    }
}

/// Draws the scene with the light at its corners, as seen from the open front of the Cornell box.
pub fn draw(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene, light: &wgpu::Buffer) -> wgpu::Texture {
    const SIZE: u32 = 512;
    let texture = |format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let colour = wgpu::TextureFormat::Rgba8UnormSrgb;
    let picture = texture(colour, wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC);
    let depth = texture(wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::RENDER_ATTACHMENT);

    // The host's own mesh: three corners a face, in the order of the scene.
    let corners: Vec<[f32; 3]> =
        (0..scene.faces.len()).flat_map(|face| scene.corners(face).map(|corner| corner.map(|x| x as f32))).collect();
    let positions = wgpu::util::DeviceExt::create_buffer_init(
        device,
        &wgpu::util::BufferInitDescriptor {
            label: Some("positions"),
            contents: bytemuck::cast_slice(&corners),
            usage: wgpu::BufferUsages::VERTEX,
        },
    );
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("draw"),
        source: wgpu::ShaderSource::Wgsl(include_str!("embed.wgsl").into()),
    });
    let position = wgpu::vertex_attr_array![0 => Float32x3];
    let radiosity = wgpu::vertex_attr_array![1 => Float32x4];
    let stream = |array_stride, attributes| {
        Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
    };
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("draw"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[stream(12, &position), stream(16, &radiosity)],
        },
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(colour.into())],
        }),
        multiview_mask: None,
        cache: None,
    });

    let mut encoder = device.create_command_encoder(&Default::default());
    let (picture_view, depth_view) = (picture.create_view(&Default::default()), depth.create_view(&Default::default()));
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &picture_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_vertex_buffer(0, positions.slice(..));
    pass.set_vertex_buffer(1, light.slice(..)); // as the bake left it
    pass.draw(0..corners.len() as u32, 0..1);
    drop(pass);
    queue.submit([encoder.finish()]);
    picture
}

/// The host's screenshot: the picture's sRGB bytes.
pub fn screenshot(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &wgpu::Texture,
) -> Result<image::RgbaImage, Box<dyn Error>> {
    let size = picture.size();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * size.width * size.height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size.width), rows_per_image: None };
    encoder.copy_texture_to_buffer(picture.as_image_copy(), wgpu::TexelCopyBufferInfo { buffer: &buffer, layout }, size);
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let bytes = buffer.get_mapped_range(..)?.to_vec();
    image::RgbaImage::from_raw(size.width, size.height, bytes).ok_or_else(|| "the picture is incomplete".into())
}

fn run() -> Result<(), Box<dyn Error>> {
    let (device, queue) = device()?;
    let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell/scene.obj"))?;
    let start = Instant::now();
    let (baked, times) = frames(&device, &queue, &scene, Params::default())?;
    let longest = times.iter().skip(1).max().copied().unwrap_or_default();
    println!(
        "baked in {} frames, {:.1} s; longest recording and submission after the first: {:.1} ms",
        times.len(),
        start.elapsed().as_secs_f64(),
        1e3 * longest.as_secs_f64()
    );
    let picture = draw(&device, &queue, &scene, &baked.light);
    if let Some(path) = std::env::args_os().nth(1) {
        screenshot(&device, &queue, &picture)?.save(&path)?;
        println!("wrote {}", path.display());
    }
    Ok(())
}

#[allow(dead_code)] // a test takes this file in as a module
fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("embed: {e}");
            ExitCode::FAILURE
        }
    }
}
