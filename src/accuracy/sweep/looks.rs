//! What an error looks like: a small picture of a run at each level of error, beside one by path tracing.

use super::ladder::Rung;
use super::record::Look;
use super::{Ways, write_png};
use crate::accuracy::reference::{Goal, Reference};
use crate::engine::Backend;
use crate::error::Result;
use crate::layout::{NONE, Point};
use crate::output::image::Tone;
use crate::plot::color;
use crate::progress::{Event, Progress};
use crate::scene::{Geometry, Scene};
use crate::solution::{Camera, Solution, picture::seen};
use glam::DVec3;
use plotters::style::RGBColor;
use std::collections::HashSet;
use std::f64::consts::PI;

/// Levels of error that are shown.
pub const LEVELS: [f64; 4] = [0.1, 0.05, 0.02, 0.01];
/// A run shows a level if its error is this many times the level or less, or its reciprocal.
const NEAR: f64 = 1.7;
/// Pixels across.
const WIDTH: u32 = 160;
/// Paths a pixel of the reference picture.
const PATHS: u64 = 1_024;
/// Relative difference at which the difference picture has its full colour.
pub const FULL: f64 = 0.2;
/// Added to the level that differences are relative to, as a share of the picture's mean: black is not divided by.
const FLOOR: f64 = 0.05;

/// A camera's view with its light by path tracing.
pub struct Looks<'a> {
    pub camera: Camera,
    hits: Vec<Option<Point>>,
    /// Radiosity at the pixels that see something, and the noise of the whole.
    truth: Vec<[f64; 3]>,
    noise: f64,
    tone: Tone,
    ways: &'a Ways<'a>,
}

/// The camera scaled to a small picture.
pub fn small(camera: Camera) -> Camera {
    let width = camera.width.min(WIDTH);
    let height = (width as f64 * camera.height as f64 / camera.width.max(1) as f64).round().clamp(1.0, 320.0) as u32;
    Camera { width, height, ..camera }
}

