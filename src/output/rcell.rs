//! `.rcell`: a JSON header and named binary sections, little endian, versioned and checksummed. Solutions and
//! checkpoints are such files.
//!
//! ```text
//! magic    8 bytes   89 'RCEL' 0D 0A 1A   (as PNG's: shows text-mode damage at once)
//! version  u32       1
//! length   u32       of the header, bytes
//! crc      u32       CRC-32 of version, length and header
//! header   JSON      padded with spaces; {"raycell": .., "sections": [{name, type, stride, offset, length, crc}, ..], "data": <the caller's>}
//! sections           each from a multiple of 16 from the file's start, zeros between
//! ```
//! Whoever holds the file can read it: the header says what each section is made of.

use super::atomic;
use crate::error::{Error, Result};
use bytemuck::Pod;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};

#[cfg(target_endian = "big")]
compile_error!("sections are written as they lie in memory, which must be little endian");

const MAGIC: [u8; 8] = *b"\x89RCEL\r\n\x1a";
/// Version of the layout above; a reader refuses newer ones.
pub const VERSION: u32 = 1;
const PREAMBLE: usize = 20;
/// Sections begin at multiples of this.
const ALIGN: usize = 16;

/// A named run of bytes to be written.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it is made of, for a reader without this program (`f32`, `Node`).
    pub kind: &'a str,
    /// Bytes an element.
    pub stride: usize,
    /// The bytes.
    pub bytes: &'a [u8],
}

impl<'a> Section<'a> {
    /// A section of records.
    pub fn new<T: Pod>(name: &'a str, records: &'a [T]) -> Section<'a> {
        Section { name, kind: kind::<T>(), stride: size_of::<T>(), bytes: bytemuck::cast_slice(records) }
    }
}

/// The name of a type without its path.
fn kind<T>() -> &'static str {
    std::any::type_name::<T>().rsplit("::").next().unwrap_or("u8")
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Entry {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    stride: u64,
    offset: u64,
    length: u64,
    crc: u32,
}

#[derive(Serialize, Deserialize)]
struct Header {
    raycell: String,
    sections: Vec<Entry>,
    data: Value,
}

/// Writes a container. Same input, same bytes. Errors: [`Error::Write`].
pub fn write(path: &Path, data: &impl Serialize, sections: &[Section]) -> Result<()> {
    let failed = |e: String| Error::Write { path: path.into(), source: std::io::Error::other(e) };
    let data = serde_json::to_value(data).map_err(|e| failed(e.to_string()))?;
    // Offsets are part of the header whose length moves them: iterate until they stand (twice, as a rule).
    let mut start = 0;
    let header = loop {
        let mut offset = start;
        let entries = sections
            .iter()
            .map(|s| {
                let entry = Entry {
                    name: s.name.into(),
                    kind: s.kind.into(),
                    stride: s.stride as u64,
                    offset: offset as u64,
                    length: s.bytes.len() as u64,
                    crc: crc32fast::hash(s.bytes),
                };
                offset = (offset + s.bytes.len()).next_multiple_of(ALIGN);
                entry
            })
            .collect();
        let header = Header { raycell: env!("CARGO_PKG_VERSION").into(), sections: entries, data: data.clone() };
        let mut text = serde_json::to_vec(&header).map_err(|e| failed(e.to_string()))?;
        if PREAMBLE + text.len() <= start {
            text.resize(start - PREAMBLE, b' ');
            break text;
        }
        start = (PREAMBLE + text.len()).next_multiple_of(ALIGN);
    };
    let length = u32::try_from(header.len()).map_err(|_| failed("the header is too large".into()))?;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes[8..16]);
    crc.update(&header);
    bytes.extend(crc.finalize().to_le_bytes());
    bytes.extend(header);
    for s in sections {
        bytes.resize(bytes.len().next_multiple_of(ALIGN), 0);
        bytes.extend(s.bytes);
    }
    atomic::write(path, &bytes)
}

