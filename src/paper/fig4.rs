//! Fig. 4: light after one reflection, from the kernel itself and from the network that has learned it.

use super::kernel::{Learned, analytic, distance, learn, point};
use super::{Figure, Press, dense, stage};
use crate::engine::{Backend, Engine};
use crate::error::Result;
use crate::layout::{NONE, Point};
use crate::output::image::Tone;
use crate::params::{Direct, Mode, Output, PaperParams, Params};
use crate::pass::GpuEngine;
use crate::plot::color::{GREY, SERIES};
use crate::plot::panel::{Axis, open, titled};
use crate::plot::picture::picture;
use crate::plot::{draw, unit};
use crate::progress::Progress;
use crate::scene::{Geometry, LoadOptions, Scene, Space};
use crate::solution::Camera;
use crate::twin::TwinEngine;
use crate::twin::trace::{Ray, closest, surface_point};
use glam::{DVec3, Vec3};
use std::path::Path;

/// How much of it is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Cells of the network in flatland.
    pub flat_cells: u32,
    /// Cells of the network in space.
    pub cells: u32,
    /// Kernel evaluations for each cell.
    pub evaluations: u32,
    /// Pixels across a picture.
    pub width: u32,
    /// Points along each segment in flatland; an eighth of them along each side of the emitter in space.
    pub points: usize,
}

impl Default for Options {
    fn default() -> Options {
        Options { flat_cells: 1024, cells: 4096, evaluations: 32, width: 300, points: 64 }
    }
}

fn read(press: &mut Press, name: &str, bytes: &[u8]) -> Result<Scene> {
    let path = format!("{name}.toml");
    let mut scene = Scene::load_from(Path::new(&path), &LoadOptions::default(), &mut |_| Ok(bytes.to_vec()), press.tell)?;
    scene.name = name.into();
    Ok(scene)
}

/// Parameters of the paper's network.
fn params(press: &Press, cells: u32, evaluations: u32) -> Params {
    let paper = PaperParams { evaluations: Some(cells * evaluations), ..PaperParams::default() };
    Params { seed: press.seed, mode: Mode::Paper, direct: Direct::Network, cells: Some(cells), paper, ..Params::default() }
}

/// Light after one reflection at places of a scene, W/m² (W/m): from the kernel, and from networks.
struct Light {
    analytic: Vec<f64>,
    network: Vec<f64>,
    /// From a network whose metric knows normals and whose cells are planes: the repairs that help most.
    repaired: Vec<f64>,
    learned: Learned,
}

/// Points of the emitters, each with its emitted radiosity times its part of the area (length).
struct Emitters(Vec<(Point, f64)>);

impl Emitters {
    /// `n` points on each emitting segment, or about `n` x `n` on each emitting triangle.
    fn of(geometry: &Geometry, n: usize) -> Emitters {
        let mut all = Vec::new();
        for e in &geometry.emitters {
            let t = e.tri;
            let area = geometry.areas[t as usize];
            let metres = if geometry.flatland { area / geometry.scale } else { area / geometry.scale.powi(2) };
            let mut places = Vec::new();
            if geometry.flatland {
                places.extend((0..n).map(|i| ((i as f32 + 0.5) / n as f32, 0.0)));
            } else {
                // The middles of n x n equal triangles.
                let h = 1.0 / n as f32;
                for i in 0..n {
                    for j in 0..n - i {
                        let (a, b) = (i as f32 * h, j as f32 * h);
                        places.push((a + h / 3.0, b + h / 3.0));
                        if j + 1 < n - i {
                            places.push((a + 2.0 * h / 3.0, b + 2.0 * h / 3.0));
                        }
                    }
                }
            }
            let share = metres / places.len() as f64;
            for (b1, b2) in places {
                let p = surface_point(geometry, t, b1, b2);
                all.push((p, dense::emitted(geometry, &p) * share));
            }
        }
        Emitters(all)
    }

    /// What a kernel brings from all emitters to each point.
    fn gather(&self, points: &[Point], mut kernel: impl FnMut(&[Point]) -> Result<Vec<f64>>) -> Result<Vec<f64>> {
        let mut all = Vec::with_capacity(points.len());
        for some in points.chunks(4096) {
            let pairs: Vec<Point> = some.iter().flat_map(|y| self.0.iter().flat_map(|(x, _)| [*x, *y])).collect();
            let values = kernel(&pairs)?;
            let each = values.chunks_exact(self.0.len());
            all.extend(each.map(|row| row.iter().zip(&self.0).map(|(k, (_, e))| k * e).sum::<f64>()));
        }
        Ok(all)
    }
}

