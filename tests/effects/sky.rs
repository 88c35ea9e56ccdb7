//! Light from where no surface is.

use crate::common::{gpu, root, rrmse};
use raycell::engine::Engine;
use raycell::layout::{DirectSum, Point};
use raycell::pass::GpuEngine;
use raycell::scene::{Called, Environment, Geometry, Light, LightKind, Material, SkyMap, shapes};
use raycell::twin::TwinEngine;
use raycell::twin::direct::Samples;
use raycell::twin::trace::{barycentric, surface_point};
use raycell::{Backend, Camera, Direct, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::f64::consts::PI;

/// Samples of a round.
pub const ROUND: Samples = Samples { emitter: 24, cosine: 8 };
pub const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// A floor of 2 x 2 m about the origin that faces up.
pub fn floor(rho: f64) -> Scene {
    let quad = shapes::quad([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]], 0);
    Scene::from_triangles("floor", &quad, vec![Material::new("grey", [rho; 3], [0.0; 3])]).unwrap()
}

/// The scene under a sky of one radiance.
fn under(mut scene: Scene, radiance: [f64; 3]) -> Scene {
    scene.environment = Some(Environment::constant(radiance));
    scene
}

/// The passes' points on a scene.
pub fn places(geometry: &Geometry, points: &[SurfacePoint]) -> Vec<Point> {
    let place = |p: &SurfacePoint| {
        let at = geometry.locate(p.p, p.n).expect("on the scene");
        let (b1, b2) = barycentric(geometry.flatland, &geometry.tris[at.tri as usize], at.p.into());
        surface_point(geometry, at.tri, b1.clamp(0.0, 1.0), b2.clamp(0.0, 1.0))
    };
    points.iter().map(place).collect()
}

fn sums<E: Engine>(engine: &mut E, points: &[Point], rounds: u32, samples: Samples) -> Vec<DirectSum> {
    let mut batch = engine.upload(points).unwrap();
    engine.direct(&mut batch, None, 3, 0, rounds, samples).unwrap();
    engine.finish().unwrap();
    engine.direct_sums(&batch).unwrap()
}

/// Direct irradiance by the twins, W/m².
pub fn direct(scene: &Scene, points: &[SurfacePoint], rounds: u32) -> Vec<[f64; 3]> {
    let geometry = Geometry::new(scene).unwrap();
    let found = sums(&mut TwinEngine::new(&geometry), &places(&geometry, points), rounds, ROUND);
    found.iter().map(|s| s.mean().map(|d| f64::from(d) / geometry.emission_scale)).collect()
}

/// Kernel and twin find the same direct light on points of all tiles.
pub fn same_on_the_device(scene: &Scene, what: &str) {
    let Some(gpu) = gpu() else { return };
    let geometry = Geometry::new(scene).unwrap();
    let starts = raycell::network::tiles::starts(&geometry, &vec![0.0; geometry.tiles as usize], 0.0);
    let points = raycell::network::tiles::drawn(&geometry, &starts, 7, 2_000);
    let want = sums(&mut TwinEngine::new(&geometry), &points, 3, Samples { emitter: 6, cosine: 2 });
    let got = sums(&mut GpuEngine::new(&gpu, &geometry).unwrap(), &points, 3, Samples { emitter: 6, cosine: 2 });
    let close = |a: f32, b: f32, most: f32| (a - b).abs() <= 1e-6 + 2e-4 * most;
    let same = |a: &DirectSum, b: &DirectSum| {
        let most = a.sum.iter().fold(0.0f32, |m, x| m.max(*x));
        a.rounds == b.rounds && (0..3).all(|k| close(a.sum[k], b.sum[k], most)) && close(a.square, b.square, most * most)
    };
    let off = want.iter().zip(&got).filter(|(a, b)| !same(a, b)).count();
    let lit = want.iter().filter(|s| s.sum != [0.0; 3]).count();
    // A point shoots up to 100 rays, each with its own chance of grazing an edge, and directions of a map theirs of the next texel.
    assert!(off * 50 <= want.len() && lit > want.len() / 4, "{what}: {off} differ, {lit} of {} lit", want.len());
}

pub fn few() -> Params {
    Params { rays: 16_384, ..Params::default() }
}

