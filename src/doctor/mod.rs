//! What is wrong with a scene, in words a modeller understands: the object, a number and the cure.
//!
//! [`examine`] looks for everything (`docs/doctor.md`: the checks and their thresholds); a bake looks
//! for what costs nothing and warns in the same words.

mod faces;
mod finding;
mod tally;
mod values;

pub use finding::{Check, Finding, Severity};

use crate::error::Result;
use crate::scene::{Geometry, Scene};
use std::borrow::Cow;

/// Everything that is wrong with a scene, gravest first. No device is needed.
///
/// The scene may come from [`Scene::read`]: materials that a bake refuses are findings here.
///
/// Errors: those of [`Geometry::new`], materials apart.
pub fn examine(scene: &Scene) -> Result<Vec<Finding>> {
    let mut findings = values::materials(scene);
    let scene = lightable(scene);
    let geometry = Geometry::new(&scene)?;
    findings.extend(quick(&scene, &geometry));
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

/// What a bake warns of: the quick checks' findings, and what the reader said as it said it.
pub(crate) fn warnings(scene: &Scene, geometry: &Geometry) -> Vec<String> {
    let read = scene.warnings.iter().cloned();
    read.chain(quick(scene, geometry).iter().filter(|f| f.check != Check::Input).map(Finding::to_string)).collect()
}

/// The scene with its impossible materials made possible, so that the rest can be looked at.
fn lightable(scene: &Scene) -> Cow<'_, Scene> {
    if scene.materials.iter().all(|m| m.check().is_ok()) {
        return Cow::Borrowed(scene);
    }
    let mut scene = scene.clone();
    for m in &mut scene.materials {
        // NaN fails both comparisons and becomes the lower bound.
        m.reflectance = m.reflectance.map(|x| if x > 0.0 { x.min(0.98) } else { 0.0 });
        m.emission = m.emission.map(|x| if x > 0.0 && x.is_finite() { x } else { 0.0 });
    }
    Cow::Owned(scene)
}
