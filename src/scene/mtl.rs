//! MTL files: `Kd` reflects, `Ke` shines, `illum 3` and `Pm 1` are mirrors, `map_Kd`, `map_Ke` and `map_d` vary them and cut
//! out; all else is named and left out.
//!
//! The values are read here because a refusal must name its line; tobj keeps none, and panics on `Kd 0.5`.

use super::images::{Images, below_one, find};
use super::load::{KdSpace, Reader};
use super::text::{Statements, bad, decode, name, split, words};
use super::texture::{Channel, Map, Meaning};
use super::unread::Unread;
use super::{Material, Scene};
use crate::error::Result;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Reflectance where the MTL says nothing.
pub const GREY: f64 = 0.5;
/// A reflectance of 1, as exporters write for "white", becomes this.
pub const NEARLY_ONE: f64 = 0.98;
/// The last reflectance that counts as 1.
pub const ONE: f64 = 1.0 + 1e-6;

/// A material as a file says it, and where.
#[derive(Default)]
struct Entry {
    kd: Option<[f64; 3]>,
    ke: Option<[f64; 3]>,
    ks: [f64; 3],
    illum: f64,
    metallic: f64,
    roughness: Option<f64>,
    /// Of reflectance, emission and alpha.
    maps: [Option<Named>; 3],
    place: String,
}

impl Entry {
    /// What it reflects as an ideal mirror: `Ks` of `illum` 3 or 5, where that is more than its `Kd`; or `Kd` of a metal
    /// without roughness. A lamp is none.
    fn mirror(&self) -> Option<[f64; 3]> {
        let sum = |v: [f64; 3]| v.iter().sum::<f64>();
        let diffuse = sum(self.kd.unwrap_or_default());
        match self {
            _ if self.ke.is_some_and(|ke| ke != [0.0; 3]) || self.maps[1].is_some() => None,
            Entry { metallic: 1.0, roughness: Some(0.0), .. } => self.kd,
            _ if (self.illum == 3.0 || self.illum == 5.0) && sum(self.ks) > diffuse => Some(self.ks),
            _ => None,
        }
    }
}

/// What a mirror material says that a diffuse one would not be read for.
const OF_MIRRORS: [&str; 3] = ["Ks", "illum", "Pm"];

/// A map as a file names it.
struct Named {
    /// The MTL, and the line in it.
    file: PathBuf,
    line: usize,
    image: String,
    /// Scale and offset of u and v, v upwards.
    scale: [f64; 2],
    offset: [f64; 2],
    clamp: bool,
    channel: Channel,
}

/// The statements of the maps, and what is taken where one cannot be had.
const MAPS: [(&str, &str); 3] =
    [("map_Kd", "its Kd is taken alone"), ("map_Ke", "its Ke is taken alone"), ("map_d", "nothing is cut out")];

/// The materials of all MTL files that an OBJ names.
#[derive(Default)]
pub struct Library {
    entries: BTreeMap<String, Entry>,
    images: Images,
}

impl Library {
    /// Reads what a `mtllib` statement on a line names; a file that cannot be read is worth a warning, no more.
    pub fn load(&mut self, obj: &Path, line: usize, names: &str, reader: &mut Reader, warnings: &mut Vec<String>) -> Result<()> {
        // One name that may hold spaces, or several without.
        if let Ok((path, bytes)) = find(obj, names, reader) {
            return self.read(&path, bytes, reader, warnings);
        }
        for one in words(names) {
            match find(obj, one, reader) {
                Ok((path, bytes)) => self.read(&path, bytes, reader, warnings)?,
                Err(e) => {
                    let obj = obj.display();
                    warnings.push(format!("{obj}:{line}: material file '{one}' was not found ({e}); put it beside the scene"));
                }
            }
        }
        Ok(())
    }

