//! A truth of our own: radiosity at surface points by path tracing, in plain Rust on all cores.
//!
//! It knows nothing of nodes and cells, and has no bias: E is known, D is sampled by itself (multiple importance
//! sampling of the emitters' area and of cosine directions, [`crate::twin::direct`]), all other light by paths that do
//! the same at each of their ends and that Russian roulette breaks off (Veach 1997, 9 and 10). The error is noise alone,
//! measured between independent batches. Where a first look finds more noise, more batches are shot; the look itself
//! does not count, so that what it saw does not sway what is kept. Batches have sequences of their own and add up in
//! their order, in f64: the same seed gives the same bytes on any number of threads, stopped in between or not.
//!
//! Where light comes by rare ways (the far end of a dark corridor) paths find it seldom, and a standard error from few
//! of them is itself too small.

use super::truth::{Flag, Truth, flag_of};
use crate::checkpoint::{bytes, digest};
use crate::error::{Error, Result};
#[cfg(feature = "cli")]
use crate::layout::Point;
use crate::layout::{self, kind};
use crate::output::atomic;
use crate::progress::{Event, Progress};
use crate::scene::{Geometry, Scene};
use crate::solution::SurfacePoint;
use crate::twin::direct::{Samples, from_emitters, from_way, round};
use crate::twin::emit::first_hit;
use crate::twin::lights::from_lights;
use crate::twin::math::{cosine_direction, invert_cdf, seed_of, unit};
use crate::twin::sky;
use crate::twin::sobol::sobol4;
use crate::twin::texture::{self, is_there};
use crate::twin::trace::{place_on, position};
use crate::twin::way::follow;
use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::Path;
use std::time::{Duration, Instant};

/// Paths of a batch at a point: a power of two, so that their first directions are stratified.
pub const PATHS: u32 = 128;
/// Direct samples of a batch.
const DIRECT: Samples = Samples { emitter: 128, cosine: 128 };
/// Samples at the ends of a path: one shadow ray serves all of the emitters', and the cosine direction is also the way on.
const END: Samples = Samples { emitter: 8, cosine: 1 };
/// Batches of the first look, and the fewest after it: a standard error from fewer means little.
const FEWEST: u32 = 16;
/// Most batches a round at a point.
const SHARE: f64 = 16.0;
/// Reflections before roulette begins.
const SURE: u32 = 2;
/// Most likely a path goes on: also at reflectance 1 it comes to an end.
const GO_ON: f32 = 0.97;
/// Batches in flight.
const IN_FLIGHT: usize = 256;
/// Particles of light that tell where it falls.
const PARTICLES: u32 = 65_536;
/// Surfaces that one may meet: of reflectances of .98 one in ten million meets more.
const MOST_ENDS: usize = 800;
/// Cosine rays that tell whether a point is covered.
const PROBES: u32 = 64;

/// When a reference is good enough; the first that is met ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// sqrt(mean stderr²) over the mean radiosity.
    pub noise: f64,
    /// Paths a point.
    pub paths: u64,
    /// Time of this call.
    pub time: Option<Duration>,
}

impl Default for Goal {
    fn default() -> Goal {
        Goal { noise: 0.005, paths: u64::MAX, time: None }
    }
}

/// A surface point as the passes know it.
#[derive(Clone, Copy)]
struct Spot {
    tri: u32,
    p: Vec3,
}

/// Sums over the batches, a point each: irradiance, scaled W/m² a band, and its squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    /// What it is of: scene, points and seed.
    of: String,
    /// Batches of a round at each point; none while the first look lasts, whose rounds have one each.
    share: Vec<u32>,
    rounds: u32,
    sum: Vec<[f64; 3]>,
    square: Vec<[f64; 3]>,
}

/// A reference in the making.
pub struct Reference<'a> {
    scene: &'a Scene,
    geometry: &'a Geometry,
    points: Vec<SurfacePoint>,
    /// Mean irradiance, scaled W/m², where points lie half by light ([`lit_points`]).
    mean: Option<f64>,
    spots: Vec<Spot>,
    seed: u32,
    state: State,
}

