//! Fig. 2: the network fits a function of the plane.

use super::{Figure, Press, stage};
use crate::error::{Error, Result};
use crate::network::supervised::{Goal, Output, Settings, Supervised};
use crate::plot::color::{INK, Map, SERIES, shade};
use crate::plot::panel::{Axis, open, titled};
use crate::plot::surface::{Names, surface};
use crate::plot::{Grid, draw};
use crate::twin::math::unit;
use crate::twin::respond::Host;
use crate::twin::sobol::sobol4;
use crate::twin::winner::Feature;
use std::path::Path;

/// What is fitted, and with what.
#[derive(Clone, Debug)]
pub struct Options {
    /// Name of a function (see [`Function::named`]), or path of an image.
    pub function: String,
    /// Cells of the network.
    pub cells: usize,
    /// Dimension of its topology.
    pub k: usize,
    /// Evaluations of the goal for each cell.
    pub evaluations: u64,
    /// Points along each side at which errors are measured.
    pub points: usize,
}

impl Default for Options {
    fn default() -> Options {
        Options { function: "ridge-step".into(), cells: 400, k: 2, evaluations: 24, points: 144 }
    }
}

impl Options {
    /// Checks every range. Errors: [`Error::InvalidParam`].
    pub fn check(&self) -> Result<()> {
        for (name, value, low, high, range) in
            [("cells", self.cells, 8, 20_000, "give 8 to 20000 cells"), ("k", self.k, 1, 4, "give 1 to 4")]
        {
            if !(low..=high).contains(&value) {
                return Err(Error::InvalidParam { name, value: value.to_string(), range });
            }
        }
        Ok(())
    }
}

/// A function from the unit square to [-1, 1].
#[derive(Clone, Debug)]
pub enum Function {
    /// A formula.
    Formula(fn(f64, f64) -> f64),
    /// The brightness of an image: pixels a row, rows from below, interpolated between their middles.
    Image(usize, Vec<f32>),
}

/// A ridge along an arc, a step along a slanted line, and a slope on top of it.
fn ridge_step(x: f64, y: f64) -> f64 {
    let ridge = 0.55 * (-((x.hypot(y) - 0.55) / 0.045).powi(2)).exp();
    let step = if x + 0.4 * y > 0.95 { 0.35 + 0.25 * y } else { 0.0 };
    (0.08 + ridge + step).min(1.0)
}

/// Three bells: nowhere steep.
fn bells(x: f64, y: f64) -> f64 {
    let bell = |a: f64, b: f64, r: f64| (-((x - a).powi(2) + (y - b).powi(2)) / (r * r)).exp();
    0.9 * bell(0.3, 0.35, 0.18) + 0.5 * bell(0.7, 0.25, 0.12) + 0.7 * bell(0.62, 0.72, 0.25)
}

impl Function {
    /// Names of the formulas.
    pub const NAMES: [&str; 2] = ["ridge-step", "bells"];

    /// A formula by its name, or an image by its path. Errors: [`Error::InvalidParam`] for a name that is neither,
    /// [`Error::Read`], [`Error::Format`].
    pub fn named(name: &str) -> Result<Function> {
        match name {
            "ridge-step" => Ok(Function::Formula(ridge_step)),
            "bells" => Ok(Function::Formula(bells)),
            _ if name.to_lowercase().ends_with(".png") => Function::image(Path::new(name)),
            _ => Err(Error::InvalidParam {
                name: "function",
                value: name.into(),
                range: "give ridge-step, bells, or the path of a .png",
            }),
        }
    }

    fn image(path: &Path) -> Result<Function> {
        let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
        let image = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).map_err(|e| Error::Format {
            path: path.into(),
            line: None,
            what: e.to_string(),
            cure: "give a PNG".into(),
        })?;
        let image = image.flipv().to_luma32f();
        Ok(Function::Image(image.width() as usize, image.into_raw()))
    }

    /// The value at a place of the unit square.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        match self {
            Function::Formula(f) => f(x, y),
            Function::Image(columns, values) => {
                let rows = values.len() / columns;
                let along = |u: f64, n: usize| {
                    let p = (u * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
                    (p as usize, (p as usize + 1).min(n - 1), p.fract())
                };
                let ((i0, i1, u), (j0, j1, v)) = (along(x, *columns), along(y, rows));
                let value = |i: usize, j: usize| values[j * columns + i] as f64;
                (value(i0, j0) * (1.0 - u) + value(i1, j0) * u) * (1.0 - v) + (value(i0, j1) * (1.0 - u) + value(i1, j1) * u) * v
            }
        }
    }
}

