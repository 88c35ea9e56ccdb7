//! Hierarchical radiosity: links between patches as coarse as the light they carry allows, and the same light and
//! read-out as every other method.
//!
//! 1. The network's pilot says what each part of the scene sends.
//! 2. Divide pairs of patches until no link carries much.
//! 3. Look around on the leaves, sample direct light; scale what each gets.
//! 4. Solve, fit a gradient to each leaf, account for every watt.

use super::{Clock, flux, patchwork};
use crate::checkpoint::Checkpoint;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::NodeLight;
use crate::params::{Direct, Params};
use crate::progress::{Event, Progress};
use crate::radiosity::patches::exchange::own_light;
use crate::radiosity::patches::links::{Links, roots};
use crate::radiosity::patches::sampled::Sampled;
use crate::radiosity::solver::{self, Rule};
use crate::scene::{Geometry, Scene};
use crate::stream::{Stream, stream};

/// The order of the steps, on any engine. Fills the checkpoint.
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
    let stage = flux::full(engine, scene, geometry, params, saved, clock, progress)?;

    progress.event(Event::Stage { name: "coefficients" })?;
    let seed = stream(params.seed, Stream::Patches);
    let mesh = roots(geometry);
    let mut links = clock.time(engine, "coefficients", |engine| {
        Links::new(engine, geometry, &mesh, &stage.brightness, params.patches, seed, progress)
    })?;
    let leaves = links.leaf_patches();
    let sampled = clock.time(engine, "direct", |engine| Sampled::new(engine, geometry, &mesh, &leaves, exact, seed, progress))?;
    links.calibrate(&sampled.visible, !exact);

    progress.event(Event::Stage { name: "solve" })?;
    let rule = Rule::new(params, params.bounces.map(|n| n - exact as u32));
    let nodes = sampled.nodes(geometry, &leaves);
    let (light, solved) = clock.time(engine, "solve", |_| {
        let own = own_light(geometry, &mesh, &leaves, &sampled, exact);
        let mut sweep = |light: &[NodeLight], n| Ok(links.jacobi(&own, &sampled.live, light, n));
        let dark = vec![NodeLight::default(); nodes.len()];
        solver::iterate(&mut sweep, geometry, dark, &[], rule, progress, scene)
    })?;

    let cost = (links.stored(), links.evaluations);
    patchwork::keep(engine, geometry, params, &sampled, &leaves, (nodes, light, solved), cost, saved, clock, progress)
}
