//! `.rcell`: solutions and checkpoints. Half of the broken files get their checksums put right again, or nothing behind
//! the checksums would ever be tried.

use super::{Target, run};
use raycell::scene::Material;
use raycell::{Backend, Checkpoint, Error, Event, Flow, Params, Scene, Solution, SurfacePoint, bake_from};
use serde_json::Value;
use std::cell::RefCell;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

const NAME: &str = "s.rcell";
/// Bytes before the header: magic, version, length, checksum.
const PREAMBLE: usize = 20;
/// Of files that were read, one in so many is also used.
const USED: u32 = 16;
/// Broken checkpoints that bakes go on from.
const GONE_ON: usize = 300;

const WORDS: &[&str] = &[
    "\"sections\"",
    "\"offset\":",
    "\"length\":",
    "\"crc\":",
    "\"stride\":",
    "\"data\"",
    "\"content\"",
    "\"solution\"",
    "\"checkpoint\"",
    "\"params\"",
    "\"rays\":",
    "null",
    "true",
    "false",
    "{}",
    "[]",
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "\"",
    " ",
    "\0\0\0\0",
    "\0\0\u{80}\u{7f}",
    "\u{7f}\u{7f}\u{7f}\u{7f}",
    "\u{1}\0\0\0",
    "e308",
    "-",
];

/// A lamp over a floor beside a black sheet, which is large so that the lit part has few tiles and files are small.
fn scene() -> Scene {
    let (grey, lamp) = (Material::new("grey", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.0; 3], [10.0; 3]));
    let black = Material::new("black", [0.0; 3], [0.0; 3]);
    let floor = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let light = [[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [0.0, 0.5, 1.0]];
    let sheet = [[0.0, -1.0, 0.0], [0.0, -1.0, 300.0], [300.0, -1.0, 0.0]];
    Scene::from_triangles("s", &[(floor, 0), (light, 1), (sheet, 2)], vec![grey, lamp, black]).unwrap()
}

fn params() -> Params {
    Params { rays: 1024, cells: Some(16), nodes: Some(6), gather_rays: 16, direct_samples: 64, ..Params::default() }
}

/// The files of a bake that is stopped at every event, without repetitions, and of the whole one.
fn files() -> (Vec<Vec<u8>>, Vec<Vec<u8>>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(NAME);
    let (mut solutions, mut checkpoints) = (Vec::new(), Vec::new());
    let mut reached = std::collections::HashSet::new();
    for stop in 1.. {
        let (mut saved, mut left) = (Checkpoint::default(), stop);
        let done = bake_from(&Backend::Cpu, &scene(), &params(), &mut saved, &mut |_: &Event| {
            left -= 1;
            if left == 0 { Flow::Stop } else { Flow::Continue }
        });
        if !saved.is_empty() && reached.insert(saved.reached()) {
            saved.save(&path).unwrap();
            checkpoints.push(std::fs::read(&path).unwrap());
            saved.solution(&scene(), &params()).unwrap().save(&path).unwrap();
            solutions.push(std::fs::read(&path).unwrap());
        }
        if done.is_ok() {
            break;
        }
    }
    assert!(checkpoints.len() > 4, "stages: {reached:?}");
    (solutions, checkpoints)
}

