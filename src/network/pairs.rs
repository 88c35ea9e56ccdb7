//! The kernel as a function to learn: area-uniform pairs of surface points, and G V between them.

use super::nodes::place_of;
use super::supervised::Goal;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{FEATURE_STRIDE, Node, Point};
use crate::scene::{Geometry, cumulative};
use crate::twin::sobol::sobol4;
use crate::twin::winner::Feature;
use glam::Vec3;

/// How a pair of surface points is a point of the network's space, and the kernel a number of order 1.
#[derive(Clone, Copy, Debug)]
pub struct PairMetric {
    /// 1/L, per local length.
    pub inv_unit: f32,
    /// Weight of normals, 0 where places alone count (the paper).
    pub lambda: f32,
    /// The kernel's clamp level, per local area.
    pub clamp: f32,
}

impl PairMetric {
    /// For a clamp level in units of 1/L² (1/L in flatland).
    pub fn new(geometry: &Geometry, lambda: f64, clamp: f64) -> PairMetric {
        let per_area = geometry.unit.powi(if geometry.flatland { 1 } else { 2 });
        PairMetric { inv_unit: (1.0 / geometry.unit) as f32, lambda: lambda as f32, clamp: (clamp / per_area) as f32 }
    }

    /// (x, lambda n_x, y, lambda n_y), the places in units of L.
    pub fn input(&self, x: ([f32; 3], [f32; 3]), y: ([f32; 3], [f32; 3])) -> Feature {
        let mut f = [0.0; FEATURE_STRIDE];
        for k in 0..3 {
            f[k] = x.0[k] * self.inv_unit;
            f[3 + k] = x.1[k] * self.lambda;
            f[6 + k] = y.0[k] * self.inv_unit;
            f[9 + k] = y.1[k] * self.lambda;
        }
        f
    }
}

/// A surface point and its normal.
pub fn end(geometry: &Geometry, p: &Point) -> ([f32; 3], [f32; 3]) {
    (p.p, geometry.tris[p.tri as usize].normal)
}

/// A node and its normal.
pub fn node_end(node: &Node) -> ([f32; 3], [f32; 3]) {
    (node.p, node.n)
}

/// Whether two places face each other.
pub fn facing(x: ([f32; 3], [f32; 3]), y: ([f32; 3], [f32; 3])) -> bool {
    let d = Vec3::from(y.0) - Vec3::from(x.0);
    d.dot(Vec3::from(x.1)) > 0.0 && d.dot(Vec3::from(y.1)) < 0.0
}

/// The kernel of a scene, for a network to learn: min(G V, clamp)/clamp.
pub struct Pairs<'a, E> {
    engine: &'a mut E,
    geometry: &'a Geometry,
    metric: PairMetric,
    cdf: Vec<u32>,
    seed: u32,
    /// G V of everything that was evaluated, per local area, before the clamp.
    pub raw: Vec<f32>,
}

impl<'a, E: Engine> Pairs<'a, E> {
    /// The kernel between the points of all surface that reflects or emits.
    pub fn new(engine: &'a mut E, geometry: &'a Geometry, metric: PairMetric, seed: u32) -> Pairs<'a, E> {
        let live = |t: usize| geometry.is_live(geometry.tile_tri[t] as usize);
        let areas: Vec<f64> = (0..geometry.tiles as usize).map(|t| if live(t) { geometry.tile_area(t) } else { 0.0 }).collect();
        Pairs { engine, geometry, metric, cdf: cumulative(&areas), seed, raw: Vec::new() }
    }
}

impl<E: Engine> Goal for Pairs<'_, E> {
    type Place = [Point; 2];
    type Machine = E;

    fn machine(&mut self) -> &mut E {
        self.engine
    }

    fn draw(&mut self, first: u64, count: usize) -> Vec<[Point; 2]> {
        let one = |i: usize| {
            let u = sobol4((first + i as u64) as u32, self.seed);
            [place_of(self.geometry, &self.cdf, u[0], u[1]), place_of(self.geometry, &self.cdf, u[2], u[3])]
        };
        (0..count).map(one).collect()
    }

    fn input(&self, [x, y]: &[Point; 2]) -> Feature {
        self.metric.input(end(self.geometry, x), end(self.geometry, y))
    }

    fn evaluate(&mut self, places: &[[Point; 2]]) -> Result<Vec<f32>> {
        let values = self.engine.kernel(places.as_flattened())?;
        self.raw.extend(&values);
        Ok(values.into_iter().map(|g| (g / self.metric.clamp).min(1.0)).collect())
    }
}
