//! The machine of compute shaders: every pass by its kernel.

use super::coefficients::Rays;
use super::jacobi::SystemBuffers;
use super::{SceneBuffers, SurfaceBuffers};
use crate::engine::Engine;
use crate::error::Result;
use crate::gpu::{Gpu, GpuVec};
use crate::layout::{CellSums, DirectSum, NONE, NodeLight, NodeSource, Point, Psi, ResponseSums, Sample, Tile, kind};
use crate::scene::{Called, Geometry};
use crate::twin::assign::Surface;
use crate::twin::coefficients::Sums;
use crate::twin::direct::{DirectRays, Samples};
use crate::twin::gather::Gathered;
use crate::twin::jacobi::System;
use crate::twin::respond::{Net, Responder};
use crate::twin::winner::{Feature, Metric};
use bytemuck::Pod;
use std::ops::Range;

/// Runs every pass on a device. What the host reads has passed [`Gpu::check_finished`].
pub struct GpuEngine<'a> {
    gpu: &'a Gpu,
    scene: SceneBuffers,
    surface: SurfaceBuffers,
    light: GpuVec<NodeLight>,
    system: SystemBuffers,
    /// Rays of direct light so far.
    direct_rays: DirectRays,
    mirrors: bool,
    /// Bytes of colour bands that sweeps have moved.
    band_bytes: u64,
    /// Whether the scene is all grey.
    grey: bool,
}

/// Points on the device, with what the passes have found about them.
#[derive(Clone, Debug)]
pub struct GpuBatch {
    points: GpuVec<Point>,
    direct: GpuVec<DirectSum>,
    psi: GpuVec<Psi>,
    features: GpuVec<Feature>,
    winners: GpuVec<u32>,
    irradiance: GpuVec<[f32; 4]>,
    /// All points, those of a tile together; found when first needed.
    order: Option<GpuVec<u32>>,
    /// Directed rays in the order of `winner`; found when first needed.
    rays: Vec<u32>,
}

impl<'a> GpuEngine<'a> {
    /// A machine for one prepared scene.
    ///
    /// Errors: [`crate::Error::Limit`] where the scene exceeds what the device holds.
    pub fn new(gpu: &'a Gpu, geometry: &Geometry) -> Result<GpuEngine<'a>> {
        Ok(GpuEngine {
            gpu,
            scene: SceneBuffers::new(gpu, geometry)?,
            surface: SurfaceBuffers::new(gpu, &Surface::default())?,
            light: gpu.alloc("light", 0)?,
            system: SystemBuffers::new(gpu, &System::default(), false)?,
            mirrors: geometry.mirrors,
            direct_rays: DirectRays::default(),
            band_bytes: 0,
            grey: Called::by(geometry).grey,
        })
    }

    /// A batch of which only the points are known.
    fn batch(&self, points: GpuVec<Point>) -> Result<GpuBatch> {
        let gpu = self.gpu;
        Ok(GpuBatch {
            points,
            direct: gpu.alloc("direct", 0)?,
            psi: gpu.alloc("psi", 0)?,
            features: gpu.alloc("features", 0)?,
            winners: gpu.alloc("winners", 0)?,
            irradiance: gpu.alloc("irradiance", 0)?,
            order: None,
            rays: Vec::new(),
        })
    }

    /// All points of a batch, those of a tile together: neighbouring invocations then walk the same part
    /// of the hierarchy. Results do not depend on it.
    fn order(&self, batch: &mut GpuBatch) -> Result<GpuVec<u32>> {
        if let Some(order) = &batch.order {
            return Ok(order.clone());
        }
        let points = self.gpu.read(&batch.points)?;
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        order.sort_by_key(|&i| points[i as usize].tile);
        let order = self.gpu.upload("order", &order)?;
        batch.order = Some(order.clone());
        Ok(order)
    }

    /// Directed rays of a range by the tile of their receiver; those that do not count come last.
    fn rays(&self, batch: &mut GpuBatch, range: Range<usize>) -> Result<GpuVec<u32>> {
        if batch.rays.is_empty() {
            let points = self.gpu.read(&batch.points)?;
            let mut rays: Vec<u32> = (0..points.len() as u32).collect();
            let key = |d: u32| if points[d as usize].kind == kind::FRONT { points[d as usize].tile } else { NONE };
            rays.sort_by_key(|&d| key(d));
            batch.rays = rays;
        }
        let rays: Vec<u32> = batch.rays.iter().copied().filter(|&d| range.contains(&(d as usize))).collect();
        self.gpu.upload("rays", &rays)
    }

    /// Reads back what kernels have finished.
    fn fetch<T: Pod>(&self, vec: &GpuVec<T>) -> Result<Vec<T>> {
        self.gpu.read_finished(vec, 0, vec.len())
    }
}

impl Responder for GpuEngine<'_> {
    fn best(&mut self, inputs: &[Feature], cells: &[Feature]) -> Result<Vec<u32>> {
        // Like receivers follow each other: an invocation that serves several inputs then passes over most cells.
        let mut order: Vec<u32> = (0..inputs.len() as u32).collect();
        order.sort_by_cached_key(|&i| [6, 7, 8].map(|k| (16.0 * inputs[i as usize][k]).floor() as i32));
        let (order, device) = (self.gpu.upload("order", &order)?, self.gpu.upload("inputs", inputs)?);
        let winners = self.gpu.alloc("winners", inputs.len())?;
        let cells = super::winner::CellBlocks::new(self.gpu, cells)?;
        super::winner::winner(self.gpu, &device, &order, &cells, &winners)?;
        self.fetch(&winners)
    }

