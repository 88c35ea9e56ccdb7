//! Pictures of a solution: rays from a pinhole camera, and light where they land.

use super::{Solution, narrow};
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::layout::{NONE, Point, kind};
use crate::params::Params;
use crate::progress::{Event, Flow};
use crate::scene::{Geometry, Scene};
use crate::twin::lights;
use crate::twin::trace::{barycentric, surface_point};
use crate::twin::way::{Way, follow, way_in};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Relative standard error of direct light in a picture: below what the eye tells apart in 8 bits.
const DIRECT_TOLERANCE: f64 = 0.03;
/// Most direct samples a pixel.
const DIRECT_SAMPLES: u32 = 256;
/// Rays of a final gather at a pixel.
const GATHER_RAYS: u32 = 96;
/// Pixels gather at contacts and in slots only.
const GATHER_THRESHOLD: f64 = 0.6;

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, metres.
    pub eye: [f64; 3],
    /// What it looks at, metres.
    pub target: [f64; 3],
    /// What is up.
    pub up: [f64; 3],
    /// Vertical field of view, degrees.
    pub vfov_degrees: f64,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

/// A picture in linear radiance, W/m²/sr.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Rows from the top.
    pub rgb: Vec<[f32; 3]>,
}

impl Camera {
    /// Checks that a picture can be made. Errors: [`Error::InvalidParam`].
    pub fn check(&self) -> Result<()> {
        let refuse = |name, value: String, range| Err(Error::InvalidParam { name, value, range });
        let [eye, target, up] = [self.eye, self.target, self.up].map(DVec3::from_array);
        let forward = target - eye;
        if !(forward.is_finite() && up.is_finite() && forward.cross(up).length() > 1e-9 * forward.length() * up.length()) {
            let value = format!("{:?} to {:?}", self.eye, self.target);
            return refuse("camera", value, "eye and target must differ, and up point across");
        }
        if !(self.vfov_degrees > 0.0 && self.vfov_degrees < 180.0) {
            return refuse("vfov", self.vfov_degrees.to_string(), "give more than 0 and less than 180 degrees");
        }
        for (name, pixels) in [("width", self.width), ("height", self.height)] {
            if !(1..=16_384).contains(&pixels) {
                return refuse(name, pixels.to_string(), "give 1 to 16384 pixels");
            }
        }
        Ok(())
    }

    /// The direction through the centre of a pixel, rows from the top; of any length.
    pub fn direction(&self, x: u32, y: u32) -> [f64; 3] {
        let [eye, target, up] = [self.eye, self.target, self.up].map(DVec3::from_array);
        let forward = (target - eye).normalize_or_zero();
        let right = forward.cross(up).normalize_or_zero();
        let half = (0.5 * self.vfov_degrees.to_radians()).tan();
        let (w, h) = (self.width as f64, self.height as f64);
        let u = (2.0 * (x as f64 + 0.5) - w) / h * half;
        let v = (1.0 - 2.0 * (y as f64 + 0.5) / h) * half;
        (forward + right * u + right.cross(forward) * v).to_array()
    }
}

/// What a camera sees through each pixel's centre, rows from the top: a point on a front face, or nothing.
pub(crate) fn seen(scene: &Scene, geometry: &Geometry, camera: &Camera) -> Result<Vec<Option<Point>>> {
    if scene.is_flatland() { primary_feet(scene, geometry, camera) } else { Ok(primary_hits(geometry, camera)) }
}

/// What a camera sees of the walls on a flatland scene's segments: the point at the foot of the wall.
fn primary_feet(scene: &Scene, geometry: &Geometry, camera: &Camera) -> Result<Vec<Option<Point>>> {
    let walls = Geometry::new(&scene.extruded())?;
    // The segment of each face, where it was not dropped.
    let mut segment = vec![NONE; scene.faces.len()];
    for (tri, &face) in geometry.source.iter().enumerate() {
        segment[face as usize] = tri as u32;
    }
    let foot = |hit: Point| {
        let face = walls.source[hit.tri as usize];
        let tri = segment[face as usize / 2];
        let world = walls.to_world(hit.p);
        let mut p = DVec3::from_array(geometry.to_local(world)).as_vec3();
        p.z = 0.0;
        let (b1, _) = barycentric(true, geometry.tris.get(tri as usize)?, p);
        Some(Point { density: hit.density, ..surface_point(geometry, tri, b1.clamp(0.0, 1.0), 0.0) })
    };
    Ok(primary_hits(&walls, camera).into_iter().map(|hit| hit.and_then(foot)).collect())
}

/// What a camera sees through each pixel's centre, also in mirrors: a point on a front face, its `density` the share of its
/// light that arrives, or nothing (the sky, a black back face). On the host: a ray a pixel is little beside what shading it takes.
fn primary_hits(geometry: &Geometry, camera: &Camera) -> Vec<Option<Point>> {
    let origin = DVec3::from_array(geometry.to_local(camera.eye)).as_vec3();
    (0..camera.width * camera.height)
        .into_par_iter()
        .map(|i| {
            let way = DVec3::from_array(camera.direction(i % camera.width, i / camera.width));
            // Ways that lose light are measured.
            let direction = if geometry.is_lossy() { way.normalize() } else { way }.as_vec3();
            // There is no medium outside the scene's box.
            let start = if geometry.sigma > 0.0 { origin + direction * way_in(geometry, origin, direction) } else { origin };
            let Way { kind, hit, share, .. } = follow(geometry, NONE, start, direction);
            (kind == kind::FRONT).then(|| Point { density: share, ..surface_point(geometry, hit.tri, hit.b1, hit.b2) })
        })
        .collect()
}

