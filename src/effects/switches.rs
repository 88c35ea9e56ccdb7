//! Effects that a user switches himself: `--effects +occlusion,-interreflection`, and those too small to matter.

use super::Name;
use crate::error::{Error, Result};
use crate::output::report::EffectReport;
use crate::scene::{Scene, Texture};
use std::fmt;
use std::str::FromStr;

/// What a user asked of effects, each once; empty: as the scene calls for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// Effects and whether they are to be on, in the order of [`Name::ALL`].
    asked: Vec<(Name, bool)>,
}

/// What can be written.
const FORMS: &str = "give auto, or effects with a sign, such as -interreflection,+occlusion (raycell explain lists them)";

impl fmt::Display for Switches {
    /// As [`Switches::from_str`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<_> =
            self.asked.iter().map(|(name, on)| format!("{}{}", if *on { '+' } else { '-' }, name.word())).collect();
        f.write_str(if words.is_empty() { "auto".into() } else { words.join(",") }.as_str())
    }
}

impl FromStr for Switches {
    type Err = Error;

    /// Reads `auto` or `+name,-name`.
    ///
    /// Errors: [`Error::InvalidParam`] for what is neither, and for an effect that is named twice.
    fn from_str(text: &str) -> Result<Switches> {
        let refused = || Error::InvalidParam { name: "--effects", value: format!("'{text}'"), range: FORMS };
        let mut switches = Switches::default();
        if text == "auto" {
            return Ok(switches);
        }
        for word in text.split(',').map(str::trim) {
            let (on, word) = match (word.strip_prefix('+'), word.strip_prefix('-')) {
                (Some(word), _) => (true, word),
                (_, Some(word)) => (false, word),
                _ => return Err(refused()),
            };
            let name = Name::ALL.into_iter().find(|n| n.word() == word).ok_or_else(refused)?;
            if switches.asked(name).is_some() {
                return Err(refused());
            }
            switches.set(name, on);
        }
        Ok(switches)
    }
}

impl Switches {
    /// Whether an effect was asked on or off.
    pub fn asked(&self, name: Name) -> Option<bool> {
        self.asked.iter().find(|(n, _)| *n == name).map(|&(_, on)| on)
    }

    fn set(&mut self, name: Name, on: bool) {
        self.asked.retain(|(n, _)| *n != name);
        self.asked.push((name, on));
        self.asked.sort_by_key(|(n, _)| Name::ALL.iter().position(|m| m == n));
    }

    /// Switches effects of a scene: what is asked off is taken out of it, with a warning where that changes the light.
    ///
    /// Errors: [`Error::InvalidParam`] where an effect cannot be switched so: the scene has none of it, or no light without it.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        if self.asked.is_empty() {
            // Without a look at the scene, which takes its preparation and some thousand paths.
            return Ok(());
        }
        let present = super::analyse(scene)?;
        for &(name, on) in &self.asked {
            let there = present.iter().any(|e| e.name == name.word() && e.on);
            switch(scene, name, on, there)?;
            scene.effects.set(name, on);
            if there && !on {
                scene
                    .warnings
                    .push(format!("effects: {} is off because it was asked off, though the scene calls for it", name.word()));
            }
        }
        Ok(())
    }
}

