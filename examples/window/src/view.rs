//! The bake and the picture, as part of egui's own frame.

use eframe::egui;
use eframe::egui_wgpu::{CallbackResources, CallbackTrait, ScreenDescriptor};
use eframe::wgpu;
use raycell::{Baker, Ready, Scene};
use std::sync::{Arc, Mutex};

/// What became of the bake: nothing yet, a picture, or the reason why not.
pub type State = Arc<Mutex<Option<Result<(), String>>>>;

/// What the view keeps between frames.
pub struct View {
    baker: Mutex<Option<Baker>>,
    state: State,
    pipeline: wgpu::RenderPipeline,
    camera: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    positions: wgpu::Buffer,
    corners: u32,
    /// Middle of the scene, and how far to stand back.
    middle: [f32; 3],
    back: f32,
    /// Radiosity at the corners, as the bake left it on the device.
    light: Option<wgpu::Buffer>,
}

impl View {
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat, scene: Scene, baker: Baker, state: State) -> View {
        let corners: Vec<[f32; 3]> =
            (0..scene.faces.len()).flat_map(|face| scene.corners(face).map(|corner| corner.map(|x| x as f32))).collect();
        let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
        for corner in &corners {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(corner[k]), high[k].max(corner[k]));
            }
        }
        let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let back = 2.0 * (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);

        let positions = buffer(device, bytemuck::cast_slice(&corners), wgpu::BufferUsages::VERTEX);
        let camera = buffer(device, &[0; 32], wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST);
        let module = device.create_shader_module(wgpu::include_wgsl!("view.wgsl"));
        let position = wgpu::vertex_attr_array![0 => Float32x3];
        let radiosity = wgpu::vertex_attr_array![1 => Float32x4];
        let stream = |array_stride, attributes| {
            Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("view"),
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
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: camera.as_entire_binding() }],
        });
        let corners = corners.len() as u32;
        View {
            baker: Mutex::new(Some(baker)),
            state,
            pipeline,
            camera,
            bind_group,
            positions,
            corners,
            middle,
            back,
            light: None,
        }
    }

    /// The bake's part of a frame.
    fn bake(&mut self, encoder: &mut wgpu::CommandEncoder) -> raycell::Result<()> {
        let slot = self.baker.get_mut().unwrap_or_else(|e| e.into_inner());
        let Some(baker) = slot else { return Ok(()) };
        baker.encode(encoder, crate::BUDGET)?;
        if baker.poll_ready()? == Ready::Done
            && let Some(baker) = slot.take()
        {
            self.light = Some(baker.finish()?.light);
            *self.state.lock().unwrap_or_else(|e| e.into_inner()) = Some(Ok(()));
        }
        Ok(())
    }
}

fn buffer(device: &wgpu::Device, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    wgpu::util::DeviceExt::create_buffer_init(device, &wgpu::util::BufferInitDescriptor { label: None, contents, usage })
}

/// One frame's call.
pub struct Slice {
    pub area: egui::Rect,
}

impl CallbackTrait for Slice {
    fn prepare(
        &self,
        _: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(view) = resources.get_mut::<View>() {
            // Into egui's own commands, which egui submits.
            if let Err(e) = view.bake(encoder) {
                *view.state.lock().unwrap_or_else(|e| e.into_inner()) = Some(Err(e.to_string()));
                *view.baker.get_mut().unwrap_or_else(|e| e.into_inner()) = None;
            }
            let [x, y, z] = view.middle;
            let camera = [x, y, z, view.back, self.area.aspect_ratio(), 0.0, 0.0, 0.0];
            queue.write_buffer(&view.camera, 0, bytemuck::cast_slice(&camera));
        }
        Vec::new()
    }

    fn paint(&self, _: egui::PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, resources: &CallbackResources) {
        if let Some(view) = resources.get::<View>()
            && let Some(light) = &view.light
        {
            pass.set_pipeline(&view.pipeline);
            pass.set_bind_group(0, &view.bind_group, &[]);
            pass.set_vertex_buffer(0, view.positions.slice(..));
            pass.set_vertex_buffer(1, light.slice(..));
            pass.draw(0..view.corners, 0..1);
        }
    }
}
