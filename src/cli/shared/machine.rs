//! What a job runs on: flags, and the device they open.

use super::super::log::Log;
use crate::error::Result;
use crate::gpu::{Gpu, Watch, device, device::BackendChoice};
use crate::output::report::AdapterReport;
use clap::{Args, ValueEnum};
use std::sync::Arc;

/// What it runs on.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub struct Device {
    /// Graphics interface; cpu is the slow driver-free oracle and never chosen by auto.
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: Backend,
    /// Only adapters whose name contains this.
    #[arg(long, value_name = "SUBSTRING")]
    pub adapter: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    Auto,
    Vulkan,
    Metal,
    Dx12,
    Gl,
    Cpu,
}

/// What a job runs on, and what a report says of it.
pub struct Machine {
    pub backend: crate::Backend,
    pub adapter: Option<AdapterReport>,
    watch: Option<Watch>,
}

impl Machine {
    pub fn open(flags: &Device, log: &Log) -> Result<Machine> {
        let Some(choice) = choice(flags.backend) else {
            return Ok(Machine { backend: crate::Backend::Cpu, adapter: None, watch: None });
        };
        let open = device::open(choice, flags.adapter.as_deref())?;
        let info = &open.info;
        let driver = [&info.driver, &info.driver_info].map(|s| s.trim()).join(" ").trim().to_string();
        log.line(&format!("running on {} ({:?}, {driver})", info.name, info.backend));
        let adapter = AdapterReport { name: info.name.clone(), backend: format!("{:?}", info.backend).to_lowercase(), driver };
        let gpu = Gpu::new(&open.device, &open.queue)?;
        Ok(Machine { backend: crate::Backend::Gpu(Arc::new(gpu)), adapter: Some(adapter), watch: Some(open.watch) })
    }

    /// A result of this machine: where the device failed meanwhile, that is the error, whatever came of it.
    pub fn judge<T>(&self, stage: &str, result: Result<T>) -> Result<T> {
        match &self.watch {
            Some(watch) => watch.judge(stage, result),
            None => result,
        }
    }
}

/// The graphics interface asked for; none for the twin.
pub fn choice(backend: Backend) -> Option<BackendChoice> {
    match backend {
        Backend::Auto => Some(BackendChoice::Auto),
        Backend::Vulkan => Some(BackendChoice::Vulkan),
        Backend::Metal => Some(BackendChoice::Metal),
        Backend::Dx12 => Some(BackendChoice::Dx12),
        Backend::Gl => Some(BackendChoice::Gl),
        Backend::Cpu => None,
    }
}
