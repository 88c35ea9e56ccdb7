//! The error of a solution without its truth (`docs/accuracy.md` derives it).
//!
//! At random surface points that the solution was not trained on, two independent gathers T1, T2 measure one
//! bounce of the solution's own light. For a read-out h the mean of rho^2 (h - T1)(h - T2) is, without bias, the mean
//! square of the residual, whatever the gathers' own noise. What the residual's mean leaves behind in further
//! bounces is bounded by the series q/(1 - q). Direct light, and final gathers, tell their error by their scatter. All of
//! these squares have heavy tails: what a single point may hold of their sum is limited.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Node, NodeLight, Point, Tile, kind};
use crate::network::tiles;
use crate::output::report::{ErrorParts, EstimatedError, RegionError};
use crate::params::{Direct, Method, Params};
use crate::progress::{Event, Progress};
use crate::radiosity::solver::Solved;
use crate::scene::Geometry;
use crate::shade::{self, Brought, Whole};
use crate::solution::Solution;
use crate::stream::{Stream, stream};
use crate::twin::math::seed_of;
use serde::{Deserialize, Serialize};

/// Test rays for each ray of the bake.
const SHARE: f64 = 0.5;
/// Least and most rays of each of the two gathers at a test point.
const HALF: [u32; 2] = [64, 512];
/// Least and most test points.
const POINTS: [u32; 2] = [192, 1_024];
/// The least of a bake of few rays, and the rays for each: where they are quickly shot the tests are not to take longer.
const FEW: (u32, u32) = (96, 64);
/// Share of test points that lie where light is.
const BRIGHT: f64 = 0.5;
/// Share of test points that lie where light falls, beside those of [`BRIGHT`] and the others.
const LANDED: f64 = 1.0 / 3.0;
/// Rays of light that tell how much of it falls on anything, and where.
const LANDINGS: u32 = 4_096;
/// Points in flight.
const CHUNK: usize = 256;
/// Largest share of light that is taken to have been reflected before: what one bounce shows says nothing of more.
const MOST_INDIRECT: f64 = 0.99;
/// The interval's lower end is no farther below the estimate than this factor, but for [`MARGIN`].
const LOWEST: f64 = 1.6;
/// Share of the nodes' mean square residual that is left in the mean over what a gather sees.
const GATHERED: f64 = 0.2;
/// The most that a single test point may hold of all squares.
const TALL: f64 = 0.15;
/// Variance of an even mean of rounds of direct light over that of a random one.
const EVEN: f64 = 0.3;
/// By how much the truth's own points may differ from the tests', and the estimate's assumptions from a scene: below, above.
const MARGIN: [f64; 2] = [1.85, 1.26];
/// The same above where light lies on patches: what one blurs is off all over it, and goes on into further bounces as such.
const PATCHED: f64 = 1.45;
/// Regions that are told apart, as a power of two.
const SPLITS: u32 = 3;

/// What a bake knows of its own noise, scaled (W/m²)², mean over the surface and the bands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Evidence {
    /// Variance of radiosity between halves of the rays; of the mean of both.
    pub noise: Option<f64>,
    /// Mean square of what the last refinement has changed, and of what the one before had.
    pub changes: Option<[f64; 2]>,
}

/// What was found at a test point, scaled W/m².
#[derive(Clone, Copy, Debug, Default)]
struct Test {
    /// Place, metres.
    p: [f64; 3],
    /// Area it stands for.
    weight: f64,
    /// Radiosity of the solution, mean over the bands.
    b: f64,
    /// What of it is reflected.
    reflected: f64,
    /// What of that has been reflected before.
    indirect: f64,
    /// What one bounce of the solution's light brings beyond the nodes' light.
    residual: f64,
    /// Unbiased square of the read-out's error in one bounce: from residuals, or from a gather's scatter.
    square: f64,
    /// Variance of the test itself.
    scatter: f64,
    /// Square of the standard error of direct light.
    direct: f64,
    /// Whether the read-out gathers here.
    gathered: bool,
}

