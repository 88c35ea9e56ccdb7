//! What is to be lit: triangles, materials, and their preparation for the passes. No wgpu here.

mod atlas;
mod called;
mod convex;
mod distribution;
mod extruded;
mod geometry;
mod gltf;
mod hierarchy;
mod images;
mod light;
mod load;
mod mtl;
mod obj;
mod polygon;
#[doc(hidden)]
pub mod shapes;
mod sides;
mod sky;
mod sky_map;
mod surface;
mod text;
mod texture;
mod toml;
mod transform;
mod unread;

#[doc(hidden)]
pub use called::Called;
pub(crate) use convex::{Obstacle, obstacle};
#[doc(hidden)]
pub use distribution::cumulative;
pub(crate) use extruded::wall;
#[doc(hidden)]
pub use geometry::Geometry;
pub(crate) use geometry::{TILES, power_of_two_for};
pub(crate) use hierarchy::depth;
pub use light::{Environment, Light, LightKind, SUN_ANGLE};
pub use load::{KdSpace, LoadOptions, Up};
#[doc(hidden)]
pub use sky::{Lights, Sky};
pub use sky_map::SkyMap;
#[doc(hidden)]
pub use surface::Located;
pub(crate) use surface::nearest_on_triangle;
pub use texture::{Map, Texels, Texture};

use crate::effects::Switches;
use crate::error::{Error, Result};
use crate::solution::Camera;

/// A diffuse material, or an ideal mirror, in user units, linear Rec.709 RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, for messages.
    pub name: String,
    /// Diffuse reflectance rho (MTL `Kd`), each band in [0, 1); with a map what its texels are multiplied by.
    pub reflectance: [f64; 3],
    /// Emitted **radiance** (MTL `Ke`), W/m²/sr; the emitted radiosity is pi times it. With a map what its texels are
    /// multiplied by.
    pub emission: [f64; 3],
    /// Reflectance of an ideal mirror, grey, in [0, 1); 0: no mirror. A mirror reflects nothing diffusely: beside it
    /// `reflectance` and its map do not count; and it does not shine.
    pub mirror: f64,
    /// What multiplies the reflectance over the surface (MTL `map_Kd`); every product is in [0, 1).
    pub reflectance_map: Option<Map>,
    /// What multiplies the emission over the surface (MTL `map_Ke`).
    pub emission_map: Option<Map>,
    /// What is cut out (MTL `map_d`): the surface is there where the alpha of the nearest texel is at least the cutoff.
    pub alpha_map: Option<Map>,
    /// Alpha from which on a surface with an alpha map is there.
    pub alpha_cutoff: f64,
}

impl Default for Material {
    /// Black, dark and whole.
    fn default() -> Material {
        Material::new("", [0.0; 3], [0.0; 3])
    }
}

impl Material {
    /// A diffuse material.
    pub fn new(name: &str, reflectance: [f64; 3], emission: [f64; 3]) -> Material {
        let (reflectance_map, emission_map, alpha_map) = (None, None, None);
        let (mirror, alpha_cutoff) = (0.0, texture::CUTOFF);
        Material { name: name.into(), reflectance, emission, mirror, reflectance_map, emission_map, alpha_map, alpha_cutoff }
    }

    /// An ideal mirror.
    pub fn new_mirror(name: &str, reflectance: f64) -> Material {
        Material { mirror: reflectance, ..Material::new(name, [0.0; 3], [0.0; 3]) }
    }

    /// Checks that it can be lit: reflectances in [0, 1), emissions >= 0 that 32-bit floats hold, no mirror that shines. Of a
    /// material with maps [`Scene::check`] knows more.
    ///
    /// Errors: [`Error::InvalidReflectance`], [`Error::InvalidEmission`], [`Error::InvalidMirror`].
    pub fn check(&self) -> Result<()> {
        // What its texels come to is not known here.
        let most = |map: Option<Map>| if map.is_some() { [0.0; 3] } else { [1.0; 3] };
        self.check_at("in memory", most(self.reflectance_map), most(self.emission_map))
    }

