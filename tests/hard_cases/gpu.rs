//! Group H: what devices and drivers do otherwise than one hopes. All on the GPU adapter but where a line says otherwise.

use crate::common::{gpu, impossible, known, open, root};
use glam::DVec3;
use raycell::gpu::kernel::WORKGROUP;
use raycell::gpu::sentinel::{self, Counts};
use raycell::gpu::wgsl::{self, KERNELS, Text};
use raycell::gpu::{Access, Gpu, HEAVY, Kernel, LIGHT, device};
use raycell::layout::{DirectSum, Point, Tile, kind};
use raycell::network::tiles;
use raycell::pass::{self, SceneBuffers};
use raycell::scene::{Geometry, Material, shapes};
use raycell::twin::direct::Samples;
use raycell::twin::math::{hash, unit};
use raycell::{Backend, Checkpoint, Error, Event, Flow, Params, Scene, Solution, SurfacePoint, bake, bake_from, twin};
use std::sync::Arc;

/// A closed room of a size, half grey, with a lamp on its ceiling.
fn room(emission: f64) -> Scene {
    let walls = shapes::room([0.0; 3], [2.0, 2.0, 2.0], [0; 6]);
    let lamp = shapes::quad([[0.8, 1.9, 0.8], [1.2, 1.9, 0.8], [1.2, 1.9, 1.2], [0.8, 1.9, 1.2]], 1);
    let materials = vec![Material::new("grey", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.0; 3], [emission; 3])];
    Scene::from_triangles("room", &[walls, lamp].concat(), materials).unwrap()
}

fn quick() -> Params {
    Params { rays: 4_096, ..Params::default() }
}

/// Points on the walls and the floor.
fn places() -> Vec<SurfacePoint> {
    let at = |k: u32| 0.1 + 1.8 * f64::from(unit(hash(k)));
    let floor = (0..24).map(|k| SurfacePoint { p: [at(2 * k), 0.0, at(2 * k + 1)], n: [0.0, 1.0, 0.0] });
    floor.chain((0..24).map(|k| SurfacePoint { p: [0.0, at(2 * k + 70), at(2 * k + 71)], n: [1.0, 0.0, 0.0] })).collect()
}

fn saved(solution: &Solution) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("solution.rcell");
    solution.save(&path).unwrap();
    std::fs::read(path).unwrap()
}

fn baked(gpu: &Arc<Gpu>, scene: &Scene, params: &Params) -> Solution {
    bake(&Backend::Gpu(gpu.clone()), scene, params, &mut |_| Flow::Continue).unwrap()
}

#[test]
fn h01_every_item_of_large_dispatches_is_done_once() {
    let Some(gpu) = gpu() else { return };
    let limit = known("LIM-DISPATCH-1D-64") as u32;
    assert_eq!(limit, 65_535 * WORKGROUP, "a workgroup has 64 invocations");
    for n in [limit - 1, limit, limit + 1, known("LIM-DISPATCH-1D-256") as u32 + 1, (1 << 24) + 1] {
        assert_eq!(sentinel::count(&gpu, n, 1, u32::MAX).unwrap(), Counts::expected(n, 1));
    }
    let n = 65_535 * 256 + 1;
    assert_eq!(f64::from(sentinel::count(&gpu, n, 0, u32::MAX).unwrap().index_sum), known("LIM-INDEXSUM"));
}

#[test]
#[ignore = "a minute: cargo test --release --test hard_cases -- --ignored h01"]
fn h01_hundred_million_items_are_done_once() {
    let Some(gpu) = gpu() else { return };
    assert_eq!(sentinel::count(&gpu, 100_000_000, 1, LIGHT).unwrap(), Counts::expected(100_000_000, 1));
}

/// One workgroup more than a dimension has. Nothing is dispatched indirectly, so nothing is dropped in silence: the host
/// cuts, and what it cuts is counted.
#[test]
fn h02_nothing_is_dispatched_indirectly_and_one_group_more_is_counted() {
    let Some(gpu) = gpu() else { return };
    let n = 65_536 * WORKGROUP;
    assert_eq!(sentinel::count(&gpu, n, 0, u32::MAX).unwrap(), Counts::expected(n, 0));
    let mut files = 0;
    for folder in ["src/gpu", "src/pass"] {
        for entry in std::fs::read_dir(root(folder)).unwrap() {
            let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
            assert!(!text.contains("dispatch_workgroups_indirect"));
            files += usize::from(text.contains("dispatch_workgroups("));
        }
    }
    assert_eq!(files, 1, "one place dispatches");
}

