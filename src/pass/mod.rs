//! One file a GPU pass: what it binds and how it is dispatched, nothing else.
//!
//! The functions take and give vectors that stay on the device, and do not wait. Before results are
//! trusted, [`Gpu::check_finished`] tells whether every kernel came to its end.

pub mod accumulate;
pub mod adapt;
pub mod assign;
pub mod coefficients;
pub mod deposit;
pub mod direct;
pub mod emit;
pub mod engine;
pub mod feature;
pub mod gather;
pub mod jacobi;
pub mod kernel;
pub mod readout;
pub mod respond;
pub mod shoot;
pub mod winner;

pub use engine::GpuEngine;

use crate::error::{Error, Result};
use crate::gpu::{Access, Bound, Constants, Gpu, GpuVec, Kernel, Records, sentinel};
use crate::layout::{BvhNode, Candidate, Emitter, Material, Node, Tri};
use crate::scene::{Called, Geometry, Scene, depth};
use crate::twin::assign::Surface;
use crate::twin::direct::Sources;
use crate::twin::trace::STACK;

/// The kernels that bakes and read-outs use in any space, with the sentinel that comes first.
const KERNELS: &[Kernel] = &[
    sentinel::KERNEL,
    accumulate::KERNEL,
    adapt::KERNEL,
    feature::KERNEL,
    jacobi::BETA,
    jacobi::UPDATE,
    readout::KERNEL,
    respond::KERNEL,
    winner::KERNEL,
];
/// Those that sum what rays have carried.
const SUMS: &[Kernel] = &[coefficients::KERNEL, coefficients::FLUX, deposit::KERNEL, gather::KERNEL];
/// Those that look at surfaces, each once for every space.
const SPATIAL: &[Kernel] = &[assign::KERNEL, direct::KERNEL, emit::KERNEL, emit::PROBE, shoot::KERNEL];

/// What sets the shaders to what a scene calls for.
fn constants(called: &Called) -> Constants {
    Constants::NONE
        .with("FLATLAND", called.flatland)
        .with("OCCLUSION", called.occlusion)
        .with("ENVIRONMENT", called.environment)
        .with("ENVIRONMENT_MAP", called.environment_map)
        .with("LIGHTS", called.lights)
        .with("SURFACELESS", called.environment || called.lights)
        .with("LOSSY", called.is_lossy())
        .with("MIRRORS", called.mirrors)
        .with("SIGMA", called.sigma)
        .with("TEXTURES", called.textures)
        .with("CUTOUTS", called.cutouts)
}

/// The same of kernels that shoot no rays and sum what rays have carried.
fn sums(called: &Called) -> Constants {
    let lossy = if called.is_lossy() { Constants::NONE.with("LOSSY", true) } else { Constants::NONE };
    if called.textures { lossy.with("TEXTURES", true).with("FLATLAND", called.flatland) } else { lossy }
}

/// Every kernel with every text and every set of constants that it may have.
pub fn variants() -> Vec<Kernel> {
    let each = [false, true];
    let none = Called { occlusion: true, ..Called::default() };
    // What only direct light knows of.
    let lit = [(true, false, false), (true, true, false), (false, false, true), (true, true, true)];
    let lit = lit.map(|(environment, environment_map, lights)| Called { environment, environment_map, lights, ..none });
    let flat = Called { flatland: true, environment: true, ..none };
    let [over, through] = [Called { mirrors: true, ..lit[0] }, Called { sigma: 0.5, ..lit[3] }];
    // All effects of light and of surfaces at once.
    let all = Called { mirrors: true, sigma: 0.5, textures: true, cutouts: true, ..lit[3] };
    let lit = lit.into_iter().chain([flat, over, through, all]).map(|called| direct::KERNEL.with(constants(&called)));
    let spaces = each.into_iter().flat_map(|flatland| each.map(|occlusion| (flatland, occlusion)));
    let ways = [(false, 0.0), (true, 0.0), (false, 0.5), (true, 0.5)];
    let call = |(flatland, occlusion)| ways.map(move |(mirrors, sigma)| Called { flatland, occlusion, mirrors, sigma, ..none });
    // Maps in one space are enough: they know of no other.
    let maps = [(true, false), (false, true), (true, true)];
    let maps = maps.map(|(textures, cutouts)| Called { textures, cutouts, ..none });
    let lossy = maps.map(|called| Called { mirrors: true, sigma: 0.5, ..called });
    let calls = spaces.flat_map(call).chain(maps).chain(lossy);
    let spatial = || SPATIAL.iter().copied().chain([kernel::KERNEL]);
    let spatial = calls.flat_map(|called| spatial().map(move |k| k.with(constants(&called))));
    let carried = |(flatland, mirrors, textures)| sums(&Called { flatland, mirrors, textures, ..none });
    let summing = [(false, false, false), (false, true, false), (false, false, true), (true, false, true), (false, true, true)];
    let summing = summing.map(carried).into_iter();
    let summing = summing.flat_map(|constants| SUMS.iter().map(move |k| k.with(constants)));
    let grey = [jacobi::BETA, jacobi::UPDATE].map(|k| k.grey(true));
    let all = KERNELS.iter().copied().chain(grey).chain(summing).chain(spatial).chain(lit);
    all.flat_map(|k| if k.buffers.contains(&Access::Scene) { vec![k, k.paged(true)] } else { vec![k] }).collect()
}

