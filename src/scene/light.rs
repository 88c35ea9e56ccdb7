//! Light that comes from no surface of the scene: lights, and the environment around it.

use super::sky_map::SkyMap;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// The sun's diameter as seen from the earth, degrees.
pub const SUN_ANGLE: f64 = 0.53;
/// Most lights of a scene: a kernel asks each of them at every point.
const LIGHTS: usize = 1_024;

/// A light without a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// Its name, for messages.
    pub name: String,
    /// What it sends, linear Rec.709: of a sun the irradiance on a surface that faces it, W/m²; of a point or a spot the
    /// radiant intensity, W/sr.
    pub intensity: [f64; 3],
    /// Where it stands, and how it shines.
    pub kind: LightKind,
}

/// How a light shines. Directions have any length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightKind {
    /// From infinitely far away.
    Sun {
        /// The way its light goes.
        direction: [f64; 3],
        /// Its diameter, degrees, 0 to 90; 0 casts shadows with sharp edges.
        angle: f64,
    },
    /// From a point, all ways alike.
    Point {
        /// Where it stands, metres.
        position: [f64; 3],
    },
    /// From a point, within a cone. Between both angles the intensity falls as glTF's `KHR_lights_punctual` proposes: with
    /// the square of (cos - cos outer)/(cos inner - cos outer).
    Spot {
        /// Where it stands, metres.
        position: [f64; 3],
        /// The way its light goes.
        direction: [f64; 3],
        /// Angle from the axis within which it sends all of its intensity, degrees.
        inner: f64,
        /// Angle from the axis beyond which it sends nothing, degrees, at most 90.
        outer: f64,
    },
}

impl Light {
    /// A sun as large as ours ([`SUN_ANGLE`]): `irradiance`, W/m², on a surface that faces it; `direction` is the way its light goes.
    pub fn sun(name: &str, irradiance: [f64; 3], direction: [f64; 3]) -> Light {
        Light { name: name.into(), intensity: irradiance, kind: LightKind::Sun { direction, angle: SUN_ANGLE } }
    }

    /// A point light of some radiant intensity, W/sr; 4 pi times it is its power.
    pub fn point(name: &str, intensity: [f64; 3], position: [f64; 3]) -> Light {
        Light { name: name.into(), intensity, kind: LightKind::Point { position } }
    }

    /// A spot light of some radiant intensity on its axis, W/sr; both angles are from the axis, degrees.
    pub fn spot(name: &str, intensity: [f64; 3], position: [f64; 3], direction: [f64; 3], [inner, outer]: [f64; 2]) -> Light {
        Light { name: name.into(), intensity, kind: LightKind::Spot { position, direction, inner, outer } }
    }

    /// Checks that it can shine. Errors: [`Error::InvalidLight`].
    pub fn check(&self) -> Result<()> {
        let refuse = |what: String, cure: &'static str| Err(Error::InvalidLight { light: self.name.clone(), what, cure });
        positive(&self.name, &self.intensity)?;
        let (position, direction) = match self.kind {
            LightKind::Sun { direction, .. } => (None, Some(direction)),
            LightKind::Point { position } => (Some(position), None),
            LightKind::Spot { position, direction, .. } => (Some(position), Some(direction)),
        };
        if let Some(p) = position.filter(|p| !super::fits(p)) {
            return refuse(format!("position {p:?} is not finite in 32 bits"), "give metres");
        }
        let length = |d: [f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
        if let Some(d) = direction.filter(|&d| !(length(d) > 0.0 && length(d).is_finite())) {
            return refuse(format!("direction {d:?} points nowhere"), "give the way its light goes, as [0, -1, 0] for down");
        }
        match self.kind {
            LightKind::Sun { angle, .. } if !(0.0..=90.0).contains(&angle) => {
                refuse(format!("angle {angle} is no diameter of a sun"), "give degrees, 0 to 90 (ours has 0.53)")
            }
            LightKind::Spot { inner, outer, .. } if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= 90.0) => {
                let what = format!("angles {inner} (inner) and {outer} (outer) are no cone");
                refuse(what, "give degrees from the axis, 0 <= inner <= outer, and more than 0 and at most 90 for outer")
            }
            _ => Ok(()),
        }
    }
}

