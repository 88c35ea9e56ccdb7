//! Lights without a surface: suns, points and spots.

use super::sky::{UP, backend, courtyard, direct, few, floor, near, same_on_the_device, solve};
use raycell::scene::{Light, LightKind, Material, shapes};
use raycell::{Backend, Params, Scene, SurfacePoint};
use std::f64::consts::PI;

fn lit(scene: Scene, lights: Vec<Light>) -> Scene {
    Scene { lights, ..scene }
}

#[test]
fn a_sun_brings_e_times_the_cosine() {
    let e = [3.0, 2.0, 1.0];
    let points = [[0.3, 0.0, -0.2], [-0.9, 0.0, 0.9]].map(|p| SurfacePoint { p, n: UP });
    for angle in [0.0, 0.53, 10.0] {
        for (direction, cos) in [([0.0, -2.0, 0.0], 1.0), ([0.6, -0.8, 0.0], 0.8), ([-3.0, -1.0, 1.0], 1.0 / 11f64.sqrt())] {
            let sun = Light { name: "sun".into(), intensity: e, kind: LightKind::Sun { direction, angle } };
            // At the zenith, and without a size, without noise.
            let tolerance = if cos == 1.0 || angle == 0.0 { 1e-5 } else { 1e-3 };
            for d in direct(&lit(floor(0.5), vec![sun.clone()]), &points, 256) {
                assert!(near(d, e.map(|e| e * cos), tolerance), "{angle} {cos}: {d:?}");
            }
        }
        let below = Light { name: "sun".into(), intensity: e, kind: LightKind::Sun { direction: UP, angle } };
        assert!(direct(&lit(floor(0.5), vec![below]), &points, 4).iter().all(|d| *d == [0.0; 3]));
    }
    // Baked: B = rho E cos, and the watts that arrive are those of the floor's 4 m2.
    for backend in [Some(Backend::Cpu), backend()].into_iter().flatten() {
        let scene = lit(floor(0.5), vec![Light::sun("sun", e, [0.0, -1.0, 0.0])]);
        let solution = solve(&backend, &scene, &Params { rays: 2_048, ..few() });
        assert!(solution.query(&backend, &points).unwrap().iter().all(|a| near(a.b, e.map(|e| 0.5 * e), 1e-5)));
        assert!(near(solution.report().energy.emitted.unwrap(), e.map(|e| 4.0 * e), 1e-4));
    }
}

#[test]
fn the_penumbra_of_a_sun_is_as_wide_as_it_is() {
    // A half plane at height 1 over x < 0; the sun at the zenith. At x on the floor the edge hides what of the disc lies beyond x.
    let quad = |y: f64, x: [f64; 2], z: f64| shapes::quad([[x[0], y, -z], [x[0], y, z], [x[1], y, z], [x[1], y, -z]], 0);
    let triangles = [quad(0.0, [-4.0, 4.0], 4.0), quad(1.0, [-4.0, 0.0], 4.0)].concat();
    let scene = Scene::from_triangles("edge", &triangles, vec![Material::new("grey", [0.5; 3], [0.0; 3])]).unwrap();
    let kind = LightKind::Sun { direction: [0.0, -1.0, 0.0], angle: 20.0 };
    let scene = lit(scene, vec![Light { name: "sun".into(), intensity: [1.0; 3], kind }]);
    let radius = 10f64.to_radians().sin();
    for x in [-0.2, -0.1, -0.03, 0.0, 0.05, 0.12, 0.2] {
        // Directions (sx, sz) fill a disc of that radius evenly in E; the edge lies at sx = -x/sqrt(1 + x^2) where sz = 0.
        let n = 400;
        let mut free = 0.0;
        for i in 0..n {
            let sz = radius * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
            let half = (radius * radius - sz * sz).sqrt();
            // Where the ray passes height 1: x + sx/sy > 0, sy^2 = 1 - sx^2 - sz^2.
            let edge = -x * ((1.0 - sz * sz) / (1.0 + x * x)).sqrt();
            free += (half - edge.clamp(-half, half)) * 2.0 * radius / f64::from(n);
        }
        free /= PI * radius * radius;
        let got = direct(&scene, &[SurfacePoint { p: [x, 0.0, 0.1], n: UP }], 512)[0][0];
        assert!((got - free).abs() < 0.01, "{x}: {got} {free}");
    }
}

