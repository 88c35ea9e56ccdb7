//! The kernel between points of a scene, analytic and as the paper's network has learned it.

use crate::bake::paper;
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::layout::Point;
use crate::network::pairs::{PairMetric, end};
use crate::network::supervised::{Settings, Supervised};
use crate::params::Params;
use crate::progress::Progress;
use crate::scene::Geometry;
use crate::twin::trace::{barycentric, surface_point};
use glam::Vec3;

/// Pairs that go to the engine at once.
const CHUNK: usize = 1 << 18;

/// A network that has learned the kernel of a scene.
pub struct Learned {
    /// The network.
    pub net: Supervised,
    /// Where the kernel was evaluated.
    pub places: Vec<[Point; 2]>,
    /// Relative L2 error at fresh pairs, all over the scene.
    pub error: f64,
    /// Share of the energy that the clamp took.
    pub clamped: f64,
    settings: Settings,
    metric: PairMetric,
}

/// Trains the paper's network.
pub fn learn<E: Engine>(engine: &mut E, geometry: &Geometry, params: &Params, progress: &mut Progress) -> Result<Learned> {
    let (net, samples, learned) = paper::learn(engine, geometry, params, progress)?;
    let (settings, metric) = (paper::settings(params), paper::metric(geometry, params));
    let (error, clamped) = (learned.kernel_error, learned.clamped);
    Ok(Learned { net, places: samples.places, error, clamped, settings, metric })
}

/// The kernel of consecutive pairs of points, per m² (flatland: per m): from the geometry, by pass `kernel`.
pub fn analytic<E: Engine>(engine: &mut E, geometry: &Geometry, pairs: &[Point]) -> Result<Vec<f64>> {
    let unit = per_metre(geometry);
    let mut all = Vec::with_capacity(pairs.len() / 2);
    for chunk in pairs.chunks(2 * CHUNK) {
        all.extend(engine.kernel(chunk)?.into_iter().map(|g| g as f64 * unit));
    }
    Ok(all)
}

impl Learned {
    /// The kernel of consecutive pairs of points as the network answers, per m² (flatland: per m).
    pub fn answers<E: Engine>(&self, engine: &mut E, geometry: &Geometry, pairs: &[Point]) -> Result<Vec<f64>> {
        let unit = self.metric.clamp as f64 * per_metre(geometry);
        let mut all = Vec::with_capacity(pairs.len() / 2);
        for chunk in pairs.chunks(2 * CHUNK) {
            let ends = chunk.chunks_exact(2).map(|p| self.metric.input(end(geometry, &p[0]), end(geometry, &p[1])));
            let inputs: Vec<_> = ends.collect();
            all.extend(self.net.answer(engine, &self.settings, &inputs)?.into_iter().map(|a| a as f64 * unit));
        }
        Ok(all)
    }

    /// The two ends of every cell's reference ray, metres.
    pub fn rays(&self, geometry: &Geometry) -> Vec<[[f64; 3]; 2]> {
        let place =
            |f: &[f32]| [0, 1, 2].map(|k| f[k] as f64 / self.metric.inv_unit as f64 / geometry.scale + geometry.center[k]);
        self.net.cells.iter().map(|c| [place(&c[0..3]), place(&c[6..9])]).collect()
    }
}

/// What a kernel per local area is multiplied by.
fn per_metre(geometry: &Geometry) -> f64 {
    if geometry.flatland { geometry.scale } else { geometry.scale * geometry.scale }
}

/// The surface point at a place (metres), on the side of a normal. Errors: [`Error::InvalidParam`] off every surface.
pub fn point(geometry: &Geometry, p: [f64; 3], n: [f64; 3]) -> Result<Point> {
    let at = geometry.locate(p, n).ok_or_else(|| Error::InvalidParam {
        name: "point",
        value: format!("{p:?}"),
        range: "give a point of a surface",
    })?;
    let (b1, b2) = barycentric(geometry.flatland, &geometry.tris[at.tri as usize], Vec3::from(at.p));
    Ok(surface_point(geometry, at.tri, b1.clamp(0.0, 1.0), b2.clamp(0.0, 1.0)))
}

/// Relative L2 distance of `found` from `truth`.
pub fn distance(found: &[f64], truth: &[f64]) -> f64 {
    let off: f64 = found.iter().zip(truth).map(|(f, t)| (f - t) * (f - t)).sum();
    let all: f64 = truth.iter().map(|t| t * t).sum();
    if all > 0.0 { (off / all).sqrt() } else { off.sqrt() }
}
