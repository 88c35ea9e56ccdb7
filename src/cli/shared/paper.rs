//! The seed paper's mode: flags, and the parameters they make.

use crate::error::{Error, Result};
use crate::params::{self, Mode, PaperParams, Params};
use clap::{Args, ValueEnum};

/// The method of the seed paper (Bohn 1997), to reproduce and to measure it.
#[derive(Args)]
#[command(next_help_heading = "Paper mode")]
pub struct Paper {
    /// What the network learns [default: flux].
    #[arg(long, value_enum)]
    pub mode: Option<ModeFlag>,
    /// Dimension of the topology's simplices, 1 to 4 [default: 2].
    #[arg(long)]
    pub k: Option<u32>,
    /// Kernel evaluations, 256 to 16777216 [default: 32 a cell].
    #[arg(long, value_name = "N")]
    pub paper_evaluations: Option<u32>,
    /// Rate at which the best-matching cell moves toward an input [default: 0.06].
    #[arg(long, value_name = "RATE")]
    pub paper_eps_b: Option<f64>,
    /// Rate at which its topological neighbours do [default: 0.006].
    #[arg(long, value_name = "RATE")]
    pub paper_eps_n: Option<f64>,
    /// How the second layer has its last word [default: delta].
    #[arg(long, value_enum)]
    pub paper_fit: Option<Fit>,
    /// Keep cells that win nothing.
    #[arg(long)]
    pub paper_no_deletion: bool,
    /// Evaluate every input, not only those where the resource is high.
    #[arg(long)]
    pub paper_no_resampling: bool,
    /// How the cells become coefficients [default: nystrom].
    #[arg(long, value_enum)]
    pub paper_coefficients: Option<Form>,
    /// Repair: normals belong to the metric.
    #[arg(long)]
    pub paper_normals: bool,
    /// Repair: a cell puts out a plane.
    #[arg(long)]
    pub paper_linear: bool,
    /// Repair: coefficients between places that do not face each other are 0.
    #[arg(long)]
    pub paper_facing: bool,
    /// Repair: rows of coefficients sum to what a node sees of the scene.
    #[arg(long)]
    pub paper_calibrate: bool,
    /// Level at which the kernel is clamped, in 1/L², in flatland 1/L; higher is a repair [default: 5].
    #[arg(long, value_name = "LEVEL")]
    pub paper_clamp: Option<f64>,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum ModeFlag {
    /// The flow of light: cells are bundles of light rays.
    Flux,
    /// The kernel itself, as the seed paper does, with --direct network and no final gathers.
    Paper,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Fit {
    /// The delta rule over all samples.
    Delta,
    /// Least squares, a cell at a time.
    LeastSquares,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Form {
    /// The network's answers between nodes and quadrature points.
    Nystrom,
    /// A cell is a link of its area times its value.
    Links,
}

/// Sets the parameters of the mode. Errors: [`Error::InvalidParam`] where the mode's flags are given without it.
pub fn apply(flags: &Paper, direct_given: bool, params: Params) -> Result<Params> {
    let default = PaperParams::default();
    let paper = PaperParams {
        k: flags.k.unwrap_or(default.k),
        evaluations: flags.paper_evaluations,
        eps_b: flags.paper_eps_b.unwrap_or(default.eps_b),
        eps_n: flags.paper_eps_n.unwrap_or(default.eps_n),
        fit: flags.paper_fit.map_or(default.fit, |f| match f {
            Fit::Delta => params::Fit::Delta,
            Fit::LeastSquares => params::Fit::LeastSquares,
        }),
        output: if flags.paper_linear { params::Output::Linear } else { default.output },
        deletion: !flags.paper_no_deletion,
        resampling: !flags.paper_no_resampling,
        form: flags.paper_coefficients.map_or(default.form, |f| match f {
            Form::Nystrom => params::Form::Nystrom,
            Form::Links => params::Form::Links,
        }),
        normals: flags.paper_normals,
        facing: flags.paper_facing,
        calibrate: flags.paper_calibrate,
        clamp: flags.paper_clamp.unwrap_or(default.clamp),
        ..default
    };
    if !matches!(flags.mode, Some(ModeFlag::Paper)) {
        if paper != PaperParams::default() {
            let range = "--k and the --paper flags belong to --mode paper; give it, or leave them out";
            return Err(Error::InvalidParam { name: "mode", value: "flux".into(), range });
        }
        return Ok(params);
    }
    let direct = if direct_given { params.direct } else { params::Direct::Network };
    Ok(Params { mode: Mode::Paper, direct, gather_rays: 0, paper, ..params })
}
