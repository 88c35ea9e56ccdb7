//! `report.json`: what a bake did. The keys are stable; a value that is not known is null, never a guess.

use super::atomic;
use crate::error::{Error, Result};
use crate::params::Params;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The record of a bake.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of raycell.
    pub raycell: String,
    /// What was lit.
    pub scene: SceneReport,
    /// What it ran on; null for the plain-Rust twin.
    pub adapter: Option<AdapterReport>,
    /// network, fem, hierarchical or rays.
    #[serde(default)]
    pub method: String,
    /// Seed of every random sequence.
    pub seed: u32,
    /// All parameters as used.
    pub params: Params,
    /// Effects considered; null where the bake was stopped.
    pub effects: Option<Vec<EffectReport>>,
    /// Cells of the network.
    pub cells: u64,
    /// Nodes of the surface network.
    pub nodes: u64,
    /// Stored coefficients: a network's gather and deposit slots, form factors, links, or directed rays.
    pub coefficients: u64,
    /// Evaluations of the kernel G V that the coefficients took; a network and its rays take none.
    #[serde(default)]
    pub kernel_evaluations: u64,
    /// Light rays of the full network; of a method with patches, the rays that look around on them.
    pub rays: u64,
    /// Wall time a stage.
    pub seconds: Seconds,
    /// Largest memory held.
    pub memory_bytes: Memory,
    /// How the light was solved for.
    pub solver: SolverReport,
    /// Where the emitted power went, W a band.
    pub energy: Energy,
    /// Estimated error of the result; null where the bake was stopped.
    pub estimated_error: Option<EstimatedError>,
    /// What was to be reached, and whether it was; null where nothing was asked for.
    #[serde(default)]
    pub target: Option<TargetReport>,
    /// How it was relit; null for a bake.
    #[serde(default)]
    pub relit: Option<RelitReport>,
    /// What was odd, in words.
    pub warnings: Vec<String>,
    /// Whether the bake was stopped before the light was solved and refined.
    #[serde(default)]
    pub partial: bool,
    /// How far a stopped bake came, in words; null where it came to its end.
    #[serde(default)]
    pub reached: Option<String>,
    /// Further keys, not yet stable.
    #[serde(flatten)]
    pub extra: serde_json::Map<String, serde_json::Value>,
}

/// The scene of a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneReport {
    /// Path or name.
    pub path: String,
    /// Triangles lit.
    pub triangles: u64,
    /// Triangles left out.
    pub dropped: u64,
}

/// The device of a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AdapterReport {
    /// Its name.
    pub name: String,
    /// vulkan, metal, dx12 or gl.
    pub backend: String,
    /// Driver and version.
    pub driver: String,
}

/// An effect of a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EffectReport {
    /// Its name.
    pub name: String,
    /// Whether it was on.
    pub on: bool,
    /// Why.
    pub why: String,
    /// What it costs, in words.
    pub cost: String,
    /// Its part of the light, estimated from a few thousand paths; none where it was not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// Wall time that it took, read-outs included and kernels' compiling not; none where it took none or cannot be told apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// Wall time of the stages, seconds; null where a stage was not run or not measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Seconds {
    /// Reading the scene.
    pub load: Option<f64>,
    /// Opening the device.
    #[serde(default)]
    pub open: Option<f64>,
    /// Building the hierarchy.
    pub bvh: Option<f64>,
    /// Compiling kernels, the driver's part included.
    pub compile: Option<f64>,
    /// Training the network.
    pub train: Option<f64>,
    /// Reading the cells as coefficients.
    pub coefficients: Option<f64>,
    /// Solving for the light.
    pub solve: Option<f64>,
    /// Exact direct light.
    pub direct: Option<f64>,
    /// Reading out at points, vertices and pixels.
    pub readout: Option<f64>,
    /// All of it.
    pub total: Option<f64>,
}

/// Memory of a [`Report`], bytes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// On the host.
    pub host: Option<u64>,
    /// On the device.
    pub device: Option<u64>,
}

/// The solve of a [`Report`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolverReport {
    /// jacobi or gauss-seidel.
    pub method: String,
    /// Sweeps made.
    pub sweeps: u64,
    /// Relative residual at the end.
    pub residual: Option<f64>,
    /// Bound on the relative distance from the fixed point.
    pub error_bound: Option<f64>,
}

/// The energy balance of a [`Report`]: emitted = absorbed + escaped + imbalance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Power emitted, W a band.
    pub emitted: Option<[f64; 3]>,
    /// Power absorbed by surfaces.
    pub absorbed: Option<[f64; 3]>,
    /// Power that left the scene.
    pub escaped: Option<[f64; 3]>,
    /// What is missing, as a share of what was emitted.
    pub imbalance: Option<f64>,
    /// What of `absorbed` mirrors have taken, what was given up between them included; not there where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirrors: Option<[f64; 3]>,
    /// What of `absorbed` the medium has taken; not there where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub medium: Option<[f64; 3]>,
    /// What was given up between mirrors ([`crate::twin::way`]), at most, as a share of what was emitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given_up: Option<f64>,
}

