//! Final gathers: which points get one, how many rays it takes, and the light where they end.

use super::Whole;
use super::direct::BRIGHT;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, Point, Psi, kind};
use crate::network::tiles::mean;
use crate::params::{Direct, Params};
use crate::progress::Progress;
use crate::stream::{Stream, stream};
use crate::twin::direct::Samples;
use crate::twin::gather::Gathered;
use crate::twin::math::seed_of;

/// Most rays in flight.
pub(super) const HITS: usize = 262_144;
/// Samples of direct light at a gather ray's hit.
const HIT: Samples = Samples { emitter: 2, cosine: 1 };
/// Hits nearer than this many node spacings ask for light by a ray of their own.
const CLOSE: f64 = 0.5;
/// Bounces in a slot before the nodes' light is taken all the same.
pub(crate) const BOUNCES: u32 = 8;
/// Share of its light by which the nodes that speak for a point may disagree.
const TORN: f64 = 0.1;
/// How many times as many rays a gather may have whose rays bring very different light.
const MORE: u32 = 4;
/// Rays of a bake below which nodes are so few that most disagree, and gathers so short that all scatter: better gathers would take
/// longer than a larger bake.
const FEW: u32 = 16_384;

/// Whether points are gathered for at all: what a gather brings has been reflected once more.
pub(crate) fn gathers(params: &Params) -> bool {
    params.gather_rays > 0 && params.bounces.is_none()
}

/// Whether a point gets a final gather, by how near its surroundings are, the nodes that speak for it, what they say and what comes
/// straight from emitters: nodes are too far apart for it, they disagree, or none speaks for it.
pub(crate) fn wants_gather(params: &Params, spacing: f64, nearness: f32, psi: &Psi, says: &[f32; 4], direct: &[f64; 3]) -> bool {
    let light = mean(&[0, 1, 2].map(|k| direct[k] + f64::from(says[k])));
    let torn = params.rays >= FEW && f64::from(says[3]) > TORN * light;
    nearness as f64 * params.gather_threshold * spacing > 1.0 || psi.is_orphan() || torn
}

/// The standard error that is asked of a gather at a point with so much light: that of rays which scatter by all of it. Where it
/// is dark, of rays which scatter by the usual light; where it is bright, [`BRIGHT`] is the most that counts.
fn goal(params: &Params, usual: f64, light: f64) -> f64 {
    light.clamp(usual, BRIGHT * usual) / f64::from(params.gather_rays).sqrt()
}

/// The most rays of a gather.
fn most(params: &Params) -> u32 {
    if params.rays < FEW { params.gather_rays } else { MORE * params.gather_rays }
}

/// The variance that a gather will be left with at a point with so much direct light, from some of its rays.
pub(crate) fn gather_variance(params: &Params, usual: f64, direct: &[f64; 3], some: &Brought) -> f64 {
    let goal = goal(params, usual, some.light(direct));
    let (mut left, mut done) = (some.variance() * some.rays / f64::from(params.gather_rays), params.gather_rays);
    while left > goal * goal && done < most(params) {
        // As below: what has been shot is doubled.
        done *= 2;
        left *= 0.5;
    }
    left
}

/// What the rays of a gather brought, summed up.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Brought {
    rays: f64,
    sum: [f64; 3],
    square: f64,
}

impl Brought {
    /// Adds what so many rays brought.
    pub fn add(&mut self, gathered: &Gathered, rays: u32) {
        let rays = f64::from(rays);
        self.rays += rays;
        self.square += rays * f64::from(gathered.square);
        (0..3).for_each(|k| self.sum[k] += rays * f64::from(gathered.irradiance[k]));
    }

    /// The irradiance that is not direct.
    pub fn mean(&self) -> [f64; 3] {
        self.sum.map(|x| x / self.rays)
    }

    /// All irradiance beside so much direct light, mean over the bands.
    fn light(&self, direct: &[f64; 3]) -> f64 {
        let brought = self.mean();
        mean(&[0, 1, 2].map(|k| direct[k] + brought[k]))
    }

    /// Variance of the mean, of the mean over the bands.
    fn variance(&self) -> f64 {
        (self.square / self.rays - mean(&self.mean()).powi(2)).max(0.0) / self.rays
    }
}

