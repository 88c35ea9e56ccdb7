//! Parameters of `--mode paper`.

use super::within;
use crate::error::Result;
pub use crate::network::supervised::{Fit, Output};
use serde::{Deserialize, Serialize};

/// How the cells of a supervised network become coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// The network's answers between nodes and quadrature points, times area (Nystroem's method).
    #[default]
    Nystrom,
    /// A cell is a link of its area times its value between the ends of its reference ray.
    Links,
}

/// What the seed paper leaves open, and what repairs it: parameters of [`crate::params::Mode::Paper`].
///
/// Bohn, "A neural network representation of three-dimensional geometrical scene descriptions", 1997. The defaults are
/// the paper's own method; `normals`, `output`, `calibrate`, `facing` and `clamp` are the repairs, each by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperParams {
    /// Dimension k of the topology's simplices, 1 to 4; default 2. Above 2 buys nothing.
    pub k: u32,
    /// Kernel evaluations, 256 to 2^24; default 32 a cell.
    pub evaluations: Option<u32>,
    /// Rate at which a best-matching cell moves toward an input, in (0, 1]; default 0.06 (Fritzke 1994).
    pub eps_b: f64,
    /// Rate at which its topological neighbours do, in [0, 1]; default 0.006.
    pub eps_n: f64,
    /// Rate of the delta rule, in (0, 1]; default 0.1.
    pub eta: f64,
    /// Share of its resource that a cell keeps from epoch to epoch, in [0, 1]; default 0.5.
    pub decay: f64,
    /// How the second layer has its last word.
    pub fit: Fit,
    /// What a cell puts out; linear cells are a repair.
    pub output: Output,
    /// Whether starved cells are deleted; default yes.
    pub deletion: bool,
    /// Whether inputs are evaluated only where the resource is high; default yes.
    pub resampling: bool,
    /// How the cells become coefficients.
    pub form: Form,
    /// Repair: normals belong to the metric, weighted by [`crate::Params::lambda`]; default no.
    pub normals: bool,
    /// Repair: coefficients between places that do not face each other are 0; default no.
    pub facing: bool,
    /// Repair: rows of coefficients are scaled to what a node sees of the scene; default no.
    pub calibrate: bool,
    /// Level at which the kernel is clamped, in units of 1/L² (1/L in flatland), 0.1 to 10,000; default 5. What
    /// is above is lost, and the report says how much; a higher level is a repair.
    pub clamp: f64,
}

impl Default for PaperParams {
    fn default() -> PaperParams {
        PaperParams {
            k: 2,
            evaluations: None,
            eps_b: 0.06,
            eps_n: 0.006,
            eta: 0.1,
            decay: 0.5,
            fit: Fit::Delta,
            output: Output::Gauss,
            deletion: true,
            resampling: true,
            form: Form::Nystrom,
            normals: false,
            facing: false,
            calibrate: false,
            clamp: 5.0,
        }
    }
}

impl PaperParams {
    pub(super) fn check(&self) -> Result<()> {
        within("k", self.k, 1, 4, "give 1 to 4")?;
        if let Some(n) = self.evaluations {
            within("evaluations", n, 256, 1 << 24, "give 256 to 16777216 evaluations")?;
        }
        within("eps_b", self.eps_b, 1e-6, 1.0, "give 1e-6 to 1")?;
        within("eps_n", self.eps_n, 0.0, 1.0, "give 0 to 1")?;
        within("eta", self.eta, 1e-6, 1.0, "give 1e-6 to 1")?;
        within("decay", self.decay, 0.0, 1.0, "give 0 to 1")?;
        within("clamp", self.clamp, 0.1, 1e4, "give 0.1 to 10000")
    }

    pub(super) fn is_default(&self) -> bool {
        *self == PaperParams::default()
    }

    /// Kernel evaluations asked for, or the default for a number of cells.
    pub fn evaluations(&self, cells: u32) -> u32 {
        self.evaluations.unwrap_or((32 * cells).max(256))
    }
}
