//! The scene as the passes see it: recentred and scaled in f64, then f32; hierarchy, planar pieces,
//! start tiles and emitters.

use super::{Scene, cumulative};
use crate::disjoint::Disjoint;
use crate::error::{Error, Result};
use crate::layout::{BvhNode, Emitter, Material, NONE, Point, TWIN, Tri};
use crate::params::{Norm, Params};
use crate::twin::direct::near2;
use glam::Vec3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Tiles the whole live area is cut into, about (a triangle has at least one).
pub(crate) const TILES: f64 = 20_000.0;
/// How much wider than its triangle a box is, local: a ray meets triangles with an absolute error of some ulp, and must
/// then have met their boxes (hard cases D02, D07).
const PAD: f32 = 1e-6;
/// Most tiles along an edge of one triangle.
const MAX_SPLIT: u32 = 160;
/// Most tiles of one flatland segment.
const MAX_FLAT_SPLIT: u32 = MAX_SPLIT * MAX_SPLIT;

/// A prepared scene. Lengths are local: `local = (world - center) * scale`.
///
/// In flatland a triangle is a segment: `v0` to `v1`, and `v2 = v1`; its area is its length, its tiles follow one
/// another along it, and its boxes reach from z = -1 to 1.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Whether the scene lies in flatland; every pass asks here.
    pub flatland: bool,
    /// Share of the light that arrives ([`crate::params::Norm`]); the reflectances in `materials` are multiplied by
    /// it, so that no pass need know.
    pub arrives: f64,
    /// Centre of the bounding box, world.
    pub center: [f64; 3],
    /// Power of two that brings the largest half extent into (0.5, 1].
    pub scale: f64,
    /// Power of two that brings the largest emission into (0.5, 1]; radiosities inside the passes are multiplied by it.
    pub emission_scale: f64,
    /// Hierarchy, root first.
    pub nodes: Vec<BvhNode>,
    /// Triangles in the order of the hierarchy's leaves.
    pub tris: Vec<Tri>,
    /// Index of each triangle in [`Scene::faces`].
    pub source: Vec<u32>,
    /// Area of each triangle, local, f64.
    pub areas: Vec<f64>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Emitting triangles with their cumulative distribution; empty where nothing emits.
    pub emitters: Vec<Emitter>,
    /// Sampling density of an emitter per unit of its summed emission, per local area.
    pub emitter_density: f32,
    /// Number of tiles.
    pub tiles: u32,
    /// Triangle of each tile.
    pub tile_tri: Vec<u32>,
    /// Area that reflects or emits, local.
    pub area: f64,
    /// The length L that features are measured in, local: sqrt(area/6), in flatland length/4; 1 of a unit box.
    pub unit: f64,
    /// Number of planar pieces (edge-connected, coplanar, of one material); both sides of a sheet count.
    pub pieces: u32,
    /// Faces left out because they have no area.
    pub degenerate: Vec<u32>,
    /// Faces left out because they repeat another: the face, and the one it repeats.
    pub duplicate: Vec<[u32; 2]>,
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The power of two that brings `x > 0` into (0.5, 1]; near it where that power is beyond f64's.
pub(crate) fn power_of_two_for(x: f64) -> f64 {
    let mut s = 2f64.powi((-x.log2().ceil()).clamp(-1000.0, 1000.0) as i32);
    // log2 may round at the interval's ends.
    while x * s > 1.0 {
        s *= 0.5;
    }
    while x * s <= 0.5 && s < 2f64.powi(1022) {
        s *= 2.0;
    }
    s
}

impl Geometry {
    /// As [`Geometry::new`], for a bake with these parameters.
    ///
    /// Errors: also [`Error::InvalidParam`] for a norm that the scene's space does not have.
    pub fn for_bake(scene: &Scene, params: &Params) -> Result<Geometry> {
        let mut geometry = Geometry::new(scene)?;
        if params.norm == Norm::Paper1997 && !geometry.flatland {
            let range = "it is for flatland scenes: in three dimensions the paper's kernel has the norm of lambert";
            return Err(Error::InvalidParam { name: "norm", value: "paper1997".into(), range });
        }
        geometry.arrives = params.norm.share();
        if params.norm != Norm::Lambert {
            for m in &mut geometry.materials {
                m.rho = m.rho.map(|rho| (rho as f64 * geometry.arrives) as f32);
            }
        }
        Ok(geometry)
    }