/// Bindings of 128 MiB, as core WebGPU has them, whatever this device has.
fn core() -> Option<Gpu> {
    open().map(|gpu| gpu.with_bindings_of(128 << 20))
}

fn is_limit<T: std::fmt::Debug>(result: raycell::Result<T>, bytes: u64) {
    let Err(Error::Limit { need, have, limit, .. }) = result else { panic!("{result:?}") };
    assert_eq!((need, limit), (bytes, "max_storage_buffer_binding_size"));
    assert!(have < need);
}

#[test]
fn h03_a_binding_of_128_mib_fits_and_one_element_more_is_refused() {
    let Some(gpu) = core() else { return };
    let n = known("LIM-DENSE-N-128MiB") as usize;
    gpu.alloc::<f32>("dense", n * n).unwrap();
    is_limit(gpu.alloc::<f32>("dense", (n + 1) * (n + 1)).map(drop), 4 * (n as u64 + 1).pow(2));
    for (fits, bytes) in [(known("LIM-BIND-128MiB-F32") as usize, 4), (known("LIM-BIND-128MiB-VEC4") as usize, 16)] {
        gpu.alloc::<u8>("bytes", fits * bytes).unwrap();
        is_limit(gpu.alloc::<u8>("bytes", (fits + 1) * bytes).map(drop), ((fits + 1) * bytes) as u64);
    }
    // What is chunked instead of refused, the scene's records, gives the same bits: more of it in paging.rs.
    let paged = Arc::new(gpu.with_paged_scenes());
    let Some(whole) = crate::common::gpu() else { return };
    assert!(saved(&baked(&paged, &room(1.0), &quick())) == saved(&baked(&whole, &room(1.0), &quick())));
}

/// Sizes are counted in 64 bits: 4 N^2 is 2^32, 0 in 32 bits, at N = 32,768. Nothing is allocated.
#[test]
fn h04_plans_beyond_4_gib_are_refused_with_their_true_size() {
    let Some(gpu) = core() else { return };
    let before = gpu.device_bytes();
    let (fits, wraps) = (known("LIM-DENSE-N-256MiB") as usize, known("LIM-DENSE-N-U32WRAP") as usize);
    for (n, bytes) in [(fits, 1 << 28), (wraps, 1 << 32), (65_536, 1 << 34), (1 << 30, 1 << 62)] {
        is_limit(gpu.alloc::<f32>("dense", n * n).map(drop), bytes);
    }
    is_limit(gpu.alloc::<f32>("dense", usize::MAX).map(drop), u64::MAX);
    assert_eq!(gpu.device_bytes(), before);
    // The dense method refuses as many patches before it begins.
    let params = Params { method: raycell::Method::Fem, patches: 65_536, ..Params::default() };
    assert!(matches!(params.check(), Err(Error::InvalidParam { name: "patches", .. })));
}

#[test]
fn h05_nothing_at_all_still_binds() {
    let Some(gpu) = gpu() else { return };
    // No lights: all is black, and nothing fails.
    let dark = room(0.0);
    let backend = Backend::Gpu(gpu.clone());
    let solution = baked(&gpu, &dark, &quick());
    let answers = solution.query(&backend, &places()).unwrap();
    assert_eq!(impossible(&answers, &dark, 0.0), None);
    assert!(answers.iter().all(|a| a.b == [0.0; 3] && a.h == [0.0; 3]));
    assert!(solution.query(&backend, &[]).unwrap().is_empty());
    // No points, no nodes, no cells.
    let geometry = Geometry::new(&dark).unwrap();
    let scene = SceneBuffers::new(&gpu, &geometry).unwrap();
    let none = gpu.upload::<Point>("points", &[]).unwrap();
    assert!(pass::shoot::shoot(&gpu, &scene, &none, 1, 0, 4).unwrap().is_empty());
    assert!(pass::kernel::kernel(&gpu, &scene, &none).unwrap().is_empty());
    let tiles = gpu.upload("tiles", &tiles::starts(&geometry, &vec![0.0; geometry.tiles as usize], 0.5)).unwrap();
    assert!(pass::emit::emit(&gpu, &scene, &tiles, 1, 0, 0, 1).unwrap().is_empty());
    gpu.check_finished().unwrap();
}

