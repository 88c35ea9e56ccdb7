//! What a file holds and is not read, or not as it stands: told once a file, with counts.

use std::fmt::Display;
use std::path::Path;

/// Most sorts that are told apart: a file of noise must not become a warning of its size.
const SORTS: usize = 20;

/// Sorts of things, with their number and first place, in order of appearance.
#[derive(Default)]
pub struct Unread(Vec<(String, usize, String)>);

impl Unread {
    /// Counts a thing of a sort.
    pub fn add(&mut self, what: &str, place: impl Display) {
        let short: String = what.chars().take(60).collect();
        let known = |what: &str| self.0.iter().position(|e| e.0 == what);
        let (what, known) = match known(&short) {
            None if self.0.len() >= SORTS => ("other".into(), known("other")),
            known => (short, known),
        };
        match known {
            Some(i) => self.0[i].1 += 1,
            None => self.0.push((what, 1, place.to_string())),
        }
    }

    /// One warning for the file; none where everything was read.
    pub fn warn(&self, path: &Path, warnings: &mut Vec<String>) {
        self.warn_as(path, "not supported and left out", "bake on without, or model it otherwise", warnings);
    }

    /// One warning that says what was done with it, and the cure.
    pub fn warn_as(&self, path: &Path, done: &str, cure: &str, warnings: &mut Vec<String>) {
        if self.0.is_empty() {
            return;
        }
        let times = |n: usize| if n == 1 { "once".into() } else { format!("{n} times, first") };
        let list: Vec<_> = self.0.iter().map(|(what, n, place)| format!("{what} ({}, {place})", times(*n))).collect();
        warnings.push(format!("{}: {done}: {}; {cure}", path.display(), list.join(", ")));
    }
}