    /// Prepares a scene.
    ///
    /// Errors: those of [`Scene::check`]; [`Error::EmptyScene`] where no triangle has an area.
    pub fn new(scene: &Scene) -> Result<Geometry> {
        scene.check()?;
        let empty = || Error::EmptyScene { scene: scene.name.clone() };

        // Bound the vertices that faces use, recentre, and scale by a power of two, all in f64.
        let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
        for face in &scene.faces {
            for &v in &face.vertices {
                for k in 0..3 {
                    low[k] = low[k].min(scene.vertices[v as usize][k]);
                    high[k] = high[k].max(scene.vertices[v as usize][k]);
                }
            }
        }
        let flatland = scene.is_flatland();
        let center = [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]);
        let half = (0..3).map(|k| high[k] - center[k]).fold(0.0, f64::max);
        if half <= 0.0 || !half.is_finite() {
            return Err(empty());
        }
        let scale = power_of_two_for(half);
        let local = |v: u32| [0, 1, 2].map(|k| ((scene.vertices[v as usize][k] - center[k]) * scale) as f32);

        // Keep triangles that have an area after the cast, each once.
        let mut kept: Vec<Kept> = Vec::new();
        let (mut degenerate, mut duplicate) = (Vec::new(), Vec::new());
        let mut seen = HashMap::new();
        for (i, face) in scene.faces.iter().enumerate() {
            let corners = face.vertices.map(local);
            let c = corners.map(|v| v.map(f64::from));
            // The left of a segment, as long as it; of a triangle twice as long as its area.
            let way = sub(c[1], c[0]);
            let normal = if flatland { [-way[1], way[0], 0.0] } else { cross(way, sub(c[2], c[0])) };
            let double_area = dot(normal, normal).sqrt();
            let longest = [(0, 1), (1, 2), (2, 0)]
                .iter()
                .map(|&(a, b)| {
                    let e = sub(c[b], c[a]);
                    dot(e, e)
                })
                .fold(0.0, f64::max);
            // Thinner than rounding of the coordinates: neither its normal nor its area means anything.
            if double_area <= longest * 1e-9 || double_area < 1e-30 {
                degenerate.push(i as u32);
                continue;
            }
            match seen.entry(wound(corners)) {
                Entry::Occupied(first) => {
                    duplicate.push([i as u32, *first.get()]);
                    continue;
                }
                Entry::Vacant(free) => free.insert(i as u32),
            };
            let area = if flatland { double_area } else { 0.5 * double_area };
            kept.push(Kept { face: i as u32, corners, normal: normal.map(|x| x / double_area), area });
        }
        if kept.is_empty() {
            return Err(empty());
        }

        // Build the hierarchy and lay triangles out in its leaf order.
        let boxes: Vec<Bounds> = kept.iter().map(|k| Bounds { corners: k.corners, flatland }).collect();
        let bvh =
            obvhs::bvh2::builder::build_bvh2(&boxes, obvhs::BvhBuildParams::medium_build(), &mut std::time::Duration::default());
        let nodes: Vec<BvhNode> = bvh
            .nodes
            .iter()
            .map(|n| BvhNode { min: n.min.to_array(), count: n.prim_count, max: n.max.to_array(), first: n.first_index })
            .collect();
        let order: Vec<usize> = bvh.primitive_indices.iter().map(|&i| i as usize).collect();

        // Materials, with the emission brought near 1.
        let brightest = scene.materials.iter().flat_map(|m| m.emission).fold(0.0, f64::max);
        let emission_scale = if brightest > 0.0 { power_of_two_for(brightest * std::f64::consts::PI) } else { 1.0 };
        let materials: Vec<Material> = scene
            .materials
            .iter()
            .map(|m| Material {
                rho: m.reflectance.map(|x| x as f32),
                emit: m.emission.map(|x| (x * std::f64::consts::PI * emission_scale) as f32),
                ..Material::default()
            })
            .collect();
        let live = |m: u32| {
            let m = &materials[m as usize];
            m.rho.iter().chain(&m.emit).any(|&x| x > 0.0)
        };

        // Number planar pieces, cut live area into tiles.
        let twins = twins(flatland, &kept, &seen);
        let mut planes = planar_pieces(&kept, &twins, scene);
        let pieces = planes.iter().max().map_or(0, |&m| m + 1);
        join_twins(&mut planes, &twins, pieces);
        let material_of = |i: usize| scene.faces[kept[i].face as usize].material;
        let area: f64 = (0..kept.len()).filter(|&i| live(material_of(i))).map(|i| kept[i].area).sum();
        let total: f64 = kept.iter().map(|k| k.area).sum();
        let tile_area = area.max(1e-3 * total) / TILES;
        let (mut tris, mut source, mut areas, mut tile_tri) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for &i in &order {
            let Kept { face, corners, normal, area: tri_area } = kept[i];
            let material = material_of(i);
            let split = match (live(material), flatland) {
                (false, _) => 1,
                (true, false) => ((tri_area / tile_area).sqrt().ceil() as u32).clamp(1, MAX_SPLIT),
                (true, true) => ((tri_area / tile_area).ceil() as u32).clamp(1, MAX_FLAT_SPLIT),
            };
            let tiles = if flatland { split } else { split * split };
            let first_tile = tile_tri.len() as u32;
            tile_tri.extend(std::iter::repeat_n(tris.len() as u32, tiles as usize));
            tris.push(Tri {
                v0: corners[0],
                material,
                v1: corners[1],
                plane: planes[i],
                v2: corners[2],
                first_tile,
                normal: normal.map(|x| x as f32),
                split,
            });
            source.push(face);
            areas.push(tri_area);
        }

