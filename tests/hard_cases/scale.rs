//! Scale: cases C of `docs/hard_cases.md`. Whole bakes and passes run on the GPU; where the twin decides, the test says so.

use super::setup::*;
use glam::{DVec3, Vec3};
use raycell::layout::{NONE, Point};
use raycell::pass::GpuEngine;
use raycell::scene::shapes::{Triangles, block, moved, quad, room, tetrahedron};
use raycell::scene::{Geometry, Material};
use raycell::twin::trace::{Ray, closest};
use raycell::{Answer, Direct, Method, Params, Scene, SurfacePoint};
use std::f64::consts::PI;

/// A room with a lamp and a block, all corners on the grid of 1/16.
fn furnished() -> Triangles {
    let lamp = quad([[0.375, 0.375, 0.9375], [0.375, 0.625, 0.9375], [0.625, 0.625, 0.9375], [0.625, 0.375, 0.9375]], 2);
    let block = block([0.25, 0.5, 0.0625], [0.5, 0.75, 0.5], 1);
    [room([0.0; 3], [1.0; 3], [0, 1, 0, 0, 0, 0]), block, lamp].concat()
}

fn paints(lamp: f64) -> Vec<Material> {
    let red = Material::new("red", [0.6, 0.2, 0.1], [0.0; 3]);
    vec![Material::new("white", [0.7; 3], [0.0; 3]), red, Material::new("lamp", [0.1; 3], [lamp, 0.8 * lamp, 0.5 * lamp])]
}

const SMALL: u32 = 2048;

fn few(direct: Direct) -> Params {
    Params { direct_samples: 512, gather_rays: 64, ..params(SMALL, direct) }
}

/// Every number of the answers, bit for bit; light divided by `unit`.
fn bits(answers: &[Answer], unit: f64) -> Vec<u64> {
    answers.iter().flat_map(|a| [a.b, a.h, a.d]).flatten().map(|x| (x / unit).to_bits()).collect()
}

/// What a bake of the furnished room answers after `to` has moved it; corners and points are moved alike.
fn furnished_bits(to: impl Fn([f64; 3]) -> [f64; 3] + Copy, direct: Direct) -> Option<Vec<u64>> {
    let gpu = gpu()?;
    let points: Vec<SurfacePoint> =
        scattered(&furnished(), 3, 1).into_iter().map(|p| SurfacePoint { p: to(p.p), n: p.n }).collect();
    let answers = lit(&gpu, &scene(&moved(furnished(), to), paints(10.0)), &few(direct), &points, 0.1);
    assert!(answers.iter().any(|a| a.b[0] > 0.0));
    Some(bits(&answers, 1.0))
}

/// The points lie on the grid's planes to the last bit of f64 only where the way there is exact: rounded to 2^-24.
fn grid(p: [f64; 3]) -> [f64; 3] {
    p.map(|x| (x * 16777216.0).round() / 16777216.0)
}

#[test]
fn c01_powers_of_two_change_no_bit() {
    let scaled = |k: i32| moved(furnished(), |p| p.map(|x| x * 2f64.powi(k)));
    let of = |k: i32| Geometry::new(&scene(&scaled(k), paints(10.0))).unwrap();
    let at_1 = of(0);
    for k in -20..=20 {
        let g = of(k);
        assert!(g.tris == at_1.tris && g.nodes == at_1.nodes && g.emitters == at_1.emitters && g.areas == at_1.areas, "{k}");
        assert_eq!(g.scale * 2f64.powi(k), at_1.scale);
    }
    // And whole bakes, in both modes.
    for (direct, powers) in [(Direct::Exact, &[-20, -7, 20][..]), (Direct::Network, &[13])] {
        let Some(want) = furnished_bits(|p| p, direct) else { return };
        for &k in powers {
            assert!(furnished_bits(|p| p.map(|x| x * 2f64.powi(k)), direct).unwrap() == want, "2^{k}");
        }
    }
}

