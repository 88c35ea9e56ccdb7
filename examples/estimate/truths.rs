//! Scenes with their truths: the shipped ones, and random ones by path tracing.

use crate::{Outcome, scenes};
use raycell::accuracy::reference::{Goal, Reference, lit_points};
use raycell::accuracy::truth::Truth;
use raycell::progress::Progress;
use raycell::scene::Geometry;
use raycell::{Event, Flow, Scene};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Points of a truth.
const POINTS: usize = 512;
/// Noise of a truth: under a third of the least error that is to be seen by it. What it is in the end is taken out of
/// every error.
const NOISE: f64 = 0.003;
/// Time that a truth may take where none was asked for; `references` goes on with what there is.
const TIME: u64 = 40;
/// The shipped scenes in three dimensions with a truth.
const SHIPPED: [&str; 6] = ["cornell", "cornell_tess", "blocker", "furnace", "corridor", "city"];

/// A scene and its truth.
pub struct Case {
    pub name: String,
    pub scene: Scene,
    pub truth: Truth,
}

fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The shipped scenes that have a truth.
pub fn shipped() -> Outcome<Vec<Case>> {
    let case = |name: &&str| -> Outcome<Case> {
        let scene = Scene::load(root(&format!("scenes/{name}/scene.obj")))?;
        Ok(Case { name: name.to_string(), scene, truth: Truth::read(&root(&format!("tests/data/{name}.truth.csv")))? })
    };
    SHIPPED.iter().map(case).collect()
}

/// The random scene of a seed. Its truth is made where it is not there, or is of an earlier generator.
pub fn random(seed: u32) -> Outcome<Case> {
    trace(seed, None)
}

/// Goes on with a truth for some seconds.
pub fn refine(seed: u32, seconds: u64) -> Outcome {
    trace(seed, Some(seconds)).map(drop)
}

fn trace(seed: u32, more: Option<u64>) -> Outcome<Case> {
    let scene = scenes::scene(seed)?;
    let geometry = Geometry::new(&scene)?;
    let folder = root("target/estimate");
    std::fs::create_dir_all(&folder)?;
    let (path, state) = (folder.join(format!("{seed}.truth.csv")), folder.join(format!("{seed}.json")));
    let name = format!("random {seed}");
    // A truth has points of its own, and holds as long as they lie on the scene: it is of the seed's scene then.
    let on_it = |truth: &Truth| truth.points.iter().all(|p| geometry.locate(p.p, p.n).is_some());
    let kept = Truth::read(&path).ok().filter(on_it);
    if let Some(truth) = kept.as_ref().filter(|truth| more.is_none() || truth.noise() <= NOISE) {
        return Ok(Case { name, scene, truth: truth.clone() });
    }
    let (points, mean) = lit_points(&geometry, POINTS, seed);
    let mut reference = Reference::new(&scene, &geometry, &path, points, seed)?.lit(mean);
    // Of an earlier scene of this seed, or of other points: begun anew.
    if reference.resume(&state).is_err() {
        std::fs::remove_file(&state)?;
    }
    let start = Instant::now();
    let goal = Goal { noise: NOISE, time: Some(Duration::from_secs(more.unwrap_or(TIME))), ..Goal::default() };
    reference.run(goal, &mut Progress::new(&mut |_: &Event| Flow::Continue))?;
    reference.save(&state)?;
    let truth = reference.truth();
    truth.write(&path)?;
    eprintln!(
        "truth of {seed}: {} paths a point, noise {:.2} %, {:.0} s",
        reference.paths(),
        100.0 * truth.noise(),
        start.elapsed().as_secs_f64()
    );
    Ok(Case { name, scene, truth })
}
