//! Faults of triangles, counted by object.

use super::finding::Finding;
use crate::scene::Scene;
use std::collections::BTreeMap;

/// Objects named a check; the rest are counted in one line more.
pub const NAMED: usize = 10;

/// What was seen of one object (or a pair of them).
#[derive(Clone, Copy)]
pub struct Seen {
    /// How often.
    pub count: usize,
    /// The first triangle, an index into [`Scene::faces`].
    pub face: u32,
    /// The first place, world.
    pub place: [f64; 3],
}

/// Counts by key: object, or pair of objects.
pub struct Tally<K>(BTreeMap<K, Seen>);

impl<K: Ord + Copy> Tally<K> {
    pub fn new() -> Tally<K> {
        Tally(BTreeMap::new())
    }

    /// Counts one more. The example with the lowest face stays, so that the order of coming does not matter.
    pub fn add(&mut self, key: K, face: u32, place: [f64; 3]) {
        let seen = self.0.entry(key).or_insert(Seen { count: 0, face, place });
        seen.count += 1;
        if face < seen.face {
            (seen.face, seen.place) = (face, place);
        }
    }

    /// A finding a key, most frequent first; past [`NAMED`] the last one names how many more there are.
    pub fn findings(self, mut tell: impl FnMut(K, Seen) -> Finding) -> Vec<Finding> {
        let mut all: Vec<(K, Seen)> = self.0.into_iter().collect();
        all.sort_by_key(|&(key, seen)| (std::cmp::Reverse(seen.count), key));
        let more = all.len().saturating_sub(NAMED);
        let mut findings: Vec<Finding> =
            all.into_iter().take(NAMED).map(|(key, seen)| tell(key, seen).at(seen.face, seen.place)).collect();
        if let (Some(last), true) = (findings.last_mut(), more > 0) {
            last.message += &format!("; so have {more} more");
        }
        findings
    }
}

/// Name of an object, by index.
pub fn name(scene: &Scene, object: u32) -> &str {
    scene.objects.get(object as usize).map_or(&scene.name, |name| name)
}

/// The middle of a triangle or segment, world.
pub fn middle(scene: &Scene, face: u32) -> [f64; 3] {
    let c = scene.corners(face as usize);
    if scene.is_flatland() {
        return [0, 1, 2].map(|k| 0.5 * (c[0][k] + c[1][k]));
    }
    [0, 1, 2].map(|k| (c[0][k] + c[1][k] + c[2][k]) / 3.0)
}
