//! Panels with two axes: heat maps, dots, lines.

use super::color::{GREY, INK, Map};
use super::sheet::{Area, Sheet, unit};
use super::{Fault, Grid};
use plotters::chart::ChartContext;
use plotters::coord::types::RangedCoordf64;
use plotters::element::BitMapElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Height of a line of text, units.
const TEXT: f64 = 14.0;
/// Points of a line that are drawn at once.
const PIECE: usize = 8;
/// Height of a line of a title, units.
const TITLE: f64 = 16.0;

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it shows, with its unit.
    pub label: String,
    /// Its ends.
    pub ends: [f64; 2],
    /// Logarithmic to base ten.
    pub log: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str, ends: [f64; 2]) -> Axis {
        Axis { label: label.into(), ends, log: false }
    }

    /// A logarithmic axis.
    pub fn log(label: &str, ends: [f64; 2]) -> Axis {
        Axis { label: label.into(), ends, log: true }
    }

    fn place(&self, x: f64) -> f64 {
        if self.log { x.max(f64::MIN_POSITIVE).log10() } else { x }
    }

    fn tick(&self, x: f64) -> String {
        if !self.log {
            return number(x);
        }
        let value = 10f64.powf(x);
        if (0.001..10_000.0).contains(&value) { number(value) } else { format!("{value:.0e}") }
    }
}

/// A number as short as it reads.
pub fn number(x: f64) -> String {
    if x == 0.0 || x.abs() < 1e-12 {
        return "0".into();
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 8) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// The letters of a plot.
pub fn text(height: f64) -> TextStyle<'static> {
    ("sans-serif", unit(height)).into_font().color(&INK)
}

/// A panel's name above it; the rest of the area.
pub fn titled<'a>(area: &Area<'a>, title: &str) -> Result<Area<'a>, Fault> {
    let (above, below) = area.margin(unit(8.0), unit(4.0), 0, 0).split_vertically(unit(TITLE + 8.0));
    let (width, _) = above.dim_in_pixel();
    let style = text(TITLE).pos(Pos::new(HPos::Center, VPos::Top));
    above.draw(&Text::new(title.to_string(), (width as i32 / 2, unit(1.0)), style))?;
    Ok(below)
}

/// The part of an area with the given ratio of width to height, in its middle.
fn fitted<'a>(area: &Area<'a>, ratio: Option<f64>, margins: [i32; 4]) -> Area<'a> {
    let Some(ratio) = ratio else { return area.clone() };
    let (w, h) = area.dim_in_pixel();
    let [left, right, top, bottom] = margins;
    let (free_w, free_h) = ((w as i32 - left - right) as f64, (h as i32 - top - bottom) as f64);
    let (cut_x, cut_y) = if free_w > free_h * ratio { (free_w - free_h * ratio, 0.0) } else { (0.0, free_h - free_w / ratio) };
    let (x, y) = ((0.5 * cut_x) as i32, (0.5 * cut_y) as i32);
    area.margin(y, y, x, x)
}

/// A panel with axes.
pub struct Panel<'a, 'b> {
    chart: ChartContext<'b, Sheet<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
    x: Axis,
    y: Axis,
}

/// Opens a panel. `ratio`: that of a unit of x to one of y on the page (1 for maps); none fills the area.
pub fn open<'a: 'b, 'b>(area: &'b Area<'a>, x: &Axis, y: &Axis, ratio: Option<f64>) -> Result<Panel<'a, 'b>, Fault> {
    let [x0, x1] = x.ends.map(|v| x.place(v));
    let [y0, y1] = y.ends.map(|v| y.place(v));
    let (left, bottom) = (unit(52.0), unit(40.0));
    let (right, top) = (unit(12.0), unit(8.0));
    let area = fitted(area, ratio.map(|r| r * (x1 - x0).abs() / (y1 - y0).abs()), [left, right, top, bottom]);
    let mut chart = ChartBuilder::on(&area)
        .margin_top(top)
        .margin_right(right)
        .x_label_area_size(bottom)
        .y_label_area_size(left)
        .build_cartesian_2d(x0..x1, y0..y1)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(GREY.stroke_width(unit(0.8) as u32))
        .label_style(text(TEXT - 1.0))
        .axis_desc_style(text(TEXT))
        .x_desc(x.label.clone())
        .y_desc(y.label.clone())
        .x_labels(if x.log { 1 + (x1 - x0).abs() as usize } else { 6 })
        .y_labels(if y.log { 1 + (y1 - y0).abs() as usize } else { 6 })
        .x_label_formatter(&|v| x.tick(*v))
        .y_label_formatter(&|v| y.tick(*v))
        .set_all_tick_mark_size(unit(4.0))
        .draw()?;
    Ok(Panel { chart, x: x.clone(), y: y.clone() })
}

impl<'a, 'b> Panel<'a, 'b> {
    fn at(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        (self.x.place(x), self.y.place(y))
    }

