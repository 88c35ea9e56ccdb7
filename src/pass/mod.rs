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
use crate::twin::trace::STACK;

/// The kernels that bakes and read-outs use in any space, with the sentinel that comes first.
const KERNELS: &[Kernel] = &[
    sentinel::KERNEL,
    accumulate::KERNEL,
    adapt::KERNEL,
    coefficients::KERNEL,
    feature::KERNEL,
    jacobi::BETA,
    jacobi::UPDATE,
    readout::KERNEL,
    respond::KERNEL,
    winner::KERNEL,
];
/// Those that look at surfaces, each once for every space.
const SPATIAL: &[Kernel] = &[assign::KERNEL, direct::KERNEL, emit::KERNEL, emit::PROBE, shoot::KERNEL];
/// Those that read what a surface reflects and emits, each once for scenes with textures.
const TEXTURED: &[Kernel] = &[coefficients::FLUX, deposit::KERNEL, gather::KERNEL];

/// What sets the shaders to what a scene calls for.
fn constants(called: &Called) -> Constants {
    let space = Constants::NONE.with("FLATLAND", called.flatland).with("OCCLUSION", called.occlusion);
    space.with("TEXTURES", called.textures).with("CUTOUTS", called.cutouts)
}

/// Every kernel with every text and every set of constants that it may have.
pub fn variants() -> Vec<Kernel> {
    let each = [false, true];
    let plain = |flatland, occlusion| Called { flatland, occlusion, textures: false, cutouts: false, grey: false };
    let calls = each.into_iter().flat_map(|flatland| each.map(|occlusion| plain(flatland, occlusion)));
    // Effects of surfaces in one space are enough: they know of no other.
    let maps = [(true, false), (false, true), (true, true)].map(|(textures, cutouts)| Called {
        textures,
        cutouts,
        ..plain(false, true)
    });
    let spatial = || SPATIAL.iter().chain(TEXTURED).copied().chain([kernel::KERNEL]);
    let spatial = calls.chain(maps).flat_map(|called| spatial().map(move |k| k.with(constants(&called))));
    let grey = [jacobi::BETA, jacobi::UPDATE].map(|k| k.grey(true));
    let all = KERNELS.iter().copied().chain(grey).chain(spatial);
    all.flat_map(|k| if k.buffers.contains(&Access::Scene) { vec![k, k.paged(true)] } else { vec![k] }).collect()
}

/// The kernels that bakes and read-outs of a scene use on a device.
pub(crate) fn kernels(device: &wgpu::Device, scene: &Scene) -> Vec<Kernel> {
    let called = Called::by_scene(scene);
    let constants = constants(&called);
    let bytes = (scene.faces.len() * size_of::<Tri>()) as u64;
    let paged = bytes > device.limits().max_storage_buffer_binding_size;
    let all = KERNELS.iter().copied().chain(SPATIAL.iter().chain(TEXTURED).map(|k| k.with(constants)));
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
    /// Triangle of each tile.
    pub tile_tri: GpuVec<u32>,
    /// Maps of the triangles, where there are any.
    texels: Option<Records<[u32; 4]>>,
    /// What sets the shaders to what it calls for.
    constants: Constants,
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
            tile_tri: gpu.upload("tile_tri", &geometry.tile_tri)?,
            texels: (!geometry.texels.is_empty()).then(|| Records::page(gpu, "texels", &geometry.texels)).transpose()?,
            constants: constants(&Called::by(geometry)),
            paged,
        })
    }

    /// A kernel that looks at surfaces, set to this scene's space and size.
    fn kernel(&self, kernel: Kernel) -> Kernel {
        self.reader(kernel).with(self.constants)
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