    fn read(&mut self, path: &Path, bytes: Vec<u8>, reader: &mut Reader, warnings: &mut Vec<String>) -> Result<()> {
        let text = decode(bytes);
        // What is not read, and of which material: told at the end, when mirrors are known.
        let mut left: Vec<(String, usize, Option<String>)> = Vec::new();
        let mut unread = Unread::default();
        let mut current: Option<(String, &mut Entry)> = None;
        for (line, statement) in Statements::new(&text) {
            let (key, rest) = split(&statement);
            match key {
                "newmtl" => {
                    let name = name(rest);
                    if name.is_empty() {
                        return Err(bad(path, line, &statement, "a name"));
                    }
                    let place = format!("{}:{line}", path.display());
                    if self.entries.contains_key(name) {
                        warnings.push(format!(
                            "{place}: material '{name}' is defined once more, and the last holds; name them apart"
                        ));
                    }
                    let entry = self.entries.entry(name.into()).or_default();
                    *entry = Entry { place, ..Entry::default() };
                    current = Some((name.into(), entry));
                }
                "Kd" | "Ke" => {
                    // One number stands for three, says the format.
                    let numbers: Option<Vec<f64>> = words(rest).map(|w| w.parse().ok()).collect();
                    let v = match numbers.as_deref() {
                        Some(&[v]) => [v; 3],
                        Some(&[r, g, b]) => [r, g, b],
                        _ => return Err(bad(path, line, &statement, "red, green and blue")),
                    };
                    let place = format!("{}:{line}", path.display());
                    match (&mut current, key) {
                        (None, _) => left.push((format!("{key} before any newmtl"), line, None)),
                        (Some((_, entry)), "Kd") => {
                            let linear = |x: f64| if reader.options.kd_space == KdSpace::Srgb { srgb_to_linear(x) } else { x };
                            (entry.kd, entry.place) = (Some(v.map(linear)), place);
                        }
                        (Some((_, entry)), _) => (entry.ke, entry.place) = (Some(v), place),
                    }
                }
                "map_Kd" | "map_Ke" | "map_d" => {
                    let named = map(path, line, key, rest, &mut unread);
                    if named.image.is_empty() {
                        return Err(bad(path, line, &statement, "the name of an image"));
                    }
                    match &mut current {
                        None => left.push((format!("{key} before any newmtl"), line, None)),
                        Some((_, entry)) => {
                            let which = MAPS.iter().position(|m| m.0 == key).unwrap_or(0);
                            entry.maps[which] = Some(named);
                        }
                    }
                }
                _ => {
                    let name = current.as_ref().map(|(name, _)| name.clone());
                    if let Some((_, entry)) = &mut current {
                        mirror_of(entry, key, rest);
                    }
                    if matters(key, rest) {
                        left.push((key.into(), line, name));
                    }
                }
            }
        }
        for (key, line, name) in left {
            let mirror = || name.and_then(|name| self.entries.get(&name)?.mirror()).is_some();
            if !(OF_MIRRORS.contains(&key.as_str()) && mirror()) {
                unread.add(&key, format_args!("line {line}"));
            }
        }
        unread.warn(path, warnings);
        Ok(())
    }

