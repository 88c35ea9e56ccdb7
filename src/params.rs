//! Every tuning number of a bake: unit, range, default, what it costs, where it comes from.

mod paper;

use crate::error::{Error, Result};
pub use paper::{Fit, Form, Output, PaperParams};
use serde::{Deserialize, Serialize};

/// How light that comes straight from emitters is carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direct {
    /// Sampled exactly at every point, by multiple importance sampling; the network carries the rest.
    #[default]
    Exact,
    /// Through the network like all other light (the paper's idea): no shadow rays, soft shadow edges.
    Network,
}

/// What the network learns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The flow of light: cells are bundles of light rays.
    #[default]
    Flux,
    /// The kernel itself, as the seed paper does (Bohn 1997): to reproduce it and to measure it.
    Paper,
}

impl Mode {
    fn is_flux(&self) -> bool {
        *self == Mode::Flux
    }
}

/// How light is carried between surfaces: the network, or a classical method to hold it against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The neural mesh of light rays.
    #[default]
    Network,
    /// Finite elements: uniform patches, a form factor for each pair of them (Goral et al. 1984).
    Fem,
    /// Links between patches of a hierarchy, as coarse as the light they carry allows (Hanrahan et al. 1991).
    Hierarchical,
    /// Every light ray its own coefficient: the network's rays and nodes without its cells.
    Rays,
}

/// How the linear system is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// Jacobi sweeps, on the device where the method has them there. The network's are accelerated (GMRES, with residuals
    /// in f64) where more than 0.8 of the light is left of each.
    #[default]
    Jacobi,
    /// Gauss-Seidel sweeps on the host: fewer, one after the other.
    GaussSeidel,
}

/// Where the network's cells come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cells {
    /// Grown and trained on the rays.
    #[default]
    Trained,
    /// Rays drawn at random: what growth is held against.
    Random,
}

/// How flatland's kernel is normalised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Norm {
    /// cos cos / (2 r): what a diffuse line sends out arrives.
    #[default]
    Lambert,
    /// cos cos / (2 pi r), as printed in Bohn's paper of 1997: of all light 1/pi arrives, the rest is lost. In three
    /// dimensions the paper's kernel has the right norm, and this one is refused.
    Paper1997,
}

impl Norm {
    /// Share of the light that arrives.
    pub fn share(self) -> f64 {
        match self {
            Norm::Lambert => 1.0,
            Norm::Paper1997 => std::f64::consts::FRAC_1_PI,
        }
    }

    fn is_lambert(&self) -> bool {
        *self == Norm::Lambert
    }
}

/// Nodes per square root of rays: where nodes carry gradients, more only add noise.
const NODES_PER_ROOT: f64 = 1.4;
/// The same in flatland.
const FLAT_NODES_PER_ROOT: f64 = 0.6;
/// The same in paper mode, whose nodes carry values alone, for each kernel evaluation.
const PAPER_NODES_PER_ROOT: f64 = 2.0;
/// Rays of the first rung of the ladder of sizes.
const FIRST_RUNG: u32 = 4_096;
/// Planar pieces beyond which each gets a node.
const PIECES: u32 = 200;

/// [`Params::gather_threshold`] at which every point with anything near it gets a final gather.
pub const EVERYWHERE: f64 = 1e9;

