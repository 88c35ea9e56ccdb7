//! Textures: reflectance and emission that vary over a surface.

use crate::common::{gpu, rrmse};
use crate::maps::{checkers, floor, painted, passes, room, solve, texture, traced, unwrap};
use raycell::effects::{Switches, analyse};
use raycell::network::tiles;
use raycell::pass::GpuEngine;
use raycell::scene::{Geometry, LoadOptions, Map, Material, Texels, shapes};
use raycell::twin::TwinEngine;
use raycell::{Backend, Flow, Params, Scene, Solution, SurfacePoint};
use std::f64::consts::PI;
use std::path::Path;

/// The squares of a side of the floor.
const SQUARES: u32 = 4;

/// The room with its floor cut into squares of two materials: what a texture stands for.
fn split(dark: f64, pale: f64) -> Scene {
    let walls = shapes::sides([0.0; 3], [1.0; 3], [0, 0, 2, 1, 0, 0]);
    let mut triangles: shapes::Triangles = [0, 1, 3, 4, 5].iter().flat_map(|&i| walls[i].clone()).collect();
    let at = |i: u32| f64::from(i) / f64::from(SQUARES);
    for i in 0..SQUARES * SQUARES {
        let (x, z) = (i % SQUARES, i / SQUARES);
        let corner = |dx, dz| [at(x + dx), 0.0, at(z + dz)];
        let corners = [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
        triangles.extend(shapes::quad(corners, 2 + (x + z) % 2));
    }
    let materials = vec![
        Material::new("wall", [0.5; 3], [0.0; 3]),
        Material::new("lamp", [0.2; 3], [3.0; 3]),
        Material::new("dark", [dark; 3], [0.0; 3]),
        Material::new("pale", [pale; 3], [0.0; 3]),
    ];
    Scene::from_triangles("split", &triangles, materials).unwrap()
}

fn answers(solution: &Solution, backend: &Backend, points: &[SurfacePoint]) -> Vec<[f64; 3]> {
    solution.query(backend, points).unwrap().iter().map(|a| a.b).collect()
}

/// Points of the floor, and of a wall that sees it.
fn places() -> Vec<SurfacePoint> {
    let wall = |i: usize| SurfacePoint { p: [0.0, 0.1 + 0.15 * i as f64, 0.5], n: [1.0, 0.0, 0.0] };
    [floor(SQUARES as usize), (0..6).map(wall).collect()].concat()
}

#[test]
fn a_checkered_floor_is_one_of_squares() {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    let (points, params) = (places(), Params { rays: 65_536, ..Params::default() });
    let painted_floor = room(painted(1.0), vec![checkers(SQUARES, 0.1, 0.9)]);
    // Truth without textures, and with them: paths know both.
    let truth = traced(&split(0.1, 0.9), &points, 4_096);
    let by_texture = traced(&painted_floor, &points, 4_096);
    let off = rrmse(&by_texture, &truth);
    // Noise of 4,096 paths a point: some 0.7 % each.
    assert!(off < 0.015, "paths over texels and over squares differ by {off}");
    let baked = answers(&solve(&backend, &painted_floor, &params), &backend, &points);
    let error = rrmse(&baked, &truth);
    assert!(error < 0.02, "{error}");
    // Switched off, the floor is its mean, and fails.
    let mut plain = painted_floor.clone();
    "-textures".parse::<Switches>().unwrap().apply(&mut plain).unwrap();
    assert!(plain.warnings[0].contains("textures is off"), "{:?}", plain.warnings);
    assert!((plain.materials[2].reflectance[0] - 0.5).abs() < 1e-6 && plain.materials[2].reflectance_map.is_none());
    let without = rrmse(&answers(&solve(&backend, &plain, &params), &backend, &points), &truth);
    assert!(without > 0.2, "{without}");
    eprintln!("checkered floor: paths {off:.4}, bake {error:.4}, without the texture {without:.3}");
}

/// Every wall of a furnace with one fine random texture: H = E/(1 - mean rho) wherever rays mix its texels.
fn furnace() -> (Scene, f64) {
    let random = |i: u32| raycell::twin::math::unit(raycell::twin::math::hash(i + 9)) * 0.9;
    let fine = texture(256, 256, |x, y| [random(y * 256 + x); 4]);
    let Texels::Float(texels) = &fine.texels else { unreachable!() };
    let mean = texels.iter().map(|t| f64::from(t[0])).sum::<f64>() / 65_536.0;
    let walls = shapes::room([0.0; 3], [1.0; 3], [0; 6]);
    let mut scene = Scene::from_triangles("furnace", &walls, vec![Material::new("all", [0.5; 3], [1.0; 3])]).unwrap();
    unwrap(&mut scene, 0..12, |p| [p[0] + p[2], p[1] + 0.37 * p[2]]);
    scene.textures = vec![fine];
    scene.materials[0] = Material { emission: [1.0; 3], ..painted(1.0) };
    scene.check().unwrap();
    (scene, mean)
}

#[test]
fn a_furnace_of_fine_texels_is_one_of_their_mean() {
    let (scene, mean) = furnace();
    let want = PI / (1.0 - mean);
    let backends = [Some(Backend::Cpu), gpu().map(Backend::Gpu)];
    for backend in backends.into_iter().flatten() {
        let solution = solve(&backend, &scene, &Params { rays: 16_384, ..Params::default() });
        let found = solution.query(&backend, &floor(5)).unwrap();
        let h = found.iter().map(|a| a.h[0]).sum::<f64>() / 25.0;
        // 16,384 rays of a texture that varies by 0.26 about its mean: 0.26/sqrt(32768) of rho, and the read-out's noise.
        assert!((h / want - 1.0).abs() < 0.01, "{h} {want}");
        // And each point reflects by its own texel.
        for (a, p) in found.iter().zip(floor(5)) {
            let local = (a.b[0] - PI) / a.h[0];
            let geometry = solution.geometry();
            let at = geometry.locate(p.p, p.n).unwrap();
            let (b1, b2) = raycell::twin::texture::shares(false, &geometry.tris[at.tri as usize], at.p.into());
            // Bilinear between texels; the passes' own image is the texture itself here.
            let own = f64::from(raycell::twin::texture::rho(geometry, at.tri, b1, b2).x);
            assert!((local - own).abs() < 1e-3, "{local} {own}");
        }
        let imbalance = solution.report().energy.imbalance.unwrap();
        assert!(imbalance.abs() < 0.02, "{imbalance}");
    }
}

/// A lamp in a black hall, its left half bright: `map_Ke`.
fn lit_hall(map: bool) -> Scene {
    let lamp = shapes::quad([[-0.5, 5.0, -0.5], [0.5, 5.0, -0.5], [0.5, 5.0, 0.5], [-0.5, 5.0, 0.5]], 1);
    let floor = shapes::quad([[-8.0, 0.0, -8.0], [-8.0, 0.0, 8.0], [8.0, 0.0, 8.0], [8.0, 0.0, -8.0]], 0);
    let materials = vec![Material::new("floor", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.0; 3], [5.0; 3])];
    let mut scene = Scene::from_triangles("hall", &[floor, lamp].concat(), materials).unwrap();
    if map {
        unwrap(&mut scene, 2..4, |p| [p[0] + 0.5, p[2] + 0.5]);
        scene.textures = vec![texture(32, 4, |x, _| if x < 16 { [2.0; 4] } else { [0.0; 4] })];
        scene.materials[1].emission_map = Some(Map::new(0));
    }
    scene.check().unwrap();
    scene
}

