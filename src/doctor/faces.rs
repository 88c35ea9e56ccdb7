//! Triangles that a bake drops: those without an area, and those that are there twice.

use super::finding::{Check, Finding, count, faces};
use super::tally::{Tally, middle, name};
use crate::scene::{Geometry, Scene};

/// Triangles without an area, by object.
pub fn degenerate(scene: &Scene, geometry: &Geometry) -> Vec<Finding> {
    let mut tally = Tally::new();
    for &face in &geometry.degenerate {
        tally.add(scene.faces[face as usize].object, face, middle(scene, face));
    }
    let [one, many] = faces(scene);
    tally.findings(|object, seen| {
        let name = name(scene, object);
        let message = format!("object '{name}': {} without an area, left out", count(seen.count, one));
        let cure = "delete them, or merge their vertices, in the modeller";
        Finding::new(Check::Degenerate, name, seen.count as f64, many, message, cure)
    })
}

/// Triangles that repeat another, corner by corner, by object.
pub fn duplicate(scene: &Scene, geometry: &Geometry) -> Vec<Finding> {
    let object = |face: u32| scene.faces[face as usize].object;
    let mut tally = Tally::new();
    for &[face, first] in &geometry.duplicate {
        tally.add([object(face), object(first)], face, middle(scene, face));
    }
    let [one, many] = faces(scene);
    tally.findings(|[object, first], seen| {
        let (name, of) = (name(scene, object), name(scene, first));
        let twice = if object == first { String::new() } else { format!(" of object '{of}'") };
        let message = format!("object '{name}': {}{twice} repeated, left out", count(seen.count, one));
        let cure = "delete the copy in the modeller";
        let finding = Finding::new(Check::Duplicate, name, seen.count as f64, many, message, cure);
        Finding { other: (object != first).then(|| of.into()), ..finding }
    })
}
