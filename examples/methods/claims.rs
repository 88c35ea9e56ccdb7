//! The paper's claims, and ours, as numbers.

use crate::run::{Case, Run, run, spread};
use raycell::scene::Face;
use raycell::{Backend, Cells, Direct, Method, Params, Result, Scene};

/// Seeds of each claim.
const SEEDS: u32 = 5;
/// Scenes with truth.
const SCENES: [&str; 8] =
    ["furnace", "cornell", "blocker", "corridor", "flatland_box", "flatland_plates", "flatland_l_room", "city"];
/// Rays of the claims about the network.
const RAYS: u32 = 131_072;

fn seeds(backend: &Backend, case: &Case, params: &Params) -> Result<Vec<Run>> {
    (1..=SEEDS).map(|seed| run(backend, case, &Params { seed, ..params.clone() })).collect()
}

fn percent(runs: &[Run]) -> String {
    let (mean, deviation) = spread(runs.iter().map(|r| r.error));
    format!("{:.3} ± {:.3} %", 100.0 * mean, 100.0 * deviation)
}

/// The scene with every segment cut into `n`.
fn cut(scene: &Scene, n: u32) -> Scene {
    let mut cut = Scene { vertices: Vec::new(), faces: Vec::new(), ..scene.clone() };
    for (i, face) in scene.faces.iter().enumerate() {
        let [a, b, _] = scene.corners(i);
        let first = cut.vertices.len() as u32;
        cut.vertices.extend((0..=n).map(|k| [0, 1, 2].map(|d| a[d] + (b[d] - a[d]) * f64::from(k) / f64::from(n))));
        cut.faces.extend((0..n).map(|k| Face { vertices: [first + k, first + k + 1, first + k + 1], ..*face }));
    }
    cut
}

/// Prints the claims named, or all of them, in Markdown; after `growth` may come its scenes.
pub fn print(backend: &Backend, names: &[&str]) -> Result<()> {
    let wanted = |name| names.is_empty() || names.contains(&name);
    if wanted("walls") {
        walls(backend)?;
    }
    if wanted("tessellation") {
        tessellation(backend)?;
    }
    if wanted("crossing") {
        crossing(backend)?;
    }
    if wanted("growth") {
        let scenes = names.iter().skip_while(|n| **n != "growth").skip(1).copied().collect::<Vec<_>>();
        growth(backend, if scenes.is_empty() { &SCENES } else { &scenes })?;
    }
    Ok(())
}

/// Claim (b): the tessellation does not matter.
fn tessellation(backend: &Backend) -> Result<()> {
    println!("\n## Tessellation: the same room in few pieces and in many ({SEEDS} seeds, {RAYS} rays)\n");
    println!("| scene | faces | error | cells | coefficients |\n|---|---|---|---|---|");
    let params = Params { rays: RAYS, gather_rays: 0, ..Params::default() };
    let boxed = Case::shipped("flatland_box")?;
    let pieces = Case {
        name: "flatland_box, each line in 100".into(),
        scene: cut(&boxed.scene, 100),
        points: boxed.points.clone(),
        truth: boxed.truth.clone(),
    };
    for case in [boxed, pieces, Case::shipped("cornell")?, Case::shipped("cornell_tess")?] {
        let runs = seeds(backend, &case, &params)?;
        let mean = |of: fn(&Run) -> f64| spread(runs.iter().map(of));
        let (cells, coefficients) = (mean(|r| r.cells), mean(|r| r.coefficients));
        println!(
            "| {} | {} | {} | {:.0} ± {:.0} | {:.0} |",
            case.name,
            case.scene.faces.len(),
            percent(&runs),
            cells.0,
            cells.1,
            coefficients.0
        );
    }
    Ok(())
}

/// Claim (e): does growth earn its place beside random reference rays?
fn growth(backend: &Backend, scenes: &[&str]) -> Result<()> {
    println!("\n## Growth: trained cells against as many random reference rays ({SEEDS} seeds, {RAYS} rays)\n");
    println!(
        "Without refinements, which would take the cells' error out; all light through the network, and exact direct light.\n"
    );
    println!("| scene | direct | cells | trained | random rays | ratio |\n|---|---|---|---|---|---|");
    for name in scenes {
        let case = Case::shipped(name)?;
        for (direct, word) in [(Direct::Network, "network"), (Direct::Exact, "exact")] {
            let base = Params { rays: RAYS, gather_rays: 0, refinements: 0, direct, ..Params::default() };
            let trained = seeds(backend, &case, &base)?;
            let cells = spread(trained.iter().map(|r| r.cells)).0;
            let random = Params { cells_from: Cells::Random, cells: Some(cells as u32), ..base };
            let random = seeds(backend, &case, &random)?;
            let ratio = spread(random.iter().map(|r| r.error)).0 / spread(trained.iter().map(|r| r.error)).0;
            println!("| {name} | {word} | {cells:.0} | {} | {} | {ratio:.2} |", percent(&trained), percent(&random));
        }
    }
    Ok(())
}

