//! Fig. 3: the kernel of two walls in flatland, with the fissure that a blocker cuts into it, and a network of it.

use super::fig2::{share_in_varied_tenth, variation};
use super::kernel::{Learned, analytic, distance, learn, point};
use super::{Figure, Press, dense, stage};
use crate::engine::{Backend, Engine};
use crate::error::Result;
use crate::layout::Point;
use crate::params::{Direct, Method, Mode, PaperParams, Params};
use crate::pass::GpuEngine;
use crate::plot::color::{GREY, INK, Map, SERIES, shade};
use crate::plot::panel::{Axis, open, titled};
use crate::plot::surface::{Names, surface};
use crate::plot::{Grid, draw, unit};
use crate::progress::Progress;
use crate::scene::{Geometry, LoadOptions, Scene};
use crate::solution::{Answer, Solution, SurfacePoint};
use crate::twin::TwinEngine;
use std::path::Path;

/// How much of it is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Cells of both networks.
    pub cells: u32,
    /// Kernel evaluations of the paper's network, and light rays of the flux mode's.
    pub evaluations: u32,
    /// Points along each wall at which errors are measured.
    pub points: usize,
    /// Patches of each wall in the classical method.
    pub patches: u32,
}

impl Default for Options {
    fn default() -> Options {
        Options { cells: 1024, evaluations: 32_768, points: 128, patches: 100 }
    }
}

/// Height of the emitting wall over the floor, m; both are 1 m long.
const HEIGHT: f64 = 0.6;
/// Points of the truth, for each metre.
const FINE: f64 = 800.0;

/// `scenes/flatland/walls.toml`, as it was when the program was built.
pub fn scene(press: &mut Press) -> Result<Scene> {
    let mut read = |_: &Path| Ok(include_bytes!("../../scenes/flatland/walls.toml").to_vec());
    let mut scene = Scene::load_from(Path::new("walls.toml"), &LoadOptions::default(), &mut read, press.tell)?;
    scene.name = "walls".into();
    Ok(scene)
}

/// A place on the emitting wall, s from 0 to 1.
fn wall_end(s: f64) -> SurfacePoint {
    SurfacePoint { p: [s, HEIGHT, 0.0], n: [0.0, -1.0, 0.0] }
}

/// A place on the floor, t from 0 to 1.
fn floor_end(t: f64) -> SurfacePoint {
    SurfacePoint { p: [t, 0.0, 0.0], n: [0.0, 1.0, 0.0] }
}

/// The two parameters of a pair of places, where it leads from the wall to the floor.
fn parameters(x: [f64; 3], y: [f64; 3]) -> Option<[f64; 2]> {
    // Cells may float between the walls: the nearer one counts.
    (x[1] > 0.5 * HEIGHT && y[1] < 0.5 * HEIGHT).then_some([x[0].clamp(0.0, 1.0), y[0].clamp(0.0, 1.0)])
}

/// What the passes find.
struct Found {
    kernel: Grid,
    energy: Vec<f64>,
    network: Learned,
    uniform: Learned,
    answer: Grid,
    truth: Vec<f64>,
}

fn find<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    options: &Options,
    places: &[SurfacePoint],
    progress: &mut Progress,
) -> Result<Found> {
    let n = options.points;
    let middle = |i: usize| (i as f64 + 0.5) / n as f64;
    let at = |p: SurfacePoint| point(geometry, p.p, p.n);
    let wall = (0..n).map(|i| at(wall_end(middle(i)))).collect::<Result<Vec<Point>>>()?;
    let floor = (0..n).map(|i| at(floor_end(middle(i)))).collect::<Result<Vec<Point>>>()?;
    let pairs: Vec<Point> = floor.iter().flat_map(|y| wall.iter().flat_map(|x| [*x, *y])).collect();
    let grid = |values| Grid { columns: n, rows: n, values, x: [0.0, 1.0], y: [0.0, 1.0] };
    let kernel = grid(analytic(engine, geometry, &pairs)?);
    let energy = wall.iter().map(|p| dense::emitted(geometry, p)).collect();
    let network = learn(engine, geometry, params, progress)?;
    let answer = grid(network.answers(engine, geometry, &pairs)?);
    let paper = PaperParams { resampling: false, ..params.paper.clone() };
    let uniform = learn(engine, geometry, &Params { paper, ..params.clone() }, progress)?;

    let shown = places.iter().map(|&p| at(p)).collect::<Result<Vec<Point>>>()?;
    let patches = dense::solve(engine, geometry, FINE)?;
    let truth = shown.iter().map(|p| dense::reflectance(geometry, p) * patches.read(geometry, p)).collect();
    Ok(Found { kernel, energy, network, uniform, answer, truth })
}

