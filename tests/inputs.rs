//! Scenes as people have them: formats, units, winding, and what is said of each.
//!
//! Bakes run on a GPU (a software one counts); without any they pass with a note, unless `RAYCELL_REQUIRE_GPU` is set.

mod common;

use common::root;
use raycell::output::points;
use raycell::scene::{Face, Geometry, KdSpace, LoadOptions, Material, Up};
use raycell::{Answer, Backend, Error, Event, Flow, Params, Result, Scene, SurfacePoint, bake};
use std::path::Path;

/// What bakes run on, or a note that there is nothing.
fn backend() -> Option<Backend> {
    common::gpu().map(Backend::Gpu)
}

/// The first of the files, as a scene; the others lie beside it.
fn load(files: &[(&str, &[u8])], options: &LoadOptions) -> Result<Scene> {
    let mut read = |path: &Path| match files.iter().find(|(name, _)| path == Path::new(name)) {
        Some((_, bytes)) => Ok(bytes.to_vec()),
        None => Err(std::io::ErrorKind::NotFound.into()),
    };
    Scene::load_from(Path::new(files[0].0), options, &mut read, &mut |_| Flow::Continue)
}

fn refusal(files: &[(&str, &[u8])]) -> String {
    load(files, &LoadOptions::default()).expect_err("should be refused").to_string()
}

/// A bake, its answers at points, and what it warned of.
fn baked(backend: &Backend, scene: &Scene, rays: u32, at: &[SurfacePoint]) -> (Vec<Answer>, Vec<String>) {
    let mut warnings = Vec::new();
    let params = Params { rays, ..Params::default() };
    let solution = bake(backend, scene, &params, &mut |event| {
        if let Event::Warning(text) = event {
            warnings.push(text.clone());
        }
        Flow::Continue
    });
    let solution = solution.unwrap();
    assert_eq!(solution.report().warnings, warnings);
    (solution.query(backend, at).unwrap(), warnings)
}

/// The centre of each triangle.
fn centres(scene: &Scene) -> Vec<SurfacePoint> {
    let point = |f: usize| {
        let [a, b, c] = scene.corners(f).map(glam::DVec3::from_array);
        SurfacePoint { p: ((a + b + c) / 3.0).to_array(), n: (b - a).cross(c - a).normalize().to_array() }
    };
    (0..scene.faces.len()).map(point).collect()
}

fn turned(mut scene: Scene) -> Scene {
    scene.faces.iter_mut().for_each(|f| f.vertices.swap(1, 2));
    scene
}

fn two_sided(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let twins: Vec<Face> =
        scene.faces.iter().map(|f| Face { vertices: [f.vertices[0], f.vertices[2], f.vertices[1]], ..*f }).collect();
    scene.faces.extend(twins);
    scene
}

#[test]
fn one_room_in_all_formats_gives_the_same_bytes() {
    let scenes: Vec<Scene> =
        ["obj", "gltf", "glb", "toml"].map(|e| Scene::load(root(&format!("scenes/room/scene.{e}"))).unwrap()).into();
    for scene in &scenes {
        assert_eq!(scene.warnings, Vec::<String>::new(), "{}", scene.name);
    }
    let Some(backend) = backend() else { return };
    let dir = tempfile::tempdir().unwrap();
    let at = centres(&scenes[0]);
    let mut files = Vec::new();
    for scene in &scenes {
        let (answers, warnings) = baked(&backend, scene, 4096, &at);
        assert_eq!(warnings, Vec::<String>::new(), "{}", scene.name);
        let path = dir.path().join("points.csv");
        points::write(&path, &at, &answers).unwrap();
        files.push(std::fs::read(&path).unwrap());
    }
    assert!(String::from_utf8_lossy(&files[0]).lines().count() == at.len() + 1);
    for (scene, file) in scenes.iter().zip(&files) {
        assert!(*file == files[0], "{} gives other bytes than {}", scene.name, scenes[0].name);
    }
}

