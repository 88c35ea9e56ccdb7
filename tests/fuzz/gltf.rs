//! glTF as text and as binary.

use super::{Target, run};
use raycell::Flow;
use raycell::scene::{LoadOptions, Scene};
use std::path::Path;
use std::sync::LazyLock;

/// Two quads as an indexed mesh and a strip, one mirrored, a lamp, a camera; its buffer beside it.
const EXTERNAL: &str = r#"{
  "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 3]}],
  "extensionsUsed": ["KHR_materials_emissive_strength"],
  "nodes": [
    {"name": "floor", "mesh": 0, "children": [2]},
    {"mesh": 1, "translation": [0, 2, 0], "scale": [1, -1, 1], "rotation": [0, 0.7071068, 0, 0.7071068]},
    {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 3, 0, 1]},
    {"name": "eye", "camera": 0, "translation": [0, 1, 5]}
  ],
  "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1}}],
  "meshes": [
    {"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]},
    {"name": "lamp", "primitives": [{"attributes": {"POSITION": 0}, "mode": 5, "material": 1}]}
  ],
  "materials": [
    {"name": "wall", "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}},
    {"name": "lamp", "emissiveFactor": [1, 1, 0.5], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5}}}
  ],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]},
    {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR", "byteOffset": 0}
  ],
  "bufferViews": [
    {"buffer": 0, "byteLength": 48, "byteStride": 12},
    {"buffer": 0, "byteOffset": 48, "byteLength": 12}
  ],
  "buffers": [{"byteLength": 60, "uri": "s.bin"}]
}"#;

static BUFFER: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let positions: [f32; 12] = [0., 0., 0., 0., 0., 1., 1., 0., 0., 1., 0., 1.];
    let indices: [u16; 6] = [0, 1, 2, 2, 1, 3];
    positions.iter().flat_map(|f| f.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes())).collect()
});

static EMBEDDED: LazyLock<String> = LazyLock::new(|| {
    EXTERNAL.replace(
        "s.bin",
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAAAAAACAPwAAAAAAAIA/AAABAAIAAgABAAMA",
    )
});

/// With a texture that colours, shines and cuts out.
static TEXTURED: LazyLock<String> = LazyLock::new(|| {
    use base64::Engine;
    let image = base64::engine::general_purpose::STANDARD.encode(super::png());
    EMBEDDED
        .replace(r#"{"POSITION": 0}, "indices""#, r#"{"POSITION": 0, "TEXCOORD_0": 2}, "indices""#)
        .replace(r#""metallicFactor": 0}"#, r#""metallicFactor": 0, "baseColorTexture": {"index": 0}}, "alphaMode": "MASK", "emissiveTexture": {"index": 0}"#)
        .replace(r#""byteOffset": 0}"#, r#""byteOffset": 0}, {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2"}"#)
        .replace(r#""buffers""#, &format!(r#""samplers": [{{"wrapS": 33071}}], "textures": [{{"source": 0, "sampler": 0}}], "images": [{{"uri": "data:image/png;base64,{image}"}}], "buffers""#))
});

/// JSON and buffer apart, so that a change of length does not break the container around them.
static PARTS: LazyLock<Vec<u8>> =
    LazyLock::new(|| [EXTERNAL.replace(r#", "uri": "s.bin""#, "").as_bytes(), SEAM, &BUFFER[..]].concat());
const SEAM: &[u8] = b"\0\0\0seam";

static BINARY: LazyLock<Vec<u8>> = LazyLock::new(|| container(&PARTS));

/// A `.glb` of parts; one that is whole already stays as it is.
fn container(parts: &[u8]) -> Vec<u8> {
    let seam = parts.windows(SEAM.len()).position(|w| w == SEAM);
    let Some(seam) = seam.filter(|_| !parts.starts_with(b"glTF")) else { return parts.to_vec() };
    let (mut json, bin) = (parts[..seam].to_vec(), &parts[seam + SEAM.len()..]);
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + bin.len();
    let word = |n: usize| (n as u32).to_le_bytes();
    let header = [&b"glTF"[..], &word(2), &word(length)].concat();
    [&header[..], &word(json.len()), b"JSON", &json, &word(bin.len()), b"BIN\0", bin].concat()
}

const WORDS: &[&str] = &[
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "\"",
    "null",
    "true",
    "\"nodes\":",
    "\"children\": [0]",
    "\"mesh\": 0",
    "\"mode\": 4",
    "\"mode\": 6",
    "\"byteOffset\": ",
    "\"byteStride\": 4",
    "\"count\": ",
    "\"sparse\": {}",
    "5121",
    "5125",
    "5126",
    "\"VEC2\"",
    "\"SCALAR\"",
    "\"skin\": 0",
    "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"],",
    "\"uri\": \"gone.bin\"",
    "[[[[[[[[",
    "\u{e9}",
    "\0",
];

fn read(name: &str, bytes: &[u8]) -> Result<(), String> {
    let mut files = |path: &Path| match path.to_str() {
        Some(path) if path == name => Ok(bytes.to_vec()),
        Some("s.bin") => Ok(BUFFER.clone()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    let options = LoadOptions::default();
    Scene::load_from(Path::new(name), &options, &mut files, &mut |_| Flow::Continue).map(drop).map_err(|e| e.to_string())
}

/// File and line, or file and path in it; or a buffer that is not there, or nothing to light in all.
fn names_place(file: &str, message: &str) -> bool {
    let places = [
        "accessors",
        "animations",
        "asset",
        "bufferViews",
        "buffers",
        "cameras",
        "extensions",
        "images",
        "materials",
        "meshes",
        "nodes",
        "samplers",
        "scene",
        "skins",
        "textures",
        "the header",
        "the first chunk",
        "the second chunk",
        "in the JSON chunk",
    ];
    let Some(rest) = message.strip_prefix(file) else { return message.starts_with("cannot read ") };
    let line = rest.strip_prefix(':').is_some_and(|m| m.starts_with(|c: char| c.is_ascii_digit()));
    let place = rest.strip_prefix(": ").is_some_and(|m| places.iter().any(|p| m.starts_with(p)));
    line || place || rest.starts_with(": the scene has no triangle")
}

#[test]
fn gltf() {
    run(&Target {
        format: "gltf",
        seeds: &[EXTERNAL.as_bytes(), EMBEDDED.as_bytes(), TEXTURED.as_bytes()],
        words: WORDS,
        read: &|bytes| read("s.gltf", bytes),
        names_place: &|message| names_place("s.gltf", message),
    });
}

#[test]
fn glb() {
    run(&Target {
        format: "glb",
        seeds: &[&BINARY, &PARTS, &PARTS],
        words: WORDS,
        read: &|bytes| read("s.glb", &container(bytes)),
        names_place: &|message| names_place("s.glb", message),
    });
}
