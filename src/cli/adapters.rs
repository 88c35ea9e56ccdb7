//! `raycell adapters`: what there is to run on.

use super::exit::Done;
use super::shared::machine::{Device, choice};
use crate::error::Result;
use crate::gpu::device;
use clap::Args;
use serde_json::json;

const EXAMPLES: &str = "\
Examples:
  raycell adapters
      What there is, which one a bake would use, and why not the others.
  raycell adapters --backend vulkan --adapter llvmpipe
      Whether these flags would find what they mean.
  raycell adapters --json
      The same for a script.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    #[command(flatten)]
    pub device: Device,
}

pub fn run(flags: Flags) -> Result<Done> {
    let mut text = String::new();
    let mut list = Vec::new();
    if let Some(choice) = choice(flags.device.backend) {
        for line in device::list_adapters(choice, flags.device.adapter.as_deref())? {
            let l = &line.limits;
            text += &format!(
                "{line}\n    buffer {} MiB, binding {} MiB, {} storage buffers a stage, {} invocations, {} KiB workgroup memory\n",
                l.max_buffer_size >> 20,
                l.max_storage_buffer_binding_size >> 20,
                l.max_storage_buffers_per_shader_stage,
                l.max_compute_invocations_per_workgroup,
                l.max_compute_workgroup_storage_size >> 10,
            );
            list.push(json!({
                "name": line.info.name,
                "backend": format!("{:?}", line.info.backend).to_lowercase(),
                "type": format!("{:?}", line.info.device_type).to_lowercase(),
                "driver": line.info.driver,
                "driver_info": line.info.driver_info,
                "ray_query": line.features.contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY),
                "chosen": line.chosen,
                "why_not": line.why_not,
            }));
        }
        if text.is_empty() {
            text += "no adapter; ci/setup installs a software driver on Debian and Ubuntu\n";
        }
    }
    text += "cpu: plain-Rust twin, slow, needs no driver, never chosen by auto (--backend cpu)\n";
    Ok(Done::new(json!({"command": "adapters", "adapters": list})).text(text))
}
