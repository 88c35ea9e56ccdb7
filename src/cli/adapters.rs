//! `raycell adapters`: what there is to run on.

use super::shared::machine::{Device, choice};
use crate::error::{Error, Result};
use crate::gpu::device;
use clap::Args;
use std::io::Write;

#[derive(Args)]
pub struct Flags {
    #[command(flatten)]
    pub device: Device,
}

pub fn run(flags: Flags) -> Result<()> {
    let mut text = String::new();
    if let Some(choice) = choice(flags.device.backend) {
        for line in device::list_adapters(choice, flags.device.adapter.as_deref()) {
            let l = &line.limits;
            text += &format!(
                "{line}\n    buffer {} MiB, binding {} MiB, {} storage buffers a stage, {} invocations, {} KiB workgroup memory\n",
                l.max_buffer_size >> 20,
                l.max_storage_buffer_binding_size >> 20,
                l.max_storage_buffers_per_shader_stage,
                l.max_compute_invocations_per_workgroup,
                l.max_compute_workgroup_storage_size >> 10,
            );
        }
        if text.is_empty() {
            text += "no adapter; ci/setup installs a software driver on Debian and Ubuntu\n";
        }
    }
    text += "cpu: plain-Rust twin, slow, needs no driver, never chosen by auto (--backend cpu)\n";
    // A reader that has seen enough (head) is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Write { path: "stdout".into(), source: e }),
        _ => Ok(()),
    }
}