/// A mean over the surface of what `square` finds of a node's light in a band, times the square of its reflectance.
fn over_nodes(geometry: &Geometry, nodes: &[Node], mass: &[f64], square: impl Fn(usize, usize) -> f64) -> f64 {
    let of = |j: usize| {
        let rho = geometry.materials[nodes[j].material as usize].rho;
        (0..3).map(|k| f64::from(rho[k]).powi(2) * square(j, k)).sum::<f64>() / 3.0
    };
    (0..nodes.len()).map(|j| mass[j] * of(j)).sum::<f64>() / mass.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Variance of radiosity from what a part of the rays (`half`, a `share` of all) and all of them bring to the nodes;
/// both over the mass of all.
pub(crate) fn noise(geometry: &Geometry, nodes: &[Node], mass: &[f64], half: &[NodeLight], all: &[NodeLight], share: f64) -> f64 {
    // The parts' own means, m1 and m2, differ by m1 - m = (1 - share)(m1 - m2) from the mean of both.
    over_nodes(geometry, nodes, mass, |j, k| {
        let (one, both) = (f64::from(half[j].h[k]) / share, f64::from(all[j].h[k]));
        (one - both).powi(2) * share / (1.0 - share)
    })
}

/// Mean square of a change of radiosity.
pub(crate) fn change(geometry: &Geometry, nodes: &[Node], mass: &[f64], before: &[NodeLight], after: &[NodeLight]) -> f64 {
    over_nodes(geometry, nodes, mass, |j, k| f64::from(after[j].h[k] - before[j].h[k]).powi(2))
}

/// Test points, and the rays of each of their two gathers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size {
    points: u32,
    half: u32,
}

impl Size {
    /// As a bake of so many rays gets.
    pub fn of_bake(rays: u32) -> Size {
        Size::new(rays, (rays / FEW.1).clamp(FEW.0, POINTS[0]))
    }

    /// For so many rays, of `least` points or more.
    pub fn new(rays: u32, least: u32) -> Size {
        let half = (rays / 512).next_power_of_two().clamp(HALF[0], HALF[1]);
        Size { points: ((f64::from(rays) * SHARE) as u32 / (2 * half)).clamp(least, POINTS[1]), half }
    }
}

/// Estimates the error of a solution by tests; `bright` is what each tile sends, where that is known.
/// Errors: those of the engine, [`crate::Error::Cancelled`].
pub(crate) fn estimate<E: Engine>(
    engine: &mut E,
    solution: &Solution,
    size: Size,
    bright: &[f64],
    solved: Solved,
    evidence: Evidence,
    progress: &mut Progress,
) -> Result<EstimatedError> {
    progress.event(Event::Stage { name: "estimate" })?;
    let (geometry, params) = (solution.geometry(), solution.params());
    engine.set_surface(solution.surface())?;
    engine.set_light(solution.light())?;
    let Size { points: count, half } = size;
    let wanted: Vec<f64> = (0..geometry.tiles as usize).map(|t| bright.get(t).copied().unwrap_or(0.0)).collect();
    let starts = tiles::starts(geometry, &wanted, BRIGHT);
    let (landed, light) = landings(engine, geometry, &starts, bright, params, count)?;
    let mut places = tiles::drawn(geometry, &starts, stream(params.seed, Stream::TestPoints), count - landed.len() as u32);
    places.extend(landed);
    let (mut tests, whole) = (Vec::new(), solution.whole());
    for (c, chunk) in places.chunks(CHUNK).enumerate() {
        tests.extend(test(engine, solution, whole, chunk, half, light, c as u32, progress)?);
    }
    Ok(conclude(&tests, 1.0 / geometry.emission_scale, params, solved, evidence))
}

/// What light counts in the density of test points.
#[derive(Clone, Copy, Debug, Default)]
struct Landed {
    /// Irradiance straight from the emitters, and from what they light.
    per_light: [f64; 2],
}

