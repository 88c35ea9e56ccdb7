//! A host that has a wgpu device of its own lends it to raycell: bakes the Cornell box and asks for the
//! light at three points.
//!
//! ```text
//! cargo run --release --example embed
//! ```

use raycell::gpu::Gpu;
use raycell::{Answer, Backend, Flow, Params, Scene, SurfacePoint, bake, wgpu};
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

/// What the host wants to know: the middle of the floor, the green wall, under the tall box.
pub const POINTS: [SurfacePoint; 3] = [
    SurfacePoint { p: [2.78, 0.0, 2.0], n: [0.0, 1.0, 0.0] },
    SurfacePoint { p: [0.0, 2.74, 2.79], n: [1.0, 0.0, 0.0] },
    SurfacePoint { p: [3.68, 0.0, 3.51], n: [0.0, 1.0, 0.0] },
];

/// The host's own device, made with what raycell needs on top of what the host would ask for.
pub fn device() -> Result<(wgpu::Device, wgpu::Queue), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    Ok(pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("the host's device"),
        required_features: Gpu::required_features(),
        required_limits: Gpu::required_limits(),
        ..Default::default()
    }))?)
}

/// Bakes on a host's device. The host keeps it, and may use it for its own work meanwhile.
pub fn light(device: &wgpu::Device, queue: &wgpu::Queue) -> raycell::Result<Vec<Answer>> {
    let backend = Backend::Gpu(Arc::new(Gpu::new(device, queue)?));
    let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell/scene.obj"))?;
    let params = Params { rays: 32_768, ..Params::default() };
    let solution = bake(&backend, &scene, &params, &mut |_| Flow::Continue)?;
    solution.query(&backend, &POINTS)
}

fn run() -> Result<(), Box<dyn Error>> {
    let (device, queue) = device()?;
    for (point, answer) in POINTS.iter().zip(light(&device, &queue)?) {
        println!("at {:?}: {:?}, B = {:.4?} W/m2", point.p, answer.status, answer.b);
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