/// Claim (a): two walls of a hundred patches each have 10,000 form factors; how many cells carry as much?
fn walls(backend: &Backend) -> Result<()> {
    println!("\n## Two walls of a hundred patches each: how many cells for the same error? ({SEEDS} seeds)\n");
    let case = Case::shipped("flatland_plates")?;
    let fem = Params { method: Method::Fem, patches: 200, gather_rays: 0, direct: Direct::Network, ..Params::default() };
    let runs = seeds(backend, &case, &fem)?;
    let textbook = [0, 1].map(|k| spread(runs.iter().map(move |r| r.patches.map_or(f64::NAN, |p| p[k]))).0);
    let coefficients = spread(runs.iter().map(|r| r.coefficients)).0;
    println!(
        "FEM, 200 patches: {coefficients:.0} coefficients, error {:.3} % constant, {:.3} % linear.\n",
        100.0 * textbook[0],
        100.0 * textbook[1]
    );
    println!("| rays | cells | coefficients | error |\n|---|---|---|---|");
    for rays in [8_192, 32_768, 131_072, 524_288] {
        let flux = Params { rays, gather_rays: 0, direct: Direct::Network, ..Params::default() };
        let runs = seeds(backend, &case, &flux)?;
        let mean = |of: fn(&Run) -> f64| spread(runs.iter().map(of)).0;
        println!("| {rays} | {:.0} | {:.0} | {} |", mean(|r| r.cells), mean(|r| r.coefficients), percent(&runs));
    }
    Ok(())
}

/// Claim (d): coefficients and evaluations where a ladder of sizes crosses an error, between two rungs.
fn crossing(backend: &Backend) -> Result<()> {
    const GOAL: f64 = 0.02;
    println!("\n## Cornell with exact direct light: what {} % costs\n", 100.0 * GOAL);
    println!("| method | size | error | coefficients | evaluations | seconds |\n|---|---|---|---|---|---|");
    let case = Case::shipped("cornell")?;
    let base = Params { gather_rays: 0, ..Params::default() };
    let ladder = |name: &str, sizes: &[u32], error: fn(&Run) -> f64, make: &dyn Fn(u32) -> Params| -> Result<Option<[f64; 2]>> {
        let mut last: Option<(f64, f64, f64)> = None;
        let mut found = None;
        for &size in sizes {
            let runs: Vec<Run> =
                (1..=3).map(|seed| run(backend, &case, &Params { seed, ..make(size) })).collect::<Result<_>>()?;
            let mean = |of: fn(&Run) -> f64| spread(runs.iter().map(of)).0;
            let (e, c, v) = (mean(error), mean(|r| r.coefficients), mean(|r| r.evaluations));
            println!("| {name} | {size} | {:.2} % | {c:.0} | {v:.0} | {:.1} |", 100.0 * e, mean(|r| r.seconds));
            if let (Some((e0, c0, v0)), None, true) = (last, found, e <= GOAL) {
                // On straight lines in logarithms.
                let t = (e0 / GOAL).ln() / (e0 / e).ln();
                found = Some([c0 * (c / c0).powf(t), v0 * (v / v0).powf(t)]);
            } else if e <= GOAL && found.is_none() {
                found = Some([c, v]);
            }
            last = Some((e, c, v));
        }
        Ok(found)
    };
    let bilinear = |r: &Run| r.patches.map_or(f64::NAN, |p| p[1]);
    let fem = ladder("FEM, bilinear", &[350, 726, 1_590, 3_174], bilinear, &|patches| Params {
        method: Method::Fem,
        patches,
        ..base.clone()
    })?;
    let flux =
        ladder("flux mode", &[8_192, 16_384, 32_768, 65_536, 131_072], |r| r.error, &|rays| Params { rays, ..base.clone() })?;
    match (fem, flux) {
        (Some(fem), Some(flux)) => println!(
            "\nAt {} %: FEM-bilinear {:.0} coefficients and {:.0} evaluations, flux mode {:.0} and {:.0}: 1/{:.1} and 1/{:.1}.",
            100.0 * GOAL,
            fem[0],
            fem[1],
            flux[0],
            flux[1],
            fem[0] / flux[0],
            fem[1] / flux[1]
        ),
        _ => println!("\nNot both reach {} %.", 100.0 * GOAL),
    }
    Ok(())
}
