//! Other light on a network that is solved: like [`mod@crate::bake`] and the read-out, this room knows an order of passes.
//!
//! Where all that shines is what shone in the bake, times a factor a band, so is all light: nothing is computed. Else:
//!
//! 1. Sample direct light all over the surface, of the bake's lamps and of the new ones; fit both to the nodes.
//! 2. Solve the network's coefficients with the new light. What the bake's rays have made of its own light corrects the
//!    cells; only the rest of the new light, which the network was not tuned for, is carried by cells alone.
//! 3. Estimate the error: by tests, as of a bake, and by that rest. Where it is more than the bake states, bake the changed scene.
//!
//! Points are then shown as those of a bake are, with exact direct light of the changed scene.

mod change;
mod known;
mod network;
mod sources;

pub use change::{Change, Retrace};

use crate::accuracy::estimate::{self, Evidence, Size};
use crate::bake::bake;
use crate::effects;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::network::nodes::surface_of;
use crate::output::report::{Energy, EstimatedError, RegionError, RelitReport, Report, Seconds};
use crate::params::{Direct, Method, Mode, Params};
use crate::pass::GpuEngine;
use crate::progress::{Event, Flow, Progress};
use crate::radiosity::energy;
use crate::radiosity::solver::Solved;
use crate::scene::{Geometry, Scene};
use crate::solution::{Baked, Solution};
use crate::twin::TwinEngine;
use crate::twin::assign::Surface;
use crate::twin::jacobi::System;
use change::Changed;
use glam::Vec3;
use network::{Job, Relit};
use std::time::Instant;

/// A relight is tested as a bake of so many times fewer rays.
const TESTS: u32 = 32;
/// Its test points, or more.
const POINTS: u32 = 96;
/// An error beyond the bake's by which it is re-traced, in what the bake states at most: the whole is then wrong by 1.8 times as much.
const BEYOND: f64 = 1.5;
/// Share of the bake's rays below which it is told how few serve the new light.
const FEW: f64 = 0.5;
/// Share by which a light may miss a multiple of another by rounding alone.
const ROUNDING: f64 = 1e-12;

