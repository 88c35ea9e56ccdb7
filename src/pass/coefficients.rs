//! Pass `coefficients`: the cells' measured footprints on the nodes. Twin: [`crate::twin::coefficients`].
//!
//! Two kernels: `coefficients` sums the nodes' masses and the cells' rows, `flux` the cells' flux and source.

use super::{SceneBuffers, SurfaceBuffers, params};
use crate::error::{Error, Result};
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel, LIGHT};
use crate::layout::{CellFlux, DirectSum, NodeSums, Point, Psi, Slot};
use crate::twin::coefficients::Sums;

/// Slots a row starts with at least, and at most where few cells leave room; doubled as long as any row is full.
const SLOTS: [usize; 2] = [128, 512];
/// Most slots a row may take: the loop budget.
const MAX_SLOTS: usize = 2048;
/// Bytes of rows that are summed at a time.
const ROW_BYTES: usize = 64 << 20;

params!(
    /// Parameters of `wgsl/coefficients.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// First cell of the dispatch.
        first: u32,
        /// End of its cells.
        end: u32,
        /// Slots a row, a power of two.
        slots: u32,
        /// 1: sum the nodes' masses, too.
        masses: u32,
        /// What weights are multiplied by.
        normalise: f32,
        /// Number of rays n.
        rays: f32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
        /// Padding.
        pad2: u32,
    }
);

/// Parameters of `wgsl/flux.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub struct FluxParams {
    /// First item.
    pub base: u32,
    /// Items in the dispatch.
    pub count: u32,
    /// 1: emitter ends send rho D, 0: E.
    pub exact: u32,
    /// What weights are multiplied by.
    pub normalise: f32,
}

pub(super) const KERNEL: Kernel = Kernel::new(
    "coefficients",
    &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write, Access::Write, Access::Write],
);
pub(super) const FLUX: Kernel =
    Kernel::new("flux", &[Access::Read, Access::Read, Access::Scene, Access::Read, Access::Read, Access::Write, Access::Texels]);

/// A batch of rays and what is known of them.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    /// Points, two a ray.
    pub points: &'a GpuVec<Point>,
    /// The points' weights on the nodes.
    pub psi: &'a GpuVec<Psi>,
    /// The cell of each directed ray.
    pub winners: &'a GpuVec<u32>,
    /// D at each point where direct light is exact.
    pub direct: Option<&'a GpuVec<DirectSum>>,
}

/// Sums all batches; see [`crate::twin::coefficients::coefficients`]. Waits for each batch before `beat`,
/// and for the result, which the host compacts.
pub fn coefficients(
    gpu: &Gpu,
    scene: &SceneBuffers,
    surface: &SurfaceBuffers,
    batches: &[Rays],
    normalise: f32,
    rays: f32,
    cells: usize,
    beat: &mut dyn FnMut() -> Result<()>,
) -> Result<Sums> {
    // A full row does its round again: start with as many slots as rows for all cells have room for.
    let room = ROW_BYTES / (2 * size_of::<Slot>() * cells.max(1));
    let mut slots = (room.max(1).next_power_of_two() / 2).clamp(SLOTS[0], SLOTS[1]);
    let node_sums = gpu.alloc::<NodeSums>("node sums", surface.nodes.len())?;
    let overflow = gpu.alloc::<u32>("overflow", 1)?;
    let mut sums = Sums { gather: vec![], deposit: vec![], flux: flux(gpu, scene, batches, normalise, cells)?, nodes: vec![] };

    // Take as many cells at a time as rows fit; at least one round, for the masses.
    let mut masses = true;
    while sums.gather.len() < cells || masses {
        let first = sums.gather.len();
        let here = (ROW_BYTES / (2 * slots * size_of::<Slot>())).max(1).min(cells - first);
        let rows = gpu.alloc::<Slot>("rows", 2 * here * slots)?;
        for batch in batches {
            let params = Params {
                flag: gpu.flag(&KERNEL),
                first: first as u32,
                end: (first + here) as u32,
                slots: slots as u32,
                masses: masses as u32,
                normalise,
                rays,
                ..Params::default()
            };
            let buffers = [
                batch.points.buffer(),
                batch.psi.buffer(),
                batch.winners.buffer(),
                surface.nodes.buffer(),
                rows.buffer(),
                node_sums.buffer(),
                overflow.buffer(),
                gpu.status(),
            ];
            gpu.run(&KERNEL.with(scene.sums), &params, &buffers, batch.points.len(), HEAVY)?;
            gpu.check_finished()?;
            beat()?;
        }
        masses = false;

        // A full row: do these cells again with longer ones. The masses stand.
        if gpu.read(&overflow)?[0] != 0 {
            slots *= 2;
            if slots > MAX_SLOTS {
                return Err(Error::Limit {
                    what: "kernel coefficients".into(),
                    limit: "nodes that a cell touches",
                    need: slots as u64,
                    have: MAX_SLOTS as u64,
                    cure: "use more cells or fewer nodes",
                });
            }
            gpu.clear(&overflow)?;
            continue;
        }
        let mut rows = gpu.read(&rows)?.into_iter();
        for _ in 0..here {
            for side in [&mut sums.gather, &mut sums.deposit] {
                let mut row: Vec<Slot> = rows.by_ref().take(slots).filter(|s| s.key != 0).collect();
                row.sort_unstable_by_key(|s| s.key);
                side.push(row);
            }
        }
    }
    sums.nodes = gpu.read(&node_sums)?;
    Ok(sums)
}

/// Flux and source of each cell.
fn flux(gpu: &Gpu, scene: &SceneBuffers, batches: &[Rays], normalise: f32, cells: usize) -> Result<Vec<CellFlux>> {
    let sums = gpu.alloc::<CellFlux>("flux", cells)?;
    let none = gpu.alloc::<DirectSum>("no direct light", 0)?;
    for batch in batches {
        let params = FluxParams { exact: batch.direct.is_some() as u32, normalise, ..FluxParams::default() };
        let buffers = [
            batch.points.bound(),
            batch.winners.bound(),
            scene.tris.bound(),
            scene.materials.bound(),
            batch.direct.unwrap_or(&none).bound(),
            sums.bound(),
            scene.texels(),
        ];
        gpu.run(&scene.summing(FLUX), &params, &buffers, batch.points.len(), LIGHT)?;
    }
    gpu.read(&sums)
}
