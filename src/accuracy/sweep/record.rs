//! What a sweep has found so far: sweep.json holds it all, sweep.csv a row a run. Both are written after every run.

use super::ladder::{Kind, Rung};
use crate::accuracy::norms::Errors;
use crate::error::{Error, Result};
use crate::output::atomic;
use crate::output::report::{AdapterReport, Report};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The estimate that a run gave of its own error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    pub rrmse: f64,
    pub low: f64,
    pub high: f64,
}

/// Stages whose seconds are told, in their order; what none of them has is `other`.
pub const STAGES: [&str; 8] = ["bvh", "train", "coefficients", "solve", "direct", "estimate", "other", "readout"];

/// A run that was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub method: Kind,
    /// Rays, patches or cells: what the method's settings count.
    pub size: u32,
    pub seed: u32,
    /// The error, by the reference; shares.
    pub rrmse: f64,
    pub noise: f64,
    pub trimmed: f64,
    /// Null where no point is good for it.
    pub median: Option<f64>,
    pub p90: Option<f64>,
    pub bias: f64,
    pub estimate: Option<Estimate>,
    /// Seconds of the bake and of the read-out at the reference's points, kernels compiled before.
    pub bake: f64,
    pub readout: f64,
    /// Seconds a stage, as [`STAGES`].
    pub stages: [f64; 8],
    /// Rays shot, or evaluations of the kernel.
    pub rays: u64,
    pub coefficients: u64,
    pub cells: u64,
    pub nodes: u64,
    /// Most bytes of the device's buffers, and of the process, while it ran; null where not known.
    pub device_bytes: Option<u64>,
    pub host_bytes: Option<u64>,
}

impl Row {
    /// A row from a run's report and errors.
    pub fn new(rung: &Rung, report: &Report, errors: &Errors, readout: f64, host_bytes: Option<u64>) -> Row {
        let s = &report.seconds;
        let bake = s.total.unwrap_or(f64::NAN);
        let estimating = report.extra.get("stages").and_then(|stages| stages.get("estimate")).and_then(|x| x.as_f64());
        let mut stages = [s.bvh, s.train, s.coefficients, s.solve, s.direct, estimating, None, Some(readout)]
            .map(|x: Option<f64>| x.unwrap_or(0.0));
        stages[6] = (bake - stages[..6].iter().sum::<f64>()).max(0.0);
        Row {
            method: rung.kind,
            size: rung.size,
            seed: rung.seed,
            rrmse: errors.rrmse,
            noise: errors.noise,
            trimmed: errors.trimmed,
            median: Some(errors.median).filter(|x| x.is_finite()),
            p90: Some(errors.p90).filter(|x| x.is_finite()),
            bias: errors.bias,
            estimate: report.estimated_error.as_ref().map(|e| Estimate { rrmse: e.rrmse, low: e.low, high: e.high }),
            bake,
            readout,
            stages,
            rays: report.rays.max(report.kernel_evaluations),
            coefficients: report.coefficients,
            cells: report.cells,
            nodes: report.nodes,
            device_bytes: report.memory_bytes.device.filter(|&b| b > 0),
            host_bytes,
        }
    }

    /// Bake and read-out.
    pub fn seconds(&self) -> f64 {
        self.bake + self.readout
    }

    /// Whether its error stands out of the reference's noise.
    pub fn is_clear(&self) -> bool {
        self.rrmse > 0.5 * self.noise && self.rrmse > 0.0
    }
}

/// The reference that errors are measured by.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceRecord {
    /// Its file.
    pub path: String,
    pub points: usize,
    /// Its own RRMSE.
    pub noise: f64,
    /// Paths a point, where it is of our own making.
    pub paths: Option<u64>,
    /// Digest of its numbers.
    pub of: String,
}

/// A picture that was made of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Look {
    /// The level of error that it stands for.
    pub shows: f64,
    pub method: Kind,
    pub size: u32,
    /// Its RRMSE over the pixels, by the path-traced picture.
    pub rrmse: f64,
    /// The run's own RRMSE, at the reference's points.
    pub level: f64,
    /// Files of the picture and of what it is off, without their folder.
    pub picture: String,
    pub difference: String,
}

