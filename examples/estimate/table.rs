//! A row a bake, a row a scene, and the claim's figures.

use crate::Outcome;
use crate::truths::Case;
use raycell::accuracy::norms::Errors;
use raycell::{Backend, Flow, Params, bake};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Instant, UNIX_EPOCH};

pub const HEADER: &str = "| scene | rays | seed | true RRMSE | truth's noise | median | estimate | low | high | inside? | seconds |\n\
                          |---|---|---|---|---|---|---|---|---|---|---|";

/// What a bake left: a truth that gets better later tells its error anew.
#[derive(Serialize, Deserialize)]
struct Run {
    /// Radiosity at the truth's points.
    b: Vec<[f64; 3]>,
    /// Estimate, low, high.
    estimate: Option<[f64; 3]>,
    seconds: f64,
}

/// What a run says.
struct Row {
    scene: String,
    rays: u32,
    error: f64,
    noise: f64,
    estimate: f64,
    low: f64,
    high: f64,
}

impl Row {
    fn inside(&self) -> bool {
        (self.low..=self.high).contains(&self.error)
    }
}

#[derive(Default)]
pub struct Table {
    /// The runs that have an estimate.
    rows: Vec<Row>,
    runs: usize,
}

/// Where runs of this very program are kept: those of another build are not mixed with them.
fn folder() -> Outcome<PathBuf> {
    let built = std::fs::metadata(std::env::current_exe()?)?.modified()?.duration_since(UNIX_EPOCH)?.as_secs();
    Ok(Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("target/estimate/runs-{built}")))
}

fn run(backend: &Backend, case: &Case, params: &Params) -> Outcome<Run> {
    let folder = folder()?;
    std::fs::create_dir_all(&folder)?;
    let path = folder.join(format!("{}-{}-{}.json", case.name.replace(' ', "-"), params.rays, params.seed));
    if let Ok(text) = std::fs::read(&path) {
        return Ok(serde_json::from_slice(&text)?);
    }
    let start = Instant::now();
    let solution = bake(backend, &case.scene, params, &mut |_| Flow::Continue)?;
    let seconds = start.elapsed().as_secs_f64();
    let b = solution.query(backend, &case.truth.points)?.iter().map(|a| a.b).collect();
    let estimate = solution.report().estimated_error.as_ref().map(|e| [e.rrmse, e.low, e.high]);
    let run = Run { b, estimate, seconds };
    std::fs::write(&path, serde_json::to_vec(&run)?)?;
    Ok(run)
}

fn cent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    of.get(of.len() / 2).copied().unwrap_or(f64::NAN)
}

fn share(of: usize, all: usize) -> f64 {
    100.0 * of as f64 / all.max(1) as f64
}

impl Table {
    /// Bakes, or takes what was baked, and tells its row.
    pub fn run(&mut self, backend: &Backend, case: &Case, params: &Params) -> Outcome<String> {
        let Run { b, estimate, seconds } = run(backend, case, params)?;
        let e = Errors::new(&b, &case.truth);
        self.runs += 1;
        let told = match estimate {
            None => "– | – | – | –".into(),
            Some([estimate, low, high]) => {
                let row =
                    Row { scene: case.name.clone(), rays: params.rays, error: e.rrmse, noise: e.noise, estimate, low, high };
                let inside = if row.inside() { "yes" } else { "**no**" };
                self.rows.push(row);
                format!("{} | {} | {} | {inside}", cent(estimate), cent(low), cent(high))
            }
        };
        let [name, rrmse, noise, median] = [case.name.clone(), cent(e.rrmse), cent(e.noise), cent(e.median)];
        Ok(format!("| {name} | {} | {} | {rrmse} | {noise} | {median} | {told} | {seconds:.1} |", params.rays, params.seed))
    }

    /// A row a scene: at each setting true → estimate, medians over the seeds, and how many runs lie inside.
    pub fn short(&self) -> String {
        let mut settings: Vec<u32> = self.rows.iter().map(|r| r.rays).collect();
        settings.sort_unstable();
        settings.dedup();
        let mut scenes: Vec<&str> = self.rows.iter().map(|r| r.scene.as_str()).collect();
        scenes.dedup();
        let titles: String = settings.iter().map(|rays| format!(" {rays} rays |")).collect();
        let mut text = format!("| scene | truth's noise |{titles}\n|---|---|{}\n", "---|".repeat(settings.len()));
        for scene in scenes {
            let of: Vec<&Row> = self.rows.iter().filter(|r| r.scene == scene).collect();
            text += &format!("| {scene} | {} |", cent(of[0].noise));
            for &rays in &settings {
                let at: Vec<&&Row> = of.iter().filter(|r| r.rays == rays).collect();
                let inside = at.iter().filter(|r| r.inside()).count();
                let of = |what: fn(&Row) -> f64| cent(median(at.iter().map(|r| what(r)).collect()));
                text += &format!(" {} → {}, {inside} of {} |", of(|r| r.error), of(|r| r.estimate), at.len());
            }
            text += "\n";
        }
        text
    }

    /// The claim's figures.
    pub fn claim(&self) -> String {
        if self.rows.is_empty() {
            return format!("{} runs, none with an estimate.", self.runs);
        }
        let n = self.rows.len();
        let count = |which: fn(&Row) -> bool| self.rows.iter().filter(|r| which(r)).count();
        let mut ratio: Vec<f64> = self.rows.iter().map(|r| r.estimate / r.error).collect();
        ratio.sort_by(f64::total_cmp);
        let (seen, seen_inside) = (count(|r| r.error >= 3.0 * r.noise), count(|r| r.error >= 3.0 * r.noise && r.inside()));
        format!(
            "{n} of {} runs with an estimate. The truth lies in [low, high] in {:.1} % of them, below in {:.1} %, above in {:.1} %; \
             where the error is 3 or more times the truth's noise ({seen} runs) in {:.1} %. Median high/low {:.2}. Estimate/true: \
             least {:.2}, median {:.2}, greatest {:.2}; under half in {} runs.",
            self.runs,
            share(count(Row::inside), n),
            share(count(|r| r.error < r.low), n),
            share(count(|r| r.error > r.high), n),
            share(seen_inside, seen),
            median(self.rows.iter().map(|r| r.high / r.low).collect()),
            ratio[0],
            ratio[n / 2],
            ratio[n - 1],
            ratio.iter().filter(|r| **r < 0.5).count()
        )
    }
}
