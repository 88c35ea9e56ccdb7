//! What the methods without light rays share: the account of energy, by rays of its own.

use super::{Clock, flux::BATCH};
use crate::checkpoint::Checkpoint;
use crate::engine::Engine;
use crate::error::Result;
use crate::network::{nodes, tiles};
use crate::params::{Direct, Params};
use crate::progress::Progress;
use crate::radiosity::energy;
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
    let net = &saved.network;
    let surface = nodes::surface_of(geometry, net.nodes.clone().unwrap_or_default(), params.lambda as f32, true);
    let energy = clock.time(engine, "energy", |engine| {
        engine.set_surface(&surface)?;
        let starts = tiles::starts(geometry, &vec![0.0; geometry.tiles as usize], 0.0);
        let mut batch = engine.emit(&starts, stream(params.seed, Stream::Rays), 0, BATCH, BATCH)?;
        engine.assign(&mut batch)?;
        if exact {
            let samples = Samples { emitter: params.end_samples, cosine: 1 };
            engine.direct(&mut batch, None, stream(params.seed, Stream::Ends), 0, 1, samples)?;
        }
        let seed = stream(params.seed, Stream::Emission);
        energy::account(engine, geometry, seed, exact, &net.light, &mut [batch], progress)
    })?;
    saved.energy = Some(energy);
    clock.compile = Some(engine.compile_seconds());
    clock.device_bytes = Some(engine.device_bytes());
    saved.keep(progress)
}
