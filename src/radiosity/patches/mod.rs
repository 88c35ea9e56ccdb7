//! Patches of the classical methods: the scene's own quadrilaterals, triangles and segments, cut into equal parts.

pub mod display;
pub mod exchange;
pub mod links;
pub mod sampled;

use crate::layout::{NONE, Point};
use crate::scene::Geometry;
use crate::twin::trace::{barycentric, surface_point};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Least sine of the corners of a quadrilateral that two triangles may make.
const SQUARE: f64 = 0.5;
/// Steps of Newton's method to a place in a quadrilateral; a parallelogram takes one.
const NEWTON: u32 = 6;

/// A flat piece that patches are cut from: two triangles that make a convex quadrilateral, a triangle, or a segment.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Its triangles, the second [`NONE`] where there is one only.
    pub tris: [u32; 2],
    /// The piece as a whole.
    pub shape: Shape,
    /// First of its patches.
    pub first: u32,
    /// Parts along both sides; a triangle has the same number along all three.
    pub cuts: [u32; 2],
}

/// A segment, a triangle or a convex quadrilateral: its first 2, 3 or 4 corners, local.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Corners in order.
    pub corners: [DVec3; 4],
    /// How many of them count.
    pub sides: u8,
}

/// A patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The chart that it is cut from.
    pub chart: u32,
    /// Its outline.
    pub shape: Shape,
    /// Its area (in flatland its length), local.
    pub area: f64,
}

/// Patches of a whole scene: all that reflects or emits.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Charts.
    pub charts: Vec<Chart>,
    /// Chart of each triangle, [`NONE`] where it neither reflects nor emits.
    pub chart_of: Vec<u32>,
    /// Patches, chart by chart.
    pub patches: Vec<Patch>,
}

impl Shape {
    /// A segment.
    pub fn segment(a: DVec3, b: DVec3) -> Shape {
        Shape { corners: [a, b, b, b], sides: 2 }
    }

    /// A triangle.
    pub fn triangle(a: DVec3, b: DVec3, c: DVec3) -> Shape {
        Shape { corners: [a, b, c, c], sides: 3 }
    }

    /// A convex quadrilateral.
    pub fn quad(corners: [DVec3; 4]) -> Shape {
        Shape { corners, sides: 4 }
    }

    /// The corners that count.
    pub fn outline(&self) -> &[DVec3] {
        &self.corners[..self.sides as usize]
    }

    /// Area, or length of a segment.
    pub fn area(&self) -> f64 {
        let [a, b, c, d] = self.corners;
        match self.sides {
            2 => a.distance(b),
            3 => 0.5 * (b - a).cross(c - a).length(),
            _ => 0.5 * (c - a).cross(d - b).length(),
        }
    }

    /// The middle.
    pub fn centre(&self) -> DVec3 {
        self.outline().iter().sum::<DVec3>() / self.sides as f64
    }

    /// Length that stands for the size: the root of the area, or the length.
    pub fn size(&self) -> f64 {
        if self.sides == 2 { self.area() } else { self.area().sqrt() }
    }

