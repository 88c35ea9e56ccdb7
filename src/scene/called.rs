//! What a scene calls for, as far as kernels are compiled for it.

use super::geometry::frame;
use super::{Face, Geometry, Obstacle, Scene, obstacle};
use crate::effects::Name;

/// Effects of which kernels have code of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Called {
    /// The scene lies in flatland.
    pub flatland: bool,
    /// Something may stand between two points that face each other.
    pub occlusion: bool,
    /// All is grey: the solve carries one colour band.
    pub grey: bool,
    /// There are ideal mirrors.
    pub mirrors: bool,
    /// What a medium absorbs on a local length; 0: there is none.
    pub sigma: f32,
}

/// Whether the bands are one.
fn equal<T: PartialEq>([r, g, b]: [T; 3]) -> bool {
    r == g && g == b
}

impl Called {
    /// What a scene will call for once it is prepared. Where faces are dropped then it may come out otherwise; kernels that
    /// are missing are compiled when they are needed.
    pub(crate) fn by_scene(scene: &Scene) -> Called {
        let mirror = |face: &Face| scene.materials.get(face.material as usize).is_some_and(|m| m.mirror > 0.0);
        let scale = if scene.absorption > 0.0 { frame(scene).map_or(1.0, |(_, scale)| scale) } else { 1.0 };
        Called {
            flatland: scene.is_flatland(),
            grey: scene.materials.iter().all(|m| equal(m.reflectance) && equal(m.emission)),
            occlusion: scene.effects.asked(Name::Occlusion).unwrap_or_else(|| obstacle(scene) != Obstacle::None),
            mirrors: scene.faces.iter().any(mirror),
            sigma: (scene.absorption / scale) as f32,
        }
    }

    /// What a prepared scene calls for.
    pub fn by(geometry: &Geometry) -> Called {
        let grey = geometry.materials.iter().all(|m| equal(m.rho) && equal(m.emit));
        let Geometry { flatland, occludes: occlusion, mirrors, sigma, .. } = *geometry;
        Called { flatland, occlusion, grey, mirrors, sigma }
    }

    /// Whether light is lost on its way.
    pub fn is_lossy(&self) -> bool {
        self.mirrors || self.sigma > 0.0
    }
}