#[test]
fn c01b_other_scales_change_the_last_digits_only() {
    let Some(gpu) = gpu() else { return };
    let at = |s: f64| {
        let t = moved(furnished(), |p| p.map(|x| x * s));
        let scene = scene(&t, paints(10.0));
        let geometry = Geometry::new(&scene).unwrap();
        let mut engine = GpuEngine::new(&gpu, &geometry).unwrap();
        // The same places of the same faces, whatever order the hierarchy brings them into.
        let order: Vec<u32> = (0..t.len() as u32).map(|f| geometry.source.iter().position(|&s| s == f).unwrap() as u32).collect();
        let mut dice = Dice(3);
        let places: Vec<(usize, DVec3)> = (0..20_000)
            .map(|_| {
                let f = dice.below(t.len());
                (f, DVec3::from(scattered(&furnished()[f..f + 1].to_vec(), 1, dice.roll())[0].p))
            })
            .collect();
        let pairs: Vec<Point> = places
            .iter()
            .map(|&(f, p)| {
                let p = DVec3::from(geometry.to_local((p * s).to_array())).as_vec3().to_array();
                Point { p, tri: order[f], ..Point::default() }
            })
            .collect();
        // G with the room's side for unit, and the pairs' distances.
        let unit = geometry.scale * s;
        let g: Vec<[f64; 2]> = kernel(&mut engine, &pairs)
            .iter()
            .zip(places.chunks_exact(2))
            .map(|(&g, p)| [f64::from(g) * unit * unit, p[0].1.distance(p[1].1)])
            .collect();
        let points: Vec<SurfacePoint> =
            scattered(&furnished(), 3, 1).into_iter().map(|p| SurfacePoint { p: p.p.map(|x| x * s), n: p.n }).collect();
        (g, lit(&gpu, &scene, &few(Direct::Exact), &points, 0.1))
    };
    let (g1, b1) = at(1.0);
    for s in [1e-6, 1e-3, 1e3, 1e6] {
        let (g, b) = at(s);
        // The deterministic path: 1e-5, and what places rounded by 1e-6 do at the distance r; at small cosines 1e-6/(pi r^2).
        // A pair that grazes an edge may be seen in one and not in the other.
        let apart =
            |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() > (1e-5 + 1e-6 / a[1]) * a[0].max(b[0]) + 1e-6 / (PI * a[1] * a[1]);
        let differ = g1.iter().zip(&g).filter(|(a, b)| apart(**a, **b)).count();
        let seen = g.iter().filter(|g| g[0] > 0.0).count();
        // A bake is another draw of the same rays where a corner's rounding sends one to another cell.
        let error = rrmse(&super::common::radiosity(&b), &super::common::radiosity(&b1));
        eprintln!("scale {s:e}: {differ} of {seen} kernels differ, bakes are {error:.2e} apart");
        assert!(differ <= 1 && seen > g.len() / 20, "{s}: {differ} of {seen}");
        // As far apart as seeds, measured below 0.05 for so few rays.
        assert!(error < 0.08, "{s}: {error}");
    }
}

#[test]
fn c02_exact_translations_change_no_bit() {
    for direct in [Direct::Exact, Direct::Network] {
        let Some(want) = furnished_bits(grid, direct) else { return };
        for t in [10, 14, 17, 20] {
            let by = [2f64.powi(t), -2f64.powi(t), 2f64.powi(t - 1)];
            let to = |p: [f64; 3]| [0, 1, 2].map(|k| grid(p)[k] + by[k]);
            assert!(furnished_bits(to, direct).unwrap() == want, "2^{t}");
        }
    }
}

