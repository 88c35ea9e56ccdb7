//! OBJ + MTL, as people's exporters really write them.
//!
//! The OBJ statements are read here, because every error must name its line and every vertex must keep
//! the number its author gave it (tobj renumbers vertices per mesh, takes polylines for triangles and
//! refuses a whole file for a one-dimensional `vt`). MTL values go through tobj, after a scan that finds
//! bad lines and passes on only what is used (tobj panics on `Kd 0.5`).

use super::*;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};

/// Reflectance where the MTL says nothing.
const GREY: f64 = 0.5;
/// A reflectance of 1, as exporters write for "white", becomes this.
const NEARLY_ONE: f64 = 0.98;
/// The last reflectance that counts as 1.
const ONE: f64 = 1.0 + 1e-6;

/// Reads an OBJ file with its materials. Faces of more than three corners are cut into fans.
///
/// Errors: [`Error::Read`], [`Error::Format`], [`Error::InvalidVertex`] and [`Error::IndexOutOfRange`]
/// with file and line.
pub fn read_obj(path: &Path) -> Result<Scene> {
    let text = read_text(path)?;
    let place = |line: usize| format!("{}:{line}", path.display());
    let mut scene = Scene { name: path.display().to_string(), ..Scene::default() };
    let mut library = Library::default();

    // Vertices and libraries first: faces may name what comes after them.
    for (line, statement) in statements(&text) {
        match split(&statement) {
            ("v", rest) => {
                let v = numbers(rest).filter(|v| v.len() >= 3).ok_or_else(|| bad(path, line, &statement, "three numbers"))?;
                let (index, value) = (scene.vertices.len(), [v[0], v[1], v[2]]);
                if !value.iter().all(|x| x.is_finite()) {
                    return Err(Error::InvalidVertex { place: place(line), index, value });
                }
                scene.vertices.push(value);
            }
            ("mtllib", rest) => library.load(path, rest, &mut scene.warnings)?,
            _ => {}
        }
    }

    // Faces, under the names that hold where they stand.
    let count = scene.vertices.len();
    let mut seen = 0i64; // vertices so far, for relative indices
    let (mut object, mut material) = ("unnamed".to_string(), None);
    let mut objects: HashMap<String, u32> = HashMap::new();
    let mut materials: HashMap<Option<String>, u32> = HashMap::new();
    let (mut thin, mut concave) = (0, 0);
    for (line, statement) in statements(&text) {
        match split(&statement) {
            ("v", _) => seen += 1,
            ("o" | "g", "") => object = "unnamed".into(),
            ("o" | "g", rest) => object = rest.into(),
            ("usemtl", rest) => material = (!rest.is_empty()).then(|| rest.to_string()),
            ("f", rest) => {
                let mut corners = Vec::new();
                for word in words(rest) {
                    let index: i64 = word
                        .split('/')
                        .next()
                        .and_then(|w| w.parse().ok())
                        .ok_or_else(|| bad(path, line, &statement, "vertex numbers"))?;
                    let from_0 = if index < 0 { seen.saturating_add(index) } else { index - 1 };
                    if !(0..count as i64).contains(&from_0) {
                        return Err(Error::IndexOutOfRange { place: place(line), index, count });
                    }
                    corners.push(from_0 as u32);
                }
                if corners.len() < 3 {
                    thin += 1;
                    continue;
                }
                if !open_fan(&mut corners, &scene.vertices) {
                    concave += 1;
                }
                let next = objects.len() as u32;
                let object = *objects.entry(object.clone()).or_insert_with(|| {
                    scene.objects.push(object.clone());
                    next
                });
                let next = materials.len() as u32;
                let material = *materials.entry(material.clone()).or_insert_with(|| {
                    scene.materials.push(library.resolve(material.as_deref(), line, &mut scene.warnings));
                    next
                });
                for pair in corners[1..].windows(2) {
                    scene.faces.push(Face { vertices: [corners[0], pair[0], pair[1]], material, object });
                }
            }
            _ => {}
        }
    }
    if thin > 0 {
        scene.warnings.push(format!("{thin} face(s) with fewer than three corners were left out"));
    }
    if concave > 0 {
        scene.warnings.push(format!("{concave} polygon(s) cannot be cut into a fan without overlap; triangulate on export"));
    }
    Ok(scene)
}