        // Emitters are picked by power; a triangle's density is its share over its area.
        let power = |t: usize| {
            let e = materials[tris[t].material as usize].emit;
            areas[t] * (e[0] + e[1] + e[2]) as f64
        };
        let shining: Vec<usize> = (0..tris.len()).filter(|&t| power(t) > 0.0).collect();
        let powers: Vec<f64> = shining.iter().map(|&t| power(t)).collect();
        let all: f64 = powers.iter().sum();
        let emitters: Vec<Emitter> = cumulative(&powers)
            .into_iter()
            .zip(&shining)
            .zip(&powers)
            .map(|((cdf, &t), p)| {
                let density = p / all / areas[t];
                let corner = |v: [f32; 3]| (Vec3::from(v) - Vec3::from(tris[t].v0)).length() as f64;
                let longest = corner(tris[t].v1).max(corner(tris[t].v2));
                Emitter { tri: t as u32, cdf, density: density as f32, near2: near2(flatland, longest, density) }
            })
            .collect();

        let lit = area.max(1e-3 * total);
        Ok(Geometry {
            flatland,
            arrives: 1.0,
            center,
            scale,
            emission_scale,
            nodes,
            tris,
            source,
            areas,
            materials,
            emitters,
            emitter_density: if all > 0.0 { (1.0 / all) as f32 } else { 0.0 },
            tiles: tile_tri.len() as u32,
            tile_tri,
            area,
            unit: if flatland { lit / 4.0 } else { (lit / 6.0).sqrt() },
            pieces,
            degenerate,
            duplicate,
        })
    }

    /// Area of a tile, local.
    pub fn tile_area(&self, tile: usize) -> f64 {
        let t = self.tile_tri[tile] as usize;
        let split = self.tris[t].split as f64;
        self.areas[t] / if self.flatland { split } else { split.powi(2) }
    }

    /// The distance between neighbours where `count` points share the live area evenly, local.
    pub fn spacing(&self, count: usize) -> f64 {
        let share = self.area / count.max(1) as f64;
        if self.flatland { share } else { share.sqrt() }
    }

    /// Whether a triangle reflects or emits.
    pub fn is_live(&self, tri: usize) -> bool {
        let m = self.material_of(tri);
        m.rho.iter().chain(&m.emit).any(|&x| x > 0.0)
    }

    /// Of which materials errors are measured: those that reflect and do not shine, whose light is found and not given.
    /// Where all that reflect shine too, they are.
    pub fn judged(&self) -> impl Fn(&Material) -> bool + use<> {
        let reflects = |m: &Material| m.rho != [0.0; 3];
        let dark = |m: &Material| m.emit == [0.0; 3];
        let any = (0..self.tris.len()).any(|t| reflects(self.material_of(t)) && dark(self.material_of(t)));
        move |m| reflects(m) && (dark(m) || !any)
    }

    /// The material of a triangle.
    pub fn material_of(&self, tri: usize) -> &Material {
        &self.materials[self.tris[tri].material as usize]
    }

    /// The material at a surface point.
    pub fn material_at(&self, point: &Point) -> &Material {
        self.material_of(point.tri as usize)
    }

    /// Longest side of the bounding box, metres.
    pub fn extent(&self) -> f64 {
        self.local_extent() / self.scale
    }

    /// Longest side of the bounding box, local.
    pub(super) fn local_extent(&self) -> f64 {
        let pad = 2.0 * f64::from(PAD);
        let side = |k: usize| self.nodes.first().map_or(0.0, |root| (root.max[k] as f64 - root.min[k] as f64 - pad).max(0.0));
        // Flatland's boxes have a height, its scenes none.
        side(0).max(side(1)).max(if self.flatland { 0.0 } else { side(2) })
    }

    /// World position to local.
    pub fn to_local(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (p[k] - self.center[k]) * self.scale)
    }

    /// Local position to world.
    pub fn to_world(&self, p: [f32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| f64::from(p[k]) / self.scale + self.center[k])
    }
}