#[test]
fn a_patterned_lamp_shines_like_its_mean_from_afar() {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    let at = |x: f64| SurfacePoint { p: [x, 0.0, 0.0], n: [0.0, 1.0, 0.0] };
    let points = [at(0.0), at(-4.0), at(4.0), at(-0.25)];
    let [with, without] = [true, false].map(|map| {
        let solution = solve(&backend, &lit_hall(map), &Params { rays: 4_096, direct_samples: 8_192, ..Params::default() });
        (solution.query(&backend, &points).unwrap(), solution.report().energy.emitted.unwrap()[0])
    });
    // The same watts.
    assert!((with.1 / without.1 - 1.0).abs() < 0.02, "{} {}", with.1, without.1);
    // By symmetry below the middle; to the sides the bright half is nearer or farther by a quarter of a metre.
    assert!((with.0[0].d[0] / without.0[0].d[0] - 1.0).abs() < 0.01, "{:?} {:?}", with.0[0], without.0[0]);
    let closed = |x: f64, low: f64, high: f64, power: f64| {
        // Midpoints of the lamp's halves as strips; E = power pi cos cos / (pi r^2).
        let n = 64;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let (u, v) = (low + (high - low) * (i as f64 + 0.5) / n as f64, -0.5 + (j as f64 + 0.5) / n as f64);
                let r2 = (u - x) * (u - x) + v * v + 25.0;
                sum += 25.0 / (r2 * r2) * (high - low) / (n * n) as f64;
            }
        }
        power * sum
    };
    for (a, x) in with.0.iter().zip([0.0, -4.0, 4.0, -0.25]) {
        // The texels between the halves blend over a thirty-second of a metre, evenly about the middle and the edge.
        let want = closed(x, -0.5, 0.0, 10.0);
        assert!((a.d[0] / want - 1.0).abs() < 0.02, "{x}: {} {want}", a.d[0]);
    }
    // Switched off, the sides are off by more than that.
    assert!((without.0[2].d[0] / with.0[2].d[0] - 1.0).abs() > 0.05);
}

