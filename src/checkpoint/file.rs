//! `checkpoint.rcell`: a [`Checkpoint`] in the container of solutions, every number as it lay in memory.

use super::{Checkpoint, Key, Learned, Network, Pilot};
use crate::accuracy::estimate::Evidence;
use crate::bake::flux;
use crate::error::Result;
use crate::layout::{DirectSum, NodeLight};
use crate::network::complex::Complex;
use crate::network::growth::{Growth, Training};
use crate::output::rcell::{self, Container, Section};
use crate::output::report::Energy;
use crate::radiosity::coefficients::Coefficients;
use crate::radiosity::solver::Solved;
use crate::scene::Geometry;
use crate::solution::{check, check::finite, sections};
use crate::twin::jacobi::System;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What the header says it holds.
const CONTENT: &str = "checkpoint";

/// The caller's part of the container's header: what is no array, and which arrays are there.
#[derive(Serialize, Deserialize)]
struct Header {
    content: String,
    key: Option<Key>,
    tiles: bool,
    /// What the pilot's rays met from behind; none until the pilot is done.
    pilot: Option<Vec<String>>,
    nodes: bool,
    rays: u32,
    growth: Option<GrowthHeader>,
    /// Coefficients stored, the share of mass that was dropped, kernel evaluations, and rays that looked around.
    coefficients: Option<(u64, f64, u64, u64)>,
    solved: Option<Solved>,
    refined: u32,
    #[serde(default)]
    evidence: Evidence,
    energy: Option<Energy>,
    #[serde(default)]
    learned: Option<Learned>,
}

#[derive(Serialize, Deserialize)]
struct GrowthHeader {
    training: Training,
    batch: usize,
    at: usize,
    lloyd: u32,
    done: bool,
}

impl Checkpoint {
    /// Writes the checkpoint. Errors: [`crate::Error::Write`].
    pub fn save(&self, path: &Path) -> Result<()> {
        let (net, none) = (&self.network, System::default());
        let growth = net.growth.as_ref();
        let header = Header {
            content: CONTENT.into(),
            key: self.key.clone(),
            tiles: self.tiles.is_some(),
            pilot: self.pilot.as_ref().map(|p| p.winding.clone()),
            nodes: net.nodes.is_some(),
            rays: net.rays,
            growth: growth.map(|g| GrowthHeader { training: g.training, batch: g.batch, at: g.at, lloyd: g.lloyd, done: g.done }),
            coefficients: net.coefficients.as_ref().map(|c| (c.stored, c.dropped, c.evaluations, c.looks)),
            solved: net.solved,
            refined: net.refined,
            evidence: net.evidence,
            energy: self.energy.clone(),
            learned: self.learned.clone(),
        };
        let pilot = self.pilot.as_ref();
        let system = net.coefficients.as_ref().map_or(&none, |c| &c.system);
        let sections = [
            Section::new("tiles", self.tiles.as_deref().unwrap_or_default()),
            Section::new("pilot_nodes", pilot.map_or(&[], |p| &p.nodes)),
            Section::new("pilot_light", pilot.map_or(&[], |p| &p.light)),
            Section::new("carried", pilot.map_or(&[], |p| &p.carried)),
            Section::new("density", pilot.map_or(&[], |p| &p.density)),
            Section::new("nodes", net.nodes.as_deref().unwrap_or_default()),
            Section::new("direct", &net.direct),
            Section::new("cells", growth.map_or(&[], |g| &g.cells)),
            Section::new("learned_cells", self.learned.as_ref().map_or(&[], |l| &l.cells)),
            Section::new("simplices", bytemuck::cast_slice::<u32, [u32; 3]>(growth.map_or(&[], |g| g.complex.simplices()))),
            Section::new("winners", &net.winners),
        ];
        let rest = [Section::new("mass", net.coefficients.as_ref().map_or(&[], |c| &c.mass)), Section::new("light", &net.light)];
        rcell::write(path, &header, &[&sections[..], &sections::of(system), &rest].concat())
    }

    /// Reads a checkpoint that was saved, or that a bake has [kept](Checkpoint::keep_in). What only the scene can
    /// tell is checked when a bake goes on from it.
    ///
    /// Errors: [`crate::Error::Read`]; [`crate::Error::Format`] where the file is no checkpoint, damaged, or of another version.
    pub fn load(path: &Path) -> Result<Checkpoint> {
        Self::from_container(rcell::read(path)?)
    }

    /// As [`Checkpoint::load`], from memory; `path` names it in messages.
    pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<Checkpoint> {
        Self::from_container(rcell::parse(bytes, path)?)
    }

