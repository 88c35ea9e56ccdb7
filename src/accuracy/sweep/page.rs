//! The sweep on one page of HTML that needs no other file and asks no network.

use super::fit::{Fit, Forecast};
use super::ladder::{Kind, thousands};
use super::looks::{FULL, LEVELS};
use super::plots::Peer;
use super::record::{Look, Record, Row};
use crate::error::Result;
use crate::output::atomic;
use crate::paper::page::{STYLE, escape};
use crate::plot::panel::number;
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use std::path::Path;

/// Errors whose cost is foretold.
const GOALS: [f64; 4] = [0.05, 0.02, 0.01, 0.005];

const MORE: &str = "
svg { width: 100%; height: auto; margin: 1em 0 } p, li { max-width: 62em } th { text-align: left; font-weight: normal; color: #666 }
td, th { padding: .2em 1.2em .2em 0; white-space: nowrap; border-bottom: 1px solid #ddd } td.n, th.n { text-align: right }
.looks { display: flex; flex-wrap: wrap; gap: 1.2em } figure { margin: 0; width: 250px }
figure img { width: 250px; image-rendering: pixelated; display: block; margin-bottom: .3em } figcaption { font-size: 85%; line-height: 1.35 }
.wide { overflow-x: auto } .dim { color: #777 } .key { display: inline-block; width: .9em; height: .9em; margin-right: .4em }";

/// Seconds as people say them.
pub fn duration(seconds: f64) -> String {
    let with =
        |x: f64, unit: &str| format!("{} {unit}", if x < 10.0 { number((x * 10.0).round() / 10.0) } else { format!("{x:.0}") });
    match seconds {
        s if !s.is_finite() => "never".into(),
        s if s < 0.1 => "under 0.1 s".into(),
        s if s < 100.0 => with(s, "s"),
        s if s < 6000.0 => with(s / 60.0, "min"),
        s if s < 172_800.0 => with(s / 3600.0, "h"),
        s if s < 3.2e7 => with(s / 86_400.0, "days"),
        _ => "over a year".into(),
    }
}

fn cent(x: f64) -> String {
    format!("{} %", number(100.0 * x))
}

/// The line through a kind's runs, error against seconds.
pub fn fit(record: &Record, kind: Kind) -> Option<Fit> {
    let rows = record.of_kind(kind);
    Fit::new(&rows.iter().filter(|r| r.is_clear()).map(|r| [r.seconds(), r.rrmse]).collect::<Vec<_>>())
}

/// What halving a method's error costs, in a sentence.
pub fn sentence(record: &Record, kind: Kind) -> String {
    let rows = record.of_kind(kind);
    let Some(f) = fit(record, kind) else {
        let settings = rows.chunk_by(|a, b| a.size == b.size).count();
        let clear: Vec<&&Row> = rows.iter().filter(|r| r.is_clear()).collect();
        let (Some(first), Some(last), true) = (clear.first(), clear.last(), settings > 2) else {
            let why = if settings > 2 { "its errors are lost in the reference's noise" } else { "a line takes three settings" };
            return format!("{}: nothing to say yet; {why}.", kind.title());
        };
        let ends = [first, last].map(|r| format!("{} in {}", cent(r.rrmse), duration(r.seconds())));
        return format!("{}: its settings take too nearly the same time for a line ({} to {}).", kind.title(), ends[0], ends[1]);
    };
    let [from, to] = f.costs;
    let span = format!("{} in {} to {} in {}", cent(f.errors[0]), duration(from), cent(f.errors[1]), duration(to));
    match f.halving() {
        Some(times) if times < 1e4 => format!(
            "{}: halving the error costs ×{} time ({span}; error ~ seconds^-{:.2} ± {:.2}).",
            kind.title(),
            number(times),
            f.exponent,
            f.exponent_error
        ),
        _ if seems_to_fall(&f) => format!(
            "{}: the error falls ({span}), but its times are too few or too uneven to say what halving costs; more --seeds would.",
            kind.title()
        ),
        _ => format!("{}: more time does not bring the error down here ({span}).", kind.title()),
    }
}

/// Whether a line falls by a good part, surely or not.
fn seems_to_fall(line: &Fit) -> bool {
    line.errors[1] < 0.75 * line.errors[0]
}

/// A forecast in words. What is cheaper than all runs is not told to the second: a bake takes its least time whatever it does.
pub fn forecast(line: &Fit, f: Option<Forecast>) -> String {
    match f {
        None if seems_to_fall(line) => "not known".into(),
        None => "not this way".into(),
        Some(f) if f.beyond && f.cost < line.costs[0] => format!("under {}", duration(line.costs[0])),
        Some(f) => {
            let far = if f.beyond { "*" } else { "" };
            format!("{}{far} ({} to {})", duration(f.cost), duration(f.low), duration(f.high))
        }
    }
}

/// A group of runs that differ by their seed alone.
fn spread(rows: &[&Row], of: impl Fn(&Row) -> Option<f64>) -> Option<[f64; 2]> {
    let values: Vec<f64> = rows.iter().map(|r| of(r)).collect::<Option<_>>()?;
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    Some([mean, variance.sqrt()])
}

/// The table of all settings.
fn runs(record: &Record) -> String {
    let mut html = String::from(
        "<div class=\"wide\"><table>\n<tr><th>method</th><th class=\"n\">setting</th><th class=\"n\">runs</th>\
         <th class=\"n\">RRMSE</th><th class=\"n\">median point</th><th class=\"n\">90th percentile</th><th class=\"n\">estimate</th>\
         <th class=\"n\">bake</th><th class=\"n\">read-out</th><th class=\"n\">rays or evaluations</th><th class=\"n\">coefficients</th>\
         <th class=\"n\">device</th><th class=\"n\">process</th></tr>\n",
    );
    let shares = |x: Option<[f64; 2]>, seeds: usize| match x {
        None => "<span class=\"dim\">not known</span>".to_string(),
        Some([mean, _]) if seeds < 2 => cent(mean),
        Some([mean, spread]) => format!("{} ± {} %", number(100.0 * mean), number(100.0 * spread)),
    };
    let bytes = |x: Option<[f64; 2]>| match x {
        None => "<span class=\"dim\">not known</span>".to_string(),
        Some([b, _]) => format!("{} MiB", number(b / 1048576.0)),
    };
    for kind in record.kinds() {
        for group in record.of_kind(kind).chunk_by(|a, b| a.size == b.size) {
            let n = group.len();
            let mean = |of: fn(&Row) -> f64| spread(group, |r| Some(of(r))).map_or(0.0, |s| s[0]);
            let cells = [
                kind.setting(group[0].size),
                n.to_string(),
                shares(spread(group, |r| Some(r.rrmse)), n),
                shares(spread(group, |r| r.median), n),
                shares(spread(group, |r| r.p90), n),
                shares(spread(group, |r| Some(r.estimate?.rrmse)), n),
                duration(mean(|r| r.bake)),
                duration(mean(|r| r.readout)),
                thousands(mean(|r| r.rays as f64) as u64),
                thousands(mean(|r| r.coefficients as f64) as u64),
                bytes(spread(group, |r| r.device_bytes.map(|b| b as f64))),
                bytes(spread(group, |r| r.host_bytes.map(|b| b as f64))),
            ];
            html += &format!("<tr><td>{}</td>", escape(kind.title()));
            cells.iter().for_each(|c| html += &format!("<td class=\"n\">{c}</td>"));
            html += "</tr>\n";
        }
    }
    html + "</table></div>\n"
}

/// A picture of a file in the folder, packed into the page.
fn image(dir: &Path, file: &str, caption: &str) -> String {
    // What is no longer there is left out.
    let Ok(bytes) = std::fs::read(dir.join(file)) else { return String::new() };
    format!(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{2}</figcaption></figure>\n",
        escape(file),
        BASE64_STANDARD.encode(bytes),
        caption
    )
}

fn looks(dir: &Path, looks: &[Look]) -> String {
    let mut html = String::new();
    for level in LEVELS {
        html += &format!("<h3 id=\"look-{0}\">About {0} %</h3>\n", (100.0 * level).round());
        let Some(look) = looks.iter().find(|l| l.shows == level) else {
            html += "<p class=\"dim\">No run came near it.</p>\n";
            continue;
        };
        let caption = format!(
            "<b>{} error</b>: {}, {} ({} over these pixels)",
            cent(look.level),
            escape(look.method.title()),
            look.method.setting(look.size),
            cent(look.rrmse)
        );
        html += "<div class=\"looks\">\n";
        html += &image(dir, &look.picture, &caption);
        html += &image(dir, "reference.png", "What it should be: path tracing, with a little noise of its own.");
        html += &image(
            dir,
            &look.difference,
            &format!(
                "What is off: red too bright, blue too dark, full colour at {:.0} %; speckle is the path tracer's.",
                100.0 * FULL
            ),
        );
        html += "</div>\n";
    }
    html
}

/// The drawings that the page shows, as SVG; none where there was nothing to draw.
pub struct Drawings {
    pub errors: String,
    pub resources: String,
    pub stages: String,
    pub estimates: Option<String>,
}

/// Writes index.html. Errors: [`crate::Error::Write`].
pub fn write(dir: &Path, record: &Record, peers: &[Peer], drawings: &Drawings) -> Result<()> {
    let title = format!("What accuracy costs: {}", escape(&record.scene));
    let machine = record.adapter.as_ref().map_or("the processor alone (--backend cpu)".into(), |a| {
        format!("{} ({}, {})", escape(&a.name), escape(&a.backend), escape(&a.driver))
    });
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>{STYLE}{MORE}</style>\n\
         <h1>{title}</h1>\n<p>{} triangles, {} runs of raycell {} on {machine}. Errors are RRMSE: the root mean square error of the \
         light at {} points, as a share of the mean light. 1 % is hard to see, 10 % is plain to see \
         (<a href=\"#looks\">pictures</a>).</p>\n",
        thousands(record.triangles),
        record.rows.len(),
        escape(&record.raycell),
        thousands(record.reference.points as u64)
    );

    html += "<h2 id=\"cost\">What halving the error costs</h2>\n<ul>\n";
    for kind in record.kinds() {
        html += &format!("<li>{}</li>\n", escape(&sentence(record, kind)));
    }
    html += "</ul>\n<h2 id=\"forecast\">What would it cost?</h2>\n<p>Seconds on this machine for a bake and its answers at the points, \
             and in brackets the interval that nine of ten further runs would lie in, by the scatter of those made. An asterisk: no \
             run came near, the line goes on beyond them. \"Under\": the cheapest run was better already.</p>\n<div class=\"wide\"><table>\n<tr><th>method</th>";
    GOALS.iter().for_each(|g| html += &format!("<th>{} error</th>", cent(*g)));
    html += "</tr>\n";
    for kind in record.kinds() {
        let line = fit(record, kind);
        html += &format!("<tr><td>{}</td>", escape(kind.title()));
        for goal in GOALS {
            let cell = line.map_or("no line".to_string(), |l| forecast(&l, l.forecast(goal)));
            html += &format!("<td>{cell}</td>");
        }
        html += "</tr>\n";
    }
    html += "</table></div>\n";

    html += &format!(
        "<h2 id=\"errors\">Error against time</h2>\n{}\n<p>A dot is a run; dots of a colour close together are the same setting with \
         another seed, so their distance is chance. Both axes are logarithmic: a straight line that falls by half while time \
         grows fourfold is the square root. Left, the whole; in the middle, the point of which half are better: dark corners \
         count as much as bright walls there; right, that of which nine in ten are better.</p>\n",
        drawings.errors
    );
    for peer in peers {
        html += &format!(
            "<p>Grey: {} at {} points, from its own measurement (<code>--peers</code>); here there are {} points. A path tracer's time \
             grows with the points; it shares nothing between them, caches nothing and is not denoised.</p>\n",
            escape(&peer.name),
            thousands(peer.points),
            thousands(record.reference.points as u64)
        );
    }

    html += "<h2 id=\"looks\">What the errors look like</h2>\n";
    html += &match record.looks.is_empty() {
        true => "<p>No run came near 10, 5, 2 or 1 %, or the camera saw nothing.</p>\n".to_string(),
        false => looks(dir, &record.looks),
    };

    html += "<h2 id=\"estimate\">Does it know its own error?</h2>\n";
    html += &match &drawings.estimates {
        None => "<p>None of these runs gave an estimate of its own error.</p>\n".to_string(),
        Some(svg) => format!(
            "{svg}\n<p>Each run guesses its error without knowing the truth: the dot is the guess, the bar the interval it names. On \
             the grey line the guess is right, above it too careful, below it too proud.</p>\n"
        ),
    };

    html += &format!(
        "<h2 id=\"resources\">Error against work, storage and memory</h2>\n{}\n<p>Rays for networks and raw rays, evaluations of the \
         kernel (a ray each) for finite elements and the hierarchical method. Coefficients are what would be kept to light the \
         scene again. Finite elements hold theirs in the process, not on the device: the last column of <a href=\"#runs\">all \
         settings</a> has both.</p>\n",
        drawings.resources
    );
    html += &format!(
        "<h2 id=\"stages\">Where the time goes</h2>\n{}\n<p>Means over the seeds. readout is the answers at the {} points.</p>\n",
        drawings.stages,
        thousands(record.reference.points as u64)
    );
    html += &format!("<h2 id=\"runs\">All settings</h2>\n{}", runs(record));
    html += "<p>Means over the runs ± their standard deviation. process: most memory the whole process held meanwhile; device: most in \
             its buffers on the device.</p>\n";
    if !record.left_out.is_empty() {
        html += "<p>Left out:</p>\n<ul>\n";
        record.left_out.iter().for_each(|l| html += &format!("<li>{}</li>\n", escape(l)));
        html += "</ul>\n";
    }

    let made = match record.reference.paths {
        Some(paths) => format!(
            "made by path tracing with {} paths a point or more, next event estimation and roulette, without bias",
            thousands(paths)
        ),
        None => format!("given as {}", escape(&record.reference.path)),
    };
    html += &format!(
        "<h2 id=\"how\">How it was measured</h2>\n<p>The reference was {made}; its own noise is {} and taken out of the RRMSE (not out of \
         the median and the percentile). RRMSE is sqrt(mean (B − B*)²) / mean B* over points and colour bands, B the radiosity. Runs \
         whose error is less than half of the noise are not drawn. Seconds count from the scene in memory to the answer at the \
         last point: hierarchy, training, solving, direct light, read-out; kernels were compiled before, in a run that does not \
         count. {} Lines are least squares through \
         single runs, in logarithms.</p>\n<p>Files: <a href=\"sweep.csv\">sweep.csv</a> (a row a run), <a \
         href=\"sweep.json\">sweep.json</a>, the plots as SVG and PNG. The same command goes on with what is missing.</p>\n</html>\n",
        cent(record.reference.noise),
        if record.gather {
            "All methods have the same read-out with its final gathers, which draw them together (<code>--no-gather</code> shows their \
             own errors); paper mode has none."
        } else {
            "All methods have the same read-out, without final gathers."
        }
    );
    atomic::write(&dir.join("index.html"), html.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_scatters_is_not_said_to_stand() {
        // Errors fall to a quarter, times hardly differ and scatter; then errors that stand while times grow.
        let falls = Fit::new(&[[3.3, 0.036], [3.0, 0.034], [2.1, 0.0175], [2.8, 0.017], [4.7, 0.0065], [4.6, 0.0064]]).unwrap();
        assert!(falls.halving().is_none() && forecast(&falls, falls.forecast(0.01)) == "not known");
        let stands = Fit::new(&[[1.0, 0.4], [2.0, 0.41], [4.0, 0.39], [8.0, 0.4]]).unwrap();
        assert_eq!(forecast(&stands, stands.forecast(0.01)), "not this way");
        let line = Fit::new(&[[1.0, 0.08], [4.0, 0.041], [16.0, 0.02], [64.0, 0.0101]]).unwrap();
        assert_eq!(forecast(&line, line.forecast(0.2)), "under 1 s");
        assert!(forecast(&line, line.forecast(0.001)).contains('*'));
    }

    #[test]
    fn durations_read_well() {
        for (seconds, words) in [
            (0.03, "under 0.1 s"),
            (3.21, "3.2 s"),
            (45.2, "45 s"),
            (150.0, "2.5 min"),
            (7200.0, "2 h"),
            (1e6, "12 days"),
            (1e9, "over a year"),
            (f64::INFINITY, "never"),
        ] {
            assert_eq!(duration(seconds), words);
        }
    }
}