/// A container that has been read and found whole.
#[derive(Clone, Debug)]
pub struct Container {
    /// The caller's part of the header.
    pub data: Value,
    path: PathBuf,
    bytes: Vec<u8>,
    sections: Vec<(Entry, Range<usize>)>,
}

/// Reads a container, checking every byte of it.
///
/// Errors: [`Error::Read`]; [`Error::Format`] where the file is no container, of a newer version,
/// truncated, or damaged.
pub fn read(path: &Path) -> Result<Container> {
    parse(std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?, path)
}

/// As [`read`], from memory; `path` names it in messages. Takes no more memory than a few times the bytes given.
pub fn parse(bytes: Vec<u8>, path: &Path) -> Result<Container> {
    let fail = |what: &str, cure: &str| Error::Format { path: path.into(), line: None, what: what.into(), cure: cure.into() };
    let truncated = || fail("the file is truncated", "copy it again, or bake it again");
    let damaged = |what: &str| fail(&format!("the file is damaged ({what})"), "copy it again, or bake it again");

    // Preamble: magic before length, so that any other file is told from a short solution.
    if bytes.len() < MAGIC.len() || bytes[..8] != MAGIC {
        if !bytes.is_empty() && MAGIC.starts_with(&bytes) {
            return Err(truncated());
        }
        return Err(fail("this is not a raycell file", "give one that raycell bake has written"));
    }
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let version = word(8).ok_or_else(truncated)?;
    if version > VERSION {
        let what = format!("the file has format version {version}, this program reads up to {VERSION}");
        return Err(fail(&what, "use a newer raycell, or bake it again"));
    }
    let length = word(12).ok_or_else(truncated)? as usize;
    let stored = word(16).ok_or_else(truncated)?;
    let text = bytes.get(PREAMBLE..).and_then(|b| b.get(..length)).ok_or_else(truncated)?;
    let mut crc = crc32fast::Hasher::new();
    crc.update(&bytes[8..16]);
    crc.update(text);
    if crc.finalize() != stored || version == 0 {
        return Err(damaged("checksum of the header"));
    }
    let header: Header = serde_json::from_slice(text).map_err(|e| damaged(&e.to_string()))?;

    // Sections follow one another; nothing but zeros lies between and nothing behind.
    let mut end = PREAMBLE + length;
    let mut entries: Vec<Entry> = Vec::new();
    let mut ranges = Vec::new();
    for e in header.sections {
        let range = usize::try_from(e.offset)
            .ok()
            .zip(e.offset.checked_add(e.length).and_then(|end| usize::try_from(end).ok()))
            .map(|(a, b)| a..b)
            .filter(|r| r.start >= end && entries.iter().all(|other| other.name != e.name))
            .ok_or_else(|| damaged("section table"))?;
        let section = bytes.get(range.clone()).ok_or_else(truncated)?;
        if crc32fast::hash(section) != e.crc {
            return Err(damaged(&format!("checksum of section '{}'", e.name)));
        }
        if bytes[end..range.start].iter().any(|&b| b != 0) {
            return Err(damaged("padding"));
        }
        end = range.end;
        entries.push(e);
        ranges.push(range);
    }
    if end != bytes.len() {
        return Err(damaged("bytes behind the last section"));
    }
    Ok(Container { data: header.data, path: path.into(), bytes, sections: entries.into_iter().zip(ranges).collect() })
}

impl Container {
    /// Whether there is a section of a name.
    pub fn has(&self, name: &str) -> bool {
        self.sections.iter().any(|(e, _)| e.name == name)
    }