/// Of `all` test points those where rays end that start where light is sent, with the density that `starts` have there; and
/// what a point's light counts in the density of all, where the others are drawn by `starts`.
///
/// A lamp close by a surface puts half of its light on a patch of its own size, far smaller than a tile, and a lit patch does so in
/// turn: what is wrong there is most of a scene's error, and no other points meet it.
fn landings<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    starts: &[Tile],
    reflected: &[f64],
    params: &Params,
    all: u32,
) -> Result<(Vec<Point>, Landed)> {
    // What else brings light, or brings it round a corner, falls elsewhere.
    let plain = !geometry.is_surfaceless() && !geometry.mirrors && geometry.sigma == 0.0 && !geometry.textured && !geometry.cut;
    // Where points are few, finding such places would take longer than to look from them.
    if !plain || geometry.emitters.is_empty() || all < POINTS[0] {
        return Ok(Default::default());
    }
    // Without exact direct light, what tiles send has their emission in it.
    let apart = params.direct == Direct::Exact || reflected.is_empty();
    let sent: Vec<f64> = (0..geometry.tiles as usize)
        .map(|t| {
            let emit = geometry.material_of(geometry.tile_tri[t] as usize).emit.map(f64::from);
            reflected.get(t).copied().unwrap_or(0.0) + if apart { tiles::mean(&emit) } else { 0.0 }
        })
        .collect();
    let seed = stream(params.seed, Stream::TestLandings);
    let batch = engine.emit(&tiles::starts(geometry, &sent, 1.0), seed, 0, LANDINGS, LANDINGS)?;
    let ends = engine.points(&batch)?;
    let met: Vec<&Point> = ends.chunks_exact(2).filter(|ray| ray[0].kind == kind::FRONT).map(|ray| &ray[1]).collect();
    if met.is_empty() {
        return Ok(Default::default());
    }
    let count = (f64::from(all) * LANDED) as usize;
    let step = (met.len() / count.max(1)).max(1);
    let place = |p: &&Point| Point { weight: 0.0, density: starts[p.tile as usize].density, ..**p };
    let landed: Vec<Point> = met.iter().step_by(step).take(count).map(place).collect();
    let power: f64 = (0..sent.len()).map(|t| sent[t] * geometry.tile_area(t)).sum();
    let arrives = power * met.len() as f64 / f64::from(LANDINGS);
    let per_light = landed.len() as f64 / (all as usize - landed.len()) as f64 / arrives;
    Ok((landed, Landed { per_light: [per_light, if reflected.is_empty() { 0.0 } else { per_light }] }))
}

