//! Radiosity in flatland by many equal patches and the kernel between the middles of all: the truth that a figure is
//! held against.

use super::kernel::analytic;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::Point;
use crate::scene::Geometry;
use crate::twin::trace::{barycentric, surface_point};
use glam::Vec3;

/// Sweeps of Jacobi: with reflectances to 0.7 more change nothing in single precision.
const SWEEPS: usize = 60;

/// A flatland scene cut into patches, solved.
pub struct Patches {
    /// Irradiance of each patch, W/m.
    irradiance: Vec<f64>,
    /// First patch and number of patches of each triangle.
    of_tri: Vec<(usize, usize)>,
}

/// Emitted radiosity at a point, W/m (W/m² in space), of the first band.
pub fn emitted(geometry: &Geometry, p: &Point) -> f64 {
    geometry.material_at(p).emit[0] as f64 / geometry.emission_scale
}

/// Reflectance at a point, of the first band.
pub fn reflectance(geometry: &Geometry, p: &Point) -> f64 {
    geometry.material_at(p).rho[0] as f64
}

/// Cuts every live segment into patches, about `per_metre` a metre, takes the kernel between the middles of all, and
/// solves.
pub fn solve<E: Engine>(engine: &mut E, geometry: &Geometry, per_metre: f64) -> Result<Patches> {
    let (mut points, mut lengths, mut of_tri) = (Vec::new(), Vec::new(), Vec::new());
    for t in 0..geometry.tris.len() {
        let length = geometry.areas[t] / geometry.scale;
        let count = if geometry.is_live(t) { ((length * per_metre).round() as usize).max(1) } else { 0 };
        of_tri.push((points.len(), count));
        for i in 0..count {
            points.push(surface_point(geometry, t as u32, (i as f32 + 0.5) / count as f32, 0.0));
            lengths.push(length / count as f64);
        }
    }
    let n = points.len();
    let mut matrix: Vec<f32> = Vec::with_capacity(n * n);
    for y in &points {
        let pairs: Vec<Point> = points.iter().flat_map(|x| [*x, *y]).collect();
        matrix.extend(analytic(engine, geometry, &pairs)?.iter().zip(&lengths).map(|(k, l)| (k * l) as f32));
    }
    let own: Vec<f64> = points.iter().map(|p| emitted(geometry, p)).collect();
    let gather = |b: &[f64]| -> Vec<f64> {
        matrix.chunks_exact(n).map(|row| row.iter().zip(b).map(|(&k, b)| k as f64 * b).sum()).collect()
    };
    let mut irradiance = gather(&own);
    for _ in 1..SWEEPS {
        let b: Vec<f64> = (0..n).map(|i| own[i] + reflectance(geometry, &points[i]) * irradiance[i]).collect();
        irradiance = gather(&b);
    }
    Ok(Patches { irradiance, of_tri })
}

impl Patches {
    /// The irradiance at a point: interpolated between the middles of its segment's patches.
    pub fn read(&self, geometry: &Geometry, p: &Point) -> f64 {
        let (first, count) = self.of_tri[p.tri as usize];
        if count == 0 {
            return 0.0;
        }
        let (b1, _) = barycentric(geometry.flatland, &geometry.tris[p.tri as usize], Vec3::from(p.p));
        // Between two middles along the segment, beyond the last ones on with their slope.
        let u = b1 as f64 * count as f64 - 0.5;
        let i = (u.floor().max(0.0) as usize).min(count.saturating_sub(2));
        let (a, b) = (self.irradiance[first + i], self.irradiance[first + (i + 1).min(count - 1)]);
        a + (b - a) * (u - i as f64)
    }
}
