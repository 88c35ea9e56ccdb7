//! The scene as the passes see it: recentred and scaled in f64, then f32; hierarchy, planar pieces,
//! start tiles and emitters.

use super::{Lights, Map, Obstacle, Scene, Sky, atlas, cumulative, hierarchy, obstacle, sky};
use crate::disjoint::Disjoint;
use crate::effects::Name;
use crate::error::{Error, Result};
use crate::hash::NumberMap;
use crate::layout::{BvhNode, Emitter, Material, NONE, Point, TWIN, Tri};
use crate::network::groups::{self, Groups};
use crate::params::{Direct, Method, Mode, Norm, Params};
use crate::twin::direct::near2;
use crate::twin::texture::{self, EMIT, MASK, RECORD};
use glam::Vec3;
use std::collections::hash_map::Entry;
use std::sync::Arc;

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
    /// Whether anything may stand between two points that face each other; where nothing can, no shadow ray is cast.
    pub occludes: bool,
    /// Whether light that surfaces reflect is followed; not where that was asked off.
    pub interreflects: bool,
    /// Whether the scene has mirrors, which rays follow: their triangles tell of it ([`Tri::mirror`]).
    pub mirrors: bool,
    /// What the medium absorbs on a local length; 0: no medium.
    pub sigma: f32,
    /// Share of the light that arrives ([`crate::params::Norm`]); the reflectances in `materials` are multiplied by
    /// it, so that no pass need know.
    pub arrives: f64,
    /// Centre of the bounding box, world.
    pub center: [f64; 3],
    /// Power of two that brings the largest half extent into (0.5, 1].
    pub scale: f64,
    /// Power of two that brings the largest emission, or the light of the brightest source without a surface, into (0.5, 1];
    /// radiosities inside the passes are multiplied by it.
    pub emission_scale: f64,
    /// Hierarchy, root first.
    pub nodes: Vec<BvhNode>,
    /// Triangles in the order of the hierarchy's leaves.
    pub tris: Vec<Tri>,
    /// Index of each triangle in [`Scene::faces`].
    pub source: Vec<u32>,
    /// Area of each triangle, local, f64.
    pub areas: Vec<f64>,
    /// Materials; of those with maps the mean, which tells where to look.
    pub materials: Vec<Material>,
    /// Largest reflectance of each material, its maps' texels looked at one by one.
    pub most_rho: Vec<f32>,
    /// Maps of all triangles, six texels each, and their images ([`crate::twin::texture`]); empty where there are none.
    pub texels: Vec<[u32; 4]>,
    /// Where the images of reflectance end.
    pub rho_end: usize,
    /// Whether reflectance or emission varies over any triangle.
    pub textured: bool,
    /// Whether anything is cut out of any triangle.
    pub cut: bool,
    /// Whether all maps of reflectance and emission are grey.
    pub grey_maps: bool,
    /// Emitting triangles with their cumulative distribution; empty where nothing emits.
    pub emitters: Vec<Emitter>,
    /// Mean emission of each emitter over its area; empty where that is its material's.
    pub emitted: Vec<[f64; 3]>,
    /// Sampling density of an emitter per unit of its summed emission, per local area.
    pub emitter_density: f32,
    /// Light from where no surface is.
    pub sky: Sky,
    /// Lights without a surface.
    pub lights: Lights,
    /// Number of tiles.
    pub tiles: u32,
    /// Triangle of each tile.
    pub tile_tri: Vec<u32>,
    /// Tiles that share lists of nodes, where there are many.
    pub groups: Option<Arc<Groups>>,
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

/// The power of two that brings `x > 0` into (0.5, 1]; of those that have an inverse the nearest.
pub(crate) fn power_of_two_for(x: f64) -> f64 {
    const MOST: i32 = 1000;
    let mut e = (-(x.log2().ceil() as i32)).clamp(-MOST, MOST);
    // log2 may round at the interval's ends.
    while x * 2f64.powi(e) > 1.0 && e > -MOST {
        e -= 1;
    }
    while x * 2f64.powi(e) <= 0.5 && e < MOST {
        e += 1;
    }
    2f64.powi(e)
}