pub fn solve(backend: &Backend, scene: &Scene, params: &Params) -> Solution {
    bake(backend, scene, params, &mut |_| Flow::Continue).unwrap()
}

pub fn backend() -> Option<Backend> {
    gpu().map(Backend::Gpu)
}

pub fn near(got: [f64; 3], want: [f64; 3], relative: f64) -> bool {
    (0..3).all(|k| (got[k] - want[k]).abs() <= relative * want[k].abs())
}

/// The shipped court with its lights; `tests/data/courtyard.truth.csv` is of it.
pub fn courtyard() -> Scene {
    Scene::load(root("scenes/courtyard/scene.toml")).unwrap()
}

#[test]
fn an_open_floor_gets_pi_l() {
    let l = [0.5, 1.0, 2.0];
    let points = [[0.3, 0.0, -0.2], [-0.9, 0.0, 0.9]].map(|p| SurfacePoint { p, n: UP });
    for d in direct(&under(floor(0.5), l), &points, 1) {
        assert!(near(d, l.map(|l| PI * l), 1e-6), "{d:?}");
    }
    // And sends rho pi L, whatever bakes it.
    for backend in [Some(Backend::Cpu), backend()].into_iter().flatten() {
        let solution = solve(&backend, &under(floor(0.5), l), &Params { rays: 2_048, ..few() });
        for a in solution.query(&backend, &points).unwrap() {
            assert!(near(a.b, l.map(|l| 0.5 * PI * l), 1e-5) && near(a.h, a.d, 1e-6), "{a:?}");
        }
        let energy = &solution.report().energy;
        assert!(near(energy.emitted.unwrap(), l.map(|l| 4.0 * PI * l), 1e-5), "{energy:?}");
        assert!(near(energy.absorbed.unwrap(), l.map(|l| 2.0 * PI * l), 1e-5), "{energy:?}");
        assert!(energy.imbalance.unwrap().abs() < 1e-3, "{energy:?}");
    }
}

#[test]
fn a_constant_map_is_a_constant_sky() {
    let l = [0.5, 1.0, 2.0];
    let map = |width, height| {
        let map = SkyMap { width, height, rgb: vec![[0.25, 0.5, 1.0]; (width * height) as usize] };
        Environment { radiance: [2.0; 3], rotation: 30.0, ..Environment::mapped(map) }
    };
    let points = [[0.3, 0.0, -0.2], [-0.9, 0.0, 0.9]].map(|p| SurfacePoint { p, n: UP });
    for (width, height) in [(1, 1), (64, 32), (333, 200)] {
        let scene = Scene { environment: Some(map(width, height)), ..floor(0.5) };
        // 512 rounds of 32 samples, stratified.
        for d in direct(&scene, &points, 512) {
            assert!(near(d, l.map(|l| PI * l), 2e-3), "{width} by {height}: {d:?}");
        }
    }
}

/// A map with a disc about `to` of some degrees, and the irradiance on a surface that faces it.
fn spotted(width: u32, height: u32, to: [f64; 3], diameter: f64, radiance: f32) -> (SkyMap, f64) {
    let (mut map, mut e) = (SkyMap { width, height, rgb: vec![[0.0; 3]; (width * height) as usize] }, 0.0);
    let edge = |row: u32| (PI * f64::from(row) / f64::from(height)).cos();
    for row in 0..height {
        for column in 0..width {
            let (turn, theta) =
                ((f64::from(column) + 0.5) / f64::from(width) * 2.0 * PI, (f64::from(row) + 0.5) / f64::from(height) * PI);
            let d = [-turn.sin() * theta.sin(), theta.cos(), turn.cos() * theta.sin()];
            let cos: f64 = (0..3).map(|k| d[k] * to[k]).sum();
            if cos > (0.5 * diameter).to_radians().cos() {
                map.rgb[(row * width + column) as usize] = [radiance; 3];
                e += f64::from(radiance) * cos * (edge(row) - edge(row + 1)) * 2.0 * PI / f64::from(width);
            }
        }
    }
    (map, e)
}

