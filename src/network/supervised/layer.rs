//! The second layer: fitted to all samples by the delta rule or by least squares, and asked.

use super::{Fit, Goal, Output, RIDGE, Samples, Settings, Supervised};
use crate::error::Result;
use crate::layout::{NONE, Sample};
use crate::twin::respond::Responder;
use crate::twin::winner::Feature;

impl Supervised {
    /// Fits the outputs to all samples. Each sample knows its best-matching cell and the network's answer afterwards.
    pub fn fit<P, M: Responder>(&mut self, machine: &mut M, settings: &Settings, samples: &mut Samples<P>) -> Result<()> {
        let winners = machine.best(&samples.inputs, &self.cells)?;
        for (s, w) in samples.values.iter_mut().zip(winners) {
            s.winner = w;
        }
        if settings.fit == Fit::LeastSquares || settings.output == Output::Linear {
            self.least_squares(settings, samples);
        }
        let (offsets, neighbours) = self.complex.adjacency();
        let sweeps = if settings.fit == Fit::Delta && settings.output == Output::Gauss { settings.sweeps } else { 0 };
        for sweep in 0..=sweeps {
            let sums = machine.respond(self.net(settings, &offsets, &neighbours), &samples.inputs, &mut samples.values)?;
            if sweep < sweeps {
                self.teach(&sums, f64::INFINITY);
            }
        }
        Ok(())
    }

    /// Least squares of each cell's own samples: a value, and with linear cells a ridged slope.
    pub(super) fn least_squares<P>(&mut self, settings: &Settings, samples: &Samples<P>) {
        let dims = if settings.output == Output::Linear { settings.dims } else { 0 };
        let mut of_cell: Vec<Vec<u32>> = vec![Vec::new(); self.cells.len()];
        for (i, s) in samples.values.iter().enumerate().filter(|(_, s)| s.winner != NONE) {
            of_cell[s.winner as usize].push(i as u32);
        }
        for (c, own) in of_cell.iter().enumerate() {
            let weight: f64 = own.iter().map(|&i| samples.values[i as usize].weight as f64).sum();
            if weight <= 0.0 {
                continue;
            }
            let mean = |f: &dyn Fn(usize) -> f64| {
                own.iter().map(|&i| samples.values[i as usize].weight as f64 * f(i as usize)).sum::<f64>() / weight
            };
            let centre: Vec<f64> = (0..dims).map(|k| mean(&|i| samples.inputs[i][k] as f64)).collect();
            let value = mean(&|i| samples.values[i].goal as f64);
            let off = |i: usize, k: usize| samples.inputs[i][k] as f64 - centre[k];
            let mut matrix = vec![vec![0.0; dims]; dims];
            let mut right = vec![0.0; dims];
            for a in 0..dims {
                for b in 0..=a {
                    matrix[a][b] = mean(&|i| off(i, a) * off(i, b));
                    matrix[b][a] = matrix[a][b];
                }
                right[a] = mean(&|i| off(i, a) * (samples.values[i].goal as f64 - value));
            }
            let ridge = RIDGE * (0..dims).map(|k| matrix[k][k]).sum::<f64>() / dims.max(1) as f64;
            (0..dims).for_each(|k| matrix[k][k] += ridge);
            let slope = if ridge > 0.0 { solve(matrix, right) } else { vec![0.0; dims] };
            let output = &mut self.outputs[c];
            output.slope = std::array::from_fn(|k| slope.get(k).map_or(0.0, |&s| s as f32));
            let at_cell: f64 = (0..dims).map(|k| slope[k] * (self.cells[c][k] as f64 - centre[k])).sum();
            output.value = (value + at_cell) as f32;
        }
    }

    /// The network's answers to any inputs.
    pub fn answer<M: Responder>(&self, machine: &mut M, settings: &Settings, inputs: &[Feature]) -> Result<Vec<f32>> {
        let winners = machine.best(inputs, &self.cells)?;
        let mut samples: Vec<Sample> = winners.into_iter().map(|winner| Sample { winner, ..Sample::default() }).collect();
        let (offsets, neighbours) = self.complex.adjacency();
        machine.respond(self.net(settings, &offsets, &neighbours), inputs, &mut samples)?;
        Ok(samples.iter().map(|s| s.output).collect())
    }

    /// Relative L2 error of the network's answers at `count` fresh inputs from `first` on of the goal's sequence.
    pub fn error<G: Goal>(&self, goal: &mut G, settings: &Settings, first: u64, count: usize) -> Result<f64> {
        let places = goal.draw(first, count);
        let inputs: Vec<Feature> = places.iter().map(|p| goal.input(p)).collect();
        let goals = goal.evaluate(&places)?;
        let answers = self.answer(goal.machine(), settings, &inputs)?;
        let square = |x: f64| x * x;
        let off: f64 = goals.iter().zip(&answers).map(|(g, a)| square(*g as f64 - *a as f64)).sum();
        let all: f64 = goals.iter().map(|g| square(*g as f64)).sum();
        Ok(if all > 0.0 { (off / all).sqrt() } else { off.sqrt() })
    }
}

/// Solves a symmetric positive definite system by elimination.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for p in 0..n {
        for r in p + 1..n {
            let f = a[r][p] / a[p][p];
            for k in p..n {
                a[r][k] -= f * a[p][k];
            }
            b[r] -= f * b[p];
        }
    }
    for p in (0..n).rev() {
        let known: f64 = (p + 1..n).map(|k| a[p][k] * b[k]).sum();
        b[p] = (b[p] - known) / a[p][p];
    }
    b
}
