//! Colour: whether the bands differ.

use super::{Name, percent, shared, told};
use crate::output::report::EffectReport;
use crate::scene::{Map, Material, Scene};

/// Largest difference between two bands, over their largest value.
fn spread(bands: [f64; 3]) -> f64 {
    let (low, high) = bands.iter().fold((f64::MAX, 0.0f64), |(l, h), &x| (l.min(x), h.max(x)));
    if high > 0.0 { (high - low) / high } else { 0.0 }
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
    let spreads = (0..scene.materials.len()).filter(|&m| used[m]).map(|m| (of(&scene.materials[m]), m));
    match spreads.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|most| most.0 > 0.0) {
        Some((most, m)) => {
            let why = format!("bands differ by up to {} ('{}')", percent(most), scene.materials[m].name);
            shared(told(Name::Colour, true, why, "three bands in every sum; geometry and rays are shared"), most)
        }
        None => told(Name::Colour, false, "all is grey: the three bands are one".into(), "nothing: the solve carries one band"),
    }
}