#[test]
fn c03_a_far_scene_in_single_precision_is_warned_of_and_stays_closed() {
    let Some(gpu) = gpu() else { return };
    for t in [1e4, 1e5, 1e6] {
        let by = [t + 0.37, -t - 0.11, 0.7 * t + 0.59];
        // Corners as a reader of single precision has them.
        let far = |p: [f64; 3]| [0, 1, 2].map(|k| f64::from((rotated(p)[k] + by[k]) as f32));
        let cube = moved(room([0.0; 3], [1.0; 3], [0, 1, 2, 0, 1, 2]), far);
        let kirchhoff = [0.3, 0.5, 0.8].map(|rho| grey(rho, 1.0 - rho)).to_vec();
        for (materials, want) in [(vec![grey(0.5, 1.0); 3], 2.0), (kirchhoff, 1.0)] {
            let scene = scene(&cube, materials);
            let solution = solve(&gpu, &scene, &by_nodes(SMALL));
            assert!(solution.report().warnings.iter().any(|w| w.contains("from the origin")), "{:?}", solution.report().warnings);
            let error = worst(&ask(&gpu, &solution, &middles(&cube), 5e-3), want);
            eprintln!("{t:e}: off by {error:.1e}");
            // At 1e6 f32 has steps of 1/16 of the side: no node speaks for some of the bent sides, and a gather's samples scatter.
            assert!(error < if t < 1e6 { 1e-3 } else { 5e-3 }, "{t}: {error}");
        }
    }
}

#[test]
fn c04_rotated_truths_stay() {
    let Some(gpu) = gpu() else { return };
    // Isothermal enclosures, by whole bakes; three times the tolerance of the axes' own frame.
    let cube = moved(room([0.0; 3], [1.0, 2.0, 0.7], [0, 1, 2, 3, 0, 1]), rotated);
    let materials = [0.1, 0.5, 0.8, 0.95].map(|rho| grey(rho, 1.0 - rho)).to_vec();
    for params in [by_nodes(16_384), params(16_384, Direct::Exact)] {
        let direct = params.direct;
        let answers = lit(&gpu, &scene(&cube, materials.clone()), &params, &scattered(&cube, 4, 2), 0.05);
        let (error, off) = (worst(&answers, 1.0), (mean(&answers) - 1.0).abs());
        eprintln!("rotated box, {direct:?}: off by {error:.1e}, {off:.1e} in the mean");
        assert!(off < 3e-3, "{direct:?}: {off}");
        // Exact direct light has the scatter of its samples.
        assert!(error < if direct == Direct::Network { 3e-3 } else { 0.05 }, "{direct:?}: {error}");
    }
    // A tetrahedron's sides see each other alike; its rows sum to 1.
    let t = moved(tetrahedron(), rotated);
    let g = Geometry::new(&scene(&t, vec![grey(0.5, 1.0); 4])).unwrap();
    let rays = uniform_rays(&gpu, &g, 1 << 17);
    let met = |i: u32, j: u32| rays.iter().filter(|r| **r == Some([i, j])).count() as f64;
    assert!(rays.iter().all(Option::is_some));
    for i in 0..4 {
        let all: f64 = (0..4).map(|j| met(i, j)).sum();
        for j in (0..4).filter(|&j| j != i) {
            let (f, sigma) = (met(i, j) / all, (2.0 / 9.0 / all).sqrt());
            assert!((f - 1.0 / 3.0).abs() < 5.0 * sigma, "{i} {j}: {f}");
        }
    }
    // Squares with a common edge.
    let floor = quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], 0);
    let wall = quad([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]], 0);
    let g = Geometry::new(&scene(&moved([floor, wall].concat(), rotated), vec![grey(0.5, 1.0)])).unwrap();
    let rays = uniform_rays(&gpu, &g, 1 << 18);
    let (from, met) = rays.iter().fold((0.0, 0.0), |(n, m), r| (n + 1.0, m + f64::from(r.is_some() as u32)));
    let (f, want) = (met / from, known("FF3-PERP-90"));
    eprintln!("rotated squares: {f:.6}, is {want:.6}");
    assert!((f - want).abs() < 5.0 * (want * (1.0 - want) / from).sqrt(), "{f} {want}");
}