/// Looks at the solution from some points.
fn test<E: Engine>(
    engine: &mut E,
    solution: &Solution,
    whole: Whole,
    places: &[Point],
    half: u32,
    landed: Landed,
    chunk: u32,
    progress: &mut Progress,
) -> Result<Vec<Test>> {
    let (geometry, params) = (solution.geometry(), solution.params());
    let exact = params.direct == Direct::Exact;
    let Whole { spacing, usual } = whole;
    let seed = |which| seed_of(stream(params.seed, which), chunk);

    // What the solution says, without final gathers.
    let mut batch = engine.upload(places)?;
    engine.assign(&mut batch)?;
    engine.readout(&mut batch)?;
    let network = engine.irradiance(&batch)?;
    let psi = engine.psi(&batch)?;
    let (samples, rounds) = shade::first_rounds(params, geometry.mirrors);
    engine.direct(&mut batch, None, seed(Stream::TestDirect), 0, rounds, samples)?;
    let direct = engine.direct_sums(&batch)?;
    progress.tick()?;

    // What one bounce of it says, twice.
    let mut halves = Vec::new();
    for n in 0..2 {
        let seeds = [Stream::TestRays, Stream::TestHits].map(|which| seed_of(seed(which), n));
        halves.push(shade::look(engine, params, spacing, &batch, seeds, half, shade::BOUNCES, progress)?);
        progress.tick()?;
    }

    let judged = geometry.judged();
    let tests = (0..places.len()).filter_map(|i| {
        let (m, of) = (geometry.material_at(&places[i]), geometry.material_of(places[i].tri as usize));
        let d = direct[i].mean().map(f64::from);
        let [one, two] = [&halves[0][i], &halves[1][i]];
        // Covered surfaces send nothing, nor do those that are not there.
        if !judged(of) || !geometry.is_there(&places[i]) || (one.is_dead() && two.is_dead() && d == [0.0; 3]) {
            return None;
        }
        let says = &network[i];
        let network = [0, 1, 2].map(|k| f64::from(says[k]));
        let (nearness, apart) = (0.5 * (one.nearness + two.nearness), if exact { d } else { [0.0; 3] });
        let gathered = shade::gathers(params) && shade::wants_gather(params, spacing, nearness, &psi[i], says, &apart);
        // What single rays bring tells more of a gather's scatter than two halves do.
        let mut both = Brought::default();
        [one, two].into_iter().for_each(|g| both.add(g, half));
        let (brought, gather) = (both.mean(), shade::gather_variance(params, usual, &d, &both));
        let [straight, once] = landed.per_light;
        let density = f64::from(places[i].density) + straight * tiles::mean(&d) + once * tiles::mean(&brought);
        let mut t = Test { p: geometry.to_world(places[i].p), weight: 1.0 / density, gathered, ..Test::default() };
        for k in 0..3 {
            // Without exact direct light the nodes hold all of it.
            let known = if exact { 0.0 } else { d[k] };
            let rho = f64::from(m.rho[k]);
            let own = rho * network[k];
            let [a, b] = [one, two].map(|g| rho * (f64::from(g.irradiance[k]) + known));
            // The scatter of a mean over both halves.
            let scatter = (a - b).powi(2) / 4.0;
            let residual = (own - a) * (own - b);
            let square = match gathered {
                true => rho * rho * gather + GATHERED * residual,
                false => residual,
            };
            let reflected = own + if exact { rho * d[k] } else { 0.0 };
            t.indirect += (reflected - rho * d[k]).max(0.0) / 3.0;
            t.residual += (0.5 * (a + b) - own) / 3.0;
            t.scatter += scatter / 3.0;
            t.square += square / 3.0;
            t.reflected += reflected / 3.0;
            t.b += (f64::from(m.emit[k]) + reflected) / 3.0;
        }
        if exact || gathered {
            let rho = tiles::mean(&m.rho.map(f64::from));
            t.direct = (rho * shade::direct_error(params, usual, geometry.mirrors, &direct[i], &network)).powi(2);
        }
        Some(t)
    });
    Ok(tests.collect())
}

/// A mean over the area of the tests, and its standard error.
#[derive(Clone, Copy, Default)]
struct Mean {
    value: f64,
    error: f64,
}

impl Mean {
    fn of(tests: &[Test], what: impl Fn(&Test) -> f64) -> Mean {
        let all: f64 = tests.iter().map(|t| t.weight).sum();
        let value = tests.iter().map(|t| t.weight * what(t)).sum::<f64>() / all;
        let error = tests.iter().map(|t| (t.weight * (what(t) - value)).powi(2)).sum::<f64>().sqrt() / all;
        Mean { value, error }
    }

    /// The least and the most that its square may be.
    fn range(self) -> [f64; 2] {
        [(self.value.abs() - 1.5 * self.error).max(0.0), self.value.abs() + 0.75 * self.error].map(|x| x * x)
    }
}

