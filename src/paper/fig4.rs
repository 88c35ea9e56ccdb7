//! Fig. 4: light after one reflection, from the kernel itself and from the network that has learned it.

use super::kernel::{Learned, analytic, distance, learn, point};
use super::{Figure, Press, dense, stage};
use crate::engine::{Backend, Engine};
use crate::error::Result;
use crate::layout::{NONE, Point};
use crate::output::image::Tone;
use crate::params::{Direct, Mode, PaperParams, Params};
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
use std::f64::consts::PI;
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
    /// Points along each segment in flatland; and squared, half as many on the emitter in space.
    pub points: usize,
}

impl Default for Options {
    fn default() -> Options {
        Options { flat_cells: 1024, cells: 4096, evaluations: 32, width: 360, points: 96 }
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

/// Light after one reflection at places of a scene, W/m² (W/m): from the kernel, and from the network.
struct Light {
    analytic: Vec<f64>,
    network: Vec<f64>,
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
    let network = Emitters::of(geometry, coarse).gather(places, |pairs| learned.answers(engine, geometry, pairs))?;
    let reflect = |h: Vec<f64>| -> Vec<f64> {
        h.iter().zip(places).map(|(h, p)| dense::reflectance(geometry, p) * h).collect()
    };
    Ok(Light { analytic: reflect(lit), network: reflect(network), learned })
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
        Backend::Gpu(gpu) => {
            shine(&mut GpuEngine::new(gpu, geometry)?, geometry, params, places, fine, coarse, &mut progress)
        }
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
    let height = options.width * 3 / 4;
    let camera = Camera {
        eye: [0.5, 0.5, DEPTH + 1.25],
        target: [0.5, 0.5, 0.0],
        up: [0.0, 1.0, 0.0],
        vfov_degrees: 42.0,
        width: 2 * options.width,
        height: 2 * height,
    };
    let first: Vec<Option<usize>> = (0..scene.faces.len())
        .scan(0, |next, f| {
            let there = geometry.source.contains(&(f as u32));
            let at = there.then_some(*next);
            *next += if there { n } else { 0 };
            Some(at)
        })
        .collect();
    let color = |p: &Point| -> Option<f64> {
        let face = walls.source[p.tri as usize] as usize / 2;
        let world = [0, 1, 2].map(|k| p.p[k] as f64 / walls.scale + walls.center[k]);
        let [a, b, _] = scene.corners(face).map(DVec3::from_array);
        let u = ((DVec3::new(world[0], world[1], 0.0) - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        let values = if world[2] > 0.5 * DEPTH { &light.analytic } else { &light.network };
        let (x, first) = ((u * n as f64 - 0.5).clamp(0.0, (n - 1) as f64), first[face]?);
        let (i, j) = (x as usize, (x as usize + 1).min(n - 1));
        let own = scene.materials[scene.faces[face].material as usize].emission[0] * PI;
        Some(own + values[first + i] + (values[first + j] - values[first + i]) * x.fract())
    };
    let values: Vec<Option<f64>> = seen(&walls, &camera).iter().map(|p| p.as_ref().and_then(color)).collect();
    let pixels = tone(&values, &light.analytic);

    let mut figure = Figure::new("fig4a", "Fig. 4a: one reflection in flatland, from the kernel in front, from the network behind");
    let most = light.analytic.iter().chain(&light.network).copied().fold(0.0, f64::max);
    let drawn = draw(1260, 500, |page| {
        let (left, right) = page.split_horizontally(unit(630.0));
        let area = titled(&left, "in front: the kernel · behind: the network")?;
        picture(&area, &pixels, camera.width, camera.height)?;
        let area = titled(&right, "the same along the lines")?;
        let x = Axis::linear("along bottom, right, top, left, blocker (m)", [0.0, start]);
        let mut panel = open(&area, &x, &Axis::linear("B − E after one reflection (W/m)", [0.0, 1.15 * most]), None)?;
        for (values, color, width) in [(&light.analytic, GREY, 4.0), (&light.network, SERIES[1], 1.4)] {
            for segment in 0..arc.len() / n {
                let of = segment * n..(segment + 1) * n;
                let line: Vec<[f64; 2]> = of.map(|i| [arc[i], values[i]]).collect();
                panel.line(&line, color, width)?;
            }
        }
        panel.legend(&[("kernel", GREY), ("network", SERIES[1])], false)
    });
    figure.drawing(press, drawn)?;
    let rows = (0..arc.len()).map(|i| vec![arc[i], light.analytic[i], light.network[i]]);
    figure.csv(press, ".csv", "arc,kernel,network", rows)?;
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
         walls in a corner, lie close together, positions alone do not tell them apart, and light leaks."
            .into(),
    );
    figure.number("error of the reflected light", weighted_distance(&scene, &geometry, n, &light), "1");
    figure.number("kernel error, over all pairs of the scene", light.learned.error, "1");
    figure.number("energy that the clamp took", light.learned.clamped, "1");
    figure.finish(press)?;
    Ok(figure)
}

/// Relative L2 distance of the network's light from the kernel's, where each segment counts by its length.
fn weighted_distance(scene: &Scene, geometry: &Geometry, n: usize, light: &Light) -> f64 {
    let lengths: Vec<f64> =
        (0..scene.faces.len()).filter(|f| geometry.source.contains(&(*f as u32))).map(|f| scene.area(f).sqrt()).collect();
    let weigh = |values: &[f64]| -> Vec<f64> { values.iter().enumerate().map(|(i, v)| v * lengths[i / n]).collect() };
    distance(&weigh(&light.network), &weigh(&light.analytic))
}

/// Grey pixels: white where nothing is, one exposure for what is reflected.
fn tone(values: &[Option<f64>], reflected: &[f64]) -> Vec<[u8; 3]> {
    let all: Vec<[f32; 3]> = reflected.iter().map(|&v| [v as f32; 3]).collect();
    let tone = Tone::auto(&all);
    values.iter().map(|v| v.map_or([255; 3], |v| tone.map([v.max(0.0) as f32; 3]))).collect()
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
    let light = on_any(press, &geometry, &params, &places, options.points / 6, options.points / 24)?;

    let shown = |values: &[f64]| {
        let mut next = values[..pixels].iter();
        let own = |p: &Point| scene.materials[geometry.tris[p.tri as usize].material as usize].emission[0] * PI;
        let lit = |hit: &Option<Point>| hit.as_ref().and_then(|p| next.next().map(|v| own(p) + v));
        let values: Vec<Option<f64>> = hits.iter().map(lit).collect();
        tone(&values, &light.analytic[pixels..])
    };
    let (left, right) = (shown(&light.analytic), shown(&light.network));
    let mut figure = Figure::new("fig4bc", "Fig. 4b, c: one reflection in space, from the kernel and from a network of six dimensions");
    let drawn = draw(1260, 40 + 630 * 3 / 4, |page| {
        let (b, c) = page.split_horizontally(unit(630.0));
        picture(&titled(&b, "(b) the kernel")?, &left, camera.width, camera.height)?;
        picture(&titled(&c, &format!("(c) the network, {} cells", options.cells))?, &right, camera.width, camera.height)
    });
    figure.drawing(press, drawn)?;
    let [kernel, network] = [&light.analytic, &light.network].map(|v| &v[pixels..]);
    let rows = (0..FLOOR * FLOOR).map(|i| vec![middle(i % FLOOR), middle(i / FLOOR), kernel[i], network[i]]);
    figure.csv(press, ".csv", "x,z,kernel,network", rows)?;
    figure.about.push(format!(
        "A wall with a lit window, a floor, and a blocker between, after one reflection: (b) from the kernel itself, (c) from \
         the paper's network of it in six dimensions, the two places of a pair ({} cells, {} evaluations). Both pictures \
         have one exposure.",
        options.cells,
        options.cells * options.evaluations
    ));
    figure.about.push(format!(
        "The error is the relative L2 norm of the light that the floor reflects, over {FLOOR} x {FLOOR} places. The kernel's \
         light takes {0} x {0} points on each half of the window, the network's {1} x {1}.",
        options.points / 6,
        options.points / 24
    ));
    figure.number("error of the light on the floor", distance(network, kernel), "1");
    figure.number("light on the floor, network over kernel", network.iter().sum::<f64>() / kernel.iter().sum::<f64>(), "1");
    figure.number("kernel error, over all pairs of the scene", light.learned.error, "1");
    figure.number("energy that the clamp took", light.learned.clamped, "1");
    figure.finish(press)?;
    Ok(figure)
}