#[test]
fn a_bright_disc_of_a_map_is_a_sun() {
    let to = [0.48, 0.6, -0.64];
    let (map, e) = spotted(1024, 512, to, 10.0, 100.0);
    // A floor and a post on it, whose shadow has a penumbra.
    let post = shapes::block([-0.1, 0.0, -0.1], [0.1, 0.5, 0.1], 0);
    let quad = shapes::quad([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]], 0);
    let triangles = [quad, post].concat();
    let scene = Scene::from_triangles("post", &triangles, vec![Material::new("grey", [0.5; 3], [0.0; 3])]).unwrap();
    let mapped = Scene { environment: Some(Environment::mapped(map)), ..scene.clone() };
    let kind = LightKind::Sun { direction: to.map(|x| -x), angle: 10.0 };
    let sunny = Scene { lights: vec![Light { name: "sun".into(), intensity: [e; 3], kind }], ..scene };
    let points: Vec<SurfacePoint> = (0..576)
        .map(|i| SurfacePoint { p: [-0.95 + 0.082 * f64::from(i % 24), 0.0, -0.95 + 0.082 * f64::from(i / 24)], n: UP })
        .filter(|p| p.p[0].abs() > 0.1 || p.p[2].abs() > 0.1)
        .collect();
    let (a, b) = (direct(&mapped, &points, 64), direct(&sunny, &points, 64));
    let full = e * 0.6;
    let part = |d: &[[f64; 3]]| d.iter().filter(|d| d[0] > 0.02 * full && d[0] < 0.98 * full).count();
    assert!(part(&b) > 5 && b.iter().filter(|d| d[0] == 0.0).count() > 5, "penumbra and umbra: {}", part(&b));
    let off = rrmse(&a, &b);
    // The disc's edge is that of texels of a third of a degree.
    assert!(off < 0.02, "{off}");
    let open = SurfacePoint { p: [0.9, 0.0, -0.9], n: UP };
    assert!(near(direct(&mapped, &[open], 64)[0], [full; 3], 0.01) && near(direct(&sunny, &[open], 1)[0], [full; 3], 1e-2));
}

#[test]
fn a_map_lies_as_it_is_told() {
    // A cube seen from outside; one texel of 16 by 8 shines.
    let scene =
        Scene::from_triangles("cube", &shapes::block([-1.0; 3], [1.0; 3], 0), vec![Material::new("grey", [0.5; 3], [0.0; 3])])
            .unwrap();
    let sides: Vec<SurfacePoint> = (0..6)
        .map(|s| {
            let mut n = [0.0; 3];
            n[s / 2] = if s % 2 == 1 { 1.0 } else { -1.0 };
            SurfacePoint { p: n.map(|x| x + 0.0), n }
        })
        .collect();
    let brightest = |column: usize, row: usize, rotation: f64| {
        let mut rgb = vec![[0.0f32; 3]; 16 * 8];
        rgb[row * 16 + column] = [1.0; 3];
        let environment = Environment { rotation, ..Environment::mapped(SkyMap { width: 16, height: 8, rgb }) };
        let lit = direct(&Scene { environment: Some(environment), ..scene.clone() }, &sides, 16);
        assert!(lit.iter().filter(|d| d[0] > 0.0).count() <= 3, "{lit:?}");
        (0..6).max_by(|&a, &b| lit[a][0].total_cmp(&lit[b][0])).unwrap()
    };
    // -x, +x, -y, +y, -z, +z
    assert_eq!([brightest(5, 0, 0.0), brightest(5, 7, 0.0)], [3, 2], "top and bottom");
    assert_eq!(brightest(8, 4, 0.0), 4, "the middle is along -z");
    assert_eq!(brightest(12, 4, 0.0), 1, "three quarters are along +x");
    assert_eq!(brightest(0, 4, 0.0), 5);
    assert_eq!(brightest(4, 4, 0.0), 0);
    // Counter-clockwise from above: -z goes to -x.
    assert_eq!(brightest(8, 4, 90.0), 0);
    assert_eq!(brightest(8, 4, -270.0), 0);
    // The picture sees what the surfaces see.
    let mut rgb = vec![[0.25f32; 3]; 16 * 8];
    rgb[4 * 16 + 8] = [3.0, 2.0, 1.0];
    let environment = Environment { rotation: 90.0, ..Environment::mapped(SkyMap { width: 16, height: 8, rgb }) };
    let scene = Scene { environment: Some(environment), ..scene };
    let solution = solve(&Backend::Cpu, &scene, &Params { rays: 1_024, ..few() });
    let look = |target: [f64; 3]| {
        let camera = Camera { eye: [0.0, 5.0, 0.0], target, up: [0.1, 1.0, 0.2], vfov_degrees: 1.0, width: 1, height: 1 };
        solution.render(&Backend::Cpu, &camera).unwrap().rgb[0]
    };
    for (got, want) in look([-1.0, 4.8, -0.1]).iter().zip([3.0, 2.0, 1.0]) {
        assert!((got - want).abs() < 1e-4, "{got} {want}");
    }
    assert!((look([1.0, 5.2, 0.0])[0] - 0.25).abs() < 1e-5);
    assert!(look([0.0; 3])[0] != 0.25, "the cube is before the sky");
}