/// Parameters of a bake. [`Params::default`] serves every scene; `check` refuses what makes no sense.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Params {
    /// Seed of every random sequence. Same seed, same device, same bytes.
    pub seed: u32,
    /// Light rays of the full network, 1,024 to 2^24; default 524,288. Error falls about as n^-0.3,
    /// time grows linearly.
    pub rays: u32,
    /// Cells (reference rays) of the network, 16 to 100,000; default `rays/512`, where the
    /// refinements take their error out of the result; `rays/128` with `--direct network`.
    pub cells: Option<u32>,
    /// Nodes of the surface network before those for orphans; default `1.4 sqrt(rays)` (`0.6 sqrt(rays)` in
    /// flatland), plus one for each planar piece where there are more than 200, at most twice as many.
    pub nodes: Option<u32>,
    /// How direct light is carried.
    pub direct: Direct,
    /// How flatland's kernel is normalised.
    #[serde(default, skip_serializing_if = "Norm::is_lambert")]
    pub norm: Norm,
    /// Share alpha of starts drawn where light is expected, in [0, 0.95]; the rest covers the area uniformly. Default 0.7.
    pub alpha: f64,
    /// Exponent gamma of the light that starts are drawn by, in [0, 1]; default 0.7 (`--direct network`
    /// always uses 1). Lower values serve dark parts at the cost of bright ones.
    pub gamma: f64,
    /// Weight lambda of normals in the metrics, in [0, 1]; default 0.3 (a length in units of L).
    pub lambda: f64,
    /// Weight mu of the emitter end's brightness in the ray metric, in [0, 2]; default 0.3.
    pub mu: f64,
    /// Ridge of the nodes' least-squares planes, in (0, 1]; default 0.05.
    pub ridge: f64,
    /// Gather and deposit slots kept a cell, 4 to 128; default 32. Below 16 the accuracy is destroyed.
    pub slots: u32,
    /// Shadow rays to emitters at each ray end (and one cosine ray beside them), 1 to 64; default 2.
    pub end_samples: u32,
    /// Relative standard error at which direct light at a shown point is taken for known, in [1e-4, 1]; default 0.004.
    pub direct_tolerance: f64,
    /// Most direct samples at a shown point, 16 to 65,536; default 8,192.
    pub direct_samples: u32,
    /// Rays of a final gather, 0 (never gather) to 65,536; default 1,024. Where they bring very different light, up to four times as many.
    pub gather_rays: u32,
    /// Gather where the harmonic mean hit distance is under this many node spacings, >= 0; default 2; and where nodes disagree.
    /// Contacts and slots need 0.6; more buys accuracy everywhere for time at each shown point; [`EVERYWHERE`] is all of them.
    pub gather_threshold: f64,
    /// Times the rays themselves carry the solution once more, 0 to 16; default 2. Takes the cells' error out
    /// of the result (`--direct exact` only), for a pass over the rays.
    pub refinements: u32,
    /// Relative error at which the solver stops, measured against the true fixed point, in [1e-9, 0.1]; default 1e-5.
    pub tolerance: f64,
    /// Most sweeps of the solver, 1 to 1,000,000; default 20,000.
    pub max_sweeps: u32,
    /// What the network learns.
    #[serde(default, skip_serializing_if = "Mode::is_flux")]
    pub mode: Mode,
    /// What [`Mode::Paper`] goes by.
    #[serde(default, skip_serializing_if = "PaperParams::is_default")]
    pub paper: PaperParams,
    /// What carries the light.
    #[serde(default)]
    pub method: Method,
    /// Patches of the `fem` method, and of the `hierarchical` one before it refines, 4 to 32,768; default 1,600.
    /// Form factors, and the time they take, grow with the square.
    #[serde(default = "patches")]
    pub patches: u32,
    /// How the linear system is solved.
    #[serde(default)]
    pub solver: Solver,
    /// Reflections that are counted, 1 to 100,000: the Neumann series of the light broken off there. `None`, the
    /// default: all of them. Points are then shown without final gathers, which would add a reflection.
    #[serde(default)]
    pub bounces: Option<u32>,
    /// Where the network's cells come from.
    #[serde(default)]
    pub cells_from: Cells,
}

fn patches() -> u32 {
    Params::default().patches
}

impl Default for Params {
    fn default() -> Self {
        Params {
            seed: 1,
            rays: 524_288,
            cells: None,
            nodes: None,
            direct: Direct::Exact,
            norm: Norm::Lambert,
            alpha: 0.7,
            gamma: 0.7,
            lambda: 0.3,
            mu: 0.3,
            ridge: 0.05,
            slots: 32,
            end_samples: 2,
            direct_tolerance: 0.004,
            direct_samples: 8_192,
            gather_rays: 1_024,
            gather_threshold: 2.0,
            refinements: 2,
            tolerance: 1e-5,
            max_sweeps: 20_000,
            mode: Mode::Flux,
            paper: PaperParams::default(),
            method: Method::Network,
            patches: 1_600,
            solver: Solver::Jacobi,
            bounces: None,
            cells_from: Cells::Trained,
        }
    }
}

/// Refuses a value outside `low..=high`.
fn within<T: PartialOrd + std::fmt::Display>(name: &'static str, value: T, low: T, high: T, range: &'static str) -> Result<()> {
    // A NaN compares false, and is refused with the rest.
    if value >= low && value <= high { Ok(()) } else { Err(Error::InvalidParam { name, value: value.to_string(), range }) }
}

