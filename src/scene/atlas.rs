//! Packs the maps of a scene into one array of texels, as the passes read them ([`crate::twin::texture`]).
//!
//! Each triangle gets the image of one resolution: the finest whose texels are about as wide as rays lie apart. What is
//! finer than that would be noise to a bake, and memory to a device; read-outs take the scene's own texels.

use super::texture::{Map, Texture};
use super::{Material, Scene};
use crate::error::{Error, Result};
use crate::layout::{NONE, Tri};
use crate::twin::texture::{CLAMP, EMIT, MASK, RECORD, RHO};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Ends of rays that the live area is shared among: about as wide as a share is a texel.
const ENDS: usize = 1 << 20;

/// The texels of a scene's maps.
#[derive(Clone, Debug, Default)]
pub struct Atlas {
    /// Six texels a triangle, then the images: those of reflectance first. Empty where no triangle has a map.
    pub texels: Vec<[u32; 4]>,
    /// Where the images of reflectance end.
    pub rho_end: usize,
    /// Whether any triangle has a map of reflectance or emission.
    pub textured: bool,
    /// Whether any is cut out.
    pub cut: bool,
}

/// An image that is needed: which texture, at which level, multiplied by what.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Image {
    map: usize,
    texture: u32,
    level: u32,
    factor: [u64; 3],
}

impl Image {
    fn size(&self, textures: &[Texture]) -> (u32, u32) {
        let t = &textures[self.texture as usize];
        ((t.width >> self.level).max(1), (t.height >> self.level).max(1))
    }

    /// Texels of the array that it takes.
    fn len(&self, textures: &[Texture]) -> u64 {
        let (w, h) = self.size(textures);
        let count = u64::from(w) * u64::from(h);
        if self.map == MASK { count.div_ceil(128) } else { count }
    }
}

/// The factors of a material's maps as the passes have them: reflectance, scaled radiosity, and the cutoff.
fn factors(m: &Material, emission_scale: f64) -> [[f64; 3]; 3] {
    [m.reflectance, m.emission.map(|x| x * PI * emission_scale), [m.alpha_cutoff; 3]]
}

/// What a map makes of a material on average: its factor times the mean of the texels.
pub fn mean(factor: [f64; 3], map: Option<Map>, textures: &[Texture]) -> [f64; 3] {
    let Some(map) = map else { return factor };
    let mean = textures[map.texture as usize].mean();
    [0, 1, 2].map(|k| factor[k] * mean[k])
}

/// Packs the maps of triangles that come from `source` faces, of `areas`; `live` is the area that rays end on, local.
///
/// Errors: [`Error::Limit`] where there are more texels than can be numbered.
pub fn pack(scene: &Scene, tris: &[Tri], source: &[u32], areas: &[f64], live: f64, emission_scale: f64) -> Result<Atlas> {
    let wanted = |t: usize| scene.materials[tris[t].material as usize].maps().iter().any(Option::is_some);
    let any = (0..tris.len()).any(|t| wanted(t) && scene.uv(source[t] as usize).is_some());
    if !any {
        return Ok(Atlas::default());
    }
    let flatland = scene.is_flatland();
    let share = live / ENDS as f64;
    let footprint = if flatland { share } else { share.sqrt() };

    // Which images, and where on them.
    let mut number: HashMap<Image, usize> = HashMap::new();
    let mut images: Vec<Image> = Vec::new();
    let mut out = Atlas::default();
    out.texels.resize(RECORD * tris.len(), [0, 0, NONE, 0]);
    let mut of: Vec<(usize, usize)> = Vec::new();
    for t in 0..tris.len() {
        let Some(uv) = scene.uv(source[t] as usize).filter(|_| wanted(t)) else { continue };
        let m = &scene.materials[tris[t].material as usize];
        for (map, (found, factor)) in m.maps().into_iter().zip(factors(m, emission_scale)).enumerate() {
            // A mirror reflects nothing diffusely.
            let Some(found) = found.filter(|_| map != RHO || m.mirror <= 0.0) else { continue };
            let texture = &scene.textures[found.texture as usize];
            let mut at = uv.map(|uv| DVec2::from_array(found.place(uv)));
            // Repeats count for nothing; near 0 the most digits are left.
            for k in 0..2 {
                if !found.clamp[k] {
                    let whole = at[0][k].min(at[1][k]).min(at[2][k]).floor();
                    at.iter_mut().for_each(|p| p[k] -= whole);
                }
            }
            let size = DVec2::new(texture.width.into(), texture.height.into());
            let [a, b, c] = at.map(|p| p * size);
            let across =
                if flatland { (b - a).length() / areas[t] } else { (0.5 * (b - a).perp_dot(c - a).abs() / areas[t]).sqrt() };
            let coarsest = texture.width.max(texture.height).ilog2();
            let level =
                if map == MASK { 0 } else { ((across * footprint).log2().floor() as i32).clamp(0, coarsest as i32) as u32 };
            let image = Image { map, texture: found.texture, level, factor: factor.map(f64::to_bits) };
            let known = *number.entry(image).or_insert_with(|| {
                images.push(image);
                images.len() - 1
            });
            let (w, h) = image.size(&scene.textures);
            let flag = |clamp: bool| if clamp { CLAMP } else { 0 };
            let size = (w | flag(found.clamp[0])) | (h | flag(found.clamp[1])) << 16;
            let first = RECORD * t + 2 * map;
            let [a, b, c] = at.map(|p| p.as_vec2().to_array().map(f32::to_bits));
            out.texels[first] = [a[0], a[1], b[0], b[1]];
            out.texels[first + 1] = [c[0], c[1], NONE, size];
            of.push((first + 1, known));
        }
    }

    // Lay the images out, reflectance first.
    let mut begin = vec![0u64; images.len()];
    let mut end = out.texels.len() as u64;
    for map in [RHO, EMIT, MASK] {
        for (i, image) in images.iter().enumerate().filter(|(_, image)| image.map == map) {
            begin[i] = end;
            end += image.len(&scene.textures);
        }
        if map == RHO {
            out.rho_end = end as usize;
        }
    }
    if end >= u64::from(NONE) {
        return Err(Error::Limit {
            what: format!("{}: the scene's textures", scene.name),
            limit: "number of texels",
            need: end,
            have: NONE.into(),
            cure: "use smaller images",
        });
    }
    for (record, known) in of {
        out.texels[record][2] = begin[known] as u32;
    }
    out.texels.resize(end as usize, [0; 4]);
    for (i, image) in images.iter().enumerate() {
        let texture = &scene.textures[image.texture as usize];
        let part = &mut out.texels[begin[i] as usize..][..image.len(&scene.textures) as usize];
        match image.map {
            MASK => mask(texture, f64::from_bits(image.factor[0]), part),
            _ => resample(texture, image.size(&scene.textures), image.factor.map(f64::from_bits), part),
        }
        out.textured |= image.map != MASK;
        out.cut |= image.map == MASK;
    }
    Ok(out)
}

