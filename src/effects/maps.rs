//! Textures and cut-outs: how much of the surface has them.

use super::{Name, percent, told, unread};
use crate::output::report::EffectReport;
use crate::scene::{Geometry, Scene};
use crate::twin::texture::{EMIT, MASK, RHO, has};

/// Share of the area whose triangles have one of some maps, and the images that these are of.
fn share(scene: &Scene, geometry: &Geometry, maps: &[usize]) -> (f64, Vec<String>) {
    let mapped = |t: usize| maps.iter().any(|&map| has(geometry, t as u32, map));
    let (mut area, mut named) = (0.0, Vec::new());
    let mut seen = vec![false; scene.textures.len()];
    for t in (0..geometry.tris.len()).filter(|&t| mapped(t)) {
        area += geometry.areas[t];
        let of = scene.materials[geometry.tris[t].material as usize].maps();
        for map in maps.iter().filter_map(|&m| of[m]) {
            if !std::mem::replace(&mut seen[map.texture as usize], true) {
                named.push(format!("'{}'", scene.textures[map.texture as usize].name));
            }
        }
    }
    (area / geometry.areas.iter().sum::<f64>(), named)
}

/// The first few names, and how many more.
fn list(names: &[String]) -> String {
    let shown = names[..names.len().min(3)].join(", ");
    if names.len() > 3 { format!("{shown} and {} more", names.len() - 3) } else { shown }
}

/// Textures of reflectance and emission.
pub(super) fn textures(scene: &Scene, geometry: &Geometry) -> EffectReport {
    if !geometry.textured {
        return unread(scene, Name::Textures, &["map_Kd", "map_Ke", "texture"]);
    }
    let (rho, of) = share(scene, geometry, &[RHO]);
    let (emit, lamps) = share(scene, geometry, &[EMIT]);
    let part = |share: f64, of: &[String], what: &str| match of {
        [] => None,
        of => Some(format!("{what} varies over {} of the area ({})", percent(share), list(of))),
    };
    let why = [part(rho, &of, "reflectance"), part(emit, &lamps, "emission")];
    let texels = format!("{} MiB of texels, read at every ray's ends", (16 * geometry.texels.len()).div_ceil(1 << 20));
    told(Name::Textures, true, why.into_iter().flatten().collect::<Vec<_>>().join("; "), &texels)
}

/// What is cut out; other ways through a surface are not built.
pub(super) fn transparency(scene: &Scene, geometry: &Geometry) -> EffectReport {
    if !geometry.cut {
        return unread(scene, Name::Transparency, &["map_d", "Tr", "Tf", "Ni", "alphaMode", "transmission"]);
    }
    let (area, of) = share(scene, geometry, &[MASK]);
    let why = format!("{} of the area is cut out by an alpha map ({})", percent(area), list(&of));
    told(Name::Transparency, true, why, "a look at the alpha where a ray meets such a triangle")
}