impl<'a> Reference<'a> {
    /// Begins one at given points. Errors: [`Error::Format`] naming `place` for a point that lies off every surface.
    pub fn new(
        scene: &'a Scene,
        geometry: &'a Geometry,
        place: &Path,
        points: Vec<SurfacePoint>,
        seed: u32,
    ) -> Result<Reference<'a>> {
        let mut spots = Vec::with_capacity(points.len());
        for (i, point) in points.iter().enumerate() {
            let at = geometry.locate(point.p, point.n).ok_or_else(|| Error::Format {
                path: place.into(),
                line: None,
                what: format!("point {i} (from 0) at {:?} lies off every surface", point.p),
                cure: "give points of this scene, in metres, with the normal of their surface".into(),
            })?;
            spots.push(Spot { tri: at.tri, p: Vec3::from(at.p) });
        }
        Ok(Reference::begin(scene, geometry, points, spots, seed))
    }

    /// Begins one at places that the passes have found, as what a camera sees: without a first look, all alike.
    #[cfg(feature = "cli")]
    pub(super) fn at(scene: &'a Scene, geometry: &'a Geometry, places: &[Point], seed: u32) -> Reference<'a> {
        let world =
            |p: &Point| SurfacePoint { p: geometry.to_world(p.p), n: geometry.tris[p.tri as usize].normal.map(f64::from) };
        let spots = places.iter().map(|p| Spot { tri: p.tri, p: Vec3::from(p.p) }).collect();
        let mut even = Reference::begin(scene, geometry, places.iter().map(world).collect(), spots, seed);
        even.state.share = vec![1; places.len()];
        even
    }

    fn begin(scene: &'a Scene, geometry: &'a Geometry, points: Vec<SurfacePoint>, spots: Vec<Spot>, seed: u32) -> Reference<'a> {
        let coordinates: Vec<f64> = points.iter().flat_map(|p| p.p.into_iter().chain(p.n)).collect();
        let of = digest(&[
            bytes(&geometry.tris),
            bytes(&geometry.materials),
            bytes(&geometry.sky.texels),
            bytes(&geometry.lights.all),
            bytes(&geometry.texels),
            bytes(&[geometry.scale, geometry.emission_scale, geometry.arrives]),
            bytes(&coordinates),
            bytes(&[seed, PATHS, DIRECT.emitter, DIRECT.cosine, END.emitter]),
        ]);
        let of = if geometry.sigma > 0.0 { digest(&[of.as_bytes(), bytes(&[geometry.sigma])]) } else { of };
        let none = vec![[0.0; 3]; points.len()];
        let state = State { of, share: Vec::new(), rounds: 0, sum: none.clone(), square: none };
        Reference { scene, geometry, points, mean: None, spots, seed, state }
    }

    /// The same with points of [`lit_points`], and the mean irradiance that came with them.
    pub fn lit(self, mean: Option<f64>) -> Reference<'a> {
        Reference { mean, ..self }
    }

    /// Goes on from where [`Reference::save`] was called; from the beginning where `path` is not there.
    ///
    /// Errors: [`Error::Read`]; [`Error::Format`] where the file is of another reference.
    pub fn resume(&mut self, path: &Path) -> Result<()> {
        let fail = |what: String| Error::Format { path: path.into(), line: None, what, cure: "delete it to start anew".into() };
        let text = match std::fs::read(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            read => read.map_err(|source| Error::Read { path: path.into(), source })?,
        };
        let state: State = serde_json::from_slice(&text).map_err(|e| fail(e.to_string()))?;
        let n = self.points.len();
        let whole = state.sum.len() == n && state.square.len() == n && (state.share.is_empty() || state.share.len() == n);
        if state.of != self.state.of || !whole {
            return Err(fail("this reference is of another scene, other points or another seed".into()));
        }
        self.state = state;
        Ok(())
    }

    /// Keeps what has been found. Errors: [`Error::Write`].
    pub fn save(&self, path: &Path) -> Result<()> {
        let text =
            serde_json::to_vec(&self.state).map_err(|e| Error::Write { path: path.into(), source: std::io::Error::other(e) })?;
        atomic::write(path, &text)
    }

    /// Paths shot at each point, or more.
    pub fn paths(&self) -> u64 {
        self.state.rounds as u64 * PATHS as u64
    }

    /// Traces until the goal is met. Tells points' rounds as [`Event::Points`]: of how many, as the noise so far lets
    /// foresee. Errors: [`Error::Cancelled`]; what has been found stays.
    pub fn run(&mut self, goal: Goal, progress: &mut Progress) -> Result<()> {
        let start = Instant::now();
        let n = self.points.len();
        let rounds_for = |batches: u32, share: u32| (batches / share.max(1)).max(1);
        // A reference of few points runs several rounds at a time.
        let step = rounds_for(IN_FLIGHT as u32, n as u32);
        while self.state.share.is_empty() {
            progress.tick()?;
            self.rounds(step.min(FEWEST - self.state.rounds));
            if self.state.rounds == FEWEST {
                self.settle();
            }
        }
        let most = goal.paths.div_ceil(PATHS as u64).clamp(2, u32::MAX as u64 / 2) as u32;
        while self.state.rounds < most {
            if self.state.rounds >= FEWEST.min(most) {
                let noise = self.truth().noise();
                let late = goal.time.is_some_and(|time| start.elapsed() >= time);
                // Where all is dark the noise is no number, and there is nothing to wait for.
                if noise <= goal.noise || noise.is_nan() || late {
                    return Ok(());
                }
                // Noise falls with the root of the rounds.
                let wanted = (self.state.rounds as f64 * (noise / goal.noise).powi(2)).min(most as f64) as u64;
                progress.event(Event::Points { done: self.state.rounds as u64 * n as u64, total: wanted * n as u64 })?;
            } else {
                progress.tick()?;
            }
            self.rounds(step.min(most - self.state.rounds));
        }
        Ok(())
    }

    /// Ends the first look: from now on each point gets batches by the noise that was found there.
    fn settle(&mut self) {
        let truth = self.truth();
        let noise: Vec<f64> =
            truth.stderr.iter().enumerate().map(|(i, s)| truth.weight(i).sqrt() * s.iter().sum::<f64>()).collect();
        let mean = noise.iter().sum::<f64>() / noise.len().max(1) as f64;
        self.state.share =
            noise.iter().map(|s| if mean > 0.0 { (s / mean).ceil().clamp(1.0, SHARE) as u32 } else { 1 }).collect();
        self.state.rounds = 0;
        self.state.sum.fill([0.0; 3]);
        self.state.square.fill([0.0; 3]);
    }

    /// Batches of a round at a point.
    fn share(&self, point: usize) -> u32 {
        self.state.share.get(point).copied().unwrap_or(1)
    }

    /// Adds `count` rounds at every point.
    fn rounds(&mut self, count: u32) {
        // The first look has seeds of its own.
        let first = if self.state.share.is_empty() { 0 } else { FEWEST };
        let mut jobs = Vec::new();
        for i in 0..self.spots.len() {
            let share = self.share(i);
            let from = first + self.state.rounds * share;
            jobs.extend((from..from + count * share).map(|batch| (i, batch)));
        }
        let found: Vec<[f64; 3]> = jobs
            .par_iter()
            .map(|&(i, batch)| batch_at(self.geometry, self.spots[i], seed_of(seed_of(self.seed, i as u32), batch)))
            .collect();
        for (&(i, _), h) in jobs.iter().zip(found) {
            for band in 0..3 {
                self.state.sum[i][band] += h[band];
                self.state.square[i][band] += h[band] * h[band];
            }
        }
        self.state.rounds += count;
    }

    /// What is known so far.
    pub fn truth(&self) -> Truth {
        let unscale = self.geometry.arrives / self.geometry.emission_scale;
        let mut truth = Truth { points: self.points.clone(), ..Truth::default() };
        for (i, spot) in self.spots.iter().enumerate() {
            let (reflectance, emission) = self.geometry.shown(self.scene, spot.tri, spot.p);
            let (sum, square) = (self.state.sum[i], self.state.square[i]);
            let m = (self.state.rounds * self.share(i)).max(1) as f64;
            let b = [0, 1, 2].map(|k| PI * emission[k] + reflectance[k] * sum[k] / m * unscale);
            let stderr = [0, 1, 2].map(|k| {
                let mean = sum[k] / m;
                let variance = (square[k] / m - mean * mean).max(0.0) / (m - 1.0).max(1.0);
                reflectance[k] * unscale * variance.sqrt()
            });
            truth.b.push(b);
            truth.stderr.push(stderr);
            if let Some(all) = self.mean {
                truth.weights.push(1.0 / (0.5 + 0.5 * sum.iter().sum::<f64>() / (3.0 * m * all)));
            }
            truth.flags.push(if b == [0.0; 3] { Flag::Covered } else { flag_of(b, stderr) });
        }
        let level = truth.weights.iter().sum::<f64>() / truth.weights.len().max(1) as f64;
        truth.weights.iter_mut().for_each(|w| *w /= level);
        truth
    }
}