#[test]
fn a_closed_room_sees_nothing_of_it() {
    let room = shapes::room([0.0; 3], [1.0, 2.0, 3.0], [0; 6]);
    let mut scene = Scene::from_triangles("room", &room, vec![Material::new("wall", [0.5; 3], [0.0; 3])]).unwrap();
    scene.environment = Some(Environment::constant([1.0; 3]));
    scene.lights = vec![Light::sun("sun", [1.0; 3], [0.3, -1.0, 0.2]), Light::point("star", [1.0; 3], [0.5, 5.0, 1.5])];
    assert!(!Geometry::new(&scene).unwrap().occludes, "convex");
    let points: Vec<SurfacePoint> =
        (0..50).map(|i| SurfacePoint { p: [0.02 * f64::from(i) + 0.005, 0.0, 0.05 * f64::from(i) + 0.1], n: UP }).collect();
    assert!(direct(&scene, &points, 4).iter().all(|d| *d == [0.0; 3]));
    // Without its ceiling it does; its walls' backs are black from outside.
    let mut open = scene.clone();
    open.faces.retain(|f| f.vertices.iter().any(|&v| scene.vertices[v as usize][1] < 2.0));
    assert_eq!(open.faces.len(), 10);
    let lit = direct(&open, &points, 4);
    assert!(lit.iter().filter(|d| d[0] > 0.1).count() > 40, "{lit:?}");
    if let Some(gpu) = gpu() {
        let geometry = Geometry::new(&scene).unwrap();
        let found = sums(&mut GpuEngine::new(&gpu, &geometry).unwrap(), &places(&geometry, &points), 2, ROUND);
        assert!(found.iter().all(|s| s.sum == [0.0; 3] && s.rounds == 2));
    }
}

#[test]
fn shader_and_twin_see_one_sky() {
    let scene = courtyard();
    let constant = Scene { lights: Vec::new(), ..scene.clone() };
    same_on_the_device(&constant, "constant");
    let (map, _) = spotted(128, 64, [0.48, 0.6, -0.64], 20.0, 30.0);
    let rgb = map.rgb.iter().enumerate().map(|(i, t)| [t[0] + 0.5, t[1] + (i % 7) as f32 * 0.1, t[2] + 1.0]).collect();
    let environment = Environment { rotation: 77.0, ..Environment::mapped(SkyMap { rgb, ..map }) };
    same_on_the_device(&Scene { environment: Some(environment), ..constant }, "map");
}

