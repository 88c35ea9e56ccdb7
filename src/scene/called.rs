//! What a scene calls for, as far as kernels are compiled for it.

use crate::effects::Name;

use super::{Geometry, Obstacle, Scene, obstacle};

/// Effects of which kernels have code of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Called {
    /// The scene lies in flatland.
    pub flatland: bool,
    /// Something may stand between two points that face each other.
    pub occlusion: bool,
    /// All is grey: the solve carries one colour band.
    pub grey: bool,
    /// Light comes from where no surface is.
    pub environment: bool,
    /// And differs with the direction.
    pub environment_map: bool,
    /// There are lights without a surface.
    pub lights: bool,
}

/// Whether the bands are one.
fn equal<T: PartialEq>([r, g, b]: [T; 3]) -> bool {
    r == g && g == b
}

impl Called {
    /// What a scene will call for once it is prepared. Where faces are dropped then it may come out otherwise; kernels that
    /// are missing are compiled when they are needed.
    pub(crate) fn by_scene(scene: &Scene) -> Called {
        let around = scene.environment.as_ref();
        let map = around.and_then(|e| e.map.as_ref());
        Called {
            flatland: scene.is_flatland(),
            occlusion: scene.effects.asked(Name::Occlusion).unwrap_or_else(|| obstacle(scene) != Obstacle::None),
            grey: scene.materials.iter().all(|m| equal(m.reflectance) && equal(m.emission))
                && scene.lights.iter().all(|l| equal(l.intensity))
                && around.is_none_or(|e| equal(e.radiance))
                && map.is_none_or(|m| m.rgb.iter().all(|&c| equal(c))),
            environment: around.is_some(),
            environment_map: map.is_some(),
            lights: !scene.lights.is_empty(),
        }
    }

    /// What a prepared scene calls for.
    pub fn by(geometry: &Geometry) -> Called {
        Called {
            flatland: geometry.flatland,
            occlusion: geometry.occludes,
            grey: geometry.materials.iter().all(|m| equal(m.rho) && equal(m.emit))
                && geometry.lights.all.iter().all(|l| equal(l.value))
                && geometry.sky.is_grey(),
            environment: !geometry.sky.is_empty(),
            environment_map: geometry.sky.is_mapped(),
            lights: !geometry.lights.is_empty(),
        }
    }
}