/// The texels of a side that one of `n` equal parts of it covers, with the share of each that lies in it.
fn covered(side: u32, n: u32, i: u32) -> impl Iterator<Item = (u32, f64)> {
    let (low, high) = (f64::from(i) * f64::from(side) / f64::from(n), f64::from(i + 1) * f64::from(side) / f64::from(n));
    let last = (high.ceil() as u32).min(side);
    (low as u32..last).map(move |x| (x, (high.min(f64::from(x) + 1.0) - low.max(x.into())).max(0.0)))
}

/// A texture at a coarser size, times a factor: each texel the mean of those that it covers, in f64.
fn resample(texture: &Texture, (w, h): (u32, u32), factor: [f64; 3], out: &mut [[u32; 4]]) {
    out.par_chunks_mut(w as usize).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let (mut sum, mut all) = ([0.0; 3], 0.0);
            for (sy, across) in covered(texture.height, h, y as u32) {
                for (sx, along) in covered(texture.width, w, x as u32) {
                    let t = texture.texel(sx, sy);
                    sum = [0, 1, 2].map(|k| sum[k] + across * along * f64::from(t[k]));
                    all += across * along;
                }
            }
            let [r, g, b] = [0, 1, 2].map(|k| ((factor[k] * sum[k] / all) as f32).to_bits());
            *texel = [r, g, b, 0];
        }
    });
    debug_assert_eq!(out.len(), w as usize * h as usize);
}