#[test]
fn kernels_read_textures_as_twins_do() {
    let Some(gpu) = gpu() else { return };
    let mut scene =
        room(painted(1.0), vec![checkers(5, 0.1, 0.7), texture(7, 3, |x, y| [x as f32 + 0.5, y as f32 + 0.25, 1.0, 1.0])]);
    unwrap(&mut scene, 6..8, |p| [3.0 * p[0], 1.5 * p[2] - 0.25]);
    scene.materials[1].emission_map = Some(Map { clamp: [false, true], ..Map::new(1) });
    let geometry = Geometry::new(&scene).unwrap();
    let tiles = tiles::starts(&geometry, &vec![0.0; geometry.tiles as usize], 0.0);
    let (a, da, ga) = passes(&mut TwinEngine::new(&geometry), &tiles);
    let (b, db, gb) = passes(&mut GpuEngine::new(&gpu, &geometry).unwrap(), &tiles);
    let same = a.iter().zip(&b).filter(|(a, b)| a.tri == b.tri && a.kind == b.kind).count();
    assert!(same * 1000 >= a.len() * 998, "{same} of {}", a.len());
    let mean = |all: &[raycell::layout::DirectSum]| all.iter().map(|d| f64::from(d.sum[0])).sum::<f64>() / all.len() as f64;
    let close = |x: f32, y: f32, scale: f32| (x - y).abs() <= 2e-3 * (scale + x.abs());
    let scale = mean(&da) as f32;
    let alike = (0..a.len()).filter(|&i| (0..3).all(|k| close(da[i].sum[k], db[i].sum[k], scale))).count();
    // Rays along edges go one way or the other.
    assert!(alike * 1000 >= a.len() * 995, "{alike} of {}", a.len());
    assert!((mean(&da) / mean(&db) - 1.0).abs() < 1e-3, "{} {}", mean(&da), mean(&db));
    let alike = (0..ga.len()).filter(|&i| (0..3).all(|k| close(ga[i][k], gb[i][k], 1.0))).count();
    assert!(alike * 100 >= ga.len() * 98, "{alike} of {}", ga.len());
    // The light is not that of a plain lamp.
    let plain =
        Scene { materials: scene.materials.iter().map(|m| Material { emission_map: None, ..m.clone() }).collect(), ..scene };
    let plain = Geometry::new(&plain).unwrap();
    let (_, other, _) = passes(&mut TwinEngine::new(&plain), &tiles);
    assert!((mean(&other) / mean(&da) - 1.0).abs() > 0.02);
}

