//! Network: cases F of `docs/hard_cases.md`.

use super::common::{gpu, impossible, known, root};
use raycell::layout::{CellOutput, Link, NodeLight, Plane, Point, ResponseSums, Sample, kind};
use raycell::network::complex::Complex;
use raycell::network::supervised::{Goal, Output, Settings, Supervised};
use raycell::network::tiles::starts;
use raycell::params::PaperParams;
use raycell::pass;
use raycell::scene::{Geometry, Material, shapes};
use raycell::twin::fixed::{FEATURE_UNIT, encode};
use raycell::twin::jacobi::{System, jacobi};
use raycell::twin::math::{hash, unit};
use raycell::twin::respond::{Host, Net, respond};
use raycell::twin::winner::Feature;
use raycell::twin::{self, sobol::sobol4};
use raycell::{Backend, Direct, Error, Flow, Mode, Params, Scene, SurfacePoint, bake};
use std::f64::consts::PI;

/// A point of feature space with one component that is not 0.
fn at(x: f64) -> Feature {
    std::array::from_fn(|k| if k == 0 { x as f32 } else { 0.0 })
}

fn output(value: f64, width: f64) -> CellOutput {
    CellOutput { value: value as f32, width: width as f32, ..CellOutput::default() }
}

/// Answers of a normalised network whose cells are all neighbours, by the twin and, where there is a device, by the kernel.
fn answers(cells: &[Feature], outputs: &[CellOutput], inputs: &[Feature]) -> Vec<Vec<f32>> {
    let n = cells.len() as u32;
    let offsets: Vec<u32> = (0..=n).map(|c| c * (n - 1)).collect();
    let neighbours: Vec<u32> = (0..n).flat_map(|c| (0..n).filter(move |&d| d != c)).collect();
    let net = Net { cells, outputs, offsets: &offsets, neighbours: &neighbours, linear: false };
    let winners = twin::winner::winner(inputs, cells);
    let asked: Vec<Sample> = winners.iter().map(|&winner| Sample { winner, weight: 1.0, ..Sample::default() }).collect();
    let mut samples = asked.clone();
    respond(net, inputs, &mut samples);
    let mut all = vec![samples.iter().map(|s| s.output).collect()];
    if let Some(gpu) = gpu() {
        let (device_inputs, device_samples) = (gpu.upload("inputs", inputs).unwrap(), gpu.upload("samples", &asked).unwrap());
        pass::respond::respond(&gpu, net, &device_inputs, &device_samples).unwrap();
        all.push(gpu.read_finished(&device_samples, 0, inputs.len()).unwrap().iter().map(|s| s.output).collect());
    }
    all
}

/// A function of places in the unit square, drawn from some of them.
struct Square {
    machine: Host,
    place: fn([f32; 2]) -> [f32; 2],
    value: fn([f32; 2]) -> f32,
}

impl Square {
    fn new(place: fn([f32; 2]) -> [f32; 2], value: fn([f32; 2]) -> f32) -> Square {
        Square { machine: Host, place, value }
    }
}

fn feature([x, y]: [f32; 2]) -> Feature {
    std::array::from_fn(|k| [x, y].get(k).copied().unwrap_or(0.0))
}

impl Goal for Square {
    type Place = [f32; 2];
    type Machine = Host;

    fn machine(&mut self) -> &mut Host {
        &mut self.machine
    }
    fn draw(&mut self, first: u64, count: usize) -> Vec<[f32; 2]> {
        let place = |i: usize| {
            let u = sobol4(first as u32 + i as u32, 7);
            (self.place)([unit(u[0]), unit(u[1])])
        };
        (0..count).map(place).collect()
    }
    fn input(&self, place: &[f32; 2]) -> Feature {
        feature(*place)
    }
    fn evaluate(&mut self, places: &[[f32; 2]]) -> raycell::Result<Vec<f32>> {
        Ok(places.iter().map(|&p| (self.value)(p)).collect())
    }
}

fn settings(cells: usize) -> Settings {
    Settings { k: 2, dims: 2, cells, evaluations: 32 * cells as u64, ..Settings::default() }
}