#[test]
fn flatland_has_a_sky_of_its_own() {
    // A floor of 4 m, and a wall of 1 m at its end.
    let (floor, wall) = (([[-2.0, 0.0], [2.0, 0.0]], 0), ([[2.0, 0.0], [2.0, 1.0]], 0));
    let mut scene = Scene::from_segments("flat", &[floor, wall], vec![Material::new("grey", [0.0; 3], [0.0; 3])]).unwrap();
    // A sky of radiance L W/m/rad brings 2 L; it is given by what it brings.
    let brings = [3.0, 2.0, 1.0];
    scene.environment = Some(Environment::constant(brings.map(|b| b / PI)));
    for x in [-1.5, 0.0, 1.0, 1.7] {
        // Of what arrives at a line from elevations up to e, the share is (1 - cos e)/2.
        let free = 1.0 - 0.5 * (1.0 - (1.0f64 / (2.0 - x)).atan().cos());
        let got = direct(&scene, &[SurfacePoint { p: [x, 0.0, 0.0], n: [0.0, 1.0, 0.0] }], 256)[0];
        assert!(near(got, brings.map(|b| b * free), 2e-3), "{x}: {got:?}, {free}");
    }
    same_on_the_device(&scene, "flatland");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("flat.toml");
    let text = |more: &str| {
        format!(
            "[[segment]]\nname = 'a'\nmaterial = 'm'\npoints = [[0, 0], [1, 0]]\n[[material]]\nname = 'm'\nreflectance = 0.5\n{more}"
        )
    };
    std::fs::write(&path, text("[environment]\nradiosity = 2\n")).unwrap();
    let read = Scene::load(&path).unwrap();
    let got = direct(&read, &[SurfacePoint { p: [0.5, 0.0, 0.0], n: [0.0, 1.0, 0.0] }], 1)[0];
    assert!(near(got, [2.0; 3], 1e-6), "{got:?}");
    for (more, part) in [
        ("[environment]\nradiance = 2\n", "radiosity"),
        ("[[light]]\nname = 'l'\nkind = 'point'\nposition = [0, 0, 0]\nintensity = 1\n", "flatland"),
    ] {
        std::fs::write(&path, text(more)).unwrap();
        let said = Scene::load(&path).unwrap_err().to_string();
        assert!(said.contains(part) && said.contains("flat.toml:8"), "{said}");
    }
}

#[test]
fn the_network_is_asked_for_no_light_without_a_surface() {
    let params = Params { direct: Direct::Network, ..few() };
    let refused = bake(&Backend::Cpu, &under(floor(0.5), [1.0; 3]), &params, &mut |_| Flow::Continue);
    let said = refused.map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("direct = network") && said.contains("--direct exact"), "{said}");
}

/// The light of the court as the project's own path tracer finds it (`raycell sweep` traces references).
#[test]
fn the_court_is_as_traced_and_not_without_its_lights() {
    let Some(backend) = backend() else { return };
    let truth = crate::common::truth("courtyard");
    let error = |scene: &Scene| {
        let solution = solve(&backend, scene, &Params { rays: 65_536, ..few() });
        let b: Vec<[f64; 3]> = solution.query(&backend, &truth.points).unwrap().iter().map(|a| a.b).collect();
        (rrmse(&b, &truth.b), solution)
    };
    let whole = courtyard();
    let (off, solution) = error(&whole);
    eprintln!("courtyard: {:.2} %", 100.0 * off);
    assert!(off < 0.03, "{off}");
    let report = solution.report();
    assert!(report.energy.imbalance.unwrap().abs() < 0.02, "{:?}", report.energy);
    assert!(report.extra["shadow_rays"].as_u64().unwrap() > 0);
    // Each part of it matters.
    let without = |what: &str, scene: Scene, least: f64| {
        let (off, _) = error(&scene);
        eprintln!("without {what}: {:.2} %", 100.0 * off);
        assert!(off > least, "without {what}: {off}");
    };
    without("sky", Scene { environment: None, ..whole.clone() }, 0.1);
    for (name, least) in [("sun", 0.2), ("lantern", 0.05), ("spot", 0.05)] {
        let mut scene = whole.clone();
        scene.lights.retain(|l| l.name != name);
        assert_eq!(scene.lights.len(), 2);
        without(name, scene, least);
    }
}