/// Final gathers at points whose direct light is known, with as many rays as their scatter asks for: the irradiance that is not
/// direct, and the rays shot.
pub(super) fn gather<E: Engine>(
    engine: &mut E,
    params: &Params,
    whole: Whole,
    points: &[Point],
    direct: &[[f64; 3]],
    seed: u32,
    progress: &mut Progress,
) -> Result<(Vec<[f64; 3]>, u64)> {
    let mut sums = vec![Brought::default(); points.len()];
    let mut active: Vec<usize> = (0..points.len()).collect();
    let (mut rays, mut done, mut shot, mut turn) = (params.gather_rays, 0, 0, 0);
    while !active.is_empty() {
        for chunk in active.chunks((HITS / rays as usize).max(1)) {
            let from = engine.upload(&chunk.iter().map(|&i| points[i]).collect::<Vec<_>>())?;
            let seeds = [Stream::PointGather, Stream::HitDirect].map(|which| seed_of(stream(seed, which), turn));
            let gathered = look(engine, params, whole.spacing, &from, seeds, rays, BOUNCES, progress)?;
            chunk.iter().zip(&gathered).for_each(|(&i, g)| sums[i].add(g, rays));
            progress.tick()?;
            turn += 1;
        }
        shot += active.len() as u64 * u64::from(rays);
        done += rays;
        let scatters = |i: usize| sums[i].variance().sqrt() > goal(params, whole.usual, sums[i].light(&direct[i]));
        active.retain(|&i| done < most(params) && scatters(i));
        // Double what has been shot.
        rays = done;
    }
    Ok((sums.iter().map(Brought::mean).collect(), shot))
}

/// What `rays` cosine rays of each point of a batch bring; `seeds` are the rays' own, and their ends'. In slots light is followed for
/// `bounces`.
pub(crate) fn look<E: Engine>(
    engine: &mut E,
    params: &Params,
    spacing: f64,
    from: &E::Batch,
    seeds: [u32; 2],
    rays: u32,
    bounces: u32,
    progress: &mut Progress,
) -> Result<Vec<Gathered>> {
    let mut hits = engine.shoot(from, seeds[0], 0, rays)?;
    light_hits(engine, params, spacing, &mut hits, seeds[1], bounces, progress)?;
    engine.gather(&hits, rays, true, params.direct == Direct::Exact)
}

