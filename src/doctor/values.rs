//! Materials and sizes: what can be judged by numbers alone.

use super::finding::{Check, Finding, Severity, faces, metres};
use super::tally::name;
use crate::error::Error;
use crate::scene::{Geometry, Scene};

/// A scene longer than this is suspicious, metres.
const LONG: f64 = 1000.0;
/// A scene shorter than this is suspicious, metres.
const SHORT: f64 = 0.05;
/// Coarsest spacing of single-precision coordinates, as a share of the scene's size.
const SPACING: f64 = 1e-5;

/// What the reader found odd.
pub fn input(scene: &Scene) -> Vec<Finding> {
    let tell = |text: &String| {
        let (message, cure) = text.split_once("; ").unwrap_or((text, "correct the file or export it anew"));
        Finding::new(Check::Input, &scene.name, 1.0, "warnings", message.into(), cure)
    };
    scene.warnings.iter().map(tell).collect()
}

/// Materials that a bake refuses, in its own words.
pub fn materials(scene: &Scene) -> Vec<Finding> {
    let mut findings = Vec::new();
    for m in 0..scene.materials.len() {
        let Err(error) = scene.check_material(m) else { continue };
        let (check, number, unit) = match &error {
            Error::InvalidReflectance { value, .. } => (Check::Reflectance, *value, "reflectance"),
            Error::InvalidEmission { value, .. } => (Check::Emission, *value, "W/m2/sr"),
            Error::InvalidMirror { .. } => (Check::Reflectance, scene.materials[m].mirror, "reflectance"),
            _ => continue,
        };
        let user = scene.faces.iter().position(|f| f.material as usize == m);
        let object = user.map_or(scene.name.as_str(), |f| name(scene, scene.faces[f].object));
        let text = format!("object '{object}', {error}");
        let (message, cure) = text.split_once("; ").unwrap_or((&text, ""));
        let finding = Finding::new(check, object, number, unit, message.into(), cure);
        findings.push(Finding { severity: Severity::Error, face: user.map(|f| f as u32), ..finding });
    }
    findings
}

/// A scene that is hardly in metres.
pub fn unit(scene: &Scene, geometry: &Geometry) -> Option<Finding> {
    let size = geometry.extent();
    let guess = match size {
        s if s > LONG => "millimetres or centimetres",
        s if s < SHORT => "kilometres or another larger unit",
        _ => return None,
    };
    let message = format!("{}: the scene is {} long; its numbers look like {guess}, not metres", scene.name, metres(size));
    let cure = "say the file's unit, as --unit 0.001 for millimetres, or export in metres";
    Some(Finding::new(Check::Unit, &scene.name, size, "m", message, cure))
}

/// A scene whose place eats up the digits of its shape.
pub fn far(scene: &Scene, geometry: &Geometry) -> Option<Finding> {
    let size = geometry.extent();
    let reach = geometry.center.iter().fold(0.0, |m: f64, c| m.max(c.abs())) + 0.5 * size;
    let spacing = (reach as f32).next_up() as f64 - reach as f32 as f64;
    if spacing <= SPACING * size {
        return None;
    }
    let distance = geometry.center.iter().map(|c| c * c).sum::<f64>().sqrt();
    let message = format!(
        "{}: the scene lies {} from the origin, where single-precision coordinates are {} apart",
        scene.name,
        metres(distance),
        metres(spacing)
    );
    let cure = "move it to the origin in the modeller";
    Some(Finding::new(Check::FarFromOrigin, &scene.name, distance, "m", message, cure))
}

/// A scene in which nothing shines.
pub fn no_emitter(scene: &Scene, geometry: &Geometry) -> Option<Finding> {
    geometry.emitters.is_empty().then(|| {
        let message = format!("{}: 0 of {} {} emit, all will be black", scene.name, geometry.tris.len(), faces(scene)[1]);
        let cure = match scene.is_flatland() {
            false => "give the lamp's material an emission: Ke in the .mtl, W/m2/sr, as `Ke 10 10 10`",
            true => "give the lamp's material an emission, W/m, as `radiosity = 1`",
        };
        Finding::new(Check::NoEmitter, &scene.name, 0.0, "emitters", message, cure)
    })
}
