//! What commands that leave a folder read out of a solution, and the files of it.

use super::super::log::Log;
use super::interrupt::heed;
use super::machine::Machine;
use super::points::off_surface;
use crate::effects::{self, Name};
use crate::error::{Error, Result};
use crate::output::mesh::Mesh;
use crate::output::report::Report;
use crate::output::{glb, image, ply, points};
use crate::progress::Event;
use crate::solution::{self, Answer, Image, Solution, SurfacePoint};
use clap::ValueEnum;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

#[derive(Clone, Copy, ValueEnum)]
pub enum Vertices {
    /// Radiosity in W/m2, beside colours to look at.
    Ply,
    /// Binary glTF with radiance B/pi in COLOR_0, for engines and viewers.
    Glb,
}

/// Refuses a folder that cannot be one, before the work and without making it.
pub fn check_folder(path: &Path) -> Result<()> {
    if path.exists() && !path.is_dir() {
        let source = std::io::Error::from(std::io::ErrorKind::NotADirectory);
        return Err(Error::Write { path: path.into(), source });
    }
    Ok(())
}

/// What is read out of a solution.
pub struct Asked<'a> {
    pub points: Option<&'a [SurfacePoint]>,
    pub camera: Option<solution::Camera>,
    pub vertices: bool,
}

/// Points, and pixels a side, that tell how long all of them take.
const SAMPLE: usize = 128;

impl Asked<'_> {
    /// How long the read-out of such a solution takes, from a sample of it.
    pub fn cost(&self, machine: &Machine, solution: &Solution) -> Result<Duration> {
        let mut seconds = 0.0;
        let mut timed = |all: f64, of: f64, work: &mut dyn FnMut() -> Result<()>| {
            let start = Instant::now();
            let done = work();
            seconds += start.elapsed().as_secs_f64() * (all / of).max(1.0);
            done
        };
        if let Some(points) = self.points.filter(|p| !p.is_empty()) {
            let some: Vec<SurfacePoint> = points.iter().step_by(points.len().div_ceil(SAMPLE)).copied().collect();
            timed(points.len() as f64, some.len() as f64, &mut || solution.query(&machine.backend, &some).map(drop))?;
        }
        if let Some(camera) = self.camera {
            let [width, height] = [camera.width, camera.height].map(|n| n.min(SAMPLE as u32 / 2));
            let small = solution::Camera { width, height, ..camera };
            let pixels = |c: &solution::Camera| f64::from(c.width) * f64::from(c.height);
            timed(pixels(&camera), pixels(&small), &mut || solution.render(&machine.backend, &small).map(drop))?;
        }
        if self.vertices {
            let (nodes, geometry) = (solution.nodes(), solution.geometry());
            let places: Vec<SurfacePoint> = nodes
                .iter()
                .step_by(nodes.len().div_ceil(SAMPLE).max(1))
                .map(|n| SurfacePoint { p: geometry.to_world(n.p), n: n.n.map(f64::from) })
                .collect();
            let all = 3.0 * solution.scene().faces.len() as f64;
            timed(all, places.len().max(1) as f64, &mut || solution.query(&machine.backend, &places).map(drop))?;
        }
        Ok(Duration::from_secs_f64(seconds))
    }

    /// Reads it out.
    pub fn show(&self, machine: &Machine, solution: &Solution, log: &mut Log, stop: &AtomicBool) -> Result<Shown> {
        let (backend, begin) = (&machine.backend, Instant::now());
        log.event(&Event::Stage { name: "readout" });
        let mut spent = Vec::new();
        let mut heed = |log: &mut Log, event: &Event| {
            if let Event::Spent { effect, seconds } = *event {
                spent.push((effect, seconds));
            }
            heed(log, stop, event)
        };
        let answers = self.points.map(|p| solution.query_with(backend, p, &mut |event| heed(log, event))).transpose();
        let answers = machine.judge("the points", answers)?;
        let picture = self.camera.map(|c| solution.render_with(backend, &c, &mut |event| heed(log, event))).transpose();
        let picture = machine.judge("the picture", picture)?;
        let mesh = self.vertices.then(|| solution.vertices_with(backend, &mut |event| heed(log, event))).transpose();
        let mesh = machine.judge("the vertices", mesh)?;
        Ok(Shown { answers, picture, mesh, readout: begin.elapsed(), spent })
    }
}

/// What was read out of a solution.
pub struct Shown {
    answers: Option<Vec<Answer>>,
    picture: Option<Image>,
    mesh: Option<Mesh>,
    /// How long it took.
    pub readout: Duration,
    /// What effects took of it, seconds.
    spent: Vec<(Name, f64)>,
}

impl Shown {
    /// Tells a report what it took.
    pub fn tell(&self, report: &mut Report) {
        report.seconds.readout = Some(self.readout.as_secs_f64());
        effects::spend(report.effects.as_deref_mut().unwrap_or_default(), self.spent.iter().copied());
    }

    /// Writes it into a folder: points.csv, vertices.ply or .glb, picture.exr and .png.
    pub fn write(
        &self,
        dir: &Path,
        points_in: Option<&[SurfacePoint]>,
        vertices: Option<Vertices>,
        exposure: Option<f64>,
        log: &Log,
    ) -> Result<()> {
        let wrote = |name: &str, note: &str| log.line(&format!("wrote {}{note}", dir.join(name).display()));
        if let (Some(p), Some(a)) = (points_in, &self.answers) {
            points::write(&dir.join("points.csv"), p, a)?;
            wrote("points.csv", &off_surface(a));
        }
        match (vertices, &self.mesh) {
            (Some(Vertices::Ply), Some(mesh)) => {
                ply::write(&dir.join("vertices.ply"), mesh)?;
                wrote("vertices.ply", "");
            }
            (Some(Vertices::Glb), Some(mesh)) => {
                glb::write(&dir.join("vertices.glb"), mesh)?;
                wrote("vertices.glb", " (linear radiance in COLOR_0)");
            }
            _ => {}
        }
        if let Some(picture) = &self.picture {
            image::write(&dir.join("picture.exr"), picture, None)?;
            wrote("picture.exr", " (linear radiance)");
            let tone = image::write(&dir.join("picture.png"), picture, exposure)?;
            wrote("picture.png", &tone.map_or(String::new(), |t| format!(" ({t})")));
        }
        Ok(())
    }
}
