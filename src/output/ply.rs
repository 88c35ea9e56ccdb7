//! `vertices.ply`: radiosity at every vertex, binary little endian.
//!
//! `B_r,B_g,B_b` are the numbers (W/m²); `red,green,blue` are only for looking at.

use super::mesh::Mesh;
use super::{atomic, image::Tone};
use crate::error::Result;
use std::path::Path;

/// Writes a mesh. Errors: [`crate::Error::Write`].
pub fn write(path: &Path, mesh: &Mesh) -> Result<()> {
    // What a camera sees of a diffuse surface is B / pi; here only ratios matter.
    let colours: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| v.b).collect();
    let tone = Tone::auto(&colours);
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment raycell: B = radiosity, W/m2, linear Rec.709; red green blue: preview, {tone}\n\
         element vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.faces.len()
    )
    .into_bytes();
    for v in &mesh.vertices {
        bytes.extend(v.p.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(v.n.iter().chain(&v.b).flat_map(|x| x.to_le_bytes()));
        bytes.extend(tone.map(v.b));
    }
    for face in &mesh.faces {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    atomic::write(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::mesh::Vertex;

    #[test]
    fn the_header_matches_the_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("v.ply");
        let vertex = Vertex { p: [1.0, 2.0, 3.0], n: [0.0, 1.0, 0.0], b: [0.5, 0.25, 0.0] };
        write(&path, &Mesh { vertices: vec![vertex; 3], faces: vec![[0, 1, 2]], ..Mesh::default() }).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        assert_eq!(bytes.len() - body, 3 * (24 + 24 + 3) + 13);
        assert_eq!(bytes[body..body + 8], 1f64.to_le_bytes());
        assert_eq!(bytes[body + 36..body + 40], 0.5f32.to_le_bytes());
    }
}
