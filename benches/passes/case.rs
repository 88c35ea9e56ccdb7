//! Every pass once: what it is given, how it is run, what it answers.

use raycell::engine::Engine;
use raycell::layout::{CellOutput, CellSums, DirectSum, Fixed, NodeLight, NodeSource, Point, ResponseSums, Sample, Tile, kind};
use raycell::network::nodes::place_nodes;
use raycell::progress::Progress;
use raycell::radiosity::coefficients;
use raycell::scene::Geometry;
use raycell::twin::assign::Surface;
use raycell::twin::direct::Samples;
use raycell::twin::gather::Gathered;
use raycell::twin::jacobi::System;
use raycell::twin::respond::Net;
use raycell::twin::winner::{Feature, Metric};
use raycell::twin::{TwinEngine, coefficients::Sums};
use raycell::{Flow, Params, Scene};

/// Rays of a batch.
pub const RAYS: u32 = 8_192;
/// Cells of the network.
pub const CELLS: usize = 1_024;
/// Sweeps of a call of Jacobi.
pub const SWEEPS: u32 = 8;
/// Points that rays are shot from, and rays of each.
const FROM: usize = 512;
const SHOTS: u32 = 32;
const SAMPLES: Samples = Samples { emitter: 2, cosine: 1 };

/// A pass: what its elements are, and what one of them asks of the machine, where that is known beforehand.
pub struct Pass {
    pub name: &'static str,
    pub element: &'static str,
    /// Floating-point operations; a multiply-add is two.
    pub flops: Option<f64>,
    /// Bytes that have to be read or written once, small tables left out.
    pub bytes: Option<f64>,
}

const fn pass(name: &'static str, element: &'static str, flops: Option<f64>, bytes: Option<f64>) -> Pass {
    Pass { name, element, flops, bytes }
}

/// All passes, in the order of a bake.
pub const PASSES: &[Pass] = &[
    pass("emit", "ray", None, None),
    pass("shoot", "ray", None, None),
    pass("direct", "ray end of 2 or 3 shadow rays", None, None),
    pass("assign", "point", None, None),
    // Two ends read, a feature written.
    pass("feature", "directed ray", None, Some(32.0 + 32.0 + 64.0)),
    // 13 differences squared and added for each cell, as if no block were passed over.
    pass("winner", "directed ray", Some(39.0 * CELLS as f64), None),
    // Point, feature and winner read; 15 sums of 8 bytes read and written.
    pass("accumulate", "directed ray", None, Some(32.0 + 64.0 + 4.0 + 15.0 * 16.0)),
    // Sums of itself and two neighbours, the cell before and after.
    pass("adapt", "cell", None, Some(3.0 * 128.0 + 2.0 * 64.0)),
    pass("coefficients", "directed ray", None, None),
    // Point, weights, direct light; 9 sums of 8 bytes at up to 4 nodes read and written.
    pass("deposit", "directed ray", None, Some(64.0 + 32.0 + 32.0 + 4.0 * 9.0 * 16.0)),
    // A coefficient read; about three bands of three multiply-adds.
    pass("jacobi", "coefficient", Some(18.0), Some(16.0)),
    // Point and weights read, irradiance written; four nodes of frame, offsets and two multiply-adds a band.
    pass("readout", "point", Some(4.0 * 40.0), Some(32.0 + 32.0 + 16.0)),
    // Hit, irradiance and direct light read.
    pass("gather", "hit", None, Some(32.0 + 16.0 + 32.0)),
    pass("kernel", "pair", None, None),
    pass("respond", "sample", None, None),
];

/// The scene, and what the passes need of each other, by the twins.
pub struct Case {
    pub geometry: Geometry,
    tiles: Vec<Tile>,
    surface: Surface,
    metric: Metric,
    brightness: Vec<f32>,
    system: System,
    light: Vec<NodeLight>,
    outputs: Vec<CellOutput>,
    /// A ring: two neighbours each.
    offsets: Vec<u32>,
    neighbours: Vec<u32>,
}

/// What lives on a machine between passes, and what they answered.
pub struct Held<E: Engine> {
    rays: E::Batch,
    points: Vec<Point>,
    features: Vec<Feature>,
    cells: Vec<Feature>,
    from: E::Batch,
    hits: E::Batch,
    emitted: Option<E::Batch>,
    shot: Option<E::Batch>,
    samples: Vec<Sample>,
    sums: Vec<CellSums>,
    moved: Vec<Feature>,
    footprints: Sums,
    known: Vec<NodeSource>,
    swept: Vec<NodeLight>,
    gathered: Vec<Gathered>,
    pairs: Vec<f32>,
    responses: Vec<ResponseSums>,
}

pub fn scene() -> Scene {
    Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell/scene.obj")).unwrap()
}