/// `count` points of a scene, uniform over the area that reflects ([`Geometry::judged`]), stratified, covered places left out.
///
/// Lamps are left out where anything else reflects: what they send is known beforehand, and so much that the mean light,
/// which errors are told by, would be theirs and hang on how many points happen to lie on them. Fewer points where most of
/// the surface is covered.
pub fn sample_points(geometry: &Geometry, count: usize, seed: u32) -> Vec<SurfacePoint> {
    let judged = geometry.judged();
    let area = |t: usize| if judged(geometry.material_of(t)) { geometry.areas[t] } else { 0.0 };
    let areas: Vec<f64> = (0..geometry.tris.len()).map(area).collect();
    let total: f64 = areas.iter().sum();
    let mut ends = Vec::with_capacity(areas.len());
    let mut sum = 0.0;
    for area in &areas {
        sum += area;
        ends.push(sum);
    }
    let mut points = Vec::with_capacity(count);
    for i in 0..8 * count as u32 {
        if points.len() == count || total <= 0.0 {
            break;
        }
        let u = sobol4(i, seed);
        let at = (u[0] as f64 + 0.5) / 4294967296.0 * total;
        let t = ends.partition_point(|&end| end <= at).min(areas.len() - 1);
        if areas[t] <= 0.0 {
            continue;
        }
        let place = (1.0 - (ends[t] - at) / areas[t]).clamp(0.0, 0.999_999_9);
        let tri = &geometry.tris[t];
        let (b1, b2) = place_on(geometry.flatland, place as f32, unit(u[1]));
        let p = position(geometry.flatland, tri, b1, b2);
        if is_there(geometry, t as u32, b1, b2) && !is_covered(geometry, t as u32, p, seed_of(seed, i)) {
            points.extend(found_again(geometry, Spot { tri: t as u32, p }));
        }
    }
    points
}

