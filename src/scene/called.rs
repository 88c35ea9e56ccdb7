//! What a scene calls for, as far as kernels are compiled for it.

use super::geometry::frame;
use super::{Face, Geometry, Obstacle, Scene, obstacle};
use crate::effects::Name;

/// Effects of which kernels have code of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
    /// There are ideal mirrors.
    pub mirrors: bool,
    /// What a medium absorbs on a local length; 0: there is none.
    pub sigma: f32,
    /// Reflectance or emission varies over a surface.
    pub textures: bool,
    /// Something is cut out of a surface.
    pub cutouts: bool,
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
        let mirror = |face: &Face| scene.materials.get(face.material as usize).is_some_and(|m| m.mirror > 0.0);
        let scale = if scene.absorption > 0.0 { frame(scene).map_or(1.0, |(_, scale)| scale) } else { 1.0 };
        // Where faces have no texture coordinates maps are not looked at.
        let mapped: Vec<[bool; 3]> = scene.materials.iter().map(|m| m.maps().map(|map| map.is_some())).collect();
        let (mut textures, mut cutouts) = (false, false);
        for i in 0..scene.face_uvs.len().min(scene.faces.len()) {
            if let Some([rho, emit, alpha]) = mapped.get(scene.faces[i].material as usize)
                && scene.uv(i).is_some()
            {
                textures |= *rho || *emit;
                cutouts |= *alpha;
            }
        }
        Called {
            flatland: scene.is_flatland(),
            occlusion: scene.effects.asked(Name::Occlusion).unwrap_or_else(|| obstacle(scene) != Obstacle::None),
            grey: scene.materials.iter().all(|m| equal(m.reflectance) && equal(m.emission))
                && scene.has_grey_maps()
                && scene.lights.iter().all(|l| equal(l.intensity))
                && around.is_none_or(|e| equal(e.radiance))
                && map.is_none_or(|m| m.rgb.iter().all(|&c| equal(c))),
            environment: around.is_some(),
            environment_map: map.is_some(),
            lights: !scene.lights.is_empty(),
            mirrors: scene.faces.iter().any(mirror),
            sigma: (scene.absorption / scale) as f32,
            textures,
            cutouts,
        }
    }

    /// What a prepared scene calls for.
    pub fn by(geometry: &Geometry) -> Called {
        Called {
            flatland: geometry.flatland,
            occlusion: geometry.occludes,
            grey: geometry.materials.iter().all(|m| equal(m.rho) && equal(m.emit))
                && geometry.grey_maps
                && geometry.lights.all.iter().all(|l| equal(l.value))
                && geometry.sky.is_grey(),
            environment: !geometry.sky.is_empty(),
            environment_map: geometry.sky.is_mapped(),
            lights: !geometry.lights.is_empty(),
            mirrors: geometry.mirrors,
            sigma: geometry.sigma,
            textures: geometry.textured,
            cutouts: geometry.cut,
        }
    }

    /// Whether light is lost on its way.
    pub fn is_lossy(&self) -> bool {
        self.mirrors || self.sigma > 0.0
    }
}