#[test]
fn textures_are_told_with_their_share() {
    let of = |scene: &Scene, name: &str| analyse(scene).unwrap().into_iter().find(|e| e.name == name).unwrap();
    let mut scene = room(painted(1.0), vec![checkers(4, 0.1, 0.9)]);
    let on = of(&scene, "textures");
    // One of six equal sides.
    assert!(on.on && on.why.contains("reflectance varies over 17 % of the area ('made')"), "{on:?}");
    assert!(!of(&scene, "colour").on && !of(&scene, "transparency").on);
    // A red texel is a colour; a map that no face has coordinates for is none.
    scene.textures[0] = texture(2, 1, |x, _| [0.5, 0.25 * x as f32, 0.0, 1.0]);
    assert!(of(&scene, "colour").why.contains("100 % ('painted')"), "{:?}", of(&scene, "colour"));
    scene.face_uvs.clear();
    assert!(!of(&scene, "textures").on);
    let mean = Geometry::new(&scene).unwrap().materials[2].rho;
    assert_eq!(mean, [0.5, 0.125, 0.0]);
}

#[test]
fn a_saved_solution_holds_its_textures() {
    let scene = room(painted(0.8), vec![checkers(4, 0.1, 0.9)]);
    let solution =
        solve(&Backend::Cpu, &scene, &Params { rays: 2_048, direct_samples: 64, gather_rays: 16, ..Params::default() });
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.rcell");
    solution.save(&path).unwrap();
    let again = Solution::load(&path).unwrap();
    assert_eq!((&again.scene().textures, &again.scene().uvs), (&scene.textures, &scene.uvs));
    assert_eq!((&again.scene().face_uvs, &again.scene().materials), (&scene.face_uvs, &scene.materials));
    assert_eq!(answers(&again, &Backend::Cpu, &floor(3)), answers(&solution, &Backend::Cpu, &floor(3)));
    assert!(!again.system().materials.is_empty());
}

fn png(w: u32, h: u32, of: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut out = Vec::new();
    let image = image::RgbaImage::from_fn(w, h, |x, y| image::Rgba(of(x, y)));
    image.write_to(&mut std::io::Cursor::new(&mut out), image::ImageFormat::Png).unwrap();
    out
}

fn load(files: &[(&str, &[u8])], name: &str) -> raycell::Result<Scene> {
    let mut read = |path: &Path| match files.iter().find(|f| Path::new(f.0) == path) {
        Some(f) => Ok(f.1.to_vec()),
        None => Err(std::io::Error::from(std::io::ErrorKind::NotFound)),
    };
    Scene::load_from(Path::new(name), &LoadOptions::default(), &mut read, &mut |_| Flow::Continue)
}

const OBJ: &[u8] =
    b"mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3 4/4\n";