/// Twice the area vector of a triangle, or where a segment's left lies, as long as the segment.
fn double_normal(flatland: bool, [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let way = sub(b, a);
    if flatland { [-way[1], way[0], 0.0] } else { cross(way, sub(c, a)) }
}

/// Whether a face is thinner than rounding of its coordinates: neither its normal nor its area means anything.
fn is_thin(corners: [[f64; 3]; 3], double_area: f64) -> bool {
    let longest = [(0, 1), (1, 2), (2, 0)]
        .map(|(a, b)| {
            let e = sub(corners[b], corners[a]);
            dot(e, e)
        })
        .into_iter()
        .fold(0.0, f64::max);
    double_area <= longest * 1e-9
}

/// Centre of the faces that have an area, and the power of two that brings half the longest side of their box into
/// (0.5, 1], in f64; none where there are none.
pub(super) fn frame(scene: &Scene) -> Option<([f64; 3], f64)> {
    let flatland = scene.is_flatland();
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for i in 0..scene.faces.len() {
        let corners = scene.corners(i);
        let normal = double_normal(flatland, corners);
        if is_thin(corners, dot(normal, normal).sqrt()) {
            continue;
        }
        for v in corners {
            for k in 0..3 {
                low[k] = low[k].min(v[k]);
                high[k] = high[k].max(v[k]);
            }
        }
    }
    let center = [0, 1, 2].map(|k| 0.5 * low[k] + 0.5 * high[k]);
    let half = (0..3).map(|k| high[k] - center[k]).fold(0.0, f64::max);
    (half > 0.0 && half.is_finite()).then(|| (center, power_of_two_for(half)))
}

impl Geometry {
    /// As [`Geometry::new`], for a bake with these parameters.
    ///
    /// Errors: also [`Error::InvalidParam`] for a norm that the scene's space does not have, for light without a surface that
    /// would have to go through the network, and for a method or mode that knows no mirrors where there are some.
    pub fn for_bake(scene: &Scene, params: &Params) -> Result<Geometry> {
        let mut geometry = Geometry::new(scene)?;
        if params.norm == Norm::Paper1997 && !geometry.flatland {
            let range = "it is for flatland scenes: in three dimensions the paper's kernel has the norm of lambert";
            return Err(Error::InvalidParam { name: "norm", value: "paper1997".into(), range });
        }
        if params.direct == Direct::Network && geometry.is_surfaceless() {
            let range = "lights without a surface, and the sky, are no end of a ray that the network could learn: bake with --direct exact";
            return Err(Error::InvalidParam { name: "direct", value: "network".into(), range });
        }
        let patches = matches!(params.method, Method::Fem | Method::Hierarchical);
        if geometry.mirrors && (patches || params.mode == Mode::Paper) {
            let range = "it knows no mirrors: evaluations of a kernel between two points find no way over one; bake with --method \
                         network or rays in --mode flux, or make the mirrors diffuse";
            let (name, value) =
                if patches { ("method", format!("{:?}", params.method)) } else { ("mode", format!("{:?}", params.mode)) };
            return Err(Error::InvalidParam { name, value: value.to_lowercase(), range });
        }
        geometry.arrives = params.norm.share();
        if params.norm != Norm::Lambert {
            let less = |rho: f32| (rho as f64 * geometry.arrives) as f32;
            for m in &mut geometry.materials {
                m.rho = m.rho.map(less);
            }
            geometry.most_rho.iter_mut().for_each(|rho| *rho = less(*rho));
            let first = RECORD * geometry.tris.len();
            for texel in geometry.texels.get_mut(first..geometry.rho_end).unwrap_or_default() {
                *texel = texel.map(|x| less(f32::from_bits(x)).to_bits());
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

        let flatland = scene.is_flatland();
        let (center, scale) = frame(scene).ok_or_else(empty)?;
        let local = |v: &[f64; 3]| [0, 1, 2].map(|k| (v[k] - center[k]) * scale);
        let locals: Vec<[f32; 3]> = scene.vertices.iter().map(|v| local(v).map(|x| x as f32)).collect();
        let places = places(&locals);

        // Keep triangles that have an area after the cast, each once.
        let mut kept: Vec<Kept> = Vec::new();
        let (mut degenerate, mut duplicate) = (Vec::new(), Vec::new());
        let mut seen: NumberMap<[u32; 3], u32> = NumberMap::default();
        seen.reserve(scene.faces.len());
        for (i, face) in scene.faces.iter().enumerate() {
            let exact = face.vertices.map(|v| local(&scene.vertices[v as usize]));
            let corners = face.vertices.map(|v| locals[v as usize]);
            let c = corners.map(|v| v.map(f64::from));
            let normal = double_normal(flatland, c);
            let double_area = dot(normal, normal).sqrt();
            let plane = double_normal(flatland, exact);
            let exact_area = dot(plane, plane).sqrt();
            if is_thin(exact, exact_area) || is_thin(c, double_area) || double_area < 1e-30 {
                degenerate.push(i as u32);
                continue;
            }
            let ends = face.vertices.map(|v| places[v as usize]);
            match seen.entry(wound(ends)) {
                Entry::Occupied(first) => {
                    duplicate.push([i as u32, kept[*first.get() as usize].face]);
                    continue;
                }
                Entry::Vacant(free) => free.insert(kept.len() as u32),
            };
            let area = if flatland { double_area } else { 0.5 * double_area };
            let (normal, plane) = (normal.map(|x| x / double_area), plane.map(|x| x / exact_area));
            kept.push(Kept { face: i as u32, corners, ends, exact, normal, plane, area });
        }
        if kept.is_empty() {
            return Err(empty());
        }

        // Build the hierarchy and lay triangles out in its leaf order.
        let boxes: Vec<Bounds> = kept.iter().map(|k| Bounds { corners: k.corners, flatland }).collect();
        let (nodes, order) = hierarchy::build(&boxes);

        // Materials, with the emission brought near 1.
        let most_of = |map: Option<Map>| map.map_or([1.0f32; 3], |m| scene.textures[m.texture as usize].most());
        let shining = |m: &crate::scene::Material| {
            let texel = most_of(m.emission_map);
            [0, 1, 2].map(|k| m.emission[k] * f64::from(texel[k]))
        };
        let brightest = scene.materials.iter().flat_map(shining).fold(0.0, f64::max) * std::f64::consts::PI;
        let brightest = brightest.max(sky::radiosity(scene, scale));
        let emission_scale = if brightest > 0.0 { power_of_two_for(brightest) } else { 1.0 };
        let materials: Vec<Material> = scene
            .materials
            .iter()
            .map(|m| Material {
                rho: match m.mirror > 0.0 {
                    true => [0.0; 3],
                    false => atlas::mean(m.reflectance, m.reflectance_map, &scene.textures).map(|x| x as f32),
                },
                emit: atlas::mean(m.emission, m.emission_map, &scene.textures)
                    .map(|x| (x * std::f64::consts::PI * emission_scale) as f32),
                ..Material::default()
            })
            .collect();
        let most_rho = (scene.materials.iter().zip(&materials))
            .map(|(m, mean)| match mean.rho {
                // Also of mirrors.
                [0.0, 0.0, 0.0] => 0.0,
                _ => (0..3).fold(0.0, |a: f32, k| a.max(m.reflectance[k] as f32 * most_of(m.reflectance_map)[k])),
            })
            .collect();
        let live = |m: u32| {
            let m = &materials[m as usize];
            m.rho.iter().chain(&m.emit).any(|&x| x > 0.0)
        };

        // Number planar pieces, cut live area into tiles.
        let twins = twins(flatland, &kept, &seen);
        drop(seen);
        let mut planes = planar_pieces(&kept, &twins, places, scene);
        let pieces = planes.iter().max().map_or(0, |&m| m + 1);
        join_twins(&mut planes, &twins, pieces);
        let material_of = |i: usize| scene.faces[kept[i].face as usize].material;
        let area: f64 = (0..kept.len()).filter(|&i| live(material_of(i))).map(|i| kept[i].area).sum();
        let total: f64 = kept.iter().map(|k| k.area).sum();
        let tile_area = area.max(1e-3 * total) / TILES;
        let (mut tris, mut source, mut areas, mut tile_tri) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for &i in &order {
            let Kept { face, corners, normal, area: tri_area, .. } = kept[i];
            let material = material_of(i);
            // Below what 32-bit floats hold with all digits a mirror is black.
            let mirror = Some(scene.materials[material as usize].mirror as f32).filter(|m| m.is_normal());
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
                split: mirror.map_or(split, f32::to_bits),
            });
            source.push(face);
            areas.push(tri_area);
        }

        let atlas = atlas::pack(scene, &tris, &source, &areas, area.max(1e-3 * total), emission_scale)?;
        let lit = area.max(1e-3 * total);
        let mut geometry = Geometry {
            flatland,
            occludes: scene.effects.asked(Name::Occlusion).unwrap_or_else(|| obstacle(scene) != Obstacle::None),
            interreflects: scene.effects.asked(Name::Interreflection).unwrap_or(true),
            mirrors: tris.iter().any(|t| t.mirror() > 0.0),
            sigma: (scene.absorption / scale) as f32,
            arrives: 1.0,
            center,
            scale,
            emission_scale,
            nodes,
            tris,
            source,
            areas,
            materials,
            most_rho,
            texels: atlas.texels,
            rho_end: atlas.rho_end,
            textured: atlas.textured,
            cut: atlas.cut,
            grey_maps: scene.has_grey_maps(),
            emitters: Vec::new(),
            emitted: Vec::new(),
            emitter_density: 0.0,
            sky: Sky::new(scene.environment.as_ref(), emission_scale),
            lights: Lights::new(&scene.lights, center, scale, emission_scale),
            tiles: tile_tri.len() as u32,
            tile_tri,
            groups: None,
            area,
            unit: if flatland { lit / 4.0 } else { (lit / 6.0).sqrt() },
            pieces,
            degenerate,
            duplicate,
        };
        geometry.groups = groups::groups(&geometry).map(Arc::new);
        geometry.find_emitters();
        Ok(geometry)
    }

    /// Finds the emitters. They are picked by power; a triangle's density is its share over its area.
    fn find_emitters(&mut self) {
        let (tris, areas) = (&self.tris, &self.areas);
        let varied = |t: usize| texture::has(self, t as u32, EMIT) || texture::has(self, t as u32, MASK);
        let means: NumberMap<u32, [f64; 3]> = (0..tris.len())
            .filter(|&t| varied(t) && self.material_of(t).emit != [0.0; 3])
            .map(|t| (t as u32, texture::mean_emission(self, t as u32)))
            .collect();
        let power = |t: usize| match means.get(&(t as u32)) {
            Some(mean) => areas[t] * mean.iter().sum::<f64>(),
            None => {
                let e = self.material_of(t).emit;
                areas[t] * (e[0] + e[1] + e[2]) as f64
            }
        };
        let shining: Vec<usize> = (0..tris.len()).filter(|&t| power(t) > 0.0).collect();
        let powers: Vec<f64> = shining.iter().map(|&t| power(t)).collect();
        let all: f64 = powers.iter().sum();
        let emitters = cumulative(&powers)
            .into_iter()
            .zip(&shining)
            .zip(&powers)
            .map(|((cdf, &t), p)| {
                let density = p / all / areas[t];
                let corner = |v: [f32; 3]| (Vec3::from(v) - Vec3::from(tris[t].v0)).length() as f64;
                let longest = corner(tris[t].v1).max(corner(tris[t].v2));
                Emitter { tri: t as u32, cdf, density: density as f32, near2: near2(self.flatland, longest, density) }
            })
            .collect();
        let mean = |&t: &usize| means.get(&(t as u32)).copied().unwrap_or(self.material_of(t).emit.map(f64::from));
        let emitted = if means.is_empty() { Vec::new() } else { shining.iter().map(mean).collect() };
        let density = if all > 0.0 { (1.0 / all) as f32 } else { 0.0 };
        (self.emitters, self.emitted, self.emitter_density) = (emitters, emitted, density);
    }

    /// Mean emission of a triangle over all of its area, scaled; what is cut out of it is dark.
    pub fn mean_emission(&self, tri: usize) -> [f64; 3] {
        if self.emitted.is_empty() {
            return self.material_of(tri).emit.map(f64::from);
        }
        let found = self.emitters.binary_search_by_key(&(tri as u32), |e| e.tri);
        found.map_or([0.0; 3], |e| self.emitted[e])
    }

    /// Reflectance and emitted radiance of a triangle at a place, as a read-out shows them: with the scene's own texels.
    pub(crate) fn shown(&self, scene: &Scene, tri: u32, p: Vec3) -> ([f64; 3], [f64; 3]) {
        let m = &scene.materials[self.tris[tri as usize].material as usize];
        if m.reflectance_map.is_none() && m.emission_map.is_none() {
            return (m.reflectance, m.emission);
        }
        let (b1, b2) = texture::shares(self.flatland, &self.tris[tri as usize], p);
        scene.shown(self.source[tri as usize] as usize, b1.into(), b2.into())
    }

    /// Whether a surface point is there: not cut out.
    pub fn is_there(&self, point: &Point) -> bool {
        if !self.cut {
            return true;
        }
        let (b1, b2) = texture::shares(self.flatland, &self.tris[point.tri as usize], Vec3::from(point.p));
        texture::is_there(self, point.tri, b1, b2)
    }

    /// Area of a tile, local.
    pub fn tile_area(&self, tile: usize) -> f64 {
        let t = self.tile_tri[tile] as usize;
        let split = self.tris[t].cuts() as f64;
        self.areas[t] / if self.flatland { split } else { split.powi(2) }
    }

    /// The distance between neighbours where `count` points share the live area evenly, local.
    pub fn spacing(&self, count: usize) -> f64 {
        let share = self.area / count.max(1) as f64;
        if self.flatland { share } else { share.sqrt() }
    }

    /// How many lists of nodes there are: one each tile, or group of tiles.
    pub fn lists(&self) -> usize {
        self.groups.as_ref().map_or(self.tiles as usize, |groups| groups.len())
    }

    /// Whether a triangle reflects or emits.
    pub fn is_live(&self, tri: usize) -> bool {
        let m = self.material_of(tri);
        m.rho.iter().chain(&m.emit).any(|&x| x > 0.0)
    }

    /// Whether light comes from what has no surface: lights, the sky.
    pub fn is_surfaceless(&self) -> bool {
        !(self.sky.is_empty() && self.lights.is_empty())
    }

    /// Whether there is light at all.
    pub fn shines(&self) -> bool {
        !self.emitters.is_empty() || self.is_surfaceless()
    }

    /// Whether light is lost on its way: at mirrors, or to the medium. A ray's points then hold what of it arrives.
    pub fn is_lossy(&self) -> bool {
        self.mirrors || self.sigma > 0.0
    }

    /// The share of what a shot ray's end sends that arrives at its start.
    pub fn arriving(&self, hit: &Point) -> f64 {
        if self.is_lossy() { hit.density.into() } else { 1.0 }
    }

    /// Whether anything reflects light diffusely, and there is some: where not, all light is direct.
    pub fn reflects(&self) -> bool {
        let rho = |t: usize| self.material_of(t).rho;
        self.interreflects && self.shines() && (0..self.tris.len()).any(|t| rho(t) != [0.0; 3])
    }

    /// Of which materials errors are measured: those that reflect and do not shine, whose light is found and not given.
    /// Where all that reflect shine too, they are.
    pub fn judged(&self) -> impl Fn(&Material) -> bool + use<> {
        let reflects = |m: &Material| m.rho != [0.0; 3];
        let dark = |m: &Material| m.emit == [0.0; 3];
        let any = (0..self.tris.len()).any(|t| reflects(self.material_of(t)) && dark(self.material_of(t)));
        move |m| reflects(m) && (dark(m) || !any)
    }

    /// The power of all emitters over the area, scaled W/m², mean over the bands.
    pub fn power_density(&self) -> f64 {
        let power = |e: &Emitter| self.areas[e.tri as usize] * self.mean_emission(e.tri as usize).iter().sum::<f64>() / 3.0;
        self.emitters.iter().map(power).sum::<f64>() / self.area
    }

    /// The material of a triangle.
    pub fn material_of(&self, tri: usize) -> &Material {
        &self.materials[self.tris[tri].material as usize]
    }

    /// What a surface reflects and emits at a point.
    pub fn material_at(&self, point: &Point) -> Material {
        let m = *self.material_of(point.tri as usize);
        if !self.textured {
            return m;
        }
        let (b1, b2) = texture::shares(self.flatland, &self.tris[point.tri as usize], Vec3::from(point.p));
        let [rho, emit] = [texture::rho, texture::emit].map(|of| of(self, point.tri, b1, b2).to_array());
        Material { rho, emit, ..m }
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
    /// Where the corners are, by number: see [`places`].
    ends: [u32; 3],
    /// The corners before the cast.
    exact: [[f64; 3]; 3],
    normal: [f64; 3],
    /// The normal before the cast, which tells planes apart.
    plane: [f64; 3],
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

/// A number for each vertex's place: vertices of one place have one.
fn places(vertices: &[[f32; 3]]) -> Vec<u32> {
    let mut at: NumberMap<[u32; 3], u32> = NumberMap::default();
    at.reserve(vertices.len());
    // Adding 0 makes both zeros one.
    vertices.iter().enumerate().map(|(i, v)| *at.entry(v.map(|x| (x + 0.0).to_bits())).or_insert(i as u32)).collect()
}

/// Corners by which a triangle is known again. The same corners wound the other way are another surface:
/// they are rotated, not sorted.
fn wound(mut ends: [u32; 3]) -> [u32; 3] {
    let first = (0..3).min_by_key(|&k| ends[k]).unwrap_or(0);
    ends.rotate_left(first);
    ends
}

/// For each triangle the one with the same corners and opposite winding, or [`NONE`]. `seen` tells the triangle of
/// each three corners.
fn twins(flatland: bool, kept: &[Kept], seen: &NumberMap<[u32; 3], u32>) -> Vec<u32> {
    let twin = |k: &Kept| {
        let [a, b, c] = k.ends;
        seen.get(&wound(if flatland { [b, a, a] } else { [a, c, b] })).copied()
    };
    kept.iter().map(|k| twin(k).unwrap_or(NONE)).collect()
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

/// Groups triangles into planar pieces, by their corners before the cast (hard case A10): grown over shared vertices from the first triangle, whose
/// plane every member must meet to 1e-6 of the scene and 1.4e-4 in angle, of one material, all of them
/// with a twin or none. Segments of flatland too short for that angle are granted their rounding.
fn planar_pieces(kept: &[Kept], twins: &[u32], places: Vec<u32>, scene: &Scene) -> Vec<u32> {
    // The triangles around each place, one list after the other.
    let mut starts = vec![0u32; places.len() + 1];
    for end in kept.iter().flat_map(|k| k.ends) {
        starts[end as usize + 1] += 1;
    }
    for i in 0..places.len() {
        starts[i + 1] += starts[i];
    }
    let (mut around, mut next) = (vec![0u32; 3 * kept.len()], places);
    next.copy_from_slice(&starts[..starts.len() - 1]);
    for (i, k) in kept.iter().enumerate() {
        for end in k.ends {
            around[next[end as usize] as usize] = i as u32;
            next[end as usize] += 1;
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
        let Kept { face, exact, plane: normal, area, .. } = kept[i];
        let material = scene.faces[face as usize].material;
        let origin = exact[0];
        plane[i] = pieces;
        stack.push(i);
        while let Some(t) = stack.pop() {
            for end in kept[t].ends {
                for &o in &around[starts[end as usize] as usize..starts[end as usize + 1] as usize] {
                    if plane[o as usize] != NONE {
                        continue;
                    }
                    let other = &kept[o as usize];
                    // Rounding turns a short segment by this angle, and the line that it tells.
                    let turned = if flatland { 2e-7 / other.area.min(area) } else { 0.0 };
                    let level = other.exact.iter().all(|&c| {
                        let off = sub(c, origin);
                        dot(off, normal).abs() < 1e-6 + turned * dot(off, off).sqrt()
                    });
                    if (twins[o as usize] == NONE) == (twins[i] == NONE)
                        && scene.faces[other.face as usize].material == material
                        && dot(other.plane, normal) > 1.0 - 1e-8 - turned * turned
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
