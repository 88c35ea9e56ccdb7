//! Finite elements: uniform patches, a form factor for each pair of them, and the same light and read-out as every
//! other method.
//!
//! 1. Cut the scene into patches, look around on each, sample direct light.
//! 2. Evaluate the kernel between all pairs; scale the rows.
//! 3. Solve, fit a gradient to each patch, account for every watt.

use super::{Clock, patchwork};
use crate::checkpoint::Checkpoint;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::NodeLight;
use crate::params::{Direct, Params, Solver};
use crate::progress::{Event, Progress};
use crate::radiosity::components::Components;
use crate::radiosity::patches::Mesh;
use crate::radiosity::patches::exchange::{Exchange, Transport};
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
    progress.event(Event::Stage { name: "coefficients" })?;
    let mesh = Mesh::new(geometry, params.patches);
    let sampled = clock.time(engine, "direct", |engine| {
        Sampled::new(engine, geometry, &mesh, &mesh.patches, exact, stream(params.seed, Stream::Patches), progress)
    })?;
    let exchange = clock.time(engine, "coefficients", |engine| Exchange::new(engine, geometry, &mesh, &sampled, progress))?;

    progress.event(Event::Stage { name: "solve" })?;
    let rule = Rule::new(params, params.bounces.map(|n| n - exact as u32));
    let nodes = sampled.nodes(geometry, &mesh.patches);
    let (light, solved) = clock.time(engine, "solve", |_| {
        let transport = Transport::new(geometry, &mesh, &sampled, &exchange, exact);
        let mut sweep = |light: &[NodeLight], n| {
            Ok(match params.solver {
                Solver::Jacobi => transport.jacobi(light, n),
                Solver::GaussSeidel => transport.gauss_seidel(light, n),
            })
        };
        let dark = vec![NodeLight::default(); nodes.len()];
        let rooms = Components::of_rows(&exchange.offsets, &exchange.other).numbers();
        solver::iterate(&mut sweep, geometry, dark, &rooms, rule, progress, scene)
    })?;

    let cost = (exchange.value.len() as u64, exchange.evaluations);
    patchwork::keep(engine, geometry, params, &sampled, &mesh.patches, (nodes, light, solved), cost, saved, clock, progress)
}