/// Uniform cosine rays by pass `emit`: the faces that each leaves and meets from the front, `None` where it meets nothing so.
fn uniform_rays(gpu: &raycell::gpu::Gpu, g: &Geometry, count: u32) -> Vec<Option<[u32; 2]>> {
    use raycell::engine::Engine;
    let tiles = raycell::network::tiles::starts(g, &vec![0.0; g.tiles as usize], 0.0);
    let mut engine = GpuEngine::new(gpu, g).unwrap();
    let batch = engine.emit(&tiles, 5, 0, count, count).unwrap();
    let face = |p: &Point| g.source[p.tri as usize];
    let ends = engine.points(&batch).unwrap();
    ends.chunks_exact(2).map(|r| (r[0].kind == raycell::layout::kind::FRONT).then(|| [face(&r[0]), face(&r[1])])).collect()
}

/// Mirrored at x = 0; the first two corners change places, so that the front stays the front and the passes add up the
/// same terms.
fn mirrored(t: &Triangles) -> Triangles {
    let flip = |p: [f64; 3]| [-p[0], p[1], p[2]];
    t.iter().map(|&([a, b, c], m)| ([flip(b), flip(a), flip(c)], m)).collect()
}

/// Rays, their hits and the kernel are mirrored to the last bit. A whole bake is not: the sampler's tangents and
/// barycentric coordinates know left from right, and a mirrored scene is another draw of the same estimator.
#[test]
fn c05_mirrored_rays_hit_bit_for_bit() {
    let Some(gpu) = gpu() else { return };
    let t = moved(furnished(), rotated);
    let [g, m] = [t.clone(), mirrored(&t)].map(|t| Geometry::new(&scene(&t, paints(10.0))).unwrap());
    let face = |g: &Geometry, f: u32| g.source.iter().position(|&s| s == f).unwrap() as u32;
    let faces: Vec<[u32; 2]> = (0..t.len() as u32).map(|f| [face(&g, f), face(&m, f)]).collect();
    let mut dice = Dice(11);
    let mut pairs = [Vec::new(), Vec::new()];
    for _ in 0..100_000 {
        let [a, b] = faces[dice.below(t.len())];
        let p = drawn(&g, a, &mut dice);
        pairs[0].push(p);
        pairs[1].push(Point { p: [-p.p[0], p.p[1], p.p[2]], tri: b, ..p });
    }
    // Pass `kernel`, on the device.
    let of = |g: &Geometry, pairs: &[Point]| kernel(&mut GpuEngine::new(&gpu, g).unwrap(), pairs);
    let (a, b) = (of(&g, &pairs[0]), of(&m, &pairs[1]));
    let seen = a.iter().filter(|g| **g > 0.0).count();
    assert!(a.iter().zip(&b).all(|(a, b)| a.to_bits() == b.to_bits()) && seen > a.len() / 20, "{seen} of {}", a.len());
    // Hits, by the twin: distance and barycentric coordinates (the mirrored triangle begins with the second corner).
    for ray in pairs[0].chunks_exact(2) {
        let (o, d) = (Vec3::from(ray[0].p), Vec3::from(ray[1].p) - Vec3::from(ray[0].p));
        let [one, other] = [(&g, Vec3::ONE, 0), (&m, Vec3::new(-1.0, 1.0, 1.0), 1)].map(|(g, flip, side)| {
            let from = faces.iter().find(|f| f[0] == ray[0].tri).unwrap()[side];
            let skip = [g.tris[from as usize].plane, NONE];
            closest(g, &Ray { origin: o * flip, direction: d * flip, t_max: f32::MAX, skip })
        });
        assert_eq!(one.t.to_bits(), other.t.to_bits());
        if one.tri != NONE && g.source[one.tri as usize] == m.source[other.tri as usize] {
            // Zeros have either sign.
            assert_eq!((one.b2 + 0.0).to_bits(), (other.b2 + 0.0).to_bits());
        }
    }
    // Bakes: no farther apart than seeds.
    let points = scattered(&t, 6, 4);
    let flip = |p: &SurfacePoint| SurfacePoint { p: [-p.p[0], p.p[1], p.p[2]], n: [-p.n[0], p.n[1], p.n[2]] };
    let bake = |t: &Triangles, points: &[SurfacePoint], seed| {
        let params = Params { seed, ..few(Direct::Exact) };
        super::common::radiosity(&lit(&gpu, &scene(t, paints(10.0)), &params, points, 0.1))
    };
    let [one, two] = [1, 2].map(|seed| bake(&t, &points, seed));
    let other = bake(&mirrored(&t), &points.iter().map(flip).collect::<Vec<_>>(), 1);
    let (seeds, apart) = (rrmse(&one, &two), rrmse(&one, &other));
    eprintln!("mirrored bakes {apart:.4} apart, seeds {seeds:.4}");
    // The scatter of one pair of seeds is known to a factor of two.
    assert!(apart < 2.0 * seeds, "{apart} {seeds}");
}

