//! Input: cases B of `docs/hard_cases.md`. Bakes run on the GPU; what the host alone decides (tables, errors) needs none.

use super::common::{gpu, impossible, known};
use raycell::engine::Engine;
use raycell::layout::{BvhNode, Point, Tile, kind};
use raycell::network::tiles::starts;
use raycell::output::{image, ply, points};
use raycell::pass::{GpuEngine, SceneBuffers};
use raycell::scene::shapes::{Triangles, flipped, quad, room, sides};
use raycell::scene::{Face, Geometry, LoadOptions, Material, cumulative};
use raycell::twin::math::{invert_cdf, seed_of, unit};
use raycell::twin::sobol::sobol4;
use raycell::{Answer, Backend, Camera, Direct, Error, Flow, Method, Params, Result, Scene, Solution, SurfacePoint, bake};
use std::f64::consts::PI;
use std::path::Path;

const LOW: [f64; 3] = [0.0; 3];
const HIGH: [f64; 3] = [1.0; 3];

/// Grey of a reflectance, with a radiosity of its own.
fn grey(rho: f64, e: f64) -> Material {
    Material::new("grey", [rho; 3], [e / PI; 3])
}

/// A lit cube: one side shines.
fn cube() -> Scene {
    Scene::from_triangles("cube", &room(LOW, HIGH, [0, 0, 0, 1, 0, 0]), vec![grey(0.5, 0.0), grey(0.0, 1.0)]).unwrap()
}

/// A scene of triangles and the cube's materials.
fn like_cube(triangles: &Triangles) -> Scene {
    Scene::from_triangles("cube", triangles, cube().materials).unwrap()
}

/// Points on all six sides of the unit cube, seen from inside.
fn inside() -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for axis in 0..3 {
        for (side, n) in [(0.0, 1.0), (1.0, -1.0)] {
            for (u, v) in [(0.013, 0.4), (0.37, 0.61), (0.83, 0.09), (0.5, 0.5)] {
                let (mut p, mut normal) = ([0.0; 3], [0.0; 3]);
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3], normal[axis]) = (side, u, v, n);
                points.push(SurfacePoint { p, n: normal });
            }
        }
    }
    points
}

fn solve(backend: &Backend, scene: &Scene, params: &Params) -> Result<Solution> {
    bake(backend, scene, params, &mut |_| Flow::Continue)
}

/// A small bake's answers inside the cube.
fn lit(backend: &Backend, scene: &Scene) -> Vec<Answer> {
    let answers = solve(backend, scene, &Params { rays: 8192, ..Params::default() }).unwrap().query(backend, &inside()).unwrap();
    // So few rays leave errors of some percent.
    assert_eq!(impossible(&answers, scene, 0.1), None);
    answers
}

/// The deepest leaf.
fn depth(nodes: &[BvhNode]) -> u32 {
    let (mut deepest, mut stack) = (0, vec![(0u32, 0)]);
    while let Some((i, above)) = stack.pop() {
        let node = &nodes[i as usize];
        deepest = deepest.max(above);
        if node.count == 0 {
            stack.extend([(node.first, above + 1), (node.first + 1, above + 1)]);
        }
    }
    deepest
}

#[test]
fn b01_triangles_without_area_change_no_bit() {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    let plain = room(LOW, HIGH, [0, 0, 0, 1, 0, 0]);
    // A repeated vertex or a point, and collinear ones, along axes and not, in the cube and far outside of it.
    let thin = |i: usize| {
        let p = [0.1 + 0.008 * i as f64, 0.3, 0.77 - 0.003 * i as f64];
        let q = [p[0] * 0.5 + 0.1, 0.9, 0.2];
        let r = [0, 1, 2].map(|k| p[k] + 0.3 * (q[k] - p[k]));
        let far = [1e3 * p[0], -50.0, 7.0];
        ([[p, p, q], [p, q, r], [p, p, p], [p, q, q], [far, p, far]][i % 5], (i % 2) as u32)
    };
    let all: Vec<_> = (0..100).map(thin).collect();
    let with: Triangles = [&all[..30], &plain[..5], &all[30..60], &plain[5..], &all[60..]].concat();
    let scene = like_cube(&with);
    let geometry = Geometry::new(&scene).unwrap();
    let faces: Vec<u32> = (0..30).chain(35..65).chain(72..112).collect();
    assert_eq!(geometry.degenerate, faces, "the list names every one, and no other");
    let (want, got) = (lit(&backend, &cube()), lit(&backend, &scene));
    assert!(want == got, "{:?}", want.iter().zip(&got).find(|(a, b)| a != b));
    let solution = solve(&backend, &scene, &Params { rays: 1024, ..Params::default() }).unwrap();
    assert_eq!(solution.report().scene.dropped, 100);
    let told = solution.report().warnings.join("\n");
    assert!(told.contains("100 triangles without an area"), "{told}");
    assert!(lit(&backend, &cube()).iter().all(|a| a.b[0] > 0.0));
}