    /// The records of a section.
    ///
    /// Errors: [`Error::Format`] where the section is missing or its records are of another size.
    pub fn get<T: Pod>(&self, name: &str) -> Result<Vec<T>> {
        let found = self.sections.iter().find(|(e, _)| e.name == name);
        let (entry, range) = found.ok_or_else(|| self.fail(&format!("section '{name}' is missing")))?;
        if entry.stride != size_of::<T>() as u64 || entry.kind != kind::<T>() || range.len() % size_of::<T>().max(1) != 0 {
            let (there, asked) = ((&entry.kind, entry.stride), (kind::<T>(), size_of::<T>()));
            return Err(
                self.fail(&format!("section '{name}' holds {} of {} bytes, not {} of {}", there.0, there.1, asked.0, asked.1))
            );
        }
        Ok(bytemuck::pod_collect_to_vec(&self.bytes[range.clone()]))
    }

    /// The caller's part of the header, which says that the container holds `content`.
    ///
    /// Errors: [`Error::Format`] where it holds something else, or cannot be read.
    pub fn header<T: DeserializeOwned>(&self, content: &str) -> Result<T> {
        let found = self.data["content"].as_str().unwrap_or("something else");
        if found != content {
            return Err(self.fail(&format!("the file holds '{found}', not a {content}")));
        }
        serde_json::from_value(self.data.clone()).map_err(|e| self.fail(&format!("the header cannot be read: {e}")))
    }

    /// A refusal of the file.
    pub(crate) fn fail(&self, what: &str) -> Error {
        let cure = "bake it again with this version of raycell".into();
        Error::Format { path: self.path.clone(), line: None, what: what.into(), cure }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(path: &Path) -> Vec<u8> {
        let data = serde_json::json!({"seed": 7, "x": 0.1});
        let (a, b) = ([1.0f32, 2.0, 3.0], [[1u32, 2], [3, 4], [5, 6]]);
        write(path, &data, &[Section::new("a", &a), Section::new::<u8>("none", &[]), Section::new("b", &b)]).unwrap();
        std::fs::read(path).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("s.rcell");
        let bytes = sample(&path);
        assert_eq!(bytes, sample(&path), "same input, same bytes");
        let c = read(&path).unwrap();
        assert_eq!(c.data["seed"], 7);
        assert_eq!(c.get::<f32>("a").unwrap(), [1.0, 2.0, 3.0]);
        assert_eq!(c.get::<[u32; 2]>("b").unwrap(), [[1, 2], [3, 4], [5, 6]]);
        assert!(c.get::<u8>("none").unwrap().is_empty());
        assert!(c.get::<f32>("c").unwrap_err().to_string().contains("section 'c' is missing"));
        assert!(c.get::<u8>("a").is_err());
        assert_eq!(bytes.windows(2).filter(|w| w == b"\"f").count(), 1, "the type is named");
        assert!(c.sections.iter().all(|(_, range)| range.start % 16 == 0));
        // Nothing at all is a container too.
        write(&path, &Value::Null, &[]).unwrap();
        assert!(read(&path).unwrap().data.is_null());
    }

    #[test]
    fn damage_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("s.rcell");
        let bytes = sample(&path);
        let error = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read(&path).map(|_| ()).expect_err("damage went unseen").to_string()
        };
        // Every byte, every bit of it in turn.
        for i in 0..bytes.len() {
            let mut wrong = bytes.clone();
            wrong[i] ^= 1 << (i % 8);
            let got = error(&wrong);
            let expected = match i {
                0..8 => "not a raycell file",
                8..12 => "version",
                12..16 => "",
                _ => "damaged",
            };
            assert!(got.contains(expected) || (8..12).contains(&i) && got.contains("damaged"), "byte {i}: {got}");
        }
        for n in 0..bytes.len() {
            let got = error(&bytes[..n]);
            assert!(got.contains(if n == 0 { "not a raycell" } else { "truncated" }), "{n} bytes: {got}");
        }
        assert!(error(b"v 0 0 0\n").contains("not a raycell file"));
        assert!(error(&[bytes.clone(), vec![1]].concat()).contains("behind"));
        let mut newer = bytes.clone();
        newer[8] = 2;
        assert!(error(&newer).contains("format version 2"));
        assert!(matches!(read(Path::new("no/such")), Err(Error::Read { .. })));
    }
}