impl Params {
    /// Checks every range. Errors: [`Error::InvalidParam`].
    pub fn check(&self) -> Result<()> {
        within("rays", self.rays, 1024, 1 << 24, "give 1024 to 16777216 rays")?;
        within("cells", self.cells(), 16, 100_000, "give 16 to 100000 cells")?;
        if let Some(n) = self.nodes {
            within("nodes", n, 4, 1_000_000, "give 4 to 1000000 nodes")?;
        }
        within("alpha", self.alpha, 0.0, 0.95, "give 0 to 0.95")?;
        within("gamma", self.gamma, 0.0, 1.0, "give 0 to 1")?;
        within("lambda", self.lambda, 0.0, 1.0, "give 0 to 1")?;
        within("mu", self.mu, 0.0, 2.0, "give 0 to 2")?;
        within("ridge", self.ridge, 1e-9, 1.0, "give 1e-9 to 1")?;
        within("slots", self.slots, 4, 128, "give 4 to 128 slots")?;
        within("end_samples", self.end_samples, 1, 64, "give 1 to 64 samples")?;
        within("direct_tolerance", self.direct_tolerance, 1e-4, 1.0, "give 1e-4 to 1")?;
        within("direct_samples", self.direct_samples, 16, 65_536, "give 16 to 65536 samples")?;
        within("gather_rays", self.gather_rays, 0, 65_536, "give 0 to 65536 rays")?;
        within("gather_threshold", self.gather_threshold, 0.0, 1e9, "give a number of node spacings, 0 or more")?;
        within("refinements", self.refinements, 0, 16, "give 0 to 16 refinements")?;
        within("tolerance", self.tolerance, 1e-9, 0.1, "give 1e-9 to 0.1")?;
        within("max_sweeps", self.max_sweeps, 1, 1_000_000, "give 1 to 1000000 sweeps")?;
        within("patches", self.patches, 4, 32_768, "give 4 to 32768 patches")?;
        if matches!(self.method, Method::Rays | Method::Hierarchical) && self.solver != Solver::Jacobi {
            let range = "rays and links carry all light at once; leave --solver out, or use --method network or fem";
            return Err(Error::InvalidParam { name: "solver", value: "gauss-seidel".into(), range });
        }
        if let Some(n) = self.bounces {
            within("bounces", n, 1, 100_000, "give 1 to 100000 reflections")?;
            if self.solver != Solver::Jacobi {
                let range = "the series of reflections is what Jacobi's sweeps are; leave --solver or --bounces out";
                return Err(Error::InvalidParam { name: "solver", value: "gauss-seidel".into(), range });
            }
        }
        if self.mode == Mode::Paper && self.method != Method::Network {
            let range = "the paper's method is a network; leave --method or --mode out";
            return Err(Error::InvalidParam { name: "mode", value: "paper".into(), range });
        }
        self.paper.check()
    }

    /// The last rung of the ladder of sizes, 2^24 rays.
    pub const LAST_RUNG: u32 = 12;

    /// Rays of a rung of the ladder of sizes.
    pub fn rays_of(rung: u32) -> u32 {
        FIRST_RUNG << rung.min(Self::LAST_RUNG)
    }

    /// These parameters on a rung of the ladder of sizes, 0 to [`Params::LAST_RUNG`]: twice the rays of the one before,
    /// cells and nodes as fit them, and a read-out that scatters as much less as rays do. Methods with patches have
    /// as many as give coefficients in proportion. [`Params::default`] is rung 7 of itself.
    pub fn rung(&self, rung: u32) -> Params {
        let usual = Params::default();
        let rays = Self::rays_of(rung);
        let size = f64::from(rays) / f64::from(usual.rays);
        let times = |x: u32, size: f64| (f64::from(x) * size) as u32;
        let gathers = 1 << times(usual.gather_rays, size.sqrt()).clamp(64, 4_096).ilog2();
        let near = if self.gather_threshold == usual.gather_threshold { size.powf(0.25).min(1.0) } else { 1.0 };
        Params {
            rays,
            cells: if self.mode == Mode::Paper { Some((rays / 32).clamp(16, 100_000)) } else { self.cells },
            direct_tolerance: (usual.direct_tolerance / size.sqrt()).clamp(0.001, 0.03),
            direct_samples: times(usual.direct_samples, size).clamp(256, 65_536),
            gather_rays: if self.gather_rays > 0 { gathers } else { 0 },
            gather_threshold: self.gather_threshold * near,
            patches: ((f64::from(usual.patches) * size.sqrt()) as u32).clamp(4, 32_768),
            ..self.clone()
        }
    }

    /// Nodes asked for, or the default for the number of rays in a scene of `pieces` planar pieces.
    pub fn node_count(&self, pieces: u32, flatland: bool) -> usize {
        if self.mode == Mode::Paper {
            let base = PAPER_NODES_PER_ROOT * (self.paper.evaluations(self.cells()) as f64).sqrt();
            return self.nodes.map_or(base as usize, |n| n as usize);
        }
        let per_root = if flatland { FLAT_NODES_PER_ROOT } else { NODES_PER_ROOT };
        let base = (per_root * (self.rays as f64).sqrt()) as usize;
        // A curved mesh has as many pieces as triangles: they may double the nodes at most.
        let more = if pieces > PIECES { (pieces as usize).min(base) } else { 0 };
        self.nodes.map_or(base + more, |n| n as usize)
    }

    /// Cells asked for, or the default for the number of rays; in paper mode 1,024.
    pub fn cells(&self) -> u32 {
        if self.mode == Mode::Paper {
            return self.cells.unwrap_or(1_024);
        }
        let share = if self.direct == Direct::Exact { 512 } else { 128 };
        self.cells.unwrap_or((self.rays / share).clamp(16, 100_000))
    }
}
