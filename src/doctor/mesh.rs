//! The scene as a mesh: corners welded by place, edges with their triangles, and patches.
//!
//! Everything is indexed as [`Geometry::tris`] is; positions are local.

use crate::layout::NONE;
use crate::scene::{Geometry, Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Corners nearer than this are one, local (the scene's longest side is between 1 and 2).
pub const WELD: f64 = 2e-6;

/// A side of a triangle, from corner `k` to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Side {
    pub tri: u32,
    pub k: u32,
}

/// Two triangles that meet in an edge.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    pub tris: [u32; 2],
    /// Whether both are wound the same way round.
    pub agree: bool,
}

/// The welded scene.
pub struct Mesh<'a> {
    pub scene: &'a Scene,
    pub geometry: &'a Geometry,
    /// Welded vertices.
    pub vertices: Vec<DVec3>,
    /// Welded corners of each triangle.
    pub corners: Vec<[u32; 3]>,
    /// The triangle with the same corners that faces the other way, or [`NONE`].
    pub mirror: Vec<u32>,
    /// Edges that exactly two triangles share.
    pub meetings: Vec<Meeting>,
    /// Edges that one triangle has alone.
    pub border: Vec<Side>,
    /// The patch of each triangle: what hangs together by edges, wound one way.
    pub patch: Vec<u32>,
    /// Area of each patch, local.
    pub patch_area: Vec<f64>,
}

impl<'a> Mesh<'a> {
    pub fn new(scene: &'a Scene, geometry: &'a Geometry) -> Mesh<'a> {
        let (vertices, corners) = weld(geometry);
        let mirror = mirrors(geometry.flatland, &corners);
        let (meetings, border) = edges(&corners, &mirror);
        let mut groups = Groups::new(corners.len());
        for m in meetings.iter().filter(|m| m.agree) {
            groups.join(m.tris[0], m.tris[1]);
        }
        // A sheet's two faces, each with its mirror, are one thing.
        for (t, &m) in mirror.iter().enumerate().filter(|(_, m)| **m != NONE) {
            groups.join(t as u32, m);
        }
        let patch = groups.numbers();
        let mut patch_area = vec![0.0; patch.iter().max().map_or(0, |&p| p as usize + 1)];
        for (t, &p) in patch.iter().enumerate() {
            patch_area[p as usize] += geometry.areas[t];
        }
        Mesh { scene, geometry, vertices, corners, mirror, meetings, border, patch, patch_area }
    }

    /// The object of a triangle.
    pub fn object(&self, tri: u32) -> u32 {
        self.scene.faces[self.face(tri) as usize].object
    }

    /// The triangle's index in [`Scene::faces`].
    pub fn face(&self, tri: u32) -> u32 {
        self.geometry.source[tri as usize]
    }

    /// A triangle's unit normal.
    pub fn normal(&self, tri: u32) -> DVec3 {
        DVec3::from_array(self.geometry.tris[tri as usize].normal.map(f64::from))
    }

    /// A triangle's corners.
    pub fn triangle(&self, tri: u32) -> [DVec3; 3] {
        self.corners[tri as usize].map(|v| self.vertices[v as usize])
    }

    /// Whether a triangle emits.
    pub fn shines(&self, tri: u32) -> bool {
        self.geometry.material_of(tri as usize).emit.iter().any(|&e| e > 0.0)
    }

    /// A local place in world coordinates, metres.
    pub fn world(&self, p: DVec3) -> [f64; 3] {
        (p / self.geometry.scale + DVec3::from_array(self.geometry.center)).to_array()
    }

    /// A local length in metres.
    pub fn metres(&self, length: f64) -> f64 {
        length / self.geometry.scale
    }
}

