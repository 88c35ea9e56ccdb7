//! glTF 2.0, as text (`.gltf`) and binary (`.glb`): meshes, instances, diffuse and emitting materials, cameras, lights.
//!
//! The `gltf` crate reads and validates the JSON; the buffers are read in [`buffers`].

mod buffers;
mod lights;
mod materials;

use super::load::Reader;
use super::transform::{self, From};
use super::unread::Unread;
use super::{Face, Scene, View, fits};
use crate::error::{Error, Result};
use crate::progress::Event;
use crate::scene::sides;
use crate::solution::Camera;
use buffers::Buffers;
use glam::{DMat4, DQuat, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::{Checked, Validate};
use gltf::json::{Index, Node, Root};
use materials::Materials;
use std::path::Path;

/// Extensions that are read, or change nothing for diffuse light.
const HARMLESS: &[&str] = &[
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Reads a glTF file: the scene it opens with, in metres, y up, as the format has it.
///
/// Errors: [`Error::Read`]; [`Error::Format`] with the line of the JSON, or the path in it;
/// [`Error::InvalidVertex`]; [`Error::IndexOutOfRange`].
pub fn read(path: &Path, reader: &mut Reader) -> Result<Scene> {
    let bytes = reader.read(path)?;
    let (json, chunk) = split(path, &bytes)?;
    let root = parse(path, json, chunk.is_some())?;
    let mut read = Read {
        path,
        root: &root,
        buffers: Buffers::new(path, &root, chunk),
        materials: Materials::new(path, &root),
        unread: Unread::default(),
        bare: Unread::default(),
        scene: Scene { name: path.display().to_string(), ..Scene::default() },
    };
    for extension in root.extensions_used.iter().filter(|e| !HARMLESS.contains(&e.as_str())) {
        read.unread.add(&format!("extension {extension}"), "extensionsUsed");
    }
    for (i, _) in root.animations.iter().enumerate() {
        read.unread.add("animation", format_args!("animations[{i}]"));
    }
    read.nodes(reader)?;

    let Read { mut scene, unread, bare, materials, .. } = read;
    unread.warn(path, &mut scene.warnings);
    bare.warn_as(
        path,
        "given the mean of their texture, and nothing cut out",
        "unwrap them in the modeller",
        &mut scene.warnings,
    );
    materials.warn(&mut scene.warnings);
    sides::mirror(&mut scene, |face| materials.is_two_sided(face.material));
    Ok(scene)
}

/// What is wrong, at a path in the file.
fn fault(path: &Path, place: &str, what: &str) -> Error {
    Error::Format { path: path.into(), line: None, what: format!("{place} {what}"), cure: "export the scene anew".into() }
}

/// The JSON and the binary chunk of a file.
fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    // Header: magic, version, length; then chunks of length, type, bytes.
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(fault(path, "the header", &format!("says version {version}, not 2"))),
        None => return Err(fault(path, "the header", "ends early")),
    }
    let chunk = |at: usize| {
        let (length, kind) = (word(at)? as usize, bytes.get(at + 4..at + 8)?);
        Some((kind, bytes.get(at + 8..(at + 8).checked_add(length)?)?))
    };
    let Some((b"JSON", json)) = chunk(12) else {
        return Err(fault(path, "the first chunk", "is not whole JSON"));
    };
    let next = 20 + json.len();
    if bytes.len() < next + 8 {
        return Ok((json, None));
    }
    match chunk(next) {
        Some((b"BIN\0", binary)) => Ok((json, Some(binary))),
        Some(_) => Ok((json, None)),
        None => Err(fault(path, "the second chunk", "ends early")),
    }
}

