use raycell::solution::*;
use raycell::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut params = Params::default();
    let mut scenes = vec![];
    for a in &args[1..] {
        if let Some((k, v)) = a.split_once('=') {
            match k {
                "rays" => params.rays = v.parse().unwrap(),
                "ref" => params.refinements = v.parse().unwrap(),
                "slots" => params.slots = v.parse().unwrap(),
                "seed" => params.seed = v.parse().unwrap(),
                "gather" => params.gather_rays = v.parse().unwrap(),
                "thr" => params.gather_threshold = v.parse().unwrap(),
                "cells" => params.cells = Some(v.parse().unwrap()),
                "nodes" => params.nodes = Some(v.parse().unwrap()),
                "direct" => params.direct = if v == "network" { Direct::Network } else { Direct::Exact },
                "tol" => params.direct_tolerance = v.parse().unwrap(),
                _ => panic!("{k}"),
            }
        } else {
            scenes.push(a.clone());
        }
    }
    for s in scenes {
        let t0 = std::time::Instant::now();
        let scene = Scene::load(format!("/work/shared/scenes/{s}/scene.obj")).unwrap();
        let text = std::fs::read_to_string(format!("/work/shared/scenes/{s}/truth.csv")).unwrap();
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let col = |n: &str| head.iter().position(|h| *h == n).unwrap();
        let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        let pts: Vec<SurfacePoint> = rows
            .iter()
            .map(|r| SurfacePoint {
                p: [r[col("px")], r[col("py")], r[col("pz")]],
                n: [r[col("nx")], r[col("ny")], r[col("nz")]],
            })
            .collect();
        let backend = if std::env::var("GPU").is_ok() {
            let o = raycell::gpu::device::open(raycell::gpu::device::BackendChoice::Auto, None).unwrap();
            Backend::Gpu(std::sync::Arc::new(raycell::gpu::Gpu::new(&o.device, &o.queue).unwrap()))
        } else {
            Backend::Cpu
        };
        let sol = bake(&backend, &scene, &params, &mut |_| progress::Flow::Continue).unwrap();
        let t1 = t0.elapsed().as_secs_f64();
        let ans = sol.query(&backend, &pts).unwrap();
        let t2 = t0.elapsed().as_secs_f64();
        let mut se = vec![];
        let mut rel = vec![];
        let (mut sb, mut st) = (0.0, 0.0);
        let mut off = 0;
        for (r, a) in rows.iter().zip(&ans) {
            let t = [r[col("B_r")], r[col("B_g")], r[col("B_b")]];
            if a.status == Status::OffSurface {
                off += 1;
            }
            let e: f64 = (0..3).map(|k| (a.b[k] - t[k]).powi(2)).sum();
            se.push((e, r[0], a.b, t, a.d, r[col("E_direct_r")], r[col("E_total_r")], a.h[0], r[col("flag")]));
            sb += a.b.iter().sum::<f64>();
            st += t.iter().sum::<f64>();
            if r[col("flag")] == 0.0 {
                rel.push((a.b.iter().sum::<f64>() - t.iter().sum::<f64>()).abs() / t.iter().sum::<f64>());
            }
        }
        let n = se.len() as f64;
        let mean = st / (3.0 * n);
        se.sort_by(|a, b| b.0.total_cmp(&a.0));
        let all: f64 = se.iter().map(|x| x.0).sum();
        let cut: f64 = se.iter().skip((n * 0.01).ceil() as usize).map(|x| x.0).sum();
        rel.sort_by(f64::total_cmp);
        let r = sol.report();
        println!(
            "{s}: RRMSE {:.4} cut1% {:.4} median {:.4} p90 {:.4} ratio {:.4} | bake {t1:.1}s query {:.1}s nodes {} cells {} sweeps {} drop {} imbalance {:.4} off {off}",
            (all / (3.0 * n)).sqrt() / mean,
            (cut / (3.0 * (n * 0.99))).sqrt() / mean,
            rel[rel.len() / 2],
            rel[rel.len() * 9 / 10],
            sb / st,
            t2 - t1,
            r.nodes,
            r.cells,
            r.solver.sweeps,
            r.extra["dropped_coefficient_mass"],
            r.energy.imbalance.unwrap_or(f64::NAN)
        );
        if std::env::var("V").is_ok() {
            println!("{:?}", r.extra);
            println!("{:?}", r.seconds);
            for x in se.iter().take(8) {
                println!(
                    "   {:.1}% id {} got {:.4?} want {:.4?} D {:.4} {:.4}  H {:.4} want {:.4} flag {}",
                    100.0 * x.0 / all,
                    x.1,
                    x.2,
                    x.3,
                    x.4[0],
                    x.5,
                    x.7,
                    x.6,
                    x.8
                );
            }
        }
    }
}
