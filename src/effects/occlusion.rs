//! Occlusion: what stands in the way, or the proof that nothing can.

use super::light::Look;
use super::{Name, percent, shared, told};
use crate::output::report::EffectReport;
use crate::scene::{Geometry, Obstacle, Scene, obstacle};

/// What it costs.
const COST: &str = "a walk through the hierarchy for every shadow ray";

/// The effect.
pub(super) fn occlusion(scene: &Scene, geometry: &Geometry, look: &Look) -> EffectReport {
    if !geometry.occludes {
        let why = "the scene is convex: no surface lies behind another's plane, so nothing can stand in light's way";
        let cost = match geometry.is_surfaceless() {
            false => "nothing: no shadow ray is cast",
            true => "shadow rays to lights and the sky only, which may be without",
        };
        return told(Name::Occlusion, false, why.into(), cost);
    }
    if scene.effects.asked(Name::Occlusion) == Some(true) {
        return told(Name::Occlusion, true, "asked on".into(), COST);
    }
    let object = match obstacle(scene) {
        Obstacle::Behind(face) => scene.objects.get(scene.faces[face as usize].object as usize).map(String::as_str),
        _ => None,
    };
    let first = object.filter(|name| !name.is_empty()).map_or(String::new(), |name| format!(" (see '{name}')"));
    let why = match look.blocked {
        _ if look.lines == 0 => format!("the scene is not convex{first}"),
        0.0 => format!("the scene is not convex{first}, though of {} lines of sight to emitters none was blocked", look.lines),
        share => format!("the scene is not convex{first}: {} of the lines of sight to emitters are blocked", percent(share)),
    };
    shared(told(Name::Occlusion, true, why, COST), look.blocked)
}