    /// Values as colours.
    pub fn heat(&mut self, grid: &Grid, color: &dyn Fn(f64) -> RGBColor) -> Result<(), Fault> {
        let corner = |x: f64, y: f64| self.chart.backend_coord(&self.at([x, y]));
        let ((left, bottom), (right, top)) = (corner(grid.x[0], grid.y[0]), corner(grid.x[1], grid.y[1]));
        let (width, height) = ((right - left).max(1) as u32, (bottom - top).max(1) as u32);
        let mut rgb = Vec::with_capacity((3 * width * height) as usize);
        for j in 0..height {
            let row = grid.rows - 1 - (j as usize * grid.rows / height as usize).min(grid.rows - 1);
            for i in 0..width {
                let column = i as usize * grid.columns / width as usize;
                let RGBColor(r, g, b) = color(grid.values[row * grid.columns + column]);
                rgb.extend([r, g, b]);
            }
        }
        let at = self.at([grid.x[0], grid.y[1]]);
        let image: BitMapElement<_> =
            BitMapElement::with_owned_buffer(at, (width, height), rgb).ok_or("a heat map of no size")?;
        self.chart.draw_series(std::iter::once(image))?;
        Ok(())
    }

    /// A line through points.
    pub fn line(&mut self, points: &[[f64; 2]], color: RGBColor, width: f64) -> Result<(), Fault> {
        let path: Vec<_> = points.iter().map(|&p| self.at(p)).collect();
        let style = color.stroke_width(unit(width).max(1) as u32);
        // In pieces: filling the outline of a long line takes plotters half a minute.
        let pieces = (0..path.len().saturating_sub(1)).step_by(PIECE);
        let pieces: Vec<_> = pieces.map(|i| PathElement::new(path[i..(i + PIECE + 1).min(path.len())].to_vec(), style)).collect();
        self.chart.draw_series(pieces)?;
        Ok(())
    }

    /// Many lines between two points each.
    pub fn edges(&mut self, edges: &[[[f64; 2]; 2]], color: RGBColor, width: f64) -> Result<(), Fault> {
        edges.iter().try_for_each(|e| self.line(e, color, width))
    }

    /// Dots, `radius` in units.
    pub fn dots(&mut self, points: &[[f64; 2]], radius: f64, color: RGBColor) -> Result<(), Fault> {
        let dots: Vec<_> = points.iter().map(|&p| Circle::new(self.at(p), unit(radius).max(1), color.filled())).collect();
        self.chart.draw_series(dots)?;
        Ok(())
    }

    /// Words at a place: in their middle, or from it on.
    pub fn words(&mut self, at: [f64; 2], words: &str, centred: bool) -> Result<(), Fault> {
        let pos = Pos::new(if centred { HPos::Center } else { HPos::Left }, VPos::Center);
        let text = Text::new(words.to_string(), self.at(at), text(TEXT - 1.0).pos(pos));
        self.chart.draw_series(std::iter::once(text))?;
        Ok(())
    }

    /// What the lines are, in the upper right (or left) corner.
    pub fn legend(&mut self, names: &[(&str, RGBColor)], left: bool) -> Result<(), Fault> {
        let area = self.chart.plotting_area().strip_coord_spec();
        let (width, _) = area.dim_in_pixel();
        for (i, (name, color)) in names.iter().enumerate() {
            let y = unit(12.0 + 17.0 * i as f64);
            let (from, to) = if left { (unit(8.0), unit(30.0)) } else { (width as i32 - unit(30.0), width as i32 - unit(8.0)) };
            area.draw(&PathElement::new(vec![(from, y), (to, y)], color.stroke_width(unit(2.0) as u32)))?;
            let (x, h) = if left { (to + unit(6.0), HPos::Left) } else { (from - unit(6.0), HPos::Right) };
            area.draw(&Text::new(name.to_string(), (x, y), text(TEXT - 1.0).pos(Pos::new(h, VPos::Center))))?;
        }
        Ok(())
    }
}

/// A heat map with its scale at the right.
pub fn heat_map<'a>(
    area: &Area<'a>,
    grid: &Grid,
    axes: [&Axis; 2],
    map: &Map,
    scale: &str,
    ratio: Option<f64>,
    more: impl FnOnce(&mut Panel) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let (width, _) = area.dim_in_pixel();
    let (main, bar) = area.split_horizontally(width as i32 - unit(74.0));
    let mut panel = open(&main, axes[0], axes[1], ratio)?;
    panel.heat(grid, &|v| map.of(v))?;
    more(&mut panel)?;
    let (_, height) = bar.dim_in_pixel();
    let bar = bar.margin(height / 6, height / 6, 0, 0);
    let ramp = Grid::of(1, 128, [0.0, 1.0], [map.low, map.high], |_, y| y);
    let mut chart = ChartBuilder::on(&bar).right_y_label_area_size(unit(56.0)).build_cartesian_2d(0.0..1.0, map.low..map.high)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .axis_style(GREY)
        .label_style(text(TEXT - 2.0))
        .axis_desc_style(text(TEXT - 1.0))
        .y_desc(scale)
        .y_labels(5)
        .y_label_formatter(&|v| number(*v))
        .draw()?;
    let mut panel = Panel { chart, x: Axis::linear("", [0.0, 1.0]), y: Axis::linear("", [map.low, map.high]) };
    panel.heat(&ramp, &|v| map.of(v))
}