/// A triangle that has an area after the cast.
#[derive(Clone, Copy)]
struct Kept {
    /// Index in [`Scene::faces`].
    face: u32,
    corners: [[f32; 3]; 3],
    normal: [f64; 3],
    area: f64,
}

struct Bounds {
    corners: [[f32; 3]; 3],
    flatland: bool,
}

impl obvhs::Boundable for Bounds {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        let v = self.corners.map(glam::Vec3A::from_array);
        // A box without a height would have rays divide 0 by 0.
        let up = glam::Vec3A::new(0.0, 0.0, if self.flatland { 1.0 } else { 0.0 });
        let (low, high) = (v[0].min(v[1]).min(v[2]) - up, v[0].max(v[1]).max(v[2]) + up);
        obvhs::aabb::Aabb { min: low - glam::Vec3A::splat(PAD), max: high + glam::Vec3A::splat(PAD) }
    }
}

/// Corners by which a triangle is known again. The same corners wound the other way are another surface:
/// they are rotated, not sorted.
fn wound(corners: [[f32; 3]; 3]) -> [[u32; 3]; 3] {
    let mut key = corners.map(|v| v.map(|x| (x + 0.0).to_bits()));
    let first = (0..3).min_by_key(|&k| key[k]).unwrap_or(0);
    key.rotate_left(first);
    key
}

/// For each triangle the one with the same corners and opposite winding, or [`NONE`]. `seen` tells the face of
/// each kept triangle's corners.
fn twins(flatland: bool, kept: &[Kept], seen: &HashMap<[[u32; 3]; 3], u32>) -> Vec<u32> {
    let twin = |k: &Kept| {
        let [a, b, c] = k.corners;
        let face = seen.get(&wound(if flatland { [b, a, a] } else { [a, c, b] }))?;
        kept.binary_search_by_key(face, |k| k.face).ok()
    };
    kept.iter().map(|k| twin(k).map_or(NONE, |t| t as u32)).collect()
}

/// Gives both sides of a sheet one number, marked [`TWIN`], so that a ray that leaves one side meets neither.
fn join_twins(planes: &mut [u32], twins: &[u32], pieces: u32) {
    let mut joined = Disjoint::new(pieces as usize);
    for (i, &t) in twins.iter().enumerate().filter(|(_, t)| **t != NONE) {
        joined.join(planes[i], planes[t as usize]);
    }
    for (plane, _) in planes.iter_mut().zip(twins).filter(|(_, t)| **t != NONE) {
        *plane = joined.root(*plane) | TWIN;
    }
}

/// Groups triangles into planar pieces: grown over shared vertices from the first triangle, whose
/// plane every member must meet to 1e-6 of the scene and 1.4e-4 in angle, of one material, all of them
/// with a twin or none. Segments of flatland too short for that angle are granted their rounding.
fn planar_pieces(kept: &[Kept], twins: &[u32], scene: &Scene) -> Vec<u32> {
    let mut at: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
    let key = |v: [f32; 3]| v.map(|x| (x + 0.0).to_bits());
    for (i, k) in kept.iter().enumerate() {
        for v in &k.corners {
            at.entry(key(*v)).or_default().push(i as u32);
        }
    }
    let flatland = scene.is_flatland();
    let mut plane = vec![NONE; kept.len()];
    let mut pieces = 0;
    let mut stack = Vec::new();
    for i in 0..kept.len() {
        if plane[i] != NONE {
            continue;
        }
        let Kept { face, corners, normal, area } = kept[i];
        let material = scene.faces[face as usize].material;
        let origin = corners[0].map(f64::from);
        plane[i] = pieces;
        stack.push(i);
        while let Some(t) = stack.pop() {
            for v in kept[t].corners {
                for &o in &at[&key(v)] {
                    let other = &kept[o as usize];
                    // Rounding turns a short segment by this angle, and the line that it tells.
                    let turned = if flatland { 2e-7 / other.area.min(area) } else { 0.0 };
                    let level = other.corners.iter().all(|c| {
                        let off = sub(c.map(f64::from), origin);
                        dot(off, normal).abs() < 1e-6 + turned * dot(off, off).sqrt()
                    });
                    if plane[o as usize] == NONE
                        && (twins[o as usize] == NONE) == (twins[i] == NONE)
                        && scene.faces[other.face as usize].material == material
                        && dot(other.normal, normal) > 1.0 - 1e-8 - turned * turned
                        && level
                    {
                        plane[o as usize] = pieces;
                        stack.push(o as usize);
                    }
                }
            }
        }
        pieces += 1;
    }
    plane
}