#[test]
fn a_box_turned_inside_out_is_told_and_cured_by_both_sides() {
    let Some(backend) = backend() else { return };
    let right = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
    let wrong = turned(right.clone());
    let at = points::read(&root("tests/data/cornell.truth.csv")).unwrap();
    let rays = 65_536;
    let (light, quiet) = baked(&backend, &right, rays, &at);
    assert_eq!(quiet, Vec::<String>::new());
    let (cured, quiet) = baked(&backend, &two_sided(&wrong), rays, &at);
    assert_eq!(quiet, Vec::<String>::new());
    // Both carry the noise of their rays; with both sides to light, each gets half as many. Default bakes with eight
    // times the rays are held to 2.4 % of truth.
    let level = light.iter().flat_map(|a| a.b).sum::<f64>() / (3 * at.len()) as f64;
    let square = light.iter().zip(&cured).flat_map(|(a, b)| [0, 1, 2].map(|k| (a.b[k] - b.b[k]).powi(2))).sum::<f64>();
    let rms = (square / (3 * at.len()) as f64).sqrt() / level;
    eprintln!("inside out with both sides against right: {:.2} %", 100.0 * rms);
    assert!(rms < 0.04, "{rms}");

    // One object alone turned: its name and the share.
    let mut one = right.clone();
    let name = right.objects[right.faces[0].object as usize].clone();
    one.faces.iter_mut().filter(|f| f.object == right.faces[0].object).for_each(|f| f.vertices.swap(1, 2));
    let (_, warnings) = baked(&backend, &one, 16_384, &at[..1]);
    let told = warnings.iter().find(|w| w.contains(&format!("object '{name}'"))).unwrap_or_else(|| panic!("{warnings:?}"));
    assert!(told.contains("% of the rays that meet it meet its back; flip") && told.contains("--two-sided"), "{told}");

    // The lamp alone turned: it lights nothing.
    let lamp = right.materials.iter().position(|m| m.emission[0] > 0.0).unwrap() as u32;
    let mut dark = right.clone();
    dark.faces.iter_mut().filter(|f| f.material == lamp).for_each(|f| f.vertices.swap(1, 2));
    let (_, warnings) = baked(&backend, &dark, 16_384, &at[..1]);
    assert!(warnings.iter().any(|w| w.contains("shines, but")), "{warnings:?}");
}

/// A closed box 2 m wide with a sheet across its middle; the ceiling above shines.
fn divided() -> Scene {
    let grey = Material::new("grey", [0.5; 3], [0.0; 3]);
    let lamp = Material::new("lamp", [0.0; 3], [1.0; 3]);
    let quad = |p: [[f64; 3]; 4], m: u32| [([p[0], p[1], p[2]], m), ([p[0], p[2], p[3]], m)];
    let wall = |a: [f64; 2], b: [f64; 2]| quad([[a[0], -1.0, a[1]], [a[0], 1.0, a[1]], [b[0], 1.0, b[1]], [b[0], -1.0, b[1]]], 0);
    let level = |y: f64, m| quad([[-1.0, y, -1.0], [-1.0, y, 1.0], [1.0, y, 1.0], [1.0, y, -1.0]], m);
    let mut triangles = level(-1.0, 0).to_vec();
    triangles.extend(level(1.0, 1).map(|([a, b, c], m)| ([a, c, b], m)));
    for (a, b) in [([-1., -1.], [1., -1.]), ([1., -1.], [1., 1.]), ([1., 1.], [-1., 1.]), ([-1., 1.], [-1., -1.])] {
        triangles.extend(wall(a, b).map(|([a, b, c], m)| ([a, c, b], m)));
    }
    let inward = |([a, b, c], m): ([[f64; 3]; 3], u32)| {
        let [p, q, r] = [a, b, c].map(glam::DVec3::from_array);
        if (q - p).cross(r - p).dot(p + q + r) > 0.0 { ([a, c, b], m) } else { ([a, b, c], m) }
    };
    let mut triangles: Vec<_> = triangles.into_iter().map(inward).collect();
    triangles.extend(level(0.0, 0));
    triangles.extend(level(0.0, 0).map(|([a, b, c], m)| ([a, c, b], m)));
    Scene::from_triangles("divided", &triangles, vec![grey, lamp]).unwrap()
}