/// As [`sample_points`], half of them where light falls, and the mean irradiance, scaled W/m², by which [`Reference::lit`] weighs
/// them.
///
/// A lamp close by a surface puts half of its light on a patch of its own size, and so does such a patch in turn. Of points spread over a
/// whole room one or none meets it, and what the mean light is, and any error by it, is then chance. Here particles of light (Arvo and Kirk 1990) are followed,
/// each of one band, through as many reflections as it survives: they end on a surface as often as its irradiance H says, so that
/// a point's density is half uniform and half H. Where light comes otherwise than from surfaces, or maps vary it, points are even.
pub fn lit_points(geometry: &Geometry, count: usize, seed: u32) -> (Vec<SurfacePoint>, Option<f64>) {
    let judged = geometry.judged();
    let even = sample_points(geometry, count, seed);
    if geometry.emitters.is_empty() || geometry.is_surfaceless() || geometry.textured || geometry.cut {
        return (even, None);
    }
    let ends: Vec<Vec<Spot>> = (0..PARTICLES).into_par_iter().map(|i| particle(geometry, &judged, i, seed)).collect();
    let ends = ends.concat();
    if ends.is_empty() {
        return (even, None);
    }
    let area: f64 = (0..geometry.tris.len()).filter(|&t| judged(geometry.material_of(t))).map(|t| geometry.areas[t]).sum();
    let mean = geometry.power_density() * geometry.area * ends.len() as f64 / f64::from(PARTICLES) / area;
    let half = count / 2;
    let step = (ends.len() / (count - half).max(1)).max(1);
    let lit = ends.iter().step_by(step).filter_map(|&end| found_again(geometry, end)).take(count - half);
    (even.into_iter().take(half).chain(lit).collect(), Some(mean))
}

