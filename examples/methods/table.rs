//! The methods side by side: error against coefficients, evaluations and time.

use crate::run::{Case, Run, run, spread};
use raycell::params::{Mode, Output, PaperParams};
use raycell::{Backend, Direct, Method, Params, Result};

/// Seeds of each row.
const SEEDS: u32 = 3;

/// A row of the table.
struct Row {
    name: String,
    params: Params,
    /// Whether exact direct light is tried as well.
    exact: bool,
}

fn row(name: impl Into<String>, exact: bool, change: impl FnOnce(&mut Params)) -> Row {
    // The read-out that all share, without final gathers: they would hide the methods' own errors.
    let mut params = Params { gather_rays: 0, ..Params::default() };
    change(&mut params);
    Row { name: name.into(), params, exact }
}

/// Paper mode with some of its repairs. More cells take long: their answers are asked between all nodes.
fn paper(name: &str, exact: bool, repair: impl FnOnce(&mut PaperParams)) -> Row {
    row(name, exact, |p| {
        p.mode = Mode::Paper;
        p.cells = Some(1_024);
        p.rays = 32 * p.cells();
        repair(&mut p.paper);
    })
}

fn rows(flatland: bool) -> Vec<Row> {
    let mut rows = vec![
        paper("paper mode", false, |_| ()),
        paper("— normals in the metric", false, |p| p.normals = true),
        paper("— local linear cells", false, |p| p.output = Output::Linear),
        paper("— facing mask", false, |p| p.facing = true),
        paper("— row calibration", false, |p| p.calibrate = true),
        paper("— clamp at 50", false, |p| p.clamp = 50.0),
        paper("— all of these", true, |p| {
            (p.normals, p.output, p.facing, p.calibrate, p.clamp) = (true, Output::Linear, true, true, 50.0)
        }),
    ];
    let (rays, patches) = if flatland { ([32_768, 131_072], [33, 128]) } else { ([131_072, 524_288], [350, 1_590]) };
    for rays in rays {
        rows.push(row(format!("flux mode, {}k rays", rays / 1024), true, |p| p.rays = rays));
    }
    for patches in patches {
        rows.push(row(format!("FEM, {patches} patches"), true, |p| (p.method, p.patches) = (Method::Fem, patches)));
    }
    for patches in patches.map(|p| p / 2) {
        let name = format!("hierarchical, from {patches} patches");
        rows.push(row(name, true, |p| (p.method, p.patches) = (Method::Hierarchical, patches)));
    }
    rows.push(row(format!("raw rays, {}k", rays[0] / 1024), true, |p| (p.method, p.rays) = (Method::Rays, rays[0])));
    rows
}

/// Prints the table of each scene, in Markdown.
pub fn print(backend: &Backend, names: &[&str]) -> Result<()> {
    let names = if names.is_empty() { &["flatland_box", "flatland_l_room", "cornell", "blocker"] } else { names };
    println!("Error: RRMSE of the radiosity at the truth's points, %, mean ± standard deviation of {SEEDS} seeds, without final");
    println!("gathers. FEM's are by the read-out all methods share / constant / bilinear. \"All light\" goes through the method");
    println!(
        "(`--direct network`), or \"exact direct\" light is sampled beside it. Evaluations of the kernel, or rays; coefficients as"
    );
    println!("stored and seconds of the bake are those of the last error column that is filled.");
    for name in names {
        let case = Case::shipped(name)?;
        println!("\n## {name}\n");
        println!("| method | all light | exact direct | coefficients | evaluations | seconds |");
        println!("|---|---|---|---|---|---|");
        for row in rows(name.starts_with("flatland")) {
            let column = |direct| -> Result<Vec<Run>> {
                (1..=SEEDS).map(|seed| run(backend, &case, &Params { seed, direct, ..row.params.clone() })).collect()
            };
            let all = column(Direct::Network)?;
            let exact = if row.exact { Some(column(Direct::Exact)?) } else { None };
            let cost = exact.as_ref().unwrap_or(&all);
            let mean = |of: fn(&Run) -> f64| spread(cost.iter().map(of)).0;
            println!(
                "| {} | {} | {} | {:.0} | {:.0} | {:.1} |",
                row.name,
                errors(&all),
                exact.as_deref().map_or("".into(), errors),
                mean(|r| r.coefficients),
                mean(|r| r.evaluations),
                mean(|r| r.seconds)
            );
        }
    }
    Ok(())
}

/// An error's cell: by the shared read-out, and by the textbooks' where there are patches.
fn errors(runs: &[Run]) -> String {
    let cell = |of: &dyn Fn(&Run) -> f64| {
        let (mean, deviation) = spread(runs.iter().map(of));
        format!("{:.2} ± {:.2}", 100.0 * mean, 100.0 * deviation)
    };
    let shared = cell(&|r| r.error);
    if runs.iter().any(|r| r.patches.is_none()) {
        return shared;
    }
    let textbook = [0, 1].map(|k| cell(&|r| r.patches.map_or(f64::NAN, |p| p[k])));
    format!("{shared} / {} / {}", textbook[0], textbook[1])
}
