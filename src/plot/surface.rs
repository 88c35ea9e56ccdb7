//! A height field as a surface in space, seen from the front and above, as the paper draws its kernels.

use super::color::{GREY, Map, shade};
use super::panel::{number, text};
use super::sheet::{Area, unit};
use super::{Fault, Grid};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// How the axes of a surface are called.
pub struct Names<'a> {
    /// Along the front edge.
    pub x: &'a str,
    /// Along the right edge.
    pub y: &'a str,
    /// Upwards.
    pub z: &'a str,
}

/// Direction of view: turned about the vertical, then raised; radians.
const AZIMUTH: f64 = -0.62;
const ELEVATION: f64 = 0.62;
/// Height of the box, where its sides are 1.
const HEIGHT: f64 = 0.62;
/// Height of a line of text, units.
const TEXT: f64 = 13.0;

/// Turns a place in the unit box into one on the page, and its depth away from the eye.
fn project([x, y, z]: [f64; 3]) -> ([f64; 2], f64) {
    let (x, y) = (x - 0.5, y - 0.5);
    let (s, c) = AZIMUTH.sin_cos();
    let (across, away) = (c * x - s * y, s * x + c * y);
    let (s, c) = ELEVATION.sin_cos();
    let up = HEIGHT * z;
    ([across, -(s * away + c * up)], c * away - s * up)
}

/// Draws values up to `map.high` as heights. `quads` patches along each side show them.
pub fn surface(area: &Area, grid: &Grid, map: &Map, names: &Names, quads: usize) -> Result<(), Fault> {
    let (width, height) = area.dim_in_pixel();
    // The box's outline, for the scale of the page.
    let corners: Vec<[f64; 2]> = (0..8).map(|i| project([(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64]).0).collect();
    let ends = |k: usize| {
        let all = corners.iter().map(|c| c[k]);
        (all.clone().fold(f64::MAX, f64::min), all.fold(f64::MIN, f64::max))
    };
    let ((left, right), (top, bottom)) = (ends(0), ends(1));
    let (free_w, free_h) = (width as f64 - unit(90.0) as f64, height as f64 - unit(64.0) as f64);
    let scale = (free_w / (right - left)).min(free_h / (bottom - top));
    let origin = [0.5 * width as f64 - 0.5 * (left + right) * scale, 0.5 * height as f64 - 0.5 * (top + bottom) * scale];
    let page = |p: [f64; 3]| {
        let ([x, y], _) = project(p);
        ((origin[0] + scale * x).round() as i32, (origin[1] + scale * y).round() as i32 - unit(6.0))
    };
    let line = |from: [f64; 3], to: [f64; 3]| PathElement::new(vec![page(from), page(to)], GREY.stroke_width(unit(0.7) as u32));

    // The floor and the two walls behind.
    for (from, to) in [
        ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0]),
        ([0.0, 1.0, 0.0], [1.0, 1.0, 0.0]),
        ([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 1.0, 0.0], [0.0, 1.0, 1.0]),
        ([1.0, 1.0, 0.0], [1.0, 1.0, 1.0]),
        ([0.0, 0.0, 1.0], [0.0, 1.0, 1.0]),
        ([0.0, 1.0, 1.0], [1.0, 1.0, 1.0]),
    ] {
        area.draw(&line(from, to))?;
    }

    // Patches, the farthest first. Each is as bright as its value, and darker where it turns away from the light.
    let at = |i: usize, j: usize| {
        let pick = |k: usize, n: usize| (k * n / quads).min(n - 1);
        let value = grid.values[pick(j, grid.rows) * grid.columns + pick(i, grid.columns)];
        let level = ((value - map.low) / (map.high - map.low)).clamp(0.0, 1.0);
        ([i as f64 / quads as f64, j as f64 / quads as f64, level], value)
    };
    let mut patches: Vec<(f64, [[f64; 3]; 4], f64)> = Vec::new();
    for i in 0..quads {
        for j in 0..quads {
            let four = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let places = four.map(|f| f.0);
            // By the ground below, not by the height: towers do not overtake.
            let middle = project([places[0][0], places[0][1], 0.0]).1;
            patches.push((middle, places, four.iter().map(|f| f.1).sum::<f64>() / 4.0));
        }
    }
    patches.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, places, value) in patches {
        let slope = [places[1][2] - places[0][2], places[3][2] - places[0][2]].map(|d| d * HEIGHT * quads as f64);
        let facing = (1.0 - 0.5 * slope[0] - 0.3 * slope[1]) / (1.35 * (1.0 + slope[0].powi(2) + slope[1].powi(2)).sqrt());
        let color = shade(map.of(value), 0.5 * (facing.clamp(0.0, 1.0) - 0.75));
        let path: Vec<_> = places.iter().map(|&p| page(p)).collect();
        area.draw(&Polygon::new(path.clone(), color.filled()))?;
        let outline = path.iter().copied().chain(path.first().copied()).collect::<Vec<_>>();
        area.draw(&PathElement::new(outline, shade(color, -0.25).stroke_width(1)))?;
    }

    // Ends of the axes, and their names.
    let words = |words: String, p: [f64; 3], dx: f64, dy: f64, h: HPos| {
        let (x, y) = page(p);
        Text::new(words, (x + unit(dx), y + unit(dy)), text(TEXT).pos(Pos::new(h, VPos::Center)))
    };
    for (k, value) in grid.x.iter().enumerate() {
        area.draw(&words(number(*value), [k as f64, 0.0, 0.0], -4.0, 10.0, HPos::Center))?;
    }
    for (k, value) in grid.y.iter().enumerate() {
        area.draw(&words(number(*value), [1.0, k as f64, 0.0], 8.0, 7.0, HPos::Left))?;
    }
    area.draw(&words(names.x.into(), [0.5, 0.0, 0.0], -12.0, 18.0, HPos::Center))?;
    area.draw(&words(names.y.into(), [1.0, 0.5, 0.0], 12.0, 12.0, HPos::Left))?;
    area.draw(&words(number(map.high), [0.0, 0.0, 1.0], -6.0, 0.0, HPos::Right))?;
    area.draw(&words(number(map.low), [0.0, 0.0, 0.0], -8.0, -2.0, HPos::Right))?;
    area.draw(&words(names.z.into(), [0.0, 0.0, 1.0], -8.0, -16.0, HPos::Center))?;
    Ok(())
}