    /// The point of (u, v) in [0, 1]^2, and by how much the map stretches there beside the mean. Uniform on segments
    /// and triangles, bilinear on quadrilaterals.
    pub fn at(&self, u: f64, v: f64) -> (DVec3, f64) {
        let [a, b, c, _] = self.corners;
        match self.sides {
            2 => (a + (b - a) * u, 1.0),
            3 => {
                let root = u.sqrt();
                (a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v), 1.0)
            }
            _ => {
                let (p, du, dv) = self.bilinear(u, v);
                (p, du.cross(dv).length() / self.area())
            }
        }
    }

    /// The point of (u, v) in a quadrilateral, and its derivatives.
    fn bilinear(&self, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        let [a, b, c, d] = self.corners;
        let (du, dv) = ((b - a).lerp(c - d, v), (d - a).lerp(c - b, u));
        (a.lerp(b, u).lerp(d.lerp(c, u), v), du, dv)
    }

    /// Parts of equal size in parameters: `cuts[0]` along the first side, `cuts[1]` along the second; a triangle is cut
    /// `cuts[0]` times along all sides. A quadrilateral's part (i, j) has number j cuts[0] + i; see [`Mesh::find`].
    pub fn cut(&self, cuts: [u32; 2]) -> Vec<Shape> {
        let [a, b, c, _] = self.corners;
        let [n, m] = cuts;
        let s = |i: u32| i as f64 / n as f64;
        match self.sides {
            2 => (0..n).map(|i| Shape::segment(a.lerp(b, s(i)), a.lerp(b, s(i + 1)))).collect(),
            3 => {
                let at = |i: u32, j: u32| a + (b - a) * s(i) + (c - a) * s(j);
                let mut out = Vec::new();
                for i in 0..n {
                    for j in 0..n - i {
                        out.push(Shape::triangle(at(i, j), at(i + 1, j), at(i, j + 1)));
                        if j + 1 < n - i {
                            out.push(Shape::triangle(at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)));
                        }
                    }
                }
                out
            }
            _ => {
                let at = |i: u32, j: u32| self.bilinear(s(i), j as f64 / m as f64).0;
                let part = |i, j| Shape::quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(|(i, j)| part(i, j)).collect()
            }
        }
    }

    /// Where a point of a quadrilateral's plane lies in its parameters.
    fn place(&self, p: DVec3) -> (f64, f64) {
        let (mut u, mut v) = (0.5, 0.5);
        for _ in 0..NEWTON {
            let (q, du, dv) = self.bilinear(u, v);
            let (a, b, c, d) = (du.dot(du), du.dot(dv), dv.dot(dv), p - q);
            let det = a * c - b * b;
            u += (c * du.dot(d) - b * dv.dot(d)) / det;
            v += (a * dv.dot(d) - b * du.dot(d)) / det;
        }
        (u, v)
    }
}

impl Chart {
    /// A point of the chart as the passes know it.
    pub fn point(&self, geometry: &Geometry, p: DVec3) -> Point {
        let on = |t: u32| {
            let (b1, b2) = barycentric(geometry.flatland, &geometry.tris[t as usize], p.as_vec3());
            (t, b1, b2, b1.min(b2).min(1.0 - b1 - b2))
        };
        if self.shape.sides == 2 {
            let [a, b, ..] = self.shape.corners;
            let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            return surface_point(geometry, self.tris[0], along as f32, 0.0);
        }
        let mut best = on(self.tris[0]);
        if self.tris[1] != NONE {
            let other = on(self.tris[1]);
            best = if other.3 > best.3 { other } else { best };
        }
        let (b1, b2) = (best.1.clamp(0.0, 1.0), best.2.clamp(0.0, 1.0));
        let over = (b1 + b2).max(1.0);
        surface_point(geometry, best.0, b1 / over, b2 / over)
    }
}

impl Mesh {
    /// Cuts all that reflects or emits into about `count` patches of like size, at least one a chart.
    pub fn new(geometry: &Geometry, count: u32) -> Mesh {
        let mut mesh = charts(geometry);
        let all: f64 = mesh.charts.iter().map(|c| c.shape.area()).sum();
        for (i, chart) in mesh.charts.iter_mut().enumerate() {
            let shape = chart.shape;
            let [a, b, c, d] = shape.corners;
            let share = all / count as f64;
            let cuts = |length: f64, part: f64| ((length / part).round() as u32).max(1);
            chart.cuts = match shape.sides {
                2 => [cuts(shape.area(), share), 1],
                3 => [cuts((shape.area() / share).sqrt(), 1.0); 2],
                _ => {
                    let sides = [a.distance(b) + d.distance(c), b.distance(c) + a.distance(d)];
                    sides.map(|s| cuts(0.5 * s, share.sqrt()))
                }
            };
            chart.first = mesh.patches.len() as u32;
            mesh.patches.extend(shape.cut(chart.cuts).into_iter().map(|shape| Patch {
                chart: i as u32,
                shape,
                area: shape.area(),
            }));
        }
        mesh
    }

