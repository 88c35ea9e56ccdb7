//! OBJ files, as people's exporters really write them.
//!
//! The statements are read here, because every error must name its line and every vertex must keep
//! the number its author gave it (tobj renumbers vertices per mesh, takes polylines for triangles and
//! refuses a whole file for a one-dimensional `vt`).

use super::load::Reader;
use super::mtl::Library;
use super::polygon::{Cut, cut};
use super::text::{Statements, bad, decode, name, split, words};
use super::texture::check_uv;
use super::unread::Unread;
use super::{Face, Scene, fits};
use crate::error::{Error, Result};
use crate::progress::Event;
use std::collections::HashMap;
use std::path::Path;

/// Bytes of text between two tellings of progress.
const STEP: usize = 1 << 20;

/// Reads an OBJ file with its materials. Polygons are cut into triangles; an object is a `o` or `g` name.
/// The reflectance of the materials that `overridden` names comes from elsewhere.
///
/// Errors: [`Error::Read`], [`Error::Format`], [`Error::InvalidVertex`], [`Error::IndexOutOfRange`], with file and line.
pub fn read(path: &Path, reader: &mut Reader, overridden: &[String]) -> Result<Scene> {
    let text = decode(reader.read(path)?);
    let place = |line: usize| format!("{}:{line}", path.display());
    let mut scene = Scene { name: path.display().to_string(), ..Scene::default() };
    let mut library = Library::default();
    let mut unread = Unread::default();
    let total = 2 * text.len() as u64;
    let mut told = 0;
    let mut tell = |reader: &mut Reader, at: usize| {
        if at < told + STEP {
            return Ok(());
        }
        told = at;
        reader.progress.event(Event::Read { done: at as u64, total })
    };

    // Vertices and libraries first: faces may name what comes after them.
    let mut lines = Statements::new(&text);
    while let Some((line, statement)) = lines.next() {
        tell(reader, lines.at)?;
        match split(&statement) {
            ("v", rest) => {
                let value = position(rest).ok_or_else(|| bad(path, line, &statement, "three numbers"))?;
                if !fits(&value) {
                    return Err(Error::InvalidVertex { place: place(line), index: scene.vertices.len(), value });
                }
                scene.vertices.push(value);
            }
            ("vt", rest) => scene.uvs.push(coordinate(rest)),
            ("mtllib", rest) => library.load(path, line, name(rest), reader, &mut scene.warnings)?,
            ("f" | "o" | "g" | "usemtl" | "vn" | "s", _) => {}
            ("fo", _) => unread.add("fo", format_args!("line {line}")),
            (key, _) if key.is_empty() || key.starts_with('#') => {}
            (key, _) => unread.add(key, format_args!("line {line}")),
        }
    }

    // Faces, under the names that hold where they stand.
    let count = scene.vertices.len();
    let (mut seen, mut seen_uvs) = (0i64, 0i64); // vertices and coordinates so far, for relative indices
    let mut names = Names::default();
    let (mut object, mut material) = (None, None);
    let (mut thin, mut crossing, mut bare) = (Unread::default(), Unread::default(), Unread::default());
    let (mut corners, mut uvs): (Vec<u32>, Vec<u32>) = Default::default();
    let mut lines = Statements::new(&text);
    while let Some((line, statement)) = lines.next() {
        tell(reader, text.len() + lines.at)?;
        match split(&statement) {
            ("v", _) => seen += 1,
            ("vt", _) => seen_uvs += 1,
            ("o" | "g", rest) => (object, names.object) = (None, name(rest).into()),
            ("usemtl", rest) => (material, names.material) = (None, name(rest).into()),
            ("f", rest) => {
                corners.clear();
                uvs.clear();
                let mut lost = None;
                for word in words(rest) {
                    let mut parts = word.split('/');
                    let index: i64 = (parts.next())
                        .and_then(|w| w.parse().ok())
                        .ok_or_else(|| bad(path, line, &statement, "vertex numbers"))?;
                    let from_0 = if index < 0 { seen.saturating_add(index) } else { index - 1 };
                    if !(0..count as i64).contains(&from_0) {
                        return Err(Error::IndexOutOfRange { place: place(line), index, count });
                    }
                    corners.push(from_0 as u32);
                    // Of a material without a map they may be anything.
                    if let Some(index) = parts.next().and_then(|w| w.parse::<i64>().ok()) {
                        let from_0 = if index < 0 { seen_uvs.saturating_add(index) } else { index - 1 };
                        match (0..scene.uvs.len() as i64).contains(&from_0) {
                            true => uvs.push(from_0 as u32),
                            false => lost = Some(index),
                        }
                    }
                }
                if corners.len() < 3 {
                    thin.add("faces with fewer than three corners", format_args!("line {line}"));
                    continue;
                }
                let object = *object.get_or_insert_with(|| names.object(&mut scene));
                let material = match material {
                    Some(m) => m,
                    None => *material.insert(names.material(&mut scene, &mut library, path, line, overridden, reader)),
                };
                let m = &scene.materials[material as usize];
                if m.maps().iter().any(Option::is_some) {
                    if let Some(index) = lost {
                        let place = format!("{}, texture coordinate", place(line));
                        return Err(Error::IndexOutOfRange { place, index, count: scene.uvs.len() });
                    }
                    for &i in &uvs {
                        check_uv(&scene.uvs[i as usize], || format!("{}, texture coordinate {i}", place(line)))?;
                    }
                    if uvs.len() < corners.len() {
                        bare.add(&format!("faces of '{}' without texture coordinates (vt)", m.name), format_args!("line {line}"));
                    }
                }
                let from = scene.faces.len();
                let mut cuts = Vec::new();
                let Scene { vertices, faces, .. } = &mut scene;
                let shape = cut(&corners, vertices, |t| {
                    faces.push(Face { vertices: t.map(|i| corners[i]), material, object });
                    cuts.push(t);
                });
                if uvs.len() == corners.len() {
                    cuts.into_iter().enumerate().for_each(|(i, t)| scene.set_uv(from + i, t.map(|c| uvs[c])));
                }
                if shape == Cut::Overlapping {
                    let object = &scene.objects[object as usize];
                    crossing.add(&format!("polygons of '{object}' that cross themselves"), format_args!("line {line}"));
                }
            }
            _ => {}
        }
    }
    unread.warn(path, &mut scene.warnings);
    thin.warn(path, &mut scene.warnings);
    crossing.warn_as(path, "cut into triangles that overlap", "triangulate on export", &mut scene.warnings);
    bare.warn_as(path, "given the mean of their map, and nothing cut out", "unwrap them in the modeller", &mut scene.warnings);
    Ok(scene)
}

