//! Files broken at random: whatever the bytes, a reader answers or refuses, in time, within bounds, and by name.
//!
//! Each format has a file here, with its seeds and words; `mutate` breaks them, `alloc` counts memory. What once
//! failed lies in `tests/data/fuzz/` and is read first, for ever. `RAYCELL_FUZZ_CASES` sets another number of cases.

mod alloc;
mod csv;
mod gltf;
mod mtl;
mod mutate;
mod obj;
mod rcell;
mod toml;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

#[global_allocator]
static ALLOCATOR: alloc::Counting = alloc::Counting;

/// Mutated inputs a format.
const CASES: u64 = 100_000;
/// Longest a reader may take over one input.
const TIME: Duration = Duration::from_secs(1);
/// Most memory a reader may hold for one input, bytes.
const MEMORY: usize = 1 << 30;

/// A small image.
pub fn png() -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([90 * x as u8, 200 * y as u8, 7, 255 * (x as u8 & 1)]));
    image.write_to(&mut out, image::ImageFormat::Png).expect("a png");
    out.into_inner()
}

/// What a reader is tried on.
pub struct Target<'a> {
    /// The format: the start of the names of its files in `tests/data/fuzz/`.
    pub format: &'a str,
    /// Small files that are right, to be broken.
    pub seeds: &'a [&'a [u8]],
    /// Words of the format, put in and swapped.
    pub words: &'a [&'a str],
    /// Reads the bytes; a refusal gives its message.
    pub read: &'a dyn Fn(&[u8]) -> Result<(), String>,
    /// Whether a message names its place: the file, and line or object.
    pub names_place: &'a dyn Fn(&str) -> bool,
}

/// Reads what has failed before, each seed, and [`CASES`] broken seeds.
pub fn run(target: &Target) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzz");
    for file in std::fs::read_dir(&folder).expect("tests/data/fuzz").map(|f| f.expect("a file").path()) {
        if file.file_name().is_some_and(|n| n.to_string_lossy().starts_with(target.format)) {
            let fault = check(target, &std::fs::read(&file).expect("a kept input"));
            assert_eq!(fault.err(), None, "{}", file.display());
        }
    }
    for (i, seed) in target.seeds.iter().enumerate() {
        assert_eq!((target.read)(seed), Ok(()), "seed {i} of {} should be read", target.format);
    }
    let cases = std::env::var("RAYCELL_FUZZ_CASES").map_or(CASES, |n| n.parse().expect("a number of cases"));
    let mut refused = 0;
    for case in 0..cases {
        let input = mutate::mutated(target.seeds, target.words, case);
        match check(target, &input) {
            Ok(read) => refused += !read as u64,
            Err(fault) => {
                let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{case}", target.format));
                std::fs::write(&kept, &input).expect("the failing input is kept");
                panic!(
                    "{} case {case}: {fault}; the input lies in {}: keep it in tests/data/fuzz",
                    target.format,
                    kept.display()
                );
            }
        }
    }
    // Mutations that break nothing, or everything, would prove nothing.
    assert!(cases / 10 < refused && refused < cases - cases / 100, "{}: {refused} of {cases} refused", target.format);
}

/// Whether an input was read (true) or refused as it should be; else what is wrong.
fn check(target: &Target, input: &[u8]) -> Result<bool, String> {
    let begin = Instant::now();
    let (result, peak) = alloc::peak(|| catch_unwind(AssertUnwindSafe(|| (target.read)(input))));
    let took = begin.elapsed();
    match result {
        Err(_) => Err("panicked".into()),
        _ if took > TIME => Err(format!("took {took:?}")),
        _ if peak > MEMORY => Err(format!("held {peak} bytes")),
        Ok(Err(message)) if !(target.names_place)(&message) => Err(format!("no place is named in '{message}'")),
        Ok(result) => Ok(result.is_ok()),
    }
}