/// A place as a point of a truth: none where a query would not find it again.
fn found_again(geometry: &Geometry, at: Spot) -> Option<SurfacePoint> {
    let tri = &geometry.tris[at.tri as usize];
    let (p, n) = (geometry.to_world(at.p.to_array()), tri.normal.map(f64::from));
    let found = geometry.locate(p, n)?;
    (geometry.tris[found.tri as usize].plane == tri.plane).then_some(SurfacePoint { p, n })
}

/// Where a particle of light meets what is judged, until it is absorbed or escapes.
fn particle(geometry: &Geometry, judged: impl Fn(&layout::Material) -> bool, i: u32, seed: u32) -> Vec<Spot> {
    let mut random = Random::new(seed_of(seed, PARTICLES), i);
    let u = sobol4(i, seed_of(seed, PARTICLES));
    let (e, place) = invert_cdf(geometry.emitters.len() as u32, |e| geometry.emitters[e as usize].cdf, u[0]);
    let tri = geometry.emitters[e as usize].tri;
    let (b1, b2) = place_on(geometry.flatland, place, unit(u[1]));
    let mut at = Spot { tri, p: position(geometry.flatland, &geometry.tris[tri as usize], b1, b2) };
    // Its band, as the emitter has it.
    let emit = geometry.material_of(tri as usize).emit;
    let mut left = random.unit() * emit.iter().sum::<f32>();
    let band = (0..2).find(|&k| {
        left -= emit[k];
        left < 0.0
    });
    let band = band.unwrap_or(2);
    let mut turn = [u[2], u[3]];
    let mut ends = Vec::new();
    while ends.len() < MOST_ENDS {
        let n = Vec3::from(geometry.tris[at.tri as usize].normal);
        let way = follow(geometry, at.tri, at.p, cosine_direction(geometry.flatland, n, unit(turn[0]), unit(turn[1])));
        if way.kind != kind::FRONT || random.unit() >= way.share {
            break;
        }
        let material = geometry.material_of(way.hit.tri as usize);
        at = Spot {
            tri: way.hit.tri,
            p: position(geometry.flatland, &geometry.tris[way.hit.tri as usize], way.hit.b1, way.hit.b2),
        };
        if judged(material) {
            ends.push(at);
        }
        if random.unit() >= material.rho[band] {
            break;
        }
        turn = [random.next(), random.next()];
    }
    ends
}

/// No front face in sight, back faces in a quarter of all directions: no light can come.
fn is_covered(geometry: &Geometry, tri: u32, p: Vec3, seed: u32) -> bool {
    let n = Vec3::from(geometry.tris[tri as usize].normal);
    let mut back = 0;
    for k in 0..PROBES {
        let u = sobol4(k, seed);
        match first_hit(geometry, tri, p, cosine_direction(geometry.flatland, n, unit(u[2]), unit(u[3]))).0 {
            kind::FRONT => return false,
            kind::BACK => back += 1,
            _ => (),
        }
    }
    4 * back >= PROBES
}

/// Irradiance at a point by one batch, scaled W/m².
fn batch_at(geometry: &Geometry, spot: Spot, seed: u32) -> [f64; 3] {
    if !geometry.shines() {
        return [0.0; 3];
    }
    let mut sum = [0.0; 3];
    for k in 0..PATHS {
        let light = path(geometry, spot, sobol4(k, seed), Random::new(seed, k));
        for band in 0..3 {
            sum[band] += light[band] as f64;
        }
    }
    let direct = round(geometry, spot.tri, spot.p, seed_of(seed, PATHS), 0, DIRECT);
    [0, 1, 2].map(|k| direct[k] as f64 + sum[k] / PATHS as f64)
}

