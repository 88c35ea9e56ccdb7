//! What the test binaries share; each uses a part of it.
#![allow(dead_code, unused_imports)]

pub use raycell::accuracy::norms::rrmse;
use raycell::accuracy::truth::Flag;
use raycell::gpu::{Gpu, device};
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
    let truth = raycell::accuracy::truth::Truth::read(&root(&format!("tests/data/{scene}.truth.csv"))).unwrap();
    let good = truth.flags.iter().map(|f| *f == Flag::Good).collect();
    Truth { points: truth.points, b: truth.b, good }
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

/// A number of `tests/data/truths.json`.
pub fn known(id: &str) -> f64 {
    static TRUTHS: OnceLock<Vec<serde_json::Value>> = OnceLock::new();
    let truths = TRUTHS.get_or_init(|| {
        let text = std::fs::read_to_string(root("tests/data/truths.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    });
    let found = truths.iter().find(|t| t["id"] == id).unwrap_or_else(|| panic!("no truth {id}"));
    found["value"].as_f64().unwrap()
}

/// Why outputs cannot be: not finite, negative, or above max(e)/(1 - max(rho)) by more than a relative `error` (the maximum
/// principle). The rule that holds in every scene.
pub fn impossible(answers: &[Answer], scene: &Scene, error: f64) -> Option<String> {
    let most = |of: fn(&raycell::scene::Material) -> [f64; 3]| scene.materials.iter().flat_map(of).fold(0.0, f64::max);
    let bound = PI * most(|m| m.emission) / (1.0 - most(|m| m.reflectance));
    answers.iter().enumerate().find_map(|(i, a)| {
        let numbers = a.b.iter().chain(&a.h).chain(&a.d);
        let finite = numbers.clone().all(|x| x.is_finite());
        let possible = finite && numbers.clone().all(|&x| x >= 0.0) && a.b.iter().all(|&b| b <= bound * (1.0 + error));
        (!possible).then(|| format!("point {i}: {a:?}, and no radiosity is above {bound}"))
    })
}
