//! A row a bake, and the claim's three figures.

use crate::truths::Case;
use raycell::accuracy::norms::Errors;
use raycell::{Backend, Flow, Params, Result, bake};
use std::time::Instant;

pub const HEADER: &str = "| scene | rays | seed | true RRMSE | truth's noise | median | estimate | low | high | inside? | seconds |\n\
                          |---|---|---|---|---|---|---|---|---|---|---|";

#[derive(Default)]
pub struct Table {
    /// True error, estimate, low, high: the runs that have an estimate.
    rows: Vec<[f64; 4]>,
    runs: usize,
}

impl Table {
    /// Bakes, and tells its row.
    pub fn run(&mut self, backend: &Backend, case: &Case, params: &Params) -> Result<String> {
        let start = Instant::now();
        let solution = bake(backend, &case.scene, params, &mut |_| Flow::Continue)?;
        let seconds = start.elapsed().as_secs_f64();
        let answers = solution.query(backend, &case.truth.points)?;
        let e = Errors::new(&answers.iter().map(|a| a.b).collect::<Vec<_>>(), &case.truth);
        self.runs += 1;
        let cent = |x: f64| format!("{:.2} %", 100.0 * x);
        let estimate = match &solution.report().estimated_error {
            None => "– | – | – | –".into(),
            Some(estimate) => {
                self.rows.push([e.rrmse, estimate.rrmse, estimate.low, estimate.high]);
                let inside = if (estimate.low..=estimate.high).contains(&e.rrmse) { "yes" } else { "**no**" };
                format!("{} | {} | {} | {inside}", cent(estimate.rrmse), cent(estimate.low), cent(estimate.high))
            }
        };
        let [name, rrmse, noise, median] = [case.name.clone(), cent(e.rrmse), cent(e.noise), cent(e.median)];
        Ok(format!("| {name} | {} | {} | {rrmse} | {noise} | {median} | {estimate} | {seconds:.1} |", params.rays, params.seed))
    }

    /// The claim's figures.
    pub fn claim(&self) -> String {
        if self.rows.is_empty() {
            return format!("{} runs, none with an estimate.", self.runs);
        }
        let n = self.rows.len();
        let inside = self.rows.iter().filter(|[e, _, low, high]| (low..=high).contains(&e)).count();
        let mut width: Vec<f64> = self.rows.iter().map(|[_, _, low, high]| high / low).collect();
        width.sort_by(f64::total_cmp);
        let mut ratio: Vec<f64> = self.rows.iter().map(|[e, estimate, ..]| estimate / e).collect();
        ratio.sort_by(f64::total_cmp);
        format!(
            "{n} of {} runs with an estimate. The truth lies in [low, high] in {:.1} % of them; median high/low {:.2}; least \
             estimate/true {:.2} (median {:.2}, greatest {:.2}).",
            self.runs,
            100.0 * inside as f64 / n as f64,
            width[n / 2],
            ratio[0],
            ratio[n / 2],
            ratio[n - 1]
        )
    }
}