/// What one path brings, direct light at its start apart. `u` draws its first direction and the first emitter sample.
fn path(geometry: &Geometry, from: Spot, u: [u32; 4], mut random: Random) -> Vec3 {
    let (mut light, mut through) = (Vec3::ZERO, Vec3::ONE);
    let mut at = from;
    let mut turn = [u[0], u[1]];
    let mut lamp = [u[2], u[3]];
    for reflections in 0u32.. {
        let n = Vec3::from(geometry.tris[at.tri as usize].normal);
        let direction = cosine_direction(geometry.flatland, n, unit(turn[0]), unit(turn[1]));
        let way = follow(geometry, at.tri, at.p, direction);
        let hit = way.hit;
        // The start's direct light is sampled apart.
        if way.kind == kind::SKY && reflections > 0 && !geometry.sky.is_empty() {
            light += through * sky::from_way(geometry, n, &way, sky_end(geometry));
        }
        if way.kind != kind::FRONT {
            break;
        }
        if reflections > 0 && !geometry.emitters.is_empty() {
            light += through * from_way(geometry, n, &way, END);
        }
        let there = &geometry.tris[hit.tri as usize];
        through *= texture::rho(geometry, hit.tri, hit.b1, hit.b2) * way.share;
        if reflections >= SURE {
            let stay = through.max_element().min(GO_ON);
            if random.unit() >= stay {
                break;
            }
            through /= stay;
        } else if through == Vec3::ZERO {
            break;
        }
        at = Spot { tri: hit.tri, p: position(geometry.flatland, there, hit.b1, hit.b2) };
        let pick = random.unit();
        if !geometry.emitters.is_empty() {
            light += through * from_emitters(geometry, at.tri, at.p, lamp, pick, END);
        }
        if geometry.is_surfaceless() {
            light += through * surfaceless_end(geometry, at, &mut random);
        }
        turn = [random.next(), random.next()];
        lamp = [random.next(), random.next()];
    }
    light
}

/// Samples of the sky at the ends of a path: one of its map, and the way on.
fn sky_end(geometry: &Geometry) -> [u32; 2] {
    [u32::from(geometry.sky.is_mapped()), 1]
}

/// What lights and the map of the sky bring to an end of a path; the way on finds the rest of the sky.
fn surfaceless_end(geometry: &Geometry, at: Spot, random: &mut Random) -> Vec3 {
    let (u, v, seed) = (random.next(), random.next(), random.next());
    let mut light = Vec3::ZERO;
    if geometry.sky.is_mapped() {
        light += sky::from_map(geometry, at.tri, at.p, u, v, sky_end(geometry));
    }
    if !geometry.lights.is_empty() {
        light += from_lights(geometry, at.tri, at.p, seed, 0, Samples { emitter: 1, cosine: 0 });
    }
    light
}

/// Random numbers of a path beyond its first end (SplitMix64; Steele et al. 2014).
struct Random(u64);

impl Random {
    fn new(seed: u32, path: u32) -> Random {
        Random((seed as u64) << 32 | path as u64)
    }

    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 32) as u32
    }

    fn unit(&mut self) -> f32 {
        unit(self.next())
    }
}

#[cfg(test)]
mod tests {
    use super::super::norms::rrmse;
    use super::*;
    use crate::progress::Flow;
    use crate::scene::Material;