/// What the sentinel reads where a driver ends loops early, and a kernel that says so itself. On drivers without such a
/// budget the counts are right.
#[test]
fn h06_a_loop_that_was_cut_is_told_by_name() {
    let Some(gpu) = open() else { return };
    sentinel::check_trips(&gpu, sentinel::LOOP_BUDGET).unwrap();
    match sentinel::check_trips(&gpu, 70_000) {
        Ok(()) => assert_eq!(sentinel::count(&gpu, 64, 70_000, LIGHT).unwrap(), Counts::expected(64, 70_000)),
        Err(Error::Unfinished { kernel, why }) => {
            assert_eq!(kernel, "sentinel");
            assert!(why.contains(&format!("trips: {}", 192u32.wrapping_mul(70_000))), "{why}");
            eprintln!("this driver cuts loops: {why}");
        }
        Err(other) => panic!("{other}"),
    }
    // `gather` with nine times the hits that its pass allows a dispatch.
    let hits = 70_000;
    let front = Point { tri: 0, tile: 0, kind: kind::BACK, weight: 1.0, ..Point::default() };
    let scene = SceneBuffers::new(&gpu, &Geometry::new(&room(1.0)).unwrap()).unwrap();
    let device_hits = gpu.upload("hits", &vec![front; hits]).unwrap();
    let out = gpu.alloc::<[f32; 4]>("gathered", 2).unwrap();
    let (dark, none) = (gpu.alloc::<[f32; 4]>("dark", 0).unwrap(), gpu.alloc::<DirectSum>("none", 0).unwrap());
    use Access::{Read, Scene, Write};
    let kernel = Kernel::new("gather", &[Scene, Read, Read, Read, Read, Write, Write]);
    let params = pass::gather::Params { flag: gpu.flag(&kernel), rays: hits as u32, end: hits as u32, ..Default::default() };
    let status = gpu.status().into();
    let buffers =
        [scene.tris.bound(), scene.materials.bound(), device_hits.bound(), dark.bound(), none.bound(), out.bound(), status];
    gpu.run(&kernel, &params, &buffers, 1, LIGHT).unwrap();
    match gpu.check_finished() {
        Ok(()) => assert!((gpu.read(&out).unwrap()[1][1] - 1.0).abs() < 1e-3, "every hit is a back"),
        Err(e) => assert!(matches!(e, Error::Unfinished { kernel: "gather", .. }), "{e}"),
    }
    // Said once; the next run is judged afresh.
    gpu.check_finished().unwrap();
}

/// A sabotaged driver: each of the sentinel's counts is wrong in turn.
#[test]
fn h06_every_wrong_count_of_the_sentinel_is_told() {
    let right = Counts::expected(192, sentinel::LOOP_BUDGET);
    sentinel::judge(right, right).unwrap();
    for wrong in [
        Counts { sum: right.sum - 0xC000_0000, ..right },
        Counts { trips: right.trips - 1, ..right },
        Counts { items: right.items - 64, ..right },
        Counts { index_sum: right.index_sum + 1, ..right },
    ] {
        let e = sentinel::judge(wrong, right).unwrap_err();
        assert!(matches!(e, Error::Unfinished { kernel: "sentinel", .. }), "{e}");
        assert!(e.to_string().contains("--backend cpu"), "{e}");
    }
}

/// Four million rays, every dispatch of which is timed, and a whole bake likewise. Adaptive cuts aim at 30 ms; the
/// bound is what Windows grants.
#[test]
fn h07_no_dispatch_is_long() {
    let Some(gpu) = open() else { return };
    gpu.measure_dispatches();
    let geometry = Geometry::new(&Scene::load(root("scenes/city/scene.obj")).unwrap()).unwrap();
    let scene = SceneBuffers::new(&gpu, &geometry).unwrap();
    let tiles = gpu.upload("tiles", &tiles::starts(&geometry, &vec![1.0; geometry.tiles as usize], 0.5)).unwrap();
    let rays = 1 << 20;
    let points = pass::emit::emit(&gpu, &scene, &tiles, 3, 0, rays, rays).unwrap();
    assert_eq!(points.len(), 2 * rays as usize);
    gpu.check_finished().unwrap();
    let gpu = Arc::new(gpu);
    baked(&gpu, &Scene::load(root("scenes/cornell/scene.obj")).unwrap(), &Params { rays: 65_536, ..Params::default() });
    let longest = gpu.longest_dispatches();
    for (name, seconds) in &longest {
        eprintln!("{name}: longest dispatch {:.1} ms", 1e3 * seconds);
    }
    assert!(longest.len() > 10 && longest["emit"] > 0.0);
    assert!(longest.values().all(|&s| s < 2.0), "{longest:?}");
}