/// The JSON, with every index in it checked.
fn parse(path: &Path, json: &[u8], binary: bool) -> Result<Root> {
    let root = Root::from_slice(json).map_err(|e| Error::Format {
        path: path.into(),
        line: (!binary && e.line() > 0).then_some(e.line()),
        what: if binary { format!("in the JSON chunk: {e}") } else { e.to_string() },
        cure: "export the scene anew".into(),
    })?;
    if let Some(extension) = root.extensions_required.iter().find(|e| !HARMLESS.contains(&e.as_str())) {
        let cure = "export without it (compressed meshes and textures are not read)";
        return Err(Error::Format {
            path: path.into(),
            line: None,
            what: format!("extensionsRequired: {extension} is not supported"),
            cure: cure.into(),
        });
    }
    // The crate's validation trusts these.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if primitive.attributes.values().any(|a| a.value() >= root.accessors.len()) {
                let place = format!("meshes[{m}].primitives[{p}].attributes");
                return Err(fault(path, &place, "names an accessor that is not there"));
            }
        }
    }
    let mut first = None;
    root.validate(&root, gltf::json::Path::new, &mut |place, error| {
        let place = place().to_string();
        // The bounds of positions are not used; older exporters leave them out.
        let spared = place.ends_with(".min") || place.ends_with(".max") || place.starts_with("extensionsRequired");
        if first.is_none() && !spared {
            first = Some(fault(path, if place.is_empty() { "the file" } else { &place }, &format!("is refused: {error}")));
        }
    });
    first.map_or(Ok(root), Err)
}

/// A file as it is being read.
struct Read<'a> {
    path: &'a Path,
    root: &'a Root,
    buffers: Buffers<'a>,
    materials: Materials<'a>,
    unread: Unread,
    /// What has a texture and no coordinates for it.
    bare: Unread,
    scene: Scene,
}