impl Case {
    pub fn new() -> Case {
        let geometry = Geometry::new(&scene()).unwrap();
        let params = Params::default();
        // Starts uniform over the area.
        let mut sum = 0.0;
        let tiles = (0..geometry.tiles as usize)
            .map(|t| {
                sum += geometry.tile_area(t) / geometry.area;
                let last = t + 1 == geometry.tiles as usize;
                let cdf = if last { u32::MAX } else { (sum * 4294967296.0).min(4294967295.0) as u32 };
                Tile { cdf, density: (1.0 / geometry.area) as f32 }
            })
            .collect();
        let mut engine = TwinEngine::new(&geometry);
        let (density, lambda) = (vec![1.0; geometry.tiles as usize], params.lambda as f32);
        let mut quiet = |_: &_| Flow::Continue;
        let surface =
            place_nodes(&mut engine, &geometry, &density, 400, lambda, 5, true, &mut Progress::new(&mut quiet)).unwrap();
        let metric = Metric { inv_unit: (1.0 / geometry.unit) as f32, lambda, mu: params.mu as f32 };
        let brightness = vec![1.0; geometry.tiles as usize];
        let mut case = Case {
            geometry,
            tiles,
            light: vec![NodeLight { h: [1.0, 0.5, 0.25], ..NodeLight::default() }; surface.nodes.len()],
            surface,
            metric,
            brightness,
            system: System::default(),
            outputs: (0..CELLS).map(|c| CellOutput { value: (c as f32).sin(), width: 0.3, ..CellOutput::default() }).collect(),
            offsets: (0..=CELLS as u32).map(|c| 2 * c).collect(),
            neighbours: (0..CELLS as u32).flat_map(|c| [(c + CELLS as u32 - 1) % CELLS as u32, (c + 1) % CELLS as u32]).collect(),
        };

        // A linear system out of these rays.
        let mut engine = TwinEngine::new(&case.geometry);
        let mut held = case.hold(&mut engine);
        case.run("coefficients", &mut engine, &mut held);
        let mut nodes = case.surface.nodes.clone();
        let slots = params.slots as usize;
        case.system = coefficients::build(&held.footprints, &mut nodes, params.ridge, slots, RAYS as f64).system;
        case
    }

    fn normalise(&self) -> f32 {
        (1.0 / (2.0 * self.geometry.area)) as f32
    }

    /// Batches with all that the passes ask for.
    pub fn hold<E: Engine>(&self, engine: &mut E) -> Held<E> {
        engine.set_surface(&self.surface).unwrap();
        engine.set_light(&self.light).unwrap();
        let mut rays = engine.emit(&self.tiles, 3, 0, RAYS, RAYS).unwrap();
        engine.direct(&mut rays, None, 7, 0, 1, SAMPLES).unwrap();
        engine.assign(&mut rays).unwrap();
        engine.readout(&mut rays).unwrap();
        engine.feature(&mut rays, self.metric, &self.brightness).unwrap();
        let count = 2 * RAYS as usize;
        let features = engine.features(&rays, 0..count).unwrap();
        let cells: Vec<Feature> = features.iter().copied().step_by(count / CELLS).take(CELLS).collect();
        engine.winner(&mut rays, 0..count, &cells).unwrap();
        let winners = engine.winners(&rays).unwrap();
        let sums = engine.accumulate(&rays, 0..count, &cells).unwrap();
        let points = engine.points(&rays).unwrap();
        let places: Vec<Point> = points.iter().filter(|p| p.kind == kind::FRONT).take(FROM).copied().collect();
        let from = engine.upload(&places).unwrap();
        let mut hits = engine.shoot(&from, 11, 0, SHOTS).unwrap();
        engine.assign(&mut hits).unwrap();
        engine.readout(&mut hits).unwrap();
        engine.direct(&mut hits, None, 13, 0, 1, SAMPLES).unwrap();
        let sample = |(k, &winner): (usize, &u32)| Sample { winner, goal: (k as f32).cos(), weight: 1.0, output: 0.0 };
        engine.set_system(&self.system).unwrap();
        Held {
            rays,
            points,
            features,
            cells,
            from,
            hits,
            emitted: None,
            shot: None,
            samples: winners.iter().enumerate().map(sample).collect(),
            sums,
            moved: Vec::new(),
            footprints: Sums::default(),
            known: Vec::new(),
            swept: Vec::new(),
            gathered: Vec::new(),
            pairs: Vec::new(),
            responses: Vec::new(),
        }
    }

