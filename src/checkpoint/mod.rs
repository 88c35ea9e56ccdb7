//! What a bake has found so far, so that one that was stopped goes on instead of beginning again.
//!
//! A bake fills a [`Checkpoint`]; what is in it already is not computed again. Kept is what took time to
//! find and is small; rays are not kept, they come again from their seeds (`docs/decisions.md`). A solution,
//! whole or not, is made of a checkpoint and of nothing else, so continued and straight bakes are the same bytes.

mod assemble;
mod file;
mod key;

pub(crate) use assemble::unread;
pub(crate) use key::{Key, bytes, digest};

use crate::accuracy::estimate::Evidence;
use crate::bake::flux;
use crate::error::{Error, Result};
use crate::layout::{DirectSum, Node, NodeLight};
use crate::network::growth::Growth;
use crate::output::report::Energy;
use crate::params::Params;
use crate::progress::{Event, Progress};
use crate::radiosity::coefficients::Coefficients;
use crate::radiosity::solver::Solved;
use crate::scene::Geometry;
use crate::twin::assign::Surface;
use crate::twin::winner::Feature;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Times as long as a write has taken must pass before the next one: keeping costs 5 % at most.
const PATIENCE: u32 = 20;

/// What a bake has found so far; empty at first. See [`crate::bake_from`].
#[derive(Clone, Debug, Default)]
pub struct Checkpoint {
    /// Which bake it is of; none while empty.
    pub(crate) key: Option<Key>,
    /// First estimate of direct light on each tile, until the pilot is done.
    pub(crate) tiles: Option<Vec<DirectSum>>,
    /// What the pilot has told, once it is done.
    pub(crate) pilot: Option<Pilot>,
    /// The network being trained: the pilot, then the full one.
    pub(crate) network: Network,
    /// What paper mode has learned.
    pub(crate) learned: Option<Learned>,
    /// Where the energy went; the bake's last word.
    pub(crate) energy: Option<Energy>,
    /// Where the bake keeps it.
    home: Option<Home>,
}

/// What remains of the pilot network.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pilot {
    /// Its nodes and their light: all that is known until the full network is solved.
    pub nodes: Vec<Node>,
    pub light: Vec<NodeLight>,
    /// What each tile sends in the pilot's light.
    pub carried: Vec<f64>,
    /// Node density of each tile.
    pub density: Vec<f64>,
    /// What its rays met from behind, in words.
    pub winding: Vec<String>,
}

/// What paper mode's supervised network has learned, beside its coefficients.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Learned {
    /// The cells' centres.
    #[serde(skip)]
    pub cells: Vec<Feature>,
    /// Pairs drawn.
    pub drawn: u64,
    /// Pairs at which the kernel was evaluated.
    pub evaluations: u64,
    /// Epochs run.
    pub epochs: u32,
    /// Cells deleted.
    pub deleted: u32,
    /// Relative L2 error of the network's answers against the clamped kernel, on fresh pairs.
    pub kernel_error: f64,
    /// Share of the kernel's integral that the clamp takes away.
    pub clamped: f64,
    /// Share of the evaluations that found 0.
    pub idle: f64,
}

/// A network as far as it is trained, in the order in which it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Network {
    /// Its nodes; with their means once there are coefficients.
    pub nodes: Option<Vec<Node>>,
    /// They, and which of them may speak where, once all is done: it takes time to find. Not kept in files.
    pub surface: Option<Surface>,
    /// Rays shot, whole batches.
    pub rays: u32,
    /// D at both ends of each of them where direct light is exact; a round of samples.
    pub direct: Vec<[f32; 3]>,
    /// The cells.
    pub growth: Option<Growth>,
    /// The cell of each directed ray, whole batches; empty again once there are coefficients.
    pub winners: Vec<u32>,
    /// The cells read as coefficients.
    pub coefficients: Option<Coefficients>,
    /// How the solve went.
    pub solved: Option<Solved>,
    /// The nodes' light, once solved.
    pub light: Vec<NodeLight>,
    /// Refinements of it done.
    pub refined: u32,
    /// What they have told of its noise.
    pub evidence: Evidence,
}

/// The file that a checkpoint is kept in.
#[derive(Clone, Debug)]
struct Home {
    path: PathBuf,
    /// No write before this moment.
    next: Instant,
    /// Whether a write has failed, and the caller has heard of it.
    failed: bool,
}

/// What is kept, or what `work` finds, which is kept from then on.
pub(crate) fn once<T>(kept: &mut Option<T>, work: impl FnOnce() -> Result<T>) -> Result<&T> {
    match kept {
        Some(found) => Ok(found),
        None => Ok(kept.insert(work()?)),
    }
}

impl Checkpoint {
    /// Whether nothing has been found yet.
    pub fn is_empty(&self) -> bool {
        self.key.is_none()
    }

    /// Whether the bake is done: what is left is to read it out.
    pub fn is_whole(&self) -> bool {
        self.energy.is_some()
    }

    /// The parameters of the bake that it is of; none while empty.
    pub(crate) fn params(&self) -> Option<&Params> {
        self.key.as_ref().map(Key::params)
    }

    /// What a whole bake with parameters `own` leaves for one with `next`, twice as large: the pilot, where both
    /// have the same. The larger one's bytes do not depend on it.
    pub(crate) fn next(&mut self, own: &Params, next: &Params) -> Checkpoint {
        let pilot = self.pilot.take().filter(|_| flux::pilot_rays(own.rays) == flux::pilot_rays(next.rays));
        Checkpoint { pilot, home: self.home.take(), ..Checkpoint::default() }
    }

    /// From now on a bake writes the checkpoint to this file as it goes on, so that it outlives the process. It
    /// writes after a stage, a batch of rays or an epoch, when twenty times as long as the last write took has
    /// passed. Where the file cannot be written the bake goes on, with an [`Event::Warning`].
    pub fn keep_in(&mut self, path: &Path) {
        self.home = Some(Home { path: path.into(), next: Instant::now(), failed: false });
    }

    /// Takes the checkpoint for a bake of a scene. Errors: [`Error::OtherBake`]; [`Error::Format`] where what it holds
    /// does not fit the scene.
    pub(crate) fn claim(&mut self, key: Key, geometry: &Geometry) -> Result<()> {
        let place = || self.home.as_ref().map_or("the checkpoint".into(), |h| h.path.clone());
        let Some(own) = &self.key else {
            self.key = Some(key);
            return Ok(());
        };
        if let Some(what) = own.difference(&key) {
            return Err(Error::OtherBake { place: place(), what });
        }
        self.check(geometry, key.rays()).map_err(|what| Error::Format {
            path: place(),
            line: None,
            what: what.into(),
            cure: "bake from the beginning (without --resume)".into(),
        })
    }

    /// Something has been found: writes it where that is wanted and due, and lets the caller stop.
    pub(crate) fn keep(&mut self, progress: &mut Progress) -> Result<()> {
        let Some(home) = self.home.as_ref().filter(|h| Instant::now() >= h.next) else { return progress.tick() };
        let (path, told) = (home.path.clone(), home.failed);
        let start = Instant::now();
        let written = self.save(&path);
        let failed = written.is_err();
        let next = Instant::now() + (start.elapsed() * PATIENCE).max(Duration::from_millis(1));
        self.home = Some(Home { path, next, failed });
        match written {
            Err(e) if !told => progress.event(Event::Warning(format!("the bake cannot be resumed: {e}"))),
            _ => progress.tick(),
        }
    }
}
