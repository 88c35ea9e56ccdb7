//! The account of energy: where every emitted watt went.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, NONE, NodeLight, Point, kind};
use crate::network::tiles::{distribution, drawn, mean};
use crate::output::report::Energy;
use crate::params::{Direct, Params};
use crate::progress::Progress;
use crate::scene::Geometry;
use crate::stream::{Stream, stream};
use crate::twin::direct::Samples;
use crate::twin::lights;
use crate::twin::math::seed_of;
use crate::twin::way;
use glam::Vec3;
use rayon::prelude::*;

/// Most rays from emitters.
const EMISSION_RAYS: u32 = 65_536;
/// Those for each ray of the bake, where that is fewer.
const SHARE: u32 = 4;
/// Most points that lights and sky are looked at from.
const LOOKS: u32 = 32_768;
/// Samples at each of them.
const LOOK: Samples = Samples { emitter: 3, cosine: 1 };

/// What the emitters send in all, scaled, over local areas.
pub fn emitted(geometry: &Geometry) -> [f64; 3] {
    let mut emitted = [0.0; 3];
    for e in &geometry.emitters {
        let emit = geometry.mean_emission(e.tri as usize);
        for k in 0..3 {
            emitted[k] += emit[k] * geometry.areas[e.tri as usize];
        }
    }
    emitted
}

/// A scaled power over local areas as watts.
pub fn watts(geometry: &Geometry, power: [f64; 3]) -> [f64; 3] {
    let area_scale = if geometry.flatland { geometry.scale } else { geometry.scale * geometry.scale };
    let per_area = 1.0 / (geometry.emission_scale * area_scale);
    power.map(|v| v * per_area)
}

