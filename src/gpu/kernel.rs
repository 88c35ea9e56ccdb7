//! Kernels: their bindings, and their pipelines, made when first used.

use super::Gpu;
use super::specialise::specialise;
use super::wgsl::{self, Text};
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
    /// An effect's data: always texels, which take none of the eight storage buffers.
    Texels,
}

/// What the host knows of a kernel before it is compiled: a constant beside the pass that uses it.
///
/// Binding 0 is the uniform `Params`, which starts with `base` and `count`; the storage buffers follow from binding 1, then
/// the texels of effects. Which of them a pipeline has is found when it is [specialised](super::specialise).
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name of the kernel: `wgsl/<name>.wgsl`, entry `main`.
    pub name: &'static str,
    /// The storage buffers, at most eight, and the texels of effects.
    pub buffers: &'static [Access],
    /// Values of its `override` constants, where they are not the shader's own; another pipeline each.
    pub constants: Constants,
    /// Which of its texts: another pipeline each.
    pub text: Text,
}

/// Most constants of a kernel.
const MOST_CONSTANTS: usize = 12;

/// Names and values of `override` constants: what a scene calls for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Constants {
    // Values by their bits, so that pipelines are told apart by them.
    list: [(&'static str, u64); MOST_CONSTANTS],
    count: usize,
}

/// A value that a constant may have.
pub trait ConstantValue {
    /// As WGSL takes it: a `bool` is 0 or 1.
    fn value(self) -> f64;
}

impl ConstantValue for bool {
    fn value(self) -> f64 {
        self.into()
    }
}

impl ConstantValue for f32 {
    fn value(self) -> f64 {
        self.into()
    }
}

impl Constants {
    /// The shader's own.
    pub const NONE: Constants = Constants { list: [("", 0); MOST_CONSTANTS], count: 0 };

    /// One more.
    pub fn with(mut self, name: &'static str, value: impl ConstantValue) -> Constants {
        self.list[self.count] = (name, value.value().to_bits());
        self.count += 1;
        self
    }

    /// Names and values.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.list[..self.count].iter().map(|&(name, bits)| (name, f64::from_bits(bits)))
    }
}

impl std::fmt::Debug for Constants {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_map().entries(self.iter()).finish()
    }
}

/// What tells pipelines apart: the kernel's name, its constants, and its text.
pub(super) type Key = (&'static str, Constants, Text);

impl Kernel {
    /// A kernel with its shader's own constants.
    pub const fn new(name: &'static str, buffers: &'static [Access]) -> Kernel {
        Kernel { name, buffers, constants: Constants::NONE, text: Text { paged: false, grey: false } }
    }

    /// The kernel with other constants.
    pub const fn with(self, constants: Constants) -> Kernel {
        Kernel { constants, ..self }
    }

    /// The kernel for a scene whose records are paged, or not.
    pub const fn paged(self, paged: bool) -> Kernel {
        Kernel { text: Text { paged, ..self.text }, ..self }
    }

    /// The kernel for a scene that is all grey, or not.
    pub const fn grey(self, grey: bool) -> Kernel {
        Kernel { text: Text { grey, ..self.text }, ..self }
    }
}

/// A compiled kernel.
#[derive(Debug)]
pub struct Pipeline {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// The bindings that it has, of the kernel's.
    pub(super) bindings: Vec<u32>,
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
        let key = (kernel.name, kernel.constants, kernel.text);
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
        let mut composed = wgsl::compose(kernel.name, kernel.text);
        if self.group != WORKGROUP {
            composed.source = composed.source.replace(AS_WRITTEN, &format!("@workgroup_size({})", self.group));
        }
        let stage = || format!("compiling {}", kernel.name);
        // What the scene does not call for is taken out; a refusal is told with the true file and line.
        let special = specialise(&composed, &kernel.constants).map_err(|why| Error::Device { stage: stage(), why })?;
        let module = self.scoped(stage, || {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(&label),
                source: wgpu::ShaderSource::Wgsl(special.source.as_str().into()),
            })
        })?;

        // Lay out the bindings that are left: the parameters, buffers, texels.
        let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
        let entries: Vec<wgpu::BindGroupLayoutEntry> = special
            .bindings
            .iter()
            .filter_map(|&binding| {
                // What the pass does not know of is missing in the layout, and wgpu refuses it.
                let ty = match binding.checked_sub(1).map(|i| kernel.buffers.get(i as usize)) {
                    None => buffer(wgpu::BufferBindingType::Uniform, true),
                    Some(None) => return None,
                    Some(Some(Access::Texels)) => super::paged::BINDING,
                    Some(Some(Access::Scene)) if kernel.text.paged => super::paged::BINDING,
                    Some(Some(access)) => buffer(wgpu::BufferBindingType::Storage { read_only: *access != Access::Write }, false),
                };
                Some(wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None })
            })
            .collect();
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
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            Pipeline {
                pipeline,
                layout,
                bindings: special.bindings,
                group: self.group,
                seconds: start.elapsed().as_secs_f64(),
                warm: OnceLock::new(),
            }
        })
    }
}