impl Solution {
    /// A picture in linear radiance, one ray a pixel. Back faces are black; rays that meet nothing see the sky, and the discs
    /// of suns that have a size. A flatland scene's segments are
    /// seen as walls, [`crate::scene::Space`], that have the light of their foot all the way up.
    ///
    /// Direct light and final gathers take fewer samples than in [`Solution::query`]. Errors:
    /// [`Error::InvalidParam`] for a camera that cannot be; those of the device; [`Error::NotFinite`];
    /// [`Error::Overflow`].
    pub fn render(&self, backend: &Backend, camera: &Camera) -> Result<Image> {
        self.render_with(backend, camera, &mut |_| Flow::Continue)
    }

    /// As [`Solution::render`], telling its progress.
    pub fn render_with(&self, backend: &Backend, camera: &Camera, tell: &mut dyn FnMut(&Event) -> Flow) -> Result<Image> {
        camera.check()?;
        let hits = seen(&self.scene, &self.geometry, camera)?;
        let points: Vec<Point> = hits.iter().flatten().copied().collect();
        let params = Params {
            direct_tolerance: self.params.direct_tolerance.max(DIRECT_TOLERANCE),
            direct_samples: self.params.direct_samples.min(DIRECT_SAMPLES),
            gather_rays: self.params.gather_rays.min(GATHER_RAYS),
            gather_threshold: self.params.gather_threshold.min(GATHER_THRESHOLD),
            ..self.params.clone()
        };
        let mut shades = self.shade(backend, &params, &points, tell)?.into_iter();
        let rgb = hits
            .iter()
            .enumerate()
            .map(|(i, hit)| match hit.as_ref().zip(if hit.is_some() { shades.next() } else { None }) {
                Some((point, shade)) => {
                    let what = || format!("the light at pixel {},{}", i as u32 % camera.width, i as u32 / camera.width);
                    let share = self.geometry.arriving(point);
                    narrow(self.answer(point, &shade, what)?.b.map(|b| share * b / PI), what)
                }
                None => self.behind(camera, i as u32),
            })
            .collect::<Result<_>>()?;
        Ok(Image { width: camera.width, height: camera.height, rgb })
    }

    /// Radiance at a pixel whose ray meets no front face: the sky's, also in mirrors, where nothing is in its way. Flatland has none above its plane.
    fn behind(&self, camera: &Camera, pixel: u32) -> Result<[f32; 3]> {
        let geometry = &self.geometry;
        if geometry.flatland || !geometry.is_surfaceless() {
            return Ok([0.0; 3]);
        }
        let direction =
            DVec3::from_array(camera.direction(pixel % camera.width, pixel / camera.width)).normalize_or_zero().as_vec3();
        let origin = DVec3::from_array(geometry.to_local(camera.eye)).as_vec3();
        let start = if geometry.sigma > 0.0 { origin + direction * way_in(geometry, origin, direction) } else { origin };
        let way = follow(geometry, NONE, start, direction);
        if way.kind != kind::SKY {
            return Ok([0.0; 3]);
        }
        let (x, y) = (pixel % camera.width, pixel / camera.width);
        let unscale = f64::from(way.share) / geometry.emission_scale;
        let wide = lights::radiance(geometry, way.direction).map(|l| l * unscale);
        narrow(wide, || format!("the sky at pixel {x},{y}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;

    #[test]
    fn the_picture_is_upright_and_the_back_is_black() {
        // One shining triangle to the upper right; the camera looks along -z.
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0]];
        let shine = Material::new("lamp", [0.0; 3], [3.0, 2.0, 1.0]);
        let scene = Scene::from_triangles("lamp", &[(corners, 0)], vec![shine]).unwrap();
        let params = Params { rays: 1024, ..Params::default() };
        let solution = crate::bake(&Backend::Cpu, &scene, &params, &mut |_| Flow::Continue).unwrap();
        let mut camera =
            Camera { eye: [0.0, 0.0, 2.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], vfov_degrees: 90.0, width: 4, height: 2 };
        let image = solution.render(&Backend::Cpu, &camera).unwrap();
        // Pixel centres lie at x = -3, -1, 1, 3 and y = 1, -1 in the triangle's plane.
        let lit: Vec<usize> = (0..8).filter(|&i| image.rgb[i] != [0.0; 3]).collect();
        assert_eq!(lit, [2]);
        for (got, want) in image.rgb[2].iter().zip([3.0, 2.0, 1.0]) {
            assert!((got - want).abs() < 1e-5, "radiance is Ke: {got} {want}");
        }
        camera.eye[2] = -2.0;
        assert!(solution.render(&Backend::Cpu, &camera).unwrap().rgb.iter().all(|c| *c == [0.0; 3]));
        for wrong in [
            Camera { target: camera.eye, ..camera },
            Camera { vfov_degrees: 180.0, ..camera },
            Camera { width: 0, ..camera },
            Camera { up: [f64::NAN; 3], ..camera },
        ] {
            assert!(matches!(solution.render(&Backend::Cpu, &wrong), Err(Error::InvalidParam { .. })));
        }
    }
}
