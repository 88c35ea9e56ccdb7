//! All figures on one page of HTML that needs no other file.

use super::Figure;
use crate::error::Result;
use crate::output::atomic;
use crate::plot::panel::number;
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use std::path::Path;

pub(crate) const STYLE: &str = "\
body { font: 16px/1.5 'DejaVu Sans', Verdana, sans-serif; color: #222; max-width: 1240px; margin: 2em auto; padding: 0 1em }
h1, h2 { font-weight: normal } h2 { margin-top: 2.5em; border-top: 1px solid #ccc; padding-top: 1em }
img { width: 100% } p { max-width: 56em } table { border-collapse: collapse; margin: 1em 0 }
td { border-bottom: 1px solid #ddd; padding: .2em 1.2em .2em 0 } td.n { text-align: right } a { color: #0072b2 }";

/// Writes `index.html`. Errors: [`crate::Error::Write`].
pub fn write(dir: &Path, figures: &[Figure]) -> Result<()> {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>raycell paper</title>\n<style>{STYLE}</style>\n\
         <h1>The paper's figures, made again</h1>\n<p>T. Bohn, <em>A neural network representation of three-dimensional \
         geometrical scene descriptions</em>, 1997. Made by <code>raycell paper</code> {}; the same seed on the same device \
         makes the same files.</p>\n",
        env!("CARGO_PKG_VERSION")
    );
    for figure in figures {
        html += &format!("<h2 id=\"{}\">{}</h2>\n", figure.name, escape(&figure.title));
        html += &format!(
            "<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n",
            escape(&figure.title),
            BASE64_STANDARD.encode(&figure.png)
        );
        for paragraph in &figure.about {
            html += &format!("<p>{}</p>\n", escape(paragraph));
        }
        html += "<table>\n";
        for n in &figure.numbers {
            // Ratios are read as shares.
            let (value, unit) = if n.unit == "1" { (100.0 * n.value, "%") } else { (n.value, n.unit) };
            html += &format!("<tr><td>{}</td><td class=\"n\">{} {unit}</td></tr>\n", escape(&n.what), number(value));
        }
        let links: Vec<String> = figure.files.iter().map(|f| format!("<a href=\"{f}\">{f}</a>")).collect();
        html += &format!("</table>\n<p>{}</p>\n", links.join(" · "));
    }
    html += "</html>\n";
    atomic::write(&dir.join("index.html"), html.as_bytes())
}

pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