/// Learns a scene's kernel and brings the emitters' light to places, both ways, from `fine` and `coarse` points of them.
fn shine<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    params: &Params,
    places: &[Point],
    fine: usize,
    coarse: usize,
    progress: &mut Progress,
) -> Result<Light> {
    let learned = learn(engine, geometry, params, progress)?;
    let lit = Emitters::of(geometry, fine).gather(places, |pairs| analytic(engine, geometry, pairs))?;
    let coarse = Emitters::of(geometry, coarse);
    let network = coarse.gather(places, |pairs| learned.answers(engine, geometry, pairs))?;
    let paper = PaperParams { normals: true, output: Output::Linear, ..params.paper.clone() };
    let repaired = learn(engine, geometry, &Params { paper, ..params.clone() }, progress)?;
    let repaired = coarse.gather(places, |pairs| repaired.answers(engine, geometry, pairs))?;
    let reflect = |h: Vec<f64>| -> Vec<f64> { h.iter().zip(places).map(|(h, p)| dense::reflectance(geometry, p) * h).collect() };
    Ok(Light { analytic: reflect(lit), network: reflect(network), repaired: reflect(repaired), learned })
}

fn on_any(
    press: &mut Press,
    geometry: &Geometry,
    params: &Params,
    places: &[Point],
    fine: usize,
    coarse: usize,
) -> Result<Light> {
    let mut progress = Progress::new(&mut *press.tell);
    match press.backend {
        Backend::Cpu => shine(&mut TwinEngine::new(geometry), geometry, params, places, fine, coarse, &mut progress),
        Backend::Gpu(gpu) => shine(&mut GpuEngine::new(gpu, geometry)?, geometry, params, places, fine, coarse, &mut progress),
    }
}

/// What a camera sees at each pixel's centre, from whichever side: the triangle and the place, local.
fn seen(geometry: &Geometry, camera: &Camera) -> Vec<Option<Point>> {
    let origin = DVec3::from_array(geometry.to_local(camera.eye)).as_vec3();
    (0..camera.width * camera.height)
        .map(|i| {
            let direction = DVec3::from_array(camera.direction(i % camera.width, i / camera.width)).as_vec3();
            let hit = closest(geometry, &Ray { origin, direction, t_max: f32::MAX, skip: [NONE; 2] });
            let front = hit.tri != NONE && Vec3::from(geometry.tris[hit.tri as usize].normal).dot(direction) < 0.0;
            front.then(|| surface_point(geometry, hit.tri, hit.b1, hit.b2))
        })
        .collect()
}

/// How deep the extruded scene of Fig. 4a is, m: the front half is lit by the kernel, the back half by the network.
const DEPTH: f64 = 1.6;

