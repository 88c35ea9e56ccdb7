//! What the test binaries share; each uses a part of it.
#![allow(dead_code)]

use raycell::gpu::{Gpu, device};
use raycell::output::points;
use raycell::scene::Geometry;
use raycell::{Answer, Scene, SurfacePoint};
use std::f64::consts::PI;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// A device, or a note that there is none: tests then pass, unless `RAYCELL_REQUIRE_GPU` is set.
pub fn open() -> Option<Gpu> {
    match device::open(device::BackendChoice::Auto, None) {
        Ok(open) => {
            eprintln!("on {} ({:?}, {} {})", open.info.name, open.info.backend, open.info.driver, open.info.driver_info);
            Some(Gpu::new(&open.device, &open.queue).unwrap())
        }
        Err(e) => {
            assert!(std::env::var_os("RAYCELL_REQUIRE_GPU").is_none(), "{e}");
            eprintln!("skipped: {e}");
            None
        }
    }
}

/// As [`open`], one for all tests of a binary.
pub fn gpu() -> Option<Arc<Gpu>> {
    static GPU: OnceLock<Option<Arc<Gpu>>> = OnceLock::new();
    GPU.get_or_init(|| open().map(Arc::new)).clone()
}

/// A path from the project's root.
pub fn root(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A shipped scene's truth: points, their radiosity, and whether each is good (flag 0).
pub struct Truth {
    pub points: Vec<SurfacePoint>,
    pub b: Vec<[f64; 3]>,
    pub good: Vec<bool>,
}

/// The truth in `tests/data`.
pub fn truth(scene: &str) -> Truth {
    let path = root(&format!("tests/data/{scene}.truth.csv"));
    let (mut b, mut good) = (Vec::new(), Vec::new());
    for row in std::fs::read_to_string(&path).unwrap().lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        b.push([6, 7, 8].map(|k| cells[k].parse().unwrap()));
        good.push(cells[12] == "0");
    }
    Truth { points: points::read(&path).unwrap(), b, good }
}

/// What a scene emits at points on it: radiosity, W/m² a band.
pub fn emitted(scene: &Scene, points: &[SurfacePoint]) -> Vec<[f64; 3]> {
    let geometry = Geometry::new(scene).unwrap();
    let emission = |p: &SurfacePoint| {
        let at = geometry.locate(p.p, p.n).expect("a point of the truth lies on the scene");
        scene.materials[geometry.tris[at.tri as usize].material as usize].emission.map(|x| PI * x)
    };
    points.iter().map(emission).collect()
}

pub fn radiosity(answers: &[Answer]) -> Vec<[f64; 3]> {
    answers.iter().map(|a| a.b).collect()
}

/// sqrt(mean (B - B*)^2)/mean(B*) over points and bands, without the `drop` worst points.
pub fn rrmse_without(b: &[[f64; 3]], truth: &[[f64; 3]], drop: usize) -> f64 {
    let mut order: Vec<(f64, usize)> = (0..b.len()).map(|i| ((0..3).map(|k| (b[i][k] - truth[i][k]).powi(2)).sum(), i)).collect();
    order.sort_by(|x, y| x.0.total_cmp(&y.0));
    order.truncate(b.len() - drop);
    let n = 3.0 * order.len() as f64;
    let level = order.iter().map(|&(_, i)| truth[i].iter().sum::<f64>()).sum::<f64>() / n;
    (order.iter().map(|o| o.0).sum::<f64>() / n).sqrt() / level
}

/// As [`rrmse_without`], over all points.
pub fn rrmse(b: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    rrmse_without(b, truth, 0)
}
