//! Supervised growing cell structures: a network that learns a function from pairs (xi, zeta).
//!
//! Bohn, "A neural network representation of three-dimensional geometrical scene descriptions", 1997, after Fritzke,
//! "Growing cell structures", Neural Networks 7(9), 1994. The first layer (the cells' centres) moves with each
//! best-matching cell and its topological neighbours, the second (their outputs) learns at the same time; a cell's
//! resource is its decayed squared error. What Fritzke does an input at a time is done here a batch at a time:
//! n steps of rate eps toward n inputs are one step of 1 - exp(-n eps) toward their mean.

mod layer;
mod topology;

use super::complex::Complex;
use crate::error::Result;
use crate::layout::{CellOutput, FEATURE_DIM, ResponseSums, Sample};
use crate::twin::fixed::FEATURE_UNIT;
use crate::twin::math::{seed_of, unit};
use crate::twin::respond::{Net, Responder};
use crate::twin::winner::Feature;
use serde::{Deserialize, Serialize};

/// Cells inserted in an epoch, as a share of those there are.
const GROWTH: f64 = 0.25;
/// Share of the evaluations that are spent while the network grows.
const GROWING: f64 = 0.7;
/// Epochs after the last insertion, in which centres settle.
const SETTLING: u64 = 4;
/// Evaluations of an epoch, at least.
const LEAST_BATCH: u64 = 64;
/// Candidates drawn at once, at most.
const CANDIDATES: usize = 65_536;
/// Acceptance of inputs, at least: what keeps their weights below 1 over this.
const LEAST_ACCEPTANCE: f64 = 0.1;
/// Root mean squared error, in units of the whole network's, at which every input is taken.
const FULL_ACCEPTANCE: f64 = 4.0;
/// Share of the mean activation that damps the delta rule: cells that answer nowhere to speak of do not drift.
const DAMPING: f64 = 0.05;
/// Cells that won fewer inputs than this share of the mean are starved.
const STARVED: f64 = 0.05;
/// Share of its wins that a cell keeps from epoch to epoch: longer than the resource lasts, so that a cell that is
/// merely unlucky is not taken for starved.
const REMEMBERED: f64 = 0.7;
/// Widths are at least this share of the largest one (hard case F01).
const LEAST_WIDTH: f32 = 1e-3;
/// Ridge of the linear cells' least squares, as a share of the inputs' mean variance.
const RIDGE: f64 = 0.02;
/// Epochs without growth after which there is none to be had.
const STUCK: u32 = 50;

/// How the second layer is fitted to all samples when the network is grown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// The delta rule, until it has seen every sample this often (the paper).
    #[default]
    Delta,
    /// Least squares, a cell at a time over the inputs that it wins.
    LeastSquares,
}

/// What a cell puts out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Output {
    /// A value; the best-matching cell and its neighbours answer together, by their Gaussian activations (the paper).
    #[default]
    Gauss,
    /// A plane; the best-matching cell answers alone. Fitted by least squares, whatever [`Fit`] says.
    Linear,
}

/// How a supervised network is trained.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Dimension of the topology's simplices, 1 to 4.
    pub k: usize,
    /// Components of an input that count, at most 13; all others are 0.
    pub dims: usize,
    /// Cells to grow to.
    pub cells: usize,
    /// Evaluations of the goal.
    pub evaluations: u64,
    /// Rate at which a best-matching cell moves toward an input.
    pub eps_b: f64,
    /// Rate at which its neighbours do.
    pub eps_n: f64,
    /// Rate of the delta rule.
    pub eta: f64,
    /// Share of the resource that an epoch leaves.
    pub decay: f64,
    /// Sweeps of the delta rule over all samples at the end.
    pub sweeps: u32,
    /// How the outputs are fitted at the end.
    pub fit: Fit,
    /// What a cell puts out.
    pub output: Output,
    /// Whether starved cells are deleted.
    pub deletion: bool,
    /// Whether inputs are evaluated only where the resource is high; else everywhere alike.
    pub resampling: bool,
    /// Seed of acceptance.
    pub seed: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            k: 2,
            dims: FEATURE_DIM,
            cells: 1024,
            evaluations: 32_768,
            eps_b: 0.06,
            eps_n: 0.006,
            eta: 0.1,
            decay: 0.5,
            sweeps: 64,
            fit: Fit::Delta,
            output: Output::Gauss,
            deletion: true,
            resampling: true,
            seed: 1,
        }
    }
}