/// Makes Fig. 4a.
pub fn flat(press: &mut Press, options: &Options) -> Result<Figure> {
    stage(press, "fig4a")?;
    let mut scene = read(press, "box", include_bytes!("../../scenes/flatland/box.toml"))?;
    scene.space = Space::Flatland { height: DEPTH };
    let geometry = Geometry::new(&scene)?;

    // Light along every segment, and the way along them for plotting.
    let n = options.points;
    let (mut places, mut arc, mut start) = (Vec::new(), Vec::new(), 0.0);
    for f in 0..scene.faces.len() {
        let tri = geometry.source.iter().position(|&s| s == f as u32);
        for i in 0..n {
            let u = (i as f32 + 0.5) / n as f32;
            places.extend(tri.map(|t| surface_point(&geometry, t as u32, u, 0.0)));
            arc.extend(tri.map(|_| start + u as f64 * scene.area(f)));
        }
        start += scene.area(f);
    }
    let params = params(press, options.flat_cells, options.evaluations);
    let light = on_any(press, &geometry, &params, &places, 512, 128)?;

    // The corridor: its walls stand along z, seen from before its front end.
    let walls = Geometry::new(&scene.extruded())?;
    let camera = Camera {
        eye: [0.5, 0.5, DEPTH + 1.25],
        target: [0.5, 0.5, 0.0],
        up: [0.0, 1.0, 0.0],
        vfov_degrees: 45.0,
        width: 2 * options.width,
        height: 2 * options.width,
    };
    let first: Vec<Option<usize>> = (0..scene.faces.len())
        .scan(0, |next, f| {
            let there = geometry.source.contains(&(f as u32));
            let at = there.then_some(*next);
            *next += if there { n } else { 0 };
            Some(at)
        })
        .collect();
    let color = |p: &Point| -> Option<Seen> {
        let face = walls.source[p.tri as usize] as usize / 2;
        let world = walls.to_world(p.p);
        let [a, b, _] = scene.corners(face).map(DVec3::from_array);
        let u = ((DVec3::new(world[0], world[1], 0.0) - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let values = if world[2] > 0.5 * DEPTH { &light.analytic } else { &light.network };
        let (x, first) = ((u * n as f64 - 0.5).clamp(0.0, (n - 1) as f64), first[face]?);
        let (i, j) = (x as usize, (x as usize + 1).min(n - 1));
        if scene.materials[scene.faces[face].material as usize].emission[0] > 0.0 {
            return Some(Seen::Emitter);
        }
        Some(Seen::Light(values[first + i] + (values[first + j] - values[first + i]) * x.fract()))
    };
    let hits = seen(&walls, &camera);
    let values: Vec<Seen> = hits.iter().map(|p| p.as_ref().and_then(color).unwrap_or(Seen::Nothing)).collect();
    let pixels = tone(&values, &light.analytic);

    let mut figure =
        Figure::new("fig4a", "Fig. 4a: one reflection in flatland, from the kernel in front, from the network behind");
    let most = light.analytic.iter().chain(&light.network).copied().fold(0.0, f64::max);
    stage(press, "plot")?;
    let drawn = draw(1200, 560, |page| {
        let (left, right) = page.split_horizontally(unit(520.0));
        let area = titled(&left, "in front: the kernel · behind: the network")?;
        picture(&area, &pixels, camera.width, camera.height)?;
        let area = titled(&right, "the same along the lines")?;
        let x = Axis::linear("along bottom, right, top, left, blocker (m)", [0.0, start]);
        let mut panel = open(&area, &x, &Axis::linear("B − E after one reflection (W/m)", [0.0, 1.15 * most]), None)?;
        let lines = [(&light.analytic, GREY, 4.0), (&light.network, SERIES[1], 1.4), (&light.repaired, SERIES[0], 1.4)];
        for (values, color, width) in lines {
            for segment in 0..arc.len() / n {
                let of = segment * n..(segment + 1) * n;
                let line: Vec<[f64; 2]> = of.map(|i| [arc[i], values[i]]).collect();
                panel.line(&line, color, width)?;
            }
        }
        let names = [("kernel", GREY), ("the paper's network", SERIES[1]), ("with normals, linear cells", SERIES[0])];
        panel.legend(&names, true)
    });
    figure.drawing(press, drawn)?;
    let rows = (0..arc.len()).map(|i| vec![arc[i], light.analytic[i], light.network[i], light.repaired[i]]);
    figure.csv(press, ".csv", "arc,kernel,network,repaired", rows)?;
    figure.about.push(format!(
        "A closed room in flatland, drawn as a corridor: a light in its ceiling, a thin blocker below it. What is seen is the \
         light after one reflection, B = E + ρ ∫ K E. In the front half the integral takes the kernel itself (512 points on \
         the light), in the back half the answers of the paper's network, which has learned the kernel between all places \
         of the room ({} cells, {} evaluations, positions only: two coordinates at either end).",
        options.flat_cells,
        options.flat_cells * options.evaluations
    ));
    figure.about.push(
        "The network's error is the relative L2 norm of its B − E along all lines. Where the two sides of the blocker, or two \
         walls in a corner, lie close together, positions alone do not tell them apart, and light leaks. With normals in the \
         metric and cells that are planes (two of the repairs, none of them the paper's) it does not."
            .into(),
    );
    let weigh = |values: &[f64]| weighted(&scene, &geometry, n, values);
    let kernel = weigh(&light.analytic);
    figure.number("error of the reflected light: the paper's network", distance(&weigh(&light.network), &kernel), "1");
    figure.number("with normals and linear cells", distance(&weigh(&light.repaired), &kernel), "1");
    figure.number("kernel error, over all pairs of the scene", light.learned.error, "1");
    figure.number("energy that the clamp took", light.learned.clamped, "1");
    figure.finish(press)?;
    Ok(figure)
}

/// Values along the segments, `n` each, so that a sum of squares is an integral along the lines.
fn weighted(scene: &Scene, geometry: &Geometry, n: usize, values: &[f64]) -> Vec<f64> {
    let there = (0..scene.faces.len()).filter(|f| geometry.source.contains(&(*f as u32)));
    let lengths: Vec<f64> = there.map(|f| scene.area(f).sqrt()).collect();
    values.iter().enumerate().map(|(i, v)| v * lengths[i / n]).collect()
}

/// What is seen where nothing is.
const NOTHING: [u8; 3] = [222, 228, 235];
/// What an emitter looks like.
const SHINES: [u8; 3] = [255, 243, 196];

/// What is seen at a pixel.
#[derive(Clone, Copy)]
enum Seen {
    Nothing,
    Emitter,
    /// Reflected radiosity.
    Light(f64),
}

/// Pixels: grey for reflected light, with one exposure.
fn tone(seen: &[Seen], exposed_for: &[f64]) -> Vec<[u8; 3]> {
    let all: Vec<[f32; 3]> = exposed_for.iter().map(|&v| [v as f32; 3]).collect();
    let tone = Tone::auto(&all);
    let color = |s: &Seen| match s {
        Seen::Nothing => NOTHING,
        Seen::Emitter => SHINES,
        Seen::Light(v) => tone.map([v.max(0.0) as f32; 3]),
    };
    seen.iter().map(color).collect()
}

/// Points along each side of the floor at which the error is measured.
const FLOOR: usize = 48;

/// Makes Fig. 4b and c.
pub fn solid(press: &mut Press, options: &Options) -> Result<Figure> {
    stage(press, "fig4bc")?;
    let scene = read(press, "wall", include_bytes!("../../scenes/wall/scene.toml"))?;
    let geometry = Geometry::new(&scene)?;
    let height = options.width * 3 / 4;
    let camera = scene.cameras.first().map_or(
        Camera {
            eye: [0.5, 1.0, 2.0],
            target: [0.5, 0.2, 0.3],
            up: [0.0, 1.0, 0.0],
            vfov_degrees: 40.0,
            width: options.width,
            height,
        },
        |view| Camera { width: options.width, height, ..view.camera },
    );

    // What the camera sees, then an even grid on the floor for the error.
    let hits = seen(&geometry, &camera);
    let mut places: Vec<Point> = hits.iter().flatten().copied().collect();
    let pixels = places.len();
    let middle = |i: usize| (i as f64 + 0.5) / FLOOR as f64;
    for i in 0..FLOOR * FLOOR {
        places.push(point(&geometry, [middle(i % FLOOR), 0.0, middle(i / FLOOR)], [0.0, 1.0, 0.0])?);
    }
    let params = params(press, options.cells, options.evaluations);
    let light = on_any(press, &geometry, &params, &places, options.points / 8, options.points / 20)?;

    let shown = |values: &[f64]| {
        let mut next = values[..pixels].iter();
        let lit = |hit: &Option<Point>| match (hit, hit.as_ref().and_then(|_| next.next())) {
            (Some(p), Some(_)) if dense::emitted(&geometry, p) > 0.0 => Seen::Emitter,
            (Some(_), Some(&v)) => Seen::Light(v),
            _ => Seen::Nothing,
        };
        let values: Vec<Seen> = hits.iter().map(lit).collect();
        tone(&values, &light.analytic[pixels..])
    };
    stage(press, "plot")?;
    let pictures = [&light.analytic, &light.network, &light.repaired].map(|values| shown(values));
    let mut figure =
        Figure::new("fig4bc", "Fig. 4b, c: one reflection in space, from the kernel and from a network of six dimensions");
    let drawn = draw(1260, 45 + 420 * 3 / 4, |page| {
        let network = format!("(c) the network, {} cells", options.cells);
        let titles = ["(b) the kernel", &network, "(d) with normals and linear cells"];
        for ((area, title), pixels) in page.split_evenly((1, 3)).iter().zip(titles).zip(&pictures) {
            picture(&titled(area, title)?, pixels, camera.width, camera.height)?;
        }
        Ok(())
    });
    figure.drawing(press, drawn)?;
    let [kernel, network, repaired] = [&light.analytic, &light.network, &light.repaired].map(|v| &v[pixels..]);
    let rows = (0..FLOOR * FLOOR).map(|i| vec![middle(i % FLOOR), middle(i / FLOOR), kernel[i], network[i], repaired[i]]);
    figure.csv(press, ".csv", "x,z,kernel,network,repaired", rows)?;
    figure.about.push(format!(
        "A wall with a lit window, a floor, and a blocker between, after one reflection: (b) from the kernel itself, (c) from \
         the paper's network of it in six dimensions, the two places of a pair ({} cells, {} evaluations), (d) with two \
         repairs that are not the paper's. All have one exposure.",
        options.cells,
        options.cells * options.evaluations
    ));
    figure.about.push(format!(
        "The error is the relative L2 norm of the light that the floor reflects, over {FLOOR} x {FLOOR} places. The kernel's \
         light takes {0} x {0} points on each half of the window, the network's {1} x {1}.",
        options.points / 8,
        options.points / 20
    ));
    figure.number("error of the light on the floor: the paper's network", distance(network, kernel), "1");
    figure.number("with normals and linear cells", distance(repaired, kernel), "1");
    figure.number(
        "light on the floor, the paper's network over the kernel",
        network.iter().sum::<f64>() / kernel.iter().sum::<f64>(),
        "1",
    );
    figure.number("kernel error, over all pairs of the scene", light.learned.error, "1");
    figure.number("energy that the clamp took", light.learned.clamped, "1");
    figure.finish(press)?;
    Ok(figure)
}
