//! What is to be lit: triangles, materials, and their preparation for the passes. No wgpu here.

mod distribution;
mod geometry;
mod obj;
mod surface;

pub use distribution::cumulative;
pub use geometry::Geometry;
pub use surface::Located;
pub(crate) use surface::nearest_on_triangle;

use crate::error::{Error, Result};
use std::path::Path;

/// A diffuse material in user units, linear Rec.709 RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, for messages.
    pub name: String,
    /// Diffuse reflectance rho (MTL `Kd`), each band in [0, 1).
    pub reflectance: [f64; 3],
    /// Emitted **radiance** (MTL `Ke`), W/m²/sr; the emitted radiosity is pi times it.
    pub emission: [f64; 3],
}

impl Material {
    /// A material.
    pub fn new(name: &str, reflectance: [f64; 3], emission: [f64; 3]) -> Material {
        Material { name: name.into(), reflectance, emission }
    }

    /// Checks that it can be lit: reflectances in [0, 1), emissions finite and >= 0.
    ///
    /// Errors: [`Error::InvalidReflectance`], [`Error::InvalidEmission`].
    pub fn check(&self) -> Result<()> {
        for (k, band) in ["red", "green", "blue"].into_iter().enumerate() {
            if !(0.0..1.0).contains(&self.reflectance[k]) {
                return Err(Error::InvalidReflectance { material: self.name.clone(), band, value: self.reflectance[k] });
            }
            if !(self.emission[k].is_finite() && self.emission[k] >= 0.0) {
                return Err(Error::InvalidEmission { material: self.name.clone(), band, value: self.emission[k] });
            }
        }
        Ok(())
    }
}

/// A triangle of a scene: vertex indices, material and object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Face {
    /// Indices into [`Scene::vertices`], counter-clockwise seen from the front.
    pub vertices: [u32; 3],
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::objects`].
    pub object: u32,
}

/// A scene as its author wrote it: metres, f64, one-sided triangles.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name or path, for messages and reports.
    pub name: String,
    /// Vertex positions, metres.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles.
    pub faces: Vec<Face>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Object names, for messages.
    pub objects: Vec<String>,
    /// What was odd on reading, in words for the user.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Reads a scene file (`.obj` with its `.mtl`).
    ///
    /// Errors: [`Error::Read`], [`Error::Format`], and those of [`Scene::check`].
    pub fn load(path: impl AsRef<Path>) -> Result<Scene> {
        let scene = Scene::read(path)?;
        scene.check()?;
        Ok(scene)
    }

    /// [`Scene::load`] without [`Scene::check`], for [`crate::doctor`], who has more to say of a sick scene.
    ///
    /// Errors: [`Error::Read`], [`Error::Format`].
    pub fn read(path: impl AsRef<Path>) -> Result<Scene> {
        obj::read_obj(path.as_ref())
    }

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

    /// Checks that the scene can be lit: finite vertices, indices in range, reflectances in [0, 1), emissions finite and >= 0.
    ///
    /// Errors: [`Error::EmptyScene`], [`Error::InvalidVertex`], [`Error::IndexOutOfRange`],
    /// [`Error::InvalidReflectance`], [`Error::InvalidEmission`].
    pub fn check(&self) -> Result<()> {
        if self.faces.is_empty() {
            return Err(Error::EmptyScene { scene: self.name.clone() });
        }
        for (index, &value) in self.vertices.iter().enumerate() {
            if !value.iter().all(|c| c.is_finite()) {
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
            if face.material as usize >= self.materials.len() {
                return Err(Error::IndexOutOfRange {
                    place: format!("{}: triangle {i}, material", self.name),
                    index: face.material as i64,
                    count: self.materials.len(),
                });
            }
        }
        self.materials.iter().try_for_each(Material::check)
    }

    /// The corners of a triangle, metres.
    pub fn corners(&self, face: usize) -> [[f64; 3]; 3] {
        self.faces[face].vertices.map(|v| self.vertices[v as usize])
    }
}