/// The file with its checksums put right and its sections where they now lie; none where its header is beyond that.
fn mended(bytes: &[u8]) -> Option<Vec<u8>> {
    let text = bytes.get(PREAMBLE..)?;
    let mut values = serde_json::Deserializer::from_slice(text).into_iter::<Value>();
    let mut header = values.next()?.ok()?;
    let end = PREAMBLE + values.byte_offset();
    let start = end + bytes[end..].iter().position(|&b| b != b' ').unwrap_or(bytes.len() - end);
    let sections = header.get_mut("sections")?.as_array_mut()?;
    let first = sections.first()?.get("offset")?.as_u64()?;
    // Offsets have ten digits at most, so that the header's length does not depend on them.
    let room = 24 * sections.len() as u64;
    let moved = (end as u64).checked_add(room)?;
    for s in sections {
        let s = s.as_object_mut()?;
        let (offset, length) = (s.get("offset")?.as_u64()?, s.get("length")?.as_u64()?);
        let from = usize::try_from(offset.wrapping_sub(first)).ok().and_then(|o| o.checked_add(start));
        let range = from.and_then(|from| Some(from..from.checked_add(usize::try_from(length).ok()?)?));
        s.insert("crc".into(), crc32fast::hash(range.and_then(|r| bytes.get(r)).unwrap_or_default()).into());
        s.insert("offset".into(), offset.wrapping_sub(first).wrapping_add(moved).into());
    }
    let mut text = serde_json::to_vec(&header).ok()?;
    if (PREAMBLE + text.len()) as u64 > moved {
        return None;
    }
    text.resize(moved as usize - PREAMBLE, b' ');
    let mut out = bytes[..8].to_vec();
    out.extend(&bytes[8..12]);
    out.extend((text.len() as u32).to_le_bytes());
    let mut crc = crc32fast::Hasher::new();
    crc.update(&out[8..16]);
    crc.update(&text);
    out.extend(crc.finalize().to_le_bytes());
    out.extend(text);
    out.extend(&bytes[start..]);
    Some(out)
}

/// The broken file, mended in half of the cases, and its checksum to tell cases by.
fn tried(bytes: &[u8]) -> (Vec<u8>, u32) {
    let crc = crc32fast::hash(bytes);
    let mended = if crc.is_multiple_of(2) { mended(bytes) } else { None };
    (mended.unwrap_or_else(|| bytes.to_vec()), crc / 2)
}

fn fuzz(format: &str, seeds: &[Vec<u8>], read: &dyn Fn(&[u8]) -> Result<(), String>) {
    let seeds: Vec<&[u8]> = seeds.iter().map(Vec::as_slice).collect();
    assert!(seeds.iter().all(|s| mended(s).is_some_and(|m| read(&m).is_ok())), "what is mended can be read");
    run(&Target { format, seeds: &seeds, words: WORDS, read, names_place: &|message| message.starts_with(NAME) });
}

#[test]
fn solutions() {
    let used = AtomicU32::new(0);
    fuzz("rcell-solution", &files().0, &|bytes| {
        let (bytes, case) = tried(bytes);
        let solution = Solution::from_bytes(bytes, Path::new(NAME)).map_err(|e| e.to_string())?;
        if case.is_multiple_of(USED) {
            // Light may be absurd, but must not be a panic.
            let floor = SurfacePoint { p: [0.3, 0.0, 0.3], n: [0.0, 1.0, 0.0] };
            let _ = solution.query(&Backend::Cpu, &[floor]);
            used.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    });
    assert!(used.into_inner() > 10, "broken solutions that could be read were used");
}

#[test]
fn checkpoints() {
    let (scene, params) = (scene(), params());
    let go_on = |saved: &mut Checkpoint, events: u32| {
        let mut left = events;
        bake_from(&Backend::Cpu, &scene, &params, saved, &mut |_| {
            left -= 1;
            if left == 0 { Flow::Stop } else { Flow::Continue }
        })
    };
    let fits = RefCell::new(Vec::new());
    fuzz("rcell-checkpoint", &files().1, &|bytes| {
        let (bytes, case) = tried(bytes);
        let mut saved = Checkpoint::from_bytes(bytes, Path::new(NAME)).map_err(|e| e.to_string())?;
        // A bake looks whether it fits, which is all of it that has to be quick.
        let stopped = go_on(&mut saved, 2);
        if case.is_multiple_of(USED) && matches!(stopped, Ok(_) | Err(Error::Cancelled)) {
            fits.borrow_mut().push(saved);
        }
        Ok(())
    });
    // What fits is gone on from, to whatever end that is not a panic.
    let mut fits = fits.into_inner();
    assert!(fits.len() > 10, "broken checkpoints that fit");
    for saved in fits.iter_mut().take(GONE_ON) {
        let _ = go_on(saved, u32::MAX);
    }
}
