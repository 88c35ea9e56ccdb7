//! What happens to light on its way: ideal mirrors send it on, a medium absorbs it.

use super::light::Look;
use super::{Name, percent, shared, told, unread};
use crate::output::report::EffectReport;
use crate::scene::{Geometry, Scene};

/// Ideal mirrors.
pub(super) fn mirrors(scene: &Scene, geometry: &Geometry, look: &Look) -> EffectReport {
    let mut mirrors = geometry.tris.iter().filter(|t| t.mirror() > 0.0);
    let Some(first) = mirrors.next() else {
        return unread(scene, Name::Mirrors, &["Ks", "Ns", "illum", "metallic", "roughness"]);
    };
    let why = format!(
        "{} of {} {} are mirrors (material '{}' reflects {}); {} of the rays from surfaces meet one",
        1 + mirrors.count(),
        geometry.tris.len(),
        if geometry.flatland { "segments" } else { "triangles" },
        scene.materials[first.material as usize].name,
        percent(first.mirror().into()),
        percent(look.over_mirrors),
    );
    told(
        Name::Mirrors,
        true,
        why,
        "a walk through the hierarchy more for each mirror on a ray's way, and a cosine direction at every point",
    )
}

/// A medium that absorbs.
pub(super) fn medium(scene: &Scene, geometry: &Geometry, look: &Look) -> EffectReport {
    if geometry.sigma <= 0.0 {
        return unread(scene, Name::Medium, &["medium", "fog"]);
    }
    let absorbs = scene.absorption;
    let why = format!("the medium absorbs {absorbs} /m; it takes {} of a ray's light on its way", percent(look.in_medium));
    shared(told(Name::Medium, true, why, "an exponential for every ray and shadow ray"), look.in_medium)
}