/// A camera that sees much of a scene: from a corner, from within or from outside, of its bounding box to the middle.
pub fn choose(scene: &Scene, geometry: &Geometry) -> Result<Camera> {
    let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
    for v in &scene.vertices {
        (low, high) = (low.min(DVec3::from_array(*v)), high.max(DVec3::from_array(*v)));
    }
    if scene.is_flatland() {
        high.z = scene.wall_height();
    }
    let up = if scene.is_flatland() { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
    let middle = 0.5 * (low + high);
    let mut best = (-1.0, None);
    for corner in 0..8 {
        for out in [0.9, 0.6, 1.6, 2.4] {
            for one in [None, Some(0), Some(1), Some(2)] {
                // A corner, or the middle of a side.
                let mut way = DVec3::from_array([0, 1, 2].map(|k| if corner >> k & 1 == 0 { -1.0 } else { 1.0 }));
                if let Some(axis) = one {
                    way = DVec3::from_array([0, 1, 2].map(|k| if k == axis { way[k] } else { 0.02 }));
                }
                let eye = middle + 0.5 * (high - low) * way * out;
                let target = middle - 0.1 * (high - low) * way;
                let vfov = if out < 1.0 { 70.0 } else { 45.0 };
                let camera =
                    Camera { eye: eye.to_array(), target: target.to_array(), up, vfov_degrees: vfov, width: 16, height: 12 };
                if camera.check().is_err() {
                    continue;
                }
                let hits = seen(scene, geometry, &camera)?;
                let there: Vec<&Point> = hits.iter().flatten().collect();
                let pieces: HashSet<u32> = there.iter().map(|p| geometry.tris[p.tri as usize].plane).collect();
                // Much in view, of many walls; a wall at the nose is little.
                let score = there.len() as f64 / hits.len() as f64 * (1.0 + pieces.len() as f64).ln();
                if score > best.0 + 1e-9 {
                    best = (score, Some(camera));
                }
            }
        }
    }
    let fallback = Camera {
        eye: (middle + DVec3::splat(geometry.extent())).to_array(),
        target: middle.to_array(),
        up,
        vfov_degrees: 45.0,
        width: 16,
        height: 12,
    };
    Ok(small(Camera { width: 640, height: 480, ..best.1.unwrap_or(fallback) }))
}

impl<'a> Looks<'a> {
    /// Traces the reference picture, or takes the one that an earlier call has left. None where nothing is seen.
    pub fn new(ways: &'a Ways<'a>, camera: Camera, progress: &mut Progress) -> Result<Option<Looks<'a>>> {
        let hits = seen(ways.scene, ways.geometry, &camera)?;
        let places: Vec<Point> = hits.iter().flatten().copied().filter(|p| p.tri != NONE).collect();
        if places.is_empty() {
            return Ok(None);
        }
        progress.event(Event::Stage { name: "reference picture" })?;
        let mut reference = Reference::at(ways.scene, ways.geometry, &places, 1);
        let state = ways.dir.join("picture.json");
        // Of another camera: traced anew.
        let _ = reference.resume(&state);
        if reference.paths() < PATHS {
            let traced = reference.run(Goal { noise: 0.0, paths: PATHS, time: None }, progress);
            reference.save(&state)?;
            traced?;
        }
        let truth = reference.truth();
        let colours: Vec<[f32; 3]> = truth.b.iter().map(|b| b.map(|x| (x / PI) as f32)).collect();
        let tone = Tone::auto(&colours);
        let noise = truth.noise();
        let looks = Looks { camera, hits, truth: truth.b, noise, tone, ways };
        write_png(&ways.dir.join("reference.png"), &looks.toned(&colours), camera.width, camera.height)?;
        Ok(Some(looks))
    }

    /// Colours of the pixels that see something among those that see nothing.
    fn spread<T: Copy>(&self, seen: &[T], nothing: T) -> Vec<T> {
        let mut next = seen.iter();
        self.hits.iter().map(|hit| hit.and_then(|_| next.next().copied()).unwrap_or(nothing)).collect()
    }

    fn toned(&self, radiance: &[[f32; 3]]) -> Vec<[u8; 3]> {
        let colours: Vec<[u8; 3]> = radiance.iter().map(|&c| self.tone.map(c)).collect();
        self.spread(&colours, [0; 3])
    }

    /// Shows a run, where its error is nearer to a level than what was shown for it.
    pub fn show(
        &self,
        backend: &Backend,
        solution: &Solution,
        rung: &Rung,
        error: f64,
        looks: &mut Vec<Look>,
        progress: &mut dyn FnMut(&Event) -> crate::Flow,
    ) -> Result<()> {
        let off = |level: f64, e: f64| (e / level).ln().abs();
        let Some(level) = LEVELS.into_iter().min_by(|a, b| off(*a, error).total_cmp(&off(*b, error))) else { return Ok(()) };
        let there = looks.iter().position(|l| l.shows == level);
        let better = there.is_none_or(|i| off(level, error) < off(level, looks[i].level) - 1e-9);
        if error <= 0.0 || off(level, error) > NEAR.ln() || !better {
            return Ok(());
        }
        let image = solution.render_with(backend, &self.camera, progress)?;
        let seen: Vec<[f32; 3]> = image.rgb.iter().zip(&self.hits).filter(|(_, hit)| hit.is_some()).map(|(c, _)| *c).collect();
        let b: Vec<[f64; 3]> = seen.iter().map(|c| c.map(|x| PI * x as f64)).collect();
        let with_noise = crate::accuracy::norms::rrmse(&b, &self.truth);
        let mean = self.truth.iter().flatten().sum::<f64>() / (3 * self.truth.len()) as f64;
        let sum = |b: &[f64; 3]| b.iter().sum::<f64>() / 3.0;
        let differences: Vec<[u8; 3]> = b
            .iter()
            .zip(&self.truth)
            .map(|(b, t)| {
                let RGBColor(r, g, b) = color::signed((sum(b) - sum(t)) / (sum(t) + FLOOR * mean) / FULL);
                [r, g, b]
            })
            .collect();
        let name = |what: &str| format!("{what}-{}pc.png", (100.0 * level).round());
        let look = Look {
            shows: level,
            method: rung.kind,
            size: rung.size,
            rrmse: (with_noise.powi(2) - self.noise.powi(2)).max(0.0).sqrt(),
            level: error,
            picture: name("picture"),
            difference: name("difference"),
        };
        let (w, h) = (self.camera.width, self.camera.height);
        write_png(&self.ways.dir.join(&look.picture), &self.toned(&seen), w, h)?;
        write_png(&self.ways.dir.join(&look.difference), &self.spread(&differences, [235; 3]), w, h)?;
        looks.retain(|l| l.shows != level);
        looks.push(look);
        looks.sort_by(|a, b| b.shows.total_cmp(&a.shows));
        Ok(())
    }
}
