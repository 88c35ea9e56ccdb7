//! Paper mode: the network learns the kernel itself, as the seed paper does (Bohn 1997).
//!
//! 1. Area-uniform pairs of surface points, kept where the resource is high, and the kernel between them.
//! 2. Supervised growing cell structures learn it.
//! 3. The network's answers become coefficients, of the flux mode's kind of system.
//! 4. The flux mode's solver. Nothing else of it: no cosine rays carry light, no footprint is measured.

use super::{Clock, patchwork};
use crate::checkpoint::{Checkpoint, Learned};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::Point;
use crate::network::nodes;
use crate::network::pairs::{PairMetric, Pairs};
use crate::network::supervised::{Goal, Samples, Settings, Supervised};
use crate::params::{Direct, Form, Params};
use crate::progress::{Event, Progress};
use crate::radiosity::learned::ends::{Ends, visible};
use crate::radiosity::learned::{links, nystrom};
use crate::radiosity::solver;
use crate::scene::{Geometry, Scene};
use crate::stream::{Stream, stream};

/// Fresh pairs on which the network is held against the kernel.
const JUDGED: usize = 16_384;
/// Where they lie in the sequence of pairs: beyond all that training may draw.
const JUDGED_FROM: u64 = 1 << 31;

/// How the parameters train a network.
pub fn settings(params: &Params) -> Settings {
    let p = &params.paper;
    Settings {
        k: p.k as usize,
        dims: 12,
        cells: params.cells() as usize,
        evaluations: p.evaluations(params.cells()) as u64,
        eps_b: p.eps_b,
        eps_n: p.eps_n,
        eta: p.eta,
        decay: p.decay,
        fit: p.fit,
        output: p.output,
        deletion: p.deletion,
        resampling: p.resampling,
        seed: stream(params.seed, Stream::Ends),
        ..Settings::default()
    }
}

/// How the parameters measure pairs.
pub fn metric(geometry: &Geometry, params: &Params) -> PairMetric {
    PairMetric::new(geometry, if params.paper.normals { params.lambda } else { 0.0 }, params.paper.clamp)
}

/// Trains a network on the kernel of a scene. Also tells G V at all samples, per local area, before the clamp.
pub fn learn<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    progress: &mut Progress,
) -> Result<(Supervised, Samples<[Point; 2]>, Learned)> {
    let (settings, metric) = (settings(params), metric(geometry, params));
    let mut goal = Pairs::new(engine, geometry, metric, stream(params.seed, Stream::Rays));
    let first: Vec<_> = goal.draw(JUDGED_FROM, 64).iter().map(|p| goal.input(p)).collect();
    let (mut net, mut samples) = (Supervised::start(&settings, &first), Samples::default());
    let mut done = false;
    while !done {
        done = net.epoch(&mut goal, &settings, &mut samples)?;
        progress.event(Event::Cells { count: net.cells.len() as u64 })?;
        progress.event(Event::Rays { done: samples.places.len() as u64, total: settings.evaluations })?;
    }
    net.fit(goal.machine(), &settings, &mut samples)?;

    // What the clamp has taken, and how far the network is from the kernel.
    let (mut all, mut kept) = (0.0, 0.0);
    for (&g, s) in goal.raw.iter().zip(&samples.values) {
        all += g as f64 * s.weight as f64;
        kept += g.min(metric.clamp) as f64 * s.weight as f64;
    }
    let error = net.error(&mut goal, &settings, JUDGED_FROM, JUDGED)?;
    let learned = Learned {
        cells: net.cells.clone(),
        drawn: samples.drawn,
        evaluations: samples.places.len() as u64,
        epochs: net.epochs,
        deleted: net.deleted,
        kernel_error: error,
        clamped: if all > 0.0 { 1.0 - kept / all } else { 0.0 },
        idle: samples.values.iter().filter(|s| s.goal == 0.0).count() as f64 / samples.values.len().max(1) as f64,
    };
    Ok((net, samples, learned))
}

/// The order of the passes, on any engine. Fills the checkpoint when all is done.
pub fn run<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<()> {
    let exact = params.direct == Direct::Exact;
    progress.event(Event::Stage { name: "train" })?;
    let count = params.node_count(geometry.pieces, geometry.flatland);
    let density = vec![1.0; geometry.tiles as usize];
    let (lambda, seed) = (params.lambda as f32, stream(params.seed, Stream::Nodes));
    let surface = clock
        .time(engine, "nodes", |engine| nodes::place_nodes(engine, geometry, &density, count, lambda, seed, true, progress))?;
    let (net, samples, learned) = clock.time(engine, "train", |engine| learn(engine, geometry, params, progress))?;

    // Read the network as coefficients.
    progress.event(Event::Stage { name: "coefficients" })?;
    let mut built = clock.time(engine, "coefficients", |engine| {
        let (settings, metric) = (settings(params), metric(geometry, params));
        let nodes = &surface.nodes;
        let visible = match params.paper.calibrate {
            true => Some(visible(engine, geometry, nodes, stream(params.seed, Stream::PilotRays))?),
            false => None,
        };
        let (place, light) = (stream(params.seed, Stream::TilePlace), stream(params.seed, Stream::TileDirect));
        let (points, weights) = nystrom::quadrature(geometry, nodes.len(), place);
        let ends = Ends::new(engine, geometry, points, exact, light)?;
        let ends = (&ends, &weights[..]);
        match params.paper.form {
            Form::Nystrom => {
                let mask = params.paper.facing;
                nystrom::build(engine, geometry, &net, &settings, metric, nodes, ends, mask, visible.as_deref())
            }
            Form::Links => {
                links::build(engine, geometry, &net, &settings, metric, nodes, &samples, ends, visible.as_deref(), place)
            }
        }
    })?;

    built.evaluations = learned.evaluations;

    // Solve.
    progress.event(Event::Stage { name: "solve" })?;
    let bounces = params.bounces.map(|n| n - exact as u32);
    let (light, solved) =
        clock.time(engine, "solve", |engine| solver::solve(engine, geometry, &built.system, params, bounces, progress, scene))?;

    let network = &mut saved.network;
    network.nodes = Some(surface.nodes.clone());
    network.surface = Some(surface);
    (network.coefficients, network.solved, network.light) = (Some(built), Some(solved), light);
    saved.learned = Some(learned);
    patchwork::account(engine, geometry, params, saved, clock, progress)
}
