//! The machine of plain Rust: every pass by its twin.

use super::assign::Surface;
use super::coefficients::Sums;
use super::direct::{DirectRays, Samples, Sources};
use super::gather::Gathered;
use super::jacobi::System;
use super::respond::{Host, Net, Responder};
use super::winner::{Feature, Metric};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{CellSums, DirectSum, NodeLight, NodeSource, Point, Psi, ResponseSums, Sample, Tile};
use crate::scene::Geometry;
use std::ops::Range;

/// Runs every pass by its twin, on the processor. Driver-free, and the oracle of the kernels.
pub struct TwinEngine<'a> {
    geometry: &'a Geometry,
    surface: Surface,
    light: Vec<NodeLight>,
    system: System,
    direct_rays: DirectRays,
    band_bytes: u64,
}

/// Points in host memory, with what the passes have found about them.
#[derive(Clone, Debug, Default)]
pub struct TwinBatch {
    points: Vec<Point>,
    direct: Vec<DirectSum>,
    psi: Vec<Psi>,
    features: Vec<Feature>,
    winners: Vec<u32>,
    irradiance: Vec<[f32; 4]>,
}

impl<'a> TwinEngine<'a> {
    /// A machine for one prepared scene.
    pub fn new(geometry: &'a Geometry) -> TwinEngine<'a> {
        TwinEngine {
            geometry,
            surface: Surface::default(),
            light: Vec::new(),
            system: System::default(),
            direct_rays: DirectRays::default(),
            band_bytes: 0,
        }
    }
}

impl Responder for TwinEngine<'_> {
    fn best(&mut self, inputs: &[Feature], cells: &[Feature]) -> Result<Vec<u32>> {
        Host.best(inputs, cells)
    }

    fn respond(&mut self, net: Net, inputs: &[Feature], samples: &mut [Sample]) -> Result<Vec<ResponseSums>> {
        Host.respond(net, inputs, samples)
    }
}