    /// The material that faces use from line `line` of an OBJ on, and its place; defaults are filled in with a
    /// warning. What `overridden` names gets its reflectance elsewhere.
    pub fn resolve(
        &mut self,
        name: Option<&str>,
        obj: &Path,
        line: usize,
        overridden: &[String],
        reader: &mut Reader,
        scene: &mut Scene,
    ) -> (Material, String) {
        let here = format!("{}:{line}", obj.display());
        let Some(name) = name else {
            let cure = "give them one in the modeller";
            scene.warnings.push(format!("{here}: faces without a material (no usemtl) are taken for {GREY} grey; {cure}"));
            return (Material::new("default", [GREY; 3], [0.0; 3]), here);
        };
        let spared = overridden.iter().any(|o| o == name);
        let Library { entries, images } = self;
        let entry = entries.get(name);
        let place = entry.map_or(here, |e| e.place.clone());
        if let Some((mirror, entry)) = entry.filter(|_| !spared).and_then(|e| Some((e.mirror()?, e))) {
            if entry.metallic != 1.0 && entry.kd.is_some_and(|kd| kd != [0.0; 3]) {
                scene.warnings.push(format!(
                    "{place}: material '{name}' is taken for an ideal mirror of its Ks, and its Kd is left out; give it \
                     illum 2 to have its Kd instead"
                ));
            }
            if entry.maps[0].is_some() {
                scene.warnings.push(map_of_mirror(name, &place, "map_Kd"));
            }
            let alpha_map = entry.maps[2].as_ref().and_then(|n| n.read(2, images, reader, scene));
            let mirror = not_quite_one(mirror, name, &place, &mut scene.warnings);
            let mirror = grey_mirror(mirror, name, &place, &mut scene.warnings);
            return (Material { alpha_map, ..Material::new_mirror(name, mirror) }, place);
        }
        let mut maps = [None; 3];
        if let Some(entry) = entry {
            for (which, named) in entry.maps.iter().enumerate() {
                // Whose reflectance is given elsewhere needs no map of it.
                maps[which] = named.as_ref().filter(|_| which > 0 || !spared).and_then(|n| n.read(which, images, reader, scene));
            }
        }
        let [reflectance_map, emission_map, alpha_map] = maps;
        let warnings = &mut scene.warnings;
        let reflectance = match entry {
            _ if spared => [GREY; 3],
            None => {
                let cure = "ship the .mtl that defines it";
                warnings.push(format!("{place}: material '{name}' is in no material file and taken for {GREY} grey; {cure}"));
                [GREY; 3]
            }
            Some(Entry { kd: None, .. }) if reflectance_map.is_some() => {
                below_one([1.0; 3], reflectance_map, name, &place, scene)
            }
            Some(Entry { kd: None, .. }) => {
                warnings.push(format!("{place}: material '{name}' has no Kd and is taken for {GREY} grey; give it a Kd"));
                [GREY; 3]
            }
            Some(Entry { kd: Some(kd), .. }) => below_one(*kd, reflectance_map, name, &place, scene),
        };
        let emission = match entry.and_then(|e| e.ke) {
            // A map of nothing would be written for nothing: exporters leave the colour black beside it.
            None | Some([0.0, 0.0, 0.0]) if emission_map.is_some() => [1.0; 3],
            ke => ke.unwrap_or_default(),
        };
        (Material { reflectance_map, emission_map, alpha_map, ..Material::new(name, reflectance, emission) }, place)
    }
}

/// Lowers a reflectance of 1, which exporters write for "white", with a warning; anything else is left alone.
pub fn not_quite_one(rho: [f64; 3], material: &str, place: &str, warnings: &mut Vec<String>) -> [f64; 3] {
    // What 32 bits round to 1 is 1.
    let one = |x: &f64| *x as f32 >= 1.0 && *x <= ONE;
    if rho.iter().any(one) {
        warnings.push(format!(
            "{place}: material '{material}' reflects everything (1), which no surface does, and is taken for {NEARLY_ONE}; \
             lower its reflectance below 1"
        ));
    }
    rho.map(|x| if one(&x) { NEARLY_ONE } else { x })
}

/// The one reflectance of a mirror, with a warning where it is tinted: ways along mirrors carry all bands alike.
pub fn grey_mirror(rho: [f64; 3], material: &str, place: &str, warnings: &mut Vec<String>) -> f64 {
    let mean = (rho[0] + rho[1] + rho[2]) / 3.0;
    if rho.iter().any(|x| x != &rho[0]) {
        warnings.push(format!(
            "{place}: material '{material}' is a tinted mirror, which is not supported, and is taken for a grey one of \
             {mean:.3}; give it one reflectance for all bands"
        ));
        return mean;
    }
    rho[0]
}

/// The warning that a mirror's map of reflectance is left out.
pub fn map_of_mirror(material: &str, place: &str, map: &str) -> String {
    format!(
        "{place}: material '{material}' is an ideal mirror, which has one reflectance everywhere, and its {map} is left out; \
         make it diffuse to have the texture"
    )
}

/// Reads what makes a mirror of a material; what cannot be read says nothing.
fn mirror_of(entry: &mut Entry, key: &str, rest: &str) {
    let values: Vec<f64> = words(rest).map_while(|w| w.parse().ok()).collect();
    match (key, &values[..]) {
        ("Ks", &[x]) => entry.ks = [x; 3],
        ("Ks", &[r, g, b]) => entry.ks = [r, g, b],
        ("illum", &[x]) => entry.illum = x,
        ("Pm", &[x]) => entry.metallic = x,
        ("Pr", &[x]) => entry.roughness = Some(x),
        _ => {}
    }
}