#[test]
fn h08_a_device_lost_between_stages_is_an_error_and_a_new_one_gives_the_same_bits() {
    let Some(whole) = gpu() else { return };
    let scene = room(1.0);
    let straight = saved(&baked(&whole, &scene, &quick()));
    for stage in ["pilot", "train", "coefficients", "solve"] {
        let open = device::open(device::BackendChoice::Auto, None).unwrap();
        let gpu = Arc::new(Gpu::new(&open.device, &open.queue).unwrap());
        let mut kept = Checkpoint::default();
        let lost = bake_from(&Backend::Gpu(gpu), &scene, &quick(), &mut kept, &mut |event| {
            if matches!(event, Event::Stage { name } if *name == stage) {
                open.device.destroy();
            }
            Flow::Continue
        });
        assert!(matches!(lost, Err(Error::DeviceLost { .. })), "{stage}: {:?}", lost.err());
        // A new context from the beginning, and from what the lost one leaves.
        let open = device::open(device::BackendChoice::Auto, None).unwrap();
        let backend = Backend::Gpu(Arc::new(Gpu::new(&open.device, &open.queue).unwrap()));
        let resumed = bake_from(&backend, &scene, &quick(), &mut kept, &mut |_| Flow::Continue).unwrap();
        assert!(saved(&resumed) == straight, "{stage}");
        if stage == "solve" {
            let anew = bake(&backend, &scene, &quick(), &mut |_| Flow::Continue).unwrap();
            assert!(saved(&anew) == straight);
        }
    }
}

/// Private arrays stay small (4 KiB: larger ones have lost whole devices in drivers), and a pipeline that cannot be
/// made is an error that leaves the device as it was.
#[test]
fn h09_a_pipeline_that_fails_is_an_error() {
    for (kernel, _) in KERNELS {
        for paged in [false, true] {
            let module = naga::front::wgsl::parse_str(&wgsl::compose(kernel, Text { paged, grey: false }).source).unwrap();
            let mut layouter = naga::proc::Layouter::default();
            layouter.update(module.to_ctx()).unwrap();
            let locals = module.functions.iter().map(|f| f.1).chain(module.entry_points.iter().map(|e| &e.function));
            let locals = locals.flat_map(|f| f.local_variables.iter().map(|(_, v)| v.ty));
            let private = module.global_variables.iter().filter(|(_, v)| v.space == naga::AddressSpace::Private);
            let bytes: u32 = private.map(|(_, v)| v.ty).chain(locals).map(|ty| layouter[ty].size).sum();
            assert!(bytes <= 4096, "{kernel}: {bytes} bytes of private memory");
        }
    }
    // A device of its own: the others' may have made it already.
    let Some(gpu) = open() else { return };
    // A kernel whose bindings are told wrongly, as good a refusal as any.
    let wrong = Kernel::new("readout", &[Access::Write]);
    let e = gpu.pipeline(&wrong).unwrap_err();
    assert!(matches!(&e, Error::Device { stage, .. } if stage.contains("readout")), "{e}");
    assert_eq!(sentinel::count(&gpu, 1000, 3, LIGHT).unwrap(), Counts::expected(1000, 3));
}