/// A sphere of 2 m seen from inside, with a point light in its middle.
fn ball(rho: f64, intensity: f64) -> (Scene, Vec<SurfacePoint>) {
    let triangles = shapes::moved(shapes::flipped(shapes::sphere(3, 0)), |p| p.map(|x| 2.0 * x));
    let middle = |t: &[[f64; 3]; 3]| [0, 1, 2].map(|k| (t[0][k] + t[1][k] + t[2][k]) / 3.0);
    let points = triangles.iter().step_by(37).map(|(t, _)| middle(t)).map(|p| SurfacePoint { p, n: p.map(|x| -x) }).collect();
    let scene = Scene::from_triangles("ball", &triangles, vec![Material::new("grey", [rho; 3], [0.0; 3])]).unwrap();
    (lit(scene, vec![Light::point("lamp", [intensity; 3], [0.0; 3])]), points)
}

#[test]
fn a_point_in_a_sphere_brings_i_over_r_squared() {
    let (scene, points) = ball(0.5, 8.0);
    let r = |p: &SurfacePoint| p.p.iter().map(|x| x * x).sum::<f64>();
    for (d, p) in direct(&scene, &points, 1).iter().zip(&points) {
        // The middle of a triangle lies straight below the light, a little nearer than 2 m.
        assert!(near(*d, [8.0 / r(p); 3], 2e-3), "{d:?} {}", r(p));
    }
    // Reflected: E/(1 - rho) as in a furnace; the tessellated ball holds 4 pi I on its own area.
    let Some(backend) = backend() else { return };
    let solution = solve(&backend, &scene, &few());
    let area: f64 = (0..scene.faces.len()).map(|f| scene.area(f)).sum();
    let even = 4.0 * PI * 8.0 / area;
    let answers = solution.query(&backend, &points).unwrap();
    let mean = answers.iter().map(|a| a.h[0]).sum::<f64>() / answers.len() as f64;
    assert!((mean / (even / 0.5) - 1.0).abs() < 0.01, "{mean} {}", even / 0.5);
    assert!(answers.iter().all(|a| near(a.b, [0.5 * even / 0.5; 3], 0.05)), "{answers:?}");
    let energy = &solution.report().energy;
    assert!(near(energy.emitted.unwrap(), [4.0 * PI * 8.0; 3], 0.01) && energy.imbalance.unwrap().abs() < 0.01, "{energy:?}");
}

#[test]
fn lights_do_not_depend_on_where_and_how_large_the_scene_is() {
    let (scene, points) = ball(0.5, 8.0);
    let far = |p: [f64; 3]| [1000.0 + 64.0 * p[0], -500.0 + 64.0 * p[1], 64.0 * p[2]];
    let mut moved = scene.clone();
    moved.vertices.iter_mut().for_each(|v| *v = far(*v));
    moved.lights = vec![Light::point("lamp", [8.0; 3], far([0.0; 3]))];
    let there: Vec<SurfacePoint> = points.iter().map(|p| SurfacePoint { p: far(p.p), n: p.n }).collect();
    for (a, b) in direct(&scene, &points, 1).iter().zip(direct(&moved, &there, 1)) {
        assert!(near(b, a.map(|x| x / 4096.0), 1e-3), "{a:?} {b:?}");
    }
}

