//! A headless device for the command line, tests and benches. Libraries that own a device need none of this.

use super::Gpu;
use crate::error::{Error, Result};
use std::sync::{Arc, Mutex};

/// Which graphics interface to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// Whatever `WGPU_BACKEND` says, else all of the platform's.
    #[default]
    Auto,
    /// Vulkan.
    Vulkan,
    /// Metal.
    Metal,
    /// Direct3D 12.
    Dx12,
    /// OpenGL or OpenGL ES.
    Gl,
}

impl BackendChoice {
    fn backends(self) -> wgpu::Backends {
        match self {
            BackendChoice::Auto => wgpu::Backends::from_env().unwrap_or(wgpu::Backends::all()),
            BackendChoice::Vulkan => wgpu::Backends::VULKAN,
            BackendChoice::Metal => wgpu::Backends::METAL,
            BackendChoice::Dx12 => wgpu::Backends::DX12,
            BackendChoice::Gl => wgpu::Backends::GL,
        }
    }
}

/// An opened device.
#[derive(Debug)]
pub struct OpenDevice {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What it runs on.
    pub info: wgpu::AdapterInfo,
    /// What the device said when it was lost, or the first error that no scope caught.
    pub failure: Arc<Mutex<Option<String>>>,
}

/// An adapter as `raycell adapters` lists it.
#[derive(Clone, Debug)]
pub struct AdapterLine {
    /// Name, backend, kind and driver.
    pub info: wgpu::AdapterInfo,
    /// Its limits.
    pub limits: wgpu::Limits,
    /// Whether a bake with the same choice would use it.
    pub chosen: bool,
    /// Why it would not be used, if so.
    pub why_not: Option<String>,
}

impl std::fmt::Display for AdapterLine {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} ({:?}, {:?}", self.info.name, self.info.backend, self.info.device_type)?;
        for driver in [&self.info.driver, &self.info.driver_info] {
            if !driver.is_empty() {
                write!(f, ", {driver}")?;
            }
        }
        write!(f, ")")?;
        match &self.why_not {
            Some(why) => write!(f, ": not used, {why}"),
            None => write!(f, ": would be used"),
        }
    }
}

/// All adapters of a choice of backend, in the order of preference, with the one that would be used.
///
/// `adapter` is part of an adapter's name, case ignored; without it `WGPU_ADAPTER_NAME` counts.
pub fn list_adapters(backend: BackendChoice, adapter: Option<&str>) -> Vec<AdapterLine> {
    candidates(backend.backends(), adapter).into_iter().map(|(_, line)| line).collect()
}

/// Adapters with their lines, best first.
fn candidates(backends: wgpu::Backends, adapter: Option<&str>) -> Vec<(wgpu::Adapter, AdapterLine)> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle().with_env();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor);
    let wanted = adapter.map(str::to_string).or_else(|| std::env::var("WGPU_ADAPTER_NAME").ok());
    let wanted = wanted.filter(|w| !w.is_empty()).map(|w| w.to_lowercase());

    // Prefer real hardware, then native interfaces; the order of the driver's own list breaks ties.
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let rank = |a: &wgpu::Adapter| {
        let info = a.get_info();
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
            wgpu::DeviceType::Cpu => 3,
        };
        (kind, info.backend == wgpu::Backend::Gl)
    };
    adapters.sort_by_key(rank);

    let mut found = false;
    adapters
        .into_iter()
        .map(|adapter| {
            let (info, limits) = (adapter.get_info(), adapter.limits());
            let why_not = match (&wanted, lacks(&adapter)) {
                (Some(w), _) if !info.name.to_lowercase().contains(w) => Some(format!("its name does not contain '{w}'")),
                (_, Some(why)) => Some(why),
                _ if found => Some("another is preferred".to_string()),
                _ => None,
            };
            let chosen = why_not.is_none();
            found |= chosen;
            let line = AdapterLine { info, limits, chosen, why_not };
            (adapter, line)
        })
        .collect()
}

/// What an adapter lacks to run the kernels.
fn lacks(adapter: &wgpu::Adapter) -> Option<String> {
    if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("it has no compute shaders".into());
    }
    let mut why = None;
    Gpu::required_limits().check_limits_with_fail_fn(&adapter.limits(), true, |limit, need, have| {
        why = Some(format!("its {limit} is {have}, {need} is needed"));
    });
    why
}

/// Opens the device that [`list_adapters`] marks as chosen.
///
/// Errors: [`Error::NoDevice`], listing what there is and why it will not do.
pub fn open(backend: BackendChoice, adapter: Option<&str>) -> Result<OpenDevice> {
    // Where nothing was asked for, OpenGL is started only if nothing else will do: its libraries print.
    let modern = backend == BackendChoice::Auto && wgpu::Backends::from_env().is_none();
    let mut all = if modern { candidates(wgpu::Backends::PRIMARY, adapter) } else { Vec::new() };
    if !all.iter().any(|(_, line)| line.chosen) {
        all = candidates(backend.backends(), adapter);
    }
    let Some((adapter, line)) = all.iter().find(|(_, line)| line.chosen) else {
        let lines: Vec<String> = all.iter().map(|(_, line)| line.to_string()).collect();
        let why = if lines.is_empty() { "there is no adapter at all".into() } else { lines.join("; ") };
        return Err(Error::NoDevice { why });
    };

    // Ask by name for what is needed; larger buffers are the one thing that more is taken of.
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: line.limits.max_storage_buffer_binding_size,
        max_buffer_size: line.limits.max_buffer_size,
        ..Gpu::required_limits()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("raycell"),
        required_features: Gpu::required_features(),
        required_limits: limits,
        ..Default::default()
    }))
    .map_err(|e| Error::NoDevice { why: format!("{line}: {e}") })?;

    // Keep the first failure; the default handler would panic.
    let failure = Arc::new(Mutex::new(None));
    let keep = |failure: &Arc<Mutex<Option<String>>>, text: String| {
        failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(text);
    };
    let lost = failure.clone();
    device.set_device_lost_callback(move |reason, message| keep(&lost, format!("device lost ({reason:?}): {message}")));
    let error = failure.clone();
    device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| keep(&error, e.to_string())));
    Ok(OpenDevice { device, queue, info: line.info.clone(), failure })
}