/// A function to learn.
pub trait Goal {
    /// An input as the goal knows it.
    type Place: Copy;
    /// What the network runs on; the goal may use it for its own evaluations.
    type Machine: Responder;

    /// The machine.
    fn machine(&mut self) -> &mut Self::Machine;
    /// Inputs `first..first + count` of a sequence that covers the domain uniformly.
    fn draw(&mut self, first: u64, count: usize) -> Vec<Self::Place>;
    /// An input as a point of the network's space: [`Settings::dims`] numbers of order 1, then zeros.
    fn input(&self, place: &Self::Place) -> Feature;
    /// The values at places, in [-1, 1].
    fn evaluate(&mut self, places: &[Self::Place]) -> Result<Vec<f32>>;
}

/// All inputs that were evaluated, in their order.
#[derive(Clone, Debug)]
pub struct Samples<P> {
    /// As the goal knows them.
    pub places: Vec<P>,
    /// As the network knows them.
    pub inputs: Vec<Feature>,
    /// Values, weights, and with the last answer of the network.
    pub values: Vec<Sample>,
    /// Inputs drawn so far, taken or not: the sum of the weights is about as large.
    pub drawn: u64,
}

impl<P> Default for Samples<P> {
    fn default() -> Samples<P> {
        Samples { places: Vec::new(), inputs: Vec::new(), values: Vec::new(), drawn: 0 }
    }
}

/// A supervised network.
#[derive(Clone, Debug)]
pub struct Supervised {
    /// Centres of the cells.
    pub cells: Vec<Feature>,
    /// Their outputs.
    pub outputs: Vec<CellOutput>,
    /// Their topology.
    pub complex: Complex,
    /// Their resources: decayed sums of weight times squared error.
    pub resource: Vec<f64>,
    /// Decayed sums of the weights of the inputs won.
    share: Vec<f64>,
    /// Decayed numbers of inputs won.
    wins: Vec<f64>,
    /// Epochs run.
    pub epochs: u32,
    /// Cells deleted.
    pub deleted: u32,
    /// Epochs since the network last grew.
    idle: u32,
    /// Epochs since it was full.
    settled: u64,
}

fn distance(a: &Feature, b: &Feature) -> f32 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f32>().sqrt()
}

impl Supervised {
    /// One simplex: inputs of `sample` far enough apart to span it.
    pub fn start(settings: &Settings, sample: &[Feature]) -> Supervised {
        let corners = settings.k + 1;
        let mut cells: Vec<Feature> = Vec::new();
        for f in sample {
            if cells.len() < corners && cells.iter().all(|c| distance(c, f) > 1e-2) {
                cells.push(*f);
            }
        }
        while cells.len() < corners {
            // All inputs alike (or none): any cells serve.
            let mut f = sample.first().copied().unwrap_or_default();
            f[0] += 1e-2 * cells.len() as f32;
            cells.push(f);
        }
        let n = cells.len();
        let mut net = Supervised {
            cells,
            outputs: vec![CellOutput::default(); n],
            complex: Complex::simplex(settings.k),
            resource: vec![0.0; n],
            share: vec![0.0; n],
            wins: vec![0.0; n],
            epochs: 0,
            deleted: 0,
            idle: 0,
            settled: 0,
        };
        net.set_widths();
        net
    }

    /// Trains a network from nothing.
    pub fn train<G: Goal>(goal: &mut G, settings: &Settings) -> Result<(Supervised, Samples<G::Place>)> {
        let first: Vec<Feature> = goal.draw(0, 64).iter().map(|p| goal.input(p)).collect();
        let (mut net, mut samples) = (Supervised::start(settings, &first), Samples::default());
        while !net.epoch(goal, settings, &mut samples)? {}
        net.fit(goal.machine(), settings, &mut samples)?;
        Ok((net, samples))
    }