/// A whole sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub raycell: String,
    pub scene: String,
    pub triangles: u64,
    /// Digest of the scene.
    pub of: String,
    /// Null for the plain-Rust twin.
    pub adapter: Option<AdapterReport>,
    pub reference: ReferenceRecord,
    /// Whether points were read out with final gathers.
    pub gather: bool,
    pub rows: Vec<Row>,
    #[serde(default)]
    pub looks: Vec<Look>,
    /// Runs that were left out, and why.
    #[serde(default)]
    pub left_out: Vec<String>,
}

impl Record {
    /// The record in a folder, empty where there is none. Errors: [`Error::Read`]; [`Error::Format`] where it is none.
    pub fn read(dir: &Path) -> Result<Option<Record>> {
        let path = dir.join("sweep.json");
        let text = match std::fs::read(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            read => read.map_err(|source| Error::Read { path: path.clone(), source })?,
        };
        let record = serde_json::from_slice(&text).map_err(|e| Error::Format {
            path,
            line: Some(e.line()).filter(|l| *l > 0),
            what: e.to_string(),
            cure: "give another folder with -o, or delete this one".into(),
        })?;
        Ok(Some(record))
    }

    /// What of this record is of another sweep than `now`; none where it can be gone on with.
    pub fn difference(&self, now: &Record) -> Option<&'static str> {
        if self.raycell != now.raycell {
            Some("raycell's version")
        } else if self.of != now.of {
            Some("the scene")
        } else if self.adapter != now.adapter {
            Some("the device")
        } else if self.reference.of != now.reference.of {
            Some("the reference")
        } else if self.gather != now.gather {
            Some("the read-out (--no-gather)")
        } else {
            None
        }
    }

    /// The run, if it was made.
    pub fn find(&self, rung: &Rung) -> Option<&Row> {
        self.rows.iter().find(|r| (r.method, r.size, r.seed) == (rung.kind, rung.size, rung.seed))
    }

    /// Runs of a kind, by size and seed.
    pub fn of_kind(&self, kind: Kind) -> Vec<&Row> {
        let mut rows: Vec<&Row> = self.rows.iter().filter(|r| r.method == kind).collect();
        rows.sort_by_key(|r| (r.size, r.seed));
        rows
    }

    /// Kinds that were run, in the order of reports.
    pub fn kinds(&self) -> Vec<Kind> {
        Kind::ALL.into_iter().filter(|&k| self.rows.iter().any(|r| r.method == k)).collect()
    }

    /// Writes sweep.json and sweep.csv. Errors: [`Error::Write`].
    pub fn write(&self, dir: &Path) -> Result<()> {
        let path = dir.join("sweep.json");
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|e| Error::Write { path: path.clone(), source: std::io::Error::other(e) })?;
        text.push('\n');
        atomic::write(&path, text.as_bytes())?;
        let mut csv = String::from(
            "method,size,seed,rrmse,reference_noise,rrmse_without_worst_1pc,median,p90,bias,estimate,estimate_low,estimate_high,\
             bake_seconds,readout_seconds",
        );
        for stage in STAGES {
            csv += &format!(",{stage}_s");
        }
        csv += ",rays,coefficients,cells,nodes,device_bytes,host_bytes\n";
        // An empty cell is not known.
        let known = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
        let whole = |x: Option<u64>| x.map(|x| x.to_string()).unwrap_or_default();
        for r in &self.rows {
            let mut cells = vec![r.method.name().to_string(), r.size.to_string(), r.seed.to_string()];
            cells.extend([r.rrmse, r.noise, r.trimmed].map(|x| x.to_string()));
            cells.extend([known(r.median), known(r.p90), r.bias.to_string()]);
            cells.extend([r.estimate.map(|e| e.rrmse), r.estimate.map(|e| e.low), r.estimate.map(|e| e.high)].map(known));
            cells.extend([r.bake, r.readout].map(|x| x.to_string()));
            cells.extend(r.stages.map(|x| x.to_string()));
            cells.extend([r.rays, r.coefficients, r.cells, r.nodes].map(|x| x.to_string()));
            cells.extend([r.device_bytes, r.host_bytes].map(whole));
            csv += &cells.join(",");
            csv.push('\n');
        }
        atomic::write(&dir.join("sweep.csv"), csv.as_bytes())
    }
}
