//! Links between patches of a hierarchy (Hanrahan, Salzman, Aupperle, "A Rapid Hierarchical Radiosity Algorithm", 1991):
//! a pair of patches exchanges light as a whole where that costs little, else the larger one is divided.

use super::exchange::{close, evaluations, facing, open, places};
use super::sampled::{POINTS, points_on};
use super::{Mesh, Patch};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{NONE, NodeLight, Point};
use crate::progress::Progress;
use crate::scene::Geometry;
use crate::twin::math::{kernel_g, seed_of};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Patches that the hierarchy grows from.
const ROOTS: u32 = 48;
/// Kernel evaluations that decide whether a pair is divided.
const TRIALS: u32 = 4;
/// Links a patch: a pair is divided while it carries more than one share in `patches` times this of all light.
const LINKS: f64 = 200.0;
/// Patches smaller than one share in `patches` times this of the area are not divided.
const FINEST: f64 = 4.0;
/// What a trial's light counts where all of its rays are blocked: some of the rest may get through.
const BLOCKED: f64 = 0.25;
/// Most that a leaf's form factors are scaled by where emitters are among what they bring: without, cornell's error was .7 to 1.4
/// (3 seeds), single leaves beside a block being too bright; with 2, .10 and .067; with 6, .096 and .053.
const MOST: f64 = 6.0;
/// Pairs in flight.
const FLIGHT: usize = 1 << 16;

/// The hierarchy and its links.
#[derive(Clone, Debug, Default)]
pub struct Links {
    /// All patches, each before its parts.
    patches: Vec<Patch>,
    /// First part of each and how many there are; 0 of a leaf.
    parts: Vec<(u32, u32)>,
    /// The patch that each is a part of, [`NONE`] of roots.
    whole: Vec<u32>,
    /// Leaves in order.
    leaves: Vec<u32>,
    /// Start of each patch's links; one more entry than patches.
    offsets: Vec<usize>,
    /// The patch that sends, and the form factor.
    links: Vec<(u32, f32)>,
    /// What brings the form factors that a leaf meets on its way from the root to the visible share of its view.
    factor: Vec<f64>,
    /// Evaluations of the kernel.
    pub evaluations: u64,
}

/// Patches while they are being linked.
struct Growing<'a> {
    geometry: &'a Geometry,
    mesh: &'a Mesh,
    seed: u32,
    /// What each tile sends, for all patches to be judged by.
    carried: &'a [f64],
    links: Links,
    points: Vec<Point>,
    stretch: Vec<f32>,
    sent: Vec<f64>,
}

impl Growing<'_> {
    fn push(&mut self, patch: Patch, whole: u32) {
        let id = self.links.patches.len() as u32;
        let chart = &self.mesh.charts[patch.chart as usize];
        let (mut sum, mut all) = (0.0, 0.0);
        for (p, stretch) in points_on(self.geometry, chart, &patch.shape, seed_of(self.seed, id)) {
            sum += self.carried[p.tile as usize] * stretch as f64;
            all += stretch as f64;
            self.points.push(p);
            self.stretch.push(stretch);
        }
        self.sent.push(sum / all);
        self.links.patches.push(patch);
        self.links.parts.push((0, 0));
        self.links.whole.push(whole);
    }

    /// The parts of a patch, divided now where it was not yet.
    fn parts(&mut self, p: u32) -> std::ops::Range<u32> {
        if self.links.parts[p as usize].1 == 0 {
            let first = self.links.patches.len() as u32;
            let Patch { chart, shape, .. } = self.links.patches[p as usize];
            let parts = shape.cut(if shape.sides == 2 { [2, 1] } else { [2, 2] });
            self.links.parts[p as usize] = (first, parts.len() as u32);
            for shape in parts {
                self.push(Patch { chart, shape, area: shape.area() }, p);
            }
        }
        let (first, count) = self.links.parts[p as usize];
        first..first + count
    }

    /// The pairs of points of `n` evaluations.
    fn pairs(&self, x: u32, y: u32, n: u32) -> impl Iterator<Item = (usize, usize)> + use<> {
        places(x, y, n).map(move |(a, b)| (x as usize * POINTS + a, y as usize * POINTS + b))
    }

    /// Evaluates the kernel on pairs: the values of each, weighted by how much its points stand for.
    fn evaluate<E: Engine>(
        &mut self,
        engine: &mut E,
        pairs: &[(u32, u32)],
        n: impl Fn(&Patch, &Patch) -> u32,
    ) -> Result<Vec<Vec<f64>>> {
        let (mut points, mut weights, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for &(x, y) in pairs {
            let n = n(&self.links.patches[x as usize], &self.links.patches[y as usize]);
            for (a, b) in self.pairs(x, y, n) {
                points.extend([self.points[a], self.points[b]]);
                weights.push(self.stretch[a] as f64 * self.stretch[b] as f64);
            }
            counts.push(n as usize);
        }
        self.links.evaluations += weights.len() as u64;
        let values = engine.kernel(&points)?;
        let mut all = values.iter().zip(&weights).map(|(&v, w)| v as f64 * w);
        Ok(counts.into_iter().map(|n| all.by_ref().take(n).collect()).collect())
    }

    /// The mean of G alone over the trials of a pair.
    fn unblocked(&self, x: u32, y: u32) -> f64 {
        let g = |(a, b): (usize, usize)| {
            let (p, q) = (&self.points[a], &self.points[b]);
            let n = |p: &Point| Vec3::from(self.geometry.tris[p.tri as usize].normal);
            kernel_g(self.geometry.flatland, p.p.into(), n(p), q.p.into(), n(q)) as f64
        };
        self.pairs(x, y, TRIALS).map(g).sum::<f64>() / TRIALS as f64
    }
}

