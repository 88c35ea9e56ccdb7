//! What was measured, as a table, as a CSV that `raycell sweep` draws, and as one ratio.

use crate::Outcome;
use crate::reference::Reference;
use std::path::Path;

/// A run of one method.
pub struct Row {
    method: &'static str,
    setting: String,
    seconds: f64,
    /// Seconds until points could be asked for.
    baked: Option<f64>,
    /// sqrt(mean (B - B*)^2)/mean(B*) over points and bands, the reference's own variance taken out.
    rrmse: f64,
    /// The relative error of half of the points is below, |B - B*| summed over bands against B*.
    median: f64,
    p90: f64,
    /// Sum of B against the reference's.
    ratio: f64,
}

impl Row {
    pub fn new(
        method: &'static str,
        setting: &str,
        reference: &Reference,
        b: &[[f64; 3]],
        seconds: f64,
        baked: Option<f64>,
    ) -> Row {
        let (mut square, mut sums, mut relative) = (0.0, [0.0; 2], Vec::new());
        for (i, b) in b.iter().enumerate() {
            let truth = reference.b(i);
            square += (0..3).map(|k| (b[k] - truth[k]).powi(2)).sum::<f64>();
            let light: f64 = truth.iter().sum();
            sums = [sums[0] + b.iter().sum::<f64>(), sums[1] + light];
            // Where no light comes there is nothing to be relative to.
            if light > 0.0 {
                relative.push((0..3).map(|k| (b[k] - truth[k]).abs()).sum::<f64>() / light);
            }
        }
        relative.sort_by(f64::total_cmp);
        let quantile = |q: f64| relative.get((q * relative.len() as f64) as usize).copied().unwrap_or(0.0);
        let square = (square / (3 * b.len()) as f64 - reference.variance()).max(0.0);
        let rrmse = square.sqrt() / reference.level();
        let setting = setting.to_string();
        Row { method, setting, seconds, baked, rrmse, median: quantile(0.5), p90: quantile(0.9), ratio: sums[0] / sums[1] }
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
        println!("| method | setting | seconds | of these baking | RRMSE % | median % | 90 % of points % | sum of B |");
        println!("|---|---|---|---|---|---|---|---|");
        Table { points, at, rows: Vec::new() }
    }

    pub fn add(&mut self, row: Row) {
        let baked = row.baked.map(|s| format!("{s:.1}")).unwrap_or_default();
        let errors = [row.rrmse, row.median, row.p90].map(|e| format!("{:.2}", 100.0 * e)).join(" | ");
        println!("| {} | {} | {:.2} | {baked} | {errors} | {:.4} |", row.method, row.setting, row.seconds, row.ratio);
        self.rows.push(row);
    }

    /// Seconds and median of a method at the RRMSE asked for, between the two runs beside it, as powers.
    fn cross(&self, method: &str) -> Option<(f64, f64)> {
        let mut own: Vec<&Row> = self.rows.iter().filter(|r| r.method == method && r.rrmse > 0.0).collect();
        own.sort_by(|a, b| b.rrmse.total_cmp(&a.rrmse));
        let after = own.iter().position(|r| r.rrmse <= self.at)?;
        let (a, b) = (own[after.checked_sub(1)?], own[after]);
        let t = (self.at / a.rrmse).ln() / (b.rrmse / a.rrmse).ln();
        let between = |a: f64, b: f64| (a.ln() + t * (b / a).ln()).exp();
        Some((between(a.seconds, b.seconds), between(a.median, b.median)))
    }

    /// Writes `peers.csv` and says what equal error costs.
    pub fn finish(self, out: &Path) -> Outcome {
        let mut csv = String::from("method,points,seconds,rrmse,median,p90\n");
        for r in &self.rows {
            csv += &format!("{},{},{},{},{},{}\n", r.method, self.points, r.seconds, r.rrmse, r.median, r.p90);
        }
        let path = out.join("peers.csv");
        std::fs::write(&path, csv)?;
        println!("\nwrote {}", path.display());
        match (self.cross("raycell"), self.cross("mitsuba")) {
            (Some(own), Some(peer)) => println!(
                "at {:.3} % RRMSE: raycell {:.2} s, median {:.2} %; Mitsuba {:.2} s, median {:.2} %: 1/{:.1} of its time",
                100.0 * self.at,
                own.0,
                100.0 * own.1,
                peer.0,
                100.0 * peer.1,
                peer.0 / own.0
            ),
            _ => println!("no ratio: the ladders do not both enclose {:.3} % RRMSE", 100.0 * self.at),
        }
        println!("Mitsuba's path integrator shares nothing between points, caches nothing, and is not denoised.");
        Ok(())
    }
}
