//! What patches see: stratified points on each, which of them are covered, how much of their view meets light-giving
//! surfaces, and what direct light falls on them.

use super::{Chart, Mesh, Patch, Shape};
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, Node, NodeLight, Point, kind};
use crate::progress::Progress;
use crate::scene::Geometry;
use crate::twin::direct::Samples;
use crate::twin::math::{seed_of, tangents, unit};
use crate::twin::sobol::sobol4;
use crate::twin::trace::segment_blocked;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Points on a patch, a square number.
pub const POINTS: usize = 16;
/// Cosine rays at each of them that tell what it sees.
const LOOKS: u32 = 16;
/// The same on patches from which some rays leave the scene: there the share counts that does not.
const LOOKS_OUT: u32 = 64;
/// Points in flight.
const CHUNK: usize = 16_384;
/// Samples of direct light at each point.
const DIRECT: Samples = Samples { emitter: 4, cosine: 1 };
/// Patches that a gradient is fitted to.
const NEIGHBOURS: usize = 8;
/// Ridge of that fit, as a share of its second moments.
const RIDGE: f64 = 1e-3;
/// Neighbours must see each other along the surface, this share of their distance above it.
const LIFT: f32 = 0.1;

/// Patches with what is known of them.
#[derive(Clone, Debug, Default)]
pub struct Sampled {
    /// [`POINTS`] a patch.
    pub points: Vec<Point>,
    /// How many times the mean area each point stands for.
    pub stretch: Vec<f32>,
    /// Share of each patch that is not covered by other surfaces.
    pub live: Vec<f64>,
    /// Share of the live part's view that meets front faces which reflect or emit.
    pub visible: Vec<f64>,
    /// Mean direct irradiance of the live part, scaled; 0 where it was not asked for.
    pub direct: Vec<[f64; 3]>,
    /// Mean place of the live part, local.
    pub centre: Vec<DVec3>,
    /// Rays shot.
    pub rays: u64,
}

impl Sampled {
    /// Looks around on all patches; with `exact` samples direct light, too.
    pub fn new<E: Engine>(
        engine: &mut E,
        geometry: &Geometry,
        mesh: &Mesh,
        patches: &[Patch],
        exact: bool,
        seed: u32,
        progress: &mut Progress,
    ) -> Result<Sampled> {
        let mut out = Sampled::default();
        for (i, patch) in patches.iter().enumerate() {
            let chart = &mesh.charts[patch.chart as usize];
            for (p, stretch) in points_on(geometry, chart, &patch.shape, seed_of(seed, i as u32)) {
                out.points.push(p);
                out.stretch.push(stretch);
            }
        }

        // Look around, once more where light leaves the scene.
        let mut seen = look(engine, geometry, &out.points, LOOKS, seed_of(seed, u32::MAX), progress)?;
        out.rays += (out.points.len() * LOOKS as usize) as u64;
        let open = |seen: &[Seen]| seen.iter().any(|s| !s.dead && s.light < 1.0);
        let again: Vec<usize> = (0..patches.len()).filter(|&i| open(&seen[i * POINTS..(i + 1) * POINTS])).collect();
        let points: Vec<Point> = again.iter().flat_map(|i| &out.points[i * POINTS..(i + 1) * POINTS]).copied().collect();
        let more = look(engine, geometry, &points, LOOKS_OUT, seed_of(seed, u32::MAX - 1), progress)?;
        out.rays += (points.len() * LOOKS_OUT as usize) as u64;
        for (k, &i) in again.iter().enumerate() {
            seen[i * POINTS..(i + 1) * POINTS].copy_from_slice(&more[k * POINTS..(k + 1) * POINTS]);
        }

        let mut sums = vec![DirectSum::default(); out.points.len()];
        if exact {
            sums.clear();
            for (c, chunk) in out.points.chunks(CHUNK).enumerate() {
                let mut batch = engine.upload(chunk)?;
                engine.direct(&mut batch, None, seed_of(seed_of(seed, u32::MAX - 2), c as u32), 0, 1, DIRECT)?;
                sums.extend(engine.direct_sums(&batch)?);
                progress.tick()?;
            }
            out.rays += (out.points.len() * (DIRECT.emitter + DIRECT.cosine) as usize) as u64;
        }
        for (i, patch) in patches.iter().enumerate() {
            let own = i * POINTS..(i + 1) * POINTS;
            let all: f64 = out.stretch[own.clone()].iter().map(|&s| s as f64).sum();
            let (mut live, mut visible, mut direct, mut centre) = (0.0, 0.0, [0.0; 3], DVec3::ZERO);
            let lit = |k: usize| !seen[k].dead || sums[k].sum != [0.0; 3];
            for k in own.filter(|&k| lit(k) && geometry.is_there(&out.points[k])) {
                let w = out.stretch[k] as f64;
                live += w;
                visible += w * seen[k].light;
                centre += Vec3::from(out.points[k].p).as_dvec3() * w;
                let d = sums[k].mean();
                direct = [0, 1, 2].map(|b| direct[b] + w * d[b] as f64);
            }
            let inv = if live > 0.0 { 1.0 / live } else { 0.0 };
            out.live.push(live / all);
            out.visible.push(visible * inv);
            out.direct.push(direct.map(|d| d * inv));
            // A patch that is not covered anywhere has its middle known exactly.
            out.centre.push(if live == all || live == 0.0 { patch.shape.centre() } else { centre * inv });
        }
        Ok(out)
    }