/// The kernels that bakes and read-outs of a scene use on a device.
pub(crate) fn kernels(device: &wgpu::Device, scene: &Scene) -> Vec<Kernel> {
    let called = Called::by_scene(scene);
    let (constants, sums) = (constants(&called), sums(&called));
    let bytes = (scene.faces.len() * size_of::<Tri>()) as u64;
    let paged = bytes > device.limits().max_storage_buffer_binding_size;
    let all = KERNELS.iter().copied().chain(SUMS.iter().map(|k| k.with(sums))).chain(SPATIAL.iter().map(|k| k.with(constants)));
    let in_bands = |k: &Kernel| [jacobi::BETA.name, jacobi::UPDATE.name].contains(&k.name);
    all.map(|k| k.paged(paged && k.buffers.contains(&Access::Scene)).grey(called.grey && in_bands(&k))).collect()
}

/// Declares a kernel's parameters: `base` and `count`, which the dispatcher writes, then the pass's own.
macro_rules! params {
    ($(#[$doc:meta])* { $($(#[$field_doc:meta])* $field:ident : $ty:ty),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct Params {
            /// First item.
            pub base: u32,
            /// Items in the dispatch.
            pub count: u32,
            $($(#[$field_doc])* pub $field: $ty),*
        }
    };
}
use params;

/// A scene's geometry on the device.
#[derive(Clone, Debug)]
pub struct SceneBuffers {
    /// Hierarchy.
    pub nodes: Records<BvhNode>,
    /// Triangles.
    pub tris: Records<Tri>,
    /// Materials.
    pub materials: GpuVec<Material>,
    /// Emitters.
    pub emitters: GpuVec<Emitter>,
    /// Sampling density of an emitter per unit of its summed emission.
    pub emitter_density: f32,
    /// Lights without a surface, and the sky.
    pub(crate) surfaceless: Surfaceless,
    /// What tells how many rays a round of direct light takes.
    pub(crate) sources: Sources,
    /// Triangle of each tile.
    pub tile_tri: GpuVec<u32>,
    /// Maps of the triangles, where there are any.
    texels: Option<Records<[u32; 4]>>,
    /// What sets the shaders to what it calls for.
    constants: Constants,
    /// The same of kernels that sum what rays have carried.
    sums: Constants,
    /// Whether hierarchy and triangles are paged.
    paged: bool,
}

impl SceneBuffers {
    /// Uploads a scene.
    ///
    /// Errors: [`Error::Limit`] where the hierarchy is too deep for the traversal stack or a buffer too large.
    pub fn new(gpu: &Gpu, geometry: &Geometry) -> Result<SceneBuffers> {
        check_depth(&geometry.nodes)?;
        let paged = gpu.must_page(size_of_val(&geometry.nodes[..]).max(size_of_val(&geometry.tris[..])));
        Ok(SceneBuffers {
            nodes: Records::upload(gpu, "nodes", &geometry.nodes, paged)?,
            tris: Records::upload(gpu, "tris", &geometry.tris, paged)?,
            materials: gpu.upload("materials", &geometry.materials)?,
            emitters: gpu.upload("emitters", &geometry.emitters)?,
            emitter_density: geometry.emitter_density,
            surfaceless: Surfaceless::new(gpu, geometry)?,
            sources: Sources::of(geometry),
            tile_tri: gpu.upload("tile_tri", &geometry.tile_tri)?,
            texels: (!geometry.texels.is_empty()).then(|| Records::page(gpu, "texels", &geometry.texels)).transpose()?,
            constants: constants(&Called::by(geometry)),
            sums: sums(&Called::by(geometry)),
            paged,
        })
    }

    /// A kernel that looks at surfaces, set to this scene's space and size.
    fn kernel(&self, kernel: Kernel) -> Kernel {
        self.reader(kernel).with(self.constants)
    }

    /// A kernel that sums what rays have carried, set to this scene's losses, maps and size.
    fn summing(&self, kernel: Kernel) -> Kernel {
        self.reader(kernel).with(self.sums)
    }

    /// The texels of its maps.
    fn texels(&self) -> Bound {
        self.texels.as_ref().map_or(Bound::Absent, Records::bound)
    }

    /// A kernel that reads triangles, set to this scene's size.
    fn reader(&self, kernel: Kernel) -> Kernel {
        kernel.paged(self.paged)
    }
}

/// What shines without a surface, on the device.
#[derive(Clone, Debug)]
pub(crate) struct Surfaceless {
    sky: Option<Records<[u32; 4]>>,
    lights: Option<Records<[u32; 4]>>,
}

impl Surfaceless {
    fn new(gpu: &Gpu, geometry: &Geometry) -> Result<Surfaceless> {
        let Geometry { sky, lights, .. } = geometry;
        let mut texels = vec![[lights.suns, lights.all.len() as u32, 0, 0]];
        texels.extend_from_slice(bytemuck::cast_slice(&lights.all));
        let page = |label, texels: &[[u32; 4]], is: bool| is.then(|| Records::page(gpu, label, texels)).transpose();
        Ok(Surfaceless { sky: page("sky", &sky.texels, !sky.is_empty())?, lights: page("lights", &texels, !lights.is_empty())? })
    }

    /// What `direct` binds: the sky, and the lights.
    fn bound(&self) -> [Bound; 2] {
        [&self.sky, &self.lights].map(|records| records.as_ref().map_or(Bound::Absent, Records::bound))
    }
}

/// A surface network on the device.
#[derive(Clone, Debug)]
pub struct SurfaceBuffers {
    /// Nodes.
    pub nodes: GpuVec<Node>,
    /// The candidates: each tile's group where tiles share lists; the start of each list, one more than there are lists;
    /// then all lists by words.
    pub lists: GpuVec<u32>,
    /// Where the lists begin.
    pub first_list: u32,
    /// Where the starts of lists begin that tiles share; 0: each tile has its own.
    pub joint: u32,
    /// 1/L, per local length.
    pub inv_unit: f32,
    /// Weight of normals.
    pub lambda: f32,
}

impl SurfaceBuffers {
    /// Uploads a surface network.
    pub fn new(gpu: &Gpu, surface: &Surface) -> Result<SurfaceBuffers> {
        let mut lists = surface.groups.as_ref().map_or(Vec::new(), |groups| groups.of_tile.clone());
        let joint = lists.len() as u32;
        lists.extend_from_slice(&surface.offsets);
        let first_list = lists.len() as u32;
        lists.extend_from_slice(bytemuck::cast_slice::<Candidate, u32>(&surface.candidates));
        Ok(SurfaceBuffers {
            nodes: gpu.upload("surface nodes", &surface.nodes)?,
            lists: gpu.upload("candidates", &lists)?,
            first_list,
            joint,
            inv_unit: surface.inv_unit,
            lambda: surface.lambda,
        })
    }
}

/// Refuses a hierarchy that is too deep for the traversal stack, on the device and in the twin.
pub(crate) fn check_depth(nodes: &[BvhNode]) -> Result<()> {
    let depth = depth(nodes);
    if depth <= STACK {
        return Ok(());
    }
    Err(Error::Limit {
        what: "the scene's hierarchy".into(),
        limit: "traversal stack",
        need: depth as u64,
        have: STACK as u64,
        cure: "split very long triangles, or remove repeated geometry",
    })
}
