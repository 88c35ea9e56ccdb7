//! `raycell paper`: the figures of the paper, made again.

use super::console::Console;
use super::exit::{Done, Failure};
use super::log::Log;
use super::shared::interrupt::{heed, interrupt};
use super::shared::machine::{Device, Machine};
use crate::error::Error;
use crate::paper::{Figure, Press, fig1, fig2, fig3, fig4, page};
use crate::plot::panel::number;
use crate::progress::Event;
use clap::{Args, ValueEnum};
use serde_json::{Map, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  raycell paper all -o figures
      Every figure of the paper as PNG and SVG, its data as CSV, and one page: figures/index.html.
  raycell paper fig2 --function bells --cells 200 --k 3
      Another function of the plane, with other networks.
  raycell paper fig2 --function portrait.png --cells 2000
      An image is a function, too: its brightness.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Which figure.
    #[arg(value_enum)]
    pub figure: Which,
    /// Folder for the figures, made where it does not exist.
    #[arg(short, long, value_name = "DIR", default_value = "figures")]
    pub output: PathBuf,
    /// Seed of every random sequence: same seed, same device, same bytes.
    #[arg(long, default_value_t = 1)]
    pub seed: u32,
    /// Fig. 2: the function to fit: ridge-step, bells, or a .png whose brightness it is.
    #[arg(long, value_name = "NAME|IMAGE")]
    pub function: Option<String>,
    /// Fig. 2: cells of the network.
    #[arg(long)]
    pub cells: Option<usize>,
    /// Fig. 2: dimension of the network's topology, 1 to 4.
    #[arg(long)]
    pub k: Option<usize>,
    #[command(flatten)]
    pub device: Device,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Which {
    /// A museum, from two places.
    Fig1,
    /// A function of the plane.
    Fig2,
    /// A kernel in flatland.
    Fig3,
    /// One reflection in flatland.
    Fig4a,
    /// One reflection in space.
    Fig4bc,
    All,
}

pub fn run(flags: Flags, console: &Console) -> std::result::Result<Done, Failure> {
    let begin = Instant::now();
    let mut plane = fig2::Options::default();
    plane.function = flags.function.unwrap_or(plane.function);
    plane.cells = flags.cells.unwrap_or(plane.cells);
    plane.k = flags.k.unwrap_or(plane.k);
    plane.check()?;
    let dir = &flags.output;
    let mut log = Log::new(console);
    let stop = interrupt();
    let machine = Machine::open(&flags.device, &log)?;
    std::fs::create_dir_all(dir).map_err(|source| Error::Write { path: dir.clone(), source })?;
    let mut figures: Vec<Figure> = Vec::new();
    for which in [Which::Fig1, Which::Fig2, Which::Fig3, Which::Fig4a, Which::Fig4bc] {
        if flags.figure != Which::All && flags.figure != which {
            continue;
        }
        let mut tell = |event: &Event| heed(&mut log, &stop, event);
        let press = &mut Press { dir, backend: &machine.backend, seed: flags.seed, tell: &mut tell };
        let made = match which {
            Which::Fig1 => fig1::make(press, &fig1::Options::default()),
            Which::Fig2 => fig2::make(press, &plane),
            Which::Fig3 => fig3::make(press, &fig3::Options::default()),
            Which::Fig4a => fig4::flat(press, &fig4::Options::default()),
            Which::Fig4bc | Which::All => fig4::solid(press, &fig4::Options::default()),
        };
        let figure = machine.judge("a figure", made).map_err(|error| stopped(error, dir, &figures))?;
        log.finish();
        for n in &figure.numbers {
            log.line(&format!("{}: {}: {} {}", figure.name, n.what, number(n.value), if n.unit == "1" { "" } else { n.unit }));
        }
        figures.push(figure);
    }
    page::write(dir, &figures)?;
    log.line(&format!("wrote {}", dir.join("index.html").display()));
    let numbers = |f: &Figure| f.numbers.iter().map(|n| (n.what.clone(), json!(n.value))).collect::<Map<_, _>>();
    Ok(Done::new(json!({
        "command": "paper",
        "output": dir.display().to_string(),
        "figures": figures.iter().map(|f| (f.name.to_string(), json!(numbers(f)))).collect::<Map<_, _>>(),
        "seconds": begin.elapsed().as_secs_f64(),
    })))
}

/// What is there when the user stops it: figures are written one by one.
fn stopped(error: Error, dir: &Path, figures: &[Figure]) -> Failure {
    let done: Vec<&str> = figures.iter().map(|f| f.name).collect();
    let words = matches!(error, Error::Cancelled).then(|| match done.is_empty() {
        true => "interrupted; no figure is done".to_string(),
        false => format!("interrupted; {} lie in {}, without their page", done.join(", "), dir.display()),
    });
    Failure { error, words }
}