/// The names that hold for the next face, and the numbers they have got.
#[derive(Default)]
struct Names {
    object: String,
    material: String,
    objects: HashMap<String, u32>,
    materials: HashMap<String, u32>,
}

impl Names {
    fn object(&mut self, scene: &mut Scene) -> u32 {
        let name = if self.object.is_empty() { "unnamed" } else { &self.object };
        *self.objects.entry(name.into()).or_insert_with(|| {
            scene.objects.push(name.into());
            scene.objects.len() as u32 - 1
        })
    }

    fn material(
        &mut self,
        scene: &mut Scene,
        library: &mut Library,
        path: &Path,
        line: usize,
        overridden: &[String],
        reader: &mut Reader,
    ) -> u32 {
        if let Some(&known) = self.materials.get(&self.material) {
            return known;
        }
        let name = (!self.material.is_empty()).then_some(self.material.as_str());
        let (material, place) = library.resolve(name, path, line, overridden, reader, scene);
        scene.materials.push(material);
        scene.material_places.push(place);
        let index = scene.materials.len() as u32 - 1;
        self.materials.insert(self.material.clone(), index);
        index
    }
}

/// The first three numbers of a `v`; a weight or a colour may follow.
fn position(rest: &str) -> Option<[f64; 3]> {
    let mut numbers = words(rest).map(|w| w.parse::<f64>());
    let mut next = || numbers.next()?.ok();
    let v = [next()?, next()?, next()?];
    numbers.all(|n| n.is_ok()).then_some(v)
}

