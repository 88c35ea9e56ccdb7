//! `vertices.glb`: binary glTF 2.0 with the light in `COLOR_0`.
//!
//! A node an object, a primitive a material, names kept. `COLOR_0` is a float32 vec4: linear radiance B/π
//! (W/m²/sr, Rec.709; what an eye sees of a diffuse surface), and 1. It is not exposed; radiosity is π times it.
//! Materials are unlit (`KHR_materials_unlit`), so that viewers show the light as it is and add none.

use super::atomic;
use super::mesh::{Mesh, Vertex};
use crate::error::{Error, Result};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::io::{self, ErrorKind};
use std::path::Path;

// glTF's numbers: component types, buffer targets.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Writes a mesh, one without triangles too.
///
/// Errors: [`Error::Write`], also where the file would have 4 GiB or more, which is the format's end;
/// [`Error::InvalidVertex`] where a position is too large for a float32.
pub fn write(path: &Path, mesh: &Mesh) -> Result<()> {
    if let Some(index) = mesh.vertices.iter().position(|v| v.p.iter().any(|&x| !(x as f32).is_finite())) {
        return Err(Error::InvalidVertex { place: path.display().to_string(), index, value: mesh.vertices[index].p });
    }
    let bytes = pack(&document(mesh)).map_err(|source| Error::Write { path: path.into(), source })?;
    atomic::write(path, &bytes)
}

/// A document and its one buffer.
struct Document {
    json: Value,
    buffer: Vec<u8>,
}

fn document(mesh: &Mesh) -> Document {
    let mut buffers = Buffers::default();
    let mut triangles = vec![Vec::new(); mesh.parts.len()];
    for (face, &part) in mesh.faces.iter().zip(&mesh.part) {
        triangles[part as usize].push(*face);
    }
    // Objects and materials in the order of their first part.
    let (mut objects, mut materials) = (Names::default(), Names::default());
    let mut primitives: Vec<Vec<Value>> = Vec::new();
    for (part, triangles) in mesh.parts.iter().zip(&triangles).filter(|(_, t)| !t.is_empty()) {
        let (object, material) = (objects.index(&part.object), materials.index(&part.material));
        primitives.resize_with(objects.names.len(), Vec::new);
        primitives[object].push(buffers.primitive(mesh, triangles, material));
    }
    let count = objects.names.len();
    let materials: Vec<Value> = materials
        .names
        .iter()
        .map(|name| {
            json!({
                "name": name,
                "extensions": {"KHR_materials_unlit": {}},
                "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 1},
            })
        })
        .collect();
    let mut json = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("raycell ", env!("CARGO_PKG_VERSION")),
            "extras": {
                "COLOR_0": "linear radiance B/pi, W/m2/sr, Rec.709, not exposed; alpha is 1",
                "radiosity_per_COLOR_0": PI,
                "length_unit": "m",
            },
        },
    });
    // glTF allows no empty lists.
    if count > 0 {
        let meshes: Vec<Value> =
            objects.names.iter().zip(primitives).map(|(name, p)| json!({"name": name, "primitives": p})).collect();
        let nodes: Vec<Value> = objects.names.iter().enumerate().map(|(i, name)| json!({"name": name, "mesh": i})).collect();
        json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        json["scene"] = 0.into();
        json["scenes"] = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
        json["nodes"] = nodes.into();
        json["meshes"] = meshes.into();
        json["materials"] = materials.into();
        json["accessors"] = buffers.accessors.into();
        json["bufferViews"] = buffers.views.into();
        json["buffers"] = json!([{"byteLength": buffers.bytes.len()}]);
    }
    Document { json, buffer: buffers.bytes }
}

/// Names in the order they come, each once.
#[derive(Default)]
struct Names<'a> {
    names: Vec<&'a str>,
    at: BTreeMap<&'a str, usize>,
}

impl<'a> Names<'a> {
    fn index(&mut self, name: &'a str) -> usize {
        *self.at.entry(name).or_insert_with(|| {
            self.names.push(name);
            self.names.len() - 1
        })
    }
}

