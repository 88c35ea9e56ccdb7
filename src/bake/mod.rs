//! The bake: the one room that knows the order of the passes, a file a method.

mod fem;
pub(crate) mod flux;
mod hierarchical;
pub(crate) mod paper;
mod patchwork;
mod rays;

use crate::accuracy::estimate::{self, Size};
use crate::checkpoint::{Checkpoint, Key};
use crate::doctor;
use crate::effects::{self, Spent, spend};
use crate::engine::{Backend, Engine};
use crate::error::Result;
use crate::output::report::EffectReport;
use crate::params::{Method, Mode, Norm, Params};
use crate::pass::GpuEngine;
use crate::progress::{Event, Flow, Progress};
use crate::scene::{Geometry, Scene};
use crate::solution::Solution;
use crate::twin::TwinEngine;
use crate::twin::direct::DirectRays;
use std::collections::BTreeMap;
use std::time::Instant;

/// What the paper's norm does.
const PAPER_NORM: &str = "the norm paper1997 loses energy: rows of the kernel sum to 1/pi, so 68 % of all light is lost on its \
                          way (a closed room of reflectance 0.5 gets 1.19 times its own light instead of 2 times); \
                          bake with --norm lambert";

/// What mirrors do not do.
const OVER_MIRRORS: &str = "light of suns, points and spots is not followed over mirrors: what mirrors cast of it is missing; make lamps of \
                            surfaces, or a sun a bright disc in a map of the sky, where that matters";

/// Wall time a stage, added up, and what else the engine tells of itself.
#[derive(Default)]
pub(crate) struct Clock {
    pub seconds: BTreeMap<&'static str, f64>,
    /// The same less what kernels' compiling took of it.
    warm: BTreeMap<&'static str, f64>,
    pub compile: Option<f64>,
    pub device_bytes: Option<u64>,
    pub direct_rays: Option<DirectRays>,
    pub band_bytes: Option<u64>,
}

impl Clock {
    /// Runs `work` as part of stage `name`.
    pub fn time<E: Engine, T>(
        &mut self,
        engine: &mut E,
        name: &'static str,
        work: impl FnOnce(&mut E) -> Result<T>,
    ) -> Result<T> {
        let (start, compiled) = (Instant::now(), engine.compile_seconds());
        let out = work(engine)?;
        engine.finish()?;
        let seconds = start.elapsed().as_secs_f64();
        *self.seconds.entry(name).or_default() += seconds;
        *self.warm.entry(name).or_default() += (seconds - (engine.compile_seconds() - compiled)).max(0.0);
        Ok(out)
    }

    pub fn get(&self, name: &str) -> Option<f64> {
        self.seconds.get(name).copied()
    }
}

/// Bakes a scene: trains the network, solves for the light.
///
/// Blocks until done; `progress` hears what happens and may stop it. Errors: those of
/// [`Scene::check`] and [`Params::check`], of the device, [`crate::Error::NotContractive`],
/// [`crate::Error::Cancelled`].
pub fn bake(backend: &Backend, scene: &Scene, params: &Params, progress: &mut dyn FnMut(&Event) -> Flow) -> Result<Solution> {
    bake_from(backend, scene, params, &mut Checkpoint::default(), progress)
}

/// As [`bake`], going on from a checkpoint and filling it: what is in it is not computed again, and the solution
/// is, byte for byte, that of a bake that was never stopped.
///
/// After an error the checkpoint holds what was found until then; [`Checkpoint::solution`] makes a partial solution
/// of it. Errors: those of [`bake`]; [`crate::Error::OtherBake`] where the checkpoint is of another scene, other
/// parameters, another device or another version.
pub fn bake_from(
    backend: &Backend,
    scene: &Scene,
    params: &Params,
    saved: &mut Checkpoint,
    progress: &mut dyn FnMut(&Event) -> Flow,
) -> Result<Solution> {
    let prepared = Prepared::new(scene, params, progress)?;
    bake_prepared(backend, &prepared, params, saved, progress)
}

/// A scene made ready: what bakes of all sizes share.
pub(crate) struct Prepared<'a> {
    scene: &'a Scene,
    geometry: Geometry,
    warnings: Vec<String>,
    effects: Vec<EffectReport>,
    /// Share of rays that meet a mirror.
    mirrored: f64,
    /// Seconds that it took.
    seconds: f64,
}