#[test]
fn a_sheet_has_two_sides_and_lets_nothing_through() {
    let scene = divided();
    let geometry = Geometry::new(&scene).unwrap();
    assert_eq!((geometry.tris.len(), geometry.duplicate.len()), (16, 0));
    let at = |y: f64, ny: f64| SurfacePoint { p: [0.3, y, 0.2], n: [0.0, ny, 0.0] };
    let at = [at(0.0, 1.0), at(0.0, -1.0), at(-1.0, 1.0), SurfacePoint { p: [1.0, -0.1, 0.0], n: [-1.0, 0.0, 0.0] }];
    let mut backends = vec![("cpu", Backend::Cpu)];
    backends.extend(backend().map(|b| ("gpu", b)));
    for (name, backend) in backends {
        let (light, warnings) = baked(&backend, &scene, 16_384, &at);
        assert_eq!(warnings, Vec::<String>::new());
        // Above: at least the ceiling's light straight down, at most what a closed white box of its kind could hold.
        let lit = light[0].b[0];
        assert!(lit > 0.5 && lit < std::f64::consts::PI, "{name}: {lit}");
        // Below: nothing, exactly.
        for (i, dark) in light[1..].iter().enumerate() {
            assert_eq!(dark.b, [0.0; 3], "{name}: light leaks to point {}", i + 1);
        }
        // Turned over, the other side is lit just as well: no side is preferred.
        let mut over = scene.clone();
        over.vertices.iter_mut().for_each(|v| *v = [v[0], -v[1], v[2]]);
        let (light, _) = baked(&backend, &turned(over), 16_384, &[SurfacePoint { n: [0.0, -1.0, 0.0], ..at[0] }, at[0]]);
        assert!((light[0].b[0] / lit - 1.0).abs() < 0.05, "{name}: {} against {lit}", light[0].b[0]);
        assert_eq!(light[1].b, [0.0; 3], "{name}");
    }
}

#[test]
fn both_sides_come_by_option_material_and_file() {
    let triangle: &[u8] = b"mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let mtl: &[u8] = b"newmtl a\nKd .5 .5 .5\n";
    let options = |two_sided| {
        let mut options = LoadOptions::default();
        options.two_sided = two_sided;
        options
    };
    let faces = |toml: &str, two_sided| {
        let files: [(&str, &[u8]); 3] = [("s.toml", toml.as_bytes()), ("s.obj", triangle), ("s.mtl", mtl)];
        load(&files, &options(two_sided)).unwrap().faces.iter().map(|f| f.vertices).collect::<Vec<_>>()
    };
    let both = vec![[0, 1, 2], [0, 2, 1]];
    assert_eq!(faces("[[file]]\npath = 's.obj'\n", false), both[..1]);
    assert_eq!(faces("[[file]]\npath = 's.obj'\n", true), both);
    assert_eq!(faces("[[file]]\npath = 's.obj'\ntwo_sided = true\n", true), both);
    assert_eq!(faces("[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\ntwo_sided = true\n", false), both);
    // A twin that its author has drawn is not drawn again.
    let drawn = [triangle, b"f 1 3 2\n"].concat();
    assert_eq!(load(&[("s.obj", &drawn), ("s.mtl", mtl)], &options(true)).unwrap().faces.len(), 2);
}