/// See [`Solution::relight`].
pub(crate) fn relight(
    from: &Solution,
    backend: &Backend,
    change: &Change,
    tell: &mut dyn FnMut(&Event) -> Flow,
) -> Result<Solution> {
    let (start, compiled) = (Instant::now(), backend.compile_seconds());
    let seconds = || Some((start.elapsed().as_secs_f64() - (backend.compile_seconds() - compiled)).max(0.0));
    let params = from.params();
    let Changed { scene, of } = change.apply(from.scene())?;
    let mut baked = Baked::of(from);
    baked.of = of.iter().map(|&m| baked.of[m as usize]).collect();
    let stated = baked.error.clone().unwrap_or_default();
    let mut told =
        RelitReport { changes: change.words(), baked_error: baked.error.as_ref().map(|e| e.rrmse), ..RelitReport::default() };
    let retrace = |why: String, tell: &mut dyn FnMut(&Event) -> Flow| {
        let mut solution = bake(backend, &scene, params, tell)?;
        let (changes, baked_error) = (change.words(), baked.error.as_ref().map(|e| e.rrmse));
        let told =
            RelitReport { changes, how: "re-traced".into(), why, baked_error, seconds: seconds(), ..RelitReport::default() };
        solution.report_mut().relit = Some(told);
        Ok(solution)
    };

    let factors = factors(&scene, &baked);
    let cannot = cannot(from, &scene, &baked, factors.is_some());
    if change.retrace == Retrace::Always {
        return retrace("it was asked for".into(), tell);
    }
    if let Some(why) = cannot {
        if change.retrace == Retrace::Never {
            return Err(Error::InvalidParam { name: "retrace", value: "never".into(), range: why });
        }
        Progress::new(tell).event(Event::Warning(format!("{why}: rays are traced anew")))?;
        return retrace(why.into(), tell);
    }

    // The changed scene, and the baked one, on the nodes that there are.
    let mut progress = Progress::new(tell);
    progress.event(Event::Stage { name: "bvh" })?;
    let geometry = Geometry::for_bake(&scene, params)?;
    let own = if from.baked().is_some() || scene.faces != from.scene().faces {
        Some(Geometry::for_bake(&baked.scene(&scene), params)?)
    } else {
        None
    };
    let before = own.as_ref().unwrap_or(from.geometry());
    let (system, surface) = moved(from, &geometry, &scene);
    let bvh = start.elapsed().as_secs_f64();

    let relit = match factors {
        Some(factors) => {
            let unit = geometry.emission_scale / before.emission_scale;
            told.how = "scaled".into();
            told.why = "all that shines is what shone in the bake, times a factor a band, and so is all light".into();
            Relit::scaled(&baked, factors.map(|f| f * unit), &from.report().solver, f64::from(params.rays))
        }
        None => {
            let job = Job { params, scene: &scene, before, after: &geometry, surface: &surface, system: &system, baked: &baked };
            let relit = match backend {
                Backend::Cpu => job.solve(&mut TwinEngine::new(before), &mut TwinEngine::new(&geometry), &mut progress)?,
                Backend::Gpu(gpu) => {
                    job.solve(&mut GpuEngine::new(gpu, before)?, &mut GpuEngine::new(gpu, &geometry)?, &mut progress)?
                }
            };
            told.how = "solved".into();
            told.why =
                format!("{:.1} % of the new light is carried as the bake's own rays did, the rest by cells", 100.0 * relit.known);
            relit
        }
    };
    (told.extra_error, told.known, told.effective_rays) = (Some(relit.extra), Some(relit.known), Some(relit.effective));

    let mut warnings = from.report().warnings.clone();
    if relit.effective < FEW * f64::from(params.rays) {
        warnings.push(format!(
            "rays were drawn for other light: {} of them scatter as {:.0} drawn for this one would",
            params.rays, relit.effective
        ));
        progress.event(Event::Warning(warnings[warnings.len() - 1].clone()))?;
    }

    // The solution, and how good it is.
    let report = Report {
        raycell: env!("CARGO_PKG_VERSION").into(),
        solver: relit.solver.clone(),
        energy: energy_of(from, &geometry, factors),
        seconds: Seconds { bvh: Some(bvh), ..Seconds::default() },
        effects: Some(effects::of(&scene, &geometry).0),
        warnings,
        adapter: None,
        target: None,
        memory_bytes: Default::default(),
        extra: Default::default(),
        ..from.report().clone()
    };
    let cells = from.cells().to_vec();
    let mut solution = Solution::new(scene.clone(), geometry, params.clone(), surface, relit.light, cells, system, report);
    let even = factors.filter(|f| f.iter().all(|x| *x == f[0]));
    let error = match (even, &baked.error) {
        (Some([factor, ..]), Some(stated)) => scaled_error(stated, factor),
        _ => {
            let mut error = test(backend, &solution, &relit.bright, relit.solved, &mut progress)?;
            error.high = error.high.max(stated.high.hypot(relit.extra));
            error
        }
    };
    if factors.is_none() && change.retrace == Retrace::Auto && baked.error.is_some() {
        // Beyond what the bake states, by the tests or by what is known of the light.
        let grown = relit.extra.max((error.low.powi(2) - stated.high.powi(2)).max(0.0).sqrt());
        if grown > BEYOND * stated.high {
            let why = format!(
                "the network was tuned for other light: solved on it, the new light would have an error {:.1} % beyond the bake's, \
                 which states {:.1} % at most",
                100.0 * grown,
                100.0 * stated.high
            );
            progress.event(Event::Warning(format!("{why}; rays are traced anew")))?;
            return retrace(why, tell);
        }
    }
    progress.event(Event::Error { rrmse: error.rrmse, low: error.low, high: error.high })?;
    told.seconds = seconds();
    let report = solution.report_mut();
    (report.seconds.total, report.estimated_error, report.relit) = (told.seconds, Some(error), Some(told));
    Ok(solution.relit(baked))
}

/// What all light of the bake is multiplied by, a band each, where that is all that has changed.
fn factors(scene: &Scene, baked: &Baked) -> Option<[f64; 3]> {
    if scene.environment.is_some() || !scene.lights.is_empty() {
        // Their light stays what it is.
        return None;
    }
    let mut factors = [None; 3];
    let mut used = vec![false; scene.materials.len()];
    scene.faces.iter().for_each(|f| used[f.material as usize] = true);
    for (m, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        let (now, then) = (&scene.materials[m], &baked.materials[baked.of[m] as usize]);
        if now.reflectance != then.reflectance {
            return None;
        }
        for k in 0..3 {
            let (now, then) = (now.emission[k], then.emission[k]);
            if then > 0.0 {
                let factor = *factors[k].get_or_insert(now / then);
                if (now - factor * then).abs() > ROUNDING * now.max(factor * then) {
                    return None;
                }
            } else if now > 0.0 {
                return None;
            }
        }
    }
    // A band in which nothing shines is as another one.
    let other = factors.iter().flatten().next().copied().unwrap_or(1.0);
    Some(factors.map(|f| f.unwrap_or(other)))
}