/// Where a texture's alpha is at least the cutoff: a bit a texel.
fn mask(texture: &Texture, cutoff: f64, out: &mut [[u32; 4]]) {
    let count = texture.width as usize * texture.height as usize;
    out.par_iter_mut().enumerate().for_each(|(i, words)| {
        for bit in (0..128).filter(|bit| 128 * i + bit < count) {
            let at = (128 * i + bit) as u32;
            if f64::from(texture.texel(at % texture.width, at / texture.width)[3]) >= cutoff {
                words[bit / 32] |= 1 << (bit % 32);
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Geometry, Texels, shapes};
    use crate::twin::texture;

    /// A unit square in the plane z = 0 with its image the right way up, and a texture on it.
    pub fn square(texture: Texture, material: Material) -> Scene {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mut scene =
            Scene::from_triangles("square", &shapes::quad(corners, 0), vec![Material::new("m", [0.5; 3], [0.0; 3])]).unwrap();
        scene.uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        scene.face_uvs = vec![[0, 1, 2], [0, 2, 3]];
        scene.textures = vec![texture];
        scene.materials = vec![material];
        scene
    }

    fn noise(w: u32, h: u32) -> Texture {
        let value = |i: u32| crate::twin::math::unit(crate::twin::math::hash(i + 1)) * 0.9;
        let texels = (0..w * h).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2), value(i + 7)]).collect();
        Texture { name: "noise".into(), width: w, height: h, texels: Texels::Float(texels) }
    }

    fn mapped() -> Material {
        Material { reflectance_map: Some(Map::new(0)), ..Material::new("m", [0.5, 1.0, 1.0], [0.0; 3]) }
    }

    #[test]
    fn values_are_those_of_the_image() {
        let scene = square(noise(7, 5), mapped());
        let geometry = Geometry::new(&scene).unwrap();
        assert!(geometry.textured && !geometry.cut);
        for (x, y) in [(0u32, 0u32), (3, 2), (6, 4), (1, 3)] {
            // A texel's middle; the square is 1 m, its upper left corner at (0, 1).
            let p = [(f64::from(x) + 0.5) / 7.0, 1.0 - (f64::from(y) + 0.5) / 5.0, 0.0];
            let at = geometry.locate(p, [0.0, 0.0, 1.0]).unwrap();
            let (b1, b2) = texture::shares(false, &geometry.tris[at.tri as usize], at.p.into());
            let found = texture::rho(&geometry, at.tri, b1, b2).to_array();
            let texel = scene.textures[0].texel(x, y);
            let want = [0.5 * texel[0], texel[1], texel[2]];
            assert!((0..3).all(|k| (found[k] - want[k]).abs() < 2e-6), "{x} {y}: {found:?} {want:?}");
            let (shown, _) = scene.shown(geometry.source[at.tri as usize] as usize, b1.into(), b2.into());
            assert!((0..3).all(|k| (shown[k] - f64::from(want[k])).abs() < 2e-6), "{x} {y}: {shown:?} {want:?}");
        }
    }

    #[test]
    fn coarser_images_have_the_same_mean() {
        let t = noise(13, 6);
        let mean = t.mean();
        for size in [(13, 6), (6, 3), (3, 1), (1, 1)] {
            let mut out = vec![[0; 4]; size.0 as usize * size.1 as usize];
            resample(&t, size, [1.0; 3], &mut out);
            for k in 0..3 {
                let all: f64 = out.iter().map(|t| f64::from(f32::from_bits(t[k]))).sum();
                assert!((all / out.len() as f64 - mean[k]).abs() < 1e-7, "{size:?}");
            }
        }
    }

    #[test]
    fn fine_images_are_stored_as_coarsely_as_rays_see_them() {
        let fine = Geometry::new(&square(noise(4096, 4096), mapped())).unwrap();
        // Two units wide, live area 4: texels of 1/2048 in shares of 2/1024: level 2.
        assert_eq!(fine.texels.len(), 2 * RECORD + 1024 * 1024);
        let coarse = Geometry::new(&square(noise(64, 64), mapped())).unwrap();
        assert_eq!(coarse.texels.len(), 2 * RECORD + 64 * 64);
        assert!((fine.materials[0].rho[1] - 0.45).abs() < 1e-3, "{:?}", fine.materials[0]);
    }

    #[test]
    fn bits_are_where_alpha_is() {
        let t = noise(37, 11);
        let material = Material { alpha_map: Some(Map::new(0)), alpha_cutoff: 0.3, ..Material::new("m", [0.5; 3], [1.0; 3]) };
        let scene = square(t.clone(), material);
        let geometry = Geometry::new(&scene).unwrap();
        assert!(!geometry.textured && geometry.cut);
        let mut there = 0;
        for i in 0..37 * 11 {
            let (x, y) = (i % 37, i / 37);
            let p = [(f64::from(x) + 0.5) / 37.0, 1.0 - (f64::from(y) + 0.5) / 11.0, 0.0];
            let at = geometry.locate(p, [0.0, 0.0, 1.0]).unwrap();
            let (b1, b2) = texture::shares(false, &geometry.tris[at.tri as usize], at.p.into());
            let is = f64::from(t.texel(x, y)[3]) >= 0.3;
            assert_eq!(texture::is_there(&geometry, at.tri, b1, b2), is, "{x} {y}");
            there += u32::from(is);
        }
        // It emits by the part that is there, by each triangle half of it or so.
        let share: f64 = (0..2).map(|e| geometry.mean_emission(e)[0] * 0.5).sum();
        let want = f64::from(there) / 407.0 * f64::from(geometry.materials[0].emit[0]);
        assert!((share / want - 1.0).abs() < 0.01, "{share} {want}");
    }

    #[test]
    fn an_image_repeats_or_is_clamped() {
        let mut scene = square(noise(4, 4), mapped());
        let map = Map { transform: [[1.0, 0.0, 5.25], [0.0, 1.0, 0.0]], ..Map::new(0) };
        for clamp in [false, true] {
            scene.materials[0].reflectance_map = Some(Map { clamp: [clamp; 2], ..map });
            let geometry = Geometry::new(&scene).unwrap();
            // The middle of the second row's first texel, three texels on.
            let at = geometry.locate([0.625, 1.0 - 0.375, 0.0], [0.0, 0.0, 1.0]).unwrap();
            let (b1, b2) = texture::shares(false, &geometry.tris[at.tri as usize], at.p.into());
            let want = scene.textures[0].texel(3, 1)[1];
            assert!((texture::rho(&geometry, at.tri, b1, b2).y - want).abs() < 2e-6, "{clamp}");
        }
    }
}
