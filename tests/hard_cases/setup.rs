//! What the cases of scale, visibility, leaks and random scenes share.

pub use super::common::{gpu, impossible, known, rrmse};
use glam::{DQuat, DVec3, Vec3};
use raycell::engine::Engine;
use raycell::gpu::Gpu;
use raycell::layout::{BvhNode, Point};
use raycell::pass::GpuEngine;
use raycell::scene::shapes::Triangles;
use raycell::scene::{Geometry, Material};
use raycell::twin::trace::surface_point;
use raycell::{Answer, Backend, Direct, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::f64::consts::PI;
use std::sync::Arc;

/// Random numbers of the tests' own (splitmix64).
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.roll() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// Uniform in the unit ball.
    pub fn in_ball(&mut self) -> DVec3 {
        loop {
            let p = DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0;
            if p.length_squared() < 1.0 && p != DVec3::ZERO {
                return p;
            }
        }
    }

    pub fn turn(&mut self) -> DQuat {
        let axis = self.in_ball().normalize();
        DQuat::from_axis_angle(axis, 2.0 * PI * self.unit())
    }
}

/// The generic rotation of all cases (seed 5).
pub fn rotated(p: [f64; 3]) -> [f64; 3] {
    (Dice(5).turn() * DVec3::from(p)).to_array()
}

/// A grey material that emits radiosity `e`.
pub fn grey(rho: f64, e: f64) -> Material {
    Material::new("grey", [rho; 3], [e / PI; 3])
}

pub fn scene(triangles: &Triangles, materials: Vec<Material>) -> Scene {
    Scene::from_triangles("case", triangles, materials).unwrap()
}

/// A bake with so many rays, light straight from emitters as stated.
pub fn params(rays: u32, direct: Direct) -> Params {
    Params { rays, direct, ..Params::default() }
}

/// All light through the network, read from its nodes; gathered for only where none speaks for a point. Rows sum to 1 there
/// whatever the rays' scatter, as long as no slot is dropped, where gathers and direct light have the scatter of their samples.
pub fn by_nodes(rays: u32) -> Params {
    Params {
        slots: 128,
        cells: Some((rays / 16).max(64)),
        gather_threshold: 0.0,
        direct_tolerance: 5e-4,
        direct_samples: 16_384,
        ..params(rays, Direct::Network)
    }
}

pub fn solve(gpu: &Arc<Gpu>, scene: &Scene, params: &Params) -> Solution {
    bake(&Backend::Gpu(gpu.clone()), scene, params, &mut |_| Flow::Continue).unwrap()
}

/// Answers at points, held to the rule that every scene obeys, to a relative `error`.
pub fn ask(gpu: &Arc<Gpu>, solution: &Solution, points: &[SurfacePoint], error: f64) -> Vec<Answer> {
    let answers = solution.query(&Backend::Gpu(gpu.clone()), points).unwrap();
    assert_eq!(impossible(&answers, solution.scene(), error), None);
    answers
}

pub fn lit(gpu: &Arc<Gpu>, scene: &Scene, params: &Params, points: &[SurfacePoint], error: f64) -> Vec<Answer> {
    ask(gpu, &solve(gpu, scene, params), points, error)
}

/// The normal of a triangle.
pub fn normal([a, b, c]: [[f64; 3]; 3]) -> DVec3 {
    (DVec3::from(b) - DVec3::from(a)).cross(DVec3::from(c) - DVec3::from(a)).normalize()
}

/// A point on a triangle, asked for from its front.
pub fn on(corners: [[f64; 3]; 3], b1: f64, b2: f64) -> SurfacePoint {
    let [a, b, c] = corners.map(DVec3::from);
    SurfacePoint { p: (a + (b - a) * b1 + (c - a) * b2).to_array(), n: normal(corners).to_array() }
}

/// The middles of triangles.
pub fn middles(triangles: &Triangles) -> Vec<SurfacePoint> {
    triangles.iter().map(|t| on(t.0, 1.0 / 3.0, 1.0 / 3.0)).collect()
}

/// `each` random points on every triangle.
pub fn scattered(triangles: &Triangles, each: usize, seed: u64) -> Vec<SurfacePoint> {
    let mut dice = Dice(seed);
    let mut point = |t: &([[f64; 3]; 3], u32)| {
        let (root, b) = (dice.unit().sqrt(), dice.unit());
        on(t.0, root * (1.0 - b), root * b)
    };
    triangles.iter().flat_map(|t| (0..each).map(|_| point(t)).collect::<Vec<_>>()).collect()
}

/// A uniform point of triangle `tri`, as passes draw them.
pub fn drawn(geometry: &Geometry, tri: u32, dice: &mut Dice) -> Point {
    let (root, b) = (dice.unit().sqrt() as f32, dice.unit() as f32);
    surface_point(geometry, tri, root * (1.0 - b), root * b)
}

/// G V of pairs of points, by the pass on the device.
pub fn kernel(engine: &mut GpuEngine, pairs: &[Point]) -> Vec<f32> {
    pairs.chunks(1 << 19).flat_map(|chunk| engine.kernel(chunk).unwrap()).collect()
}

/// The same scene as one leaf: every ray is tried against every triangle.
pub fn brute(geometry: &Geometry) -> Geometry {
    let all = BvhNode { min: [-4.0; 3], max: [4.0; 3], count: geometry.tris.len() as u32, first: 0 };
    Geometry { nodes: vec![all], ..geometry.clone() }
}

/// Twelve small triangles about a point that face all six ways: rays that belong to no surface borrow their ends'
/// normals. The first six face -x, +x, -y, ...; the others again.
pub fn compass(at: [f64; 3], size: f64, material: u32) -> Triangles {
    let mut out = Triangles::new();
    for round in 0..2 {
        for axis in 0..6 {
            let (k, up) = (axis / 2, axis % 2 == 1);
            // Far enough apart to share nothing.
            let shift = DVec3::from(at) + DVec3::ONE * (size * 4.0 * (6 * round + axis) as f64);
            let mut e = [DVec3::ZERO; 2];
            e[0][(k + 1) % 3] = size;
            e[1][(k + 2) % 3] = size;
            if !up {
                e.swap(0, 1);
            }
            out.push(([shift.to_array(), (shift + e[0]).to_array(), (shift + e[1]).to_array()], material));
        }
    }
    out
}

/// The ends of a segment from `a` to `b` (local), with the compass's triangles (its first is number `first` of the scene)
/// for normals: its G is positive.
pub fn segment(geometry: &Geometry, first: u32, a: Vec3, b: Vec3) -> [Point; 2] {
    let d = b - a;
    let k = d.abs().max_position();
    let face = |up: bool| 2 * k as u32 + up as u32;
    let tri = |n: u32| geometry.source.iter().position(|&s| s == first + n).unwrap() as u32;
    let point = |p: Vec3, n: u32| Point { p: p.to_array(), tri: tri(n), ..Point::default() };
    [point(a, face(d[k] > 0.0)), point(b, 6 + face(d[k] < 0.0))]
}

/// Least and largest of the differences from `want`, relative to it, over all bands.
pub fn worst(answers: &[Answer], want: f64) -> f64 {
    answers.iter().flat_map(|a| a.b).map(|b| (b / want - 1.0).abs()).fold(0.0, f64::max)
}

/// The mean radiosity over points and bands.
pub fn mean(answers: &[Answer]) -> f64 {
    answers.iter().flat_map(|a| a.b).sum::<f64>() / (3 * answers.len()) as f64
}
