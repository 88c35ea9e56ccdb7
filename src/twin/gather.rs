//! Pass `gather`: the mean over a point's cosine rays of what their hits reflect (final gather).

use crate::layout::{DirectSum, Point, kind};
use crate::scene::Geometry;
use glam::Vec3;
use rayon::prelude::*;

/// What the hits of a point's rays told (32 bytes are shared with the kernel as two `vec4`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Mean over the rays of rho (D + H) at front hits, scaled W/m²: the irradiance that is not direct.
    pub irradiance: [f32; 3],
    /// Mean over the rays of the square of what one brings, itself a mean over the bands.
    pub square: f32,
    /// Mean of 1/distance over the rays, the sky counting 0: the inverse harmonic mean distance.
    pub nearness: f32,
    /// Share of the rays that met front faces.
    pub front: f32,
    /// Share of the rays that met back faces.
    pub back: f32,
}

impl Gathered {
    /// Whether the point is dead: no front face in sight, back faces in a quarter of all directions.
    pub fn is_dead(&self) -> bool {
        self.front == 0.0 && self.back >= 0.25
    }
}

/// Averages `rays` consecutive hits a point. `light` holds the network's irradiance at each hit;
/// `direct` D at each hit where direct light is exact, `None` where the network carries it.
/// With `light` empty only distances and shares are found.
pub fn gather(geometry: &Geometry, hits: &[Point], light: &[[f32; 4]], direct: Option<&[DirectSum]>, rays: u32) -> Vec<Gathered> {
    hits.par_chunks_exact(rays as usize)
        .enumerate()
        .map(|(i, hits)| {
            let mut sum = Vec3::ZERO;
            let mut g = Gathered::default();
            for (k, hit) in hits.iter().enumerate() {
                let at = i * rays as usize + k;
                if hit.kind == kind::FRONT || hit.kind == kind::BACK {
                    g.nearness += 1.0 / hit.weight.max(1e-12);
                }
                g.back += (hit.kind == kind::BACK) as u32 as f32;
                g.front += (hit.kind == kind::FRONT) as u32 as f32;
                if hit.kind == kind::FRONT && !light.is_empty() {
                    let rho = Vec3::from(geometry.material_at(hit).rho);
                    let d = direct.map_or(Vec3::ZERO, |d| Vec3::from(d[at].mean()));
                    let sent = rho * (d + Vec3::from_slice(&light[at][..3]));
                    let brought = if geometry.is_lossy() { sent * hit.density } else { sent };
                    sum += brought;
                    let grey = (brought.x + brought.y + brought.z) / 3.0;
                    g.square += grey * grey;
                }
            }
            let inv = 1.0 / rays as f32;
            g.irradiance = (sum * inv).to_array();
            g.square *= inv;
            g.nearness *= inv;
            g.front *= inv;
            g.back *= inv;
            g
        })
        .collect()
}
