//! A headless device for the command line, tests and benches. Libraries that own a device need none of this.

use super::{Gpu, Watch};
use crate::error::{Error, Result};

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
    /// The interfaces meant. Errors: [`Error::NoSuchDevice`] where `WGPU_BACKEND` counts and names none.
    fn backends(self) -> Result<wgpu::Backends> {
        Ok(match self {
            BackendChoice::Auto => asked_backends()?.unwrap_or(wgpu::Backends::all()),
            BackendChoice::Vulkan => wgpu::Backends::VULKAN,
            BackendChoice::Metal => wgpu::Backends::METAL,
            BackendChoice::Dx12 => wgpu::Backends::DX12,
            BackendChoice::Gl => wgpu::Backends::GL,
        })
    }
}

/// A variable's value; an empty one says nothing.
fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.trim().is_empty())
}

/// What `WGPU_BACKEND` asks for. wgpu passes over names that it does not know, and then finds nothing.
fn asked_backends() -> Result<Option<wgpu::Backends>> {
    let Some(value) = variable("WGPU_BACKEND") else { return Ok(None) };
    if let Some(unknown) = value.split(',').find(|name| wgpu::Backends::from_comma_list(name).is_empty()) {
        let asked = format!("WGPU_BACKEND={value}: '{}'", unknown.trim());
        return Err(Error::NoSuchDevice { asked, known: "vulkan, metal, dx12, gl".into() });
    }
    Ok(Some(wgpu::Backends::from_comma_list(&value)))
}

/// What `WGPU_POWER_PREF` asks for.
fn asked_power() -> Result<wgpu::PowerPreference> {
    match (variable("WGPU_POWER_PREF"), wgpu::PowerPreference::from_env()) {
        (Some(value), None) => {
            Err(Error::NoSuchDevice { asked: format!("WGPU_POWER_PREF={value}"), known: "low, high, none".into() })
        }
        (_, preference) => Ok(preference.unwrap_or_default()),
    }
}

/// The part of an adapter's name that is asked for, and how that is said.
fn asked_name(adapter: Option<&str>) -> Option<(String, String)> {
    let flag = adapter.filter(|name| !name.is_empty()).map(|name| (name.to_lowercase(), format!("--adapter {name}")));
    flag.or_else(|| variable("WGPU_ADAPTER_NAME").map(|name| (name.to_lowercase(), format!("WGPU_ADAPTER_NAME={name}"))))
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
    /// Hears when the device is lost, and of errors that no scope caught.
    pub watch: Watch,
}

/// An adapter as `raycell adapters` lists it.
#[derive(Clone, Debug)]
pub struct AdapterLine {
    /// Name, backend, kind and driver.
    pub info: wgpu::AdapterInfo,
    /// Its limits.
    pub limits: wgpu::Limits,
    /// What else it offers; raycell needs none of it.
    pub features: wgpu::Features,
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
/// `adapter` is part of an adapter's name, case ignored; without it `WGPU_ADAPTER_NAME` counts. With
/// `WGPU_POWER_PREF=low` an integrated GPU comes before a discrete one.
///
/// Errors: [`Error::NoSuchDevice`] where one of wgpu's variables holds no value of its kind.
pub fn list_adapters(backend: BackendChoice, adapter: Option<&str>) -> Result<Vec<AdapterLine>> {
    Ok(candidates(backend.backends()?, adapter)?.into_iter().map(|(_, line)| line).collect())
}

/// Adapters with their lines, best first.
fn candidates(backends: wgpu::Backends, adapter: Option<&str>) -> Result<Vec<(wgpu::Adapter, AdapterLine)>> {
    let low_power = asked_power()? == wgpu::PowerPreference::LowPower;
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle().with_env();
    descriptor.backends = backends;
    let instance = wgpu::Instance::new(descriptor);
    let wanted = asked_name(adapter).map(|(name, _)| name);

    // Prefer real hardware, then native interfaces; the order of the driver's own list breaks ties.
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let rank = |a: &wgpu::Adapter| {
        let info = a.get_info();
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => u8::from(low_power),
            wgpu::DeviceType::IntegratedGpu => u8::from(!low_power),
            wgpu::DeviceType::VirtualGpu | wgpu::DeviceType::Other => 2,
            wgpu::DeviceType::Cpu => 3,
        };
        (kind, info.backend == wgpu::Backend::Gl)
    };
    adapters.sort_by_key(rank);

    let mut found = false;
    let lines = adapters
        .into_iter()
        .map(|adapter| {
            let (info, limits, features) = (adapter.get_info(), adapter.limits(), adapter.features());
            let why_not = match (&wanted, lacks(&adapter)) {
                (Some(w), _) if !info.name.to_lowercase().contains(w) => Some(format!("its name does not contain '{w}'")),
                (_, Some(why)) => Some(why),
                _ if found => Some("another is preferred".to_string()),
                _ => None,
            };
            let chosen = why_not.is_none();
            found |= chosen;
            let line = AdapterLine { info, limits, features, chosen, why_not };
            (adapter, line)
        })
        .collect();
    Ok(lines)
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
/// Errors: [`Error::NoSuchDevice`] where no adapter has the name asked for, or a variable of wgpu's names
/// nothing; [`Error::NoDevice`], listing what there is and why it will not do.
pub fn open(backend: BackendChoice, adapter: Option<&str>) -> Result<OpenDevice> {
    // Where nothing was asked for, OpenGL is started only if nothing else will do: its libraries print.
    let modern = backend == BackendChoice::Auto && asked_backends()?.is_none();
    let mut all = if modern { candidates(wgpu::Backends::PRIMARY, adapter)? } else { Vec::new() };
    if !all.iter().any(|(_, line)| line.chosen) {
        all = candidates(backend.backends()?, adapter)?;
    }
    let Some((adapter, line)) = all.iter().find(|(_, line)| line.chosen) else {
        if let (Some((name, asked)), false) = (asked_name(adapter), all.is_empty())
            && all.iter().all(|(_, line)| !line.info.name.to_lowercase().contains(&name))
        {
            let mut known: Vec<&str> = all.iter().map(|(_, line)| line.info.name.as_str()).collect();
            known.dedup();
            return Err(Error::NoSuchDevice { asked, known: known.join(", ") });
        }
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
        // Timestamps where there are any: `Gpu::time_kernels` may be asked for them.
        required_features: Gpu::required_features() | (adapter.features() & wgpu::Features::TIMESTAMP_QUERY),
        required_limits: limits,
        ..Default::default()
    }))
    .map_err(|e| Error::NoDevice { why: format!("{line}: {e}") })?;

    let watch = Watch::on(&device);
    Ok(OpenDevice { device, queue, info: line.info.clone(), watch })
}
