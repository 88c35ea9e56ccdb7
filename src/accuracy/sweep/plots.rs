//! The plots of a sweep, each as SVG and PNG.

use super::fit::Fit;
use super::ladder::Kind;
use super::record::{Record, Row, STAGES};
use crate::plot::color::{GREY, INK, SERIES, shade};
use crate::plot::panel::{Axis, number, open, text, titled};
use crate::plot::{Area, Drawing, Fault, draw, unit};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A method of another program, from its own measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    pub name: String,
    pub points: u64,
    /// Seconds, and RRMSE, median and 90th percentile; shares.
    pub runs: Vec<[f64; 4]>,
}

/// A kind's colour in every plot.
pub fn color_of(kind: Kind) -> RGBColor {
    SERIES[match kind {
        Kind::Network => 0,
        Kind::NetworkDirect => 4,
        Kind::Paper => 3,
        Kind::Fem => 1,
        Kind::Hierarchical => 5,
        Kind::Rays => 2,
    }]
}

/// Dots that belong together.
struct Series<'a> {
    name: &'a str,
    color: RGBColor,
    dots: Vec<[f64; 2]>,
}

/// The ends of a logarithmic axis: at halves of decades, half a decade long or more.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.filter(|v| *v > 0.0 && v.is_finite()).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return [0.1, 10.0];
    }
    let low = (low.log10() * 2.0 - 0.15).floor() / 2.0;
    let high = ((high.log10() * 2.0 + 0.15).ceil() / 2.0).max(low + 0.5);
    [low, high].map(|x| 10f64.powf(x))
}

/// Dots and their lines, both axes logarithmic. Errors are in per cent.
fn curves(area: &Area, title: &str, x: &str, y: &str, series: &[Series]) -> Result<(), Fault> {
    let area = titled(area, title)?;
    let all = || series.iter().flat_map(|s| s.dots.iter());
    if all().next().is_none() {
        area.draw(&Text::new("not known", (unit(60.0), unit(40.0)), text(14.0)))?;
        return Ok(());
    }
    let (across, up) = (ends(all().map(|d| d[0])), ends(all().map(|d| d[1])));
    let mut panel = open(&area, &Axis::log(x, across), &Axis::log(y, up), None)?;
    for s in series {
        if let Some(fit) = Fit::new(&s.dots) {
            // The part of the fitted line that lies on the panel.
            let line: Vec<[f64; 2]> = (0..=32)
                .map(|i| fit.costs[0] * (fit.costs[1] / fit.costs[0]).powf(i as f64 / 32.0))
                .map(|c| [c, fit.error_at(c)])
                .filter(|p| p[1] >= up[0] && p[1] <= up[1])
                .collect();
            panel.line(&line, shade(s.color, 0.35), 1.5)?;
        }
        panel.dots(&s.dots, 3.2, s.color)?;
    }
    Ok(())
}

/// Three panels, and above them what their colours are.
fn three(panels: [(&str, &str, &str, Vec<Series>); 3]) -> Result<Drawing, Fault> {
    draw(1260, 460, |page| {
        let (above, below) = page.split_vertically(unit(34.0));
        let mut x = 60.0;
        for s in &panels[0].3 {
            swatch(&above, [x, x + 14.0], [12.0, 24.0], s.color)?;
            words(&above, [x + 20.0, 18.0], s.name, HPos::Left)?;
            x += 60.0 + 7.6 * s.name.len() as f64;
        }
        for (area, (title, x, y, series)) in below.split_evenly((1, 3)).iter().zip(&panels) {
            curves(area, title, x, y, series)?;
        }
        Ok(())
    })
}

fn words(area: &Area, at: [f64; 2], words: &str, h: HPos) -> Result<(), Fault> {
    let style = text(13.0).pos(Pos::new(h, VPos::Center));
    Ok(area.draw(&Text::new(words.to_string(), (unit(at[0]), unit(at[1])), style))?)
}

fn swatch(area: &Area, x: [f64; 2], y: [f64; 2], color: RGBColor) -> Result<(), Fault> {
    let corners = [(unit(x[0]), unit(y[0])), (unit(x[1]), unit(y[1]))];
    Ok(area.draw(&Rectangle::new(corners, color.filled()))?)
}

fn series<'a>(record: &Record, of: impl Fn(&Row) -> Option<[f64; 2]>) -> Vec<Series<'a>> {
    let dots = |kind: Kind| record.of_kind(kind).into_iter().filter_map(&of).filter(|d| d[0] > 0.0 && d[1] > 0.0).collect();
    record.kinds().into_iter().map(|kind| Series { name: kind.title(), color: color_of(kind), dots: dots(kind) }).collect()
}