/// Cuts what single tests hold of all squares to [`TALL`] of their sum.
///
/// One point in a slot, or one that a small lamp is seldom found from, can hold half of the sum of a hundred; with it the
/// mean is right on average, and far from right nearly always. Which of the tests it meets is chance, so it goes.
fn tamed(tests: &[Test]) -> Vec<Test> {
    let holds = |t: &Test| t.weight * (t.square + EVEN * t.direct);
    let most = TALL * tests.iter().map(holds).sum::<f64>();
    let (tall, rest): (Vec<&Test>, Vec<&Test>) = tests.iter().partition(|t| holds(t) > most);
    let (left, share) = (rest.into_iter().map(holds).sum::<f64>(), 1.0 - TALL * tall.len() as f64);
    if most <= 0.0 || left <= 0.0 || share <= 0.0 {
        return tests.to_vec();
    }
    // The sum that holds them at that share: what is left, and TALL of it for each.
    let level = TALL * left / share;
    let cut = |t: &Test| {
        let factor = if holds(t) > most { (level / holds(t)).min(1.0) } else { 1.0 };
        Test { square: factor * t.square, direct: factor * t.direct, ..*t }
    };
    tests.iter().map(cut).collect()
}

/// The estimate, its interval and its parts from what was found at the test points.
fn conclude(tests: &[Test], unscale: f64, params: &Params, solved: Solved, evidence: Evidence) -> EstimatedError {
    let over = |what: fn(&Test) -> f64| Mean::of(tests, what);
    let (b, reflected) = (over(|t| t.b).value, over(|t| t.reflected).value);
    if tests.is_empty() || b <= 0.0 || reflected <= 0.0 {
        // All is dark or black: nothing can be wrong with it.
        return EstimatedError::default();
    }
    let of_mean = |square: f64| square.max(0.0).sqrt() / b;

    // A share that all light is off by grows with every further bounce.
    let q = (over(|t| t.indirect).value / reflected).clamp(0.0, MOST_INDIRECT);
    let grows = (q / (1.0 - q) / reflected).powi(2) * over(|t| t.reflected * t.reflected).value;
    let residual = over(|t| t.residual);
    // The square of a mean is too large by that of its own error.
    let carried = (residual.value.powi(2) - residual.error.powi(2)).max(0.0) * grows;

    let tamed = tamed(tests);
    let over = |what: fn(&Test) -> f64| Mean::of(&tamed, what);
    // Rounds of direct light are drawn evenly, so their mean is better than their scatter says: by experience, by half.
    let local = over(|t| t.square + EVEN * t.direct);
    let direct = EVEN * over(|t| t.direct).value;
    let square = (local.value + carried).max(local.error);
    let [least, most] = residual.range().map(|x| x * grows);
    let high = square - carried + most + local.error;
    let low = (square - carried + least.min(carried) - 0.25 * local.error).max(square / LOWEST.powi(2));

    let between = over(|t| if t.gathered { 0.0 } else { t.square }).value.max(0.0);
    let rays = evidence.noise.map(|noise| noise.min(between));
    let cells = evidence.changes.map(|[last, before]| {
        let factor = (last / before.max(f64::MIN_POSITIVE)).sqrt().min(MOST_INDIRECT);
        last * (factor / (1.0 - factor)).powi(2)
    });
    let nodes = between - rays.unwrap_or(0.0) - cells.unwrap_or(0.0);
    let exact = params.direct == Direct::Exact;
    let gathers = shade::gathers(params);
    let above = if matches!(params.method, Method::Fem | Method::Hierarchical) { PATCHED } else { MARGIN[1] };
    EstimatedError {
        rrmse: of_mean(square),
        low: of_mean(low) / MARGIN[0],
        high: of_mean(high) * above,
        parts: ErrorParts {
            rays: rays.map(of_mean),
            cells: cells.map(of_mean),
            nodes: Some(of_mean(nodes)),
            direct: exact.then(|| of_mean(direct)),
            gather: gathers.then(|| of_mean(over(|t| if t.gathered { t.square } else { 0.0 }).value)),
            carried: params.bounces.is_none().then(|| of_mean(carried)),
            solver: params.bounces.is_none().then_some(solved.error_bound),
            truncation: params.bounces.map(|_| of_mean(carried)),
        },
        regions: regions(tests.to_vec(), SPLITS).iter().map(|r| region(r, unscale)).collect(),
    }
}