#[test]
fn f01_cells_in_one_place_answer_their_mean() {
    let (w1, w2) = (0.25, 0.75);
    for width in [1.0, 1e-3, 1e-12] {
        for got in answers(&[at(0.5); 2], &[output(w1, width), output(w2, width)], &[at(0.5)]) {
            assert!((f64::from(got[0]) - 0.5 * (w1 + w2)).abs() < 1e-6, "width {width}: {got:?}");
        }
    }
    // All inputs in one place: all edges shrink to nothing, and widths must not follow.
    for k in 1..=4 {
        let mut goal = Square::new(|_| [0.3, 0.6], |_| 0.5);
        let s = Settings { k, ..settings(16) };
        let (net, _) = Supervised::train(&mut goal, &s).unwrap();
        assert!(net.outputs.iter().all(|o| o.width > 0.0 && o.width.is_finite()), "k {k}");
        let got = net.answer(&mut Host, &s, &[feature([0.3, 0.6]), feature([0.9, 0.9])]).unwrap();
        assert!(got.iter().all(|x| x.is_finite()) && (got[0] - 0.5).abs() < 1e-2, "k {k}: {got:?}");
    }
}

#[test]
fn f02_one_cell_answers_its_value_everywhere() {
    let places: Vec<Feature> = [0.0, 1e-3, 0.5, 1.0, 1e3, 1e15].map(at).to_vec();
    for w in [0.1f32, -0.7, 1.0 / 3.0] {
        for got in answers(&[at(0.5)], &[output(w.into(), 0.01)], &places) {
            assert!(got.iter().all(|x| x.to_bits() == w.to_bits()), "{w}: {got:?}");
        }
    }
    // Nor does the smallest complex stumble over what it has no neighbours for.
    for k in 1..=4 {
        let net = Supervised::start(&Settings { k, ..settings(k + 1) }, &[]);
        assert_eq!(net.cells.len(), k + 1);
        assert!(net.outputs.iter().all(|o| o.width > 0.0 && o.width.is_finite()), "k {k}");
    }
}

#[test]
fn f03_nothing_to_learn_is_not_learned() {
    let (net, samples) = Supervised::train(&mut Square::new(|p| p, |_| 0.0), &settings(64)).unwrap();
    assert!(!samples.places.is_empty() && net.cells.len() == 3, "{} cells of noise", net.cells.len());
    assert!(net.outputs.iter().all(|o| o.value.to_bits() == 0 && o.slope.iter().all(|s| s.to_bits() == 0)));
    let answers = net.answer(&mut Host, &settings(64), &[feature([0.1, 0.9]), feature([7.0, -3.0])]).unwrap();
    assert!(answers.iter().all(|a| a.to_bits() == 0), "{answers:?}");

    // Two plates back to back, a hand's breadth apart: b = e exactly, by either mode.
    let material = Material::new("shining", [0.5; 3], [1.0; 3]);
    let plate = |z: f64, up: bool| {
        let corners = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
        if up { shapes::quad(corners, 0) } else { shapes::flipped(shapes::quad(corners, 0)) }
    };
    let scene = Scene::from_triangles("plates", &[plate(0.1, true), plate(0.0, false)].concat(), vec![material]).unwrap();
    let points: Vec<SurfacePoint> = (0..16)
        .map(|i| {
            let up = i % 2 == 0;
            let p = [0.05 + 0.06 * f64::from(i), 0.4, if up { 0.1 } else { 0.0 }];
            SurfacePoint { p, n: [0.0, 0.0, if up { 1.0 } else { -1.0 }] }
        })
        .collect();
    for mode in [Mode::Flux, Mode::Paper] {
        for direct in [Direct::Network, Direct::Exact] {
            let params = Params { mode, direct, rays: 2048, ..Params::default() };
            let solution = bake(&Backend::Cpu, &scene, &params, &mut |_| Flow::Continue).unwrap();
            let answers = solution.query(&Backend::Cpu, &points).unwrap();
            assert_eq!(impossible(&answers, &scene, 0.0), None);
            assert!(
                answers.iter().all(|a| a.h == [0.0; 3] && a.b.iter().all(|b| (b / PI - 1.0).abs() < 1e-7)),
                "{mode:?} {direct:?}"
            );
            if mode == Mode::Paper {
                assert!(solution.report().cells <= 3, "{direct:?}: {} cells", solution.report().cells);
            }
        }
    }
}

