//! `raycell sweep`: what accuracy costs, a method beside the other.

use super::console::Console;
use super::exit::{Done, Failure};
use super::log::Log;
use super::shared::camera::{self, Camera};
use super::shared::interrupt::{heed, interrupt};
use super::shared::machine::{Device, Machine};
use super::shared::scene::{self, Reading};
use crate::accuracy::sweep::ladder::{Kind, Sizes};
use crate::accuracy::sweep::{Options, Ways, page, record::Record, run as sweep};
use crate::error::Error;
use crate::progress::Event;
use crate::scene::Geometry;
use clap::{Args, ValueEnum};
use serde_json::{Map, json};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples:
  raycell sweep room.obj
      What accuracy costs in this scene: sweep/index.html says it in words, plots and pictures.
  raycell sweep room.obj --methods network,fem --seeds 3 --minutes 5
      Two methods, three seeds, five minutes. The same command again goes on with what was left out.
  raycell sweep room.obj --reference truth.csv -o against_truth
      By a truth of your own: px,py,pz,nx,ny,nz,B_r,B_g,B_b and, where known, stderr_r,stderr_g,stderr_b.
  raycell sweep room.obj --noise 0.1 --points 2048 --minutes 60
      A better reference, and more of it.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Scene to light: .obj with its .mtl, .gltf, .glb or .toml.
    pub scene: PathBuf,
    /// Folder for the results, made where it does not exist; what lies there already is not run again.
    #[arg(short, long, value_name = "DIR", default_value = "sweep")]
    pub output: PathBuf,
    /// Methods to run.
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',', default_values_t = [Method::Network, Method::NetworkDirect,
          Method::Paper, Method::Fem, Method::Hierarchical, Method::Rays])]
    pub methods: Vec<Method>,
    /// Runs of each setting, which differ by chance alone.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub seeds: u32,
    /// Time for all of it; runs that would go beyond are left out.
    #[arg(long, default_value_t = 15.0)]
    pub minutes: f64,
    /// Truth to measure errors by: CSV with points and B_r,B_g,B_b [default: one is made by path tracing].
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Points of a reference that is made.
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(8..=1_000_000))]
    pub points: u32,
    /// Noise at which a reference that is made is good enough, per cent of the mean light; a tenth of --minutes at most.
    #[arg(long, value_name = "PCT", default_value_t = 0.25)]
    pub noise: f64,
    /// Paths a point of a reference that is made, however long they take.
    #[arg(long, value_name = "N")]
    pub paths: Option<u64>,
    /// Settings of the networks and of raw rays [default: 8192 to 2097152 by fours; in flatland from 2048].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub rays: Option<Vec<u32>>,
    /// Settings of finite elements; the hierarchical method begins with half [default: 100,350,800,1600,3200].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub patches: Option<Vec<u32>>,
    /// Settings of paper mode, with 32 evaluations each [default: 128,256,512,1024].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub cells: Option<Vec<u32>>,
    /// Leave final gathers out of the read-out, to see the methods' own errors.
    #[arg(long)]
    pub no_gather: bool,
    /// Another program's curve, to be drawn beside: CSV with method,points,seconds,rrmse,median,p90.
    #[arg(long, value_name = "FILE")]
    pub peers: Option<PathBuf>,
    /// Go on with the sweep in DIR; it does so anyway.
    #[arg(long, hide = true)]
    pub resume: bool,
    #[command(flatten)]
    pub reading: Reading,
    #[command(flatten)]
    pub camera: Camera,
    #[command(flatten)]
    pub device: Device,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The network, direct light exact: what bake does.
    Network,
    /// The network carries all light.
    NetworkDirect,
    /// The seed paper's network.
    Paper,
    /// Finite elements.
    Fem,
    /// Links of a hierarchy.
    Hierarchical,
    /// Every light ray its own coefficient.
    Rays,
}

impl Method {
    fn kind(self) -> Kind {
        match self {
            Method::Network => Kind::Network,
            Method::NetworkDirect => Kind::NetworkDirect,
            Method::Paper => Kind::Paper,
            Method::Fem => Kind::Fem,
            Method::Hierarchical => Kind::Hierarchical,
            Method::Rays => Kind::Rays,
        }
    }
}

/// A list of settings, smallest first, each once.
fn sorted(list: Option<Vec<u32>>, default: Vec<u32>) -> Vec<u32> {
    let mut list = list.unwrap_or(default);
    list.sort_unstable();
    list.dedup();
    list
}

