//! A mesh with light at its vertices, as [`super::ply`] and [`super::glb`] write it.

/// A mesh with light at its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Triangles: indices into [`Mesh::vertices`], counter-clockwise seen from the lit side.
    pub faces: Vec<[u32; 3]>,
    /// Index into [`crate::Scene::faces`] of each triangle, ascending.
    pub sources: Vec<u32>,
    /// For each triangle, the part it belongs to: an index into [`Mesh::parts`].
    pub part: Vec<u32>,
    /// Parts: every pair of object and material that has triangles.
    pub parts: Vec<Part>,
}

/// A vertex of a [`Mesh`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vertex {
    /// Position, metres.
    pub p: [f64; 3],
    /// Unit normal of the side that the light was taken on.
    pub n: [f32; 3],
    /// Radiosity, W/m² in linear Rec.709 RGB.
    pub b: [f32; 3],
}

/// Triangles of one object and one material.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// The object's name.
    pub object: String,
    /// The material's name.
    pub material: String,
}