#[test]
fn units_axes_and_colours_are_as_told() {
    let obj: &[u8] = b"mtllib s.mtl\nv 0 0 0\nv 100 0 0\nv 0 200 300\nusemtl a\nf 1 2 3\n";
    let files: [(&str, &[u8]); 2] = [("s.obj", obj), ("s.mtl", b"newmtl a\nKd 0.5 0 1.0\n")];
    let mut options = LoadOptions::default();
    (options.unit, options.up, options.kd_space) = (0.01, Up::Z, KdSpace::Srgb);
    let scene = load(&files, &options).unwrap();
    assert_eq!(scene.corners(0), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 3.0, -2.0]]);
    // IEC 61966-2-1: 0.5 is 0.2140; 1 stays 1, and is too much.
    let [r, g, b] = scene.materials[0].reflectance;
    assert!((r - 0.214041).abs() < 1e-6 && g == 0.0 && b == 0.98, "{:?}", scene.materials[0]);
    assert_eq!(scene.warnings.len(), 1);
    options.strict = true;
    let error = load(&files, &options).unwrap_err();
    assert!(matches!(error, Error::Strict { .. }) && error.to_string().starts_with("s.mtl:2: material 'a'"), "{error}");
    for unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        options.unit = unit;
        assert!(matches!(load(&files, &options), Err(Error::InvalidParam { name: "unit", .. })));
    }
    assert!(refusal(&[("s.fbx", b"")]).starts_with("s.fbx: the name does not tell a format"));
}

#[test]
fn what_exporters_write_is_read_or_named() {
    // Windows' line ends and paths, a byte order mark, Latin-1 names, several libraries, spaces in names.
    let obj = b"\xef\xbb\xbf# x\r\nmtllib C:\\work\\my scene.mtl\r\nmtllib a.mtl b.mtl\r\no W\xe4nde\r\nv 0 0 0\r\nv\t1 0 0\r\nv 0 1 0\r\n\
        usemtl dark wood\r\nf 1 2 \\\r\n3\r\nusemtl b\r\nf 1 2 3\r\nl 1 2\r\np 1\r\ncurv2 1 2\r\n";
    let mtl = b"newmtl dark wood\nKd .25 .25 .25\nmap_Kd wood.png\nillum 7\nd 0.5\nKs 0.5 0 0\nNs 10\nKa 1 1 1\nTr 0\n";
    let files: [(&str, &[u8]); 3] = [("s.obj", obj), ("my scene.mtl", mtl), ("b.mtl", b"newmtl b\nKd .5 .5 .5\nmap_Kd b.png\n")];
    let scene = load(&files, &LoadOptions::default()).unwrap();
    assert_eq!(scene.objects, ["W\u{e4}nde"]);
    assert_eq!(
        scene.materials.iter().map(|m| (m.name.as_str(), m.reflectance[0])).collect::<Vec<_>>(),
        [("dark wood", 0.25), ("b", 0.5)]
    );
    assert_eq!(scene.material_places, ["my scene.mtl:2", "b.mtl:2"]);
    let all = scene.warnings.join("\n");
    for part in [
        "my scene.mtl: not supported and left out: illum (once, line 4), d (once, line 5), Ks (once, line 6);",
        "my scene.mtl:3: texture 'wood.png' was not found",
        "b.mtl:3: texture 'b.png' was not found",
        "s.obj:3: material file 'a.mtl' was not found",
        "s.obj: not supported and left out: l (once, line 13), p (once, line 14), curv2 (once, line 15);",
    ] {
        assert!(all.contains(part), "expected {part:?} in\n{all}");
    }
    assert_eq!(scene.warnings.len(), 5, "{all}");
}

#[test]
fn big_files_tell_their_progress_and_can_be_stopped() {
    let side = 300;
    let mut obj = String::new();
    for i in 0..=side {
        for j in 0..=side {
            obj += &format!("v {} {} {}\n", i as f64 * 0.01, ((i * j) % 7) as f64 * 0.001, j as f64 * 0.01);
        }
    }
    for i in 0..side {
        for j in 0..side {
            let a = i * (side + 1) + j + 1;
            obj += &format!("f {} {} {} {}\n", a, a + 1, a + side + 2, a + side + 1);
        }
    }
    let mut files = |_: &Path| Ok(obj.clone().into_bytes());
    let mut seen = Vec::new();
    let scene = Scene::load_from(Path::new("s.obj"), &LoadOptions::default(), &mut files, &mut |event| {
        if let Event::Read { done, total } = event {
            seen.push((*done, *total));
        }
        Flow::Continue
    });
    assert_eq!(scene.unwrap().faces.len(), 2 * side * side);
    assert!(seen.len() >= 3 && seen.windows(2).all(|w| w[0].0 < w[1].0) && seen.iter().all(|s| s.0 <= s.1), "{seen:?}");
    let stopped = Scene::load_from(Path::new("s.obj"), &LoadOptions::default(), &mut files, &mut |_| Flow::Stop);
    assert!(matches!(stopped, Err(Error::Cancelled)));
}