    /// `rho` and `shine` are the largest texels of the maps, 1 where there is none.
    fn check_at(&self, place: &str, rho: [f64; 3], shine: [f64; 3]) -> Result<()> {
        for (k, band) in ["red", "green", "blue"].into_iter().enumerate() {
            let (place, material) = (place.to_string(), self.name.clone());
            // Also as the passes see it: 1 - 1e-9 is 1 in 32 bits.
            let value = self.reflectance[k] * rho[k];
            if !((0.0..1.0).contains(&value) && (value as f32) < 1.0 && self.reflectance[k] >= 0.0) {
                return Err(Error::InvalidReflectance { place, material, band, value });
            }
            let value = self.emission[k] * shine[k];
            if !((0.0..=f64::from(f32::MAX)).contains(&value) && self.emission[k] >= 0.0) {
                return Err(Error::InvalidEmission { place, material, band, value });
            }
        }
        let refuse = |what: String| Err(Error::InvalidMirror { place: place.into(), material: self.name.clone(), what });
        if !((0.0..1.0).contains(&self.mirror) && (self.mirror as f32) < 1.0) {
            return refuse(format!("a mirror of reflectance {} is not in [0, 1)", self.mirror));
        }
        if self.mirror > 0.0 && self.emission != [0.0; 3] {
            return refuse("it is a mirror and shines".into());
        }
        Ok(())
    }

    /// Its maps: of reflectance, emission and alpha.
    pub(crate) fn maps(&self) -> [Option<Map>; 3] {
        [self.reflectance_map, self.emission_map, self.alpha_map]
    }
}

/// The space that a scene lies in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Space {
    /// Triangles in three dimensions.
    #[default]
    Solid,
    /// Segments in the plane z = 0. Irradiance and radiosity are W/m, powers W, along lines of a world that has no
    /// third dimension; the kernel is cos cos / (2 r) (Heckbert, "Radiosity in Flatland", 1992).
    Flatland {
        /// How high pictures and meshes draw the segments' walls, metres.
        height: f64,
    },
}

/// Whether a place is one that 32-bit floats hold: files are written in them, and what is beyond is a mistake. Its areas
/// and volumes are then finite, too.
pub(crate) fn fits(place: &[f64; 3]) -> bool {
    place.iter().all(|&x| (x as f32).is_finite())
}

