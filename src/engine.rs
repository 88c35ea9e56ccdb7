//! What a bake asks of the machine it runs on: one method a pass. [`crate::twin::TwinEngine`] answers
//! in plain Rust, `crate::pass::GpuEngine` with compute shaders.

use crate::error::Result;
use crate::gpu::Gpu;
use crate::layout::{CellSums, DirectSum, NodeLight, NodeSource, Point, Psi, Tile};
use crate::twin::assign::Surface;
use crate::twin::coefficients::Sums;
use crate::twin::direct::{DirectRays, Samples};
use crate::twin::gather::Gathered;
use crate::twin::jacobi::System;
use crate::twin::respond::Responder;
use crate::twin::winner::{Feature, Metric};
use std::ops::Range;
use std::sync::Arc;

/// What a bake runs on.
#[derive(Clone)]
#[non_exhaustive]
pub enum Backend {
    /// The plain-Rust twins: slow, driver-free, the oracle. Never chosen silently.
    Cpu,
    /// Compute shaders on a device, the host's or one from [`crate::gpu::device::open`].
    Gpu(Arc<Gpu>),
}

impl Backend {
    /// Seconds spent on compiling kernels since the device was opened.
    pub(crate) fn compile_seconds(&self) -> f64 {
        match self {
            Backend::Cpu => 0.0,
            Backend::Gpu(gpu) => gpu.compiled(),
        }
    }
}

/// A machine that runs the passes over one prepared scene.
///
/// Arrays live in [`Engine::Batch`]es: points, and what the passes have found about each of them.
/// Of the supervised network it answers the passes of [`Responder`].
/// Counts and ranges are in points unless a name says rays; a ray is two consecutive points.
#[doc(hidden)]
pub trait Engine: Responder {
    /// Points that live on the machine, with their direct light, weights, features and winners.
    type Batch;

    /// Takes points over from the host.
    fn upload(&mut self, points: &[Point]) -> Result<Self::Batch>;
    /// Gives points back to the host.
    fn points(&mut self, batch: &Self::Batch) -> Result<Vec<Point>>;

    /// Pass `emit`: rays `first..first + count` of sequence `seed` from start densities `tiles`; two points a ray.
    fn emit(&mut self, tiles: &[Tile], seed: u32, first: u32, count: u32, total: u32) -> Result<Self::Batch>;
    /// Pass `shoot`: `rays` consecutive cosine rays of each point; a point a ray.
    fn shoot(&mut self, from: &Self::Batch, seed: u32, first: u32, rays: u32) -> Result<Self::Batch>;

    /// Pass `kernel`: G V of consecutive pairs of points, per local area.
    fn kernel(&mut self, pairs: &[Point]) -> Result<Vec<f32>>;

    /// Pass `direct`: adds rounds `first..first + rounds` to the listed points' direct light (all points where `None`).
    fn direct(
        &mut self,
        batch: &mut Self::Batch,
        active: Option<&[u32]>,
        seed: u32,
        first: u32,
        rounds: u32,
        samples: Samples,
    ) -> Result<()>;
    /// Sets direct light that was found earlier.
    fn set_direct(&mut self, batch: &mut Self::Batch, sums: &[DirectSum]) -> Result<()>;
    /// The direct light found so far.
    fn direct_sums(&mut self, batch: &Self::Batch) -> Result<Vec<DirectSum>>;

    /// Sets the surface network that later passes use.
    fn set_surface(&mut self, surface: &Surface) -> Result<()>;
    /// Sets the nodes' light that `readout` uses.
    fn set_light(&mut self, light: &[NodeLight]) -> Result<()>;
    /// Pass `assign`: the nodes that speak for each point.
    fn assign(&mut self, batch: &mut Self::Batch) -> Result<()>;
    /// The weights that `assign` found.
    fn psi(&mut self, batch: &Self::Batch) -> Result<Vec<Psi>>;
    /// Replaces them.
    fn set_psi(&mut self, batch: &mut Self::Batch, psi: &[Psi]) -> Result<()>;