/// Halves the tests by area along the longest side of their box, `splits` times over.
fn regions(mut tests: Vec<Test>, splits: u32) -> Vec<Vec<Test>> {
    if splits == 0 || tests.len() < 2 {
        return vec![tests];
    }
    let (min, max) = bounds(&tests);
    let axis = (0..3).fold(0, |a, k| if max[k] - min[k] > max[a] - min[a] { k } else { a });
    tests.sort_by(|a, b| a.p[axis].total_cmp(&b.p[axis]));
    let half = 0.5 * tests.iter().map(|t| t.weight).sum::<f64>();
    let mut sum = 0.0;
    let middle = tests.iter().position(|t| {
        sum += t.weight;
        sum >= half
    });
    let rest = tests.split_off(middle.unwrap_or(0).clamp(1, tests.len() - 1));
    [regions(tests, splits - 1), regions(rest, splits - 1)].concat()
}

fn bounds(tests: &[Test]) -> ([f64; 3], [f64; 3]) {
    tests.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(min, max), t| {
        ([0, 1, 2].map(|k| min[k].min(t.p[k])), [0, 1, 2].map(|k| max[k].max(t.p[k])))
    })
}

/// The error in a region. What a gather takes from surroundings that are off is as far off as they are: in a dark
/// region that is all of its light, so residuals count at gathered points as well.
fn region(tests: &[Test], unscale: f64) -> RegionError {
    let (min, max) = bounds(tests);
    let over = |what: fn(&Test) -> f64| Mean::of(tests, what);
    let mean = over(|t| t.b).value;
    let residual = over(|t| t.residual).value.powi(2);
    let squares = [over(|t| t.square + EVEN * t.direct), over(|t| t.residual * t.residual - t.scatter)];
    let square = squares.iter().map(|s| s.value.max(0.5 * s.error)).fold(residual, f64::max);
    RegionError { min, max, mean: mean * unscale, rrmse: if mean > 0.0 { square.sqrt() / mean } else { 0.0 } }
}

/// The error of the middle one of some regions, 0 where there is none.
pub(crate) fn median_region(regions: &[RegionError]) -> f64 {
    let mut errors: Vec<f64> = regions.iter().map(|r| r.rrmse).collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;
    use crate::twin::TwinEngine;
    use crate::twin::direct::Samples;

    #[test]
    fn points_under_a_lamp_stand_for_the_area_that_they_lie_on() {
        // A lamp of 4 cm, 2 cm above the floor of a room of a metre: a tile is 1.7 cm wide.
        let geometry = Geometry::new(&shapes::low_lamp(0.48)).unwrap();
        let mut engine = TwinEngine::new(&geometry);
        let starts = tiles::starts(&geometry, &vec![0.0; geometry.tiles as usize], BRIGHT);
        let all = 6_000;
        let (landed, light) = landings(&mut engine, &geometry, &starts, &[], &Params::default(), all).unwrap();
        assert_eq!(landed.len(), 2_000);
        let mut places = tiles::drawn(&geometry, &starts, 7, all - 2_000);
        places.extend(landed);
        let mut batch = engine.upload(&places).unwrap();
        engine.direct(&mut batch, None, 5, 0, 16, Samples { emitter: 24, cosine: 8 }).unwrap();
        let direct = engine.direct_sums(&batch).unwrap();
        let weight = |i: usize| 1.0 / (f64::from(places[i].density) + light.per_light[0] * f64::from(direct[i].mean()[0]));
        let under = |i: &usize| {
            let p = geometry.to_world(places[*i].p);
            p[1] < 1e-3 && (p[0] - 0.5).abs() < 0.05 && (p[2] - 0.5).abs() < 0.05
        };
        let there: Vec<usize> = (0..places.len()).filter(under).collect();
        let share = there.iter().map(|&i| weight(i)).sum::<f64>() / (0..places.len()).map(weight).sum::<f64>();
        // A square of 10 cm among six square metres: by the area of it some 7 of 4,000 points lie there.
        assert!(there.len() > 1_000, "{}", there.len());
        assert!((share / (0.01 / 6.0016) - 1.0).abs() < 0.2, "{share}");
    }
}
