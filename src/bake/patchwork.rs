//! What the methods without light rays share: how patches are kept, and the account of energy, by rays of its own.

use super::{Clock, flux, flux::BATCH};
use crate::checkpoint::{Checkpoint, unread};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Node, NodeLight};
use crate::network::{nodes, tiles};
use crate::params::{Direct, Params};
use crate::progress::Progress;
use crate::radiosity::coefficients::Coefficients;
use crate::radiosity::patches::{Patch, sampled::Sampled};
use crate::radiosity::solver::Solved;
use crate::scene::Geometry;
use crate::stream::{Stream, stream};
use crate::twin::direct::Samples;

/// Where did every watt go? A flux network asks the rays that it has; patches and the
/// paper's network have none, so these are shot for it alone.
pub fn account<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<()> {
    let exact = params.direct == Direct::Exact;
    let net = &mut saved.network;
    let find = || nodes::surface_of(geometry, net.nodes.clone().unwrap_or_default(), params.lambda as f32, true);
    let surface = net.surface.take().unwrap_or_else(find);
    let batch = clock.time(engine, "energy", |engine| {
        engine.set_surface(&surface)?;
        let starts = tiles::starts(geometry, &vec![0.0; geometry.tiles as usize], 0.0);
        let mut batch = engine.emit(&starts, stream(params.seed, Stream::Rays), 0, BATCH, BATCH)?;
        engine.assign(&mut batch)?;
        if exact {
            let samples = Samples { emitter: params.end_samples, cosine: 1 };
            engine.direct(&mut batch, None, stream(params.seed, Stream::Ends), 0, 1, samples)?;
        }
        Ok(batch)
    })?;
    net.surface = Some(surface);
    flux::account(engine, geometry, params, &mut [batch], saved, clock, progress)
}

/// Keeps what was solved on patches, each a node with a gradient, and accounts for every watt. `stored` coefficients
/// took `evaluations` of the kernel.
pub fn keep<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    sampled: &Sampled,
    patches: &[Patch],
    (nodes, light, solved): (Vec<Node>, Vec<NodeLight>, Solved),
    (stored, evaluations): (u64, u64),
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<()> {
    let net = &mut saved.network;
    net.light = sampled.slopes(geometry, &nodes, &light);
    let mass = patches.iter().map(|p| p.area).collect();
    net.coefficients =
        Some(Coefficients { system: unread(&nodes), mass, stored, evaluations, looks: sampled.rays, dropped: 0.0 });
    (net.nodes, net.solved) = (Some(nodes), Some(solved));
    account(engine, geometry, params, saved, clock, progress)
}