/// The estimated error of a [`Report`]: root mean square over the surface, over the mean (`docs/accuracy.md`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EstimatedError {
    /// The estimate.
    pub rrmse: f64,
    /// Lower end of its interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// What it is made of.
    #[serde(default)]
    pub parts: ErrorParts,
    /// Where it sits: parts of the surface of equal area, each with an error of its own.
    #[serde(default)]
    pub regions: Vec<RegionError>,
}

/// What an [`EstimatedError`] is made of, each as a share of the mean radiosity; null where there is no such thing.
/// Their squares add up to that of the whole as far as they are independent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorParts {
    /// Scatter of the light rays.
    pub rays: Option<f64>,
    /// What cells blur, where they carry light.
    pub cells: Option<f64>,
    /// What lies between nodes.
    pub nodes: Option<f64>,
    /// Scatter of direct light at a shown point.
    pub direct: Option<f64>,
    /// Scatter of final gathers.
    pub gather: Option<f64>,
    /// What an error of the mean becomes over many reflections.
    pub carried: Option<f64>,
    /// What the solver has left.
    pub solver: Option<f64>,
    /// Light of reflections that were not asked for.
    pub truncation: Option<f64>,
}

/// The estimated error of a part of the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionError {
    /// Lower corner of its box, metres.
    pub min: [f64; 3],
    /// Upper corner.
    pub max: [f64; 3],
    /// Mean radiosity in it, W/m², over the bands.
    pub mean: f64,
    /// Error in it, as a share of its own mean.
    pub rrmse: f64,
}

/// How a solution came by other light than it was baked with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RelitReport {
    /// The solution's file; null where there was none.
    pub from: Option<String>,
    /// What was changed, one each, as the flags say it.
    pub changes: Vec<String>,
    /// scaled (all light is a multiple of the bake's, a band each: exact), solved (the network carries new light), or re-traced
    /// (the changed scene was baked).
    pub how: String,
    /// Why so, in words.
    pub why: String,
    /// The error that the bake states; null where it states none.
    pub baked_error: Option<f64>,
    /// What is added to the error by a network that was tuned for other light, as a share of the mean radiosity; null where
    /// it was re-traced.
    pub extra_error: Option<f64>,
    /// Share of the new light that the bake's own rays carry as they are; the rest goes by cells. Null where it was re-traced.
    pub known: Option<f64>,
    /// As many rays, drawn for the new light, would scatter as little as the bake's; null where it was re-traced.
    pub effective_rays: Option<f64>,
    /// Wall time without kernels being compiled, and without reading files.
    pub seconds: Option<f64>,
}

/// What a bake was to reach.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TargetReport {
    /// Relative error that the upper end of the estimate was to be within.
    pub error: Option<f64>,
    /// Wall time it had, seconds.
    pub seconds: Option<f64>,
    /// Whether the error was reached; null where none was asked for.
    pub met: Option<bool>,
    /// Where it was not: what stood in the way, and what it would take.
    pub missed: Option<String>,
    /// The rungs that were climbed.
    pub rungs: Vec<RungReport>,
}

/// A rung of a [`TargetReport`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RungReport {
    /// Light rays.
    pub rays: u32,
    /// Wall time of its bake, without compiling.
    pub seconds: f64,
    /// Its estimated error.
    pub rrmse: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// What it is made of.
    pub parts: ErrorParts,
}

impl Report {
    /// The report in a bake's folder. Errors: [`Error::Read`], [`Error::Format`].
    pub fn read(folder: &Path) -> Result<Report> {
        let path = folder.join("report.json");
        let text = std::fs::read_to_string(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
        serde_json::from_str(&text).map_err(|e| Error::Format {
            path,
            line: Some(e.line()),
            what: e.to_string(),
            cure: "give the folder of a bake by this version".into(),
        })
    }
}

/// Writes a report as JSON. Errors: [`Error::Write`].
pub fn write(path: &Path, report: &Report) -> Result<()> {
    let mut text =
        serde_json::to_string_pretty(report).map_err(|e| Error::Write { path: path.into(), source: std::io::Error::other(e) })?;
    text.push('\n');
    atomic::write(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_contract_is_there() {
        let mut report = Report::default();
        report.extra.insert("pilot".into(), 1.into());
        let json = serde_json::to_value(&report).unwrap();
        let keys = "scene.path scene.triangles scene.dropped adapter method seed params effects cells nodes coefficients kernel_evaluations rays \
            seconds.load seconds.bvh seconds.train seconds.coefficients seconds.solve seconds.direct seconds.readout \
            seconds.total memory_bytes.host memory_bytes.device solver.method solver.sweeps solver.residual \
            solver.error_bound partial reached energy.emitted energy.absorbed energy.escaped energy.imbalance estimated_error target warnings pilot";
        for key in keys.split_whitespace() {
            let found = key.split('.').try_fold(&json, |at, k| at.get(k));
            assert!(found.is_some(), "{key}");
        }
        assert!(json["effects"].is_null() && json["estimated_error"].is_null());
        assert_eq!(serde_json::from_value::<Report>(json).unwrap(), report);
    }
}
