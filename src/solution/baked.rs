//! What the bake of a relit solution found: the ground that every further relight starts from.

use crate::layout::NodeLight;
use crate::output::report::EstimatedError;
use crate::scene::{Face, Material, Scene};
use crate::solution::Solution;

/// A bake's own light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Baked {
    /// The materials of the bake.
    pub materials: Vec<Material>,
    /// For each material of the relit scene the one that it was.
    pub of: Vec<u32>,
    /// The nodes' light, in the bake's own scale.
    pub light: Vec<NodeLight>,
    /// The error that the bake states.
    pub error: Option<EstimatedError>,
}

impl Baked {
    /// What a solution's bake found.
    pub fn of(solution: &Solution) -> Baked {
        solution.baked().cloned().unwrap_or_else(|| Baked {
            materials: solution.scene().materials.clone(),
            of: (0..solution.scene().materials.len() as u32).collect(),
            light: solution.light().to_vec(),
            error: solution.report().estimated_error.clone(),
        })
    }

    /// The scene that was baked; `scene` is the relit one.
    pub fn scene(&self, scene: &Scene) -> Scene {
        let faces = scene.faces.iter().map(|f| Face { material: self.of[f.material as usize], ..*f }).collect();
        Scene { faces, materials: self.materials.clone(), material_places: Vec::new(), ..scene.clone() }
    }
}
