//! Colour: whether the bands differ.

use super::{Name, percent, shared, told};
use crate::output::report::EffectReport;
use crate::scene::{Material, Scene};

/// Largest difference between two bands, over their largest value.
fn spread(bands: [f64; 3]) -> f64 {
    let (low, high) = bands.iter().fold((f64::MAX, 0.0f64), |(l, h), &x| (l.min(x), h.max(x)));
    if high > 0.0 { (high - low) / high } else { 0.0 }
}

/// The effect.
pub(super) fn colour(scene: &Scene) -> EffectReport {
    let mut used = vec![false; scene.materials.len()];
    scene.faces.iter().for_each(|f| used[f.material as usize] = true);
    let of = |m: &Material| spread(m.reflectance).max(spread(m.emission));
    let most =
        (0..scene.materials.len()).filter(|&m| used[m]).map(|m| &scene.materials[m]).max_by(|a, b| of(a).total_cmp(&of(b)));
    // Colours of light without a surface: the same bands.
    let mut lights: Vec<([f64; 3], &str)> = scene.lights.iter().map(|l| (l.intensity, l.name.as_str())).collect();
    if let Some(around) = &scene.environment {
        let mean = around.map.as_ref().map_or([1.0; 3], |map| map.mean());
        lights.push(([0, 1, 2].map(|k| mean[k] * around.radiance[k]), "environment"));
    }
    let coloured = lights.iter().map(|&(l, name)| (spread(l), name)).max_by(|a, b| a.0.total_cmp(&b.0)).filter(|l| l.0 > 0.0);
    if let Some((spread, name)) = coloured.filter(|l| most.is_none_or(|m| of(m) < l.0)) {
        let why = format!("bands differ by up to {} ('{name}')", percent(spread));
        return shared(told(Name::Colour, true, why, "three bands in every sum; geometry and rays are shared"), spread);
    }
    match most.filter(|m| of(m) > 0.0) {
        Some(m) => {
            let why = format!("bands differ by up to {} ('{}')", percent(of(m)), m.name);
            shared(told(Name::Colour, true, why, "three bands in every sum; geometry and rays are shared"), of(m))
        }
        None => told(Name::Colour, false, "all is grey: the three bands are one".into(), "nothing: the solve carries one band"),
    }
}