/// NaN and infinities come back from the device as they were, and no output holds one: they are looked for on the host.
#[test]
fn h10_what_is_no_number_is_detected() {
    let Some(gpu) = gpu() else { return };
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0xffc0_0001), 1.0];
    let back = gpu.read(&gpu.upload("odd", &odd).unwrap()).unwrap();
    assert!(back.iter().zip(&odd).all(|(a, b)| a.to_bits() == b.to_bits()));
    assert_eq!(back.iter().filter(|x| !x.is_finite()).count(), 4);
    // No kernel asks `x != x`, which may be false for NaN.
    for (kernel, _) in KERNELS {
        let text = wgsl::compose(kernel, Text::default()).source;
        let code = text.lines().map(|l| l.split("//").next().unwrap_or_default());
        for line in code.filter(|l| l.contains("!=")) {
            let side = |s: &str| s.trim_matches(|c: char| !c.is_alphanumeric() && c != '_' && c != '.').to_string();
            for pair in line.split(' ').collect::<Vec<_>>().windows(3).filter(|w| w[1] == "!=") {
                assert_ne!(side(pair[0]), side(pair[2]), "{kernel}: {line}");
            }
        }
    }
    // Nor is one let in with a scene.
    let mut scene = room(1.0);
    scene.vertices[0][1] = f64::NAN;
    let refused = bake(&Backend::Gpu(gpu.clone()), &scene, &quick(), &mut |_| Flow::Continue);
    assert!(matches!(refused, Err(Error::InvalidVertex { index: 0, .. })));
}

/// Light of 1e-39 and 1e-40 W/m², subnormal in single precision, is the same light scaled: to the bit where the
/// factor is a power of two.
#[test]
fn h11_subnormal_light_is_right() {
    let Some(gpu) = gpu() else { return };
    let backend = Backend::Gpu(gpu.clone());
    let answers = |emission: f64| {
        let scene = room(emission);
        let answers = baked(&gpu, &scene, &quick()).query(&backend, &places()).unwrap();
        assert_eq!(impossible(&answers, &scene, 0.1), None);
        answers
    };
    let usual = answers(1.0);
    for scale in [2f64.powi(-130), 2f64.powi(-133), 2f64.powi(-200), 2f64.powi(100)] {
        for (a, b) in usual.iter().zip(answers(scale)) {
            assert_eq!(a.b.map(|x| x * scale), b.b, "{scale}");
        }
    }
    for emission in [1e-39, 1e-40] {
        for (a, b) in usual.iter().zip(answers(emission)) {
            for k in 0..3 {
                assert!((b.b[k] / emission - a.b[k]).abs() <= 1e-3 * a.b[k], "{emission}: {:?} {:?}", a.b, b.b);
            }
        }
    }
}

/// Directions of the kernels' own polynomials: rays from a lone triangle all escape, and tell theirs.
#[test]
fn h12_cosine_directions_have_their_moments() {
    let Some(gpu) = gpu() else { return };
    let floor = [([[0.0, 0.0, 0.0], [1.0, 0.2, 0.1], [0.1, 1.0, -0.3]], 0)];
    let scene = Scene::from_triangles("floor", &floor, vec![Material::new("white", [0.5; 3], [1.0; 3])]).unwrap();
    let geometry = Geometry::new(&scene).unwrap();
    let buffers = SceneBuffers::new(&gpu, &geometry).unwrap();
    let tiles = gpu.upload("tiles", &tiles::starts(&geometry, &vec![1.0; geometry.tiles as usize], 0.5)).unwrap();
    let n = 1 << 18;
    let points = gpu.read(&pass::emit::emit(&gpu, &buffers, &tiles, 7, 0, n, n).unwrap()).unwrap();
    gpu.check_finished().unwrap();
    let normal = DVec3::from(geometry.tris[0].normal.map(f64::from));
    let (mut one, mut two, mut longest) = (0.0, 0.0, 0f64);
    for ray in points.chunks_exact(2) {
        assert_eq!(ray[1].kind, kind::SKY);
        let d = DVec3::from(ray[1].p.map(f64::from));
        longest = longest.max((d.length() - 1.0).abs());
        one += d.dot(normal);
        two += d.dot(normal).powi(2);
    }
    let n = f64::from(n);
    // Variances of cos and cos^2 under the cosine's own density: 1/18 and 1/12.
    assert!((one / n - 2.0 / 3.0).abs() < 5.0 * (1.0 / 18.0 / n).sqrt(), "{}", one / n);
    assert!((two / n - 0.5).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(), "{}", two / n);
    assert!(longest < 1e-6, "{longest}");
}