/// Finds the light at the hits of gather rays: the nodes', and direct light where that is exact.
///
/// A hit much nearer than nodes lie apart is in a slot, or beside a contact, of which no node speaks: its light is what
/// one ray of its own brings, and so on for `bounces` until the light is met outside.
fn light_hits<E: Engine>(
    engine: &mut E,
    params: &Params,
    spacing: f64,
    hits: &mut E::Batch,
    seed: u32,
    bounces: u32,
    progress: &mut Progress,
) -> Result<()> {
    let exact = params.direct == Direct::Exact;
    if exact {
        engine.direct(hits, None, seed, 0, 1, HIT)?;
    }
    let points = match bounces {
        0 => Vec::new(),
        _ => engine.points(hits)?,
    };
    let is_close = |p: &Point| f64::from(p.weight) < CLOSE * spacing;
    let front = (0..points.len()).filter(|&i| points[i].kind == kind::FRONT);
    let (close, far): (Vec<usize>, Vec<usize>) = front.partition(|&i| is_close(&points[i]));
    if close.is_empty() {
        engine.assign(hits)?;
        engine.readout(hits)?;
        engine.finish()?;
        return progress.tick();
    }
    let mut light = vec![[0.0; 4]; points.len()];
    let own = |listed: &[usize]| listed.iter().map(|&i| points[i]).collect::<Vec<_>>();

    // Only those whose light the nodes speak for are asked about.
    if !far.is_empty() {
        let mut from = engine.upload(&own(&far))?;
        engine.assign(&mut from)?;
        engine.readout(&mut from)?;
        far.iter().zip(engine.irradiance(&from)?).for_each(|(&i, l)| light[i] = l);
    }
    progress.tick()?;

    let mut from = engine.upload(&own(&close))?;
    let seeds = [Stream::PointGather, Stream::HitDirect].map(|which| stream(seed, which));
    let brought = look(engine, params, spacing, &from, seeds, 1, bounces - 1, progress)?;
    let known = match exact {
        true => vec![[0.0; 3]; close.len()],
        false => {
            // The nodes' light would have held it.
            engine.direct(&mut from, None, stream(seed, Stream::PointDirect), 0, 1, HIT)?;
            engine.direct_sums(&from)?.iter().map(DirectSum::mean).collect()
        }
    };
    for (k, &i) in close.iter().enumerate() {
        for b in 0..3 {
            light[i][b] = known[k][b] + brought[k].irradiance[b];
        }
    }
    engine.set_irradiance(hits, &light)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::nodes::surface_of;
    use crate::progress::Flow;
    use crate::scene::{Geometry, shapes};
    use crate::twin::TwinEngine;
    use crate::twin::trace::surface_point;

    const RAYS: u32 = 64;

    #[test]
    fn a_point_is_gathered_for_where_its_nodes_disagree() {
        let params = Params::default();
        let psi = Psi { node: [0, 1, u32::MAX, u32::MAX], weight: [0.5, 0.5, 0.0, 0.0] };
        let wants = |torn, light| wants_gather(&params, 0.05, 0.1, &psi, &[1.0, 1.0, 1.0, torn], &[light - 1.0; 3]);
        assert!(wants(0.3, 2.0) && !wants(0.1, 2.0));
        // Direct light makes what they disagree about smaller, and of few rays most nodes disagree.
        assert!(!wants(0.3, 4.0));
        let few = Params { rays: FEW - 1, ..params.clone() };
        assert!(!wants_gather(&few, 0.05, 0.1, &psi, &[1.0, 1.0, 1.0, 0.3], &[1.0; 3]));
    }

    #[test]
    fn rays_that_bring_very_different_light_are_shot_on() {
        // A lamp of 4 cm, 2 cm above the floor of a room of a metre: nearly all that the wall gets comes from a patch under it.
        let geometry = Geometry::new(&shapes::low_lamp(0.1)).unwrap();
        let engine = &mut TwinEngine::new(&geometry);
        // No node speaks for anything: all that rays bring is direct light, once reflected.
        engine.set_surface(&surface_of(&geometry, Vec::new(), 0.3, false)).unwrap();
        engine.set_light(&[]).unwrap();
        let params = Params { gather_rays: RAYS, ..Params::default() };
        let quiet = &mut |_: &_| Flow::Continue;
        let progress = &mut Progress::new(quiet);
        let at = geometry.locate([0.0, 0.3, 0.5], [1.0, 0.0, 0.0]).unwrap();
        let point = Point { p: at.p, ..surface_point(&geometry, at.tri, 0.3, 0.3) };
        let usual = geometry.power_density();

        let scatter = |of: &[f64]| {
            let mean = of.iter().sum::<f64>() / of.len() as f64;
            (mean, of.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (of.len() - 1) as f64)
        };
        let (mut plain, mut more, mut rays) = (Vec::new(), Vec::new(), 0);
        for seed in 0..48 {
            let from = engine.upload(&[point]).unwrap();
            let found = look(engine, &params, 0.0, &from, [seed, seed + 100], RAYS, BOUNCES, progress).unwrap();
            plain.push(f64::from(found[0].irradiance[0]));
            let whole = Whole { spacing: 0.0, usual };
            let (brought, shot) = gather(engine, &params, whole, &[point], &[[0.0; 3]], seed, progress).unwrap();
            more.push(brought[0][0]);
            rays += shot;
        }
        let ((mean, variance), (same, less)) = (scatter(&plain), scatter(&more));
        assert!(rays > 2 * 48 * u64::from(RAYS), "{rays} rays");
        assert!(less < 0.6 * variance, "variance {variance} -> {less}");
        assert!((mean - same).abs() < 3.0 * ((variance + less) / 48.0).sqrt(), "{mean}, {same}");

        // Where nothing is brought nothing differs.
        let dark = Params { direct: Direct::Network, ..params };
        let whole = Whole { spacing: 0.0, usual };
        assert_eq!(gather(engine, &dark, whole, &[point], &[[0.0; 3]], 1, progress).unwrap(), (vec![[0.0; 3]], u64::from(RAYS)));
    }
}
