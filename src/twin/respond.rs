//! Pass `respond`: the output of a supervised network, and what its errors leave in the cells.
//!
//! B. Fritzke, "Growing cell structures: a self-organizing network for unsupervised and supervised learning",
//! Neural Networks 7(9), 1994, section 4; Bohn, "A neural network representation of three-dimensional geometrical
//! scene descriptions", 1997. Activations exp(-|xi - w_c|^2 / sigma_c^2) of the best-matching cell and its
//! topological neighbours, normalised to sum 1.

use super::fixed::{FEATURE_UNIT, encode};
use super::winner::Feature;
use crate::error::Result;
use crate::layout::{CellOutput, FEATURE_DIM, NONE, ResponseSums, Sample};
use rayon::prelude::*;

/// A supervised network as the pass reads it.
#[derive(Clone, Copy, Debug)]
pub struct Net<'a> {
    /// Centres of the cells.
    pub cells: &'a [Feature],
    /// Their outputs.
    pub outputs: &'a [CellOutput],
    /// Start of each cell's neighbours; one more entry than cells.
    pub offsets: &'a [u32],
    /// Neighbours.
    pub neighbours: &'a [u32],
    /// Whether the best-matching cell answers alone, by its plane, instead of a Gaussian mean of values.
    pub linear: bool,
}

/// A machine that a supervised network runs on.
pub trait Responder {
    /// Pass `winner`: the cell nearest to each input, ties to the lowest index.
    fn best(&mut self, inputs: &[Feature], cells: &[Feature]) -> Result<Vec<u32>>;
    /// Pass `respond`: sets the samples' outputs and sums what they leave in the cells.
    fn respond(&mut self, net: Net, inputs: &[Feature], samples: &mut [Sample]) -> Result<Vec<ResponseSums>>;
}

/// The processor, for functions that need no scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Host;

impl Responder for Host {
    fn best(&mut self, inputs: &[Feature], cells: &[Feature]) -> Result<Vec<u32>> {
        Ok(super::winner::winner(inputs, cells))
    }

    fn respond(&mut self, net: Net, inputs: &[Feature], samples: &mut [Sample]) -> Result<Vec<ResponseSums>> {
        Ok(respond(net, inputs, samples))
    }
}

fn distance2(a: &Feature, b: &Feature) -> f32 {
    (0..FEATURE_DIM).map(|k| (a[k] - b[k]) * (a[k] - b[k])).fold(0.0, |sum, x| sum + x)
}

impl Net<'_> {
    /// The best-matching cell and its neighbours.
    fn active(&self, winner: u32) -> impl Iterator<Item = u32> + Clone {
        let c = winner as usize;
        let row = self.offsets[c] as usize..self.offsets[c + 1] as usize;
        let row = if self.linear { 0..0 } else { row };
        std::iter::once(winner).chain(self.neighbours[row].iter().copied())
    }

    /// |xi - w_c|^2 / sigma_c^2
    fn exponent(&self, cell: u32, input: &Feature) -> f32 {
        let width = self.outputs[cell as usize].width;
        distance2(input, &self.cells[cell as usize]) / (width * width)
    }

    /// The activations of all that answer, relative to the greatest (so that none underflows, hard case F04), and their sum.
    fn activations<'a>(&'a self, winner: u32, input: &'a Feature) -> (impl Iterator<Item = (u32, f32)> + 'a, f32) {
        // The first of the least exponents, as the device has it.
        let exponents = self.active(winner).map(|c| (c, self.exponent(c, input)));
        let (nearest, least) = exponents.fold((winner, f32::MAX), |best, e| if e.1 < best.1 { e } else { best });
        let activation = move |c| if c == nearest { 1.0 } else { (least - self.exponent(c, input)).min(0.0).exp() };
        let all = self.active(winner).map(move |c| (c, activation(c)));
        let sum = all.clone().fold(0.0, |sum, (_, a)| sum + a);
        (all, sum)
    }

    /// What the network answers to an input that `winner` matches best; 0 where there is no cell.
    pub fn answer(&self, winner: u32, input: &Feature) -> f32 {
        if winner == NONE {
            return 0.0;
        }
        let own = &self.outputs[winner as usize];
        if self.linear {
            let cell = &self.cells[winner as usize];
            return (0..FEATURE_DIM).fold(own.value, |sum, k| sum + own.slope[k] * (input[k] - cell[k]));
        }
        let (all, sum) = self.activations(winner, input);
        all.map(|(c, a)| a / sum * self.outputs[c as usize].value).fold(0.0, |sum, x| sum + x)
    }
}

/// Sets the samples' outputs and sums what they leave in the cells.
pub fn respond(net: Net, inputs: &[Feature], samples: &mut [Sample]) -> Vec<ResponseSums> {
    samples.par_iter_mut().zip(inputs).for_each(|(s, input)| s.output = net.answer(s.winner, input));
    let mut sums = vec![ResponseSums::default(); net.cells.len()];
    for (s, input) in samples.iter().zip(inputs).filter(|(s, _)| s.winner != NONE) {
        let error = s.goal - s.output;
        let own = &mut sums[s.winner as usize];
        for k in 0..FEATURE_DIM {
            own.feature[k].add(encode(input[k], FEATURE_UNIT));
        }
        own.count.add(1);
        own.share.add(encode(s.weight, FEATURE_UNIT));
        own.error.add(encode(s.weight * (error * error), FEATURE_UNIT));
        let (all, sum) = net.activations(s.winner, input);
        for (c, activation) in all {
            let activation = s.weight * (activation / sum);
            sums[c as usize].gain.add(encode(activation * error, FEATURE_UNIT));
            sums[c as usize].activation.add(encode(activation, FEATURE_UNIT));
        }
    }
    sums
}