/// The materials of all MTL files that an OBJ names.
#[derive(Default)]
struct Library {
    /// Name to reflectance (where given) and emission.
    entries: BTreeMap<String, (Option<[f64; 3]>, [f64; 3])>,
    /// Materials with a texture that is not read.
    textured: Vec<String>,
}

impl Library {
    /// Reads what a `mtllib` statement names; a file that is not there is worth a warning, no more.
    fn load(&mut self, obj: &Path, names: &str, warnings: &mut Vec<String>) -> Result<()> {
        let folder = obj.parent().unwrap_or(Path::new(""));
        let find = |name: &str| {
            let name = folder.join(name.replace('\\', "/"));
            name.is_file().then_some(name)
        };
        // One name that may hold spaces, or several without.
        let found: Vec<_> = match find(names) {
            Some(file) => vec![file],
            None => words(names)
                .filter_map(|name| {
                    let file = find(name);
                    if file.is_none() {
                        warnings.push(format!("material file '{name}' was not found beside {}", obj.display()));
                    }
                    file
                })
                .collect(),
        };
        for file in found {
            self.read(&file)?;
        }
        Ok(())
    }

    fn read(&mut self, path: &Path) -> Result<()> {
        let text = read_text(path)?;
        let mut clean = String::new();
        let mut current = "";
        let lines: Vec<_> = statements(&text).collect();
        for (line, statement) in &lines {
            match split(statement) {
                ("newmtl", "") => return Err(bad(path, *line, statement, "a name")),
                ("newmtl", name) => {
                    current = name;
                    clean += &format!("newmtl {name}\n");
                }
                (key @ ("Kd" | "Ke"), rest) => {
                    // One number stands for three, says the format.
                    let v = match numbers(rest).as_deref() {
                        Some(&[v]) => [v; 3],
                        Some(&[r, g, b]) => [r, g, b],
                        _ => return Err(bad(path, *line, statement, "linear red, green and blue")),
                    };
                    clean += &format!("{key} {:?} {:?} {:?}\n", v[0], v[1], v[2]);
                }
                ("map_Kd" | "map_Ke", _) => self.textured.push(current.into()),
                _ => {}
            }
        }
        let (materials, _) = tobj::load_mtl_buf(&mut clean.as_bytes()).map_err(|e| Error::Format {
            path: path.into(),
            line: None,
            what: e.to_string(),
            cure: "re-export the materials".into(),
        })?;
        for m in materials {
            self.entries.insert(m.name, (m.diffuse, m.emissive.unwrap_or_default()));
        }
        Ok(())
    }

    /// The material that faces use from this line on, defaults filled in with a warning.
    fn resolve(&self, name: Option<&str>, line: usize, warnings: &mut Vec<String>) -> Material {
        let grey = format!("{GREY} grey is assumed");
        let Some(name) = name else {
            warnings.push(format!("faces from line {line} on have no material (no usemtl): {grey}"));
            return Material { name: "default".into(), reflectance: [GREY; 3], emission: [0.0; 3] };
        };
        let entry = self.entries.get(name);
        let mut reflectance = match entry {
            None => {
                warnings.push(format!("material '{name}' (line {line}) is in no material file: {grey}"));
                [GREY; 3]
            }
            Some((None, _)) => {
                warnings.push(format!("material '{name}' has no Kd: {grey}"));
                [GREY; 3]
            }
            Some((Some(kd), _)) => *kd,
        };
        if reflectance.iter().any(|x| (1.0..=ONE).contains(x)) {
            warnings.push(format!("material '{name}' reflects everything (Kd 1), which no surface does: {NEARLY_ONE} is taken"));
            reflectance = reflectance.map(|x| if (1.0..=ONE).contains(&x) { NEARLY_ONE } else { x });
        }
        if self.textured.iter().any(|t| t == name) {
            warnings.push(format!("material '{name}' has a texture; textures are not read yet, its Kd and Ke are used alone"));
        }
        Material { name: name.into(), reflectance, emission: entry.map_or([0.0; 3], |e| e.1) }
    }
}

