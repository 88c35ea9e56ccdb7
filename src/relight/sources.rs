//! Direct light as the nodes see it: sampled at points all over the surface, and fitted to each node by value and slope, as
//! the coefficients read what nodes send.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{NONE, Point, Psi};
use crate::network::tiles;
use crate::progress::Progress;
use crate::radiosity::refined::Light;
use crate::scene::Geometry;
use crate::stream::{Stream, stream};
use crate::twin::assign::Surface;
use crate::twin::coefficients::offsets;
use crate::twin::direct::Samples;
use crate::twin::math::seed_of;
use crate::twin::trace::{barycentric, surface_point};
use glam::{DVec3, Vec3};

/// Points in flight.
const CHUNK: usize = 65_536;
/// Most points a node, but for its own.
const EACH: usize = 20;
/// Samples of direct light at a point.
const SAMPLES: Samples = Samples { emitter: 3, cosine: 1 };
/// Points around a node below which it has no slope.
const LEAST: f64 = 4.0;
/// What a node's own place counts, as a share of the area that nodes have on the mean.
const OWN: f64 = 0.05;

/// Points all over what reflects, and the nodes that speak for them.
pub(super) struct Looks {
    points: Vec<Point>,
    psi: Vec<Psi>,
    /// Area that each stands for, local.
    areas: Vec<f64>,
}

impl Looks {
    /// Looks around with the surface that is set on the engine.
    pub fn new<E: Engine>(
        engine: &mut E,
        geometry: &Geometry,
        surface: &Surface,
        seed: u32,
        progress: &mut Progress,
    ) -> Result<Looks> {
        let mut points = tiles::places(geometry, stream(seed, Stream::TilePlace));
        points.retain(|p| geometry.material_at(p).rho != [0.0; 3]);
        // Neighbours follow each other, so every n-th one leaves no gap.
        let step = points.len().div_ceil(EACH * surface.nodes.len().max(1)).max(1);
        let mut points: Vec<Point> = points.into_iter().step_by(step).collect();
        let mut areas: Vec<f64> = points.iter().map(|p| geometry.tile_area(p.tile as usize)).collect();
        // Nodes lie closer where light changes quickly: each has a point at least.
        let own = OWN * geometry.area / surface.nodes.len().max(1) as f64;
        for node in &surface.nodes {
            if let Some(at) = geometry.locate(geometry.to_world(node.p), node.n.map(f64::from)) {
                let (b1, b2) = barycentric(geometry.flatland, &geometry.tris[at.tri as usize], Vec3::from(at.p));
                points.push(surface_point(geometry, at.tri, b1.clamp(0.0, 1.0), b2.clamp(0.0, 1.0)));
                areas.push(own);
            }
        }
        let mut psi = Vec::with_capacity(points.len());
        for chunk in points.chunks(CHUNK) {
            let mut batch = engine.upload(chunk)?;
            engine.assign(&mut batch)?;
            psi.extend(engine.psi(&batch)?);
            progress.tick()?;
        }
        Ok(Looks { points, psi, areas })
    }

    /// Direct irradiance at every point, scaled as the engine's scene is. Its own samples, whatever the emitters are.
    pub fn direct<E: Engine>(&self, engine: &mut E, seed: u32, progress: &mut Progress) -> Result<Vec<[f32; 3]>> {
        let mut direct = Vec::with_capacity(self.points.len());
        for (i, chunk) in self.points.chunks(CHUNK).enumerate() {
            let mut batch = engine.upload(chunk)?;
            engine.direct(&mut batch, None, seed_of(stream(seed, Stream::TileDirect), i as u32), 0, 1, SAMPLES)?;
            direct.extend(engine.direct_sums(&batch)?.iter().map(|d| d.mean()));
            progress.tick()?;
        }
        Ok(direct)
    }

    /// The area that each node speaks for, local.
    pub fn areas(&self, nodes: usize) -> Vec<f64> {
        let mut areas = vec![0.0; nodes];
        for (psi, area) in self.psi.iter().zip(&self.areas) {
            for (&node, &weight) in psi.node.iter().zip(&psi.weight).filter(|(_, w)| **w > 0.0) {
                areas[node as usize] += area * f64::from(weight);
            }
        }
        areas
    }

    /// A number at every tile from numbers at the nodes; 0 where none speaks.
    pub fn on_tiles(&self, geometry: &Geometry, of_node: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; geometry.tiles as usize];
        for (point, psi) in self.points.iter().zip(&self.psi).filter(|(p, _)| p.tile != NONE) {
            let said = psi.node.iter().zip(&psi.weight).filter(|(_, w)| **w > 0.0);
            out[point.tile as usize] = said.map(|(&n, &w)| of_node[n as usize] * f64::from(w)).sum();
        }
        out
    }

    /// The least-squares plane of numbers at the points, each node's own: the value where its mass has its mean, and the slopes.
    pub fn fit(&self, surface: &Surface, ridge: f64, values: &[[f32; 3]]) -> Vec<Light> {
        let mut sums = vec![Sums::default(); surface.nodes.len()];
        for ((point, psi), (area, value)) in self.points.iter().zip(&self.psi).zip(self.areas.iter().zip(values)) {
            for (&n, &weight) in psi.node.iter().zip(&psi.weight).filter(|(_, w)| **w > 0.0) {
                let node = &surface.nodes[n as usize];
                let (a, b) = offsets(node, Vec3::from(point.p));
                let at = [a - node.mean[0], b - node.mean[1]].map(f64::from);
                sums[n as usize].add(area * f64::from(weight), at, DVec3::from_array(value.map(f64::from)));
            }
        }
        sums.iter().map(|s| s.plane(ridge)).collect()
    }
}

/// Moments of weighted numbers about a place.
#[derive(Clone, Copy, Default)]
struct Sums {
    weight: f64,
    square: f64,
    at: [f64; 2],
    second: [f64; 3],
    value: DVec3,
    along: [DVec3; 2],
}

impl Sums {
    fn add(&mut self, w: f64, [a, b]: [f64; 2], value: DVec3) {
        self.weight += w;
        self.square += w * w;
        self.at = [self.at[0] + w * a, self.at[1] + w * b];
        self.second = [self.second[0] + w * a * a, self.second[1] + w * a * b, self.second[2] + w * b * b];
        self.value += value * w;
        self.along = [self.along[0] + value * (w * a), self.along[1] + value * (w * b)];
    }

    fn plane(&self, ridge: f64) -> Light {
        if self.weight <= 0.0 {
            return [DVec3::ZERO; 3];
        }
        let mean = self.value / self.weight;
        let [a, b] = self.at.map(|x| x / self.weight);
        let [aa, ab, bb] = self.second.map(|x| x / self.weight);
        let (aa, ab, bb) = (aa - a * a, ab - a * b, bb - b * b);
        let lift = ridge * (aa + bb);
        let (aa, bb) = (aa + lift, bb + lift);
        let det = aa * bb - ab * ab;
        if self.weight * self.weight / self.square < LEAST || det <= 0.0 || lift <= 0.0 {
            return [mean, DVec3::ZERO, DVec3::ZERO];
        }
        let (u, v) = (self.along[0] / self.weight - mean * a, self.along[1] / self.weight - mean * b);
        let (g0, g1) = ((u * bb - v * ab) / det, (v * aa - u * ab) / det);
        [mean - g0 * a - g1 * b, g0, g1]
    }
}