/// Switches an effect, which is `there`.
fn switch(scene: &mut Scene, name: Name, on: bool, there: bool) -> Result<()> {
    let refused = |range| {
        let sign = if on { '+' } else { '-' };
        Err(Error::InvalidParam { name: "--effects", value: format!("'{sign}{}'", name.word()), range })
    };
    match (name, on) {
        // Geometry asks.
        (Name::Occlusion, _) | (Name::Interreflection, false) => Ok(()),
        (_, true) if there => Ok(()),
        (_, true) => refused("the scene asks for none of it, so there is nothing to switch on"),
        (_, false) if !there => Ok(()),
        (Name::Colour, false) => {
            for m in &mut scene.materials {
                m.reflectance = [m.reflectance.iter().sum::<f64>() / 3.0; 3];
                m.emission = [m.emission.iter().sum::<f64>() / 3.0; 3];
            }
            if !scene.has_grey_maps() {
                scene.textures = scene.textures.iter().map(Texture::in_grey).collect();
            }
            for light in &mut scene.lights {
                light.intensity = [light.intensity.iter().sum::<f64>() / 3.0; 3];
            }
            if let Some(around) = &mut scene.environment {
                // The product of both is what is seen.
                match &mut around.map {
                    Some(map) => {
                        let factor = around.radiance.map(|x| x as f32);
                        map.rgb.iter_mut().for_each(|c| *c = [(0..3).map(|k| c[k] * factor[k]).sum::<f32>() / 3.0; 3]);
                        around.radiance = [1.0; 3];
                    }
                    None => around.radiance = [around.radiance.iter().sum::<f64>() / 3.0; 3],
                }
            }
            Ok(())
        }
        (Name::Environment, false) => {
            scene.environment = None;
            Ok(())
        }
        (Name::Lights, false) => {
            scene.lights.clear();
            Ok(())
        }
        (Name::Mirrors, false) => {
            // As much light as they reflect, but diffusely.
            for m in scene.materials.iter_mut().filter(|m| m.mirror > 0.0) {
                (m.reflectance, m.reflectance_map, m.mirror) = ([m.mirror; 3], None, 0.0);
            }
            Ok(())
        }
        (Name::Medium, false) => {
            scene.absorption = 0.0;
            Ok(())
        }
        (Name::Textures, false) => {
            scene.flatten_maps();
            Ok(())
        }
        (Name::Transparency, false) => {
            scene.materials.iter_mut().for_each(|m| m.alpha_map = None);
            Ok(())
        }
        (Name::Direct | Name::TwoSided | Name::Flatland, false) => refused("the scene is made of it; change the scene instead"),
    }
}

/// Switches off what brings less than `threshold` of the light (or of the bands' difference), and says so in the scene's
/// warnings with its share. Shares are estimates from a few thousand paths ([`super::analyse`]).
///
/// Errors: [`Error::InvalidParam`] for a threshold that is not in [0, 1).
pub fn drop_below(scene: &mut Scene, threshold: f64) -> Result<()> {
    if !(0.0..1.0).contains(&threshold) {
        let range = "give a share of the light below 100 %, such as 0.1%";
        return Err(Error::InvalidParam { name: "--effects-threshold", value: threshold.to_string(), range });
    }
    let small = |e: &EffectReport| e.on && e.share.is_some_and(|share| share < threshold);
    let present = super::analyse(scene)?;
    for name in Name::ALL {
        let Some(effect) = present.iter().find(|e| e.name == name.word() && small(e)) else { continue };
        switch(scene, name, false, true)?;
        scene.effects.set(name, false);
        let share = effect.share.unwrap_or_default();
        scene.warnings.push(format!(
            "effects: {} is left out, as its part of the light, about {}, is below the threshold of {}",
            name.word(),
            super::percent(share),
            super::percent(threshold)
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn switches_are_read_and_refused() {
        assert_eq!("auto".parse::<Switches>().unwrap(), Switches::default());
        let two: Switches = "+occlusion, -interreflection".parse().unwrap();
        assert_eq!((two.asked(Name::Occlusion), two.asked(Name::Interreflection)), (Some(true), Some(false)));
        assert_eq!(two.asked(Name::Colour), None);
        assert_eq!((two.to_string().as_str(), Switches::default().to_string().as_str()), ("+occlusion,-interreflection", "auto"));
        for bad in ["", "occlusion", "+nothing", "+colour,-colour", "-", "auto,-colour"] {
            let told = bad.parse::<Switches>().unwrap_err().to_string();
            assert!(told.contains("raycell explain"), "{told}");
        }
    }
}