/// A function as a goal of the network.
struct Plane<'a> {
    host: Host,
    function: &'a Function,
    seed: u32,
}

impl Goal for Plane<'_> {
    type Place = [f64; 2];
    type Machine = Host;

    fn machine(&mut self) -> &mut Host {
        &mut self.host
    }
    fn draw(&mut self, first: u64, count: usize) -> Vec<[f64; 2]> {
        let place = |i: usize| sobol4(first as u32 + i as u32, self.seed);
        (0..count).map(place).map(|u| [unit(u[0]) as f64, unit(u[1]) as f64]).collect()
    }
    fn input(&self, p: &[f64; 2]) -> Feature {
        feature(*p)
    }
    fn evaluate(&mut self, places: &[[f64; 2]]) -> Result<Vec<f32>> {
        Ok(places.iter().map(|p| self.function.at(p[0], p[1]) as f32).collect())
    }
}

fn feature(p: [f64; 2]) -> Feature {
    std::array::from_fn(|k| p.get(k).map_or(0.0, |&x| x as f32))
}

/// A network that was fitted.
struct Fitted {
    net: Supervised,
    places: Vec<[f64; 2]>,
    approximation: Grid,
    error: f64,
}

/// How far apart a grid's values lie around each place: the largest less the smallest within a 32nd of the sides.
pub fn variation(grid: &Grid) -> Grid {
    let reach = [(grid.columns / 32).max(1), (grid.rows / 32).max(1)];
    let around = |k: usize, n: usize, reach: usize| k.saturating_sub(reach)..(k + reach + 1).min(n);
    let spread = |k: usize| {
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for j in around(k / grid.columns, grid.rows, reach[1]) {
            for i in around(k % grid.columns, grid.columns, reach[0]) {
                let v = grid.values[j * grid.columns + i];
                (low, high) = (low.min(v), high.max(v));
            }
        }
        high - low
    };
    grid.with((0..grid.values.len()).map(spread).collect())
}

/// The share of places in the tenth of the domain where `variation` is largest.
pub fn share_in_varied_tenth(variation: &Grid, places: &[[f64; 2]]) -> f64 {
    let mut sorted = variation.values.clone();
    sorted.sort_by(f64::total_cmp);
    let least = sorted[sorted.len() * 9 / 10];
    let cell = |v: f64, ends: [f64; 2], n: usize| (((v - ends[0]) / (ends[1] - ends[0]) * n as f64) as usize).min(n - 1);
    let within = places.iter().filter(|p| {
        let (i, j) = (cell(p[0], variation.x, variation.columns), cell(p[1], variation.y, variation.rows));
        variation.values[j * variation.columns + i] > least
    });
    within.count() as f64 / places.len().max(1) as f64
}

fn fit(function: &Function, goal: &Grid, settings: &Settings) -> Result<Fitted> {
    let mut plane = Plane { host: Host, function, seed: settings.seed };
    let (net, samples) = Supervised::train(&mut plane, settings)?;
    let inputs: Vec<Feature> = (0..goal.values.len()).map(|i| feature(goal.place(i))).collect();
    let answers = net.answer(&mut plane.host, settings, &inputs)?;
    let approximation = goal.with(answers.iter().map(|&a| a as f64).collect());
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let off = square(&mut goal.values.iter().zip(&approximation.values).map(|(a, b)| a - b));
    let error = (off / square(&mut goal.values.iter().copied())).sqrt();
    Ok(Fitted { net, places: samples.places, approximation, error })
}

