//! Solutions: cases E of `docs/hard_cases.md`.

use super::common::{gpu, impossible, known};
use raycell::scene::{Material, shapes};
use raycell::{Answer, Backend, Direct, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::f64::consts::PI;

/// A material of reflectance `rho` that shines with radiosity `e`, W/m².
fn grey(rho: f64, e: f64) -> Material {
    Material::new("grey", [rho; 3], [e / PI; 3])
}

/// The unit cube seen from inside, one material.
fn cube(material: Material) -> Scene {
    Scene::from_triangles("cube", &shapes::room([0.0; 3], [1.0; 3], [0; 6]), vec![material]).unwrap()
}

/// `n` points on each triangle, the first the middle; and what each stands for: an equal share of its triangle's area.
fn points(scene: &Scene, n: usize) -> Vec<(usize, SurfacePoint, f64)> {
    let mut out = Vec::new();
    for f in 0..scene.faces.len() {
        let [a, b, c] = scene.corners(f).map(glam::DVec3::from_array);
        let cross = (b - a).cross(c - a);
        for i in 0..n {
            // The R2 sequence, folded into the triangle.
            let (u, v) = ((0.25 + 0.754877666 * i as f64).fract(), (1.0 / 3.0 + 0.569840291 * i as f64).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p = a + (b - a) * u + (c - a) * v;
            out.push((f, SurfacePoint { p: p.to_array(), n: cross.normalize().to_array() }, 0.5 * cross.length() / n as f64));
        }
    }
    out
}

/// A bake on the device, or on the processor where there is none.
fn solved(scene: &Scene, params: &Params) -> (Backend, Solution) {
    let backend = gpu().map_or(Backend::Cpu, Backend::Gpu);
    let solution = bake(&backend, scene, params, &mut |_| Flow::Continue).unwrap();
    (backend, solution)
}

#[test]
fn e01_probe() {
    for direct in [Direct::Network, Direct::Exact] {
        for rho in [0.5, 0.9, 0.99, 0.999, 0.9999] {
            for rays in [65_536, 131_072, 524_288] {
                let scene = cube(grey(rho, 1.0));
                let gather_rays = if direct == Direct::Network { 0 } else { 1024 };
                let params = Params { direct, rays, gather_rays, ..Params::default() };
                let start = std::time::Instant::now();
                let (backend, solution) = solved(&scene, &params);
                let seconds = start.elapsed().as_secs_f64();
                let asked = points(&scene, 20);
                let places: Vec<SurfacePoint> = asked.iter().map(|p| p.1).collect();
                let answers = solution.query(&backend, &places).unwrap();
                let want = 1.0 / (1.0 - f64::from(rho as f32));
                let worst = answers.iter().map(|a| (a.b[0] / want - 1.0).abs()).fold(0.0, f64::max);
                let mean = answers.iter().map(|a| a.b[0] / want - 1.0).sum::<f64>() / answers.len() as f64;
                let r = solution.report();
                let s = &r.solver;
                eprintln!("{direct:?} {rho} {rays}: mean {mean:+.2e} worst {worst:.2e}, {seconds:.1} s; {} {} sweeps, residual {:.1e} bound {:.1e} factor {} {:?}",
                    s.method, s.sweeps, s.residual.unwrap(), s.error_bound.unwrap(), r.extra["contraction"], r.extra["stages"]);
            }
        }
    }
}
