//! What is wrong with a scene, in words a modeller understands: the object, a number and the cure.
//!
//! [`examine`] looks for everything (`docs/doctor.md`: the checks and their thresholds); a bake looks
//! for what costs nothing and warns in the same words.

mod emitters;
mod faces;
mod finding;
mod light;
mod mesh;
mod nearest;
mod open;
mod pairs;
mod rays;
mod tally;
mod values;
mod winding;

pub use finding::{Check, Finding, Severity};

use crate::error::Result;
use crate::pass::check_depth;
use crate::scene::{Geometry, Scene};
use std::borrow::Cow;

/// Everything that is wrong with a scene, gravest first. No device is needed.
///
/// The scene may come from [`Scene::read`]: materials that a bake refuses are findings here.
///
/// Errors: those of [`Geometry::new`], materials apart; [`crate::Error::Limit`] where the hierarchy is too deep.
pub fn examine(scene: &Scene) -> Result<Vec<Finding>> {
    let mut findings = values::materials(scene);
    let scene = lightable(scene);
    let geometry = Geometry::new(&scene)?;
    check_depth(&geometry.nodes)?;
    findings.extend(quick(&scene, &geometry));
    findings.extend(costly(&scene, &geometry));
    Ok(findings)
}

/// The checks that cost next to nothing.
fn quick(scene: &Scene, geometry: &Geometry) -> Vec<Finding> {
    let mut findings = values::input(scene);
    findings.extend(faces::degenerate(scene, geometry));
    findings.extend(faces::duplicate(scene, geometry));
    findings.extend(values::unit(scene, geometry));
    findings.extend(values::far(scene, geometry));
    findings.extend(values::no_emitter(scene, geometry));
    findings
}

/// The checks that weld the mesh, shoot rays, and compare triangles: seconds for a million of them.
fn costly(scene: &Scene, geometry: &Geometry) -> Vec<Finding> {
    let mesh = mesh::Mesh::new(scene, geometry);
    let met = light::meet(&mesh);
    let (away, mut findings) = emitters::facing_away(&mesh);
    let wrong = winding::wrong(&mesh, &met, &away);
    findings.extend(winding::flipped(&mesh, &wrong));
    findings.extend(open::open(&mesh));
    findings.extend(pairs::pairs(&mesh, &wrong));
    findings
}

/// What a bake warns of: the quick checks' findings, and what the reader said as it said it.
pub(crate) fn warnings(scene: &Scene, geometry: &Geometry) -> Vec<String> {
    let read = scene.warnings.iter().cloned();
    read.chain(quick(scene, geometry).iter().filter(|f| f.check != Check::Input).map(Finding::to_string)).collect()
}

/// The scene with its impossible materials made possible, so that the rest can be looked at.
fn lightable(scene: &Scene) -> Cow<'_, Scene> {
    if (0..scene.materials.len()).all(|m| scene.check_material(m).is_ok()) {
        return Cow::Borrowed(scene);
    }
    let mut scene = scene.clone();
    let impossible: Vec<bool> = (0..scene.materials.len()).map(|m| scene.check_material(m).is_err()).collect();
    for m in scene.materials.iter_mut().zip(impossible).filter(|x| x.1).map(|x| x.0) {
        (m.reflectance_map, m.emission_map, m.alpha_map) = (None, None, None);
    }
    for m in &mut scene.materials {
        // NaN fails both comparisons and becomes the lower bound.
        m.reflectance = m.reflectance.map(|x| if x > 0.0 { x.min(0.98) } else { 0.0 });
        m.emission = m.emission.map(|x| if x > 0.0 && x.is_finite() { x } else { 0.0 });
        m.mirror = if m.mirror > 0.0 && m.emission == [0.0; 3] { m.mirror.min(0.98) } else { 0.0 };
    }
    Cow::Owned(scene)
}