/// A unit cube's inside, its ceiling a frame around a square light of side `side`.
fn tiny_light(side: f64) -> Triangles {
    let (l, h) = (0.5 - 0.5 * side, 0.5 + 0.5 * side);
    let outer = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let inner = [[l, l], [l, h], [h, h], [h, l]];
    let up = |p: [f64; 2]| [p[0], p[1], 1.0];
    let mut t: Triangles = room([0.0; 3], [1.0; 3], [0; 6])[..10].to_vec();
    for k in 0..4 {
        let next = (k + 1) % 4;
        t.extend(quad([up(outer[k]), up(outer[next]), up(inner[next]), up(inner[k])], 0));
    }
    t.extend(quad(inner.map(up), 1));
    t
}

#[test]
fn c06_a_tiny_light_is_not_missed() {
    let Some(gpu) = gpu() else { return };
    let t = tiny_light(1e-6);
    let scene = scene(&t, vec![grey(0.5, 0.0), grey(0.0, 1.0)]);
    assert_eq!(Geometry::new(&scene).unwrap().emitters.len(), 2);
    let floor = SurfacePoint { p: [0.5, 0.5, 0.0], n: [0.0, 0.0, 1.0] };
    let points = [vec![floor], scattered(&t[..8].to_vec(), 4, 3)].concat();
    let answers = lit(&gpu, &scene, &few(Direct::Exact), &points, 0.1);
    let want = known("PT-TINYLIGHT");
    eprintln!("tiny light: {:e}, is {want:e}", answers[0].d[1]);
    assert!((answers[0].d[1] / want - 1.0).abs() < 1e-3, "{:e}", answers[0].d[1]);
    assert!(answers.iter().all(|a| a.h[1] > 0.0 && a.h[1] < 1e-11), "{answers:?}");
}

/// The unit sphere's inside in rings of 48, with a cap of half angle `alpha` of material 1 about its pole.
fn capped(alpha: f64) -> Triangles {
    const N: usize = 48;
    let mut rings = vec![alpha];
    // Rings that grow by at most a factor of six, so that slivers stay few.
    while *rings.last().unwrap() < 0.02 {
        rings.push(rings.last().unwrap() * 6.0);
    }
    let last = *rings.last().unwrap();
    rings.extend((1..24).map(|i| last + (PI - last) * i as f64 / 24.0));
    let at = |theta: f64, k: usize| {
        let phi = 2.0 * PI * (k % N) as f64 / N as f64;
        [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
    };
    let mut t = Triangles::new();
    for k in 0..N {
        // Flat where the ring lies, counter-clockwise seen from below.
        t.push(([[0.0, 0.0, alpha.cos()], at(alpha, k + 1), at(alpha, k)], 1));
        for r in rings.windows(2) {
            t.extend(quad([at(r[0], k), at(r[0], k + 1), at(r[1], k + 1), at(r[1], k)], 0));
        }
        let end = *rings.last().unwrap();
        t.push(([at(end, k), at(end, k + 1), [0.0, 0.0, -1.0]], 0));
    }
    t
}

/// The mean radiosity of the sphere outside its cap, by one point a triangle, weighted by their areas.
fn outside(scene: &Scene, answers: &[Answer]) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (i, a) in answers.iter().enumerate().filter(|(i, _)| scene.faces[*i].material == 0) {
        sum += scene.area(i) * a.b[1];
        area += scene.area(i);
    }
    sum / area
}