impl Named {
    /// The map, with its image in the scene.
    fn read(&self, which: usize, images: &mut Images, reader: &mut Reader, scene: &mut Scene) -> Option<Map> {
        let meaning = if which == 2 { Meaning::Alpha(self.channel) } else { Meaning::Colour };
        let place = format!("{}:{}", self.file.display(), self.line);
        let bytes = || find(&self.file, &self.image, reader).map(|found| found.1).map_err(|e| e.to_string());
        let texture = images.take(&self.image, meaning, bytes, &place, MAPS[which].1, scene)?;
        let ([su, sv], [ou, ov]) = (self.scale, self.offset);
        // An image's v points down.
        let transform = [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]];
        Some(Map { texture, transform, clamp: [self.clamp; 2] })
    }
}

/// Up to so many numbers at the start of a text, but never its last word; the text goes on behind them.
fn numbers(text: &mut &str, most: usize) -> Vec<f64> {
    let mut next = || {
        let (word, more) = split(text);
        let value = word.parse::<f64>().ok().filter(|_| !more.is_empty())?;
        *text = more;
        Some(value)
    };
    (0..most).map_while(|_| next()).collect()
}

/// The options and the image of a map. Options that are not read and would change the light are named.
fn map(file: &Path, line: usize, key: &str, rest: &str, unread: &mut Unread) -> Named {
    let mut named = Named {
        file: file.into(),
        line,
        image: String::new(),
        scale: [1.0; 2],
        offset: [0.0; 2],
        clamp: false,
        channel: Channel::Any,
    };
    let mut left = rest;
    loop {
        let (option, mut after) = split(left);
        match option {
            "-s" | "-o" => {
                let given = numbers(&mut after, 3);
                let to = if option == "-s" { &mut named.scale } else { &mut named.offset };
                given.iter().zip(to).for_each(|(x, to)| *to = *x);
            }
            "-t" | "-mm" => {
                let given = numbers(&mut after, if option == "-t" { 3 } else { 2 });
                let idle: &[f64] = if option == "-t" { &[0.0; 3] } else { &[0.0, 1.0] };
                if given.iter().zip(idle).any(|(x, idle)| x != idle) {
                    unread.add(&format!("{key} {option}"), format_args!("line {line}"));
                }
            }
            "-texres" | "-bm" | "-boost" => drop(numbers(&mut after, 1)),
            "-clamp" | "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-type" => {
                let (word, more) = split(after);
                after = more;
                match (option, word) {
                    ("-clamp", _) => named.clamp = word == "on",
                    ("-imfchan", "r") => named.channel = Channel::Red,
                    ("-imfchan", "g") => named.channel = Channel::Green,
                    ("-imfchan", "b") => named.channel = Channel::Blue,
                    ("-imfchan", "m") => named.channel = Channel::Alpha,
                    ("-imfchan", "l") => named.channel = Channel::Luminance,
                    ("-imfchan" | "-type", _) => unread.add(&format!("{key} {option} {word}"), format_args!("line {line}")),
                    ("-cc", "on") => unread.add(&format!("{key} -cc"), format_args!("line {line}")),
                    _ => {}
                }
            }
            _ => break,
        }
        left = after;
    }
    named.image = name(left).into();
    named
}

/// Whether a statement that is not read would have changed the light.
fn matters(key: &str, rest: &str) -> bool {
    let values = || words(rest).filter_map(|w| w.parse::<f64>().ok());
    match key {
        // Ambient colour, the width of highlights and the density of glass mean nothing to a diffuse surface.
        "" | "Ka" | "Ns" | "Ni" | "sharpness" | "Pr" | "aniso" | "anisor" => false,
        _ if key.starts_with('#') => false,
        "d" => values().any(|d| d < 1.0),
        "Tr" | "Ks" | "Pm" | "Ps" | "Pc" | "Pcr" => values().any(|x| x != 0.0),
        "Tf" => values().any(|x| x != 1.0),
        // 0 to 2 are matt and highlights; above are mirrors, glass and shadow tricks.
        "illum" => values().any(|x| x > 2.0),
        _ => true,
    }
}

/// sRGB's transfer function; what is no colour stays as it is, to be refused.
fn srgb_to_linear(x: f64) -> f64 {
    match x {
        0.0..=0.04045 => x / 12.92,
        0.04045..=ONE => ((x + 0.055) / 1.055).powf(2.4),
        _ => x,
    }
}