impl Read<'_> {
    /// All nodes under the scene's roots, depth first, as the file orders them.
    fn nodes(&mut self, reader: &mut Reader) -> Result<()> {
        let root = self.root;
        let mut seen = vec![false; root.nodes.len()];
        let scene = root.scene.map_or(0, |s| s.value());
        let roots: Vec<usize> = match root.scenes.get(scene) {
            Some(scene) => scene.nodes.iter().map(Index::value).collect(),
            None => {
                let mut child = vec![false; root.nodes.len()];
                root.nodes.iter().flat_map(|n| n.children.iter().flatten()).for_each(|c| child[c.value()] = true);
                (0..root.nodes.len()).filter(|&n| !child[n]).collect()
            }
        };
        let mut stack: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|n| (n, DMat4::IDENTITY)).collect();
        let mut done = 0;
        while let Some((n, parent)) = stack.pop() {
            if std::mem::replace(&mut seen[n], true) {
                return Err(fault(self.path, &format!("nodes[{n}]"), "hangs from two parents"));
            }
            let node = &root.nodes[n];
            let matrix = parent * local(node);
            let from = From::end(&self.scene);
            self.mesh(n, node, reader)?;
            self.camera(n, node);
            lights::light(root, n, node, &mut self.scene, &mut self.unread);
            transform::apply(&mut self.scene, from, matrix);
            if let Some(i) = self.scene.vertices[from.vertices..].iter().position(|v| !fits(v)) {
                let place = format!("{}: nodes[{n}]", self.path.display());
                return Err(Error::InvalidVertex { place, index: i, value: self.scene.vertices[from.vertices + i] });
            }
            stack.extend(node.children.iter().flatten().rev().map(|c| (c.value(), matrix)));
            done += 1;
            reader.progress.event(Event::Read { done, total: root.nodes.len() as u64 })?;
        }
        Ok(())
    }

    /// The triangles of a node's mesh, in the mesh's own space; the node is their object.
    fn mesh(&mut self, n: usize, node: &Node, reader: &mut Reader) -> Result<()> {
        let Some(mesh) = node.mesh else { return Ok(()) };
        if node.skin.is_some() {
            self.unread.add("skin (the mesh is taken at rest)", format_args!("nodes[{n}]"));
        }
        let mesh_index = mesh.value();
        let mesh = &self.root.meshes[mesh_index];
        let name = node.name.as_ref().or(mesh.name.as_ref()).cloned().unwrap_or_else(|| format!("nodes[{n}]"));
        let object = self.scene.objects.len() as u32;
        self.scene.objects.push(name);
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            self.primitive(&format!("meshes[{mesh_index}].primitives[{p}]"), primitive, object, reader)?;
        }
        Ok(())
    }

    fn primitive(&mut self, place: &str, primitive: &Primitive, object: u32, reader: &mut Reader) -> Result<()> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            _ => {
                self.unread.add("points or lines", place);
                return Ok(());
            }
        };
        if primitive.targets.as_ref().is_some_and(|t| !t.is_empty()) {
            self.unread.add("morph target (the mesh is taken without)", place);
        }
        let Some(&positions) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            self.unread.add("primitive without positions", place);
            return Ok(());
        };
        let positions = self.buffers.positions(positions, reader)?;
        let (first, count) = (self.scene.vertices.len(), positions.len());
        if first + count > u32::MAX as usize {
            return Err(fault(self.path, place, "brings more than 4294967295 vertices into the scene"));
        }
        let corners = match primitive.indices {
            Some(indices) => self.buffers.indices(indices, reader)?,
            None => (0..count as u32).collect(),
        };
        if let Some(&index) = corners.iter().find(|&&i| i as usize >= count) {
            let place = format!("{}: {place}", self.path.display());
            return Err(Error::IndexOutOfRange { place, index: index as i64, count });
        }
        let material = self.materials.used(primitive.material, &mut self.buffers, reader, &mut self.scene, place);
        let textured = self.scene.materials[material as usize].maps().iter().any(Option::is_some);
        let first_uv = self.scene.uvs.len() as u32;
        let mut has_uvs = false;
        if textured {
            match primitive.attributes.get(&Checked::Valid(Semantic::TexCoords(0))) {
                Some(&accessor) => {
                    let uvs = self.buffers.coordinates(accessor, reader)?;
                    if uvs.len() != count {
                        let what = format!("has {} texture coordinates and {count} positions", uvs.len());
                        return Err(fault(self.path, place, &what));
                    }
                    self.scene.uvs.extend(uvs);
                    has_uvs = true;
                }
                None => self.bare.add("primitives without TEXCOORD_0", place),
            }
        }
        self.scene.vertices.extend(positions);
        let at = |i: usize| first as u32 + corners[i];
        let triangles = match mode {
            Mode::Triangles => corners.len() / 3,
            _ => corners.len().saturating_sub(2),
        };
        for i in 0..triangles {
            let three = match mode {
                Mode::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
                // Every other triangle of a strip is wound the other way.
                Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
                _ => [i + 1, i + 2, 0],
            };
            if has_uvs {
                let face = self.scene.faces.len();
                self.scene.set_uv(face, three.map(|i| first_uv + corners[i]));
            }
            self.scene.faces.push(Face { vertices: three.map(at), material, object });
        }
        Ok(())
    }

    /// The camera of a node: it looks down its own -z, its y is up.
    fn camera(&mut self, n: usize, node: &Node) {
        let Some(camera) = node.camera else { return };
        let camera = &self.root.cameras[camera.value()];
        let Some(perspective) = &camera.perspective else {
            self.unread.add("orthographic camera", format_args!("nodes[{n}]"));
            return;
        };
        let height = 512u32;
        let aspect = perspective.aspect_ratio.map_or(1.0, f64::from);
        let view = Camera {
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            vfov_degrees: (perspective.yfov as f64).to_degrees(),
            width: ((height as f64 * aspect).round() as u32).clamp(1, 4096),
            height,
        };
        if view.check().is_err() {
            self.unread.add("camera that sees nothing", format_args!("nodes[{n}]"));
            return;
        }
        let name = node.name.as_ref().or(camera.name.as_ref()).cloned().unwrap_or_else(|| format!("nodes[{n}]"));
        self.scene.cameras.push(View { name, camera: view });
    }
}

/// A node's own transform.
fn local(node: &Node) -> DMat4 {
    if let Some(m) = node.matrix {
        return DMat4::from_cols_array(&m.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, default: DVec3| v.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    let turn = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
    // Written with seven digits a rotation is not quite of unit length.
    let turn = if turn.length_squared() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(vector(node.scale, DVec3::ONE), turn, vector(node.translation, DVec3::ZERO))
}
