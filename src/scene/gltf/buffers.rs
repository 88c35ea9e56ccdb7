//! Numbers out of a glTF's buffers. Every offset and length is a stranger's claim, checked before it is used;
//! the `gltf` crate's own readers trust them.

use super::fault;
use crate::error::Result;
use crate::scene::load::Reader;
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::path::Path;

/// The buffers of a file, read when first used.
pub struct Buffers<'a> {
    path: &'a Path,
    root: &'a Root,
    /// The binary chunk of a `.glb`.
    chunk: Option<&'a [u8]>,
    read: Vec<Option<Vec<u8>>>,
}

/// Checked elements of an accessor.
struct Elements<'b> {
    bytes: &'b [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'b> Elements<'b> {
    fn iter(&self) -> impl Iterator<Item = &'b [u8]> + use<'b> {
        let Elements { bytes, stride, size, count } = *self;
        (0..count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

impl<'a> Buffers<'a> {
    pub fn new(path: &'a Path, root: &'a Root, chunk: Option<&'a [u8]>) -> Buffers<'a> {
        Buffers { path, root, chunk, read: vec![None; root.buffers.len()] }
    }

    /// Positions, three floats each.
    pub fn positions(&mut self, accessor: Index<Accessor>, reader: &mut Reader) -> Result<Vec<[f64; 3]>> {
        let float = |b: &[u8], k: usize| f32::from_le_bytes([b[4 * k], b[4 * k + 1], b[4 * k + 2], b[4 * k + 3]]) as f64;
        let elements = self.elements(accessor, Type::Vec3, &[ComponentType::F32], reader)?;
        Ok(elements.iter().map(|b| [0, 1, 2].map(|k| float(b, k))).collect())
    }

    /// Texture coordinates, two floats or normalised integers each.
    pub fn coordinates(&mut self, accessor: Index<Accessor>, reader: &mut Reader) -> Result<Vec<[f64; 2]>> {
        let kinds = [ComponentType::F32, ComponentType::U8, ComponentType::U16];
        let elements = self.elements(accessor, Type::Vec2, &kinds, reader)?;
        let number = |b: &[u8]| match *b {
            [x] => f64::from(x) / 255.0,
            [x, y] => f64::from(u16::from_le_bytes([x, y])) / 65_535.0,
            [x, y, z, w] => f64::from(f32::from_le_bytes([x, y, z, w])),
            _ => f64::NAN,
        };
        let half = elements.size / 2;
        Ok(elements.iter().map(|b| [number(&b[..half]), number(&b[half..])]).collect())
    }

    /// The bytes of an image: a view of a buffer, a `data:` URI, or a file beside the scene. What is wrong is told in words.
    pub fn image(&mut self, index: usize, reader: &mut Reader) -> std::result::Result<Vec<u8>, String> {
        let image = &self.root.images[index];
        if let Some(view) = image.buffer_view {
            let view = &self.root.buffer_views[view.value()];
            let buffer = self.buffer(view.buffer.value(), reader).map_err(|e| e.to_string())?;
            let start = view.byte_offset.map_or(0, |o| o.0);
            let end = start.checked_add(view.byte_length.0).filter(|&end| end <= buffer.len() as u64);
            return match end {
                Some(end) => Ok(buffer[start as usize..end as usize].to_vec()),
                None => Err("its view reaches beyond its buffer".into()),
            };
        }
        match image.uri.as_deref() {
            None => Err("it has neither a uri nor a buffer view".into()),
            Some(uri) => match uri.strip_prefix("data:") {
                Some(data) => base64(data),
                None => {
                    let path = self.path.parent().unwrap_or(Path::new("")).join(percent_decoded(uri));
                    reader.try_read(&path).map_err(|e| e.to_string())
                }
            },
        }
    }

    /// Vertex numbers.
    pub fn indices(&mut self, accessor: Index<Accessor>, reader: &mut Reader) -> Result<Vec<u32>> {
        let kinds = [ComponentType::U8, ComponentType::U16, ComponentType::U32];
        let elements = self.elements(accessor, Type::Scalar, &kinds, reader)?;
        Ok(elements.iter().map(|b| b.iter().rev().fold(0, |n, &byte| n << 8 | byte as u32)).collect())
    }

    /// An accessor's elements, all of them inside their view and buffer.
    fn elements(
        &mut self,
        index: Index<Accessor>,
        shape: Type,
        kinds: &[ComponentType],
        reader: &mut Reader,
    ) -> Result<Elements<'_>> {
        let (path, root) = (self.path, self.root);
        let bad = |what: &str| fault(path, &format!("accessors[{}]", index.value()), what);
        let accessor = &root.accessors[index.value()];
        let (Checked::Valid(kind), Checked::Valid(type_)) = (&accessor.component_type, &accessor.type_) else {
            return Err(bad("has no type"));
        };
        if *type_ != shape || !kinds.contains(&kind.0) {
            return Err(bad(&format!("holds {type_:?} of {:?} where {shape:?} of {kinds:?} is needed", kind.0)));
        }
        let Some(view) = accessor.buffer_view.filter(|_| accessor.sparse.is_none()) else {
            return Err(bad("is sparse, which is not supported"));
        };
        let size = (kind.0.size() * shape.multiplicity()) as u64;
        let view_index = view.value();
        let view = &root.buffer_views[view_index];
        let stride = view.byte_stride.map_or(size, |s| s.0 as u64).max(size);
        let (count, offset) = (accessor.count.0, accessor.byte_offset.map_or(0, |o| o.0));
        // The last element may end before its stride does.
        let last = count.checked_sub(1).ok_or_else(|| bad("holds no element"))?;
        let end = last.checked_mul(stride).and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(offset));
        if end.is_none_or(|end| end > view.byte_length.0) {
            return Err(bad(&format!("reaches beyond the {} bytes of bufferViews[{view_index}]", view.byte_length.0)));
        }
        let start = view.byte_offset.map_or(0, |o| o.0);
        let buffer = self.buffer(view.buffer.value(), reader)?;
        let bytes = (start.checked_add(view.byte_length.0))
            .filter(|&end| end <= buffer.len() as u64)
            .map(|end| &buffer[(start + offset) as usize..end as usize]);
        match bytes {
            Some(bytes) => Ok(Elements { bytes, stride: stride as usize, size: size as usize, count: count as usize }),
            None => {
                let place = format!("bufferViews[{view_index}]");
                Err(fault(path, &place, &format!("reaches beyond the {} bytes of its buffer", buffer.len())))
            }
        }
    }

    /// A buffer's bytes: the chunk of a `.glb`, a `data:` URI, or a file beside the scene.
    fn buffer(&mut self, index: usize, reader: &mut Reader) -> Result<&[u8]> {
        let bad = |what: &str| fault(self.path, &format!("buffers[{index}]"), what);
        let Some(uri) = &self.root.buffers[index].uri else {
            return self.chunk.filter(|_| index == 0).ok_or_else(|| bad("has neither a uri nor a binary chunk"));
        };
        if self.read[index].is_none() {
            self.read[index] = Some(match uri.strip_prefix("data:") {
                Some(data) => base64(data).map_err(|why| bad(&why))?,
                None => reader.read(&self.path.parent().unwrap_or(Path::new("")).join(percent_decoded(uri)))?,
            });
        }
        Ok(self.read[index].as_deref().unwrap_or_default())
    }
}

/// The bytes of a `data:` URI.
fn base64(data: &str) -> std::result::Result<Vec<u8>, String> {
    let Some((_, text)) = data.split_once(";base64,") else { return Err("has a data: URI without base64".into()) };
    // Exporters do not agree on padding.
    let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let base64 = GeneralPurpose::new(&base64::alphabet::STANDARD, config);
    base64.decode(text).map_err(|e| format!("is no base64: {e}"))
}

/// A URI's %20 and the like as the characters they stand for.
fn percent_decoded(uri: &str) -> String {
    let (mut out, mut rest) = (Vec::new(), uri.as_bytes());
    while let Some((&first, more)) = rest.split_first() {
        let hex = (first == b'%').then(|| more.get(..2)).flatten().and_then(|h| std::str::from_utf8(h).ok());
        match hex.and_then(|h| u8::from_str_radix(h, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                rest = &more[2..];
            }
            None => {
                out.push(first);
                rest = more;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[test]
fn uris_name_files() {
    for (uri, name) in [("a%20b.bin", "a b.bin"), ("%C3%A9.bin", "\u{e9}.bin"), ("100%", "100%"), ("%zz%4", "%zz%4"), ("", "")] {
        assert_eq!(percent_decoded(uri), name);
    }
}