#[test]
fn f04_far_from_all_cells_the_nearest_answers() {
    for sigma in ["0.01", "0.02"] {
        let width = sigma.parse::<f64>().unwrap();
        for (x, name) in [(0.5, "0.5"), (0.49, "0.49"), (0.499, "0.499")] {
            let want = known(&format!("NRBF-{sigma}-{name}"));
            // The case's Gaussians are exp(-d^2/(2 sigma^2)), the network's exp(-d^2/width^2).
            let outputs = [output(10.0, 2f64.sqrt() * width), output(20.0, 2f64.sqrt() * width)];
            for got in answers(&[at(0.0), at(1.0)], &outputs, &[at(x)]) {
                eprintln!("sigma {sigma}, x {name}: {} ({want})", got[0]);
                // The input itself is rounded: at .499 by 1.5e-8, which moves the exponent, 2 x / (2 sigma^2) and 10, by
                // 1e-4, and the answer, 10.00045, by 5e-9; at sigma .02, where the exponent is 2.5, by 1e-6.
                assert!((f64::from(got[0]) / want - 1.0).abs() < 1e-5, "sigma {sigma}, x {name}: {} {want}", got[0]);
            }
        }
    }
    // A hundred widths away, where every activation by itself is 0.
    for got in answers(&[at(0.0), at(1.0)], &[output(10.0, 1e-3), output(20.0, 1e-3)], &[at(-0.1), at(2.0)]) {
        assert_eq!(got, [10.0, 20.0]);
    }
}

#[test]
fn f05_the_complex_survives_random_insertions_and_deletions() {
    for k in 2..=4 {
        let mut state = k as u32;
        let mut random = |n: usize| {
            state = hash(state.wrapping_add(1));
            state as usize % n
        };
        let mut complex = Complex::simplex(k);
        let (mut refused, mut deleted) = (0, 0);
        for step in 0..10_000 {
            let cells = complex.cells();
            // In waves, so that it also shrinks to the least there can be.
            if random(if step / 500 % 2 == 0 { 3 } else { 12 }) < 2 {
                let q = random(cells) as u32;
                let near = complex.neighbours(q);
                complex.split(q, near[random(near.len())]);
            } else {
                let mut doomed = vec![false; cells];
                doomed[random(cells)] = true;
                match complex.delete(&doomed) {
                    Some(_) => deleted += 1,
                    None => refused += 1,
                }
            }
            complex.check().unwrap_or_else(|e| panic!("k {k}, step {step}: {e}"));
            assert!(complex.cells() > k, "k {k}, step {step}");
        }
        eprintln!("k {k}: {deleted} deletions, {refused} refused, {} cells left", complex.cells());
        assert!(deleted > 1_000 && refused > 10, "k {k}");
        // Down to the last simplex, and no farther.
        let mut left = 0;
        while left < 3 * complex.cells() {
            let mut doomed = vec![false; complex.cells()];
            doomed[random(complex.cells())] = true;
            left = if complex.delete(&doomed).is_some() { 0 } else { left + 1 };
        }
        complex.check().unwrap();
        assert!(complex.cells() > k);
        let (offsets, all) = complex.adjacency();
        let row = |c: u32| &all[offsets[c as usize] as usize..offsets[c as usize + 1] as usize];
        for c in 0..complex.cells() as u32 {
            assert!(row(c).iter().all(|&n| row(n).contains(&c)), "k {k}: adjacency of {c} is not symmetric");
        }
    }
}

