//! Plots for reports: drawn once, as PNG and as SVG.
//!
//! A sheet is a page; panels ([`panel`], [`surface`], [`picture`]) draw into its areas. Sizes are in units of the
//! page; a PNG has a pixel a unit.

pub mod color;
pub mod panel;
pub mod picture;
mod sheet;
pub mod surface;

pub use color::Map;
pub use sheet::{Area, Drawing, draw, png, unit};

/// What drawing may fail with.
pub type Fault = Box<dyn std::error::Error + Send + Sync>;

/// A matrix of numbers over a rectangle: `values[row * columns + column]`, rows from below.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Values along x.
    pub columns: usize,
    /// Values along y.
    pub rows: usize,
    /// The values, at the middles of equal cells.
    pub values: Vec<f64>,
    /// The rectangle's ends along x.
    pub x: [f64; 2],
    /// The rectangle's ends along y.
    pub y: [f64; 2],
}

impl Grid {
    /// A grid of the values of a function at the middles of its cells.
    pub fn of(columns: usize, rows: usize, x: [f64; 2], y: [f64; 2], mut f: impl FnMut(f64, f64) -> f64) -> Grid {
        let mut grid = Grid { columns, rows, values: vec![0.0; columns * rows], x, y };
        for i in 0..columns * rows {
            let [at_x, at_y] = grid.place(i);
            grid.values[i] = f(at_x, at_y);
        }
        grid
    }

    /// A grid of other values over the same places.
    pub fn with(&self, values: Vec<f64>) -> Grid {
        Grid { values, ..self.clone() }
    }

    /// The middle of a cell.
    pub fn place(&self, i: usize) -> [f64; 2] {
        let along = |ends: [f64; 2], k: usize, n: usize| ends[0] + (ends[1] - ends[0]) * (k as f64 + 0.5) / n as f64;
        [along(self.x, i % self.columns, self.columns), along(self.y, i / self.columns, self.rows)]
    }

    /// The largest value, 0 or more.
    pub fn peak(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }
}