    /// An epoch: evaluates inputs, moves the cells toward them, teaches the outputs, inserts and deletes. Returns
    /// whether all is spent; [`Supervised::fit`] then has the last word.
    pub fn epoch<G: Goal>(&mut self, goal: &mut G, settings: &Settings, samples: &mut Samples<G::Place>) -> Result<bool> {
        let spent = samples.places.len() as u64;
        let left = settings.evaluations.saturating_sub(spent);
        let growing = self.cells.len() < settings.cells && self.idle < STUCK && left > 0;
        let more = ((GROWTH * self.cells.len() as f64).ceil() as usize).min(settings.cells.saturating_sub(self.cells.len()));
        let want = if growing {
            // What is left of the growth's share, by what is left to grow.
            let budget = (GROWING * settings.evaluations as f64 - spent as f64).max(0.0);
            let part = more as f64 / (settings.cells - self.cells.len()) as f64;
            ((budget * part).ceil() as u64).max(LEAST_BATCH).min(left)
        } else {
            left / (SETTLING - self.settled.min(SETTLING - 1))
        };
        let fresh = samples.inputs.len()..samples.inputs.len() + self.sample(goal, settings, want as usize, samples)?;

        let (offsets, neighbours) = self.complex.adjacency();
        let inputs = &samples.inputs[fresh.clone()];
        let sums = goal.machine().respond(self.net(settings, &offsets, &neighbours), inputs, &mut samples.values[fresh])?;
        self.teach(&sums, settings.eta);
        self.count(&sums, settings.decay);
        self.move_cells(&sums, settings, &offsets, &neighbours);
        self.epochs += 1;
        if growing {
            let before = self.cells.len();
            self.insert(more);
            if settings.deletion && self.epochs.is_multiple_of(3) {
                self.delete_starved();
            }
            self.idle = if self.cells.len() > before { 0 } else { self.idle + 1 };
        } else {
            self.settled += 1;
        }
        debug_assert_eq!(self.complex.check(), Ok(()));
        self.set_widths();
        Ok(self.settled >= SETTLING)
    }

    /// Draws inputs, takes them where the resource is high, and evaluates what was taken, `want` in all.
    fn sample<G: Goal>(&self, goal: &mut G, settings: &Settings, want: usize, samples: &mut Samples<G::Place>) -> Result<usize> {
        let acceptance = self.acceptance(settings);
        let mut taken = 0;
        while taken < want {
            let count = (2 * (want - taken)).clamp(256, CANDIDATES);
            let places = goal.draw(samples.drawn, count);
            let inputs: Vec<Feature> = places.iter().map(|p| goal.input(p)).collect();
            let winners = goal.machine().best(&inputs, &self.cells)?;
            let mut chosen = Vec::new();
            for i in 0..count {
                if taken == want {
                    break;
                }
                samples.drawn += 1;
                let chance = acceptance[winners[i] as usize];
                if (unit(seed_of(settings.seed, samples.drawn as u32)) as f64) < chance {
                    chosen.push(places[i]);
                    samples.inputs.push(inputs[i]);
                    samples.values.push(Sample { winner: winners[i], weight: (1.0 / chance) as f32, ..Sample::default() });
                    taken += 1;
                }
            }
            let values = goal.evaluate(&chosen)?;
            let first = samples.places.len();
            for (s, v) in samples.values[first..].iter_mut().zip(values) {
                s.goal = v;
            }
            samples.places.extend(chosen);
        }
        Ok(taken)
    }

    /// The chance that an input is taken, by its best-matching cell: its root mean squared error, relative to the
    /// whole network's.
    fn acceptance(&self, settings: &Settings) -> Vec<f64> {
        let (error, share): (f64, f64) = (self.resource.iter().sum(), self.share.iter().sum());
        if !settings.resampling || error <= 0.0 {
            return vec![1.0; self.cells.len()];
        }
        let mean = error / share;
        let chance = |(&r, &s): (&f64, &f64)| match s > 0.0 {
            true => ((r / s / mean).sqrt() / FULL_ACCEPTANCE).clamp(LEAST_ACCEPTANCE, 1.0),
            // Nothing is known of a cell without inputs.
            false => 1.0,
        };
        self.resource.iter().zip(&self.share).map(chance).collect()
    }

