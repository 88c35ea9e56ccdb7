//! The estimated error beside the true one, and bakes that are to reach something.
//!
//! Without any adapter the tests pass with a note, unless `RAYCELL_REQUIRE_GPU` is set. The estimate's claim on scenes
//! that nobody has seen is `cargo run --release --example estimate -- claim` (`docs/accuracy.md`).

mod common;

use common::{gpu, root};
use raycell::accuracy::norms::Errors;
use raycell::accuracy::truth::Truth;
use raycell::accuracy::{Climb, climb};
use raycell::{Backend, Checkpoint, Direct, Error, Flow, Goal, Method, Params, Scene, Solution, bake};
use std::time::{Duration, Instant};

fn scene(name: &str) -> Scene {
    Scene::load(root(&format!("scenes/{name}/scene.obj"))).unwrap()
}

fn truth(name: &str) -> Truth {
    Truth::read(&root(&format!("tests/data/{name}.truth.csv"))).unwrap()
}

fn errors(solution: &Solution, backend: &Backend, truth: &Truth) -> Errors {
    let answers = solution.query(backend, &truth.points).unwrap();
    Errors::new(&answers.iter().map(|a| a.b).collect::<Vec<_>>(), truth)
}

#[test]
fn the_true_error_lies_in_its_interval() {
    let Some(backend) = gpu().map(Backend::Gpu) else { return };
    // Other ways to carry light have the same estimate: it knows nothing of how a solution was found.
    let fem = Params { method: Method::Fem, patches: 800, gather_rays: 0, ..Params::default() };
    let network = Params { direct: Direct::Network, rays: 65_536, ..Params::default() };
    let coarse = Params { rays: 16_384, gather_rays: 0, ..Params::default() };
    let usual = Params { rays: 65_536, ..Params::default() };
    let mut widths = Vec::new();
    for (name, params) in [
        ("furnace", &usual),
        ("cornell", &usual),
        ("blocker", &usual),
        ("cornell", &coarse),
        ("cornell", &fem),
        ("cornell", &network),
    ] {
        let truth = truth(name);
        let solution = bake(&backend, &scene(name), params, &mut |_| Flow::Continue).unwrap();
        let true_error = errors(&solution, &backend, &truth).rrmse;
        let e = solution.report().estimated_error.clone().unwrap();
        eprintln!("{name} {:?}: true {true_error:.4}, estimate {:.4} ({:.4} to {:.4})", params.method, e.rrmse, e.low, e.high);
        assert!(e.low <= e.rrmse && e.rrmse <= e.high, "{name}: {e:?}");
        // The furnace's direct light is better than its standard error says: it is the same everywhere.
        let low = if name == "furnace" { e.low / 2.0 } else { e.low };
        assert!((low..=e.high).contains(&true_error), "{name}: {true_error} {e:?}");
        widths.push(e.high / e.low);
        assert_eq!(e.regions.len(), 8);
    }
    widths.sort_by(f64::total_cmp);
    assert!(widths[widths.len() / 2] <= 3.0, "{widths:?}");
}

#[test]
fn a_dark_region_does_not_hide_behind_a_bright_one() {
    let Some(backend) = gpu().map(Backend::Gpu) else { return };
    let params = Params { rays: 65_536, ..Params::default() };
    let solution = bake(&backend, &scene("corridor"), &params, &mut |_| Flow::Continue).unwrap();
    let e = solution.report().estimated_error.clone().unwrap();
    let dark = e.regions.iter().min_by(|a, b| a.mean.total_cmp(&b.mean)).unwrap();
    let bright = e.regions.iter().max_by(|a, b| a.mean.total_cmp(&b.mean)).unwrap();
    assert!(bright.mean > 1e3 * dark.mean && bright.rrmse < 0.05 && dark.rrmse > 0.2, "{:?}", e.regions);
}

/// Climbs cornell, from and into a checkpoint.
fn cornell(
    backend: &Backend,
    goal: Goal,
    checkpoint: &mut Checkpoint,
    solution: Option<Solution>,
    stop: u32,
) -> raycell::Result<Solution> {
    let mut told = 0;
    let climbing = Climb {
        goal,
        checkpoint,
        solution,
        begin: Instant::now(),
        reached: &mut |_| Ok(()),
        readout: &mut |_| Ok(Duration::ZERO),
    };
    climb(backend, &scene("cornell"), &Params::default(), climbing, &mut |_| {
        told += 1;
        if told == stop { Flow::Stop } else { Flow::Continue }
    })
}

fn bytes(solution: &Solution) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    solution.save(&dir.path().join("s.rcell")).unwrap();
    std::fs::read(dir.path().join("s.rcell")).unwrap()
}

#[test]
fn a_climb_that_goes_on_ends_where_a_straight_one_does() {
    let Some(backend) = gpu().map(Backend::Gpu) else { return };
    let goal = |error| Goal { error: Some(error), budget: None };
    let straight = cornell(&backend, goal(0.04), &mut Checkpoint::default(), None, 0).unwrap();
    let target = straight.report().target.clone().unwrap();
    assert!(target.met == Some(true) && target.rungs.len() > 1, "{target:?}");
    assert!(target.rungs.windows(2).all(|w| w[1].rays == 2 * w[0].rays));
    // A bake of the rung by itself is the same to the byte: the pilot that it took over is its own.
    let rung = (0..=Params::LAST_RUNG).find(|&n| Params::rays_of(n) == straight.report().params.rays).unwrap();
    let alone = bake(&backend, &scene("cornell"), &Params::default().rung(rung), &mut |_| Flow::Continue).unwrap();
    assert!(alone.light() == straight.light() && alone.nodes() == straight.nodes());
    assert_eq!(alone.report().estimated_error, straight.report().estimated_error);

    // Stopped in the middle of a rung, and gone on from the checkpoint.
    let mut saved = Checkpoint::default();
    assert!(matches!(cornell(&backend, goal(0.04), &mut saved, None, 150), Err(Error::Cancelled)));
    let on = cornell(&backend, goal(0.04), &mut saved, None, 0).unwrap();
    assert_eq!(bytes(&on), bytes(&straight));
    // Gone on from the whole solution of an easier target.
    let easy = cornell(&backend, goal(0.07), &mut Checkpoint::default(), None, 0).unwrap();
    assert!(easy.report().params.rays < straight.report().params.rays);
    let on = cornell(&backend, goal(0.04), &mut Checkpoint::default(), Some(easy), 0).unwrap();
    assert_eq!(bytes(&on), bytes(&straight));
}

#[test]
fn time_is_kept_and_an_error_out_of_reach_is_said_to_be() {
    let Some(backend) = gpu().map(Backend::Gpu) else { return };
    let budget = Duration::from_secs(4);
    let start = Instant::now();
    let solution =
        cornell(&backend, Goal { error: Some(1e-4), budget: Some(budget) }, &mut Checkpoint::default(), None, 0).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let target = solution.report().target.clone().unwrap();
    // Compiling does not count; the first rung is always done, however slow the machine.
    let compile = 2.0 * solution.report().seconds.compile.unwrap_or(0.0) + target.rungs[0].seconds;
    assert!(seconds < budget.as_secs_f64() + 0.5 + compile, "{seconds} s, {target:?}");
    assert!(target.met == Some(false) && target.missed.clone().unwrap().contains("not enough"), "{target:?}");
}