    fn from_container(file: Container) -> Result<Checkpoint> {
        let header: Header = file.header(CONTENT)?;
        let growth = match header.growth {
            None => None,
            Some(g) => {
                let cells = file.get("cells")?;
                let simplices: Vec<[u32; 3]> = file.get("simplices")?;
                // Cells that were not grown have no topology.
                let complex = match simplices.is_empty() {
                    true => Complex::empty(),
                    false => Complex::from_simplices(2, cells.len(), simplices.into_flattened())
                        .ok_or_else(|| file.fail("the cells and their simplices do not belong together"))?,
                };
                let GrowthHeader { training, batch, at, lloyd, done } = g;
                Some(Growth { cells, complex, training, batch, at, lloyd, done })
            }
        };
        let coefficients = match header.coefficients {
            None => None,
            Some((stored, dropped, evaluations, looks)) => {
                let (system, mass) = (sections::read(&file)?, file.get("mass")?);
                Some(Coefficients { system, mass, stored, dropped, evaluations, looks })
            }
        };
        let pilot = match header.pilot {
            None => None,
            Some(winding) => Some(Pilot {
                nodes: file.get("pilot_nodes")?,
                light: file.get("pilot_light")?,
                carried: file.get("carried")?,
                density: file.get("density")?,
                winding,
            }),
        };
        Ok(Checkpoint {
            key: header.key,
            tiles: header.tiles.then(|| file.get("tiles")).transpose()?,
            pilot,
            network: Network {
                nodes: header.nodes.then(|| file.get("nodes")).transpose()?,
                surface: None,
                rays: header.rays,
                direct: file.get("direct")?,
                growth,
                winners: file.get("winners")?,
                coefficients,
                solved: header.solved,
                light: file.get("light")?,
                refined: header.refined,
                evidence: header.evidence,
            },
            learned: match header.learned {
                Some(learned) => Some(Learned { cells: file.get("learned_cells")?, ..learned }),
                None => None,
            },
            energy: header.energy,
            home: None,
        })
    }

    /// Checks lengths, indices and numbers against the scene and the number of rays, so that going on cannot
    /// fail on them. The first thing wrong, in words.
    pub(crate) fn check(&self, geometry: &Geometry, rays: u32) -> std::result::Result<(), &'static str> {
        let amounts = |x: &[f64], many: usize| x.len() == many && x.iter().all(|x| x.is_finite() && *x >= 0.0);
        let tiles = geometry.tiles as usize;
        let tile = |d: &DirectSum| finite(&d.sum);
        let looks = || flux::looks(geometry, flux::pilot_rays(rays)).tiles.len();
        if !self.tiles.iter().all(|t| t.len() == looks() && t.iter().all(tile)) {
            return Err("the light of its tiles does not fit the scene");
        }
        if let Some(p) = &self.pilot {
            check::nodes(geometry, &p.nodes)?;
            check::light(&p.light, p.nodes.len())?;
            if !amounts(&p.carried, tiles) || !amounts(&p.density, tiles) {
                return Err("what its pilot carries does not fit the scene");
            }
        }
        let net = &self.network;
        let nodes = net.nodes.as_deref().unwrap_or_default();
        check::nodes(geometry, nodes)?;
        let per_ray = |len: usize| len == 0 || len == 2 * net.rays as usize;
        if net.rays > rays || !per_ray(net.direct.len()) || net.winners.len() > 2 * net.rays as usize {
            return Err("its rays do not belong together");
        }
        let cells = net.growth.as_ref().map_or(0, |g| g.cells.len());
        if !finite(net.direct.as_flattened()) || net.winners.iter().any(|&w| w as usize >= cells && w != crate::layout::NONE) {
            return Err("its rays hold numbers that cannot be");
        }
        if let Some(g) = &net.growth {
            let batches = rays.div_ceil(crate::bake::flux::batch_rays(rays)) as usize;
            if !finite(g.cells.as_flattened())
                || g.batch >= batches
                || g.at > 2 * crate::bake::flux::BATCH as usize
                || cells > 200_000
            {
                return Err("its cells hold numbers that cannot be");
            }
        }
        if let Some(c) = &net.coefficients {
            check::system(geometry, &c.system, nodes.len())?;
            if cells > c.system.source.len() || !amounts(&c.mass, nodes.len()) {
                return Err("its coefficients do not fit its network");
            }
        }
        if self.learned.as_ref().is_some_and(|l| !finite(l.cells.as_flattened())) {
            return Err("its cells hold numbers that cannot be");
        }
        // Each step rests on the ones before it.
        let network = self.key.as_ref().is_none_or(Key::is_network);
        let grown = net.growth.is_some() || self.learned.is_some() || (!network && net.coefficients.is_some());
        let steps = [self.energy.is_some(), net.solved.is_some(), net.coefficients.is_some(), grown, net.nodes.is_some()];
        if !steps.is_sorted() || (network && self.energy.is_some() && self.pilot.is_none()) {
            return Err("a step is there without those before it");
        }
        let lit: &[NodeLight] = &net.light;
        check::light(lit, if net.solved.is_some() { nodes.len() } else { 0 })
    }
}