/// The buffer as it grows, with what lies where. Every value has four bytes: all is aligned.
#[derive(Default)]
struct Buffers {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffers {
    /// A primitive with only the vertices that its triangles use.
    fn primitive(&mut self, mesh: &Mesh, triangles: &[[u32; 3]], material: usize) -> Value {
        let mut used: Vec<u32> = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let vertices = || used.iter().map(|&v| mesh.vertices[v as usize]);
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for p in vertices().map(position) {
            for k in 0..3 {
                bounds[0][k] = bounds[0][k].min(p[k]);
                bounds[1][k] = bounds[1][k].max(p[k]);
            }
        }
        let positions = self.floats("VEC3", vertices().map(position));
        self.accessors[positions]["min"] = json!(bounds[0]);
        self.accessors[positions]["max"] = json!(bounds[1]);
        let normals = self.floats("VEC3", vertices().map(|v| v.n));
        let colours = self.floats("VEC4", vertices().map(|v| colour(v.b)));
        let start = self.bytes.len();
        for v in triangles.as_flattened() {
            // Found: `used` is made of the same numbers.
            let local = used.binary_search(v).unwrap_or_default() as u32;
            self.bytes.extend(local.to_le_bytes());
        }
        let indices = self.accessor(start, ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR", 3 * triangles.len());
        json!({
            "attributes": {"POSITION": positions, "NORMAL": normals, "COLOR_0": colours},
            "indices": indices,
            "material": material,
        })
    }

    fn floats<const N: usize>(&mut self, kind: &str, values: impl Iterator<Item = [f32; N]>) -> usize {
        let start = self.bytes.len();
        let mut count = 0;
        for value in values {
            self.bytes.extend(value.iter().flat_map(|x| x.to_le_bytes()));
            count += 1;
        }
        self.accessor(start, ARRAY_BUFFER, FLOAT, kind, count)
    }

    fn accessor(&mut self, start: usize, target: u32, component: u32, kind: &str, count: usize) -> usize {
        let length = self.bytes.len() - start;
        self.views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": length, "target": target}));
        let view = self.views.len() - 1;
        self.accessors.push(json!({"bufferView": view, "componentType": component, "type": kind, "count": count}));
        self.accessors.len() - 1
    }
}

fn position(v: Vertex) -> [f32; 3] {
    v.p.map(|x| x as f32)
}

/// Radiance of a radiosity, and an alpha of 1.
fn colour(b: [f32; 3]) -> [f32; 4] {
    let [r, g, b] = b.map(|x| (x as f64 / PI) as f32);
    [r, g, b, 1.0]
}

/// The binary container: a header, the document, the buffer; each chunk a multiple of four bytes.
fn pack(document: &Document) -> io::Result<Vec<u8>> {
    let mut text = document.json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut chunks = vec![(b"JSON", &text)];
    if !document.buffer.is_empty() {
        chunks.push((b"BIN\0", &document.buffer));
    }
    let length = 12 + chunks.iter().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
    let length = u32::try_from(length)
        .map_err(|_| io::Error::new(ErrorKind::FileTooLarge, "a .glb ends at 4 GiB; write a .ply instead"))?;
    let mut out = Vec::with_capacity(length as usize);
    out.extend(b"glTF");
    out.extend([2, length].map(u32::to_le_bytes).as_flattened());
    for (name, bytes) in chunks {
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(name);
        out.extend(bytes);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::mesh::Part;
    use gltf::Semantic;

    /// Two objects that share a corner, three materials, one part of which nothing is left.
    fn mesh() -> Mesh {
        let vertex = |i: u32| Vertex {
            p: [i as f64 * 0.1, -(i as f64), 1.0 / 3.0],
            n: [0.0, 0.0, 1.0],
            b: [i as f32, 0.7 * i as f32, 1e-9],
        };
        let part = |object: &str, material: &str| Part { object: object.into(), material: material.into() };
        Mesh {
            vertices: (0..7).map(vertex).collect(),
            faces: vec![[0, 1, 2], [4, 5, 6], [2, 1, 3], [6, 5, 3]],
            sources: vec![0, 1, 2, 3],
            part: vec![0, 2, 0, 3],
            parts: vec![part("floor \"1\"", "grey"), part("gone", "grey"), part("lamp", "grey"), part("lamp", "glow")],
        }
    }

    /// Values of an accessor, as the reading crate sees them.
    fn floats(accessor: &gltf::Accessor, blob: &[u8]) -> Vec<Vec<f32>> {
        let view = accessor.view().unwrap();
        assert_eq!((view.offset() % 4, view.stride(), accessor.data_type()), (0, None, gltf::accessor::DataType::F32));
        let n = accessor.dimensions().multiplicity();
        let bytes = &blob[view.offset()..view.offset() + view.length()];
        assert_eq!(bytes.len(), 4 * n * accessor.count());
        let values: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        values.chunks_exact(n).map(<[f32]>::to_vec).collect()
    }

    #[test]
    fn it_reads_back_corner_by_corner() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("v.glb");
        let mesh = mesh();
        write(&path, &mesh).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len() % 4, 0);
        let file = gltf::Gltf::from_slice(&bytes).expect("valid glTF");
        let blob = file.blob.as_deref().unwrap();
        assert_eq!(file.extensions_used().collect::<Vec<_>>(), ["KHR_materials_unlit"]);
        let nodes: Vec<_> = file.default_scene().unwrap().nodes().collect();
        assert_eq!(nodes.iter().map(|n| n.name().unwrap()).collect::<Vec<_>>(), ["floor \"1\"", "lamp"]);

        let mut seen = Vec::new();
        for primitive in nodes.iter().flat_map(|n| n.mesh().unwrap().primitives().collect::<Vec<_>>()) {
            let of = |semantic| primitive.get(&semantic).unwrap();
            let positions = floats(&of(Semantic::Positions), blob);
            let normals = floats(&of(Semantic::Normals), blob);
            let colours = floats(&of(Semantic::Colors(0)), blob);
            // Only its own vertices, with their true bounds.
            let low: Vec<f32> = (0..3).map(|k| positions.iter().map(|p| p[k]).fold(f32::MAX, f32::min)).collect();
            assert_eq!(of(Semantic::Positions).min().unwrap(), serde_json::json!(low));
            let indices = primitive.indices().unwrap();
            let (view, material) = (indices.view().unwrap(), primitive.material().name().unwrap().to_string());
            let at = |i: usize| {
                let at = view.offset() + 4 * i;
                u32::from_le_bytes(blob[at..at + 4].try_into().unwrap()) as usize
            };
            for i in 0..indices.count() {
                let k = at(i);
                seen.push((material.clone(), positions[k].clone(), normals[k].clone(), colours[k].clone()));
            }
        }
        // Parts in their order, and in each the faces in theirs.
        let order = [0, 2, 1, 3];
        let wanted: Vec<_> = order
            .iter()
            .flat_map(|&f| mesh.faces[f].map(|v| (mesh.parts[mesh.part[f] as usize].material.clone(), mesh.vertices[v as usize])))
            .map(|(m, v)| (m, position(v).to_vec(), v.n.to_vec(), colour(v.b).to_vec()))
            .collect();
        assert_eq!(seen, wanted);
        let radiosity = seen[1].3[0] as f64 * PI;
        assert!((radiosity - 1.0).abs() < 1e-6, "{radiosity}");
    }

    #[test]
    fn nothing_is_a_file_too_and_what_cannot_be_written_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("v.glb");
        write(&path, &Mesh::default()).unwrap();
        assert_eq!(gltf::Gltf::from_slice(&std::fs::read(&path).unwrap()).unwrap().meshes().count(), 0);
        let mut mesh = mesh();
        mesh.vertices[5].p[1] = 1e39;
        assert!(matches!(write(&path, &mesh), Err(Error::InvalidVertex { index: 5, .. })));
    }
}
