//! Colour: whether the bands differ.

use super::{Name, percent, shared, told};
use crate::output::report::EffectReport;
use crate::scene::{Environment, Material, Scene};

/// Largest difference between two bands, over their largest value.
fn spread(bands: [f64; 3]) -> f64 {
    let (low, high) = bands.iter().fold((f64::MAX, 0.0f64), |(l, h), &x| (l.min(x), h.max(x)));
    if high > 0.0 { (high - low) / high } else { 0.0 }
}

/// The same of an environment, over all of its map.
fn spread_around(around: &Environment) -> f64 {
    let Some(map) = &around.map else { return spread(around.radiance) };
    let (mut most, mut apart) = (0.0, 0.0);
    for texel in &map.rgb {
        let seen = [0, 1, 2].map(|k| f64::from(texel[k]) * around.radiance[k]);
        let high = seen.iter().fold(0.0, |a: f64, &b| a.max(b));
        most += high;
        apart += high * spread(seen);
    }
    if most > 0.0 { apart / most } else { 0.0 }
}

/// The effect.
pub(super) fn colour(scene: &Scene) -> EffectReport {
    let mut used = vec![false; scene.materials.len()];
    scene.faces.iter().for_each(|f| used[f.material as usize] = true);
    let of = |m: &Material| spread(m.reflectance).max(spread(m.emission));
    let most =
        (0..scene.materials.len()).filter(|&m| used[m]).map(|m| &scene.materials[m]).max_by(|a, b| of(a).total_cmp(&of(b)));
    // Colours of light without a surface: the same bands.
    let mut lights: Vec<(f64, &str)> = scene.lights.iter().map(|l| (spread(l.intensity), l.name.as_str())).collect();
    lights.extend(scene.environment.as_ref().map(|around| (spread_around(around), "environment")));
    let coloured = lights.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).filter(|l| l.0 > 0.0);
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