#[test]
fn f06_duplicated_samples_weigh_twice_and_change_no_mean() {
    let cells: Vec<Feature> = (0..9u8).map(|i| feature([0.1 * f32::from(i), 0.5])).collect();
    let outputs: Vec<CellOutput> = (0..9u8).map(|i| output(0.1 * f64::from(i), 0.2)).collect();
    let offsets: Vec<u32> = (0..=9).map(|c| 2 * c).collect();
    let neighbours: Vec<u32> = (0..9).flat_map(|c| [(c + 1) % 9, (c + 8) % 9]).collect();
    let net = Net { cells: &cells, outputs: &outputs, offsets: &offsets, neighbours: &neighbours, linear: false };
    let inputs: Vec<Feature> = (0..500).map(|i| sobol4(i, 3)).map(|u| feature([unit(u[0]), unit(u[1])])).collect();
    let sums = |inputs: &[Feature]| {
        let winners = twin::winner::winner(inputs, &cells);
        let sample = |(i, winner)| Sample { winner, goal: unit(hash(i as u32 % 500)), weight: 1.5, ..Sample::default() };
        respond(net, inputs, &mut winners.into_iter().enumerate().map(sample).collect::<Vec<_>>())
    };
    let (once, twice) = (sums(&inputs), sums(&[inputs.clone(), inputs.clone()].concat()));
    for (a, b) in once.iter().zip(&twice) {
        // Sums are integers: they double to the bit, and every mean is what it was.
        assert_eq!((2 * a.gain.units(), 2 * a.activation.units()), (b.gain.units(), b.activation.units()));
        assert_eq!((2 * a.count.units(), 2 * a.error.units()), (b.count.units(), b.error.units()));
    }
    // One step of a doubled batch is two steps of n: 1 - exp(-2 n eta) = 1 - (1 - s)^2.
    let start = || Supervised::start(&settings(3), &[feature([0.0, 0.0]), feature([1.0, 0.0]), feature([0.0, 1.0])]);
    let batch = |n: i64, error: f64| -> Vec<ResponseSums> {
        let sum = |x: f64| raycell::layout::Fixed::from_units((x * n as f64 * f64::from(FEATURE_UNIT)) as i64);
        vec![ResponseSums { gain: sum(error), activation: sum(1.0), ..ResponseSums::default() }; 3]
    };
    let (mut doubled, mut stepped) = (start(), start());
    doubled.teach(&batch(2, 1.0), 0.1);
    stepped.teach(&batch(1, 1.0), 0.1);
    // The rule is damped by a twentieth, as if that much of every batch knew the answer already.
    let rest = 1.0 - 1.05 * f64::from(stepped.outputs[0].value);
    stepped.teach(&batch(1, rest), 0.1);
    assert!((doubled.outputs[0].value - stepped.outputs[0].value).abs() < 1e-6, "{:?} {:?}", doubled.outputs, stepped.outputs);
}

#[test]
fn f07_steps_contract_at_every_rate_that_is_taken() {
    // One cell, which alone answers. Its step is 1 - exp(-eta), damped by a twentieth of the mean activation: of two cells
    // one is active, so by 1.025. The rate that makes it .1:
    let eta = -(1.0 - 0.1 * 1.025f64).ln();
    let run = |eta: f64, steps: u32| {
        let mut net = Supervised::start(&Settings { k: 1, ..settings(2) }, &[]);
        net.cells = vec![at(0.0), at(1e3)];
        for output in &mut net.outputs {
            output.width = 1.0;
        }
        let (offsets, neighbours) = net.complex.adjacency();
        for _ in 0..steps {
            let mut samples = [Sample { winner: 0, goal: 1.0, weight: 1.0, ..Sample::default() }];
            let view =
                Net { cells: &net.cells, outputs: &net.outputs, offsets: &offsets, neighbours: &neighbours, linear: false };
            let sums = respond(view, &[at(0.0)], &mut samples);
            net.teach(&sums, eta);
        }
        1.0 - f64::from(net.outputs[0].value)
    };
    let (got, want) = (run(eta, 100), known("NET-LMS"));
    assert!((got - want).abs() < 1e-6, "{got} {want}");
    // No rate overshoots: the step never exceeds 1.
    for eta in [1e-3, 0.1, 1.0, 2.1, 1e3] {
        let left = [1, 2, 5, 50].map(|steps| run(eta, steps));
        assert!(left.iter().all(|x| (0.0..1.0).contains(x)) && left[3] < left[0], "{eta}: {left:?}");
    }
    // And what a user asks for is refused all the same.
    let params = Params { mode: Mode::Paper, paper: PaperParams { eta: 2.1, ..PaperParams::default() }, ..Params::default() };
    assert!(matches!(params.check(), Err(Error::InvalidParam { name: "eta", .. })), "{:?}", params.check());
}

