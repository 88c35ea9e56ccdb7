//! What a scene calls for, as far as kernels are compiled for it.

use super::{Geometry, Obstacle, Scene, obstacle};

/// Effects of which kernels have code of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Called {
    /// The scene lies in flatland.
    pub flatland: bool,
    /// Something may stand between two points that face each other.
    pub occlusion: bool,
}

impl Called {
    /// What a scene will call for once it is prepared. Where faces are dropped then it may come out otherwise; kernels that
    /// are missing are compiled when they are needed.
    pub(crate) fn by_scene(scene: &Scene) -> Called {
        Called { flatland: scene.is_flatland(), occlusion: obstacle(scene) != Obstacle::None }
    }

    /// What a prepared scene calls for.
    pub fn by(geometry: &Geometry) -> Called {
        Called { flatland: geometry.flatland, occlusion: geometry.occludes }
    }
}