/// Why the network cannot carry the new light at all; none where it can.
fn cannot(from: &Solution, scene: &Scene, baked: &Baked, linear: bool) -> Option<&'static str> {
    let params: &Params = from.params();
    if from.is_partial() {
        return Some("the bake was stopped before its end");
    }
    if linear {
        return None;
    }
    if params.method != Method::Network || params.mode != Mode::Flux {
        return Some("a bake by another method leaves no coefficients to solve other light with");
    }
    if params.direct == Direct::Network {
        return Some("without exact direct light there are no coefficients for what lamps send");
    }
    if params.bounces.is_some() {
        return Some("what the rays have made of a stated number of reflections says nothing of other light");
    }
    if from.nodes().is_empty() || from.system().source.is_empty() {
        return Some("nothing reflected light in the bake, and there is no network");
    }
    let has_maps = |m: u32| scene.materials[m as usize].maps().iter().any(Option::is_some);
    if scene.faces.iter().any(|f| has_maps(f.material)) {
        return Some(
            "textures: nodes of a scene with maps know one reflectance and emission each, and cells not what varies on them",
        );
    }
    let black = |m: u32| {
        let then = baked.materials[baked.of[m as usize] as usize].reflectance;
        then == [0.0; 3] && scene.materials[m as usize].reflectance != [0.0; 3]
    };
    scene.faces.iter().any(|f| black(f.material)).then_some("a surface that was black reflects now, and there are no nodes on it")
}

/// The network on the changed scene: where an object has a material of its own now, its nodes have it, too.
fn moved(from: &Solution, geometry: &Geometry, scene: &Scene) -> (System, Surface) {
    let mut system = from.system().clone();
    let then = from.geometry();
    let same = scene.faces == from.scene().faces;
    if same && geometry.unit == then.unit && geometry.tile_tri == then.tile_tri {
        return (system, from.surface().clone());
    }
    let mut nodes = from.nodes().to_vec();
    for (node, plane) in nodes.iter_mut().zip(&mut system.planes).filter(|_| !same) {
        if let Some(at) = geometry.locate(geometry.to_world(node.p), node.n.map(f64::from)) {
            let tri = &geometry.tris[at.tri as usize];
            debug_assert!((Vec3::from(at.p) - Vec3::from(node.p)).length() < 1e-3);
            (node.material, node.plane, plane.material) = (tri.material, tri.plane, tri.material);
        }
    }
    // Marks save rays where many points are assigned; here they are few.
    let surface = surface_of(geometry, nodes, from.params().lambda as f32, false);
    (system, surface)
}

/// The error of a solution, by fewer tests than a bake has.
fn test(
    backend: &Backend,
    solution: &Solution,
    bright: &[f64],
    solved: Solved,
    progress: &mut Progress,
) -> Result<EstimatedError> {
    let geometry = solution.geometry();
    let size = Size::new(solution.params().rays / TESTS, POINTS);
    let evidence = Evidence::default();
    match backend {
        Backend::Cpu => estimate::estimate(&mut TwinEngine::new(geometry), solution, size, bright, solved, evidence, progress),
        Backend::Gpu(gpu) => {
            estimate::estimate(&mut GpuEngine::new(gpu, geometry)?, solution, size, bright, solved, evidence, progress)
        }
    }
}

/// The error that a bake states, of its light times a factor.
fn scaled_error(stated: &EstimatedError, factor: f64) -> EstimatedError {
    let regions = stated.regions.iter().map(|r| RegionError { mean: factor * r.mean, ..*r }).collect();
    EstimatedError { regions, ..stated.clone() }
}

/// Where the watts go, as far as that is known: all of it where the bake's light was scaled, else what is emitted.
fn energy_of(from: &Solution, geometry: &Geometry, factors: Option<[f64; 3]>) -> Energy {
    if geometry.is_surfaceless() {
        // What arrives from the sky and from lights without a surface was not looked for.
        return Energy::default();
    }
    let emitted = Some(energy::watts(geometry, energy::emitted(geometry)));
    let then = &from.report().energy;
    match (factors, from.baked(), then.emitted, then.absorbed, then.escaped) {
        (Some(factors), None, Some(_), Some(absorbed), Some(escaped)) => {
            let times = |x: [f64; 3]| [0, 1, 2].map(|k| factors[k] * x[k]);
            let (absorbed, escaped) = (times(absorbed), times(escaped));
            let sum = |x: [f64; 3]| x.iter().sum::<f64>();
            let all = emitted.map_or(0.0, sum);
            let imbalance = if all > 0.0 { (all - sum(absorbed) - sum(escaped)) / all } else { 0.0 };
            let (absorbed, escaped) = (Some(absorbed), Some(escaped));
            Energy { emitted, absorbed, escaped, imbalance: Some(imbalance), ..Energy::default() }
        }
        _ => Energy { emitted, ..Energy::default() },
    }
}