#[test]
fn b02_a_sliver_has_its_area() {
    let sliver = [[0.0; 3], [4096.0, 4097.0, 0.0], [4097.0, 4098.0, 0.0]];
    // In 32 bits the area vanishes.
    let [_, b, c] = sliver.map(|v| v.map(|x| x as f32));
    assert_eq!(b[0] * c[1] - b[1] * c[0], 0.0);
    let scene = Scene::from_triangles("sliver", &[(sliver, 0)], vec![grey(0.5, 1.0)]).unwrap();
    let geometry = Geometry::new(&scene).unwrap();
    assert_eq!(scene.area(0), known("SLIVER"));
    assert_eq!(geometry.areas[0] / geometry.scale.powi(2), known("SLIVER"));
    // 4096 * 4098 - 4097² = -1: seen from above it is clockwise.
    assert_eq!(geometry.tris[0].normal, [0.0, 0.0, -1.0]);
    // From a file, too.
    let obj = b"v 0 0 0\nv 4096 4097 0\nv 4097 4098 0\nf 1 2 3\n";
    let mut files = |path: &Path| match path.to_str() {
        Some("s.obj") => Ok(obj.to_vec()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    let scene = Scene::load_from(Path::new("s.obj"), &LoadOptions::default(), &mut files, &mut |_| Flow::Continue).unwrap();
    assert_eq!(scene.area(0), known("SLIVER"));
}

#[test]
fn b03_duplicates_change_no_bit() {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    let plain = room(LOW, HIGH, [0, 0, 0, 1, 0, 0]);
    let turned = |i: usize| plain.iter().map(move |&([a, b, c], m)| ([[a, b, c], [b, c, a], [c, a, b]][i % 3], m));
    let many: Triangles = (0..1000).flat_map(turned).collect();
    let geometry = Geometry::new(&like_cube(&many)).unwrap();
    assert_eq!((geometry.tris.len(), geometry.duplicate.len()), (12, 11_988));
    let (want, got) = (lit(&backend, &cube()), lit(&backend, &like_cube(&many)));
    assert!(want == got, "{:?}", want.iter().zip(&got).find(|(a, b)| a != b));

    // Reversed winding is another surface: the cube's outside, which the inside does not see. All of both, in whatever
    // order, is what one of each is.
    let both = [plain.clone(), flipped(plain.clone())].concat();
    let reversed: Triangles =
        (0..500).flat_map(|i| turned(i).collect::<Vec<_>>().into_iter().chain(flipped(turned(i + 1).collect()))).collect();
    let geometry = Geometry::new(&like_cube(&reversed)).unwrap();
    assert_eq!((geometry.tris.len(), geometry.duplicate.len()), (24, 11_976));
    let (want, got) = (lit(&backend, &like_cube(&both)), lit(&backend, &like_cube(&reversed)));
    assert!(want == got, "{:?}", want.iter().zip(&got).find(|(a, b)| a != b));
}

#[test]
fn b03_what_coincides_and_is_no_duplicate_is_built_all_the_same() {
    // Thousands of triangles in one plane about one centre, each a little turned: boxes that no split parts.
    let n = 12_000usize;
    let star: Triangles = (0..n)
        .map(|i| {
            let at = |k: usize| {
                let turn = 2.0 * PI * (k as f64 / 3.0 + i as f64 / (3 * n) as f64);
                [turn.cos(), turn.sin(), 0.0]
            };
            ([at(0), at(1), at(2)], 0)
        })
        .collect();
    let geometry = Geometry::new(&Scene::from_triangles("star", &star, vec![grey(0.5, 1.0)]).unwrap()).unwrap();
    assert_eq!(geometry.tris.len() + geometry.duplicate.len(), n);
    let most = (geometry.tris.len() as f64).log2().ceil() as u32 + 8;
    eprintln!("{} triangles, {} deep, {most} allowed", geometry.tris.len(), depth(&geometry.nodes));
    assert!(depth(&geometry.nodes) <= most);
    // The device takes it, and every triangle is in a leaf once.
    let mut seen = vec![0; geometry.tris.len()];
    for leaf in geometry.nodes.iter().filter(|n| n.count > 0) {
        (leaf.first..leaf.first + leaf.count).for_each(|t| seen[t as usize] += 1);
    }
    assert!(seen.iter().all(|&times| times == 1));
    if let Some(gpu) = gpu() {
        SceneBuffers::new(&gpu, &geometry).unwrap();
    }
}

#[test]
fn b04_what_is_no_number_is_refused() {
    let good = cube();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e39, -1e300] {
        for at in 0..good.vertices.len() {
            for k in 0..3 {
                let mut scene = good.clone();
                scene.vertices[at][k] = bad;
                match Geometry::new(&scene) {
                    Err(Error::InvalidVertex { index, .. }) => assert_eq!(index, at),
                    other => panic!("{bad} at {at}: {:?}", other.map(|_| ())),
                }
            }
        }
    }
    for index in [good.vertices.len() as u32, u32::MAX] {
        for face in [0, 7, good.faces.len() - 1] {
            for corner in 0..3 {
                let mut scene = good.clone();
                scene.faces[face].vertices[corner] = index;
                let refused = Geometry::new(&scene).map(|_| ());
                assert!(matches!(refused, Err(Error::IndexOutOfRange { index: i, .. }) if i == index as i64), "{refused:?}");
            }
            let mut scene = good.clone();
            scene.faces[face].material = index;
            assert!(matches!(Geometry::new(&scene), Err(Error::IndexOutOfRange { .. })));
        }
    }
    // In text, with the line.
    for bad in ["nan", "inf", "-inf", "1e39", "1e999", "-4e38"] {
        let obj = format!("v 0 0 0\nv 1 0 0\nv 0 {bad} 0\nf 1 2 3\n");
        let mut files = |path: &Path| match path.to_str() {
            Some("s.obj") => Ok(obj.clone().into_bytes()),
            _ => Err(std::io::ErrorKind::NotFound.into()),
        };
        let refused = Scene::load_from(Path::new("s.obj"), &LoadOptions::default(), &mut files, &mut |_| Flow::Continue);
        match refused {
            Err(Error::InvalidVertex { place, index: 2, .. }) => assert_eq!(place, "s.obj:3"),
            other => panic!("{bad}: {other:?}"),
        }
    }
    // What is merely extreme is lit, or has no area; it neither hangs nor panics.
    for size in [1e-320, 1e-300, 1e-38, 1e-6, 1e6, 1e37] {
        let triangle = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
        let scene = Scene::from_triangles("extreme", &[(triangle, 0)], vec![grey(0.5, 1.0)]).unwrap();
        match Geometry::new(&scene) {
            Ok(g) => assert!(g.scale.is_finite() && g.scale > 0.0 && g.areas[0] > 0.0 && g.areas[0].is_finite()),
            Err(e) => assert!(matches!(e, Error::EmptyScene { .. }) && size < 1e-75, "{size:e}: {e}"),
        }
    }
}

#[test]
fn b05_a_flipped_face_is_told_by_the_others() {
    let Some(gpu) = gpu() else { return };
    const RAYS: usize = 1 << 19;
    // The row sum of each face: the share of its cosine rays that meet a front.
    let row = |g: &Geometry, face: usize| {
        let mut engine = GpuEngine::new(&gpu, g).unwrap();
        let tri = |half: usize| g.source.iter().position(|&f| f as usize == 2 * face + half).unwrap() as u32;
        let from: Vec<Point> = (0..RAYS as u32 / 64)
            .map(|i| {
                let [u, v, ..] = sobol4(i, 3).map(unit);
                // A square is cut along its diagonal.
                let (half, b1, b2) = if u >= v { (0, u - v, v) } else { (1, u, v - u) };
                raycell::twin::trace::surface_point(g, tri(half), b1, b2)
            })
            .collect();
        let batch = engine.upload(&from).unwrap();
        let hits = engine.shoot(&batch, 5, 0, 64).unwrap();
        let hits = engine.points(&hits).unwrap();
        [kind::FRONT, kind::BACK, kind::SKY].map(|k| hits.iter().filter(|p| p.kind == k).count() as f64 / RAYS as f64)
    };
    let faces = sides(LOW, HIGH, [0; 6]);
    let scene = |turned: Option<usize>| {
        let all = (0..6).flat_map(|i| if turned == Some(i) { flipped(faces[i].clone()) } else { faces[i].clone() });
        Scene::from_triangles("cube", &all.collect::<Vec<_>>(), vec![grey(0.5, 1.0)]).unwrap()
    };
    let whole = Geometry::new(&scene(None)).unwrap();
    assert!((0..6).all(|face| row(&whole, face) == [1.0, 0.0, 0.0]));
    let g = Geometry::new(&scene(Some(0))).unwrap();
    for face in 1..6 {
        let [front, back, sky] = row(&g, face);
        let want = known(if face == 1 { "FF3-CUBE-OPP" } else { "FF3-PERP-90" });
        let sigma = (want * (1.0 - want) / RAYS as f64).sqrt();
        eprintln!("face {face}: row sum {front:.6}, is {:.6}, off by {:+.2} standard errors", 1.0 - want, (back - want) / sigma);
        assert!((front - (1.0 - want)).abs() <= 5.0 * sigma && front + back == 1.0 && sky == 0.0);
    }
    // The flipped one looks outside, where nothing is.
    assert_eq!(row(&g, 0), [0.0, 0.0, 1.0]);

    // Bakes: 1/(1-rho) without it; with it less, and it is said why.
    let backend = Backend::Gpu(gpu.clone());
    let params = Params { rays: 32_768, ..Params::default() };
    let opposite = &inside()[4..8];
    let bright = solve(&backend, &scene(None), &params).unwrap();
    let answers = bright.query(&backend, opposite).unwrap();
    assert_eq!(impossible(&answers, &scene(None), 0.01), None);
    // As exact as the furnace of so few rays is.
    assert!(answers.iter().all(|a| (a.b[0] / 2.0 - 1.0).abs() < 0.01), "{answers:?}");
    assert!(bright.report().warnings.is_empty(), "{:?}", bright.report().warnings);
    let dim = solve(&backend, &scene(Some(0)), &params).unwrap();
    let told = dim.report().warnings.join("\n");
    assert!(told.contains("back"), "{told}");
    let answers = dim.query(&backend, opposite).unwrap();
    assert_eq!(impossible(&answers, &scene(Some(0)), 0.0), None);
    assert!(answers.iter().all(|a| a.b[0] < 1.9 && a.b[0] > 1.5), "{answers:?}");
}

#[test]
fn b06_a_single_triangle() {
    let Some(gpu) = gpu() else { return };
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = Scene::from_triangles("one", &[(corners, 0)], vec![grey(0.5, 1.0)]).unwrap();
    for backend in [Backend::Gpu(gpu), Backend::Cpu] {
        for direct in [Direct::Exact, Direct::Network] {
            let solution = solve(&backend, &scene, &Params { rays: 4096, direct, ..Params::default() }).unwrap();
            let answers = solution.query(&backend, &[SurfacePoint { p: [0.2, 0.3, 0.0], n: [0.0, 0.0, 1.0] }]).unwrap();
            assert_eq!(impossible(&answers, &scene, 0.0), None);
            assert_eq!((answers[0].b, answers[0].h), ([PI * (1.0 / PI); 3], [0.0; 3]));
        }
    }
}

#[test]
fn b07_nothing_to_light() {
    let flat = ([[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], 0);
    let nothing = Scene::from_triangles("nothing", &[], vec![]).map(|_| ());
    assert!(matches!(nothing, Err(Error::EmptyScene { .. })), "{nothing:?}");
    let bare = Scene::from_triangles("bare", &[([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0)], vec![]).map(|_| ());
    assert!(matches!(bare, Err(Error::IndexOutOfRange { index: 0, count: 0, .. })), "{bare:?}");
    // Faces without an area, or vertices without faces: the same on every machine, before anything is uploaded.
    let mut backends = vec![Backend::Cpu];
    backends.extend(gpu().map(Backend::Gpu));
    for backend in backends {
        let mut lonely = cube();
        lonely.faces.clear();
        let line = Scene::from_triangles("line", &[flat; 3], vec![grey(0.5, 1.0)]).unwrap();
        for scene in [Scene::default(), lonely, line] {
            let refused = solve(&backend, &scene, &Params::default()).map(|_| ());
            assert!(matches!(refused, Err(Error::EmptyScene { .. })), "{refused:?}");
        }
    }
    let mut files = |_: &Path| Ok(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n".to_vec());
    let refused = Scene::load_from(Path::new("s.obj"), &LoadOptions::default(), &mut files, &mut |_| Flow::Continue).map(|_| ());
    assert!(matches!(refused, Err(Error::EmptyScene { .. })), "{refused:?}");
}

#[test]
fn b08_no_light() {
    let Some(gpu) = gpu() else { return };
    let scene = Scene::from_triangles("dark", &room(LOW, HIGH, [0; 6]), vec![grey(0.9, 0.0)]).unwrap();
    let backend = Backend::Gpu(gpu);
    for direct in [Direct::Exact, Direct::Network] {
        let solution = solve(&backend, &scene, &Params { rays: 4096, direct, ..Params::default() }).unwrap();
        let answers = solution.query(&backend, &inside()).unwrap();
        let bits = |a: &Answer| [a.b, a.h, a.d].as_flattened().iter().all(|x| x.to_bits() == 0);
        assert!(answers.iter().all(bits), "{answers:?}");
        let solver = &solution.report().solver;
        assert_eq!((solver.residual, solver.error_bound), (Some(0.0), Some(0.0)));
        assert!(solution.report().warnings.iter().any(|w| w.contains("all will be black")));
    }
}

#[test]
fn b09_all_emit() {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    for rho in [0.5, 0.9] {
        let scene = Scene::from_triangles("furnace", &room(LOW, HIGH, [0; 6]), vec![grey(rho, 1.0)]).unwrap();
        let off = |params: &Params| {
            let answers = solve(&backend, &scene, params).unwrap().query(&backend, &inside()).unwrap();
            assert_eq!(impossible(&answers, &scene, 1e-2), None);
            let off: Vec<f64> = answers.iter().map(|a| a.b[0] * (1.0 - rho) - 1.0).collect();
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            (off.iter().fold(0.0, |m: f64, x| m.max(x.abs())), mean.abs())
        };
        // Lamps are receivers, too. A bake as it comes, direct light sampled as exactly as the tolerance asks: E01's tolerance
        // for the mean, ten times it at single points, each of which has the noise of 1,024 gather rays, .3 %.
        let params = Params { rays: 65_536, direct_tolerance: 5e-4, direct_samples: 65_536, ..Params::default() };
        let network = off(&params);
        // Without sampling at the points shown.
        let params = Params { method: Method::Fem, direct: Direct::Network, patches: 150, gather_rays: 0, ..Params::default() };
        let fem = off(&params);
        eprintln!("furnace {rho}: network off by {network:?} at most and in the mean, finite elements by {fem:?}");
        assert!(network.0 <= 1e-2 && network.1 <= 1e-3 && fem.0 <= 1e-3, "{rho}: {network:?} {fem:?}");
    }
}

#[test]
fn b10_reflectances_that_cannot_be() {
    let triangles = room(LOW, HIGH, [0, 0, 0, 1, 0, 0]);
    let with = |rho: f64, k: usize| {
        let mut wall = Material::new("the wall", [0.5; 3], [1.0; 3]);
        wall.reflectance[k] = rho;
        Scene::from_triangles("cube", &triangles, vec![grey(0.5, 0.0), wall])
    };
    // In memory: refused by name. 1 - 1e-9 is 1 in the passes' 32 bits.
    for rho in [1.0, 1.0 - 1e-9, 1.0000001, 1.5, -0.1, f64::NAN, f64::INFINITY] {
        for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
            match with(rho, k) {
                Err(Error::InvalidReflectance { material, band, value, .. }) => {
                    assert_eq!((material.as_str(), band, value.to_bits()), ("the wall", name, rho.to_bits()));
                }
                other => panic!("{rho}: {:?}", other.map(|_| ())),
            }
        }
    }
    for rho in [-0.0, 0.0, 0.999999] {
        with(rho, 1).unwrap();
    }
    // From files: what exporters write for white is taken for 0.98 with a warning, and refused by --strict.
    let load = |kd: &str, strict: bool| {
        let mut files = |path: &Path| match path.to_str() {
            Some("s.obj") => Ok(b"mtllib s.mtl\nusemtl the wall\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec()),
            Some("s.mtl") => Ok(format!("newmtl the wall\nKd 0.5 {kd} 0.5\n").into_bytes()),
            _ => Err(std::io::ErrorKind::NotFound.into()),
        };
        let mut options = LoadOptions::default();
        options.strict = strict;
        Scene::load_from(Path::new("s.obj"), &options, &mut files, &mut |_| Flow::Continue)
    };
    for kd in ["1", "1.0", "1.0000001", "0.999999999"] {
        let scene = load(kd, false).unwrap();
        assert_eq!(scene.materials[0].reflectance, [0.5, 0.98, 0.5], "{kd}");
        assert!(scene.warnings.iter().any(|w| w.contains("'the wall'") && w.contains("0.98")), "{:?}", scene.warnings);
        let refused = load(kd, true).map(|_| ());
        assert!(matches!(&refused, Err(Error::Strict { what, .. }) if what.contains("'the wall'")), "{refused:?}");
    }
    for kd in ["1.00001", "1.5", "-0.1", "nan", "inf"] {
        match load(kd, false) {
            Err(Error::InvalidReflectance { material, band: "green", place, .. }) => {
                assert_eq!((material.as_str(), place.as_str()), ("the wall", "s.mtl:2"));
            }
            other => panic!("{kd}: {other:?}"),
        }
    }
    load("-0.0", true).unwrap();
    // Two plates of reflectance 1 would have a light, 1/(1 - F): that they are refused is a choice, not mathematics.
    assert!((1.0 / (1.0 - known("FF3-CUBE-OPP")) - known("RHO1-OPEN")).abs() < 1e-12);
    let [floor, _, _, ceiling, ..] = sides(LOW, HIGH, [0; 6]);
    let open = Scene::from_triangles("open", &[floor, ceiling].concat(), vec![Material::new("plate", [1.0; 3], [1.0; 3])]);
    assert!(matches!(open.map(|_| ()), Err(Error::InvalidReflectance { material, .. }) if material == "plate"));
}

#[test]
fn b11_emissions_beyond_all_measure() {
    let triangles = room(LOW, HIGH, [0; 6]);
    for bad in [-1e-30, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 3.5e38, 1e308] {
        match Scene::from_triangles("cube", &triangles, vec![Material::new("lamp", [0.9; 3], [1.0, bad, 1.0])]) {
            Err(Error::InvalidEmission { material, band: "green", .. }) => assert_eq!(material, "lamp"),
            other => panic!("{bad}: {:?}", other.map(|_| ())),
        }
    }
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu);
    let dir = tempfile::tempdir().unwrap();
    // As much as is allowed, and as little as can be written: the inside works with what it is beside 1.
    for e in [3e38, 1e-30, 1e-300, 5e-320] {
        let scene = Scene::from_triangles("furnace", &triangles, vec![grey(0.9, e)]).unwrap();
        // Of finite elements every row sums to 1.
        let params = Params { method: Method::Fem, direct: Direct::Network, patches: 150, gather_rays: 0, ..Params::default() };
        let solution = solve(&backend, &scene, &params).unwrap();
        let answers = solution.query(&backend, &inside()).unwrap();
        // Of numbers below the normal ones few digits are left.
        let limit = if e < 1e-307 { 0.05 } else { 1e-4 };
        assert_eq!(impossible(&answers, &scene, limit), None);
        let worst = answers.iter().map(|a| (a.b[0] / (10.0 * e) - 1.0).abs()).fold(0.0, f64::max);
        eprintln!("e = {e:e}: off by {worst:.2e} at most");
        assert!(worst <= limit, "{e:e}: {worst}");

        // Files: 64-bit text holds it; 32-bit meshes and pictures do, or say that they do not.
        let csv = dir.path().join("points.csv");
        points::write(&csv, &inside(), &answers).unwrap();
        let text = std::fs::read_to_string(&csv).unwrap();
        let cells = text.lines().skip(1).flat_map(|l| l.split(',').skip(6).take(9).map(|c| c.parse::<f64>().unwrap()));
        assert!(cells.clone().count() == 9 * answers.len() && cells.clone().all(|x| x.is_finite()));
        let camera = Camera {
            eye: [0.5, 0.5, 0.9],
            target: [0.5, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            vfov_degrees: 60.0,
            width: 4,
            height: 4,
        };
        let (mesh, picture) = (solution.vertices(&backend), solution.render(&backend, &camera));
        if e > 1.0 {
            assert!(
                matches!(&mesh, Err(Error::Overflow { what, value }) if what.contains("vertex") && *value > 2e39),
                "{mesh:?}"
            );
            assert!(matches!(&picture, Err(Error::Overflow { what, .. }) if what.contains("pixel")), "{picture:?}");
            continue;
        }
        let (mesh, picture) = (mesh.unwrap(), picture.unwrap());
        assert!(mesh.vertices.iter().all(|v| v.b.iter().all(|b| b.is_finite() && *b >= 0.0)));
        assert!(picture.rgb.as_flattened().iter().all(|x| x.is_finite() && *x >= 0.0));
        ply::write(&dir.path().join("v.ply"), &mesh).unwrap();
        image::write(&dir.path().join("p.exr"), &picture, None).unwrap();
        image::write(&dir.path().join("p.png"), &picture, None).unwrap();
    }
}

#[test]
fn b12_random_numbers_stay_below_one() {
    assert_eq!(0xFFFF_FFFFu32 as f32 * (1.0 / 4294967296.0), known("RNG-ONE") as f32, "the trap");
    for x in [0, 1, 0xFFFF_FF00, 0xFFFF_FFFF] {
        assert!((0.0..1.0).contains(&unit(x)));
    }
    assert_eq!((unit(0), unit(u32::MAX)), (0.0, 1.0 - 1.0 / 16777216.0));
    // A place in an interval of a distribution likewise, for the first and the last number, however narrow it is.
    for weights in [vec![1.0], vec![0.0, 1.0, 0.0], vec![1.0, 1e-12], vec![1e-12, 1.0, 1e-12], vec![1.0; 1000]] {
        let cdf = cumulative(&weights);
        for u in [0, 1, 0x7FFF_FFFF, 0xFFFF_FF00, 0xFFFF_FFFE, 0xFFFF_FFFF] {
            let (i, place) = invert_cdf(cdf.len() as u32, |i| cdf[i as usize], u);
            assert!(weights[i as usize] > 0.0 && (0.0..1.0).contains(&place), "{weights:?} {u}: {i} {place}");
        }
    }
    // Rays of the GPU: every start within its own tile's triangle.
    let Some(gpu) = gpu() else { return };
    let g = Geometry::new(&cube()).unwrap();
    let mut engine = GpuEngine::new(&gpu, &g).unwrap();
    let rays = engine.emit(&starts(&g, &vec![0.0; g.tiles as usize], 0.0), 3, 0, 1 << 17, 1 << 17).unwrap();
    for p in engine.points(&rays).unwrap() {
        assert!(p.tile < g.tiles && g.tile_tri[p.tile as usize] == p.tri && p.p.iter().all(|x| x.abs() <= 1.0), "{p:?}");
    }
}

/// Whether counts follow weights: the p-value of chi-square, weights pooled until 20 draws are expected of each pool.
fn p_value(counts: &[u32], weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let draws: f64 = counts.iter().map(|&c| c as f64).sum();
    let (mut chi, mut pools, mut seen, mut expected) = (0.0, 0, 0.0, 0.0);
    for (&c, w) in counts.iter().zip(weights) {
        seen += c as f64;
        expected += draws * w / total;
        if expected >= 20.0 {
            chi += (seen - expected).powi(2) / expected;
            (pools, seen, expected) = (pools + 1, 0.0, 0.0);
        }
    }
    // Wilson and Hilferty: the cube root is all but normal; then the normal tail by Abramowitz and Stegun 26.2.17.
    let k = (pools - 1) as f64;
    let z = ((chi / k).powf(1.0 / 3.0) - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt();
    let t = 1.0 / (1.0 + 0.2316419 * z.abs());
    let tail = (-0.5 * z * z).exp() / (2.0 * PI).sqrt()
        * t
        * (0.319381530 + t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
    eprintln!("{draws} draws, {pools} pools: chi-square {chi:.1}, z {z:+.2}");
    if z > 0.0 { tail } else { 1.0 - tail }
}

#[test]
fn b13_a_million_areas_of_twelve_decades() {
    const N: usize = 1_000_000;
    // Every thousandth has none at all, so have the first and the last.
    let area =
        |i: usize| if i.is_multiple_of(1000) || i + 1 == N { 0.0 } else { 10f64.powf(-12.0 * unit(seed_of(3, i as u32)) as f64) };
    let areas: Vec<f64> = (0..N).map(area).collect();
    let cdf = cumulative(&areas);
    assert!(cdf.windows(2).all(|c| c[0] <= c[1]) && cdf[N - 1] == u32::MAX);
    let draw = |u: u32| invert_cdf(N as u32, |i| cdf[i as usize], u).0 as usize;
    let mut counts = vec![0u32; N];
    (0..10_000_000u32).for_each(|i| counts[draw(seed_of(11, i))] += 1);
    for u in [0, 1, u32::MAX - 256, u32::MAX - 1, u32::MAX] {
        assert!(areas[draw(u)] > 0.0, "{u}");
    }
    assert!(counts.iter().zip(&areas).all(|(&c, &a)| a > 0.0 || c == 0));
    let p = p_value(&counts, &areas);
    assert!(p > 1e-4, "{p}");
}

#[test]
fn b13_starts_and_lamps_follow_areas() {
    let Some(gpu) = gpu() else { return };
    // Triangles side by side of areas 1e-9 to 1, each a lamp: starts of rays on the GPU.
    let mut x = 0.0;
    let triangles: Triangles = (0..20_000u32)
        .map(|i| {
            let side = (2.0 * 10f64.powf(-9.0 * unit(seed_of(3, i)) as f64)).sqrt();
            let at = (x, 30.0 * unit(seed_of(4, i)) as f64);
            x += side / 100.0;
            ([[at.0, at.1, 0.0], [at.0 + side, at.1, 0.0], [at.0, at.1 + side, 0.0]], 0)
        })
        .collect();
    let scene = Scene::from_triangles("lamps", &triangles, vec![grey(0.5, 1.0)]).unwrap();
    let g = Geometry::new(&scene).unwrap();
    let tiles: Vec<Tile> = starts(&g, &vec![0.0; g.tiles as usize], 0.0);
    let mut engine = GpuEngine::new(&gpu, &g).unwrap();
    let n = 1 << 20;
    let rays = engine.emit(&tiles, 3, 0, n, n).unwrap();
    let mut counts = vec![0u32; g.tris.len()];
    engine.points(&rays).unwrap().chunks(2).for_each(|ray| counts[ray[0].tri as usize] += 1);
    // Low-discrepancy draws are more even than chance: a p-value near 1 is right.
    let p = p_value(&counts, &g.areas);
    assert!(p > 1e-4, "{p}");
    // Emitters are drawn by power, here the area.
    assert_eq!(g.emitters.len(), g.tris.len());
    let mut counts = vec![0u32; g.tris.len()];
    for i in 0..4_000_000u32 {
        let (e, _) = invert_cdf(g.emitters.len() as u32, |e| g.emitters[e as usize].cdf, seed_of(5, i));
        counts[g.emitters[e as usize].tri as usize] += 1;
    }
    let p = p_value(&counts, &g.areas);
    assert!(p > 1e-4, "{p}");
}

#[test]
fn b07_faces_of_nothing_are_left_out_of_a_scene_that_has_some() {
    // Not empty: one face with an area among many without.
    let mut scene = cube();
    scene.faces.push(Face { vertices: [0, 0, 0], material: 0, object: 0 });
    assert_eq!(Geometry::new(&scene).unwrap().degenerate, [12]);
    let one = quad([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], 0);
    assert_eq!(Geometry::new(&Scene::from_triangles("one", &one, vec![grey(0.0, 0.0)]).unwrap()).unwrap().tris.len(), 2);
}
