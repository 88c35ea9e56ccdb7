//! Colour: whether the bands differ.

use super::{Name, percent, shared, told};
use crate::output::report::EffectReport;
use crate::scene::{Environment, Map, Material, Scene};

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
    let mapped = |factor: [f64; 3], map: Option<Map>| match map.map(|m| &scene.textures[m.texture as usize]) {
        Some(texture) if !texture.is_grey() => {
            let texel = |i| texture.texel(i % texture.width, i / texture.width);
            let spread = |t: [f32; 4]| spread([0, 1, 2].map(|k| factor[k] * f64::from(t[k])));
            (0..texture.width * texture.height).map(|i| spread(texel(i))).fold(0.0, f64::max)
        }
        _ => spread(factor),
    };
    let of = |m: &Material| mapped(m.reflectance, m.reflectance_map).max(mapped(m.emission, m.emission_map));
    let materials = scene.materials.iter().zip(used).filter(|(_, used)| *used);
    let surfaces = materials.map(|(m, _)| (of(m), m.name.as_str()));
    // Colours of light without a surface: the same bands.
    let lights = scene.lights.iter().map(|l| (spread(l.intensity), l.name.as_str()));
    let around = scene.environment.iter().map(|around| (spread_around(around), "environment"));
    let spreads = surfaces.chain(lights).chain(around);
    match spreads.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|most| most.0 > 0.0) {
        Some((most, name)) => {
            let why = format!("bands differ by up to {} ('{name}')", percent(most));
            shared(told(Name::Colour, true, why, "three bands in every sum; geometry and rays are shared"), most)
        }
        None => told(Name::Colour, false, "all is grey: the three bands are one".into(), "nothing: the solve carries one band"),
    }
}