/// Makes the figure.
pub fn make(press: &mut Press, options: &Options) -> Result<Figure> {
    stage(press, "fig2")?;
    options.check()?;
    let function = Function::named(&options.function)?;
    let goal = Grid::of(options.points, options.points, [0.0, 1.0], [0.0, 1.0], |x, y| function.at(x, y));
    let settings = Settings {
        k: options.k,
        dims: 2,
        cells: options.cells,
        evaluations: options.evaluations * options.cells as u64,
        seed: press.seed,
        ..Settings::default()
    };
    let shown = fit(&function, &goal, &settings)?;
    let uniform = fit(&function, &goal, &Settings { resampling: false, ..settings })?;
    let linear = fit(&function, &goal, &Settings { output: Output::Linear, ..settings })?;
    let varied = variation(&goal);

    let mut figure = Figure::new("fig2", "Fig. 2: a function of the plane, learned from samples");
    let axes = [Axis::linear("x", [0.0, 1.0]), Axis::linear("y", [0.0, 1.0])];
    let map = Map::upto(goal.peak());
    let names = Names { x: "x", y: "y", z: "f(x, y)" };
    let cells: Vec<[f64; 2]> = shown.net.cells.iter().map(|c| [c[0] as f64, c[1] as f64]).collect();
    let drawn = draw(1200, 1000, |page| {
        let four = page.split_evenly((2, 2));
        surface(&titled(&four[0], "(a) goal")?, &goal, &map, &names, 72)?;
        let area = titled(&four[1], &format!("(b) {} samples", shown.places.len()))?;
        let mut panel = open(&area, &axes[0], &axes[1], Some(1.0))?;
        panel.heat(&goal, &|v| shade(map.of(v), 0.72))?;
        panel.dots(&shown.places, 0.9, INK)?;
        let area = titled(&four[2], &format!("(c) topology of {} cells, k = {}", cells.len(), options.k))?;
        let mut panel = open(&area, &axes[0], &axes[1], Some(1.0))?;
        panel.heat(&goal, &|v| shade(map.of(v), 0.72))?;
        let ends: Vec<_> = shown.net.complex.edges().iter().map(|e| e.map(|c| cells[c as usize])).collect();
        panel.edges(&ends, SERIES[1], 0.8)?;
        panel.dots(&cells, 1.8, INK)?;
        surface(&titled(&four[3], "(d) approximation")?, &shown.approximation, &map, &names, 72)
    });
    figure.drawing(press, drawn)?;
    let rows = (0..goal.values.len()).map(|i| {
        let [x, y] = goal.place(i);
        vec![x, y, goal.values[i], shown.approximation.values[i]]
    });
    figure.csv(press, ".csv", "x,y,goal,approximation", rows)?;
    figure.csv(press, "_samples.csv", "x,y", shown.places.iter().map(|p| p.to_vec()))?;
    figure.csv(
        press,
        "_cells.csv",
        "x,y,value,width",
        shown
            .net
            .cells
            .iter()
            .zip(&shown.net.outputs)
            .map(|(c, o)| vec![c[0] as f64, c[1] as f64, o.value as f64, o.width as f64]),
    )?;
    figure.csv(press, "_edges.csv", "cell,cell", shown.net.complex.edges().iter().map(|e| e.map(f64::from).to_vec()))?;

    figure.about.push(format!(
        "Supervised growing cell structures as the paper trains them, on the function '{}': (a) the goal, (b) where it was \
         evaluated, (c) the cells and their topology, (d) what the network answers: the Gaussian-weighted mean of the \
         best-matching cell's output and its neighbours'.",
        options.function
    ));
    figure.about.push(format!(
        "Errors are relative L2 norms over {0} x {0} places. Resampling draws inputs uniformly and evaluates them only where \
         the resource (the decayed squared error) is high: {1:.1} % of the samples lie in the tenth of the domain where the \
         goal varies most, against {2:.1} % without it.",
        options.points,
        100.0 * share_in_varied_tenth(&varied, &shown.places),
        100.0 * share_in_varied_tenth(&varied, &uniform.places)
    ));
    figure.number("cells", shown.net.cells.len() as f64, "");
    figure.number("samples", shown.places.len() as f64, "");
    figure.number("error (the paper's: Gaussian cells, resampling)", shown.error, "1");
    figure.number("error without resampling", uniform.error, "1");
    figure.number("error with local linear cells (a repair)", linear.error, "1");
    figure.number(
        "samples in the tenth of the domain where the goal varies most",
        share_in_varied_tenth(&varied, &shown.places),
        "1",
    );
    figure.number("the same without resampling", share_in_varied_tenth(&varied, &uniform.places), "1");
    figure.finish(press)?;
    Ok(figure)
}