#[test]
fn it_is_explained_and_kept() {
    let scene = courtyard();
    let effects = raycell::effects::analyse(&scene).unwrap();
    let of = |name: &str| effects.iter().find(|e| e.name == name).unwrap();
    assert!(of("environment").on && of("environment").why.contains("one radiance") && of("environment").why.contains('%'));
    assert!(of("lights").on && of("lights").why.contains("1 sun, 1 point, 1 spot (see 'sun')"), "{}", of("lights").why);
    assert!(of("direct").on && of("interreflection").on);
    let dark = Scene { environment: None, lights: Vec::new(), ..scene.clone() };
    let effects = raycell::effects::analyse(&dark).unwrap();
    assert!(["environment", "lights", "direct"].iter().all(|n| !effects.iter().find(|e| e.name == *n).unwrap().on));
    let no_emitter =
        |scene: &Scene| raycell::doctor::examine(scene).unwrap().iter().any(|f| f.check == raycell::doctor::Check::NoEmitter);
    assert!(no_emitter(&dark) && !no_emitter(&scene));

    // Switched by hand.
    let mut off = scene.clone();
    "-environment,-lights".parse::<raycell::effects::Switches>().unwrap().apply(&mut off).unwrap();
    assert!(off.environment.is_none() && off.lights.is_empty() && off.warnings.len() == 2, "{:?}", off.warnings);
    // A coloured sky over grey walls is no grey scene.
    let mut grey = under(floor(0.5), [1.0, 1.0, 1.0]);
    let one_band = |scene: &Scene| Called::by(&Geometry::new(scene).unwrap()).grey;
    assert!(one_band(&grey));
    grey.environment = Some(Environment::constant([1.0, 1.0, 2.0]));
    assert!(!one_band(&grey));
    let map = SkyMap { width: 2, height: 1, rgb: vec![[1.0; 3]; 2] };
    grey.environment = Some(Environment::mapped(map.clone()));
    assert!(one_band(&grey));
    grey.environment = Some(Environment::mapped(SkyMap { rgb: vec![[1.0; 3], [1.0, 2.0, 1.0]], ..map }));
    assert!(!one_band(&grey));

    // A solution holds its lights and its map, and answers as before.
    let (map, _) = spotted(32, 16, UP, 60.0, 5.0);
    let mapped = Scene { environment: Some(Environment { rotation: 10.0, ..Environment::mapped(map) }), ..scene };
    let solution = solve(&Backend::Cpu, &mapped, &Params { rays: 4_096, gather_rays: 16, direct_samples: 64, ..few() });
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.rcell");
    solution.save(&path).unwrap();
    let again = Solution::load(&path).unwrap();
    let points: Vec<SurfacePoint> = (0..20).map(|i| SurfacePoint { p: [0.5 * f64::from(i) + 0.1, 0.0, 4.0], n: UP }).collect();
    let answers = solution.query(&Backend::Cpu, &points).unwrap();
    assert_eq!(again.query(&Backend::Cpu, &points).unwrap(), answers);
    assert!(answers.iter().all(|a| a.d[0] > 0.0));
    let bytes = std::fs::read(&path).unwrap();
    again.save(&path).unwrap();
    assert!(std::fs::read(&path).unwrap() == bytes);
}

#[test]
fn a_file_says_what_is_around() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.toml");
    let mesh = "[[mesh]]\nname = 'f'\nmaterial = 'm'\nvertices = [[0,0,0],[0,0,1],[1,0,1]]\nfaces = [[0,1,2]]\n[[material]]\nname = 'm'\nreflectance = 0.5\n";
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    hdr.extend([128, 64, 32, 129, 128, 128, 128, 130]);
    std::fs::write(dir.path().join("sky.hdr"), hdr).unwrap();
    let read = |more: &str| {
        std::fs::write(&path, format!("{mesh}{more}")).unwrap();
        Scene::load(&path)
    };
    let environment = read("[environment]\nmap = 'sky.hdr'\nradiance = [1, 2, 3]\nrotation = 45\n").unwrap().environment.unwrap();
    assert_eq!((environment.radiance, environment.rotation), ([1.0, 2.0, 3.0], 45.0));
    assert_eq!(environment.map.unwrap(), SkyMap { width: 2, height: 1, rgb: vec![[1.0, 0.5, 0.25], [2.0; 3]] });
    assert_eq!(read("[environment]\nradiance = 0.5\n").unwrap().environment.unwrap(), Environment::constant([0.5; 3]));
    for (more, part) in [
        ("[environment]\n", "needs a radiance"),
        ("[environment]\nradiance = -1\n", "-1"),
        ("[environment]\nradiance = 1\nrotation = 5\n", "no map"),
        ("[environment]\nmap = 'sky.png'\n", "sky.png"),
        ("[environment]\nmap = 'gone.exr'\n", "gone.exr"),
        ("[environment]\nsun = 1\n", "sun"),
    ] {
        let said = read(more).unwrap_err().to_string();
        assert!(said.contains(part), "{said}");
    }
}