/// A triangle of a scene: vertex indices, material and object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// Indices into [`Scene::vertices`], counter-clockwise seen from the front. A flatland segment from a to b is
    /// [a, b, b]; its front is on the left of the way from a to b, seen from +z.
    pub vertices: [u32; 3],
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::objects`].
    pub object: u32,
}

/// A camera of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Its name in the file.
    pub name: String,
    /// The camera, metres.
    pub camera: Camera,
}

/// A scene as its author wrote it: metres, f64, one-sided triangles, or segments in [`Space::Flatland`].
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name or path, for messages and reports.
    pub name: String,
    /// The space it lies in.
    pub space: Space,
    /// Vertex positions, metres.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles.
    pub faces: Vec<Face>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Images that materials name in their maps.
    pub textures: Vec<Texture>,
    /// Texture coordinates: u to the right, v down from an image's upper left corner; an image repeats at whole numbers.
    pub uvs: Vec<[f64; 2]>,
    /// Indices into [`Scene::uvs`] of each face's corners, in the order of [`Scene::faces`]. A face beyond its end, or with
    /// an index of `u32::MAX`, has none: there maps stand for their mean, and nothing is cut out.
    pub face_uvs: Vec<[u32; 3]>,
    /// Object names, for messages.
    pub objects: Vec<String>,
    /// File and line of each material, for messages; empty where the scene does not come from files.
    pub material_places: Vec<String>,
    /// Cameras the file holds, in its order.
    pub cameras: Vec<View>,
    /// Effects that were switched by hand ([`Switches::apply`]).
    pub effects: Switches,
    /// Lights without a surface.
    pub lights: Vec<Light>,
    /// What is around; nothing is black.
    pub environment: Option<Environment>,
    /// What a homogeneous medium that fills the scene's bounding box absorbs on a metre, 1/m: light of a way of r metres
    /// is left with exp(-absorption r). 0: no medium.
    pub absorption: f64,
    /// What was odd on reading, in words for the user.
    pub warnings: Vec<String>,
}

impl Scene {
    /// A scene from triangles in memory: three corners (metres) and a material index each.
    ///
    /// Errors: those of [`Scene::check`].
    pub fn from_triangles(name: &str, triangles: &[([[f64; 3]; 3], u32)], materials: Vec<Material>) -> Result<Scene> {
        let mut scene = Scene { name: name.into(), materials, objects: vec![name.into()], ..Scene::default() };
        for (corners, material) in triangles {
            let first = scene.vertices.len() as u32;
            scene.vertices.extend_from_slice(corners);
            scene.faces.push(Face { vertices: [first, first + 1, first + 2], material: *material, object: 0 });
        }
        scene.check()?;
        Ok(scene)
    }

    /// A flatland scene from segments in memory: two ends (metres; the front is on the left of the way from the
    /// first to the second) and a material index each. Walls are half its longest side high.
    ///
    /// Errors: those of [`Scene::check`].
    pub fn from_segments(name: &str, segments: &[([[f64; 2]; 2], u32)], materials: Vec<Material>) -> Result<Scene> {
        let mut scene = Scene { name: name.into(), materials, objects: vec![name.into()], ..Scene::default() };
        for ([a, b], material) in segments {
            let first = scene.vertices.len() as u32;
            scene.vertices.extend([[a[0], a[1], 0.0], [b[0], b[1], 0.0]]);
            scene.faces.push(Face { vertices: [first, first + 1, first + 1], material: *material, object: 0 });
        }
        scene.space = Space::Flatland { height: scene.wall_height() };
        scene.check()?;
        Ok(scene)
    }

    /// Whether the scene lies in flatland.
    pub fn is_flatland(&self) -> bool {
        matches!(self.space, Space::Flatland { .. })
    }

    /// Half the longest side of the bounding box: how high walls are where nobody says.
    pub(crate) fn wall_height(&self) -> f64 {
        let side = |k: usize| {
            let (low, high) = self.vertices.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v[k]), h.max(v[k])));
            (high - low).max(0.0)
        };
        0.5 * side(0).max(side(1))
    }

    /// Checks that the scene can be lit: vertices and emissions that 32-bit floats hold, indices in range, reflectances
    /// in [0, 1), emissions >= 0, an absorption >= 0.
    ///
    /// Errors: [`Error::EmptyScene`], [`Error::InvalidVertex`], [`Error::IndexOutOfRange`], [`Error::InvalidReflectance`],
    /// [`Error::InvalidEmission`], [`Error::InvalidMirror`], [`Error::InvalidLight`]; [`Error::InvalidParam`] for the medium's
    /// absorption; [`Error::NotFlat`] for a flatland scene whose faces are no segments in the plane z = 0.
    pub fn check(&self) -> Result<()> {
        if self.faces.is_empty() {
            return Err(Error::EmptyScene { scene: self.name.clone() });
        }
        for (index, &value) in self.vertices.iter().enumerate() {
            if !fits(&value) {
                return Err(Error::InvalidVertex { place: self.name.clone(), index, value });
            }
        }
        for (i, face) in self.faces.iter().enumerate() {
            for &v in &face.vertices {
                if v as usize >= self.vertices.len() {
                    return Err(Error::IndexOutOfRange {
                        place: format!("{}: triangle {i}", self.name),
                        index: v as i64,
                        count: self.vertices.len(),
                    });
                }
            }
            let [_, b, c] = self.corners(i);
            if self.is_flatland() && (b != c || self.corners(i).iter().any(|v| v[2] != 0.0)) {
                return Err(Error::NotFlat { place: self.name.clone(), face: i });
            }
            if face.material as usize >= self.materials.len() {
                return Err(Error::IndexOutOfRange {
                    place: format!("{}: triangle {i}, material", self.name),
                    index: face.material as i64,
                    count: self.materials.len(),
                });
            }
        }
        light::check(&self.lights, self.environment.as_ref(), self.is_flatland())?;
        if !(0.0..=f64::from(f32::MAX)).contains(&self.absorption) {
            let range = "the medium takes a share of light on each metre: give 1/m, 0 or more";
            return Err(Error::InvalidParam { name: "absorption", value: self.absorption.to_string(), range });
        }
        self.textures.iter().try_for_each(Texture::check)?;
        self.check_uvs()?;
        let most: Vec<[f64; 3]> = self.textures.iter().map(|t| t.most().map(f64::from)).collect();
        (0..self.materials.len()).try_for_each(|m| self.check_material_of(m, &most))
    }

    /// Coordinates that a map looks at.
    fn check_uvs(&self) -> Result<()> {
        let mapped = |face: usize| {
            let material = self.faces.get(face).and_then(|f| self.materials.get(f.material as usize));
            material.is_some_and(|m| m.maps().iter().any(Option::is_some))
        };
        for (i, corners) in self.face_uvs.iter().enumerate().filter(|(i, _)| mapped(*i)) {
            for &corner in corners.iter().filter(|&&c| c != crate::layout::NONE) {
                let place = || format!("{}: triangle {i}, texture coordinate", self.name);
                match self.uvs.get(corner as usize) {
                    Some(uv) => texture::check_uv(uv, || format!("{} {corner}", place()))?,
                    None => return Err(Error::IndexOutOfRange { place: place(), index: corner.into(), count: self.uvs.len() }),
                }
            }
        }
        Ok(())
    }

    /// As [`Material::check`], of a material of this scene with its maps; the error names the file and line it comes from.
    ///
    /// Errors: also [`Error::InvalidTexture`] for a map that names no texture or stretches it beyond all measure.
    pub fn check_material(&self, material: usize) -> Result<()> {
        let most: Vec<[f64; 3]> = self.textures.iter().map(|t| t.most().map(f64::from)).collect();
        self.check_material_of(material, &most)
    }

    /// `most` are the textures' largest texels.
    fn check_material_of(&self, material: usize, most: &[[f64; 3]]) -> Result<()> {
        let m = &self.materials[material];
        let place = self.material_places.get(material).unwrap_or(&self.name);
        for map in m.maps().into_iter().flatten() {
            let fail =
                |what: String, cure| Err(Error::InvalidTexture { place: format!("{place}: material '{}'", m.name), what, cure });
            if map.texture as usize >= self.textures.len() {
                let what = format!("has a map of texture {} where there are {}", map.texture, self.textures.len());
                return fail(what, "add the texture to the scene");
            }
            if !map.transform.iter().flatten().all(|x| x.abs() <= texture::MOST_REPEATS) {
                return fail(format!("scales or moves a map by {:?}", map.transform), "stay within 65536 repeats");
            }
        }
        let most = |map: Option<Map>| map.map_or([1.0; 3], |m| most[m.texture as usize]);
        m.check_at(place, most(m.reflectance_map), most(m.emission_map))
    }

    /// Whether every map of reflectance or emission is grey.
    pub(crate) fn has_grey_maps(&self) -> bool {
        let mut used = vec![false; self.textures.len()];
        for map in self.materials.iter().flat_map(|m| [m.reflectance_map, m.emission_map]).flatten() {
            if let Some(used) = used.get_mut(map.texture as usize) {
                *used = true;
            }
        }
        self.textures.iter().zip(used).all(|(t, used)| !used || t.is_grey())
    }

    /// Takes all maps of reflectance and emission for their means.
    pub(crate) fn flatten_maps(&mut self) {
        for m in &mut self.materials {
            m.reflectance = atlas::mean(m.reflectance, m.reflectance_map.take(), &self.textures);
            m.emission = atlas::mean(m.emission, m.emission_map.take(), &self.textures);
        }
    }

    /// Texture coordinates of a face's corners; none where it has none.
    pub fn uv(&self, face: usize) -> Option<[[f64; 2]; 3]> {
        let corners = self.face_uvs.get(face).filter(|c| c.iter().all(|&i| (i as usize) < self.uvs.len()))?;
        Some(corners.map(|i| self.uvs[i as usize]))
    }

    /// Gives the last of the faces its texture coordinates.
    pub(crate) fn set_uv(&mut self, face: usize, corners: [u32; 3]) {
        self.face_uvs.resize(self.face_uvs.len().max(face), [crate::layout::NONE; 3]);
        match self.face_uvs.get_mut(face) {
            Some(known) => *known = corners,
            None => self.face_uvs.push(corners),
        }
    }

    /// Reflectance and emitted radiance of a face at barycentric coordinates, texels in between.
    pub(crate) fn shown(&self, face: usize, b1: f64, b2: f64) -> ([f64; 3], [f64; 3]) {
        let m = &self.materials[self.faces[face].material as usize];
        let uv = self.uv(face);
        let of = |factor: [f64; 3], map: Option<Map>| match (map, uv) {
            (None, _) => factor,
            (Some(map), Some([a, b, c])) => {
                let at = [0, 1].map(|k| a[k] + (b[k] - a[k]) * b1 + (c[k] - a[k]) * b2);
                let texel = self.textures[map.texture as usize].at(&map, map.place(at));
                [0, 1, 2].map(|k| factor[k] * texel[k])
            }
            (Some(_), None) => atlas::mean(factor, map, &self.textures),
        };
        (of(m.reflectance, m.reflectance_map), of(m.emission, m.emission_map))
    }

    /// The area of a triangle, m²; the length of a flatland segment, m.
    pub fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.corners(face).map(glam::DVec3::from_array);
        if self.is_flatland() {
            return a.distance(b);
        }
        0.5 * (b - a).cross(c - a).length()
    }

    /// The corners of a triangle, metres.
    pub fn corners(&self, face: usize) -> [[f64; 3]; 3] {
        self.faces[face].vertices.map(|v| self.vertices[v as usize])
    }
}