impl Links {
    /// Links about `patches` leaves. `carried` holds what each tile sends, as a pilot has found it.
    pub fn new<E: Engine>(
        engine: &mut E,
        geometry: &Geometry,
        mesh: &Mesh,
        carried: &[f64],
        patches: u32,
        seed: u32,
        progress: &mut Progress,
    ) -> Result<Links> {
        let mut g = Growing {
            geometry,
            mesh,
            seed,
            carried,
            links: Links::default(),
            points: Vec::new(),
            stretch: Vec::new(),
            sent: Vec::new(),
        };
        mesh.patches.iter().for_each(|p| g.push(*p, NONE));
        let area: f64 = mesh.patches.iter().map(|p| p.area).sum();
        let all: f64 = mesh.patches.iter().zip(&g.sent).map(|(p, b)| p.area * b).sum();
        let (most, least) = (all / (patches as f64 * LINKS), area / (patches as f64 * FINEST));

        let roots = mesh.patches.len() as u32;
        let mut frontier: Vec<(u32, u32)> = (0..roots).flat_map(|x| (x + 1..roots).map(move |y| (x, y))).collect();
        frontier.retain(|&(x, y)| facing(geometry, mesh, &mesh.patches[x as usize], &mesh.patches[y as usize]));
        let mut kept = Vec::new();
        while !frontier.is_empty() {
            let mut next = Vec::new();
            for chunk in frontier.chunks(FLIGHT) {
                let trials = g.evaluate(engine, chunk, |_, _| TRIALS)?;
                for (&(x, y), values) in chunk.iter().zip(trials) {
                    let [p, q] = [x, y].map(|i| g.links.patches[i as usize]);
                    let mean = values.iter().sum::<f64>() / TRIALS as f64;
                    let (low, high) = values.iter().fold((f64::MAX, 0.0f64), |(l, h), &v| (l.min(v), h.max(v)));
                    let doubt = if mean > 0.0 { mean + (high - low) } else { BLOCKED * g.unblocked(x, y) };
                    let light = p.area * q.area * g.sent[x as usize].max(g.sent[y as usize]) * doubt;
                    let (larger, other) = if p.area >= q.area { (x, y) } else { (y, x) };
                    if light > most && p.area.max(q.area) > least {
                        for part in g.parts(larger) {
                            if facing(geometry, mesh, &g.links.patches[part as usize], &g.links.patches[other as usize]) {
                                next.push((part.min(other), part.max(other)));
                            }
                        }
                    } else if mean > 0.0 {
                        kept.push((x, y, mean));
                    }
                }
                progress.tick()?;
            }
            frontier = next;
        }
        g.settle(engine, kept, progress)
    }

    /// Scales what each leaf gets to the visible share of its view; by no more than [`MOST`] where links carry the emitters' own
    /// light (`all_light`): a leaf whose links see little of what it sees would get all of it from the few that do.
    pub fn calibrate(&mut self, visible: &[f64], all_light: bool) {
        let most = if all_light { MOST } else { f64::INFINITY };
        let mut met = vec![0.0; self.patches.len()];
        for p in 0..self.patches.len() {
            let above = if self.whole[p] == NONE { 0.0 } else { met[self.whole[p] as usize] };
            met[p] = above + self.row(p).map(|&(_, f)| f as f64).sum::<f64>();
        }
        let scale = |(&leaf, &v): (&u32, &f64)| if met[leaf as usize] > 0.0 { (v / met[leaf as usize]).min(most) } else { 0.0 };
        self.factor = self.leaves.iter().zip(visible).map(scale).collect();
    }