/// Follows every watt: light from emitters by rays of their own, reflected light by the network's rays.
///
/// emitted = absorbed + escaped holds only if D, H and the rays agree, so the imbalance is a check. Of lights without a
/// surface, and of the sky, what arrives on front faces that are no mirrors counts as emitted; where the rest goes is no matter of the scene.
/// Back faces and black surfaces absorb what meets them, mirrors and the medium what they take on the way: both are counted
/// among what is absorbed, and by themselves.
pub fn account<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    seed: u32,
    params: &Params,
    light: &[NodeLight],
    batches: &mut [E::Batch],
    progress: &mut Progress,
) -> Result<Energy> {
    let mut emitted = emitted(geometry);
    let all = mean(&emitted);
    let (mut absorbed, mut escaped) = ([0.0; 3], [0.0; 3]);
    if geometry.is_surfaceless() {
        let [arrived, kept] = surfaceless(geometry, stream(seed, Stream::PointDirect), params.rays);
        for k in 0..3 {
            emitted[k] += arrived[k];
            absorbed[k] += kept[k];
        }
    }
    if emitted == [0.0; 3] {
        let none = Some([0.0; 3]);
        return Ok(Energy { emitted: none, absorbed: none, escaped: none, imbalance: Some(0.0), ..Energy::default() });
    }
    let (mut mirrors, mut medium, mut lost) = ([0.0; 3], [0.0; 3], 0.0);
    let lossy = geometry.is_lossy();
    let mut follow = |points: &[Point], sent: &dyn Fn(usize) -> [f64; 3]| {
        for d in 0..points.len() {
            let y = &points[d];
            // One-way rays are stored at their start, so their receiver is the odd end.
            let one_way = y.kind == kind::SKY || y.kind == kind::BACK || y.kind == kind::LOST;
            let x = d ^ 1;
            let (start, end) = (&points[d & !1], &points[d | 1]);
            let mut w = if one_way { points[x].weight } else { y.weight } as f64;
            if w <= 0.0 || (one_way && d % 2 == 0) {
                continue;
            }
            let s = sent(x);
            if lossy {
                // What is lost on the way, and the rest that arrives.
                let on_mirrors = w * f64::from(start.density);
                let in_medium = w - w * f64::from(end.density) - on_mirrors;
                for k in 0..3 {
                    mirrors[k] += on_mirrors * s[k];
                    medium[k] += in_medium * s[k];
                    lost += if y.kind == kind::LOST { w * s[k] } else { 0.0 };
                }
                w *= f64::from(end.density);
            }
            for k in 0..3 {
                match y.kind {
                    kind::SKY => escaped[k] += w * s[k],
                    kind::BACK | kind::LOST => absorbed[k] += w * s[k],
                    _ => absorbed[k] += w * s[k] * (1.0 - geometry.material_at(y).rho[k] as f64),
                }
            }
        }
    };

    // Light from emitters.
    if all > 0.0 {
        let mut shine = vec![0.0; geometry.tiles as usize];
        for t in 0..shine.len() {
            shine[t] = mean(&geometry.mean_emission(geometry.tile_tri[t] as usize)) / all;
        }
        let rays = EMISSION_RAYS.min(SHARE * params.rays);
        let batch = engine.emit(&distribution(geometry, &shine), seed, 0, rays, rays)?;
        let points = engine.points(&batch)?;
        let sent = |x: usize| match points[x].tri {
            NONE => [0.0; 3],
            _ => geometry.material_at(&points[x]).emit.map(f64::from),
        };
        follow(&points, &sent);
    }

    // Reflected light.
    let exact = params.direct == Direct::Exact;
    engine.set_light(light)?;
    for batch in batches {
        engine.readout(batch)?;
        let (points, h) = (engine.points(batch)?, engine.irradiance(batch)?);
        let direct = if exact { engine.direct_sums(batch)? } else { Vec::new() };
        follow(&points, &|x| {
            if points[x].tri == NONE {
                return [0.0; 3];
            }
            let rho = geometry.material_at(&points[x]).rho;
            let d = direct.get(x).map_or([0.0; 3], DirectSum::mean);
            [0, 1, 2].map(|k| rho[k] as f64 * (h[x][k] + d[k]) as f64)
        });
        progress.tick()?;
    }
    for k in 0..3 {
        absorbed[k] += mirrors[k] + medium[k];
    }
    let imbalance = (0..3).map(|k| emitted[k] - absorbed[k] - escaped[k]).sum::<f64>() / emitted.iter().sum::<f64>();
    let watts = |x: [f64; 3]| Some(watts(geometry, x));
    // Of a ray that was given up no more was left than this.
    let best = geometry.tris.iter().map(|t| f64::from(t.mirror())).fold(0.0, f64::max);
    let left = best.powi(way::MIRRORS as i32).max(way::LEAST.into());
    Ok(Energy {
        emitted: watts(emitted),
        absorbed: watts(absorbed),
        escaped: watts(escaped),
        imbalance: Some(imbalance),
        mirrors: geometry.mirrors.then(|| watts(mirrors)).flatten(),
        medium: if geometry.sigma > 0.0 { watts(medium) } else { None },
        given_up: geometry.mirrors.then(|| lost * left / emitted.iter().sum::<f64>()),
    })
}

/// Light of lights without a surface and of the sky: what arrives on front faces, and what of it is absorbed there. By the
/// twins, on points even over all surfaces, in their order.
fn surfaceless(geometry: &Geometry, seed: u32, rays: u32) -> [[f64; 3]; 2] {
    let whole: f64 = geometry.areas.iter().sum();
    let even = distribution(geometry, &vec![1.0 / whole; geometry.tiles as usize]);
    let points = drawn(geometry, &even, seed, LOOKS.min(rays));
    let found: Vec<Vec3> = (points.par_iter().enumerate())
        .map(|(i, y)| match geometry.tris[y.tri as usize].mirror() > 0.0 {
            // What comes over a mirror is counted where it arrives.
            true => Vec3::ZERO,
            false => lights::surfaceless(geometry, y.tri, Vec3::from(y.p), seed_of(seed, i as u32), 0, LOOK),
        })
        .collect();
    let mut sums = [[0.0; 3]; 2];
    for (y, light) in points.iter().zip(found) {
        for k in 0..3 {
            let arrives = f64::from(light[k]) * whole / points.len() as f64;
            sums[0][k] += arrives;
            sums[1][k] += arrives * (1.0 - f64::from(geometry.material_at(y).rho[k]));
        }
    }
    sums
}
