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
        let grey = scene.materials.iter().all(|m| equal(m.reflectance) && equal(m.emission));
        Called {
            flatland: scene.is_flatland(),
            grey: grey && scene.has_grey_maps(),
            occlusion: scene.effects.asked(Name::Occlusion).unwrap_or_else(|| obstacle(scene) != Obstacle::None),
            textures,
            cutouts,
        }
    }

    /// What a prepared scene calls for.
    pub fn by(geometry: &Geometry) -> Called {
        let grey = geometry.grey_maps && geometry.materials.iter().all(|m| equal(m.rho) && equal(m.emit));
        let (textures, cutouts) = (geometry.textured, geometry.cut);
        Called { flatland: geometry.flatland, occlusion: geometry.occludes, grey, textures, cutouts }
    }
}