/// Guards behind and between what kernels write keep their poison.
#[test]
fn h13_guards_are_untouched() {
    let Some(gpu) = gpu() else { return };
    let geometry = Geometry::new(&room(1.0)).unwrap();
    let scene = SceneBuffers::new(&gpu, &geometry).unwrap();
    let mut places = tiles::places(&geometry, 5);
    places.truncate(1_001);
    let points = gpu.upload("points", &places).unwrap();

    // `shoot` writes as many hits as it was asked for: raw, into a longer buffer.
    let poison = Point { p: [-7.0; 3], tri: 0xdead, tile: 0xbeef, kind: 77, weight: -7.0, density: -7.0 };
    let hits = gpu.upload("hits", &vec![poison; 4_300]).unwrap();
    use Access::{Read, Scene as Records, Write};
    let kernel = Kernel::new("shoot", &[Records, Records, Read, Write, Write]);
    let params = pass::shoot::Params { flag: gpu.flag(&kernel), seed: 3, rays: 4, ..Default::default() };
    let bound = [scene.nodes.bound(), scene.tris.bound(), points.bound(), hits.bound(), gpu.status().into()];
    let written = 4 * 1_001 - 3;
    gpu.run(&kernel, &params, &bound, written, HEAVY).unwrap();
    let got = gpu.read(&hits).unwrap();
    assert!(got[..written].iter().all(|p| *p != poison && p.kind <= kind::BACK), "all was written");
    assert!(got[written..].iter().all(|p| *p == poison), "and nothing beyond");

    // `direct` adds to the points listed, and to no other.
    let guard = DirectSum { sum: [-7.0; 3], rounds: 77, square: -7.0, ..Default::default() };
    let zeros = DirectSum::default();
    let listed: Vec<u32> = (0..1_001).filter(|i| i % 3 == 0).collect();
    let sums: Vec<DirectSum> = (0..1_100).map(|i| if i < 1_001 && i % 3 == 0 { zeros } else { guard }).collect();
    let (sums, active) = (gpu.upload("sums", &sums).unwrap(), gpu.upload("active", &listed).unwrap());
    let samples = Samples { emitter: 2, cosine: 1 };
    pass::direct::direct(&gpu, &scene, &points, &active, 1, 0, 3, samples, &sums).unwrap();
    for (i, sum) in gpu.read(&sums).unwrap().iter().enumerate() {
        let on_list = i < 1_001 && i % 3 == 0;
        assert!(if on_list { sum.rounds == 3 && sum.sum[0] >= 0.0 } else { *sum == guard }, "{i}: {sum:?}");
    }

    // Tiles and triangles that rays bring back lie within their tables.
    let uniform = tiles::starts(&geometry, &vec![1.0; geometry.tiles as usize], 0.5);
    let starts: &[Tile] = &uniform;
    let rays = pass::emit::emit(&gpu, &scene, &gpu.upload("tiles", starts).unwrap(), 1, 0, 5_003, 5_003).unwrap();
    for p in gpu.read(&rays).unwrap().iter().filter(|p| p.kind == kind::FRONT) {
        assert!(p.tile < geometry.tiles && geometry.tile_tri[p.tile as usize] == p.tri, "{p:?}");
    }
    gpu.check_finished().unwrap();
}

/// Coordinates that are no numbers, negative or far beyond: a tile's number stays in its triangle's range (the twin of
/// the kernels' clamp), and a query says that there is no surface.
#[test]
fn h14_bad_coordinates_are_flagged() {
    let scene = room(1.0);
    let geometry = Geometry::new(&scene).unwrap();
    for tri in &geometry.tris {
        let own = tri.first_tile..tri.first_tile + tri.split * tri.split;
        for a in [f32::NAN, -1.0, -1e20, 1e20, f32::INFINITY, 0.5, 1.0] {
            for b in [f32::NAN, -1.0, 1e20, f32::NEG_INFINITY, 0.25] {
                let tile = twin::trace::tile_of(false, tri, a, b);
                assert!(own.contains(&tile), "({a}, {b}): {tile} is not in {own:?}");
            }
        }
    }
    let Some(gpu) = gpu() else { return };
    let solution = baked(&gpu, &scene, &quick());
    let bad = [f64::NAN, f64::INFINITY, -1e20, 1e20, 4294967040.0, -4294967296.0];
    let mut asked: Vec<SurfacePoint> = bad.map(|x| SurfacePoint { p: [x, 0.0, 1.0], n: [0.0, 1.0, 0.0] }).into();
    asked.push(SurfacePoint { p: [1.0, 0.0, 1.0], n: [f64::NAN, 1.0, 0.0] });
    asked.push(places()[0]);
    let answers = solution.query(&Backend::Gpu(gpu), &asked).unwrap();
    let (good, flagged) = answers.split_last().unwrap();
    assert!(flagged.iter().all(|a| a.status == raycell::Status::OffSurface && a.b == [0.0; 3]), "{flagged:?}");
    assert!(good.status == raycell::Status::Ok && good.b[0] > 0.0);
    assert_eq!(impossible(&answers, &scene, 0.1), None);
}

