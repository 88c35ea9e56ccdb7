//! Every light ray its own coefficient: the network's rays and nodes without its cells, swept until the light stands.

use super::{Clock, flux, flux::Traced};
use crate::checkpoint::{Checkpoint, unread};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{NONE, NodeLight, kind};
use crate::network::candidates;
use crate::params::{Direct, Params};
use crate::progress::{Event, Progress};
use crate::radiosity::coefficients;
use crate::radiosity::components::{Components, Peaks};
use crate::radiosity::solver::{self, Rule};
use crate::scene::{Geometry, Scene};

/// The order of the passes, on any engine. Fills the checkpoint.
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
    let Traced { mut surface, mut batches, lengths } = flux::trace(engine, geometry, params, &stage, saved, clock, progress)?;
    let normalise = flux::normalise(geometry, params);

    // The nodes' masses and planes, of which no cell has a part.
    progress.event(Event::Stage { name: "coefficients" })?;
    let mut rooms = Vec::new();
    let built = clock.time(engine, "coefficients", |engine| {
        let (mut directed, mut first) = (0, 0);
        let (mut all, mut peaks) = (Components::new(surface.nodes.len()), Peaks::new(surface.nodes.len()));
        for (batch, &points) in batches.iter_mut().zip(&lengths) {
            engine.set_winners(batch, &vec![NONE; points])?;
            let (ends, psi) = (engine.points(batch)?, engine.psi(batch)?);
            directed += ends.iter().filter(|p| p.kind == kind::FRONT).count() as u64;
            all.join(&ends, &psi);
            peaks.see(geometry, &ends, &psi, saved.network.direct.get(first..first + points).filter(|_| exact));
            first += points;
        }
        rooms = all.numbers();
        peaks.set_gains(geometry, &rooms, &mut surface.nodes);
        let rays = params.rays as f32;
        let sums = engine.coefficients(&batches, exact, normalise, rays, 0, &mut || progress.tick())?;
        let built = coefficients::build(&sums, &mut surface.nodes, params.ridge, params.slots as usize, params.rays as f64);
        candidates::leave_out_empty(geometry, &mut surface, &built.mass, candidates::worth_marking(geometry, params.rays));
        engine.set_surface(&surface)?;
        Ok(coefficients::Coefficients { stored: directed, ..built })
    })?;
    let net = &mut saved.network;
    net.nodes = Some(surface.nodes.clone());

    // A sweep reads the light at every ray's emitter end and carries it to the nodes around its receiver end.
    progress.event(Event::Stage { name: "solve" })?;
    let rule = Rule::new(params, params.bounces.map(|n| n - exact as u32));
    let (light, solved) = clock.time(engine, "solve", |engine| {
        let dark = vec![NodeLight::default(); surface.nodes.len()];
        let mut sweep = |light: &[NodeLight], sweeps| {
            let mut light = light.to_vec();
            for _ in 0..sweeps {
                engine.set_light(&light)?;
                for batch in &mut batches {
                    engine.readout(batch)?;
                }
                let sums = engine.deposit(&batches, exact, true, normalise)?;
                light = coefficients::fit(&coefficients::known(&sums, &surface.nodes, &built.mass), &built.system.planes);
            }
            Ok(light)
        };
        solver::iterate(&mut sweep, geometry, dark, &rooms, rule, progress, scene)
    })?;
    let net = &mut saved.network;
    net.coefficients = Some(coefficients::Coefficients { system: unread(&surface.nodes), ..built });
    (net.light, net.solved, net.surface) = (light, Some(solved), Some(surface));
    flux::account(engine, geometry, params, &mut batches, saved, clock, progress)
}