/// A capped sphere whose cap's emission `e` times its share of the area is as of a cap of a true sphere.
fn capped_scene(alpha: f64, rho: f64, e: f64, elsewhere: f64) -> (Triangles, Scene) {
    let t = capped(alpha);
    let areas = scene(&t, vec![grey(rho, 0.0); 2]);
    let area = |m: u32| (0..t.len()).filter(|&i| t[i].1 == m).map(|i| areas.area(i)).sum::<f64>();
    let share = area(1) / (area(0) + area(1));
    let truth = (0.5 * alpha).sin().powi(2);
    assert!((share / truth - 1.0).abs() < 0.05, "{share:e} {truth:e}");
    (t.clone(), scene(&t, vec![grey(rho, elsewhere), grey(rho, e * truth / share)]))
}

#[test]
fn c07_a_tiny_cap_lights_its_sphere() {
    let Some(gpu) = gpu() else { return };
    let (t, scene) = capped_scene(1e-6, 0.5, 1.0, 0.0);
    let answers = lit(&gpu, &scene, &params(16_384, Direct::Exact), &middles(&t), 0.1);
    let (got, want) = (outside(&scene, &answers), known("SPHERE-TINY"));
    eprintln!("tiny cap: {got:e}, is {want:e}, off by {:.1e}", got / want - 1.0);
    // 1e-4 is of the formula; here by 16,384 rays on a polyhedron of 48 sides.
    assert!((got / want - 1.0).abs() < 5e-3, "{got:e} {want:e}");
}

#[test]
fn c08_fifteen_decades_of_emission_keep_their_digits() {
    let Some(gpu) = gpu() else { return };
    // A cap of 1e-6 of the area, 1e9 bright, in a sphere of 1e-6.
    let (t, capped) = capped_scene(2e-3, 0.5, 1e9, 1e-6);
    let got = outside(&capped, &lit(&gpu, &capped, &params(16_384, Direct::Exact), &middles(&t), 0.1));
    let want = known("HDR-SPHERE");
    eprintln!("bright cap: {got}, is {want}, off by {:.1e}", got / want - 1.0);
    // 1e-3 is of the formula; here by 16,384 rays on a polyhedron of 48 sides.
    assert!((got / want - 1.0).abs() < 5e-3, "{got}");

    // Two closed rooms that see nothing of each other. The second pair's dim room needs many more sweeps.
    for (rho_bright, rho_dim) in [(0.5, 0.5), (0.1, 0.9)] {
        let bright = room([0.0; 3], [1.0; 3], [0; 6]);
        let dim = room([2.0, 0.0, 0.0], [3.0, 1.0, 1.0], [1; 6]);
        let materials = vec![grey(rho_bright, 1e9), grey(rho_dim, 1e-6)];
        let scene = scene(&[bright.clone(), dim.clone()].concat(), materials);
        let solution = solve(&gpu, &scene, &params(32_768, Direct::Exact));
        for (t, want) in [(bright, 1e9 / (1.0 - rho_bright)), (dim, 1e-6 / (1.0 - rho_dim))] {
            let answers = ask(&gpu, &solution, &scattered(&t, 8, 5), 0.1);
            let (off, error) = (mean(&answers) / want - 1.0, worst(&answers, want));
            eprintln!("room of {want:e}: off by {off:+.1e} in the mean, {error:.1e} at most");
            // 1e-3 in the mean for rho = .5; a furnace of .9 multiplies the rays' scatter by ten.
            assert!(off.abs() < if want == 1e-6 / (1.0 - 0.9) { 5e-3 } else { 1e-3 }, "{want:e}: {off}");
            assert!(error < 0.05, "{want:e}: {error}");
        }
    }
}

