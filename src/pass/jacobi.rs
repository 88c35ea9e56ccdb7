//! Pass `jacobi`: sweeps of the iteration. Twin: [`crate::twin::jacobi`].
//!
//! Two kernels: `beta` finds what each cell sends, `update` what arrives at each node.

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, Kernel, LIGHT};
use crate::layout::{Link, Material, NodeLight, Plane};
use crate::twin::jacobi::System;

/// Sweeps in a submission, at most.
const SWEEPS: usize = 32;
/// Links that a submission reads, at most: what keeps it short.
const LINKS: usize = 1 << 24;

params!(
    /// Parameters of `wgsl/beta.wgsl` and `wgsl/update.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Padding.
        pad0: u32,
    }
);

pub(super) const BETA: Kernel = Kernel::new(
    "beta",
    &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write],
);
pub(super) const UPDATE: Kernel =
    Kernel::new("update", &[Access::Read, Access::Read, Access::Read, Access::Read, Access::Read, Access::Write, Access::Write]);

/// Bands of a scene's light, as the kernels hold them: all three, or where the scene is grey the first alone.
#[derive(Clone, Copy, Debug)]
struct Bands {
    grey: bool,
}

impl Bands {
    /// Words that a cell takes.
    fn of_cell(self) -> usize {
        if self.grey { 1 } else { 4 }
    }

    /// Words that a node's light takes.
    fn of_node(self) -> usize {
        if self.grey { 3 } else { size_of::<NodeLight>() / size_of::<f32>() }
    }

    /// Those of cells; one of no light where there are none, as a binding holds one at least.
    fn cells(self, cells: &[[f32; 4]]) -> Vec<f32> {
        if cells.is_empty() {
            return vec![0.0; self.of_cell()];
        }
        cells.iter().flat_map(|c| &c[..self.of_cell()]).copied().collect()
    }

    /// Those of nodes; likewise.
    fn nodes(self, light: &[NodeLight]) -> Vec<f32> {
        if light.is_empty() {
            return vec![0.0; self.of_node()];
        }
        match self.grey {
            true => light.iter().flat_map(|l| [l.h[0], l.g0[0], l.g1[0]]).collect(),
            false => bytemuck::cast_slice(light).to_vec(),
        }
    }

    fn light(self, words: &[f32]) -> Vec<NodeLight> {
        let one = |w: &[f32]| NodeLight { h: [w[0]; 3], g0: [w[1]; 3], g1: [w[2]; 3], ..NodeLight::default() };
        match self.grey {
            true => words.chunks_exact(3).map(one).collect(),
            false => bytemuck::pod_collect_to_vec(words),
        }
    }
}

/// A linear system on the device.
#[derive(Clone, Debug)]
pub struct SystemBuffers {
    bands: Bands,
    cells: usize,
    cell_offsets: GpuVec<u32>,
    cell_links: GpuVec<Link>,
    source: GpuVec<f32>,
    node_offsets: GpuVec<u32>,
    node_links: GpuVec<Link>,
    planes: GpuVec<Plane>,
    known: GpuVec<f32>,
    /// The nodes' own materials, where they have some; `planes` then name these.
    materials: Option<GpuVec<Material>>,
    beta: GpuVec<f32>,
}

impl SystemBuffers {
    /// Uploads a system; of a `grey` scene one band.
    pub fn new(gpu: &Gpu, system: &System, grey: bool) -> Result<SystemBuffers> {
        let (bands, cells) = (Bands { grey }, system.source.len());
        let own = !system.materials.is_empty();
        let named = |(j, p): (usize, &Plane)| Plane { material: if own { j as u32 } else { p.material }, ..*p };
        let planes: Vec<Plane> = system.planes.iter().enumerate().map(named).collect();
        Ok(SystemBuffers {
            bands,
            cells,
            cell_offsets: gpu.upload("cell offsets", &system.cell_offsets)?,
            cell_links: gpu.upload("cell links", &system.cell_links)?,
            source: gpu.upload("source", &bands.cells(&system.source))?,
            node_offsets: gpu.upload("node offsets", &system.node_offsets)?,
            node_links: gpu.upload("node links", &system.node_links)?,
            planes: gpu.upload("planes", &planes)?,
            known: gpu.upload("known light", &bands.nodes(&system.node_source))?,
            beta: gpu.alloc("beta", cells.max(1) * bands.of_cell())?,
            materials: own.then(|| gpu.upload("node materials", &system.materials)).transpose()?,
        })
    }

    /// Bytes that a sweep moves once for each band or all of them: what cells send, and what nodes are lit by.
    pub fn band_bytes(&self) -> u64 {
        let words = 2 * self.cells * self.bands.of_cell() + 2 * self.planes.len() * self.bands.of_node();
        (words * size_of::<f32>()) as u64
    }
}

/// Sweeps from `light`; of a system of one band it is grey, too.
pub fn jacobi(
    gpu: &Gpu,
    scene: &SceneBuffers,
    system: &SystemBuffers,
    light: &[NodeLight],
    sweeps: u32,
) -> Result<Vec<NodeLight>> {
    let nodes_there = light.len();
    let light = gpu.upload("light", &system.bands.nodes(light))?;
    let [cells, nodes] = [BETA, UPDATE].map(|kernel| kernel.grey(system.bands.grey));
    let beta = [
        system.cell_offsets.buffer(),
        system.cell_links.buffer(),
        system.source.buffer(),
        system.planes.buffer(),
        system.materials.as_ref().unwrap_or(&scene.materials).buffer(),
        light.buffer(),
        system.beta.buffer(),
        gpu.status(),
    ];
    let update = [
        system.node_offsets.buffer(),
        system.node_links.buffer(),
        system.planes.buffer(),
        system.known.buffer(),
        system.beta.buffer(),
        light.buffer(),
        gpu.status(),
    ];
    let params = |kernel| Params { flag: gpu.flag(kernel), ..Params::default() };
    let beta = gpu.prepare(&cells, &params(&cells), &beta, system.cells, LIGHT)?;
    let update = gpu.prepare(&nodes, &params(&nodes), &update, system.planes.len(), LIGHT)?;
    let links = system.cell_links.len() + system.node_links.len();
    let most = (LINKS / links.max(1)).clamp(1, SWEEPS);
    let mut left = sweeps as usize;
    while left > 0 {
        let now = left.min(most);
        gpu.run_jobs(&[&beta, &update], now)?;
        left -= now;
    }
    let mut swept = system.bands.light(&gpu.read_finished(&light, 0, light.len())?);
    swept.truncate(nodes_there);
    Ok(swept)
}
