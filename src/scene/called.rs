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
}

/// Whether the bands are one.
fn equal<T: PartialEq>([r, g, b]: [T; 3]) -> bool {
    r == g && g == b
}

impl Called {
    /// What a scene will call for once it is prepared. Where faces are dropped then it may come out otherwise; kernels that
    /// are missing are compiled when they are needed.
    pub(crate) fn by_scene(scene: &Scene) -> Called {
        Called {
            flatland: scene.is_flatland(),
            grey: scene.materials.iter().all(|m| equal(m.reflectance) && equal(m.emission)),
            occlusion: scene.effects.asked(Name::Occlusion).unwrap_or_else(|| obstacle(scene) != Obstacle::None),
        }
    }

    /// What a prepared scene calls for.
    pub fn by(geometry: &Geometry) -> Called {
        let grey = geometry.materials.iter().all(|m| equal(m.rho) && equal(m.emit));
        Called { flatland: geometry.flatland, occlusion: geometry.occludes, grey }
    }
}