const TRIANGLE: &[u8] = b"mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no leaf\nusemtl a\nf 1 2 3\n";

/// A TOML scene with the triangle `s.obj` beside it.
fn toml(text: &str) -> Result<Scene> {
    let mtl: &[u8] = b"newmtl a\nKd .5 .5 .5\n";
    load(&[("s.toml", text.as_bytes()), ("s.obj", TRIANGLE), ("s.mtl", mtl)], &LoadOptions::default())
}

#[test]
fn toml_places_files() {
    let text = "[[file]]\npath = 's.obj'\nunit = 2\nup = 'z'\nscale = [1, 3, -1]\nrotate = [0, 0, 90]\ntranslate = [10, 0, 0]\n\
        [[file]]\npath = 's.obj'\nmatrix = [[0, 0, 1, 5], [1, 0, 0, 6], [0, 1, 0, 7], [0, 0, 0, 1]]\n";
    let scene = toml(text).unwrap();
    // (0,1,0) in file -> up z: (0,0,-1) -> unit: (0,0,-2) -> scale: (0,0,2) -> turn about z -> move.
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12);
    let c = scene.corners(0);
    // The scale mirrors, so the winding is turned for the front to stay in front.
    assert!(near(c[0], [10.0, 0.0, 0.0]) && near(c[1], [10.0, 0.0, 2.0]) && near(c[2], [10.0, 2.0, 0.0]), "{c:?}");
    assert_eq!(scene.corners(1), [[5.0, 6.0, 7.0], [5.0, 7.0, 7.0], [5.0, 6.0, 8.0]]);
    assert_eq!((scene.objects.len(), scene.faces[1].object, scene.faces[1].material), (2, 1, 1));
}

#[test]
fn toml_lights_are_radiance_radiosity_or_lumens() {
    let with = |light: &str| {
        let scene = toml(&format!("[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\nreflectance = 0.25\n{light}\n")).unwrap();
        assert_eq!(scene.materials[0].reflectance, [0.25; 3]);
        scene.materials[0].emission
    };
    let pi = std::f64::consts::PI;
    assert_eq!(with("radiance = [1, 2, 3]"), [1.0, 2.0, 3.0]);
    assert_eq!(with("radiosity = 5"), [5.0 / pi; 3]);
    // The triangle is half a square metre: 179 lm are a watt, 2 W/m2, 2/pi W/m2/sr.
    let white = with("lumens = 179");
    assert!(white.iter().all(|x| (x - 2.0 / pi).abs() < 1e-12), "{white:?}");
    // Green alone is 0.7152 of the luminance of white.
    let green = with("lumens = 179\ncolor = [0, 3, 0]");
    assert!(green[0] == 0.0 && (green[1] - 2.0 / pi / 0.7152).abs() < 1e-12, "{green:?}");
    // Two sides share the lumens.
    let both = with("lumens = 179\ntwo_sided = true");
    assert!((both[0] - 1.0 / pi).abs() < 1e-12, "{both:?}");
    // And metres are those of the scene, not of the file.
    let text = "[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\nlumens = 179\n";
    let mut options = LoadOptions::default();
    options.unit = 10.0;
    let scene = load(&[("s.toml", text.as_bytes()), ("s.obj", TRIANGLE), ("s.mtl", b"newmtl a\nKd 0 0 0\n")], &options).unwrap();
    assert!((scene.materials[0].emission[0] - 0.02 / pi).abs() < 1e-14);
}

