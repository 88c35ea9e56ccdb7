//! Error against seconds beside another renderer, on the same points and the same cores, in turn.
//!
//! `cargo run --release --example peers` bakes the Cornell box and asks at 65,536 points; beside it, where Python finds
//! Mitsuba 3 (`--python PATH`; `pip install mitsuba`, and LLVM 16 or later), Mitsuba's path integrator answers for the
//! same points. `benches/README.md` has the flags, and what is counted.

mod reference;
mod table;
mod worker;

use raycell::accuracy::truth::Truth;
use raycell::gpu::{Gpu, device};
use raycell::scene::Geometry;
use raycell::twin::sobol::sobol4;
use raycell::twin::trace::{place_on, position};
use raycell::{Backend, Flow, Params, Scene, SurfacePoint, bake};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use table::{Row, Seconds, Table};
use worker::Worker;

/// What may fail anywhere.
pub type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// What is run.
struct Job {
    scene: PathBuf,
    points: usize,
    /// Points and reference, where they are known.
    truth: Option<PathBuf>,
    python: String,
    threads: usize,
    /// Samples a point of the peer's ladder.
    spp: Vec<u32>,
    /// Samples a point of the reference.
    reference: u32,
    seeds: u32,
    /// RRMSE at which seconds are compared.
    at: f64,
    /// Settings of raycell's ladder, each with its name.
    ladder: Vec<(String, Params)>,
    out: PathBuf,
}

fn main() -> Outcome {
    let job = Job::from_args()?;
    std::fs::create_dir_all(&job.out)?;
    let scene = Scene::load(&job.scene)?;
    let known = job.truth.as_deref().map(Truth::read).transpose()?;
    let points = match &known {
        Some(truth) => truth.points.clone(),
        None => places(&scene, job.points)?,
    };
    let open = device::open(device::BackendChoice::Auto, None)?;
    let driver = format!("{} {}", open.info.driver, open.info.driver_info);
    println!("raycell on {} ({:?}, {})", open.info.name, open.info.backend, driver.trim());
    let backend = Backend::Gpu(Arc::new(Gpu::new(&open.device, &open.queue)?));
    let mut peer = match Worker::start(&job.python, &job.scene, &points, job.threads, &job.out)? {
        Ok(worker) => {
            println!("peer {}", worker.version);
            Some(worker)
        }
        Err(why) => {
            println!("peer skipped: {why}");
            None
        }
    };
    let truth = match known {
        Some(truth) => truth,
        None => reference::get(&job.out, &job.scene, &points, job.reference, peer.as_mut())?,
    };
    println!("noise of the reference: {:.2} %, taken out of RRMSE, not of quantiles\n", 100.0 * truth.noise());

    // Kernels compile and memory is touched before the clock runs, on both sides.
    for (_, params) in job.ladder.iter().take(1) {
        let warm = Params { rays: 16_384, ..params.clone() };
        bake(&backend, &scene, &warm, &mut |_| Flow::Continue)?.query(&backend, &points[..points.len().min(1024)])?;
    }
    let mut table = Table::new(points.len(), job.at);
    for seed in 1..=job.seeds {
        for step in 0..job.ladder.len().max(job.spp.len()) {
            if let Some((name, params)) = job.ladder.get(step) {
                let params = Params { seed, ..params.clone() };
                let (start, cores) = (Instant::now(), core_seconds());
                let solution = bake(&backend, &scene, &params, &mut |_| Flow::Continue)?;
                let baked = start.elapsed().as_secs_f64();
                let answers = solution.query(&backend, &points)?;
                let seconds = Seconds {
                    wall: start.elapsed().as_secs_f64(),
                    cores: core_seconds().zip(cores).map(|(now, then)| now - then),
                };
                let b: Vec<[f64; 3]> = answers.iter().map(|a| a.b).collect();
                table.add(Row::new("raycell", name, &truth, &b, seconds, Some(baked)));
            }
            if let (Some(peer), Some(&spp)) = (&mut peer, job.spp.get(step)) {
                let (seconds, b) = peer.bake(spp, seed)?;
                table.add(Row::new("mitsuba", &format!("{spp} samples"), &truth, &b, seconds, None));
            }
        }
    }
    table.finish(&job.out)
}