#[test]
fn f08_counters_are_handed_on_and_fade_to_nothing() {
    let edge = |[x, y]: [f32; 2]| if x + 0.5 * y > 0.9 { 0.6 } else { 0.1 * y };
    let (mut net, _) = Supervised::train(&mut Square::new(|p| p, edge), &settings(64)).unwrap();
    let before: f64 = net.resource.iter().sum();
    net.insert(10_000);
    let after: f64 = net.resource.iter().sum();
    assert_eq!(net.cells.len(), 10_064);
    assert!((after / before - 1.0).abs() < 1e-5 && net.resource.iter().all(|r| *r >= 0.0), "{before} became {after}");
    net.complex.check().unwrap();

    // Decay: (1 - alpha)^n, through the subnormals to 0.
    let mut net = Supervised::start(&settings(3), &[]);
    net.resource = vec![1.0, 2.0, 3.0];
    let nothing = vec![ResponseSums::default(); 3];
    for n in 1..=1_000_000u32 {
        net.count(&nothing, 1.0 - 1e-3);
        if n == 10_000 {
            let want = 2.0 * (1.0 - 1e-3f64).powi(10_000);
            assert!((net.resource[1] / want - 1.0).abs() < 1e-5, "{} {want}", net.resource[1]);
        }
    }
    assert!(net.resource.iter().all(|r| (0.0..1e-300).contains(r)), "{:?}", net.resource);
    // Nothing is divided by what has faded: training goes on.
    let s = settings(16);
    let mut samples = Default::default();
    let mut goal = Square::new(|p| p, edge);
    while !net.epoch(&mut goal, &s, &mut samples).unwrap() {}
    assert!(
        net.cells.len() > 3
            && net.resource.iter().chain([&net.error(&mut goal, &s, 1 << 20, 256).unwrap()]).all(|x| x.is_finite())
    );
}

#[test]
fn f09_distances_are_differences_first() {
    // Two places 1e-4 apart, a thousand from the origin: recentred, they keep the digits that f32 has not there.
    let offset = 1e3;
    let room = shapes::moved(shapes::room([0.0; 3], [1.0; 3], [0; 6]), |p| p.map(|x| x + offset));
    let scene = Scene::from_triangles("far", &room, vec![Material::new("grey", [0.5; 3], [1.0; 3])]).unwrap();
    let g = Geometry::new(&scene).unwrap();
    let place = |x: f64| {
        let p = g.locate([offset + x, offset + 0.5, offset], [0.0, 0.0, 1.0]).expect("on the floor");
        Point { kind: kind::FRONT, p: p.p, tri: p.tri, ..Point::default() }
    };
    let input = |p: &Point| -> Feature { std::array::from_fn(|k| if k < 3 { p.p[k] / g.scale as f32 } else { 0.0 }) };
    let (c, x) = (input(&place(0.5)), input(&place(0.5 + 1e-4)));
    let run = |f: &Feature| {
        let points = [place(0.5)];
        let mut all = vec![twin::accumulate::accumulate(&points, &[*f], &[0], &[c])[0].distortion.value(FEATURE_UNIT)];
        if let Some(gpu) = gpu() {
            let (points, features) = (gpu.upload("points", &points).unwrap(), gpu.upload("features", &[*f]).unwrap());
            let (winners, cells) = (gpu.upload("winners", &[0u32]).unwrap(), gpu.upload("cells", &[c]).unwrap());
            let sums = pass::accumulate::accumulate(&gpu, &points, &features, &winners, 0..1, &cells).unwrap();
            all.push(gpu.read(&sums).unwrap()[0].distortion.value(FEATURE_UNIT));
        }
        all
    };
    for d2 in run(&x) {
        // One unit of the sums, 2^-32, is 2 % of 1e-8: resources are told no finer, distances are.
        assert!((d2 - 1e-8).abs() <= 1e-8 * 1e-3 + 2f64.powi(-32), "{d2}");
    }
    let exact: f64 = (0..3).map(|k| f64::from(x[k] - c[k]).powi(2)).sum();
    assert!((exact / 1e-8 - 1.0).abs() < 1e-3, "{exact}");
    assert!(run(&c).iter().all(|d2| d2.to_bits() == 0), "a place is 0 from itself");
    // By expansion x.x - 2 x.c + c.c it would be this far off, or negative; by differences nearest stays nearest.
    let shift = |f: &Feature, by: f32| -> Feature { std::array::from_fn(|k| if k < 13 { f[k] + by } else { 0.0 }) };
    let cells: Vec<Feature> = (0..64u8).map(|i| shift(&at(0.01 * f64::from(i)), 1e3)).collect();
    let found = twin::winner::winner(&cells, &cells);
    assert_eq!(found, (0..64).collect::<Vec<u32>>());
}