#[test]
fn toml_faults_are_named_by_line() {
    let mesh = "[[mesh]]\nname = 'm'\nmaterial = 'a'\nvertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]\n";
    assert!(toml(mesh).unwrap().warnings[0].starts_with("s.toml:1: material 'a' has no reflectance"));
    for (text, part) in [
        ("[[file]]\npath = 's.obj'\ncolour = 3\n", "s.toml:3: unknown field `colour`"),
        ("[[file]]\npath = 3\n", "s.toml:2: "),
        ("x =\n", "s.toml:1: "),
        ("\n[[file]]\npath = 'gone.obj'\n", "cannot read gone.obj"),
        ("\n[[file]]\npath = 's.toml'\n", "s.toml:2: file 's.toml' is a .toml itself"),
        ("[[file]]\npath = 's.obj'\nunit = 0\n", "s.toml:1: file 's.obj' has a unit"),
        ("[[file]]\npath = 's.obj'\nscale = nan\n", "s.toml:1: file 's.obj' is moved by"),
        ("[[file]]\npath = 's.obj'\nscale = 2\nmatrix = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n", "has a matrix beside"),
        (
            "[[file]]\npath = 's.obj'\nscale = 1e308\ntranslate = [1e308, 1e308, 0]\nunit = 10\n",
            "s.toml:1: file 's.obj': vertex 0 is not finite in 32 bits",
        ),
        (
            "[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\nradiance = 1\nlumens = 2\n",
            "s.toml:3: material 'a' has more than one",
        ),
        ("[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\nreflectance = 1.5\n", "s.toml:3: material 'a': reflectance 1.5"),
        (
            "[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\nlumens = 1\ncolor = [0, 0, 0]\n",
            "s.toml:3: material 'a' has a color",
        ),
        (
            "[[file]]\npath = 's.obj'\n[[camera]]\nname = 'c'\neye = [0, 0, 0]\ntarget = [0, 0, 0]\n",
            "s.toml:3: camera 'c' cannot be used",
        ),
        (&mesh.replace("0, 1, 2]]", "0, 1, 3]]"), "s.toml:1: mesh 'm', face 0: index 3 is out of range"),
        (&mesh.replace("0, 1, 2]]", "0, 1]]"), "s.toml:1: mesh 'm': face 0 has fewer than three corners"),
        (&mesh.replace("[1, 0, 0]", "[1, inf, 0]"), "s.toml:1: mesh 'm': vertex 1 is not finite"),
    ] {
        let message = toml(text).expect_err(text).to_string();
        assert!(message.contains(part), "expected {part:?} in {message:?}");
    }
    // A material that a table describes is not judged by its file.
    let white: &[u8] = b"newmtl a\nKd 1 1 1\n";
    let text: &[u8] = b"[[file]]\npath = 's.obj'\n[[material]]\nname = 'a'\nreflectance = 0.5\n";
    assert_eq!(
        load(&[("s.toml", text), ("s.obj", TRIANGLE), ("s.mtl", white)], &LoadOptions::default()).unwrap().warnings.len(),
        0
    );
    assert!(
        toml(&format!("{mesh}[[material]]\nname = 'b'\n")).unwrap().warnings[1]
            .starts_with("s.toml:6: material 'b' is used by no face")
    );
}

/// A glTF file with one triangle of 16-bit indices in a data: URI.
fn gltf(nodes: &str, materials: &str, more: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{nodes}], "materials": [{materials}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
                      {{"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 6}}],
        "buffers": [{{"byteLength": 42, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}}]{more}}}"#
    )
}

const GREY: &str = r#"{"name": "grey", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}}"#;