/// What is around a scene: light that comes from everywhere that no surface is.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Radiance, W/m²/sr, linear Rec.709; with a map what its texels are multiplied by. In flatland 1/pi of the
    /// irradiance, W/m, on a line with nothing before it, as [`super::Material::emission`] is there.
    pub radiance: [f64; 3],
    /// Radiance that differs with the direction.
    pub map: Option<SkyMap>,
    /// Degrees that the map is turned by about the upward axis, counter-clockwise as seen from above. At 0 its middle lies along -z.
    pub rotation: f64,
}

impl Environment {
    /// A sky of one radiance, W/m²/sr, above and below.
    pub fn constant(radiance: [f64; 3]) -> Environment {
        Environment { radiance, map: None, rotation: 0.0 }
    }

    /// A sky as its map shows it.
    pub fn mapped(map: SkyMap) -> Environment {
        Environment { radiance: [1.0; 3], map: Some(map), rotation: 0.0 }
    }

    /// Checks that it can shine. Errors: [`Error::InvalidLight`].
    pub fn check(&self) -> Result<()> {
        positive("environment", &self.radiance)?;
        if !self.rotation.is_finite() {
            let what = format!("rotation {} is not finite", self.rotation);
            return Err(Error::InvalidLight { light: "environment".into(), what, cure: "give degrees" });
        }
        match &self.map {
            Some(map) => map.check(),
            None => Ok(()),
        }
    }
}

/// Checks what a light sends.
fn positive(light: &str, values: &[f64; 3]) -> Result<()> {
    match values.iter().find(|x| !(0.0..=f64::from(f32::MAX)).contains(*x)) {
        None => Ok(()),
        Some(x) => {
            let what = format!("{x} is not a finite number >= 0 in 32 bits");
            Err(Error::InvalidLight { light: light.into(), what, cure: "correct its radiance, irradiance or intensity" })
        }
    }
}

/// Checks the lights of a scene and what is around it. Errors: [`Error::InvalidLight`].
pub(super) fn check(lights: &[Light], environment: Option<&Environment>, flatland: bool) -> Result<()> {
    if lights.len() > LIGHTS {
        let what = format!("there are {} lights, and a scene has {LIGHTS} at most", lights.len());
        let cure = "keep those that matter, or give their lamps a surface that shines";
        return Err(Error::InvalidLight { light: lights[LIGHTS].name.clone(), what, cure });
    }
    lights.iter().try_for_each(Light::check)?;
    environment.map_or(Ok(()), Environment::check)?;
    let flat = |light: &str, what: &str, cure| {
        Err(Error::InvalidLight { light: light.into(), what: format!("{what} is not supported in flatland"), cure })
    };
    match (flatland, lights.first(), environment) {
        (true, Some(light), _) => flat(&light.name, "a light without a surface", "give a segment a radiosity"),
        (true, None, Some(e)) if e.map.is_some() => flat("environment", "a map", "give it a radiosity, W/m, all around"),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_shine_is_refused_by_name() {
        let refused = |light: Light, part: &str| {
            let said = light.check().unwrap_err().to_string();
            assert!(said.contains("'lamp'") && said.contains(part), "{said}");
        };
        let (down, one) = ([0.0, -1.0, 0.0], [1.0; 3]);
        assert!(Light::sun("lamp", one, down).check().is_ok());
        assert!(Light::spot("lamp", one, [0.0; 3], down, [0.0, 90.0]).check().is_ok());
        refused(Light::sun("lamp", [1.0, f64::NAN, 1.0], down), "NaN");
        refused(Light::sun("lamp", [1.0, -1.0, 1.0], down), "-1");
        refused(Light::sun("lamp", one, [0.0; 3]), "direction");
        refused(Light { kind: LightKind::Sun { direction: down, angle: 91.0 }, ..Light::sun("lamp", one, down) }, "91");
        refused(Light::point("lamp", one, [0.0, f64::INFINITY, 0.0]), "position");
        refused(Light::spot("lamp", one, [0.0; 3], down, [40.0, 30.0]), "cone");
        refused(Light::spot("lamp", one, [0.0; 3], down, [0.0, 91.0]), "cone");
        let many = vec![Light::sun("lamp", one, down); LIGHTS + 1];
        assert!(check(&many, None, false).unwrap_err().to_string().contains("1025"));
        assert!(check(&many[..1], None, true).unwrap_err().to_string().contains("flatland"));
        assert!(Environment { rotation: f64::NAN, ..Environment::constant(one) }.check().is_err());
        assert!(Environment::constant([-1.0; 3]).check().unwrap_err().to_string().contains("'environment'"));
    }
}