    /// Numbers that the second layer keeps: the coefficients.
    pub fn stored(&self, settings: &Settings) -> u64 {
        (self.cells.len() * if settings.output == Output::Linear { 1 + settings.dims } else { 1 }) as u64
    }

    /// The network as the pass `respond` reads it.
    fn net<'a>(&'a self, settings: &Settings, offsets: &'a [u32], neighbours: &'a [u32]) -> Net<'a> {
        let linear = settings.output == Output::Linear;
        Net { cells: &self.cells, outputs: &self.outputs, offsets, neighbours, linear }
    }

    /// Delta rule: outputs move by their activation-weighted mean error.
    pub fn teach(&mut self, sums: &[ResponseSums], eta: f64) {
        let activation = |s: &ResponseSums| s.activation.value(FEATURE_UNIT);
        let damping = DAMPING * sums.iter().map(activation).sum::<f64>() / sums.len() as f64;
        for (output, s) in self.outputs.iter_mut().zip(sums).filter(|(_, s)| activation(s) > 0.0) {
            let step = 1.0 - (-eta * activation(s)).exp();
            output.value += (step * s.gain.value(FEATURE_UNIT) / (activation(s) + damping)) as f32;
        }
    }

    /// Decays resources and wins, and adds the batch's.
    pub fn count(&mut self, sums: &[ResponseSums], decay: f64) {
        for (c, s) in sums.iter().enumerate() {
            self.resource[c] = decay * self.resource[c] + s.error.value(FEATURE_UNIT);
            self.share[c] = decay * self.share[c] + s.share.value(FEATURE_UNIT);
            self.wins[c] = REMEMBERED * self.wins[c] + s.count.units() as f64;
        }
    }

    /// Moves cells toward the inputs that they and their neighbours won.
    fn move_cells(&mut self, sums: &[ResponseSums], settings: &Settings, offsets: &[u32], neighbours: &[u32]) {
        for (c, cell) in self.cells.iter_mut().enumerate() {
            let mut rate = settings.eps_b * sums[c].count.units() as f64;
            let mut sum = [0.0; FEATURE_DIM];
            for k in 0..settings.dims {
                sum[k] = settings.eps_b * sums[c].feature[k].value(FEATURE_UNIT);
            }
            for &n in &neighbours[offsets[c] as usize..offsets[c + 1] as usize] {
                rate += settings.eps_n * sums[n as usize].count.units() as f64;
                for k in 0..settings.dims {
                    sum[k] += settings.eps_n * sums[n as usize].feature[k].value(FEATURE_UNIT);
                }
            }
            if rate > 0.0 {
                let step = 1.0 - (-rate).exp();
                for k in 0..settings.dims {
                    cell[k] += (step * (sum[k] / rate - cell[k] as f64)) as f32;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::respond::Host;
    use crate::twin::sobol::sobol4;

    /// A function over the unit square.
    struct Square(Host, fn(f32, f32) -> f32);

    impl Goal for Square {
        type Place = [f32; 2];
        type Machine = Host;

        fn machine(&mut self) -> &mut Host {
            &mut self.0
        }
        fn draw(&mut self, first: u64, count: usize) -> Vec<[f32; 2]> {
            (0..count).map(|i| sobol4(first as u32 + i as u32, 7)).map(|u| [unit(u[0]), unit(u[1])]).collect()
        }
        fn input(&self, p: &[f32; 2]) -> Feature {
            std::array::from_fn(|k| if k < 2 { p[k] } else { 0.0 })
        }
        fn evaluate(&mut self, places: &[[f32; 2]]) -> Result<Vec<f32>> {
            Ok(places.iter().map(|p| (self.1)(p[0], p[1])).collect())
        }
    }

    /// A step and a ridge.
    fn edgy(x: f32, y: f32) -> f32 {
        let step = if x + 0.5 * y > 0.9 { 0.6 } else { 0.0 };
        step + 0.4 * (-200.0 * (x - 0.3) * (x - 0.3)).exp()
    }

    fn settings(k: usize, cells: usize) -> Settings {
        Settings { k, dims: 2, cells, evaluations: 32 * cells as u64, ..Settings::default() }
    }

    #[test]
    fn the_error_falls_with_cells_at_every_k() {
        for k in 1..=4 {
            for output in [Output::Gauss, Output::Linear] {
                let mut errors = Vec::new();
                for cells in [64, 512] {
                    let s = Settings { output, ..settings(k, cells) };
                    let mut goal = Square(Host, edgy);
                    let (net, samples) = Supervised::train(&mut goal, &s).unwrap();
                    net.complex.check().unwrap();
                    assert_eq!((net.cells.len(), samples.places.len() as u64), (cells, s.evaluations));
                    errors.push(net.error(&mut goal, &s, 1 << 24, 8192).unwrap());
                }
                eprintln!("k {k}, {output:?}: {errors:?}");
                // Eight times the cells make a step's band (n^-1/2 wide) 2.8 times as narrow; its L2 error falls by
                // the square root of that.
                assert!(errors[1] < errors[0] / 1.4 && errors[1] < 0.2, "k {k}, {output:?}: {errors:?}");
            }
        }
    }

    /// A network in the middle of its growth.
    fn grown(cells: usize) -> Supervised {
        Supervised::train(&mut Square(Host, edgy), &settings(2, cells)).unwrap().0
    }

    #[test]
    fn insertion_hands_the_resource_on() {
        let mut net = grown(64);
        for _ in 0..200 {
            let (before, resource) = (net.cells.len(), net.resource.iter().sum::<f64>());
            net.insert(1);
            assert_eq!(net.cells.len(), before + 1);
            let after: f64 = net.resource.iter().sum();
            assert!((after / resource - 1.0).abs() < 1e-12, "{resource} became {after}");
            assert!(net.resource.iter().all(|r| *r >= 0.0));
            net.complex.check().unwrap();
        }
    }

    #[test]
    fn deletion_keeps_the_topology() {
        let mut net = grown(64);
        net.wins[5] = 0.0;
        net.wins[60] = 0.0;
        let kept = net.cells[59];
        net.delete_starved();
        assert!(net.cells.len() <= 62 && net.deleted >= 2 && net.cells.contains(&kept));
        let n = net.cells.len();
        assert_eq!([net.outputs.len(), net.resource.len(), net.share.len(), net.wins.len(), net.complex.cells()], [n; 5]);
        net.complex.check().unwrap();
    }

    #[test]
    fn cells_in_one_place_answer_their_mean() {
        // Hard case F01: two of three cells coincide, and all of their edges may have no length.
        for apart in [0.0, 1.0] {
            let mut net = Supervised::start(&settings(2, 3), &[]);
            net.cells = vec![[0.0; 16], [0.0; 16], [apart; 16]];
            net.outputs[0].value = 1.0;
            net.outputs[1].value = 2.0;
            net.outputs[2].value = 1.5;
            net.set_widths();
            let answer = net.answer(&mut Host, &settings(2, 3), &[[0.0; 16]]).unwrap()[0];
            assert!((answer - 1.5).abs() < 1e-6, "{apart}: {answer}");
        }
    }

    #[test]
    fn a_plane_is_learned_by_linear_cells() {
        let s = Settings { output: Output::Linear, ..settings(2, 32) };
        let mut goal = Square(Host, |x, y| 0.2 + 0.5 * x - 0.3 * y);
        let (net, _) = Supervised::train(&mut goal, &s).unwrap();
        // The ridge takes a fiftieth of the slope, over cells a fifth of the square wide: .02 * .5 * .2 at most.
        assert!(net.error(&mut goal, &s, 1 << 24, 4096).unwrap() < 0.005);
    }
}