impl Engine for TwinEngine<'_> {
    type Batch = TwinBatch;

    fn upload(&mut self, points: &[Point]) -> Result<TwinBatch> {
        Ok(TwinBatch { points: points.to_vec(), ..TwinBatch::default() })
    }

    fn points(&mut self, batch: &TwinBatch) -> Result<Vec<Point>> {
        Ok(batch.points.clone())
    }

    fn emit(&mut self, tiles: &[Tile], seed: u32, first: u32, count: u32, total: u32) -> Result<TwinBatch> {
        Ok(TwinBatch { points: super::emit::emit(self.geometry, tiles, seed, first, count, total), ..TwinBatch::default() })
    }

    fn shoot(&mut self, from: &TwinBatch, seed: u32, first: u32, rays: u32) -> Result<TwinBatch> {
        Ok(TwinBatch { points: super::shoot::shoot(self.geometry, &from.points, seed, first, rays), ..TwinBatch::default() })
    }

    fn kernel(&mut self, pairs: &[Point]) -> Result<Vec<f32>> {
        Ok(super::kernel::kernel(self.geometry, pairs))
    }

    fn direct(
        &mut self,
        batch: &mut TwinBatch,
        active: Option<&[u32]>,
        seed: u32,
        first: u32,
        rounds: u32,
        samples: Samples,
    ) -> Result<()> {
        batch.direct.resize(batch.points.len(), DirectSum::default());
        let all: Vec<u32> = (0..batch.points.len() as u32).collect();
        let points = active.map_or(all.len(), <[u32]>::len) as u64;
        self.direct_rays.add(&Sources::of(self.geometry).rays(samples), points * u64::from(rounds));
        super::direct::direct(
            self.geometry,
            &batch.points,
            active.unwrap_or(&all),
            seed,
            first,
            rounds,
            samples,
            &mut batch.direct,
        );
        Ok(())
    }

    fn set_direct(&mut self, batch: &mut TwinBatch, sums: &[DirectSum]) -> Result<()> {
        batch.direct = sums.to_vec();
        Ok(())
    }

    fn direct_sums(&mut self, batch: &TwinBatch) -> Result<Vec<DirectSum>> {
        Ok(batch.direct.clone())
    }

    fn set_surface(&mut self, surface: &Surface) -> Result<()> {
        self.surface = surface.clone();
        Ok(())
    }

    fn set_light(&mut self, light: &[NodeLight]) -> Result<()> {
        self.light = light.to_vec();
        Ok(())
    }

    fn assign(&mut self, batch: &mut TwinBatch) -> Result<()> {
        batch.psi = super::assign::assign(self.geometry, &self.surface, &batch.points);
        Ok(())
    }

    fn psi(&mut self, batch: &TwinBatch) -> Result<Vec<Psi>> {
        Ok(batch.psi.clone())
    }

    fn set_psi(&mut self, batch: &mut TwinBatch, psi: &[Psi]) -> Result<()> {
        batch.psi = psi.to_vec();
        Ok(())
    }

    fn feature(&mut self, batch: &mut TwinBatch, metric: Metric, brightness: &[f32]) -> Result<()> {
        batch.features = super::winner::feature(self.geometry, metric, brightness, &batch.points);
        Ok(())
    }

    fn features(&mut self, batch: &TwinBatch, range: Range<usize>) -> Result<Vec<Feature>> {
        Ok(batch.features[range].to_vec())
    }

    fn winner(&mut self, batch: &mut TwinBatch, range: Range<usize>, cells: &[Feature]) -> Result<()> {
        batch.winners.resize(batch.points.len(), crate::layout::NONE);
        let found = super::winner::winner(&batch.features[range.clone()], cells);
        batch.winners[range].copy_from_slice(&found);
        Ok(())
    }

    fn winners(&mut self, batch: &TwinBatch) -> Result<Vec<u32>> {
        Ok(batch.winners.clone())
    }

    fn set_winners(&mut self, batch: &mut TwinBatch, winners: &[u32]) -> Result<()> {
        batch.winners = winners.to_vec();
        Ok(())
    }

    fn accumulate(&mut self, batch: &TwinBatch, range: Range<usize>, cells: &[Feature]) -> Result<Vec<CellSums>> {
        let r = range;
        Ok(super::accumulate::accumulate(&batch.points[r.clone()], &batch.features[r.clone()], &batch.winners[r], cells))
    }

    fn adapt(
        &mut self,
        cells: &[Feature],
        sums: &[CellSums],
        offsets: &[u32],
        neighbours: &[u32],
        eta: f32,
    ) -> Result<Vec<Feature>> {
        Ok(super::adapt::adapt(cells, sums, offsets, neighbours, eta))
    }

    fn coefficients(
        &mut self,
        batches: &[TwinBatch],
        exact: bool,
        normalise: f32,
        rays: f32,
        cells: usize,
        beat: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Sums> {
        let mut sums = Sums::default();
        for b in batches {
            let direct = exact.then_some(b.direct.as_slice());
            sums.merge(super::coefficients::coefficients(
                self.geometry,
                &self.surface,
                &b.points,
                &b.psi,
                &b.winners,
                direct,
                normalise,
                rays,
                cells,
            ));
            beat()?;
        }
        Ok(sums)
    }

    fn deposit(&mut self, batches: &[TwinBatch], exact: bool, lit: bool, normalise: f32) -> Result<Vec<NodeSource>> {
        let mut sums = Vec::new();
        for b in batches {
            let light = if lit { b.irradiance.as_slice() } else { &[] };
            let direct = exact.then_some(b.direct.as_slice());
            let more = super::deposit::deposit(self.geometry, &self.surface, &b.points, &b.psi, direct, light, normalise);
            super::deposit::merge(&mut sums, more);
        }
        Ok(sums)
    }

    fn set_system(&mut self, system: &System) -> Result<()> {
        self.system = system.clone();
        Ok(())
    }

    fn jacobi(&mut self, light: &[NodeLight], sweeps: u32) -> Result<Vec<NodeLight>> {
        // Always in three bands: what is sent and what is found of cells and nodes.
        let bytes = 2 * size_of_val(&self.system.source[..]) + 2 * size_of_val(&self.system.node_source[..]);
        self.band_bytes += u64::from(sweeps) * bytes as u64;
        Ok(super::jacobi::jacobi(&self.system, &self.geometry.materials, light, sweeps))
    }

    fn readout(&mut self, batch: &mut TwinBatch) -> Result<()> {
        batch.irradiance = super::readout::readout(&self.surface, &self.light, &batch.points, &batch.psi);
        Ok(())
    }

    fn irradiance(&mut self, batch: &TwinBatch) -> Result<Vec<[f32; 4]>> {
        Ok(batch.irradiance.clone())
    }

    fn set_irradiance(&mut self, batch: &mut TwinBatch, light: &[[f32; 4]]) -> Result<()> {
        batch.irradiance = light.to_vec();
        Ok(())
    }

    fn gather(&mut self, hits: &TwinBatch, rays: u32, lit: bool, exact: bool) -> Result<Vec<Gathered>> {
        let light = if lit { hits.irradiance.as_slice() } else { &[] };
        Ok(super::gather::gather(self.geometry, &hits.points, light, exact.then_some(hits.direct.as_slice()), rays))
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }

    fn has_mirrors(&self) -> bool {
        self.geometry.mirrors
    }

    fn compile_seconds(&self) -> f64 {
        0.0
    }

    fn direct_rays(&self) -> DirectRays {
        self.direct_rays
    }

    fn band_bytes(&self) -> u64 {
        self.band_bytes
    }

    fn device_bytes(&self) -> u64 {
        0
    }
}