/// Makes one vertex of all corners within [`WELD`] of it.
fn weld(geometry: &Geometry) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const CELL: f64 = 2.0 * WELD;
    let mut exact: HashMap<[u32; 3], u32> = HashMap::new();
    // Cells of a grid: the first vertex in each, and from each vertex the next one.
    let mut first: HashMap<[i32; 3], u32> = HashMap::new();
    let mut next: Vec<u32> = Vec::new();
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut place = |v: [f32; 3]| {
        *exact.entry(v.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
            let p = DVec3::from_array(v.map(f64::from));
            let cell = |q: DVec3| (q / CELL).floor().as_ivec3().to_array();
            let (low, high) = (cell(p - WELD), cell(p + WELD));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let mut at = first.get(&[x, y, z]).copied().unwrap_or(NONE);
                        while at != NONE {
                            if vertices[at as usize].distance(p) <= WELD {
                                return at;
                            }
                            at = next[at as usize];
                        }
                    }
                }
            }
            let new = vertices.len() as u32;
            vertices.push(p);
            next.push(first.insert(cell(p), new).unwrap_or(NONE));
            new
        })
    };
    let corners = geometry.tris.iter().map(|t| [t.v0, t.v1, t.v2].map(&mut place)).collect();
    (vertices, corners)
}

/// Finds triangles, or segments, with the same corners in opposite order.
fn mirrors(flatland: bool, corners: &[[u32; 3]]) -> Vec<u32> {
    let mut sorted: Vec<([u32; 3], u32)> = corners
        .iter()
        .enumerate()
        .map(|(t, c)| {
            // Of a segment's three corners two are one: its order must not tell the key.
            let mut key = if flatland { [c[0], c[1], 0] } else { *c };
            key.sort_unstable();
            (key, t as u32)
        })
        .collect();
    sorted.par_sort_unstable();
    let even = |t: u32| {
        let [a, b, c] = corners[t as usize];
        if flatland { a < b } else { (a < b) ^ (b < c) ^ (a < c) }
    };
    let mut mirror = vec![NONE; corners.len()];
    for pair in sorted.windows(2) {
        let (a, b) = (pair[0].1, pair[1].1);
        if pair[0].0 == pair[1].0 && even(a) != even(b) {
            mirror[a as usize] = b;
            mirror[b as usize] = a;
        }
    }
    mirror
}

/// Sorts the sides by edge: those with one triangle, and those with two. Mirrored triangles have no part
/// in it: a sheet that is seen from both sides has no wrong side and no border.
fn edges(corners: &[[u32; 3]], mirror: &[u32]) -> (Vec<Meeting>, Vec<Side>) {
    struct Half {
        ends: (u32, u32),
        side: Side,
        forward: bool,
    }
    let mut halves: Vec<Half> = Vec::with_capacity(3 * corners.len());
    for (t, c) in corners.iter().enumerate() {
        // Triangles thinner than the weld have fallen together.
        if mirror[t] != NONE || c[0] == c[1] || c[1] == c[2] || c[2] == c[0] {
            continue;
        }
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            halves.push(Half { ends: (a.min(b), a.max(b)), side: Side { tri: t as u32, k: k as u32 }, forward: a < b });
        }
    }
    halves.par_sort_unstable_by_key(|h| (h.ends, h.side.tri));
    let (mut meetings, mut border) = (Vec::new(), Vec::new());
    for edge in halves.chunk_by(|a, b| a.ends == b.ends) {
        match edge {
            [one] => border.push(one.side),
            [one, two] => {
                meetings.push(Meeting { tris: [one.side.tri, two.side.tri], agree: one.forward != two.forward });
            }
            // Walls that meet in a T, boxes that share an edge: no winding is right or wrong there.
            _ => {}
        }
    }
    (meetings, border)
}

/// Disjoint sets of numbers.
struct Groups(Vec<u32>);

impl Groups {
    fn new(n: usize) -> Groups {
        Groups((0..n as u32).collect())
    }

    fn find(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// The number of each one's set, counted from 0 in order of appearance.
    fn numbers(mut self) -> Vec<u32> {
        let mut number = vec![NONE; self.0.len()];
        let mut count = 0;
        (0..self.0.len() as u32)
            .map(|i| {
                let root = self.find(i) as usize;
                if number[root] == NONE {
                    number[root] = count;
                    count += 1;
                }
                number[root]
            })
            .collect()
    }
}