/// Processor time of this process on all cores, drivers' threads included; where there is Linux's `/proc`.
fn core_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut ticks = stat.rsplit(')').next()?.split_whitespace().skip(11).map(|t| t.parse::<f64>());
    Some((ticks.next()?.ok()? + ticks.next()?.ok()?) / 100.0)
}

/// Points uniform over the surfaces that reflect.
fn places(scene: &Scene, count: usize) -> Outcome<Vec<SurfacePoint>> {
    let geometry = Geometry::new(scene)?;
    let reflects = |t: usize| geometry.material_of(t).rho.iter().any(|r| *r > 0.0);
    let mut sum = 0.0;
    let cdf: Vec<(f64, usize)> = (0..geometry.tris.len())
        .filter(|&t| reflects(t))
        .map(|t| {
            sum += geometry.areas[t];
            (sum, t)
        })
        .collect();
    let unit = |x: u32| x as f32 / 4294967296.0;
    Ok((0..count as u32)
        .map(|i| {
            let u = sobol4(i, 20_011);
            let wanted = u[2] as f64 / 4294967296.0 * sum;
            let t = cdf[cdf.partition_point(|c| c.0 <= wanted).min(cdf.len() - 1)].1;
            let (b1, b2) = place_on(geometry.flatland, unit(u[0]), unit(u[1]));
            let local = position(geometry.flatland, &geometry.tris[t], b1, b2);
            let p = geometry.to_world(local.to_array());
            SurfacePoint { p, n: geometry.tris[t].normal.map(f64::from) }
        })
        .collect())
}

impl Job {
    fn from_args() -> Outcome<Job> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut job = Job {
            scene: root.join("scenes/cornell/scene.obj"),
            points: 65_536,
            truth: None,
            python: "python3".into(),
            threads: std::thread::available_parallelism()?.get(),
            spp: vec![64, 256, 1280],
            reference: 4096,
            seeds: 1,
            at: 0.03,
            ladder: Vec::new(),
            out: root.join("target/peers"),
        };
        let mut args = std::env::args().skip(1);
        while let Some(flag) = args.next() {
            let value = args.next().ok_or_else(|| format!("{flag} needs a value"))?;
            match flag.as_str() {
                "--scene" => job.scene = value.into(),
                "--points" => job.points = value.parse()?,
                "--truth" => job.truth = Some(value.into()),
                "--python" => job.python = value,
                "--threads" => job.threads = value.parse()?,
                "--spp" => job.spp = value.split(',').filter(|x| !x.is_empty()).map(str::parse).collect::<Result<_, _>>()?,
                "--reference" => job.reference = value.parse()?,
                "--seeds" => job.seeds = value.parse()?,
                "--at" => job.at = value.parse::<f64>()? / 100.0,
                "--try" => job.ladder.push((value.clone(), tried(&value)?)),
                "-o" => job.out = value.into(),
                _ => return Err(format!("there is no flag {flag}; benches/README.md has them").into()),
            }
        }
        if job.ladder.is_empty() {
            job.ladder = ladder();
        }
        Ok(job)
    }
}

/// The settings that are held against the peer: rungs of the ladder that targets and time budgets climb.
fn ladder() -> Vec<(String, Params)> {
    let rung = |n| (format!("{} rays", Params::rays_of(n)), Params::default().rung(n));
    (2..=5).map(rung).collect()
}

/// Settings as `rays=65536 gather_rays=0`: names and values of [`Params`].
fn tried(words: &str) -> Outcome<Params> {
    let mut json = serde_json::to_value(Params::default())?;
    for word in words.split_whitespace() {
        let (name, value) = word.split_once('=').ok_or_else(|| format!("{word} is no NAME=VALUE"))?;
        if json.get(name).is_none() {
            return Err(format!("there is no parameter {name}").into());
        }
        json[name] = serde_json::from_str(value).unwrap_or(value.into());
    }
    Ok(serde_json::from_value(json)?)
}