/// The first two numbers of a `vt`, v turned to point down as an image's rows do; of a single one v is 0. What is no number
/// is refused where a scene has maps.
fn coordinate(rest: &str) -> [f64; 2] {
    let mut numbers = words(rest).map(|w| w.parse().unwrap_or(f64::NAN));
    [numbers.next().unwrap_or(f64::NAN), 1.0 - numbers.next().unwrap_or(0.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Flow;
    use crate::scene::LoadOptions;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    /// Reads an OBJ with the material file `s.mtl` beside it, if any, all in memory.
    fn load_bytes(obj: &[u8], mtl: Option<&[u8]>, options: &LoadOptions) -> Result<Scene> {
        let mut files = |path: &Path| match (path.to_str(), mtl) {
            (Some("s.obj"), _) => Ok(obj.to_vec()),
            (Some("s.mtl"), Some(mtl)) => Ok(mtl.to_vec()),
            _ => Err(std::io::ErrorKind::NotFound.into()),
        };
        Scene::load_from(Path::new("s.obj"), options, &mut files, &mut |_| Flow::Continue)
    }

    fn load(obj: &str, mtl: Option<&str>) -> Result<Scene> {
        load_bytes(obj.as_bytes(), mtl.map(str::as_bytes), &LoadOptions::default())
    }

    fn message(obj: &str, mtl: Option<&str>) -> String {
        load(obj, mtl).expect_err("should be refused").to_string()
    }

    #[test]
    fn vertices_keep_their_numbers() {
        let obj = "v 0 0 0\nv 9 9 9\nv 1 0 0 1\nvt 0.5\nvn 0 0 1\nv 0 1 0 1 0 0\no a\nf 1//1 3//1 4/1/1\ng b\nf -1 -2 \\\n 1\nl 1 2 3\n";
        let scene = load(obj, None).unwrap();
        assert_eq!(scene.vertices.len(), 4);
        assert_eq!(scene.faces.iter().map(|f| f.vertices).collect::<Vec<_>>(), [[0, 2, 3], [3, 2, 0]]);
        assert_eq!(scene.objects, ["a", "b"]);
        assert_eq!(scene.faces[1].object, 1);
    }

    #[test]
    fn dented_polygons_are_cut_without_overlap() {
        // An arrow head, dented at its second corner.
        let obj = "v 0 0 0\nv 1 .2 0\nv 2 0 0\nv 1 3 0\nf 1 2 3 4\n";
        let scene = load(obj, None).unwrap();
        assert_eq!(scene.faces.len(), 2);
        for i in 0..2 {
            let c = scene.corners(i).map(glam::DVec3::from_array);
            assert!((c[1] - c[0]).cross(c[2] - c[0]).z > 0.0);
        }
    }

    #[test]
    fn bad_lines_are_named() {
        for (obj, part) in [
            ("v 0 0 0\nv 1 0 nan\n", "s.obj:2: vertex 1 is not finite"),
            ("v 0 0 0\nv 1e999 0 0\n", "s.obj:2: vertex 1 is not finite"),
            ("v 0 0\n", "s.obj:1: 'v 0 0' does not hold three numbers"),
            ("\nv 0 x 0\n", "s.obj:2: 'v 0 x 0'"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "s.obj:4: index 4 is out of range (there are 3)"),
            ("v 0 0 0\nf 0 1 1\n", "s.obj:2: index 0 is out of range"),
            ("v 0 0 0\nf -2 1 1\n", "s.obj:2: index -2 is out of range"),
            ("v 0 0 0\nf a b c\n", "s.obj:2: 'f a b c' does not hold vertex numbers"),
            ("v 0 0 0\nf 99999999999999999999 1 1\n", "s.obj:2"),
            ("", "no triangle"),
            ("v 0 0 0\nl 1 1\nf 1 1\n", "no triangle"),
        ] {
            let got = message(obj, None);
            assert!(got.contains(part), "expected {part:?} in {got:?}");
        }
    }

    #[test]
    fn missing_materials_are_grey_with_a_warning() {
        let scene = load(TRIANGLE, None).unwrap();
        assert_eq!(scene.materials[0].reflectance, [0.5; 3]);
        assert!(scene.warnings[0].starts_with("s.obj:4: "), "{:?}", scene.warnings);

        let scene = load(&format!("mtllib gone.mtl\nusemtl wall\n{TRIANGLE}"), None).unwrap();
        assert_eq!(scene.materials[0].name, "wall");
        assert!(scene.warnings.iter().any(|w| w.contains("gone.mtl")));
        assert!(scene.warnings.iter().any(|w| w.contains("'wall'") && w.contains("0.5 grey")));

        let scene = load(&format!("mtllib s.mtl\nusemtl a\n{TRIANGLE}"), Some("newmtl a\nKe 1 2 3\n")).unwrap();
        assert_eq!((scene.materials[0].reflectance, scene.materials[0].emission), ([0.5; 3], [1.0, 2.0, 3.0]));
        assert!(scene.warnings[0].contains("'a' has no Kd"));
    }

    #[test]
    fn material_values_are_judged() {
        let with = |mtl: &str| load(&format!("mtllib s.mtl\nusemtl my wall\n{TRIANGLE}"), Some(mtl));
        let scene = with("newmtl my wall\nKd 0.25\nillum 2\nd 1.0\nNi 1.45\nKs 0 0 0\n").unwrap();
        assert_eq!(scene.materials[0].reflectance, [0.25; 3]);
        assert!(scene.warnings.is_empty());
        let scene = with("newmtl my wall\nKd 1.0000005 1 0.5 # white\n").unwrap();
        assert_eq!(scene.materials[0].reflectance, [0.98, 0.98, 0.5]);
        assert!(scene.warnings[0].contains("'my wall'"));
        // Materials that no face uses may be anything.
        with("newmtl other\nKd 7 7 7\nnewmtl my wall\nKd .5 .5 .5\n").unwrap();
        for (kd, band) in [("0.5 1.1 0.5", "green"), ("-0.1 0 0", "red"), ("0 0 nan", "blue")] {
            match with(&format!("newmtl my wall\nKd {kd}\n")) {
                Err(Error::InvalidReflectance { material, band: b, .. }) => assert_eq!((material.as_str(), b), ("my wall", band)),
                other => panic!("{kd}: {other:?}"),
            }
        }
        for (mtl, part) in [
            ("newmtl my wall\nKd 0.5 0.5\n", "s.mtl:2"),
            ("newmtl my wall\nKd spectral a.rfl\n", "s.mtl:2"),
            ("newmtl\n", "s.mtl:1"),
            ("newmtl my wall\nKd 0 0 0\nKe 1 -1 0\n", "emission -1"),
            ("newmtl my wall\nKd 0 0 0\nKe inf 1 0\n", "emission inf"),
        ] {
            let got = with(mtl).expect_err(mtl).to_string();
            assert!(got.contains(part), "expected {part:?} in {got:?}");
        }
    }
}