    /// Runs a pass. Those whose answers a bake always reads back read them here, too.
    pub fn run<E: Engine>(&self, name: &str, engine: &mut E, held: &mut Held<E>) {
        let all = 0..2 * RAYS as usize;
        let cells = &held.cells;
        match name {
            "emit" => held.emitted = Some(engine.emit(&self.tiles, 3, 0, RAYS, RAYS).unwrap()),
            "shoot" => held.shot = Some(engine.shoot(&held.from, 11, 0, SHOTS).unwrap()),
            "direct" => engine.direct(&mut held.rays, None, 7, 0, 1, SAMPLES).unwrap(),
            "assign" => engine.assign(&mut held.rays).unwrap(),
            "feature" => engine.feature(&mut held.rays, self.metric, &self.brightness).unwrap(),
            "winner" => engine.winner(&mut held.rays, all, cells).unwrap(),
            "accumulate" => held.sums = engine.accumulate(&held.rays, all, cells).unwrap(),
            "adapt" => held.moved = engine.adapt(cells, &held.sums, &self.offsets, &self.neighbours, 0.1).unwrap(),
            "coefficients" => {
                let rays = std::slice::from_ref(&held.rays);
                held.footprints = engine.coefficients(rays, true, self.normalise(), RAYS as f32, CELLS, &mut || Ok(())).unwrap();
            }
            "deposit" => {
                held.known = engine.deposit(std::slice::from_ref(&held.rays), true, true, self.normalise()).unwrap();
            }
            "jacobi" => held.swept = engine.jacobi(&self.light, SWEEPS).unwrap(),
            "readout" => engine.readout(&mut held.rays).unwrap(),
            "gather" => held.gathered = engine.gather(&held.hits, SHOTS, true, true).unwrap(),
            "kernel" => held.pairs = engine.kernel(&held.points).unwrap(),
            "respond" => {
                let net =
                    Net { cells, outputs: &self.outputs, offsets: &self.offsets, neighbours: &self.neighbours, linear: false };
                held.responses = engine.respond(net, &held.features, &mut held.samples).unwrap();
            }
            _ => panic!("no pass {name}"),
        }
    }

    /// Elements of a run.
    pub fn elements(&self, name: &str) -> u64 {
        match name {
            "emit" | "kernel" => RAYS.into(),
            "shoot" | "gather" => FROM as u64 * SHOTS as u64,
            "adapt" => CELLS as u64,
            "jacobi" => SWEEPS as u64 * (self.system.cell_links.len() + self.system.node_links.len()) as u64,
            _ => 2 * RAYS as u64,
        }
    }

    /// What a pass that was run found, as numbers to compare.
    pub fn answer<E: Engine>(&self, name: &str, engine: &mut E, held: &Held<E>) -> Vec<f32> {
        let places = |points: Vec<Point>| points.iter().flat_map(|p| [p.p[0], p.p[1], p.p[2], p.tri as f32]).collect();
        let direct = |sums: Vec<DirectSum>| sums.iter().flat_map(|d| d.sum).collect();
        match name {
            "emit" => places(engine.points(held.emitted.as_ref().unwrap()).unwrap()),
            "shoot" => places(engine.points(held.shot.as_ref().unwrap()).unwrap()),
            "direct" => direct(engine.direct_sums(&held.rays).unwrap()),
            "assign" => engine.psi(&held.rays).unwrap().iter().flat_map(|s| s.weight).collect(),
            "feature" => engine.features(&held.rays, 0..2 * RAYS as usize).unwrap().as_flattened().to_vec(),
            "winner" => engine.winners(&held.rays).unwrap().iter().map(|&w| w as f32).collect(),
            "accumulate" => held.sums.iter().flat_map(|s| s.feature.map(number)).collect(),
            "adapt" => held.moved.as_flattened().to_vec(),
            "coefficients" => {
                let rows = held.footprints.gather.iter().chain(&held.footprints.deposit);
                let slots = rows.flatten().flat_map(|s| [s.key as f32, number(s.value), number(s.first), number(s.second)]);
                slots.chain(held.footprints.flux.iter().flat_map(|f| f.source.map(number))).collect()
            }
            "deposit" => bytemuck::cast_slice::<NodeSource, Fixed>(&held.known).iter().map(|&f| number(f)).collect(),
            "jacobi" => held.swept.iter().flat_map(|l| [l.h, l.g0, l.g1]).flatten().collect(),
            "readout" => engine.irradiance(&held.rays).unwrap().as_flattened().to_vec(),
            "gather" => held.gathered.iter().flat_map(|g| [g.irradiance[0], g.irradiance[1], g.nearness, g.front]).collect(),
            "kernel" => held.pairs.clone(),
            "respond" => held.responses.iter().flat_map(|r| [number(r.gain), number(r.activation), number(r.error)]).collect(),
            _ => panic!("no pass {name}"),
        }
    }
}

/// A sum in units of 2^-32.
fn number(f: Fixed) -> f32 {
    (f.hi as i32 as f64 + f.lo as f64 / 4294967296.0) as f32
}