/// Error against seconds: RRMSE, median, 90th percentile.
pub fn errors(record: &Record, peers: &[Peer]) -> Result<Drawing, Fault> {
    type Of = fn(&Row) -> Option<f64>;
    let measures: [(&str, &str, Of); 3] = [
        ("RRMSE", "RRMSE, %", |r| r.is_clear().then_some(r.rrmse)),
        ("median point", "relative error, %", |r| r.median),
        ("90th percentile of points", "relative error, %", |r| r.p90),
    ];
    let mut k = 0;
    three(measures.map(|(title, y, of)| {
        let mut series = series(record, |r| Some([r.seconds(), 100.0 * of(r)?]));
        k += 1;
        for peer in peers {
            let dots = peer.runs.iter().map(|r| [r[0], 100.0 * r[k]]).collect();
            series.push(Series { name: &peer.name, color: GREY, dots });
        }
        (title, "seconds: bake and read-out", y, series)
    }))
}

/// RRMSE against rays, stored coefficients and memory.
pub fn resources(record: &Record) -> Result<Drawing, Fault> {
    type Of = fn(&Row) -> Option<f64>;
    let costs: [(&str, &str, Of); 3] = [
        ("work", "rays, or evaluations of the kernel", |r| Some(r.rays as f64)),
        ("what is stored", "coefficients", |r| Some(r.coefficients as f64)),
        ("memory", "MiB of device buffers, at most", |r| r.device_bytes.map(|b| b as f64 / 1048576.0)),
    ];
    three(
        costs.map(|(title, x, of)| (title, x, "RRMSE, %", series(record, |r| r.is_clear().then_some([of(r)?, 100.0 * r.rrmse])))),
    )
}

/// The estimate of every run beside its true error; none where no run has an estimate.
pub fn estimates(record: &Record) -> Option<Result<Drawing, Fault>> {
    let rows: Vec<&Row> = record.rows.iter().filter(|r| r.estimate.is_some() && r.rrmse > 0.0).collect();
    if rows.is_empty() {
        return None;
    }
    let values = rows.iter().flat_map(|r| r.estimate.map(|e| [r.rrmse, e.low, e.high])).flatten().map(|x| 100.0 * x);
    let ends = ends(values);
    Some(draw(640, 600, |page| {
        let area = titled(page, "The estimate beside the true error: on the line they agree")?;
        let mut panel = open(&area, &Axis::log("true RRMSE, %", ends), &Axis::log("estimated RRMSE, %", ends), Some(1.0))?;
        panel.line(&[[ends[0]; 2], [ends[1]; 2]], GREY, 1.0)?;
        for r in &rows {
            if let Some(e) = r.estimate {
                let [x, low, high] = [r.rrmse, e.low, e.high].map(|x| (100.0 * x).clamp(ends[0], ends[1]));
                panel.line(&[[x, low], [x, high]], shade(color_of(r.method), 0.4), 1.2)?;
                panel.dots(&[[x, (100.0 * e.rrmse).clamp(ends[0], ends[1])]], 3.2, color_of(r.method))?;
            }
        }
        let kinds: Vec<(&str, RGBColor)> = record
            .kinds()
            .into_iter()
            .filter(|&k| rows.iter().any(|r| r.method == k))
            .map(|k| (k.title(), color_of(k)))
            .collect();
        panel.legend(&kinds, true)
    }))
}

/// Shades of the stages, as [`STAGES`].
const STAGE_COLORS: [RGBColor; 8] =
    [RGBColor(90, 90, 90), SERIES[0], SERIES[4], SERIES[1], SERIES[2], SERIES[3], RGBColor(205, 205, 205), SERIES[5]];

/// Where the time goes: a bar a setting, its stages as shares, its seconds at its end.
pub fn stages(record: &Record) -> Result<Drawing, Fault> {
    let mut bars: Vec<(Kind, u32, [f64; 8])> = Vec::new();
    for kind in record.kinds() {
        let rows = record.of_kind(kind);
        for group in rows.chunk_by(|a, b| a.size == b.size) {
            let mean = |k: usize| group.iter().map(|r| r.stages[k]).sum::<f64>() / group.len() as f64;
            bars.push((kind, group[0].size, std::array::from_fn(mean)));
        }
    }
    let (height, label, width) = (20.0, 330.0, 760.0);
    draw(1260, (70.0 + height * bars.len() as f64) as u32, |page| {
        let mut x = label;
        for (name, color) in STAGES.iter().zip(STAGE_COLORS) {
            swatch(page, [x, x + 12.0], [18.0, 30.0], color)?;
            words(page, [x + 17.0, 24.0], name, HPos::Left)?;
            x += 30.0 + 8.5 * name.len() as f64;
        }
        let mut y = 46.0;
        for (kind, size, seconds) in &bars {
            words(page, [label - 10.0, y + 0.5 * height], &format!("{}, {}", kind.title(), kind.setting(*size)), HPos::Right)?;
            let total: f64 = seconds.iter().sum();
            let mut x = label;
            for (s, color) in seconds.iter().zip(STAGE_COLORS) {
                let w = width * s / total.max(1e-12);
                if w > 0.3 {
                    swatch(page, [x, x + w], [y + 3.0, y + height - 3.0], color)?;
                }
                x += w;
            }
            words(page, [label + width + 10.0, y + 0.5 * height], &format!("{} s", number(total)), HPos::Left)?;
            y += height;
        }
        page.draw(&PathElement::new(vec![(unit(label), unit(44.0)), (unit(label), unit(y))], INK.stroke_width(1)))?;
        Ok(())
    })
}
