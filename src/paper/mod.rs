//! The figures of the paper, made again: Bohn, "A neural network representation of three-dimensional geometrical
//! scene descriptions", 1997. A file a figure; [`page`] puts them on one page.

mod dense;
pub mod fig1;
pub mod fig2;
pub mod fig3;
pub mod fig4;
mod kernel;
pub mod page;

use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::output::{self, atomic};
use crate::plot::{Drawing, Fault};
use crate::progress::{Event, Flow};
use crate::solution::Image;
use std::path::Path;

/// What figures are made with, and where to.
pub struct Press<'a> {
    /// Folder that gets the files; it exists.
    pub dir: &'a Path,
    /// What passes run on.
    pub backend: &'a Backend,
    /// Seed of every random sequence.
    pub seed: u32,
    /// Hears what happens.
    pub tell: &'a mut dyn FnMut(&Event) -> Flow,
}

/// A number that a figure tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// What it is.
    pub what: String,
    /// Its value.
    pub value: f64,
    /// Its unit; "1" for ratios.
    pub unit: &'static str,
}

/// A figure that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of its files.
    pub name: &'static str,
    /// Its heading.
    pub title: String,
    /// What it shows, and how its numbers are made; a string a paragraph.
    pub about: Vec<String>,
    /// What it tells in numbers.
    pub numbers: Vec<Number>,
    /// The PNG.
    pub png: Vec<u8>,
    /// Files written, without their folder.
    pub files: Vec<String>,
}

impl Figure {
    /// A figure without numbers or files yet.
    pub fn new(name: &'static str, title: &str) -> Figure {
        let title = title.to_string();
        Figure { name, title, about: Vec::new(), numbers: Vec::new(), png: Vec::new(), files: Vec::new() }
    }

    /// Adds a number.
    pub fn number(&mut self, what: impl Into<String>, value: f64, unit: &'static str) {
        self.numbers.push(Number { what: what.into(), value, unit });
    }

    /// Writes the drawing as PNG and SVG. Errors: [`Error::Write`].
    pub fn drawing(&mut self, press: &Press, drawn: std::result::Result<Drawing, Fault>) -> Result<()> {
        let drawn = drawn
            .map_err(|e| Error::Write { path: press.dir.join(format!("{}.png", self.name)), source: std::io::Error::other(e) })?;
        self.file(press, ".svg", drawn.svg.as_bytes())?;
        self.file(press, ".png", &drawn.png)?;
        self.png = drawn.png;
        Ok(())
    }

    /// Writes rows of numbers as `NAME` + `suffix`. Errors: [`Error::NotFinite`], [`Error::Write`].
    pub fn csv(&mut self, press: &Press, suffix: &str, header: &str, rows: impl Iterator<Item = Vec<f64>>) -> Result<()> {
        let mut text = format!("{header}\n");
        for row in rows {
            if !row.iter().all(|x| x.is_finite()) {
                return Err(Error::NotFinite { what: format!("a number of {}{suffix}", self.name) });
            }
            let cells: Vec<String> = row.iter().map(|x| format!("{}", *x as f32)).collect();
            text += &cells.join(",");
            text.push('\n');
        }
        self.file(press, suffix, text.as_bytes())
    }

    /// Writes a picture's linear radiance as `NAME_WHAT.exr`. Errors: those of [`output::image::write`].
    pub fn exr(&mut self, press: &Press, what: &str, image: &Image) -> Result<()> {
        let name = format!("{}_{what}.exr", self.name);
        output::image::write(&press.dir.join(&name), image, None)?;
        self.files.push(name);
        Ok(())
    }

    /// Writes the figure's numbers. Errors: [`Error::NotFinite`], [`Error::Write`].
    pub fn finish(&mut self, press: &Press) -> Result<()> {
        let mut text = "quantity,value,unit\n".to_string();
        for n in &self.numbers {
            if !n.value.is_finite() {
                return Err(Error::NotFinite { what: format!("'{}' of {}", n.what, self.name) });
            }
            text += &format!("\"{}\",{},{}\n", n.what, n.value, n.unit);
        }
        self.file(press, "_numbers.csv", text.as_bytes())
    }

    /// Writes a file of the figure. Errors: [`Error::Write`].
    pub fn file(&mut self, press: &Press, suffix: &str, bytes: &[u8]) -> Result<()> {
        let name = format!("{}{suffix}", self.name);
        atomic::write(&press.dir.join(&name), bytes)?;
        self.files.push(name);
        Ok(())
    }
}

/// Tells the stage; the listener may stop it.
fn stage(press: &mut Press, name: &'static str) -> Result<()> {
    match (press.tell)(&Event::Stage { name }) {
        Flow::Continue => Ok(()),
        Flow::Stop => Err(Error::Cancelled),
    }
}
