//! MTL files: `Kd` reflects, `Ke` shines; all else is named and left out.
//!
//! The values are read here because a refusal must name its line; tobj keeps none, and panics on `Kd 0.5`.

use super::Material;
use super::load::{KdSpace, Reader};
use super::text::{Statements, bad, decode, name, split, words};
use super::unread::Unread;
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
    ke: [f64; 3],
    place: String,
}

/// The materials of all MTL files that an OBJ names.
#[derive(Default)]
pub struct Library {
    entries: BTreeMap<String, Entry>,
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
        let mut unread = Unread::default();
        let mut current: Option<&mut Entry> = None;
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
                    current = Some(entry);
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
                        (None, _) => unread.add(&format!("{key} before any newmtl"), format_args!("line {line}")),
                        (Some(entry), "Kd") => {
                            let linear = |x: f64| if reader.options.kd_space == KdSpace::Srgb { srgb_to_linear(x) } else { x };
                            (entry.kd, entry.place) = (Some(v.map(linear)), place);
                        }
                        (Some(entry), _) => (entry.ke, entry.place) = (v, place),
                    }
                }
                _ if matters(key, rest) => unread.add(key, format_args!("line {line}")),
                _ => {}
            }
        }
        unread.warn(path, warnings);
        Ok(())
    }

    /// The material that faces use from line `line` of an OBJ on, and its place; defaults are filled in with a
    /// warning. What `overridden` names gets its reflectance elsewhere.
    pub fn resolve(
        &self,
        name: Option<&str>,
        obj: &Path,
        line: usize,
        overridden: &[String],
        warnings: &mut Vec<String>,
    ) -> (Material, String) {
        let here = format!("{}:{line}", obj.display());
        let Some(name) = name else {
            let cure = "give them one in the modeller";
            warnings.push(format!("{here}: faces without a material (no usemtl) are taken for {GREY} grey; {cure}"));
            return (Material::new("default", [GREY; 3], [0.0; 3]), here);
        };
        let spared = overridden.iter().any(|o| o == name);
        let entry = self.entries.get(name);
        let place = entry.map_or(here, |e| e.place.clone());
        let reflectance = match entry {
            _ if spared => [GREY; 3],
            None => {
                let cure = "ship the .mtl that defines it";
                warnings.push(format!("{place}: material '{name}' is in no material file and taken for {GREY} grey; {cure}"));
                [GREY; 3]
            }
            Some(Entry { kd: None, .. }) => {
                warnings.push(format!("{place}: material '{name}' has no Kd and is taken for {GREY} grey; give it a Kd"));
                [GREY; 3]
            }
            Some(Entry { kd: Some(kd), .. }) => not_quite_one(*kd, name, &place, warnings),
        };
        (Material::new(name, reflectance, entry.map_or([0.0; 3], |e| e.ke)), place)
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

/// The file of a name beside an OBJ: as written, with Windows' separators turned, or by its last part alone,
/// where a path of somebody else's machine was written.
fn find(obj: &Path, name: &str, reader: &mut Reader) -> std::io::Result<(PathBuf, Vec<u8>)> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let turned = name.replace('\\', "/");
    let mut read = |name: &str| {
        let path = folder.join(name);
        reader.try_read(&path).map(|bytes| (path, bytes))
    };
    read(&turned).or_else(|e| match turned.rsplit_once('/') {
        Some((_, last)) if !last.is_empty() => read(last).map_err(|_| e),
        _ => Err(e),
    })
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