impl<'a> Prepared<'a> {
    /// Makes a scene ready, and tells what is odd about it.
    pub fn new(scene: &'a Scene, params: &Params, progress: &mut dyn FnMut(&Event) -> Flow) -> Result<Prepared<'a>> {
        params.check()?;
        let mut progress = Progress::new(progress);
        progress.event(Event::Stage { name: "bvh" })?;
        let start = Instant::now();
        let geometry = Geometry::for_bake(scene, params)?;
        let seconds = start.elapsed().as_secs_f64();
        let mut warnings = doctor::warnings(scene, &geometry);
        if params.norm == Norm::Paper1997 {
            warnings.push(PAPER_NORM.into());
        }
        if !geometry.lights.is_empty() && geometry.mirrors {
            warnings.push(OVER_MIRRORS.into());
        }
        for warning in &warnings {
            progress.event(Event::Warning(warning.clone()))?;
        }
        let (effects, mirrored) = effects::of(scene, &geometry);
        Ok(Prepared { scene, geometry, warnings, effects, mirrored, seconds })
    }
}

/// As [`bake_from`], of a scene that is ready.
pub(crate) fn bake_prepared(
    backend: &Backend,
    prepared: &Prepared,
    params: &Params,
    saved: &mut Checkpoint,
    progress: &mut dyn FnMut(&Event) -> Flow,
) -> Result<Solution> {
    params.check()?;
    let Prepared { scene, geometry, warnings, effects, mirrored, seconds: bvh } = prepared;
    let mut progress = Progress::new(progress);
    let start = Instant::now();
    let resumed = !saved.is_empty();
    saved.claim(Key::new(backend, scene, geometry, params), geometry)?;
    let (mut clock, warnings) = (Clock::default(), warnings.clone());
    let mut solution = match backend {
        Backend::Cpu => {
            let engine = &mut TwinEngine::new(geometry);
            whole(engine, scene, geometry, params, warnings, saved, &mut clock, &mut progress)?
        }
        Backend::Gpu(gpu) => {
            let engine = &mut GpuEngine::new(gpu, geometry)?;
            whole(engine, scene, geometry, params, warnings, saved, &mut clock, &mut progress)?
        }
    };

    // Training is everything up to the winners; its parts are told beside it.
    let train: f64 = ["train", "emit", "nodes", "assign", "grow", "winner"].iter().filter_map(|s| clock.get(s)).sum();
    let report = solution.report_mut();
    let mut effects = effects.clone();
    spend(&mut effects, Spent::of_stages(&clock.warm, &clock.direct_rays.unwrap_or_default(), *mirrored).parts());
    report.effects = Some(effects);
    report.memory_bytes.device = clock.device_bytes;
    let seconds = &mut report.seconds;
    seconds.bvh = Some(*bvh);
    seconds.compile = clock.compile;
    seconds.train = (train > 0.0).then_some(train);
    seconds.coefficients = clock.get("coefficients");
    seconds.solve = clock.get("solve");
    seconds.direct = clock.get("direct");
    seconds.total = Some(bvh + start.elapsed().as_secs_f64());
    let net = &saved.network;
    let training = net.growth.as_ref().map(|g| g.training).unwrap_or_default();
    for (key, value) in [
        ("rays_per_second", serde_json::json!((!resumed).then(|| params.rays as f64 / train.max(1e-9)))),
        ("epochs", serde_json::json!(training.epochs)),
        ("cells_deleted", serde_json::json!(training.deleted)),
        ("contraction", serde_json::json!(net.solved.map(|s| s.contraction))),
        ("dropped_coefficient_mass", serde_json::json!(net.coefficients.as_ref().map(|c| c.dropped))),
        ("planar_pieces", serde_json::json!(geometry.pieces)),
        ("emission_scale", serde_json::json!(geometry.emission_scale)),
        ("shadow_rays", serde_json::json!(clock.direct_rays.map(|rays| rays.shadow()))),
        ("solve_band_bytes", serde_json::json!(clock.band_bytes)),
        ("stages", serde_json::json!(clock.seconds)),
        ("learned", serde_json::json!(saved.learned)),
        // Times are then those since the bake went on.
        ("resumed", serde_json::json!(resumed)),
    ] {
        report.extra.insert(key.into(), value);
    }
    Ok(solution)
}

/// Bakes as far as that is not done, and asks how good the result is.
fn whole<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    warnings: Vec<String>,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<Solution> {
    run(engine, scene, geometry, params, saved, clock, progress)?;
    let mut solution = saved.assemble(scene, geometry, params, warnings);
    let bright = saved.pilot.as_ref().map_or(&[][..], |p| &p.carried);
    let (solved, evidence) = (saved.network.solved.unwrap_or_default(), saved.network.evidence);
    let estimate = clock.time(engine, "estimate", |engine| {
        estimate::estimate(engine, &solution, Size::of_bake(params.rays), bright, solved, evidence, progress)
    })?;
    progress.event(Event::Error { rrmse: estimate.rrmse, low: estimate.low, high: estimate.high })?;
    solution.report_mut().estimated_error = Some(estimate);
    Ok(solution)
}

/// The order of passes of the method asked for.
fn run<E: Engine>(
    engine: &mut E,
    scene: &Scene,
    geometry: &Geometry,
    params: &Params,
    saved: &mut Checkpoint,
    clock: &mut Clock,
    progress: &mut Progress,
) -> Result<()> {
    if saved.is_whole() {
        return Ok(());
    }
    match params.method {
        Method::Network if params.mode == Mode::Paper => paper::run(engine, scene, geometry, params, saved, clock, progress),
        Method::Network => flux::run(engine, scene, geometry, params, saved, clock, progress),
        Method::Fem => fem::run(engine, scene, geometry, params, saved, clock, progress),
        Method::Rays => rays::run(engine, scene, geometry, params, saved, clock, progress),
        Method::Hierarchical => hierarchical::run(engine, scene, geometry, params, saved, clock, progress),
    }
}