/// Every text of every kernel, with every set of constants, is compiled by the driver; none holds a constant that is no
/// finite number, which would be refused.
#[test]
fn h15_every_variant_compiles() {
    for bad in ["const X: f32 = 1e39;", "const X = 1.0f / 0.0f;", "const X = sqrt(-1.0);"] {
        let module = naga::front::wgsl::parse_str(bad);
        let valid = module.map_err(|e| e.to_string()).and_then(|m| {
            let mut validator =
                naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&m).map(drop).map_err(|e| e.to_string())
        });
        assert!(valid.is_err(), "{bad}");
    }
    let Some(gpu) = gpu() else { return };
    let variants = pass::variants();
    assert!(variants.len() > 2 * KERNELS.len() - 10, "{}", variants.len());
    for kernel in &variants {
        gpu.pipeline(kernel).unwrap_or_else(|e| panic!("{} {:?} {:?}: {e}", kernel.name, kernel.constants, kernel.text));
    }
    let names: std::collections::BTreeSet<&str> = variants.iter().map(|k| k.name).collect();
    assert_eq!(names.len(), KERNELS.len());
}

/// Whether multiply-adds are fused or not, the kernel meets f64 within 1e-5, and its clamped mean over adjacent squares
/// is the known one.
#[test]
fn h16_kernels_meet_truths_whatever_is_fused() {
    let Some(gpu) = gpu() else { return };
    let faces = [
        shapes::quad([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]], 0),
        shapes::quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], 0),
    ];
    let scene = Scene::from_triangles("wedge", &faces.concat(), vec![Material::new("white", [0.5; 3], [1.0; 3])]).unwrap();
    let geometry = Geometry::new(&scene).unwrap();
    let side = |y: bool| -> Vec<u32> {
        (0..geometry.tris.len() as u32).filter(|&t| (geometry.tris[t as usize].normal[1].abs() > 0.5) == y).collect()
    };
    let (floor, wall) = (side(true), side(false));
    let n = 1 << 18;
    let mut pairs = Vec::with_capacity(2 * n);
    for i in 0..n as u32 {
        let u = twin::sobol::sobol4(i, 5);
        for (tris, a, b) in [(&floor, u[0], u[1]), (&wall, u[2], u[3])] {
            let (half, a) = ((a >> 31) as usize, unit(a << 1));
            let (b1, b2) = twin::trace::place_on(false, a, unit(b));
            pairs.push(twin::trace::surface_point(&geometry, tris[half], b1, b2));
        }
    }
    let buffers = SceneBuffers::new(&gpu, &geometry).unwrap();
    let values = gpu.read(&pass::kernel::kernel(&gpu, &buffers, &gpu.upload("pairs", &pairs).unwrap()).unwrap()).unwrap();
    gpu.check_finished().unwrap();
    let mut clamped = 0.0;
    for (pair, value) in pairs.chunks_exact(2).zip(&values) {
        let [x, y] = [pair[0], pair[1]].map(|p| DVec3::from(p.p.map(f64::from)));
        let [m, n] = [pair[0], pair[1]].map(|p| DVec3::from(geometry.tris[p.tri as usize].normal.map(f64::from)));
        let d = y - x;
        let g = (m.dot(d) * -n.dot(d)).max(0.0) / (std::f64::consts::PI * d.dot(d).powi(2));
        // Near the edge both cosines are differences of nearly equal numbers.
        let floor = 1e-5 + 4.0 * f64::from(f32::EPSILON) / d.length();
        assert!((f64::from(*value) - g).abs() <= floor * g + 1e-6, "{value} {g} at {}", d.length());
        clamped += (f64::from(*value) * geometry.scale.powi(2)).min(10.0);
    }
    // E[min(G, 10)] over uniform pairs of unit squares at a right angle; local lengths are twice as long.
    let (mean, truth) = (clamped / n as f64, known("SING-CLAMP-10"));
    assert!((mean - truth).abs() < 1e-3 * truth, "{mean} instead of {truth}");
}
