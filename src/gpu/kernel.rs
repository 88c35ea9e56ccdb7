//! Kernels: their bindings, and their pipelines, made when first used.

use super::{Gpu, wgsl};
use crate::error::{Error, Result};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// Invocations in a workgroup, in every kernel, unless [`Gpu::with_group`] says otherwise.
pub const WORKGROUP: u32 = 64;
/// As it stands in the kernels' text.
const AS_WRITTEN: &str = "@workgroup_size(64)";

/// How a kernel uses a storage buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`.
    Write,
    /// Records of the scene: `var<storage, read>`, and texels where the kernel is [`Kernel::paged`].
    Scene,
}

/// What the host knows of a kernel before it is compiled: a constant beside the pass that uses it.
///
/// Binding 0 is the uniform `Params`, which starts with `base` and `count`; the storage buffers follow from binding 1.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name of the kernel: `wgsl/<name>.wgsl`, entry `main`.
    pub name: &'static str,
    /// The storage buffers, at most eight.
    pub buffers: &'static [Access],
    /// Values of its `override` constants, where they are not the shader's own; another pipeline each.
    pub constants: Constants,
    /// Whether the scene's records come as texels: another text, and another pipeline ([`super::paged`]).
    pub paged: bool,
}

/// Names and values of `override` constants; a `bool` is 0 or 1.
pub type Constants = &'static [(&'static str, u32)];

/// What tells pipelines apart: the kernel's name, its constants, and whether the scene is paged.
pub(super) type Key = (&'static str, Constants, bool);

impl Kernel {
    /// A kernel with its shader's own constants.
    pub const fn new(name: &'static str, buffers: &'static [Access]) -> Kernel {
        Kernel { name, buffers, constants: &[], paged: false }
    }

    /// The kernel with other constants.
    pub const fn with(self, constants: Constants) -> Kernel {
        Kernel { constants, ..self }
    }

    /// The kernel for a scene whose records are paged, or not.
    pub const fn paged(self, paged: bool) -> Kernel {
        Kernel { paged, ..self }
    }
}

/// A compiled kernel.
#[derive(Debug)]
pub struct Pipeline {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// Invocations in a workgroup.
    pub(super) group: u32,
    /// Seconds to make the pipeline.
    pub seconds: f64,
    /// Seconds of the first, empty dispatch: drivers put most of their compiling off until then.
    pub(super) warm: OnceLock<f64>,
}

#[doc(hidden)]
impl Gpu {
    /// The pipeline of a kernel, compiled on the first call.
    ///
    /// Errors: [`Error::Device`] with file and line where the shader is refused.
    pub fn pipeline(&self, kernel: &Kernel) -> Result<Arc<Pipeline>> {
        let mut cache = self.kernels.lock().unwrap_or_else(|e| e.into_inner());
        let key = (kernel.name, kernel.constants, kernel.paged);
        if let Some(found) = cache.get(&key) {
            return Ok(found.clone());
        }
        let made = Arc::new(self.compile(kernel)?);
        cache.insert(key, made.clone());
        Ok(made)
    }

    /// Names and compile seconds of the kernels made so far, by name.
    pub fn compile_seconds(&self) -> Vec<(&'static str, f64)> {
        let cache = self.kernels.lock().unwrap_or_else(|e| e.into_inner());
        let mut all: Vec<_> = cache.iter().map(|(&(name, ..), p)| (name, p.seconds + p.warm.get().unwrap_or(&0.0))).collect();
        all.sort_by_key(|&(name, _)| name);
        all
    }

    /// Seconds that all kernels made so far took to compile.
    pub fn compiled(&self) -> f64 {
        self.compile_seconds().iter().map(|(_, seconds)| seconds).sum()
    }

    fn compile(&self, kernel: &Kernel) -> Result<Pipeline> {
        let start = Instant::now();
        let device = &self.device;
        let label = format!("raycell.{}", kernel.name);
        let mut composed = wgsl::compose(kernel.name, kernel.paged);
        if self.group != WORKGROUP {
            composed.source = composed.source.replace(AS_WRITTEN, &format!("@workgroup_size({})", self.group));
        }
        let stage = || format!("compiling {}", kernel.name);
        let constants: Vec<(&str, f64)> = kernel.constants.iter().map(|&(name, value)| (name, value.into())).collect();

        // Load the text; a refusal is retold with the true file and line.
        let loaded = self.scoped(stage, || {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&label),
                source: wgpu::ShaderSource::Wgsl(composed.source.as_str().into()),
            })
        });
        let module = loaded.map_err(|e| match e {
            Error::Device { stage, why } => Error::Device { stage, why: retold(&why, &composed) },
            other => other,
        })?;

        // Lay out the bindings: the parameters, then the buffers.
        let entry = |binding: u32, ty: wgpu::BindingType| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
        let mut entries = vec![entry(0, buffer(wgpu::BufferBindingType::Uniform, true))];
        entries.extend(kernel.buffers.iter().enumerate().map(|(i, &access)| {
            let ty = match access {
                Access::Scene if kernel.paged => super::paged::BINDING,
                _ => buffer(wgpu::BufferBindingType::Storage { read_only: access != Access::Write }, false),
            };
            entry(i as u32 + 1, ty)
        }));
        self.scoped(stage, || {
            let layout =
                device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(&label), entries: &entries });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(&label),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&label),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            });
            Pipeline { pipeline, layout, group: self.group, seconds: start.elapsed().as_secs_f64(), warm: OnceLock::new() }
        })
    }
}

/// A compiler message with its first `wgsl:line:column` led back to the source file.
fn retold(why: &str, composed: &wgsl::Composed) -> String {
    let line = why.split("wgsl:").nth(1).and_then(|rest| rest.split(':').next()).and_then(|n| n.parse().ok());
    match line {
        Some(line) => format!("{}: {why}", composed.locate(line)),
        None => why.to_string(),
    }
}