    fn respond(&mut self, net: Net, inputs: &[Feature], samples: &mut [Sample]) -> Result<Vec<ResponseSums>> {
        let (inputs, device) = (self.gpu.upload("inputs", inputs)?, self.gpu.upload("samples", samples)?);
        let sums = super::respond::respond(self.gpu, net, &inputs, &device)?;
        samples.copy_from_slice(&self.fetch(&device)?);
        self.fetch(&sums)
    }
}

impl Engine for GpuEngine<'_> {
    type Batch = GpuBatch;

    fn upload(&mut self, points: &[Point]) -> Result<GpuBatch> {
        self.batch(self.gpu.upload("points", points)?)
    }

    fn points(&mut self, batch: &GpuBatch) -> Result<Vec<Point>> {
        self.fetch(&batch.points)
    }

    fn emit(&mut self, tiles: &[Tile], seed: u32, first: u32, count: u32, total: u32) -> Result<GpuBatch> {
        let tiles = self.gpu.upload("tiles", tiles)?;
        self.batch(super::emit::emit(self.gpu, &self.scene, &tiles, seed, first, count, total)?)
    }

    fn shoot(&mut self, from: &GpuBatch, seed: u32, first: u32, rays: u32) -> Result<GpuBatch> {
        self.batch(super::shoot::shoot(self.gpu, &self.scene, &from.points, seed, first, rays)?)
    }

    fn kernel(&mut self, pairs: &[Point]) -> Result<Vec<f32>> {
        let points = self.gpu.upload("pairs", pairs)?;
        self.fetch(&super::kernel::kernel(self.gpu, &self.scene, &points)?)
    }

    fn direct(
        &mut self,
        batch: &mut GpuBatch,
        active: Option<&[u32]>,
        seed: u32,
        first: u32,
        rounds: u32,
        samples: Samples,
    ) -> Result<()> {
        if batch.direct.len() < batch.points.len() {
            batch.direct = self.gpu.alloc("direct", batch.points.len())?;
        }
        let active = match active {
            Some(active) => self.gpu.upload("active", active)?,
            None => self.order(batch)?,
        };
        self.direct_rays.add(&self.scene.sources.rays(samples), active.len() as u64 * u64::from(rounds));
        super::direct::direct(self.gpu, &self.scene, &batch.points, &active, seed, first, rounds, samples, &batch.direct)
    }

    fn set_direct(&mut self, batch: &mut GpuBatch, sums: &[DirectSum]) -> Result<()> {
        batch.direct = self.gpu.upload("direct", sums)?;
        Ok(())
    }

    fn direct_sums(&mut self, batch: &GpuBatch) -> Result<Vec<DirectSum>> {
        self.fetch(&batch.direct)
    }

    fn set_surface(&mut self, surface: &Surface) -> Result<()> {
        self.surface = SurfaceBuffers::new(self.gpu, surface)?;
        Ok(())
    }

    fn set_light(&mut self, light: &[NodeLight]) -> Result<()> {
        self.light = self.gpu.upload("light", light)?;
        Ok(())
    }

    fn assign(&mut self, batch: &mut GpuBatch) -> Result<()> {
        let order = self.order(batch)?;
        batch.psi = super::assign::assign(self.gpu, &self.scene, &self.surface, &batch.points, &order)?;
        Ok(())
    }

    fn psi(&mut self, batch: &GpuBatch) -> Result<Vec<Psi>> {
        self.fetch(&batch.psi)
    }

    fn set_psi(&mut self, batch: &mut GpuBatch, psi: &[Psi]) -> Result<()> {
        batch.psi = self.gpu.upload("psi", psi)?;
        Ok(())
    }

    fn feature(&mut self, batch: &mut GpuBatch, metric: Metric, brightness: &[f32]) -> Result<()> {
        let brightness = self.gpu.upload("brightness", brightness)?;
        batch.features = super::feature::feature(self.gpu, &self.scene, metric, &brightness, &batch.points)?;
        Ok(())
    }

    fn features(&mut self, batch: &GpuBatch, range: Range<usize>) -> Result<Vec<Feature>> {
        self.gpu.read_finished(&batch.features, range.start, range.len())
    }

    fn winner(&mut self, batch: &mut GpuBatch, range: Range<usize>, cells: &[Feature]) -> Result<()> {
        if batch.winners.len() < batch.points.len() {
            batch.winners = self.gpu.upload("winners", &vec![NONE; batch.points.len()])?;
        }
        let order = self.rays(batch, range)?;
        let cells = super::winner::CellBlocks::new(self.gpu, cells)?;
        super::winner::winner(self.gpu, &batch.features, &order, &cells, &batch.winners)
    }

    fn winners(&mut self, batch: &GpuBatch) -> Result<Vec<u32>> {
        self.fetch(&batch.winners)
    }

    fn set_winners(&mut self, batch: &mut GpuBatch, winners: &[u32]) -> Result<()> {
        batch.winners = self.gpu.upload("winners", winners)?;
        Ok(())
    }

    fn accumulate(&mut self, batch: &GpuBatch, range: Range<usize>, cells: &[Feature]) -> Result<Vec<CellSums>> {
        let cells = self.gpu.upload("cells", cells)?;
        let sums = super::accumulate::accumulate(self.gpu, &batch.points, &batch.features, &batch.winners, range, &cells)?;
        self.fetch(&sums)
    }

    fn adapt(
        &mut self,
        cells: &[Feature],
        sums: &[CellSums],
        offsets: &[u32],
        neighbours: &[u32],
        eta: f32,
    ) -> Result<Vec<Feature>> {
        let cells = self.gpu.upload("cells", cells)?;
        let sums = self.gpu.upload("cell sums", sums)?;
        let offsets = self.gpu.upload("offsets", offsets)?;
        let neighbours = self.gpu.upload("neighbours", neighbours)?;
        let moved = super::adapt::adapt(self.gpu, &cells, &sums, &offsets, &neighbours, eta)?;
        self.fetch(&moved)
    }

    fn coefficients(
        &mut self,
        batches: &[GpuBatch],
        exact: bool,
        normalise: f32,
        rays: f32,
        cells: usize,
        beat: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Sums> {
        let batches: Vec<Rays> = batches
            .iter()
            .map(|b| Rays { points: &b.points, psi: &b.psi, winners: &b.winners, direct: exact.then_some(&b.direct) })
            .collect();
        let sums =
            super::coefficients::coefficients(self.gpu, &self.scene, &self.surface, &batches, normalise, rays, cells, beat)?;
        self.gpu.check_finished()?;
        Ok(sums)
    }

    fn deposit(&mut self, batches: &[GpuBatch], exact: bool, lit: bool, normalise: f32) -> Result<Vec<NodeSource>> {
        let sums = self.gpu.alloc("known light", self.surface.nodes.len())?;
        for b in batches {
            let (direct, light) = (exact.then_some(&b.direct), lit.then_some(&b.irradiance));
            super::deposit::deposit(self.gpu, &self.scene, &self.surface, &b.points, &b.psi, direct, light, normalise, &sums)?;
        }
        self.fetch(&sums)
    }

    fn set_system(&mut self, system: &System) -> Result<()> {
        self.system = SystemBuffers::new(self.gpu, system, self.grey)?;
        Ok(())
    }

    fn jacobi(&mut self, light: &[NodeLight], sweeps: u32) -> Result<Vec<NodeLight>> {
        self.band_bytes += u64::from(sweeps) * self.system.band_bytes();
        super::jacobi::jacobi(self.gpu, &self.scene, &self.system, light, sweeps)
    }

    fn readout(&mut self, batch: &mut GpuBatch) -> Result<()> {
        batch.irradiance = super::readout::readout(self.gpu, &self.surface, &self.light, &batch.points, &batch.psi)?;
        Ok(())
    }

    fn irradiance(&mut self, batch: &GpuBatch) -> Result<Vec<[f32; 4]>> {
        self.fetch(&batch.irradiance)
    }

    fn set_irradiance(&mut self, batch: &mut GpuBatch, light: &[[f32; 4]]) -> Result<()> {
        batch.irradiance = self.gpu.upload("irradiance", light)?;
        Ok(())
    }

    fn gather(&mut self, hits: &GpuBatch, rays: u32, lit: bool, exact: bool) -> Result<Vec<Gathered>> {
        let (light, direct) = (lit.then_some(&hits.irradiance), exact.then_some(&hits.direct));
        let gathered = super::gather::gather(self.gpu, &self.scene, &hits.points, light, direct, rays)?;
        Ok(super::gather::decode(&self.fetch(&gathered)?))
    }

    fn finish(&mut self) -> Result<()> {
        self.gpu.check_finished()
    }

    fn has_mirrors(&self) -> bool {
        self.mirrors
    }

    fn compile_seconds(&self) -> f64 {
        self.gpu.compiled()
    }

    fn direct_rays(&self) -> DirectRays {
        self.direct_rays
    }

    fn band_bytes(&self) -> u64 {
        self.band_bytes
    }

    fn device_bytes(&self) -> u64 {
        self.gpu.device_bytes()
    }
}