/// The file as text; what is not UTF-8 (old exporters' names) is replaced, not refused.
fn read_text(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let text = String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

/// Statements with the number of their first line; a backslash at a line's end continues it.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut statement = Cow::Borrowed(line.trim());
        while statement.ends_with('\\') {
            let more = lines.next().map_or("", |(_, more)| more.trim());
            statement = Cow::Owned(format!("{} {more}", statement.trim_end_matches('\\')));
        }
        Some((number + 1, statement))
    })
}

/// Keyword and the rest of a statement.
fn split(statement: &str) -> (&str, &str) {
    let end = statement.find(char::is_whitespace).unwrap_or(statement.len());
    (&statement[..end], statement[end..].trim())
}

/// Words up to a comment.
fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|w| !w.starts_with('#'))
}

/// All words as numbers, or nothing.
fn numbers(rest: &str) -> Option<Vec<f64>> {
    words(rest).map(|w| w.parse().ok()).collect()
}

fn bad(path: &Path, line: usize, statement: &str, wanted: &str) -> Error {
    let shown: String = statement.chars().take(60).collect();
    Error::Format {
        path: path.into(),
        line: Some(line),
        what: format!("'{shown}' does not hold {wanted}"),
        cure: "correct the line or re-export the scene".into(),
    }
}

/// Turns a polygon so that the fan from its first corner folds nowhere. False where no corner serves.
fn open_fan(corners: &mut [u32], vertices: &[[f64; 3]]) -> bool {
    if corners.len() == 3 {
        return true;
    }
    let at = |c: u32| glam::DVec3::from_array(vertices[c as usize]);
    let area = |c: &[u32], i: usize| (at(c[i]) - at(c[0])).cross(at(c[i + 1]) - at(c[0]));
    let inner = 1..corners.len() - 1;
    let normal: glam::DVec3 = inner.clone().map(|i| area(corners, i)).sum();
    let slack = -1e-12 * normal.length_squared();
    for _ in 0..corners.len() {
        if inner.clone().all(|i| area(corners, i).dot(normal) >= slack) {
            return true;
        }
        corners.rotate_left(1);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    fn load(obj: &str, mtl: Option<&str>) -> Result<Scene> {
        let dir = tempfile::tempdir().unwrap();
        if let Some(mtl) = mtl {
            std::fs::write(dir.path().join("s.mtl"), mtl).unwrap();
        }
        let path = dir.path().join("s.obj");
        std::fs::write(&path, obj).unwrap();
        Scene::load(&path)
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
    fn polygons_become_fans_even_when_concave() {
        // An arrow head, dented at its second corner: only two of its corners open a fan.
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
        assert!(scene.warnings[0].contains("line 4"), "{:?}", scene.warnings);

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
        let scene = with("newmtl my wall\nKd 0.25\nillum x\nmap_Bump\nKs 1\n").unwrap();
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

    #[test]
    fn noise_never_panics() {
        let mut state = 1u32;
        let pieces =
            ["v ", "f ", "1 ", "-1 ", "0.5 ", "/", "\\\n", "\n", "#", "usemtl ", "mtllib s.mtl", "nan ", "o ", "é", "1e400 "];
        for _ in 0..2000 {
            let mut text = String::new();
            for _ in 0..40 {
                state = state.wrapping_mul(1664525).wrapping_add(1013904223);
                text += pieces[(state >> 16) as usize % pieces.len()];
            }
            let _ = load(&text, None);
        }
        assert!(matches!(Scene::load("no/such.obj"), Err(Error::Read { .. })));
    }
}
