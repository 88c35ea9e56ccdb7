//! The account of energy: where every emitted watt went.

use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{DirectSum, NONE, NodeLight, Point, kind};
use crate::network::tiles::{distribution, mean};
use crate::output::report::Energy;
use crate::params::{Direct, Params};
use crate::progress::Progress;
use crate::scene::Geometry;

/// Most rays from emitters.
const EMISSION_RAYS: u32 = 65_536;
/// Those for each ray of the bake, where that is fewer.
const SHARE: u32 = 4;

/// Follows every watt: light from emitters by rays of their own, reflected light by the network's rays.
///
/// emitted = absorbed + escaped holds only if D, H and the rays agree, so the imbalance is a check.
/// Back faces and black surfaces absorb what meets them.
pub fn account<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    seed: u32,
    params: &Params,
    light: &[NodeLight],
    batches: &mut [E::Batch],
    progress: &mut Progress,
) -> Result<Energy> {
    let area_scale = if geometry.flatland { geometry.scale } else { geometry.scale * geometry.scale };
    let per_area = 1.0 / (geometry.emission_scale * area_scale);
    let mut emitted = [0.0; 3];
    for e in &geometry.emitters {
        let emit = geometry.mean_emission(e.tri as usize);
        for k in 0..3 {
            emitted[k] += emit[k] * geometry.areas[e.tri as usize];
        }
    }
    if emitted == [0.0; 3] {
        return Ok(Energy { emitted: Some([0.0; 3]), absorbed: Some([0.0; 3]), escaped: Some([0.0; 3]), imbalance: Some(0.0) });
    }
    let (mut absorbed, mut escaped) = ([0.0; 3], [0.0; 3]);
    let mut follow = |points: &[Point], sent: &dyn Fn(usize) -> [f64; 3]| {
        for d in 0..points.len() {
            let y = &points[d];
            // One-way rays are stored at their start, so their receiver is the odd end.
            let one_way = y.kind == kind::SKY || y.kind == kind::BACK;
            let x = d ^ 1;
            let w = if one_way { points[x].weight } else { y.weight } as f64;
            if w <= 0.0 || (one_way && d % 2 == 0) {
                continue;
            }
            let s = sent(x);
            for k in 0..3 {
                match y.kind {
                    kind::SKY => escaped[k] += w * s[k],
                    kind::BACK => absorbed[k] += w * s[k],
                    _ => absorbed[k] += w * s[k] * (1.0 - geometry.material_at(y).rho[k] as f64),
                }
            }
        }
    };

    // Light from emitters.
    let mut shine = vec![0.0; geometry.tiles as usize];
    let all = mean(&emitted);
    for t in 0..shine.len() {
        shine[t] = mean(&geometry.mean_emission(geometry.tile_tri[t] as usize)) / all;
    }
    let rays = EMISSION_RAYS.min(SHARE * params.rays);
    let batch = engine.emit(&distribution(geometry, &shine), seed, 0, rays, rays)?;
    let points = engine.points(&batch)?;
    follow(&points, &|x| if points[x].tri == NONE { [0.0; 3] } else { geometry.material_at(&points[x]).emit.map(f64::from) });

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
    let imbalance = (0..3).map(|k| emitted[k] - absorbed[k] - escaped[k]).sum::<f64>() / emitted.iter().sum::<f64>();
    let watts = |x: [f64; 3]| Some(x.map(|v| v * per_area));
    Ok(Energy { emitted: watts(emitted), absorbed: watts(absorbed), escaped: watts(escaped), imbalance: Some(imbalance) })
}