    /// The leaves.
    pub fn leaf_patches(&self) -> Vec<Patch> {
        self.leaves.iter().map(|&p| self.patches[p as usize]).collect()
    }

    /// Links, both ways.
    pub fn stored(&self) -> u64 {
        self.links.len() as u64
    }

    fn row(&self, p: usize) -> std::slice::Iter<'_, (u32, f32)> {
        self.links[self.offsets[p]..self.offsets[p + 1]].iter()
    }

    /// What arrives at each leaf from what the leaves send; `live` is the share of each leaf that is not covered.
    pub fn carry(&self, sent: &[DVec3], live: &[f64]) -> Vec<DVec3> {
        // Pull: what a patch sends is the mean of its parts.
        let mut mean = vec![(DVec3::ZERO, 0.0); self.patches.len()];
        for (k, &leaf) in self.leaves.iter().enumerate() {
            let area = self.patches[leaf as usize].area * live[k];
            mean[leaf as usize] = (sent[k] * area, area);
        }
        for p in (0..self.patches.len()).rev() {
            let (sum, area) = mean[p];
            if self.whole[p] != NONE {
                let whole = &mut mean[self.whole[p] as usize];
                *whole = (whole.0 + sum, whole.1 + area);
            }
        }
        let sent: Vec<DVec3> = mean.into_iter().map(|(sum, area)| if area > 0.0 { sum / area } else { DVec3::ZERO }).collect();
        // Gather over the links, and push down to the leaves.
        let mut h: Vec<DVec3> = (0..self.patches.len())
            .into_par_iter()
            .map(|p| self.row(p).map(|&(q, f)| sent[q as usize] * f as f64).sum())
            .collect();
        for p in 0..h.len() {
            if self.whole[p] != NONE {
                h[p] = h[p] + h[self.whole[p] as usize];
            }
        }
        self.leaves.iter().zip(&self.factor).map(|(&leaf, &f)| h[leaf as usize] * f).collect()
    }

    /// `sweeps` Jacobi sweeps from a light at the leaves; `own` holds reflectance and own light of each.
    pub fn jacobi(&self, own: &[(DVec3, DVec3)], live: &[f64], light: &[NodeLight], sweeps: u32) -> Vec<NodeLight> {
        let mut h = open(light);
        for _ in 0..sweeps {
            let sent: Vec<DVec3> = own.iter().zip(&h).map(|((rho, own), h)| *own + *rho * *h).collect();
            h = self.carry(&sent, live);
        }
        close(&h)
    }
}

impl Growing<'_> {
    /// Evaluates the near ones among the links kept more carefully, and sorts all by receiver.
    fn settle<E: Engine>(mut self, engine: &mut E, kept: Vec<(u32, u32, f64)>, progress: &mut Progress) -> Result<Links> {
        let mut rows: Vec<Vec<(u32, f32)>> = vec![Vec::new(); self.links.patches.len()];
        for chunk in kept.chunks(FLIGHT / 16) {
            let near = |x: &Patch, y: &Patch| evaluations(x, y) > TRIALS;
            let pairs: Vec<(u32, u32)> = (chunk.iter())
                .filter(|(x, y, _)| near(&self.links.patches[*x as usize], &self.links.patches[*y as usize]))
                .map(|&(x, y, _)| (x, y))
                .collect();
            let mut careful = pairs.iter().zip(self.evaluate(engine, &pairs, evaluations)?).peekable();
            for &(x, y, trial) in chunk {
                let mean = match careful.next_if(|(pair, _)| **pair == (x, y)) {
                    Some((_, values)) => values.iter().sum::<f64>() / values.len() as f64,
                    None => trial,
                };
                let [a, b] = [x, y].map(|i| self.links.patches[i as usize].area);
                if mean > 0.0 {
                    rows[x as usize].push((y, (mean * b) as f32));
                    rows[y as usize].push((x, (mean * a) as f32));
                }
            }
            progress.tick()?;
        }
        let links = &mut self.links;
        links.offsets.push(0);
        for row in rows {
            links.links.extend(row);
            links.offsets.push(links.links.len());
        }
        links.leaves = (0..links.patches.len() as u32).filter(|&p| links.parts[p as usize].1 == 0).collect();
        Ok(self.links)
    }
}

/// The patches that a hierarchy over the scene grows from.
pub fn roots(geometry: &Geometry) -> Mesh {
    Mesh::new(geometry, ROOTS)
}
