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
    #[command(flatten)]
    pub paper: Paper,
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
        ..default
    };
    let params = paper::apply(&flags.paper, flags.direct.is_some(), params)?;
    params.check()?;
    Ok(params)
}