    #[test]
    fn points_where_light_falls_stand_for_less() {
        let (scene, _) = shipped("cornell");
        let geometry = Geometry::new(&scene).unwrap();
        let (points, mean) = lit_points(&geometry, 2_048, 3);
        assert_eq!(points.len(), 2_048);
        let mut traced = Reference::new(&scene, &geometry, Path::new("points"), points.clone(), 3).unwrap().lit(mean);
        traced.run(Goal { paths: 512, ..Goal::default() }, &mut Progress::new(&mut |_: &Event| Flow::Continue)).unwrap();
        let weights = traced.truth().weights;
        let (even, all) = (sample_points(&geometry, 2_048, 4), weights.iter().sum::<f64>());
        // Each side of the room has its share of the weight, though the floor has far more of the points.
        for normal in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]] {
            let faces = |p: &SurfacePoint| (0..3).all(|k| (p.n[k] - normal[k]).abs() < 0.1);
            let share = points.iter().zip(&weights).filter(|(p, _)| faces(p)).map(|(_, w)| w).sum::<f64>() / all;
            let area = even.iter().filter(|p| faces(p)).count() as f64 / 2_048.0;
            assert!((share / area - 1.0).abs() < 0.1, "{normal:?}: {share} of the weight, {area} of the area");
        }
        let floor = |p: &&SurfacePoint| p.n[1] > 0.9;
        assert!(points.iter().filter(floor).count() as f64 > 1.2 * even.iter().filter(floor).count() as f64);
        // The particles' mean is that of the truth.
        let traced = traced
            .state
            .sum
            .iter()
            .zip(&weights)
            .enumerate()
            .map(|(i, (s, w))| w * s.iter().sum::<f64>() / f64::from(3 * traced.state.rounds * traced.share(i)));
        let known = traced.sum::<f64>() / all;
        // By 2,048 points to some 2 %.
        assert!((mean.unwrap() / known - 1.0).abs() < 0.06, "{mean:?} {known}");
    }

    fn shipped(name: &str) -> (Scene, Truth) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let scene = match name.strip_prefix("flatland_") {
            Some(flat) => root.join(format!("scenes/flatland/{flat}.toml")),
            None => root.join(format!("scenes/{name}/scene.obj")),
        };
        (Scene::load(scene).unwrap(), Truth::read(&root.join(format!("tests/data/{name}.truth.csv"))).unwrap())
    }

    fn traced(scene: &Scene, points: &[SurfacePoint], paths: u64) -> Truth {
        let geometry = Geometry::new(scene).unwrap();
        let mut reference = Reference::new(scene, &geometry, Path::new("points"), points.to_vec(), 5).unwrap();
        let mut tell = |_: &Event| Flow::Continue;
        reference.run(Goal { noise: 0.0, paths, time: None }, &mut Progress::new(&mut tell)).unwrap();
        reference.truth()
    }

    /// In units of both standard errors: the root mean square over all bands and the mean, which a bias would show in.
    fn apart(a: &Truth, b: &Truth) -> [f64; 2] {
        let z: Vec<f64> = (0..a.b.len())
            .filter(|&i| b.flags[i] != Flag::Covered)
            .map(|i| {
                let sum = |x: &[f64; 3]| x.iter().sum::<f64>();
                // Bands share their paths.
                let scatter = (sum(&a.stderr[i]).powi(2) + sum(&b.stderr[i]).powi(2)).sqrt();
                (sum(&a.b[i]) - sum(&b.b[i])) / scatter
            })
            .collect();
        let n = z.len() as f64;
        [(z.iter().map(|z| z * z).sum::<f64>() / n).sqrt(), z.iter().sum::<f64>() / n]
    }

    /// A closed room whose walls all shine: B = E/(1 - rho) everywhere.
    #[test]
    fn it_meets_the_furnace() {
        for rho in [0.5, 0.9] {
            let v = |i: usize| [0, 1, 2].map(|k| (i >> k & 1) as f64);
            let quads = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
            let walls: Vec<_> =
                quads.iter().flat_map(|&[a, b, c, d]: &[usize; 4]| [([v(a), v(b), v(c)], 0), ([v(a), v(c), v(d)], 0)]).collect();
            let scene = Scene::from_triangles("furnace", &walls, vec![Material::new("all", [rho; 3], [1.0, 0.5, 2.0])]).unwrap();
            let geometry = Geometry::new(&scene).unwrap();
            let points = sample_points(&geometry, 64, 1);
            assert_eq!(points.len(), 64);
            let truth = traced(&scene, &points, 4096);
            let exact = [1.0, 0.5, 2.0].map(|e| PI * e / (1.0 - rho));
            let known = Truth { b: vec![exact; 64], stderr: vec![[0.0; 3]; 64], ..truth.clone() };
            let [rms, mean] = apart(&truth, &known);
            eprintln!("rho {rho}: rms {rms:.2}, mean {mean:+.2} standard errors, noise {:.5}", truth.noise());
            // 64 points: the root mean square scatters by 1/sqrt(128) (+ 1/sqrt(64) for the batches'), the mean by 1/8.
            assert!(rms < 1.4 && mean.abs() < 0.45, "{rms} {mean}");
            assert!(truth.noise() < 0.02 && rrmse(&truth.b, &known.b) < 0.02);
        }
    }

    /// The shipped truths were made by another program.
    #[test]
    fn it_meets_the_shipped_truths() {
        for name in ["cornell", "blocker", "flatland_box", "flatland_l_room"] {
            let (scene, known) = shipped(name);
            let truth = traced(&scene, &known.points, 3072);
            let [rms, mean] = apart(&truth, &known);
            let error = rrmse(&truth.b, &known.b);
            eprintln!("{name}: rms {rms:.2}, mean {mean:+.3} standard errors; RRMSE {error:.5}, noise {:.5}", truth.noise());
            // 24 batches: 512 standardised differences have a root mean square of 1.05 +- .04, and a mean of 0 +- .05.
            assert!(rms < 1.25 && mean.abs() < 0.2, "{name}: {rms} {mean}");
            let covered = |t: &Truth| t.flags.iter().filter(|f| **f == Flag::Covered).count();
            assert_eq!(covered(&truth), covered(&known), "{name}");
        }
    }

    #[test]
    fn points_lie_on_what_reflects() {
        let (scene, known) = shipped("cornell");
        let geometry = Geometry::new(&scene).unwrap();
        let points = sample_points(&geometry, 512, 1);
        assert_eq!(points.len(), 512);
        let tri = |p: &SurfacePoint| geometry.locate(p.p, p.n).unwrap().tri as usize;
        assert!(points.iter().all(|p| geometry.material_of(tri(p)).emit == [0.0; 3]));
        // As on the shipped points: the floor is a fifth of all walls, and their mean height is about half the room's.
        let share = |points: &[SurfacePoint]| points.iter().filter(|p| p.n[1] > 0.9).count() as f64 / points.len() as f64;
        let height = |points: &[SurfacePoint]| points.iter().map(|p| p.p[1]).sum::<f64>() / points.len() as f64;
        assert!((share(&points) - share(&known.points)).abs() < 0.05, "{} {}", share(&points), share(&known.points));
        assert!((height(&points) / height(&known.points) - 1.0).abs() < 0.1);
        let truth = traced(&scene, &points, 512);
        assert!((truth.mean() / known.mean() - 1.0).abs() < 0.1, "{} {}", truth.mean(), known.mean());
    }

    #[test]
    fn threads_and_stops_do_not_show() {
        let (scene, known) = shipped("cornell");
        let geometry = Geometry::new(&scene).unwrap();
        let points: Vec<SurfacePoint> = known.points[..40].to_vec();
        let goal = |paths| Goal { noise: 0.0, paths, time: None };
        let mut tell = |_: &Event| Flow::Continue;
        let begin = || Reference::new(&scene, &geometry, Path::new("points"), points.clone(), 9).unwrap();
        let mut whole = begin();
        whole.run(goal(24 * PATHS as u64), &mut Progress::new(&mut tell)).unwrap();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("reference.json");
        let mut first = begin();
        first.run(goal(7 * PATHS as u64), &mut Progress::new(&mut tell)).unwrap();
        first.save(&path).unwrap();
        let mut second = begin();
        second.resume(&path).unwrap();
        assert_eq!(second.paths(), 7 * PATHS as u64);
        one.install(|| second.run(goal(24 * PATHS as u64), &mut Progress::new(&mut |_| Flow::Continue))).unwrap();
        assert_eq!(second.state, whole.state);
        let mut other = Reference::new(&scene, &geometry, Path::new("points"), points.clone(), 10).unwrap();
        assert!(other.resume(&path).unwrap_err().to_string().contains("another seed"));
        // A stop keeps what there is.
        let mut stopped = begin();
        let stop = stopped.run(
            goal(u64::MAX),
            &mut Progress::new(&mut |e| match e {
                Event::Points { .. } => Flow::Stop,
                _ => Flow::Continue,
            }),
        );
        assert!(matches!(stop, Err(Error::Cancelled)) && stopped.paths() > 0);
    }
}