    /// The patch that holds a surface point, and the point's place in its chart, in patches; none on what neither
    /// reflects nor emits.
    pub fn find(&self, point: &Point) -> Option<(u32, [f64; 2])> {
        let chart = self.charts.get(*self.chart_of.get(point.tri as usize)? as usize)?;
        let p = Vec3::from(point.p).as_dvec3();
        let [a, b, c, _] = chart.shape.corners;
        let [n, m] = chart.cuts;
        let index = |x: f64, n: u32| (x.max(0.0) as u32).min(n - 1);
        Some(match chart.shape.sides {
            2 => {
                let x = (p - a).dot(b - a) / (b - a).length_squared() * n as f64;
                (chart.first + index(x, n), [x, 0.0])
            }
            3 => {
                let (e, f, d) = (b - a, c - a, p - a);
                let (ee, ef, ff) = (e.dot(e), e.dot(f), f.dot(f));
                let det = ee * ff - ef * ef;
                let x = (ff * e.dot(d) - ef * f.dot(d)) / det * n as f64;
                let y = (ee * f.dot(d) - ef * e.dot(d)) / det * n as f64;
                let i = index(x, n);
                let j = index(y, n - i);
                let upper = x - i as f64 + y - j as f64 > 1.0 && j + 1 < n - i;
                (chart.first + i * (2 * n - i) + 2 * j + upper as u32, [x, y])
            }
            _ => {
                let (u, v) = chart.shape.place(p);
                let (x, y) = (u * n as f64, v * m as f64);
                (chart.first + index(y, m) * n + index(x, n), [x, y])
            }
        })
    }
}

/// Charts over all that reflects or emits, not cut yet.
fn charts(geometry: &Geometry) -> Mesh {
    let tris = &geometry.tris;
    let corners = |t: usize| [tris[t].v0, tris[t].v1, tris[t].v2].map(|v| Vec3::from(v).as_dvec3());
    let key = |v: [f32; 3]| v.map(|x| (x + 0.0).to_bits());
    // Which triangle has the edge from one corner to another.
    let mut edges: HashMap<([u32; 3], [u32; 3]), usize> = HashMap::new();
    for (t, tri) in tris.iter().enumerate() {
        let v = [tri.v0, tri.v1, tri.v2];
        for k in 0..3 {
            edges.insert((key(v[k]), key(v[(k + 1) % 3])), t);
        }
    }
    let mut mesh = Mesh { chart_of: vec![NONE; tris.len()], ..Mesh::default() };
    let mut order: Vec<usize> = (0..tris.len()).filter(|&t| geometry.is_live(t)).collect();
    order.sort_unstable_by_key(|&t| geometry.source[t]);
    for t in order {
        if mesh.chart_of[t] != NONE {
            continue;
        }
        let v = [tris[t].v0, tris[t].v1, tris[t].v2];
        let c = corners(t);
        let n = Vec3::from(tris[t].normal).as_dvec3();
        let segment = v[1] == v[2];
        // Across which edge does a free triangle make the best quadrilateral?
        let mut best: Option<(f64, usize, [DVec3; 4])> = None;
        for k in (0..3).filter(|_| !segment) {
            let Some(&o) = edges.get(&(key(v[(k + 1) % 3]), key(v[k]))) else { continue };
            let same = tris[o].plane == tris[t].plane && Vec3::from(tris[o].normal).dot(Vec3::from(tris[t].normal)) > 0.0;
            if !same || mesh.chart_of[o] != NONE || tris[o].material != tris[t].material {
                continue;
            }
            let far = corners(o).into_iter().find(|p| *p != c[k] && *p != c[(k + 1) % 3]);
            let Some(far) = far else { continue };
            let quad = [c[k], far, c[(k + 1) % 3], c[(k + 2) % 3]];
            let sine = |i: usize| {
                let (e, f) = (quad[(i + 1) % 4] - quad[i], quad[(i + 3) % 4] - quad[i]);
                e.cross(f).dot(n) / (e.length() * f.length()).max(f64::MIN_POSITIVE)
            };
            let least = (0..4).map(sine).fold(f64::INFINITY, f64::min);
            if least > best.map_or(SQUARE, |b| b.0) {
                best = Some((least, o, quad));
            }
        }
        let chart = mesh.charts.len() as u32;
        mesh.chart_of[t] = chart;
        let mut pair = [t as u32, NONE];
        let shape = match best {
            _ if segment => Shape::segment(c[0], c[1]),
            Some((_, o, quad)) => {
                mesh.chart_of[o] = chart;
                pair[1] = o as u32;
                Shape::quad(quad)
            }
            None => Shape::triangle(c[0], c[1], c[2]),
        };
        mesh.charts.push(Chart { tris: pair, shape, first: 0, cuts: [1, 1] });
    }
    mesh
}