    /// A node for each patch, at the point nearest to the middle of its live part.
    pub fn nodes(&self, geometry: &Geometry, patches: &[Patch]) -> Vec<Node> {
        (0..patches.len())
            .map(|i| {
                let centre = self.centre[i];
                let far = |p: &&Point| Vec3::from(p.p).as_dvec3().distance_squared(centre);
                let own = &self.points[i * POINTS..(i + 1) * POINTS];
                let p = own.iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(&own[0]);
                let tri = &geometry.tris[p.tri as usize];
                let (t1, t2) = tangents(Vec3::from(tri.normal));
                let d = centre.as_vec3() - Vec3::from(p.p);
                Node {
                    p: p.p,
                    material: tri.material,
                    n: tri.normal,
                    plane: tri.plane,
                    mean: [d.dot(t1), d.dot(t2)],
                    gain: 1.0,
                    ..Node::default()
                }
            })
            .collect()
    }

    /// Gives every patch's light a gradient: a weighted least-squares plane through its own value, fitted to those of
    /// its nearest neighbours in sight on the same planar piece.
    pub fn slopes(&self, geometry: &Geometry, nodes: &[Node], light: &[NodeLight]) -> Vec<NodeLight> {
        let mut pieces: HashMap<u32, Vec<usize>> = HashMap::new();
        for (i, n) in nodes.iter().enumerate().filter(|(i, _)| self.live[*i] > 0.0) {
            pieces.entry(n.plane).or_default().push(i);
        }
        (0..nodes.len())
            .into_par_iter()
            .map(|i| {
                let own = NodeLight { h: light[i].h, ..NodeLight::default() };
                let n = Vec3::from(nodes[i].n);
                let (t1, t2) = tangents(n);
                let mut near: Vec<(f64, usize)> = (pieces.get(&nodes[i].plane).into_iter().flatten())
                    .filter(|&&j| j != i && Vec3::from(nodes[j].n).dot(n) > 0.0)
                    .map(|&j| (self.centre[j].distance_squared(self.centre[i]), j))
                    .collect();
                if near.len() > NEIGHBOURS {
                    near.select_nth_unstable_by(NEIGHBOURS - 1, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                    near.truncate(NEIGHBOURS);
                }
                near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let (mut c11, mut c12, mut c22) = (0.0, 0.0, 0.0);
                let mut m = [[0.0; 2]; 3];
                for (d2, j) in near {
                    let lift = n * (LIFT * d2.sqrt() as f32);
                    let (a, b) = (self.centre[i].as_vec3() + lift, self.centre[j].as_vec3() + lift);
                    if d2 == 0.0 || segment_blocked(geometry, a, b, [nodes[i].plane; 2]) {
                        continue;
                    }
                    let d = (self.centre[j] - self.centre[i]).as_vec3();
                    let (x, y, w) = (d.dot(t1) as f64, d.dot(t2) as f64, 1.0 / d2);
                    c11 += w * x * x;
                    c12 += w * x * y;
                    c22 += w * y * y;
                    for k in 0..3 {
                        let change = (light[j].h[k] - light[i].h[k]) as f64;
                        m[k][0] += w * x * change;
                        m[k][1] += w * y * change;
                    }
                }
                let lift = RIDGE * (c11 + c22);
                let det = (c11 + lift) * (c22 + lift) - c12 * c12;
                if lift <= 0.0 || det <= 0.0 {
                    return own;
                }
                let solve = |m: [f64; 2]| [(m[0] * (c22 + lift) - m[1] * c12) / det, (m[1] * (c11 + lift) - m[0] * c12) / det];
                let g = m.map(solve);
                NodeLight { g0: g.map(|g| g[0] as f32), g1: g.map(|g| g[1] as f32), ..own }
            })
            .collect()
    }
}

/// [`POINTS`] points on a part of a chart, and how many times the mean area each stands for.
pub fn points_on(geometry: &Geometry, chart: &Chart, shape: &Shape, seed: u32) -> impl Iterator<Item = (Point, f32)> {
    strata(shape.sides, seed).map(|(u, v)| {
        let (p, stretch) = shape.at(u, v);
        (chart.point(geometry, p), stretch as f32)
    })
}

/// Places of [`POINTS`] points on a patch, one a stratum: squares of (u, v), or parts of a segment.
fn strata(sides: u8, seed: u32) -> impl Iterator<Item = (f64, f64)> {
    const SIDE: usize = POINTS.isqrt();
    (0..POINTS).map(move |k| {
        let u = sobol4(k as u32, seed).map(|x| unit(x) as f64);
        match sides {
            2 => ((k as f64 + u[0]) / POINTS as f64, 0.0),
            _ => (((k % SIDE) as f64 + u[0]) / SIDE as f64, ((k / SIDE) as f64 + u[1]) / SIDE as f64),
        }
    })
}

/// What a point sees.
#[derive(Clone, Copy)]
struct Seen {
    /// Share of the view that meets front faces which reflect or emit, and of their light that arrives.
    light: f64,
    /// Covered: no front face in sight, and back faces in a quarter of the view.
    dead: bool,
}

fn look<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    points: &[Point],
    rays: u32,
    seed: u32,
    progress: &mut Progress,
) -> Result<Vec<Seen>> {
    let mut out = Vec::with_capacity(points.len());
    for (c, chunk) in points.chunks(CHUNK).enumerate() {
        let batch = engine.upload(chunk)?;
        let hits = engine.shoot(&batch, seed_of(seed, c as u32), 0, rays)?;
        out.extend(engine.points(&hits)?.chunks_exact(rays as usize).map(|hits| {
            let share = |f: &dyn Fn(&Point) -> bool| hits.iter().filter(|p| f(p)).count() as f64 / rays as f64;
            let front = share(&|p| p.kind == kind::FRONT);
            let lit = |p: &&Point| p.kind == kind::FRONT && geometry.is_live(p.tri as usize);
            let light = hits.iter().filter(lit).map(|p| geometry.arriving(p)).sum::<f64>() / rays as f64;
            Seen { light, dead: front == 0.0 && share(&|p| p.kind == kind::BACK) >= 0.25 }
        }));
        progress.tick()?;
    }
    Ok(out)
}