pub fn run(flags: Flags, console: &Console) -> std::result::Result<Done, Failure> {
    let begin = Instant::now();
    let positive = |name: &'static str, x: f64| match x > 0.0 && x.is_finite() {
        true => Ok(x),
        false => Err(Error::InvalidParam { name, value: x.to_string(), range: "give a number more than 0" }),
    };
    let (minutes, noise) = (positive("minutes", flags.minutes)?, positive("noise", flags.noise)? / 100.0);
    let camera = camera::camera(&flags.camera)?;
    let dir = &flags.output;
    if dir.exists() && !dir.is_dir() {
        let source = std::io::Error::from(std::io::ErrorKind::NotADirectory);
        return Err(Error::Write { path: dir.clone(), source }.into());
    }
    let log = RefCell::new(Log::new(console));
    let stop = interrupt();
    let scene = scene::load(&flags.scene, &flags.reading, &mut log.borrow_mut(), &stop)?;
    let camera = scene::camera(camera, flags.camera.view.as_deref(), &scene)?;
    let default = Sizes::of(scene.is_flatland());
    let mut kinds: Vec<Kind> = flags.methods.iter().map(|m| m.kind()).collect();
    if !scene.lights.is_empty() || scene.environment.is_some() {
        let all = kinds.len();
        kinds.retain(|k| !matches!(k, Kind::NetworkDirect | Kind::Paper));
        if kinds.is_empty() {
            let range = "lights without a surface, and the sky, are no end of a ray that these could learn: add another method";
            return Err(Error::InvalidParam { name: "methods", value: "network-direct, paper".into(), range }.into());
        }
        if kinds.len() < all {
            let what = "network-direct and paper are left out: they know no light without a surface, and the scene has some";
            log.borrow_mut().warning(what);
        }
    }
    let options = Options {
        kinds,
        sizes: Sizes {
            rays: sorted(flags.rays, default.rays),
            patches: sorted(flags.patches, default.patches),
            cells: sorted(flags.cells, default.cells),
        },
        seeds: flags.seeds,
        gather: !flags.no_gather,
        time: Duration::from_secs_f64((60.0 * minutes).min(1e9)),
        reference: flags.reference,
        points: flags.points as usize,
        noise,
        paths: flags.paths,
        camera,
        peers: flags.peers,
    };
    // A setting that cannot be is refused before any run.
    for &kind in &options.kinds {
        options.sizes.of_kind(kind).iter().try_for_each(|&size| kind.params(size, 1, true).check())?;
    }
    let geometry = Geometry::new(&scene)?;
    let machine = Machine::open(&flags.device, &log.borrow())?;
    std::fs::create_dir_all(dir).map_err(|source| Error::Write { path: dir.clone(), source })?;
    let ways = Ways { dir, scene: &scene, geometry: &geometry, backend: &machine.backend, adapter: machine.adapter.clone() };
    let mut tell = |event: &Event| heed(&mut log.borrow_mut(), &stop, event);
    let swept = sweep(&ways, &options, &mut tell, &|text| log.borrow().line(text));
    let swept = machine.judge("the sweep", swept);
    log.borrow_mut().finish();
    let record = swept.map_err(|error| stopped(error, dir))?;
    for kind in record.kinds() {
        log.borrow().line(&page::sentence(&record, kind));
    }
    log.borrow().line(&format!("wrote {}", dir.join("index.html").display()));
    let methods = record.kinds().into_iter().map(|kind| (kind.name().to_string(), told(&record, kind)));
    Ok(Done::new(json!({
        "command": "sweep",
        "output": dir.display().to_string(),
        "runs": record.rows.len(),
        "left_out": record.left_out,
        "reference_noise": record.reference.noise,
        "methods": methods.collect::<Map<_, _>>(),
        "seconds": begin.elapsed().as_secs_f64(),
    })))
}

/// What a script wants to know of a method; null where it is not known.
fn told(record: &Record, kind: Kind) -> serde_json::Value {
    let fit = page::fit(record, kind);
    json!({
        "runs": record.of_kind(kind).len(),
        "exponent": fit.map(|f| f.exponent),
        "halving_costs": fit.and_then(|f| f.halving()),
        "seconds_for_1pc": fit.and_then(|f| f.forecast(0.01)).map(|f| [f.low, f.cost, f.high]),
    })
}

/// What is there when the user stops it.
fn stopped(error: Error, dir: &Path) -> Failure {
    let rows = Record::read(dir).ok().flatten().map_or(0, |r| r.rows.len());
    let words = matches!(error, Error::Cancelled).then(|| match rows {
        0 => "interrupted; no run is done. The same command goes on from here".to_string(),
        _ => format!("interrupted; {rows} runs lie in {}, with their page. The same command goes on from there", dir.display()),
    });
    Failure { error, words }
}