#[test]
fn gltf_nodes_materials_and_cameras() {
    let nodes = r#"{"name": "a", "mesh": 0, "translation": [1, 2, 3], "children": [1, 2]},
        {"mesh": 0, "scale": [-2, 2, 2]}, {"name": "eye", "camera": 0, "rotation": [0, 0.70710678, 0, 0.70710678]}"#;
    let lamp = r#"{"name": "lamp", "doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0, 1]},
        "emissiveFactor": [1, 0.5, 0], "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}}"#;
    let more = r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 2, "znear": 1}}],
        "textures": [{"source": 0}], "images": [{"uri": "x.png"}], "extensionsUsed": ["EXT_lights_image_based"]"#;
    let scene = load(&[("s.gltf", gltf(nodes, lamp, more).as_bytes())], &LoadOptions::default()).unwrap();
    assert_eq!(scene.objects, ["a", "nodes[1]"]);
    // Two instances, each with its twin; the mirrored one is wound so that its front stays in front.
    assert_eq!(scene.faces.len(), 4);
    assert_eq!(scene.corners(0), [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 3.0, 3.0]]);
    assert_eq!(scene.corners(1), [[1.0, 2.0, 3.0], [1.0, 4.0, 3.0], [-1.0, 2.0, 3.0]]);
    assert_eq!((scene.materials[0].reflectance, scene.materials[0].emission), ([0.5, 0.25, 0.0], [8.0, 4.0, 0.0]));
    let view = &scene.cameras[0];
    // Turned a quarter to the left about y: it looks along -x.
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
    assert!(view.name == "eye" && near(view.camera.eye, [1., 2., 3.]) && near(view.camera.target, [0., 2., 3.]), "{view:?}");
    assert_eq!((view.camera.width, view.camera.height), (1024, 512));
    assert!((view.camera.vfov_degrees - 0.5f64.to_degrees()).abs() < 1e-5);
    let all = scene.warnings.join("\n");
    for part in [
        "materials[0] 'lamp': texture 'x.png' was not found",
        "extension EXT_lights_image_based",
        "metals are taken for diffuse: 'lamp'",
    ] {
        assert!(all.contains(part), "expected {part:?} in\n{all}");
    }
    assert_eq!(scene.warnings.len(), 3, "{all}");
}

