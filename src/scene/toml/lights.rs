//! `[[light]]` and `[environment]`: light that comes from no surface.

use super::Place;
use super::document::{self, LightKind};
use crate::error::Result;
use crate::scene::load::Reader;
use crate::scene::{self, Environment, Light, SUN_ANGLE, SkyMap};
use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

/// Half the opening of a spot's cone where none is given, degrees: as glTF has it.
const OUTER: f64 = 45.0;

/// A light, checked.
pub fn light(at: &Place, span: Range<usize>, entry: &document::Light, flatland: bool) -> Result<Light> {
    let fault = |what: &str| at.fault(span.clone(), &format!("light '{}' {what}", entry.name));
    if flatland {
        return Err(fault("has no surface, which is not supported in flatland; give a segment a radiosity"));
    }
    // A key that means nothing for a kind is a mistake of the kind.
    let only = |there: bool, what: &str| if there { Err(fault(what)) } else { Ok(()) };
    let spot = entry.kind == LightKind::Spot;
    only(!spot && (entry.inner.is_some() || entry.outer.is_some()), "has a cone (inner, outer), which only a spot has")?;
    let direction = || match (entry.direction, entry.target, entry.position) {
        (Some(direction), None, _) => Ok(direction),
        (None, Some(t), Some(p)) => Ok([0, 1, 2].map(|k| t[k] - p[k])),
        _ => Err(fault("needs a direction, the way its light goes; a spot may have a target instead")),
    };
    let (sent, kind) = match entry.kind {
        LightKind::Sun => {
            only(
                entry.position.is_some() || entry.target.is_some(),
                "is a sun, which stands nowhere: leave position and target out",
            )?;
            only(entry.intensity.is_some(), "is a sun: give its irradiance, W/m2, on a surface that faces it")?;
            let angle = entry.angle.unwrap_or(SUN_ANGLE);
            (entry.irradiance, scene::LightKind::Sun { direction: direction()?, angle })
        }
        LightKind::Point | LightKind::Spot => {
            only(entry.irradiance.is_some(), "has an irradiance, which depends on the distance: give its intensity, W/sr")?;
            only(entry.angle.is_some(), "has an angle, which only a sun has; a spot's are inner and outer")?;
            let position = entry.position.ok_or_else(|| fault("needs a position"))?;
            let kind = if spot {
                let outer = entry.outer.unwrap_or(OUTER);
                scene::LightKind::Spot { position, direction: direction()?, inner: entry.inner.unwrap_or(0.0), outer }
            } else {
                only(entry.direction.is_some() || entry.target.is_some(), "shines all ways: leave direction and target out")?;
                scene::LightKind::Point { position }
            };
            (entry.intensity, kind)
        }
    };
    let unit = if entry.kind == LightKind::Sun { "needs an irradiance, W/m2" } else { "needs an intensity, W/sr" };
    let intensity = sent.ok_or_else(|| fault(unit))?.three();
    let light = Light { name: entry.name.clone(), intensity, kind };
    light.check().map_err(|e| at.fault(span.clone(), &format!("cannot be used: {e}")))?;
    Ok(light)
}

/// The environment, checked; its map is read.
pub fn environment(
    at: &Place,
    span: Range<usize>,
    entry: &document::Environment,
    flatland: bool,
    reader: &mut Reader,
) -> Result<Environment> {
    let fault = |what: &str| at.fault(span.clone(), &format!("environment {what}"));
    if flatland && (entry.radiance.is_some() || entry.map.is_some()) {
        return Err(fault("has a radiance or a map, which flatland does not know; give radiosity, W/m"));
    }
    let radiance = match (entry.radiance, entry.radiosity) {
        (Some(radiance), None) => radiance.three(),
        (None, Some(radiosity)) => radiosity.three().map(|b| b / PI),
        (None, None) if entry.map.is_some() => [1.0; 3],
        (None, None) => return Err(fault("needs a radiance, W/m2/sr, or a map")),
        _ => return Err(fault("has both radiance and radiosity; one says it all")),
    };
    let map = match &entry.map {
        Some(name) => {
            let path = at.path.parent().unwrap_or(Path::new("")).join(name);
            Some(SkyMap::from_bytes(&reader.read(&path)?, &path)?)
        }
        None if entry.rotation.is_some() => return Err(fault("has a rotation and no map to turn")),
        None => None,
    };
    let environment = Environment { radiance, map, rotation: entry.rotation.unwrap_or(0.0) };
    environment.check().map_err(|e| at.fault(span.clone(), &format!("cannot be used: {e}")))?;
    Ok(environment)
}
