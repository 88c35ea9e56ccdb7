//! The network beside the classical methods: error against coefficients, kernel evaluations, rays and time.
//!
//! `cargo run --release --example methods -- SCENE TRUTH.csv METHOD SIZE,SIZE,... [key=value ...]`
//!
//! METHOD: network, network0 (no refinements), random0 (random rays as cells), fem, hierarchical, rays. SIZE: patches
//! of fem and hierarchical, rays of the others. Keys: seeds, cells, direct (exact or network), backend (gpu or cpu),
//! gather (rays of the final gather, default 0), and any parameter of `Params` as JSON.

use raycell::gpu::{Gpu, device};
use raycell::output::points;
use raycell::radiosity::{display, patches::Mesh};
use raycell::twin::trace::{barycentric, surface_point};
use raycell::{Backend, Flow, Method, Params, Scene, SurfacePoint, bake};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// sqrt(mean (B - B*)^2)/mean(B*) over points and bands.
fn rrmse(b: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    let square: f64 = b.iter().flatten().zip(truth.iter().flatten()).map(|(b, t)| (b - t).powi(2)).sum();
    let n = 3.0 * b.len() as f64;
    (square / n).sqrt() / (truth.iter().flatten().sum::<f64>() / n)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, truth, method, sizes, keys @ ..] = &args[..] else {
        return Err("SCENE TRUTH.csv METHOD SIZE,SIZE,... [key=value ...]".into());
    };
    let key = |name: &str| keys.iter().find_map(|k| k.strip_prefix(name)?.strip_prefix('='));
    let backend = match key("backend") {
        Some("cpu") => Backend::Cpu,
        _ => {
            let open = device::open(device::BackendChoice::Auto, None)?;
            Backend::Gpu(Arc::new(Gpu::new(&open.device, &open.queue)?))
        }
    };
    let scene = Scene::load(scene)?;
    let at: Vec<SurfacePoint> = points::read(Path::new(truth))?;
    let text = std::fs::read_to_string(truth)?;
    let columns = |row: &str| row.split(',').skip(6).take(3).map(|x| x.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    let truth: Vec<[f64; 3]> = text.lines().skip(1).map(|row| columns(row).try_into().unwrap_or([f64::NAN; 3])).collect();

    println!("method size seed | coefficients evaluations rays cells nodes sweeps seconds | RRMSE nodes, constant, linear");
    for size in sizes.split(',') {
        let size: u32 = size.parse()?;
        for seed in 1..=key("seeds").map_or(Ok(1), str::parse)? {
            let mut params = Params { seed, gather_rays: key("gather").map_or(Ok(0), str::parse)?, ..Params::default() };
            params.method = match method.as_str() {
                "fem" => Method::Fem,
                "hierarchical" => Method::Hierarchical,
                "rays" => Method::Rays,
                _ => Method::Network,
            };
            if matches!(params.method, Method::Fem | Method::Hierarchical) {
                params.patches = size;
            } else {
                params.rays = size;
            }
            if method.ends_with('0') {
                params.refinements = 0;
            }
            if method.starts_with("random") {
                params.cells_from = raycell::Cells::Random;
            }
            let mut json = serde_json::to_value(&params)?;
            for (name, value) in keys.iter().filter_map(|k| k.split_once('=')) {
                if json.get(name).is_some() {
                    json[name] = serde_json::from_str(value).unwrap_or(value.into());
                }
            }
            let params: Params = serde_json::from_value(json)?;
            let start = Instant::now();
            let solution = bake(&backend, &scene, &params, &mut |_| Flow::Continue)?;
            let seconds = start.elapsed().as_secs_f64();
            let answers = solution.query(&backend, &at)?;
            let b: Vec<[f64; 3]> = answers.iter().map(|a| a.b).collect();
            let r = solution.report();
            print!(
                "{method} {size} {seed} | {} {} {} {} {} {} {seconds:.1} | {:.5}",
                r.coefficients,
                r.kernel_evaluations,
                r.rays,
                r.cells,
                r.nodes,
                r.solver.sweeps,
                rrmse(&b, &truth)
            );
            if params.method == Method::Fem {
                let geometry = solution.geometry();
                let mesh = Mesh::new(geometry, params.patches);
                let read = |f: &dyn Fn(&raycell::layout::Point) -> glam::Vec3| {
                    let b: Vec<[f64; 3]> = (at.iter().zip(&answers))
                        .map(|(p, a)| {
                            // What is covered is black by any read-out.
                            let found = geometry.locate(p.p, p.n).filter(|_| a.status == raycell::Status::Ok);
                            let Some(found) = found else { return a.b };
                            let (b1, b2) = barycentric(geometry.flatland, &geometry.tris[found.tri as usize], found.p.into());
                            let h = f(&surface_point(geometry, found.tri, b1, b2));
                            let m = &scene.materials[geometry.tris[found.tri as usize].material as usize];
                            [0, 1, 2].map(|k| {
                                let h = a.d[k] + h[k] as f64 / geometry.emission_scale;
                                PI * m.emission[k] + m.reflectance[k] * h
                            })
                        })
                        .collect();
                    rrmse(&b, &truth)
                };
                print!(", {:.5}", read(&|p| display::constant(&mesh, solution.light(), p)));
                print!(", {:.5}", read(&|p| display::linear(&mesh, solution.nodes(), solution.light(), p)));
            }
            println!("; energy {:+.4}", r.energy.imbalance.unwrap_or(f64::NAN));
        }
    }
    Ok(())
}
