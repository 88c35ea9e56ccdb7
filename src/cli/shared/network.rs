//! How the network is trained: flags, and the parameters they make.

use super::paper::{self, Paper};
use crate::error::Result;
use crate::params::{self, Params};
use clap::{Args, ValueEnum};

/// How the network is trained.
#[derive(Args)]
#[command(next_help_heading = "Network")]
pub struct Network {
    /// Seed of every random sequence: same seed, same device, same bytes [default: 1].
    #[arg(long)]
    pub seed: Option<u32>,
    /// Light rays, 1024 to 16777216 [default: 524288].
    #[arg(long)]
    pub rays: Option<u32>,
    /// Cells of the network, 16 to 100000 [default: rays/512; with --direct network rays/128; with
    /// --mode paper 1024].
    #[arg(long)]
    pub cells: Option<u32>,
    /// How light straight from emitters is carried [default: exact; with --mode paper network].
    #[arg(long, value_enum)]
    pub direct: Option<Direct>,
    /// How the kernel of a flatland scene is normalised [default: lambert].
    #[arg(long, value_enum)]
    pub norm: Option<Norm>,
    /// What carries light between surfaces: the network, or a classical method to compare it with [default: network].
    #[arg(long, value_enum)]
    pub method: Option<Method>,
    /// Patches of --method fem, 4 to 32768; the hierarchical method divides some further [default: 1600].
    #[arg(long)]
    pub patches: Option<u32>,
    /// How the linear system is solved [default: jacobi].
    #[arg(long, value_enum)]
    pub solver: Option<Solver>,
    /// Reflections that are counted [default: all of them].
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
    /// Where points get a final gather [default: adaptive].
    #[arg(long, value_enum)]
    pub gather: Option<Gather>,
    /// Times the rays carry the solution once more, 0 to 16; for comparisons.
    #[arg(long, hide = true)]
    pub refinements: Option<u32>,
    /// Where cells come from; for comparisons.
    #[arg(long, value_enum, hide = true)]
    pub cells_from: Option<Cells>,
    #[command(flatten)]
    pub paper: Paper,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Method {
    /// The neural mesh of light rays.
    Network,
    /// Finite elements: uniform patches, a form factor for each pair.
    Fem,
    /// Links between patches of a hierarchy, as coarse as their light allows.
    Hierarchical,
    /// Every light ray its own coefficient.
    Rays,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Solver {
    /// All nodes at once.
    Jacobi,
    /// One node after the other, on the host; with --method network or fem.
    GaussSeidel,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Cells {
    /// Grown and trained on the rays.
    Trained,
    /// Rays drawn at random.
    Random,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Gather {
    /// Nowhere: the nodes' own light.
    None,
    /// Where surroundings are nearer than nodes lie apart, or nodes disagree.
    Adaptive,
    /// At every point.
    Everywhere,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Norm {
    /// cos cos / (2 r): what a diffuse line sends out arrives.
    Lambert,
    /// cos cos / (2 pi r), as the paper of 1997 prints it: 68 % of all light is lost.
    Paper1997,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Direct {
    /// Sampled exactly at every point.
    Exact,
    /// Through the network like all other light.
    Network,
}

pub fn params(flags: &Network) -> Result<Params> {
    let default = Params::default();
    let params = Params {
        seed: flags.seed.unwrap_or(default.seed),
        rays: flags.rays.unwrap_or(default.rays),
        cells: flags.cells,
        direct: flags.direct.map_or(default.direct, |d| match d {
            Direct::Exact => params::Direct::Exact,
            Direct::Network => params::Direct::Network,
        }),
        norm: flags.norm.map_or(default.norm, |n| match n {
            Norm::Lambert => params::Norm::Lambert,
            Norm::Paper1997 => params::Norm::Paper1997,
        }),
        method: flags.method.map_or(default.method, |m| match m {
            Method::Network => params::Method::Network,
            Method::Fem => params::Method::Fem,
            Method::Hierarchical => params::Method::Hierarchical,
            Method::Rays => params::Method::Rays,
        }),
        patches: flags.patches.unwrap_or(default.patches),
        solver: flags.solver.map_or(default.solver, |s| match s {
            Solver::Jacobi => params::Solver::Jacobi,
            Solver::GaussSeidel => params::Solver::GaussSeidel,
        }),
        bounces: flags.bounces,
        gather_rays: match flags.gather {
            Some(Gather::None) => 0,
            _ => default.gather_rays,
        },
        gather_threshold: match flags.gather {
            Some(Gather::Everywhere) => params::EVERYWHERE,
            _ => default.gather_threshold,
        },
        refinements: flags.refinements.unwrap_or(default.refinements),
        cells_from: flags.cells_from.map_or(default.cells_from, |c| match c {
            Cells::Trained => params::Cells::Trained,
            Cells::Random => params::Cells::Random,
        }),
        ..default
    };
    let params = paper::apply(&flags.paper, flags.direct.is_some(), params)?;
    params.check()?;
    Ok(params)
}
