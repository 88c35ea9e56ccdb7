//! Flatland drawn: each segment as a wall that stands on the plane z = 0.

use super::{Face, Scene, Space};

impl Scene {
    /// The scene as it is drawn: a flatland scene's segments as walls, two triangles a segment in its order, lit side
    /// outwards; any other scene as it is. Face `f` of the walls stands on segment `f / 2`.
    pub(crate) fn extruded(&self) -> Scene {
        let Space::Flatland { height } = self.space else { return self.clone() };
        let ground = self.vertices.len() as u32;
        let top = self.vertices.iter().map(|v| [v[0], v[1], height]);
        let walls = self
            .faces
            .iter()
            .flat_map(|face| wall(face.vertices[0], face.vertices[1], ground).map(|vertices| Face { vertices, ..*face }));
        Scene {
            space: Space::Solid,
            vertices: self.vertices.iter().copied().chain(top).collect(),
            faces: walls.collect(),
            ..self.clone()
        }
    }
}

/// The two triangles of a wall on the segment from vertex a to b, whose upper ends are `up` further on. Its front is
/// on the left of the way from a to b. The first triangle holds b, a and the upper a, the second b and both upper ends.
pub(crate) fn wall(a: u32, b: u32, up: u32) -> [[u32; 3]; 2] {
    [[b, a, a + up], [b, a + up, b + up]]
}
