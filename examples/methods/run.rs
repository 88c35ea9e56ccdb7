//! One bake of one method, and what it costs.

use raycell::accuracy::norms::rrmse;
use raycell::accuracy::truth::Truth;
use raycell::radiosity::patches::{Mesh, display};
use raycell::twin::trace::{barycentric, surface_point};
use raycell::{Answer, Backend, Flow, Method, Params, Result, Scene, Status, SurfacePoint, bake};
use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

/// A scene with its truth.
pub struct Case {
    pub name: String,
    pub scene: Scene,
    pub points: Vec<SurfacePoint>,
    /// Radiosity, W/m² a band.
    pub truth: Vec<[f64; 3]>,
}

impl Case {
    /// A shipped scene and its truth in tests/data.
    pub fn shipped(name: &str) -> Result<Case> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let scene = match name.strip_prefix("flatland_") {
            Some(flat) => format!("scenes/flatland/{flat}.toml"),
            None => format!("scenes/{name}/scene.obj"),
        };
        Case::new(name, &root.join(scene), &root.join(format!("tests/data/{name}.truth.csv")))
    }

    /// A scene, and a CSV with px,py,pz,nx,ny,nz,B_r,B_g,B_b first.
    pub fn new(name: &str, scene: &Path, truth: &Path) -> Result<Case> {
        let Truth { points, b, .. } = Truth::read(truth)?;
        Ok(Case { name: name.into(), scene: Scene::load(scene)?, points, truth: b })
    }
}

/// What a bake gave and took.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// sqrt(mean (B - B*)^2)/mean(B*) over points and bands, by the read-out all methods share.
    pub error: f64,
    /// The same by the textbooks' read-outs of patches, constant and linear; methods with patches only.
    pub patches: Option<[f64; 2]>,
    /// Coefficients stored.
    pub coefficients: f64,
    /// Kernel evaluations, or rays: whichever the method goes by.
    pub evaluations: f64,
    pub cells: f64,
    pub nodes: f64,
    pub sweeps: f64,
    /// Seconds of the bake, without the read-out.
    pub seconds: f64,
    pub imbalance: f64,
}

/// Bakes and asks at the truth's points.
pub fn run(backend: &Backend, case: &Case, params: &Params) -> Result<Run> {
    let start = Instant::now();
    let solution = bake(backend, &case.scene, params, &mut |_| Flow::Continue)?;
    let seconds = start.elapsed().as_secs_f64();
    let answers = solution.query(backend, &case.points)?;
    let report = solution.report();
    let patches = (params.method == Method::Fem).then(|| {
        let geometry = solution.geometry();
        let mesh = Mesh::new(geometry, params.patches);
        let read = |at: &dyn Fn(&raycell::layout::Point) -> glam::Vec3| {
            let b = (case.points.iter().zip(&answers)).map(|(p, a): (_, &Answer)| {
                // What is covered is black by any read-out.
                let found = geometry.locate(p.p, p.n).filter(|_| a.status == Status::Ok);
                let Some(found) = found else { return a.b };
                let (b1, b2) = barycentric(geometry.flatland, &geometry.tris[found.tri as usize], found.p.into());
                let h = at(&surface_point(geometry, found.tri, b1, b2));
                let m = &case.scene.materials[geometry.tris[found.tri as usize].material as usize];
                [0, 1, 2].map(|k| {
                    let h = a.d[k] + h[k] as f64 / geometry.emission_scale;
                    PI * m.emission[k] + m.reflectance[k] * h
                })
            });
            rrmse(&b.collect::<Vec<_>>(), &case.truth)
        };
        [
            read(&|p| display::constant(&mesh, solution.light(), p)),
            read(&|p| display::linear(&mesh, solution.nodes(), solution.light(), p)),
        ]
    });
    Ok(Run {
        error: rrmse(&answers.iter().map(|a| a.b).collect::<Vec<_>>(), &case.truth),
        patches,
        coefficients: report.coefficients as f64,
        evaluations: report.rays.max(report.kernel_evaluations) as f64,
        cells: report.cells as f64,
        nodes: report.nodes as f64,
        sweeps: report.solver.sweeps as f64,
        seconds,
        imbalance: report.energy.imbalance.unwrap_or(f64::NAN),
    })
}

/// Mean and standard deviation.
pub fn spread(x: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = x.clone().count().max(1) as f64;
    let mean = x.clone().sum::<f64>() / n;
    let variance = x.map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    (mean, variance.sqrt())
}