/// Radiosity less what is emitted, at places, of a bake.
fn reflected(press: &mut Press, geometry: &Geometry, solution: &Solution, places: &[SurfacePoint]) -> Result<Vec<f64>> {
    let answers = solution.query_with(press.backend, places, press.tell)?;
    let light = |(a, p): (&Answer, &SurfacePoint)| Ok(a.b[0] - dense::emitted(geometry, &point(geometry, p.p, p.n)?));
    answers.iter().zip(places).map(light).collect()
}

/// Makes the figure.
pub fn make(press: &mut Press, options: &Options) -> Result<Figure> {
    stage(press, "fig3")?;
    let scene = scene(press)?;
    let geometry = Geometry::new(&scene)?;
    let paper = Params {
        seed: press.seed,
        mode: Mode::Paper,
        direct: Direct::Network,
        cells: Some(options.cells),
        paper: PaperParams { evaluations: Some(options.evaluations), ..PaperParams::default() },
        gather_rays: 0,
        ..Params::default()
    };
    let classical = Params { mode: Mode::Flux, method: Method::Fem, patches: 2 * options.patches, cells: None, ..paper.clone() };
    let flux = Params { mode: Mode::Flux, rays: options.evaluations, paper: PaperParams::default(), ..paper.clone() };

    // Both walls, one after the other: t along the floor, then 1 + s along the wall.
    let middle = |i: usize| (i as f64 + 0.5) / options.points as f64;
    let places: Vec<SurfacePoint> =
        (0..options.points).map(|i| floor_end(middle(i))).chain((0..options.points).map(|i| wall_end(middle(i)))).collect();
    let arc = |i: usize| if i < options.points { middle(i) } else { 1.0 + middle(i - options.points) };

    let mut progress = Progress::new(&mut *press.tell);
    let found = match press.backend {
        Backend::Cpu => find(&mut TwinEngine::new(&geometry), &geometry, &paper, options, &places, &mut progress)?,
        Backend::Gpu(gpu) => find(&mut GpuEngine::new(gpu, &geometry)?, &geometry, &paper, options, &places, &mut progress)?,
    };
    let by_paper = crate::bake(press.backend, &scene, &paper, press.tell)?;
    let by_paper = reflected(press, &geometry, &by_paper, &places)?;
    let by_flux = crate::bake(press.backend, &scene, &flux, press.tell)?;
    let flux_light = reflected(press, &geometry, &by_flux, &places)?;

    let by_patches = crate::bake(press.backend, &scene, &classical, press.tell)?;
    let coefficients = by_patches.report().coefficients;
    let by_patches = reflected(press, &geometry, &by_patches, &places)?;

    // Weighted by what the wall sends: what the paper draws.
    let weighted =
        |grid: &Grid| grid.with(grid.values.iter().enumerate().map(|(i, k)| k * found.energy[i % grid.columns]).collect());
    let (goal, answer) = (weighted(&found.kernel), weighted(&found.answer));
    let cells: Vec<[f64; 2]> = found.network.rays(&geometry).into_iter().filter_map(|[x, y]| parameters(x, y)).collect();
    let back = |f: &[f32]| [0, 1, 2].map(|k| f[k] as f64 * geometry.unit / geometry.scale + geometry.center[k]);
    let flux_cells: Vec<[f64; 2]> = by_flux.cells().iter().filter_map(|c| parameters(back(&c[0..3]), back(&c[6..9]))).collect();
    let samples = |l: &Learned| -> Vec<[f64; 2]> {
        l.places.iter().filter_map(|[x, y]| parameters(geometry.to_world(x.p), geometry.to_world(y.p))).collect()
    };
    let varied = variation(&found.kernel);
    let [resampled, uniform] = [&found.network, &found.uniform].map(samples);

    stage(press, "plot")?;
    let mut figure = Figure::new("fig3", "Fig. 3: the kernel of a wall over a floor, with a blocker between");
    let map = Map::upto(goal.peak());
    let bare = Map::upto(found.kernel.peak());
    let pale = |v: f64| shade(bare.of(v), 0.45);
    let names = Names { x: "s (m)", y: "t (m)", z: "K E (W/m²)" };
    let axes = [Axis::linear("s along the wall (m)", [0.0, 1.0]), Axis::linear("t along the floor (m)", [0.0, 1.0])];
    let most = found.truth.iter().chain(&by_paper).copied().fold(0.0, f64::max);
    let drawn = draw(1060, 750, |page| {
        let parts = page.split_evenly((2, 3));
        let area = titled(&parts[0], "(a) geometry")?;
        let mut panel = open(&area, &Axis::linear("x (m)", [-0.08, 1.08]), &Axis::linear("y (m)", [-0.12, 0.78]), Some(1.0))?;
        for (f, face) in scene.faces.iter().enumerate() {
            let [a, b, _] = scene.corners(f).map(|v| [v[0], v[1]]);
            let m = &scene.materials[face.material as usize];
            let (color, width) = match (m.emission[0] > 0.0, m.name.as_str()) {
                (true, "bright") => (SERIES[4], 6.0),
                (true, _) => (SERIES[4], 2.5),
                (false, "black") => (INK, 2.0),
                _ => (GREY, 4.0),
            };
            panel.line(&[a, b], color, width)?;
        }
        panel.words([0.5, 0.69], "wall, s: shines, most in its middle", true)?;
        panel.words([0.5, -0.06], "floor, t", true)?;
        panel.words([0.64, 0.3], "blocker", false)?;
        surface(&titled(&parts[1], "(b) kernel times the wall's energy")?, &goal, &map, &names, 48)?;
        let title = format!("(c) cells of the paper's network ({} of {} here)", cells.len(), found.network.net.cells.len());
        let area = titled(&parts[2], &title)?;
        let mut panel = open(&area, &axes[0], &axes[1], Some(1.0))?;
        panel.heat(&found.kernel, &pale)?;
        panel.dots(&cells, 2.2, INK)?;
        surface(&titled(&parts[3], "(d) what the network answers")?, &answer, &map, &names, 48)?;
        let title = format!("(e) cells of the flux mode ({} of {} here)", flux_cells.len(), by_flux.cells().len());
        let area = titled(&parts[4], &title)?;
        let mut panel = open(&area, &axes[0], &axes[1], Some(1.0))?;
        panel.heat(&found.kernel, &pale)?;
        panel.dots(&flux_cells, 2.2, INK)?;
        let (upper, lower) = titled(&parts[5], "(f) reflected light, and what is wrong with it")?.split_vertically(unit(170.0));
        let x = Axis::linear("t along the floor, then 1 + s along the wall (m)", [0.0, 2.0]);
        let mut panel = open(&upper, &Axis::linear("", x.ends), &Axis::linear("B − E (W/m)", [0.0, 1.4 * most]), None)?;
        let line =
            |values: &mut dyn Iterator<Item = f64>| -> Vec<[f64; 2]> { values.enumerate().map(|(i, v)| [arc(i), v]).collect() };
        panel.line(&line(&mut found.truth.iter().copied()), GREY, 4.0)?;
        panel.line(&line(&mut by_paper.iter().copied()), SERIES[1], 1.4)?;
        panel.legend(&[("truth", GREY), ("the paper's network", SERIES[1])], false)?;
        let wrong = |values: &[f64]| line(&mut values.iter().zip(&found.truth).map(|(v, t)| v - t));
        let lines = [(&by_paper, SERIES[1]), (&by_patches, SERIES[2]), (&flux_light, SERIES[0])].map(|(v, c)| (wrong(v), c));
        let worst = lines.iter().flat_map(|(line, _)| line).map(|p| p[1].abs()).fold(1e-9, f64::max);
        let y = Axis::linear("error (W/m)", [-1.1 * worst, 2.4 * worst]);
        let mut panel = open(&lower, &x, &y, None)?;
        panel.line(&[[0.0, 0.0], [2.0, 0.0]], GREY, 0.7)?;
        for (line, color) in &lines {
            panel.line(line, *color, 1.4)?;
        }
        let fem = format!("{} patches a wall", options.patches);
        panel.legend(&[("the paper's network", SERIES[1]), (&fem, SERIES[2]), ("flux mode", SERIES[0])], false)
    });
    figure.drawing(press, drawn)?;

    let rows = (0..goal.values.len()).map(|i| {
        let [s, t] = goal.place(i);
        vec![s, t, found.energy[i % goal.columns], found.kernel.values[i], found.answer.values[i]]
    });
    figure.csv(press, ".csv", "s,t,energy,kernel,network", rows)?;
    figure.csv(press, "_cells.csv", "s,t", cells.iter().map(|c| c.to_vec()))?;
    figure.csv(press, "_flux_cells.csv", "s,t", flux_cells.iter().map(|c| c.to_vec()))?;
    figure.csv(press, "_samples.csv", "s,t", resampled.iter().map(|c| c.to_vec()))?;
    let rows = (0..places.len()).map(|i| vec![arc(i), found.truth[i], by_paper[i], flux_light[i], by_patches[i]]);
    figure.csv(press, "_light.csv", "arc,truth,paper,flux,patches", rows)?;

    let [varied_resampled, varied_uniform] = [&resampled, &uniform].map(|s| share_in_varied_tenth(&varied, s));
    figure.about.push(format!(
        "A wall that shines over a floor in flatland, with a black blocker between (a). The kernel cos cos/(2 r) between a \
         place s of the wall and a place t of the floor, times what the wall emits at s, is a surface with a fissure where \
         the blocker stands (b). The paper's network ({} cells, {} evaluations, positions only, Gaussian outputs) puts its \
         cells where the kernel changes (c) and answers (d). The flux mode's cells ({}, from as many rays) are bundles of \
         light: they follow the flow, not the kernel's edges (e). Both, and finite elements (a coefficient for each two \
         patches), solve for the light of all reflections; the truth has {} points a metre (f).",
        options.cells,
        options.evaluations,
        by_flux.cells().len(),
        FINE
    ));
    figure.about.push(format!(
        "Errors are relative L2 norms: of the kernel over {0} x {0} pairs of this wall and this floor, of the reflected \
         light B − E over {0} places of each. With resampling {1:.1} % of the samples lie in the tenth of the pairs where \
         the kernel varies most (within a 32nd of the walls), without it {2:.1} %.",
        options.points,
        100.0 * varied_resampled,
        100.0 * varied_uniform
    ));
    figure.number("kernel error of the paper's network", distance(&found.answer.values, &found.kernel.values), "1");
    figure.number("the same over all pairs of the scene", found.network.error, "1");
    figure.number("the same without resampling", found.uniform.error, "1");
    figure.number("energy that the clamp took", found.network.clamped, "1");
    figure.number("error of the light: the paper's network", distance(&by_paper, &found.truth), "1");
    figure.number("error of the light: flux mode", distance(&flux_light, &found.truth), "1");
    figure.number(
        format!("error of the light: finite elements, {} patches a wall, {coefficients} coefficients", options.patches),
        distance(&by_patches, &found.truth),
        "1",
    );
    figure.number("samples in the tenth of the pairs where the kernel varies most", varied_resampled, "1");
    figure.number("the same share without resampling", varied_uniform, "1");
    figure.finish(press)?;
    Ok(figure)
}
