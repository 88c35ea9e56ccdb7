//! What was measured, as a table, as a CSV that `raycell sweep` draws, and as one ratio.

use crate::Outcome;
use raycell::accuracy::norms::Errors;
use raycell::accuracy::truth::Truth;
use std::path::Path;

/// What a run took.
#[derive(Clone, Copy)]
pub struct Seconds {
    pub wall: f64,
    /// Of all cores together, what other programs took left out; where the system tells.
    pub cores: Option<f64>,
}

/// A run of one method.
pub struct Row {
    method: &'static str,
    setting: String,
    seconds: Seconds,
    /// Seconds until points could be asked for.
    baked: Option<f64>,
    errors: Errors,
}

impl Row {
    pub fn new(method: &'static str, setting: &str, truth: &Truth, b: &[[f64; 3]], seconds: Seconds, baked: Option<f64>) -> Row {
        let errors = Errors::new(b, truth);
        let setting = setting.to_string();
        Row { method, setting, seconds, baked, errors }
    }
}

/// All runs at one list of points.
pub struct Table {
    points: usize,
    at: f64,
    rows: Vec<Row>,
}

impl Table {
    pub fn new(points: usize, at: f64) -> Table {
        println!(
            "| method | setting | seconds | of these baking | core seconds | RRMSE % | median % | 90 % of points % | sum of B |"
        );
        println!("|---|---|---|---|---|---|---|---|---|");
        Table { points, at, rows: Vec::new() }
    }

    pub fn add(&mut self, row: Row) {
        let [baked, cores] = [row.baked, row.seconds.cores].map(|s| s.map(|s| format!("{s:.1}")).unwrap_or_default());
        let errors = [row.errors.rrmse, row.errors.median, row.errors.p90].map(|e| format!("{:.2}", 100.0 * e)).join(" | ");
        println!(
            "| {} | {} | {:.2} | {baked} | {cores} | {errors} | {:.4} |",
            row.method,
            row.setting,
            row.seconds.wall,
            1.0 + row.errors.bias
        );
        self.rows.push(row);
    }

    /// Seconds, core seconds and median of a method at the RRMSE asked for, between the two runs beside it, as powers.
    fn cross(&self, method: &str) -> Option<[f64; 3]> {
        let mut own: Vec<&Row> = self.rows.iter().filter(|r| r.method == method && r.errors.rrmse > 0.0).collect();
        own.sort_by(|a, b| b.errors.rrmse.total_cmp(&a.errors.rrmse));
        let after = own.iter().position(|r| r.errors.rrmse <= self.at)?;
        let (a, b) = (own[after.checked_sub(1)?], own[after]);
        let t = (self.at / a.errors.rrmse).ln() / (b.errors.rrmse / a.errors.rrmse).ln();
        let between = |a: f64, b: f64| (a.ln() + t * (b / a).ln()).exp();
        let cores = |r: &Row| r.seconds.cores.unwrap_or(f64::NAN);
        Some([between(a.seconds.wall, b.seconds.wall), between(cores(a), cores(b)), between(a.errors.median, b.errors.median)])
    }

    /// Writes `peers.csv` and says what equal error costs.
    pub fn finish(self, out: &Path) -> Outcome {
        let mut csv = String::from("method,points,seconds,rrmse,median,p90\n");
        for r in &self.rows {
            csv += &format!(
                "{},{},{},{},{},{}\n",
                r.method, self.points, r.seconds.wall, r.errors.rrmse, r.errors.median, r.errors.p90
            );
        }
        let path = out.join("peers.csv");
        std::fs::write(&path, csv)?;
        println!("\nwrote {}", path.display());
        match (self.cross("raycell"), self.cross("mitsuba")) {
            (Some(own), Some(peer)) => {
                let tell = |name: &str, [seconds, cores, median]: [f64; 3]| {
                    println!(
                        "{name} at {:.3} % RRMSE: {seconds:.2} s ({cores:.2} core seconds), median {:.2} %",
                        100.0 * self.at,
                        100.0 * median
                    );
                };
                tell("raycell", own);
                tell("Mitsuba", peer);
                println!("Mitsuba takes {:.1} times as long ({:.1} times the core seconds)", peer[0] / own[0], peer[1] / own[1]);
            }
            _ => println!("no ratio: the ladders do not both enclose {:.3} % RRMSE", 100.0 * self.at),
        }
        println!("Mitsuba's path integrator shares nothing between points, caches nothing, and is not denoised.");
        Ok(())
    }
}
