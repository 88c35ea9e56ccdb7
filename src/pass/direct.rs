//! Pass `direct`: irradiance straight from emitters. Twin: [`crate::twin::direct`].

use super::{SceneBuffers, params};
use crate::error::Result;
use crate::gpu::{Access, Gpu, GpuVec, HEAVY, Kernel};
use crate::layout::{DirectSum, Point};
use crate::twin::direct::Samples;

/// Rays that an invocation may shoot in a dispatch, unless a single round takes more.
const RAYS: u32 = 16;
/// Lights that cost as much as a ray.
const LIGHTS_A_RAY: u32 = 64;

params!(
    /// Parameters of `wgsl/direct.wgsl`.
    {
        /// Place of the finished flag.
        flag: u32,
        /// Seed; each point has a sequence of its own.
        seed: u32,
        /// First round.
        first: u32,
        /// Rounds in this dispatch.
        rounds: u32,
        /// Samples of the emitters' area a round.
        emitter: u32,
        /// Cosine directions a round.
        cosine: u32,
        /// Number of emitters; where there are none, rounds are only counted.
        emitters: u32,
        /// Sampling density of an emitter per unit of its summed emission.
        emitter_density: f32,
        /// Padding.
        pad0: u32,
        /// Padding.
        pad1: u32,
    }
);

pub(super) const KERNEL: Kernel = Kernel::new(
    "direct",
    &[
        Access::Scene,
        Access::Scene,
        Access::Read,
        Access::Read,
        Access::Read,
        Access::Read,
        Access::Write,
        Access::Write,
        Access::Texels,
        Access::Texels,
        Access::Texels,
    ],
);

/// Adds rounds `first..first + rounds` to the sums of the points listed in `active`.
pub fn direct(
    gpu: &Gpu,
    scene: &SceneBuffers,
    points: &GpuVec<Point>,
    active: &GpuVec<u32>,
    seed: u32,
    first: u32,
    rounds: u32,
    samples: Samples,
    sums: &GpuVec<DirectSum>,
) -> Result<()> {
    let (emitter, cosine) = (samples.emitter, samples.cosine);
    let more = scene.sources.rays(samples);
    let more = (more.sky + more.lights) as u32 + scene.sources.lights() / LIGHTS_A_RAY;
    let rays = (emitter + cosine + more).max(1);
    let [sky, lights] = scene.surfaceless.bound();
    let buffers = [
        scene.nodes.bound(),
        scene.tris.bound(),
        scene.materials.bound(),
        scene.emitters.bound(),
        points.bound(),
        active.bound(),
        sums.bound(),
        gpu.status().into(),
        sky,
        lights,
        scene.texels(),
    ];
    // As many rounds a dispatch as keep an invocation short.
    let mut done = 0;
    while done < rounds {
        let now = (RAYS / rays).max(1).min(rounds - done);
        let params = Params {
            flag: gpu.flag(&KERNEL),
            seed,
            first: first + done,
            rounds: now,
            emitter,
            cosine,
            emitters: scene.emitters.len() as u32,
            emitter_density: scene.emitter_density,
            ..Params::default()
        };
        gpu.run(&scene.kernel(KERNEL), &params, &buffers, active.len(), HEAVY / (rays * now))?;
        done += now;
    }
    Ok(())
}