#[test]
fn f10_the_learned_flow_has_finite_variance() {
    // Two squares that share an edge (A01): G is unbounded, the flux of rays is not.
    let squares = [
        shapes::quad([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], 0),
        shapes::quad([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]], 1),
    ];
    let materials = vec![Material::new("floor", [0.5; 3], [1.0 / PI; 3]), Material::new("wall", [0.5; 3], [0.0; 3])];
    let scene = Scene::from_triangles("edge", &squares.concat(), materials).unwrap();
    let g = Geometry::new(&scene).unwrap();
    let tiles = starts(&g, &vec![0.0; g.tiles as usize], 0.0);
    let want = known("FF3-PERP-90");
    // What the rays carry to the wall is what a network is trained on. Owen's scrambling makes them better than
    // independent ones: errors may fall faster than n^-1/2, not slower.
    let carried = |seed: u32, rays: u32| {
        let points = twin::emit::emit(&g, &tiles, seed, 0, rays, rays);
        let crossing = points.chunks_exact(2).filter(|r| r[0].kind == kind::FRONT && r[0].plane(&g) != r[1].plane(&g));
        crossing.map(|r| f64::from(r[0].weight)).sum::<f64>() / (g.scale * g.scale)
    };
    let spread = |rays: u32| {
        let all: Vec<f64> = (1..=10).map(|seed| carried(seed, rays)).collect();
        let mean = all.iter().sum::<f64>() / 10.0;
        (mean, (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 9.0).sqrt())
    };
    let (few, many) = (spread(1_024), spread(65_536));
    eprintln!("F12 of 1,024 rays {few:?}, of 65,536 {many:?}; is {want}");
    assert!((few.0 / want - 1.0).abs() < 2e-2 && (many.0 / want - 1.0).abs() < 2e-3);
    // 64 times the rays: an eighth of the scatter; a stable law of index 3/2 would leave a quarter. Of ten seeds a
    // scatter is known to 24 %, the ratio of two to a third.
    assert!(many.1 < few.1 / 8.0 * 1.33, "{few:?} {many:?}");

    // And the network's own answer: the floor's light on the wall, the mean over its points.
    let points: Vec<SurfacePoint> = (0..64u32)
        .map(|i| SurfacePoint { p: [0.0, f64::from(i % 8) / 8.0 + 0.0625, f64::from(i / 8) / 8.0 + 0.0625], n: [1.0, 0.0, 0.0] })
        .collect();
    let mut sum = 0.0;
    for seed in 1..=10 {
        let params =
            Params { seed, rays: 16_384, direct: Direct::Network, gather_rays: 0, bounces: Some(1), ..Params::default() };
        let backend = gpu().map_or(Backend::Cpu, Backend::Gpu);
        let solution = bake(&backend, &scene, &params, &mut |_| Flow::Continue).unwrap();
        let answers = solution.query(&backend, &points).unwrap();
        assert_eq!(impossible(&answers, &scene, 0.0), None);
        sum += answers.iter().map(|a| a.h[0]).sum::<f64>() / 64.0 / 10.0;
    }
    // 8 x 8 midpoints see the edge's steep light a little too weakly: by .6 %, found by an analytic sum of point factors.
    eprintln!("F21 by the network {sum}");
    assert!((sum / want - 1.0).abs() < 2e-2, "{sum}");
}

