//! What is to be lit: triangles, materials, and their preparation for the passes. No wgpu here.

mod called;
mod convex;
mod distribution;
mod extruded;
mod geometry;
mod gltf;
mod hierarchy;
mod load;
mod mtl;
mod obj;
mod polygon;
#[doc(hidden)]
pub mod shapes;
mod sides;
mod surface;
mod text;
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
pub use load::{KdSpace, LoadOptions, Up};
#[doc(hidden)]
pub use surface::Located;
pub(crate) use surface::nearest_on_triangle;

use crate::effects::Switches;
use crate::error::{Error, Result};
use crate::solution::Camera;

/// A diffuse material, or an ideal mirror, in user units, linear Rec.709 RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, for messages.
    pub name: String,
    /// Diffuse reflectance rho (MTL `Kd`), each band in [0, 1).
    pub reflectance: [f64; 3],
    /// Emitted **radiance** (MTL `Ke`), W/m²/sr; the emitted radiosity is pi times it.
    pub emission: [f64; 3],
    /// Reflectance of an ideal mirror, grey, in [0, 1); 0: no mirror. A mirror reflects nothing diffusely: beside it
    /// `reflectance` does not count; and it does not shine.
    pub mirror: f64,
}

impl Material {
    /// A diffuse material.
    pub fn new(name: &str, reflectance: [f64; 3], emission: [f64; 3]) -> Material {
        Material { name: name.into(), reflectance, emission, mirror: 0.0 }
    }

    /// An ideal mirror.
    pub fn new_mirror(name: &str, reflectance: f64) -> Material {
        Material { mirror: reflectance, ..Material::new(name, [0.0; 3], [0.0; 3]) }
    }

    /// Checks that it can be lit: reflectances in [0, 1), emissions >= 0 that 32-bit floats hold, no mirror that shines.
    ///
    /// Errors: [`Error::InvalidReflectance`], [`Error::InvalidEmission`], [`Error::InvalidMirror`].
    pub fn check(&self) -> Result<()> {
        self.check_at("in memory")
    }

    fn check_at(&self, place: &str) -> Result<()> {
        for (k, band) in ["red", "green", "blue"].into_iter().enumerate() {
            let (place, material) = (place.to_string(), self.name.clone());
            // Also as the passes see it: 1 - 1e-9 is 1 in 32 bits.
            let rho = self.reflectance[k];
            if !((0.0..1.0).contains(&rho) && (rho as f32) < 1.0) {
                return Err(Error::InvalidReflectance { place, material, band, value: self.reflectance[k] });
            }
            if !(0.0..=f64::from(f32::MAX)).contains(&self.emission[k]) {
                return Err(Error::InvalidEmission { place, material, band, value: self.emission[k] });
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
    /// Object names, for messages.
    pub objects: Vec<String>,
    /// File and line of each material, for messages; empty where the scene does not come from files.
    pub material_places: Vec<String>,
    /// Cameras the file holds, in its order.
    pub cameras: Vec<View>,
    /// Effects that were switched by hand ([`Switches::apply`]).
    pub effects: Switches,
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
    /// [`Error::InvalidEmission`], [`Error::InvalidMirror`]; [`Error::InvalidParam`] for the medium's absorption; [`Error::NotFlat`] for a flatland scene whose faces
    /// are no segments in the plane z = 0.
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
        if !(0.0..=f64::from(f32::MAX)).contains(&self.absorption) {
            let range = "the medium takes a share of light on each metre: give 1/m, 0 or more";
            return Err(Error::InvalidParam { name: "absorption", value: self.absorption.to_string(), range });
        }
        (0..self.materials.len()).try_for_each(|m| self.check_material(m))
    }

    /// As [`Material::check`], of a material of this scene; the error names the file and line it comes from.
    pub fn check_material(&self, material: usize) -> Result<()> {
        self.materials[material].check_at(self.material_places.get(material).unwrap_or(&self.name))
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