#[test]
fn gltf_metals_without_roughness_are_mirrors() {
    let made = |material: &str| {
        let scene = load(&[("s.gltf", gltf(r#"{"mesh": 0}"#, material, "").as_bytes())], &LoadOptions::default()).unwrap();
        (scene.materials[0].clone(), scene.warnings.join("\n"))
    };
    let metal = |color: &str, rough: f64| {
        format!(r#"{{"name": "m", "pbrMetallicRoughness": {{"baseColorFactor": {color}, "roughnessFactor": {rough}}}}}"#)
    };
    assert_eq!(made(&metal("[0.75, 0.75, 0.75, 1]", 0.0)), (Material::new_mirror("m", 0.75), String::new()));
    let (tinted, told) = made(&metal("[1, 0.5, 0.25, 1]", 0.0));
    assert!((tinted.mirror - (0.98 + 0.75) / 3.0).abs() < 1e-9 && told.contains("tinted mirror"), "{tinted:?} {told}");
    let (rough, told) = made(&metal("[0.75, 0.75, 0.75, 1]", 0.25));
    assert!(rough.mirror == 0.0 && told.contains("metals are taken for diffuse"), "{told}");
    let lamp = metal("[0.75, 0.75, 0.75, 1]", 0.0).replace("\"name\"", "\"emissiveFactor\": [1, 1, 1], \"name\"");
    assert_eq!(made(&lamp).0.mirror, 0.0);
}

#[test]
fn gltf_faults_are_named_by_their_path() {
    let node = r#"{"mesh": 0}"#;
    let good = gltf(node, GREY, "");
    assert_eq!(load(&[("s.gltf", good.as_bytes())], &LoadOptions::default()).unwrap().warnings, Vec::<String>::new());
    for (from, to, part) in [
        (
            "\"count\": 3, \"type\": \"VEC3\"",
            "\"count\": 99999999999, \"type\": \"VEC3\"",
            "s.gltf: accessors[0] reaches beyond the 36 bytes of bufferViews[0]",
        ),
        (
            "\"byteOffset\": 36, \"byteLength\": 6",
            "\"byteOffset\": 37, \"byteLength\": 6",
            "s.gltf: bufferViews[1] reaches beyond the 42 bytes",
        ),
        ("\"POSITION\": 0", "\"POSITION\": 7", "s.gltf: meshes[0].primitives[0].attributes names an accessor"),
        ("\"indices\": 1", "\"indices\": 0", "s.gltf: accessors[0] holds Vec3 of F32 where Scalar"),
        ("\"indices\": 1", "\"indices\": 7", "s.gltf: meshes[0].primitives[0].indices is refused: Index out of bounds"),
        ("{\"mesh\": 0}", "{\"mesh\": 0, \"children\": [0]}", "s.gltf: the scene has no triangle"),
        ("{\"mesh\": 0}", "{\"mesh\": 0, \"children\": [1, 1]}, {}", "s.gltf: nodes[1] hangs from two parents"),
        ("{\"mesh\": 0}", "{\"mesh\": 0, \"scale\": [3e38, 3e38, 3e38], \"children\": [1]}, {\"mesh\": 0}", "no error"),
        ("base64,AAAA", "base64,%%%%", "s.gltf: buffers[0] is no base64"),
        (
            "\"asset\"",
            "\"asset\": {\"version\": \"2.0\"}, \"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"extras\"",
            "s.gltf",
        ),
        ("\"materials\"", "\"materials", "s.gltf:"),
    ] {
        let text = good.replacen(from, to, 1);
        match load(&[("s.gltf", text.as_bytes())], &LoadOptions::default()) {
            Ok(_) => assert_eq!(part, "no error", "{text}"),
            Err(e) => assert!(e.to_string().contains(part), "expected {part:?} in {e}"),
        }
    }
    let required = good.replacen("\"asset\"", "\"extensionsRequired\": [\"KHR_draco_mesh_compression\"], \"asset\"", 1);
    assert!(
        refusal(&[("s.gltf", required.as_bytes())])
            .starts_with("s.gltf: extensionsRequired: KHR_draco_mesh_compression is not supported")
    );
    let index = good.replacen("AAABAAIA", "AAABAAMA", 1);
    assert!(refusal(&[("s.gltf", index.as_bytes())]).starts_with("s.gltf: meshes[0].primitives[0]: index 3 is out of range"));
    assert!(refusal(&[("s.glb", b"glTF\x02\0\0\0\x05\0\0\0")]).starts_with("s.glb: the first chunk is not whole JSON"));
    assert!(refusal(&[("s.glb", b"glTF\x01\0\0\0\x05\0\0\0")]).starts_with("s.glb: the header says version 1"));
}

#[test]
fn the_documents_examples_load() {
    let text = std::fs::read_to_string(root("docs/scenes.md")).unwrap();
    let blocks: Vec<&str> = text.split("```").skip(1).step_by(2).collect();
    let body = |i: usize| blocks[i].split_once('\n').unwrap().1.as_bytes();
    let mut bin: Vec<u8> = [0f32, 0., 0., 0., 0., 1., 1., 0., 1., 1., 0., 0.].iter().flat_map(|f| f.to_le_bytes()).collect();
    bin.extend([0u16, 1, 2, 0, 2, 3, 2, 1, 0, 3, 2, 0].iter().flat_map(|i| i.to_le_bytes()));
    const SKY: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81";
    let files: [(&str, &[u8]); 6] = [
        ("room.obj", body(0)),
        ("room.mtl", body(1)),
        ("room.gltf", body(2)),
        ("room.toml", body(3)),
        ("flat.toml", body(4)),
        ("room.bin", &bin),
    ];
    for (i, faces) in [(0, 4), (2, 4), (3, 5), (4, 5)] {
        let mut there = vec![files[i], ("chair.obj", TRIANGLE), ("s.mtl", b"newmtl a\nKd .5 .5 .5\n"), ("sky.hdr", SKY)];
        there.extend(files);
        let scene = load(&there, &LoadOptions::default()).unwrap();
        assert_eq!((scene.faces.len(), scene.warnings.clone()), (faces, vec![]), "{}", scene.name);
    }
}