#[test]
fn f11_units_do_not_matter() {
    let scene = |power: i32| {
        let by = 2f64.powi(power);
        let scene = Scene::load(root("scenes/cornell/scene.obj")).unwrap();
        let triangles: shapes::Triangles =
            (0..scene.faces.len()).map(|f| (scene.corners(f).map(|p| p.map(|x| x * by)), scene.faces[f].material)).collect();
        Scene::from_triangles("cornell", &triangles, scene.materials.clone()).unwrap()
    };
    let backend = gpu().map_or(Backend::Cpu, Backend::Gpu);
    let bits = |power: i32| {
        let params = Params { rays: 4_096, ..Params::default() };
        let solution = bake(&backend, &scene(power), &params, &mut |_| Flow::Continue).unwrap();
        let cells: Vec<u32> = solution.cells().iter().flatten().map(|x| x.to_bits()).collect();
        (
            cells,
            bytemuck::cast_slice::<_, u8>(solution.light()).to_vec(),
            bytemuck::cast_slice::<_, u8>(solution.nodes()).to_vec(),
        )
    };
    let want = bits(0);
    assert!(!want.0.is_empty() && !want.1.is_empty());
    for power in [-20, 20] {
        assert!(bits(power) == want, "2^{power}");
    }
}

#[test]
fn f12_what_was_never_sampled_answers_nothing_or_its_neighbours() {
    // Cells start from 0, and what wins no input keeps that.
    let net = Supervised::start(&settings(3), &[]);
    let got = net.answer(&mut Host, &settings(3), &[feature([0.5, 0.5]), feature([9.0, 9.0])]).unwrap();
    assert!(got.iter().all(|x| x.to_bits() == 0), "{got:?}");

    // Trained on the left half alone, it answers on the right as at the border; starved cells are deleted and counted.
    let left = |[x, y]: [f32; 2]| [0.5 * x, y];
    for output in [Output::Gauss, Output::Linear] {
        let s = Settings { output, ..settings(64) };
        let (net, _) = Supervised::train(&mut Square::new(left, |_| 0.25), &s).unwrap();
        let got = net.answer(&mut Host, &s, &[feature([0.9, 0.5]), feature([0.25, 0.5])]).unwrap();
        assert!(got.iter().all(|x| (x - 0.25).abs() < 5e-3), "{output:?}: {got:?}");
    }

    // A cell of the flow that carries no ray sends nothing, and a node that no ray met has none.
    let link = |other, value| Link { other, value, ..Link::default() };
    let system = System {
        cell_offsets: vec![0, 1, 1],
        cell_links: vec![link(0, 1.0)],
        source: vec![[1.0, 1.0, 1.0, 0.0], [0.0; 4]],
        node_offsets: vec![0, 1, 1],
        node_links: vec![link(0, 1.0)],
        planes: vec![Plane::default(); 2],
        node_source: vec![NodeLight::default(); 2],
        ..System::default()
    };
    let grey = [raycell::layout::Material { rho: [0.5; 3], ..Default::default() }];
    let light = jacobi(&system, &grey, &[NodeLight::default(); 2], 60);
    assert!((light[0].h[0] - 2.0).abs() < 1e-6 && light[1] == NodeLight::default(), "{light:?}");
    assert_eq!(encode(0.0, FEATURE_UNIT), 0);
}

/// The planar piece of a point, for [`f10_the_learned_flow_has_finite_variance`].
trait Piece {
    fn plane(&self, g: &Geometry) -> u32;
}

impl Piece for Point {
    fn plane(&self, g: &Geometry) -> u32 {
        g.tris[self.tri as usize].plane
    }
}