#[test]
fn c09_light_is_linear() {
    let Some(gpu) = gpu() else { return };
    // Powers of two change no bit.
    let t = furnished();
    let of = |k: i32| {
        let unit = 2f64.powi(k);
        bits(&lit(&gpu, &scene(&t, paints(10.0 * unit)), &few(Direct::Exact), &scattered(&t, 3, 1), 0.1), unit)
    };
    let at_1 = of(0);
    for k in [-30, 7, 60] {
        assert!(of(k) == at_1, "2^{k}");
    }
    // Two lights, together and each alone. Finite elements have the same form factors for every light; the network's rays go
    // where the light is, so that its sum is another draw (below).
    let lights = |a: f64, b: f64| {
        let mut t = furnished();
        t.extend(quad([[0.0625, 0.25, 0.25], [0.0625, 0.75, 0.25], [0.0625, 0.75, 0.5], [0.0625, 0.25, 0.5]], 3));
        scene(&t, [paints(a), vec![grey(0.3, b)]].concat())
    };
    let points = scattered(&furnished(), 4, 6);
    let fem = Params { method: Method::Fem, patches: 300, gather_rays: 0, tolerance: 1e-9, ..few(Direct::Network) };
    for (params, limit) in [(fem, 1e-5), (few(Direct::Exact), 0.08)] {
        let [one, other, both] =
            [(10.0, 0.0), (0.0, 3.0), (10.0, 3.0)].map(|(a, b)| lit(&gpu, &lights(a, b), &params, &points, 0.1));
        let sum: Vec<[f64; 3]> = one.iter().zip(&other).map(|(a, b)| [0, 1, 2].map(|k| a.b[k] + b.b[k])).collect();
        let apart = rrmse(&sum, &super::common::radiosity(&both));
        eprintln!("{:?}: the sum of both lights is {apart:.1e} off", params.method);
        assert!(apart < limit, "{:?}: {apart}", params.method);
    }
}

#[test]
fn c10_a_box_of_a_metre_in_a_room_of_a_thousand_kilometres() {
    let Some(gpu) = gpu() else { return };
    let side = 1e6;
    let (low, high) = ([0.5 * side - 0.5, 0.5 * side - 0.5, 0.0], [0.5 * side + 0.5, 0.5 * side + 0.5, 1.0]);
    let block = block(low, high, 0);
    let t = [room([0.0; 3], [side; 3], [0; 6]), block.clone()].concat();
    {
        let rho = 0.5;
        let scene = scene(&t, vec![grey(rho, 1.0)]);
        // No node speaks for the box's sides: enough samples for a scatter of some 3e-4.
        let params = Params { direct_tolerance: 3e-4, direct_samples: 65_536, gather_rays: 65_536, ..by_nodes(SMALL) };
        let solution = solve(&gpu, &scene, &params);
        let want = 1.0 / (1.0 - rho);
        for (what, t) in [("room", t[..12].to_vec()), ("box", block.iter().filter(|t| normal(t.0).z > -0.5).copied().collect())] {
            let points: Vec<SurfacePoint> = scattered(&t, 1, 9);
            let answers = ask(&gpu, &solution, &points, 2e-3);
            let error = worst(&answers, want);
            eprintln!("{what}, rho {rho}: off by {error:.1e}");
            assert!(error < 1e-3, "{what} {rho}: {error}");
        }
    }
    // The box is there: a ray aimed at it from the ceiling meets it (the twin).
    let g = Geometry::new(&scene(&t, vec![grey(0.5, 1.0)])).unwrap();
    let from = DVec3::from(g.to_local([0.5 * side, 0.5 * side, side])).as_vec3();
    let to = DVec3::from(g.to_local([0.5 * side, 0.5 * side, 0.0])).as_vec3();
    let hit = closest(&g, &Ray { origin: from, direction: to - from, t_max: f32::MAX, skip: [NONE; 2] });
    assert!(g.source[hit.tri as usize] >= 12, "{hit:?}");
}
