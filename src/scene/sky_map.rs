//! Pictures of the sky: equirectangular maps of radiance, from EXR and Radiance HDR files.

use crate::error::{Error, Result};
use std::io::Cursor;
use std::path::Path;

/// Most texels across and down: a map of them takes 2 GiB.
const MOST: [u32; 2] = [16_384, 8_192];

/// An equirectangular picture of radiance, W/m²/sr, linear Rec.709. Its rows go from above (+y) to below, its columns once
/// around: the middle lies along -z, three quarters along +x. A texel has one radiance all over.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Rows from the top.
    pub rgb: Vec<[f32; 3]>,
}

impl SkyMap {
    /// Reads a map from the bytes of an `.exr` or `.hdr` file; `path` tells which, and names it in messages.
    ///
    /// Errors: [`Error::Format`] where the file is damaged, too large, without red, green and blue, or holds what is no number;
    /// values below 0, as filters leave them, become 0.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<SkyMap> {
        let fail = |what: String, cure: &str| Error::Format { path: path.into(), line: None, what, cure: cure.into() };
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let mut map = match extension.as_str() {
            "exr" => exr(bytes),
            "hdr" | "pic" => hdr(bytes),
            _ => return Err(fail("the name does not tell a map of radiance".into(), "name it .exr or .hdr")),
        }
        .map_err(|what| fail(what, "save the map again, as red, green and blue in floats"))?;
        if let Some(i) = map.rgb.iter().position(|c| c.iter().any(|x| !x.is_finite())) {
            let at = [i as u32 % map.width, i as u32 / map.width];
            let what = format!("the texel at column {}, row {} is {:?}, no finite radiance", at[0], at[1], map.rgb[i]);
            return Err(fail(what, "clip the map to finite numbers (a sun in half floats may exceed 65504)"));
        }
        map.rgb.as_flattened_mut().iter_mut().for_each(|x| *x = x.max(0.0));
        Ok(map)
    }

    /// Checks that it is whole. Errors: [`Error::InvalidLight`].
    pub(super) fn check(&self) -> Result<()> {
        let refuse = |what: String, cure| Err(Error::InvalidLight { light: "environment".into(), what, cure });
        if fits(self.width, self.height).is_err() || self.rgb.len() as u64 != u64::from(self.width) * u64::from(self.height) {
            let what = format!("a map of {} by {} with {} texels", self.width, self.height, self.rgb.len());
            return refuse(what, "give width times height texels, up to 16384 by 8192");
        }
        match self.rgb.iter().flatten().find(|x| !(0.0..=f32::MAX).contains(*x)) {
            Some(x) => refuse(format!("a texel of its map is {x}"), "give finite radiances >= 0"),
            None => Ok(()),
        }
    }

    /// Its mean over all directions, W/m²/sr.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (row, texels) in self.rgb.chunks(self.width as usize).enumerate() {
            let (_, share) = band(row, self.height);
            for k in 0..3 {
                sum[k] += 0.5 * share * texels.iter().map(|c| f64::from(c[k])).sum::<f64>() / f64::from(self.width);
            }
        }
        sum
    }
}

/// The cosine from the upward axis at the upper edge of a row of a map, and by how much it falls until the lower one: 2 pi times that
/// is the row's solid angle.
pub(super) fn band(row: usize, height: u32) -> (f64, f64) {
    let angle = |row: f64| std::f64::consts::PI * row / f64::from(height);
    // cos a - cos b = 2 sin((a + b)/2) sin((b - a)/2): near the poles a difference of cosines would lose its digits.
    let fall = 2.0 * angle(row as f64 + 0.5).sin() * angle(0.5).sin();
    (angle(row as f64).cos(), fall)
}

/// Whether a map may have this size.
fn fits(width: u32, height: u32) -> std::result::Result<(), String> {
    match (1..=MOST[0]).contains(&width) && (1..=MOST[1]).contains(&height) {
        true => Ok(()),
        false => Err(format!("the map is {width} by {height} texels, and 1 to {} by 1 to {} are read", MOST[0], MOST[1])),
    }
}