    /// Pass `feature`: every directed ray of a batch as a point of ray space.
    fn feature(&mut self, batch: &mut Self::Batch, metric: Metric, brightness: &[f32]) -> Result<()>;
    /// The features of a range of directed rays.
    fn features(&mut self, batch: &Self::Batch, range: Range<usize>) -> Result<Vec<Feature>>;
    /// Pass `winner`: the best-matching cell of each directed ray in the range.
    fn winner(&mut self, batch: &mut Self::Batch, range: Range<usize>, cells: &[Feature]) -> Result<()>;
    /// The winners of a batch.
    fn winners(&mut self, batch: &Self::Batch) -> Result<Vec<u32>>;
    /// Replaces the winners of a batch.
    fn set_winners(&mut self, batch: &mut Self::Batch, winners: &[u32]) -> Result<()>;
    /// Pass `accumulate`: what the directed rays of a range leave in their cells.
    fn accumulate(&mut self, batch: &Self::Batch, range: Range<usize>, cells: &[Feature]) -> Result<Vec<CellSums>>;
    /// Pass `adapt`: the cells' next places.
    fn adapt(
        &mut self,
        cells: &[Feature],
        sums: &[CellSums],
        offsets: &[u32],
        neighbours: &[u32],
        eta: f32,
    ) -> Result<Vec<Feature>>;

    /// Pass `coefficients`: the cells' footprints over all batches; with `exact`, emitter ends send
    /// rho D instead of E. See [`crate::twin::coefficients::coefficients`]. The longest of all passes: `beat` is
    /// called when a batch is done, and its error ends the pass.
    fn coefficients(
        &mut self,
        batches: &[Self::Batch],
        exact: bool,
        normalise: f32,
        rays: f32,
        cells: usize,
        beat: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Sums>;
    /// Pass `deposit`: what the rays of all batches bring to the nodes from rho (D + H) at their emitter
    /// ends, or without `exact` from E + rho H; H is what `readout` found where `lit`, else 0. `direct` must have
    /// run where `exact`.
    fn deposit(&mut self, batches: &[Self::Batch], exact: bool, lit: bool, normalise: f32) -> Result<Vec<NodeSource>>;
    /// Sets the linear system that `jacobi` iterates.
    fn set_system(&mut self, system: &System) -> Result<()>;
    /// Pass `jacobi`: `sweeps` sweeps from `light`.
    fn jacobi(&mut self, light: &[NodeLight], sweeps: u32) -> Result<Vec<NodeLight>>;

    /// Pass `readout`: the network's irradiance at each point; `assign` must have run.
    fn readout(&mut self, batch: &mut Self::Batch) -> Result<()>;
    /// The irradiance that `readout` found.
    fn irradiance(&mut self, batch: &Self::Batch) -> Result<Vec<[f32; 4]>>;
    /// Sets irradiance that was found otherwise, a value each point.
    fn set_irradiance(&mut self, batch: &mut Self::Batch, light: &[[f32; 4]]) -> Result<()>;
    /// Pass `gather`: means over `rays` consecutive hits a point. With `lit`, `readout` (and with
    /// `exact` also `direct`) must have run on the hits; without, only distances and shares are found.
    fn gather(&mut self, hits: &Self::Batch, rays: u32, lit: bool, exact: bool) -> Result<Vec<Gathered>>;

    /// Waits until all passes asked for so far are done; for honest timings.
    fn finish(&mut self) -> Result<()>;
    /// Whether the scene has mirrors.
    fn has_mirrors(&self) -> bool;
    /// Seconds spent compiling kernels so far.
    fn compile_seconds(&self) -> f64;
    /// Rays of direct light so far; those that carry no light are counted, too.
    fn direct_rays(&self) -> DirectRays;
    /// Bytes that the sweeps of [`Engine::jacobi`] have moved once for each colour band, or for all of them.
    fn band_bytes(&self) -> u64;
    /// Bytes that live on the machine now (the host's own memory for the twin).
    fn device_bytes(&self) -> u64;
}
