//! Light that comes from no surface: the environment, and lights.

use super::light::Look;
use super::{Name, percent, shared, told};
use crate::output::report::EffectReport;
use crate::scene::{Geometry, LightKind, Scene};

/// The environment.
pub(super) fn environment(scene: &Scene, geometry: &Geometry, look: &Look) -> EffectReport {
    let Some(environment) = scene.environment.as_ref().filter(|_| !geometry.sky.is_empty()) else {
        return told(Name::Environment, false, "around the scene all is black".into(), "nothing");
    };
    let share = percent(look.sky);
    let effect = match &environment.map {
        None => {
            let why = format!("the sky has one radiance and brings {share} of the direct light");
            told(Name::Environment, true, why, "a shadow ray a sample of direct light, more where it is half hidden")
        }
        Some(map) => {
            let why =
                format!("the sky is a map of {} by {} texels and brings {share} of the direct light", map.width, map.height);
            told(Name::Environment, true, why, "shadow rays by its radiance and by cosines; 16 bytes a texel on the device")
        }
    };
    shared(effect, look.sky * (1.0 - look.reflected))
}

/// Lights without a surface.
pub(super) fn lights(scene: &Scene, geometry: &Geometry, look: &Look) -> EffectReport {
    if geometry.lights.is_empty() {
        return told(Name::Lights, false, "no light is without a surface".into(), "nothing");
    }
    let count = |is: fn(&LightKind) -> bool, one: &str| {
        let n = scene.lights.iter().filter(|l| is(&l.kind) && l.intensity != [0.0; 3]).count();
        (n > 0).then(|| if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") })
    };
    let sorts = [
        count(|k| matches!(k, LightKind::Sun { .. }), "sun"),
        count(|k| matches!(k, LightKind::Point { .. }), "point"),
        count(|k| matches!(k, LightKind::Spot { .. }), "spot"),
    ];
    let sorts = sorts.into_iter().flatten().collect::<Vec<_>>().join(", ");
    let first = scene.lights.iter().find(|l| l.intensity != [0.0; 3]).map_or("", |l| &l.name);
    let why = format!("{sorts} (see '{first}'); {} of the direct light", percent(look.lights));
    let effect = told(Name::Lights, true, why, "a shadow ray a round for each point and spot, up to 8, and some for each sun");
    shared(effect, look.lights * (1.0 - look.reflected))
}