fn exr(bytes: &[u8]) -> std::result::Result<SkyMap, String> {
    use exr::prelude::*;
    // The size is looked at before anything is made of it.
    let told = |e: exr::error::Error| format!("the EXR file cannot be read ({e})");
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(told)?;
    for header in &meta.headers {
        let size = header.layer_size;
        fits(u32::try_from(size.0).unwrap_or(u32::MAX), u32::try_from(size.1).unwrap_or(u32::MAX))?;
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size: Vec2<usize>, _| (size.0, vec![[0.0f32; 3]; size.0 * size.1]),
            |(width, texels): &mut (usize, Vec<[f32; 3]>), at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
                texels[at.1 * *width + at.0] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(told)?;
    let size = image.layer_data.size;
    let (_, rgb) = image.layer_data.channel_data.pixels;
    Ok(SkyMap { width: size.0 as u32, height: size.1 as u32, rgb })
}

fn hdr(bytes: &[u8]) -> std::result::Result<SkyMap, String> {
    use image::ImageDecoder;
    let told = |e: image::ImageError| format!("the HDR file cannot be read ({e})");
    let decoder = image::codecs::hdr::HdrDecoder::new(Cursor::new(bytes)).map_err(told)?;
    let (width, height) = decoder.dimensions();
    fits(width, height)?;
    let mut rgb = vec![[0.0f32; 3]; width as usize * height as usize];
    decoder.read_image(bytemuck::cast_slice_mut(&mut rgb)).map_err(told)?;
    Ok(SkyMap { width, height, rgb })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_map_has_its_own_mean() {
        for (width, height) in [(1, 1), (2, 1), (64, 32), (4096, 2048)] {
            let map = SkyMap { width, height, rgb: vec![[1.0, 2.0, 0.5]; (width * height) as usize] };
            let mean = map.mean();
            for (got, want) in mean.iter().zip([1.0, 2.0, 0.5]) {
                assert!((got / want - 1.0).abs() < 1e-9, "{width} by {height}: {got} {want}");
            }
        }
    }

    #[test]
    fn maps_are_read_and_damage_is_named() {
        let rgb = [[1.0f32, 0.5, 0.25], [2.0, 4.0, 8.0], [0.0, 100.0, 1.0], [0.125, 0.25, 3.0]];
        let mut bytes = Cursor::new(Vec::new());
        let channels = exr::prelude::SpecificChannels::rgb(|at: exr::prelude::Vec2<usize>| {
            let [r, g, b] = rgb[at.y() * 2 + at.x()];
            (r, g, b)
        });
        use exr::prelude::WritableImage;
        exr::prelude::Image::from_channels((2, 2), channels).write().to_buffered(&mut bytes).unwrap();
        let exr = bytes.into_inner();
        assert_eq!(SkyMap::from_bytes(&exr, Path::new("a.exr")).unwrap(), SkyMap { width: 2, height: 2, rgb: rgb.to_vec() });
        // Radiance's own format: eight bits and a shared exponent, exact for these.
        let texel = |c: [f32; 3]| {
            let most = c.iter().fold(0.0f32, |a, &b| a.max(b));
            let exponent = most.log2().floor() as i32 + 1;
            let byte = |x: f32| (x * 2f32.powi(8 - exponent)) as u8;
            [byte(c[0]), byte(c[1]), byte(c[2]), (exponent + 128) as u8]
        };
        let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n".to_vec();
        rgb.iter().for_each(|&c| hdr.extend(texel(c)));
        let read = SkyMap::from_bytes(&hdr, Path::new("a.hdr")).unwrap();
        for (got, want) in read.rgb.as_flattened().iter().zip(rgb.as_flattened()) {
            assert!((got - want).abs() <= want.max(100.0 / 256.0), "{got} {want}");
        }
        assert_eq!(read.rgb[0], rgb[0]);
        for (bytes, name, part) in [
            (&exr[..exr.len() / 2], "a.exr", "EXR"),
            (&hdr[..20], "a.hdr", "HDR"),
            (&exr, "a.png", "name it .exr"),
            (&hdr, "a.exr", "EXR"),
        ] {
            let said = SkyMap::from_bytes(bytes, Path::new(name)).unwrap_err().to_string();
            assert!(said.contains(part) && said.contains(name), "{said}");
        }
        let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
        assert!(SkyMap::from_bytes(huge, Path::new("a.hdr")).unwrap_err().to_string().contains("60000"));
        assert!(SkyMap { width: 2, height: 2, rgb: vec![[1.0; 3]; 3] }.check().is_err());
        assert!(SkyMap { width: 1, height: 1, rgb: vec![[f32::NAN; 3]] }.check().is_err());
    }
}
