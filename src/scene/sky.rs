//! Lights without a surface as the passes see them: local lengths, scaled radiosities, distributions.

use super::light::{Environment, Light, LightKind};
use super::sky_map::{SkyMap, band};
use super::{Scene, cumulative};
use crate::layout;
use glam::DVec3;
use std::f64::consts::PI;

/// Texels of a [`Sky`] before its rows.
const HEAD: usize = 2;

/// The environment, as four words a texel, on the device as in the twins; no texel at all where it is black.
///
/// ```text
/// texel 0             width, height of the map (0 and 0: none), what it is turned by (turns, f32), -
/// texel 1             E = pi L of a constant sky, scaled (f32, three bands), -
/// height texels       a row of the map: end of its interval of the cumulative distribution, cosine from the upward axis at its
///                     upper edge (f32), by how much that falls to the lower one (f32), -
/// width * height      a texel of the map: E (f32, three bands), end of its interval of its row's cumulative distribution
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sky {
    /// The words.
    pub texels: Vec<[u32; 4]>,
}

impl Sky {
    /// An environment whose radiosities are multiplied by `scale`.
    pub(super) fn new(environment: Option<&Environment>, scale: f64) -> Sky {
        let Some(environment) = environment.filter(|e| brightest(e) > 0.0) else { return Sky::default() };
        let radiosity = |l: f64, k: usize| (PI * l * environment.radiance[k] * scale) as f32;
        let Some(map) = &environment.map else {
            let [r, g, b] = [0, 1, 2].map(|k| radiosity(1.0, k).to_bits());
            return Sky { texels: vec![[0; 4], [r, g, b, 0]] };
        };
        let (width, height) = (map.width as usize, map.height);
        let colour = |texel: &[f32; 3]| [0, 1, 2].map(|k| radiosity(f64::from(texel[k]), k));
        let weight = |e: [f32; 3]| e.iter().map(|&x| f64::from(x)).sum::<f64>();
        let turn = (environment.rotation / 360.0).rem_euclid(1.0) as f32;
        let mut texels = vec![[map.width, height, turn.to_bits(), 0], [0; 4]];
        // Rows by what they send to a sphere within, then texels within their row.
        let rows = || map.rgb.chunks(width).enumerate();
        let powers: Vec<f64> =
            rows().map(|(row, t)| t.iter().map(|t| weight(colour(t))).sum::<f64>() * band(row, height).1).collect();
        for (row, cdf) in cumulative(&powers).into_iter().enumerate() {
            let (top, fall) = band(row, height);
            texels.push([cdf, (top as f32).to_bits(), (fall as f32).to_bits(), 0]);
        }
        for (_, row) in rows() {
            let colours: Vec<[f32; 3]> = row.iter().map(colour).collect();
            let cdf = cumulative(&colours.iter().map(|&e| weight(e)).collect::<Vec<_>>());
            texels.extend(colours.iter().zip(cdf).map(|(e, cdf)| [e[0].to_bits(), e[1].to_bits(), e[2].to_bits(), cdf]));
        }
        Sky { texels }
    }

    /// Whether it is black.
    pub fn is_empty(&self) -> bool {
        self.texels.is_empty()
    }

    /// Whether its bands are one.
    pub fn is_grey(&self) -> bool {
        let colours = match self.texels.first() {
            Some(head) if head[0] > 0 => &self.texels[HEAD + head[1] as usize..],
            Some(_) => &self.texels[1..],
            None => &[],
        };
        colours.iter().all(|t| t[0] == t[1] && t[1] == t[2])
    }

    /// None where it is black, else whether it is a map.
    pub fn mapped(&self) -> Option<bool> {
        (!self.is_empty()).then(|| self.is_mapped())
    }

    /// Whether it differs with the direction.
    pub fn is_mapped(&self) -> bool {
        self.texels.first().is_some_and(|t| t[0] > 0)
    }
}

/// The lights of a scene: suns, then those that stand somewhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    /// Number of suns.
    pub suns: u32,
    /// All of them, those that are black left out.
    pub all: Vec<layout::Lamp>,
}

impl Lights {
    /// Lights of a scene in local lengths ([`super::Geometry::to_local`]), what they send multiplied by `emission_scale`.
    pub(super) fn new(lights: &[Light], center: [f64; 3], scale: f64, emission_scale: f64) -> Lights {
        let shining = |sun: bool| {
            let is = move |l: &&Light| matches!(l.kind, LightKind::Sun { .. }) == sun && l.intensity.iter().any(|&x| x > 0.0);
            lights.iter().filter(is)
        };
        let local = |p: [f64; 3]| [0, 1, 2].map(|k| ((p[k] - center[k]) * scale) as f32);
        let unit = |d: [f64; 3]| DVec3::from(d).normalize_or_zero();
        let prepare = |light: &Light| {
            // Lengths are multiplied by `scale`, so that intensities are by its square.
            let near = emission_scale * scale * scale;
            let sent = |factor: f64| light.intensity.map(|x| (x * factor) as f32);
            match light.kind {
                LightKind::Sun { direction, angle } => layout::Lamp {
                    p: (-unit(direction)).as_vec3().to_array(),
                    slope: (0.5 * angle).to_radians().sin() as f32,
                    value: sent(emission_scale),
                    ..layout::Lamp::default()
                },
                LightKind::Point { position } => {
                    layout::Lamp { p: local(position), value: sent(near), offset: 1.0, ..layout::Lamp::default() }
                }
                LightKind::Spot { position, direction, inner, outer } => {
                    let [inner, outer] = [inner, outer].map(|a| a.to_radians().cos());
                    // An edge of no width is one that floats can tell.
                    let slope = 1.0 / (inner - outer).max(1e-5);
                    layout::Lamp {
                        p: local(position),
                        slope: slope as f32,
                        value: sent(near),
                        offset: (-outer * slope) as f32,
                        d: unit(direction).as_vec3().to_array(),
                        pad0: 0,
                    }
                }
            }
        };
        Lights { suns: shining(true).count() as u32, all: shining(true).chain(shining(false)).map(prepare).collect() }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }
}

/// Radiosity of the brightest source without a surface, W/m²; of those that stand somewhere what they bring to half the
/// scene's extent.
pub(super) fn radiosity(scene: &Scene, scale: f64) -> f64 {
    let light = |l: &Light| {
        let most = l.intensity.iter().fold(0.0, |a: f64, &b| a.max(b));
        if matches!(l.kind, LightKind::Sun { .. }) { most } else { most * scale * scale }
    };
    let around = scene.environment.as_ref().map_or(0.0, |e| PI * brightest(e));
    scene.lights.iter().map(light).fold(around, f64::max)
}

/// Mean radiance over all directions, of the brightest band.
fn brightest(environment: &Environment) -> f64 {
    let mean = environment.map.as_ref().map_or([1.0; 3], SkyMap::mean);
    (0..3).map(|k| mean[k] * environment.radiance[k]).fold(0.0, f64::max)
}