#[test]
fn a_spot_has_the_cone_it_is_given() {
    let (inner, outer) = (20.0, 30.0);
    let light = Light::spot("spot", [4.0, 2.0, 1.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [inner, outer]);
    let scene = lit(floor(0.5), vec![light]);
    for degrees in [0.0f64, 10.0, 19.9, 22.0, 25.0, 28.0, 29.9, 30.1, 40.0] {
        let (x, cos) = (degrees.to_radians().tan(), degrees.to_radians().cos());
        let got = direct(&scene, &[SurfacePoint { p: [x, 0.0, 0.0], n: UP }], 1)[0];
        let [ci, co] = [inner, outer].map(|a: f64| a.to_radians().cos());
        let fall = ((cos - co) / (ci - co)).clamp(0.0, 1.0).powi(2);
        // cos/r^2 at height 1.
        let want = [4.0, 2.0, 1.0].map(|i| i * fall * cos.powi(3));
        assert!((0..3).all(|k| (got[k] - want[k]).abs() <= 1e-4 * want[k] + 1e-4), "{degrees}: {got:?} {want:?}");
        assert_eq!(got == [0.0; 3], degrees > outer, "{degrees}");
    }
    // Without a soft edge: all inside, nothing outside.
    let hard = Light::spot("spot", [1.0; 3], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [30.0, 30.0]);
    let at = |d: f64| {
        direct(&lit(floor(0.5), vec![hard.clone()]), &[SurfacePoint { p: [d.to_radians().tan(), 0.0, 0.0], n: UP }], 1)[0][0]
    };
    assert!(near([at(29.8); 3], [29.8f64.to_radians().cos().powi(3); 3], 1e-3) && at(30.2) == 0.0);
}

/// Points at many places, of all brightnesses.
fn many(count: u32) -> Vec<Light> {
    (0..count)
        .map(|i| {
            let x = f64::from(i);
            let position = [0.9 * (1.3 * x).sin(), 0.2 + 0.1 * (x % 7.0), 0.9 * (2.1 * x).cos()];
            Light::point(&format!("lamp {i}"), [1.0 + x % 5.0, 2.0, 0.1 * x], position)
        })
        .collect()
}

#[test]
fn of_many_lights_some_are_asked_and_all_are_meant() {
    let points = [[0.3, 0.0, -0.2], [-0.7, 0.0, 0.6]].map(|p| SurfacePoint { p, n: UP });
    for count in [8, 9, 100] {
        let lights = many(count);
        let want = points.map(|p| {
            let mut sum = [0.0; 3];
            for light in &lights {
                let LightKind::Point { position } = light.kind else { unreachable!() };
                let r2: f64 = (0..3).map(|k| (position[k] - p.p[k]).powi(2)).sum();
                (0..3).for_each(|k| sum[k] += light.intensity[k] * position[1] / r2.powf(1.5));
            }
            sum
        });
        let (rounds, tolerance) = if count <= 8 { (1, 1e-4) } else { (4_096, 5e-3) };
        for (got, want) in direct(&lit(floor(0.5), lights), &points, rounds).into_iter().zip(want) {
            assert!(near(got, want, tolerance), "{count}: {got:?} {want:?}");
        }
    }
}

#[test]
fn shader_and_twin_see_the_same_lights() {
    let court = Scene { environment: None, ..courtyard() };
    same_on_the_device(&court, "all kinds");
    let sharp = Light { kind: LightKind::Sun { direction: [0.1, -1.0, -0.2], angle: 0.0 }, ..court.lights[0].clone() };
    same_on_the_device(&lit(court.clone(), vec![sharp]), "a sharp sun");
    let above = |l: Light| match l.kind {
        LightKind::Point { position: [x, y, z] } => {
            Light { kind: LightKind::Point { position: [5.0 + 3.0 * x, y + 1.0, 5.0 + 3.0 * z] }, ..l }
        }
        _ => l,
    };
    same_on_the_device(&lit(court.clone(), many(40).into_iter().map(above).collect()), "many points");
    // Beside the sky and a surface that shines.
    let mut all = courtyard();
    all.materials[0].emission = [0.5, 0.25, 0.125];
    same_on_the_device(&all, "everything");
}

#[test]
fn a_toml_says_where_they_stand() {
    let scene = courtyard();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let kinds: Vec<_> = scene.lights.iter().map(|l| (l.name.as_str(), l.intensity, l.kind)).collect();
    assert_eq!(kinds[0], ("sun", [9.0, 8.0, 6.5], LightKind::Sun { direction: [0.45, -0.8, -0.4], angle: 0.53 }));
    assert_eq!(kinds[1], ("lantern", [6.0, 4.0, 2.0], LightKind::Point { position: [3.7, 2.2, 1.3] }));
    let LightKind::Spot { position, direction, inner, outer } = kinds[2].2 else { panic!("{kinds:?}") };
    assert_eq!((position, inner, outer), ([8.6, 2.5, 1.6], 15.0, 35.0));
    assert!(near(direction, [0.2, -1.3, -1.6], 1e-9));
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.toml");
    let mesh = "[[mesh]]\nname = 'f'\nmaterial = 'm'\nvertices = [[0,0,0],[0,0,1],[1,0,1]]\nfaces = [[0,1,2]]\n[[material]]\nname = 'm'\nreflectance = 0.5\n[[light]]\nname = 'l'\n";
    for (light, part) in [
        ("kind = 'sun'\nirradiance = 1\n", "direction"),
        ("kind = 'sun'\nintensity = 1\ndirection = [0,-1,0]\n", "irradiance"),
        ("kind = 'sun'\nirradiance = 1\ndirection = [0,-1,0]\nposition = [0,1,0]\n", "nowhere"),
        ("kind = 'sun'\nirradiance = 1\ndirection = [0,0,0]\n", "points nowhere"),
        ("kind = 'point'\nintensity = 1\n", "position"),
        ("kind = 'point'\nirradiance = 1\nposition = [0,1,0]\n", "intensity"),
        ("kind = 'point'\nintensity = 1\nposition = [0,1,0]\ninner = 3\n", "only a spot"),
        ("kind = 'spot'\nintensity = 1\nposition = [0,1,0]\n", "direction"),
        ("kind = 'spot'\nintensity = -1\nposition = [0,1,0]\ntarget = [0,0,0]\n", "-1"),
        ("kind = 'area'\n", "area"),
        ("kind = 'point'\nintensity = 1\nposition = [0,1,0]\nlumens = 3\n", "lumens"),
    ] {
        std::fs::write(&path, format!("{mesh}{light}")).unwrap();
        let said = Scene::load(&path).unwrap_err().to_string();
        assert!(said.contains(part) && said.contains("scene.toml:"), "{said}");
    }
}

#[test]
fn gltf_has_words_for_them() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.gltf");
    // A triangle, and three lights: a turned sun, a moved point, a spot in a scaled and moved part.
    let text = r#"{
      "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"], "scene": 0, "scenes": [{"nodes": [0, 1, 2, 3]}],
      "extensions": {"KHR_lights_punctual": {"lights": [
        {"type": "directional", "color": [1, 0.5, 0.25], "intensity": 8},
        {"type": "point", "name": "bulb", "intensity": 2, "range": 10},
        {"type": "spot", "intensity": 3, "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}]}},
      "nodes": [
        {"mesh": 0},
        {"name": "sun", "rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"translation": [0.5, 1, 0.5], "extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"scale": [2, 2, 2], "children": [4]},
        {"name": "beam", "translation": [0, 1, 0], "extensions": {"KHR_lights_punctual": {"light": 2}}}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
      "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "buffers": [{"byteLength": 36, "uri": "corners.bin"}]}"#;
    std::fs::write(&path, text).unwrap();
    let corners: [[f32; 3]; 3] = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    std::fs::write(dir.path().join("corners.bin"), bytemuck_bytes(&corners)).unwrap();
    let scene = Scene::load(&path).unwrap();
    assert_eq!(scene.lights.len(), 3);
    let [sun, bulb, beam] = [0, 1, 2].map(|i| &scene.lights[i]);
    assert_eq!((sun.name.as_str(), sun.intensity), ("sun", [8.0, 4.0, 2.0]));
    let LightKind::Sun { direction, angle } = sun.kind else { panic!("{sun:?}") };
    assert!(angle == 0.0 && direction[1] < -0.999_999, "{direction:?}");
    assert_eq!(
        (bulb.name.as_str(), bulb.intensity, bulb.kind),
        ("bulb", [2.0; 3], LightKind::Point { position: [0.5, 1.0, 0.5] })
    );
    let LightKind::Spot { position, direction, inner, outer } = beam.kind else { panic!("{beam:?}") };
    assert!(position == [0.0, 2.0, 0.0] && direction[2] < 0.0, "{beam:?}");
    assert!((inner - 0.25f64.to_degrees()).abs() < 1e-5 && (outer - 0.5f64.to_degrees()).abs() < 1e-5);
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].contains("range of a light") && scene.warnings[0].contains("nodes[2]"), "{:?}", scene.warnings);
    // In a TOML scene it is placed with its file, and in millimetres; its intensity stays.
    let toml = dir.path().join("scene.toml");
    std::fs::write(&toml, "[[file]]\npath = 'scene.gltf'\nunit = 0.5\ntranslate = [1, 0, 0]\n").unwrap();
    let scene = Scene::load(&toml).unwrap();
    assert_eq!(scene.lights[1].kind, LightKind::Point { position: [1.25, 0.5, 0.25] });
    assert_eq!(scene.lights[1].intensity, [2.0; 3]);
    assert!(matches!(scene.lights[0].kind, LightKind::Sun { direction, .. } if direction[1] < 0.0));
}

fn bytemuck_bytes(corners: &[[f32; 3]; 3]) -> Vec<u8> {
    corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}