#[test]
fn an_obj_brings_its_images() {
    // Black at the upper left, else grey, red below.
    let image =
        png(2, 2, |x, y| [[0, 0, 0, 255], [188, 188, 188, 255], [255, 0, 0, 255], [188, 188, 188, 0]][(2 * y + x) as usize]);
    let mtl = b"newmtl a\nKd 0.5 1 1\nmap_Kd -blendu on -o 0 0 tex\\my wall.png # wood\nKe 0 0 0\nmap_Ke glow.hdr\nmap_d -imfchan m my wall.png\n";
    let scene = load(&[("s.obj", OBJ), ("s.mtl", mtl), ("my wall.png", &image)], "s.obj").unwrap();
    let said = scene.warnings.join("\n");
    assert!(said.contains("s.mtl:5: texture 'glow.hdr' was not found") && said.contains("its Ke is taken alone"), "{said}");
    assert_eq!(scene.warnings.len(), 1, "{said}");
    assert_eq!((scene.textures.len(), scene.faces.len(), scene.face_uvs.len()), (2, 2, 2));
    let m = &scene.materials[0];
    assert!(m.reflectance_map.is_some() && m.alpha_map.is_some() && m.emission_map.is_none());
    assert_eq!(m.emission, [0.0; 3]);
    // v points up in an OBJ: the lower left corner is the third texel, red.
    let geometry = Geometry::new(&scene).unwrap();
    let rho = |x: f64, y: f64| {
        let at = geometry.locate([x, y, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let (b1, b2) = raycell::twin::texture::shares(false, &geometry.tris[at.tri as usize], at.p.into());
        let there = raycell::twin::texture::is_there(&geometry, at.tri, b1, b2);
        (raycell::twin::texture::rho(&geometry, at.tri, b1, b2).to_array(), there)
    };
    assert_eq!(rho(0.25, 0.75), ([0.0; 3], true));
    let (red, there) = rho(0.25, 0.25);
    // 255 in red times Kd .5; nothing else.
    assert!((red[0] - 0.5).abs() < 1e-5 && red[1].abs() < 1e-5 && there, "{red:?}");
    let grey = ((188.0 / 255.0 + 0.055) / 1.055f64).powf(2.4) as f32;
    let (value, there) = rho(0.75, 0.25);
    assert!((value[1] - grey).abs() < 1e-5 && !there, "{value:?}");
    // White is lowered with a warning, as a Kd of 1 is.
    let white = png(1, 1, |_, _| [255; 4]);
    let scene = load(&[("s.obj", OBJ), ("s.mtl", b"newmtl a\nKd 1 1 1\nmap_Kd w.png\n"), ("w.png", &white)], "s.obj").unwrap();
    assert_eq!(scene.materials[0].reflectance, [0.98; 3]);
    assert!(scene.warnings[0].contains("reflects everything"), "{:?}", scene.warnings);
}

#[test]
fn broken_images_and_coordinates_are_named() {
    let image = png(64, 64, |x, y| [x as u8, y as u8, 7, 255]);
    let mtl = b"newmtl a\nKd .5 .5 .5\nmap_Kd t.png\n";
    let with = |obj: &[u8], mtl: &[u8], image: &[u8]| load(&[("s.obj", obj), ("s.mtl", mtl), ("t.png", image)], "s.obj");
    // The image is taken away, with its name said.
    for (bytes, part) in [
        (&image[..image.len() / 2], "texture 't.png' cannot be read"),
        (b"".as_slice(), "texture 't.png' cannot be read"),
        (b"GIF89a".as_slice(), "texture 't.png' cannot be read"),
    ] {
        let scene = with(OBJ, mtl, bytes).unwrap();
        assert!(scene.warnings[0].starts_with("s.mtl:3: ") && scene.warnings[0].contains(part), "{:?}", scene.warnings);
        assert!(scene.materials[0].reflectance_map.is_none() && scene.textures.is_empty());
    }
    // A header that claims more than any file of its size can hold.
    let mut bomb = image.clone();
    bomb[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    let said = with(OBJ, mtl, &bomb).unwrap().warnings.join("\n");
    assert!(said.contains("t.png"), "{said}");
    // Options that are not read are named; no name at all is refused.
    let said = with(OBJ, b"newmtl a\nKd .5 .5 .5\nmap_Kd -mm 0.1 2 t.png\n", &image).unwrap().warnings.join("\n");
    assert!(said.contains("map_Kd -mm (once, line 3)"), "{said}");
    let said = with(OBJ, b"newmtl a\nKd .5 .5 .5\nmap_Kd\n", &image).unwrap_err().to_string();
    assert!(said.contains("s.mtl:3: 'map_Kd' does not hold the name of an image"), "{said}");
    // Coordinates that are not there, or are none.
    let bare = String::from_utf8(OBJ.to_vec()).unwrap().replace("1/1 2/2 3/3 4/4", "1 2 3 4");
    let said = with(bare.as_bytes(), mtl, &image).unwrap().warnings.join("\n");
    assert!(said.contains("faces of 'a' without texture coordinates (vt) (once, line 11)"), "{said}");
    let beyond = String::from_utf8(OBJ.to_vec()).unwrap().replace("4/4", "4/9");
    let said = with(beyond.as_bytes(), mtl, &image).unwrap_err().to_string();
    assert!(said.contains("s.obj:11, texture coordinate: index 9 is out of range (there are 4)"), "{said}");
    with(beyond.as_bytes(), b"newmtl a\nKd .5 .5 .5\n", &image).expect("no map looks at them");
    let wild = String::from_utf8(OBJ.to_vec()).unwrap().replace("vt 1 1", "vt 1e9 1");
    let said = with(wild.as_bytes(), mtl, &image).unwrap_err().to_string();
    assert!(said.contains("s.obj:11, texture coordinate 2 is [1000000000.0, 0.0], beyond 65536 repeats"), "{said}");
    // More than white.
    let hot = texture(1, 1, |_, _| [1.5; 4]);
    let mut scene = room(painted(0.5), vec![hot]);
    scene.materials[2].reflectance = [0.7; 3];
    let said = scene.check().unwrap_err().to_string();
    assert!(said.contains("'painted'") && said.contains("reflectance 1.0499"), "{said}");
}

/// CRC-32 as PNG has it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes
        .iter()
        .fold(!0u32, |crc, &b| (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 }))
}

#[test]
fn toml_and_gltf_bring_images_too() {
    let image = png(2, 1, |x, _| [[0, 0, 0, 255], [188, 188, 188, 0]][x as usize]);
    let toml = br#"
[[mesh]]
name = "sheet"
material = "paper"
vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
faces = [[0, 1, 2, 3]]
uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]
[[material]]
name = "paper"
reflectance_map = "t.png"
emission_map = "t.png"
alpha_map = "t.png"
alpha_cutoff = 0.25
"#;
    let scene = load(&[("s.toml", toml), ("t.png", &image)], "s.toml").unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    // One image, read as colours and as coverage.
    assert_eq!((scene.textures.len(), scene.materials[0].alpha_cutoff, scene.materials[0].reflectance), (2, 0.25, [1.0; 3]));
    let uri = |bytes: &[u8]| {
        use base64::Engine;
        format!("data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
    };
    let floats: Vec<u8> =
        [0.0f32, 0., 0., 1., 0., 0., 0., 1., 0., 0., 1., 1., 1., 0., 0.].iter().flat_map(|f| f.to_le_bytes()).collect();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "materials":[{{"name":"leaf","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0,
        "extensions":{{"KHR_texture_transform":{{"offset":[0.25,0]}}}}}},"baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0}},
        "emissiveTexture":{{"index":0}},"emissiveFactor":[1,1,1],"alphaMode":"MASK","alphaCutoff":0.4}}],
        "extensionsUsed":["KHR_texture_transform"],
        "textures":[{{"source":0}}],"images":[{{"uri":"{}"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},{{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}}],
        "buffers":[{{"byteLength":60,"uri":"{}"}}]}}"#,
        uri(&image),
        uri(&floats),
    );
    let scene = load(&[("s.gltf", json.as_bytes())], "s.gltf").unwrap();
    assert_eq!(scene.warnings, [""; 0]);
    let m = &scene.materials[0];
    // One image serves all three.
    assert_eq!((scene.textures.len(), scene.uv(0).unwrap()), (1, [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]));
    assert_eq!((m.alpha_cutoff * 10.0).round(), 4.0);
    assert_eq!(m.reflectance_map.unwrap().transform, [[1.0, 0.0, 0.25], [-0.0, 1.0, 0.0]]);
    assert!(m.alpha_map == m.reflectance_map && m.emission_map.is_some());
    // Its image missing.
    let broken = json.replace("data:application/octet-stream;base64,iVBOR", "data:application/octet-stream;base64,AAAAA");
    let scene = load(&[("s.gltf", broken.as_bytes())], "s.gltf").unwrap();
    assert!(scene.warnings[0].contains("texture 'images[0]' cannot be read"), "{:?}", scene.warnings);
}
