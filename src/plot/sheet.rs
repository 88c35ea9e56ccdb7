//! A page that is drawn on twice at once: as pixels, three a unit and averaged, and as SVG.

use super::{Fault, color};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind, FontTransform};
use std::fmt::Write;
use std::io::Cursor;

/// Points of the page a unit: what makes lines smooth.
const FINE: u32 = 3;
/// The letters of every plot: ASCII, Greek, and a few signs of DejaVu Sans (dejavu-fonts.github.io; free to embed).
static FONT: &[u8] = include_bytes!("DejaVuSans-subset.ttf");

/// A part of a page to draw on.
pub type Area<'a> = DrawingArea<Sheet<'a>, Shift>;

/// A length on the page.
pub fn unit(length: f64) -> i32 {
    (length * FINE as f64).round() as i32
}

/// A finished page.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// As a PNG, a pixel a unit.
    pub png: Vec<u8>,
    /// As SVG.
    pub svg: String,
}

/// Draws a page of `width` x `height` units.
pub fn draw(width: u32, height: u32, work: impl FnOnce(&Area) -> Result<(), Fault>) -> Result<Drawing, Fault> {
    register_font("sans-serif", FontStyle::Normal, FONT).map_err(|_| "the plots' font is broken")?;
    let (w, h) = (width * FINE, height * FINE);
    let mut pixels = vec![255u8; (3 * w * h) as usize];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"DejaVu Sans, Verdana, sans-serif\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    {
        let sheet = Sheet { pixels: BitMapBackend::with_buffer(&mut pixels, (w, h)), svg: &mut svg };
        let area = sheet.into_drawing_area();
        area.fill(&color::PAPER)?;
        work(&area.margin(0, 0, unit(8.0), unit(8.0)))?;
        area.present()?;
    }
    svg.push_str("</svg>\n");

    let (small, width, height) = shrunk(&pixels, w, h);
    Ok(Drawing { png: png(&small, width, height)?, svg })
}

/// An RGB image with a pixel a unit: the mean of the points of each.
fn shrunk(rgb: &[u8], w: u32, h: u32) -> (Vec<u8>, u32, u32) {
    let (width, height) = ((w / FINE).max(1), (h / FINE).max(1));
    let mut small = Vec::with_capacity((3 * width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            for k in 0..3 {
                let (mut sum, mut count) = (0, 0);
                for j in y * FINE..((y + 1) * FINE).min(h) {
                    for i in x * FINE..((x + 1) * FINE).min(w) {
                        sum += rgb[(3 * (j * w + i) + k) as usize] as u32;
                        count += 1;
                    }
                }
                small.push(((sum + count / 2) / count) as u8);
            }
        }
    }
    (small, width, height)
}

/// A PNG of RGB bytes.
pub fn png(rgb: &[u8], width: u32, height: u32) -> Result<Vec<u8>, Fault> {
    use image::ImageEncoder;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let mut bytes = Cursor::new(Vec::new());
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(rgb, width, height, image::ExtendedColorType::Rgb8)?;
    Ok(bytes.into_inner())
}

/// The page.
pub struct Sheet<'a> {
    pixels: BitMapBackend<'a>,
    svg: &'a mut String,
}

/// Fill or stroke, with the opacity where it is not 1.
fn paint(what: &str, color: BackendColor) -> String {
    let (r, g, b) = color.rgb;
    let opacity = if color.alpha < 1.0 { format!(" {what}-opacity=\"{:.3}\"", color.alpha) } else { String::new() };
    format!("{what}=\"#{r:02x}{g:02x}{b:02x}\"{opacity}")
}

fn line<S: BackendStyle>(style: &S) -> String {
    format!("fill=\"none\" {} stroke-width=\"{}\"", paint("stroke", style.color()), style.stroke_width())
}

fn fill_or_line<S: BackendStyle>(style: &S, fill: bool) -> String {
    if fill { paint("fill", style.color()) } else { line(style) }
}

fn points(path: &[BackendCoord]) -> String {
    path.iter().map(|(x, y)| format!("{x},{y}")).collect::<Vec<_>>().join(" ")
}

type Outcome<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

impl<'a> DrawingBackend for Sheet<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.pixels.get_size()
    }

    fn ensure_prepared(&mut self) -> Outcome<'a> {
        self.pixels.ensure_prepared()
    }

    fn present(&mut self) -> Outcome<'a> {
        self.pixels.present()
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Outcome<'a> {
        let _ = writeln!(self.svg, "<rect x=\"{x}\" y=\"{y}\" width=\"1\" height=\"1\" {}/>", paint("fill", color));
        self.pixels.draw_pixel((x, y), color)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Outcome<'a> {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, a: BackendCoord, b: BackendCoord, style: &S, fill: bool) -> Outcome<'a> {
        let (x, y, w, h) = (a.0.min(b.0), a.1.min(b.1), (a.0 - b.0).abs(), (a.1 - b.1).abs());
        let how = fill_or_line(style, fill);
        let _ = writeln!(self.svg, "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {how}/>");
        self.pixels.draw_rect(a, b, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Outcome<'a> {
        let path: Vec<_> = path.into_iter().collect();
        let _ = writeln!(self.svg, "<polyline points=\"{}\" {}/>", points(&path), line(style));
        self.pixels.draw_path(path, style)
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, r: u32, style: &S, fill: bool) -> Outcome<'a> {
        let _ = writeln!(self.svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {}/>", fill_or_line(style, fill));
        self.pixels.draw_circle((x, y), r, style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, vertices: I, style: &S) -> Outcome<'a> {
        let path: Vec<_> = vertices.into_iter().collect();
        let _ = writeln!(self.svg, "<polygon points=\"{}\" {}/>", points(&path), paint("fill", style.color()));
        self.pixels.fill_polygon(path, style)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, pos: BackendCoord) -> Outcome<'a> {
        let (x, y) = pos;
        let anchor = match style.anchor().h_pos {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        let dy = match style.anchor().v_pos {
            VPos::Top => "0.76em",
            VPos::Center => "0.36em",
            VPos::Bottom => "-0.2em",
        };
        let turn = match style.transform() {
            FontTransform::None => String::new(),
            FontTransform::Rotate90 => format!(" transform=\"rotate(90 {x} {y})\""),
            FontTransform::Rotate180 => format!(" transform=\"rotate(180 {x} {y})\""),
            FontTransform::Rotate270 => format!(" transform=\"rotate(270 {x} {y})\""),
        };
        let escaped = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        // A size is the height of a line to plotters, that of an em to SVG.
        let em = style.size() / 1.24;
        let _ = writeln!(
            self.svg,
            "<text x=\"{x}\" y=\"{y}\" dy=\"{dy}\" text-anchor=\"{anchor}\" font-size=\"{em:.1}\" {}{turn}>{escaped}</text>",
            paint("fill", style.color())
        );
        self.pixels.draw_text(text, style, pos)
    }

    fn blit_bitmap(&mut self, (x, y): BackendCoord, (w, h): (u32, u32), rgb: &[u8]) -> Outcome<'a> {
        // As fine as the PNG. What cannot be packed is left out of the SVG and seen in the PNG.
        let (small, sw, sh) = shrunk(rgb, w, h);
        if let Ok(packed) = png(&small, sw, sh) {
            let data = BASE64_STANDARD.encode(packed);
            let href = format!("href=\"data:image/png;base64,{data}\"");
            let _ = writeln!(self.svg, "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" {href}/>");
        }
        self.pixels.blit_bitmap((x, y), (w, h), rgb)
    }
}
