//! Pictures: EXR holds linear radiance (W/m²/sr, Rec.709), PNG a tone-mapped look at it.

use super::atomic;
use crate::error::{Error, Result};
use crate::solution::Image;
use std::io::Cursor;
use std::path::Path;

/// The tone curve of every preview: times an exposure, the sRGB curve, clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// What radiance is multiplied by before the sRGB curve.
    pub exposure: f64,
}

/// Where the 95th percentile of the brightest band comes to lie, of 1: most lights clip, rooms do not.
const KEY: f64 = 0.8;

impl Tone {
    /// The exposure that shows most of these colours.
    pub fn auto(colours: &[[f32; 3]]) -> Tone {
        let mut peaks: Vec<f32> =
            colours.iter().map(|c| c[0].max(c[1]).max(c[2])).filter(|&x| x > 0.0 && x.is_finite()).collect();
        if peaks.is_empty() {
            return Tone { exposure: 1.0 };
        }
        let k = peaks.len() * 95 / 100;
        let (_, &mut peak, _) = peaks.select_nth_unstable_by(k, f32::total_cmp);
        Tone { exposure: KEY / peak as f64 }
    }

    /// A colour for the screen.
    pub fn map(&self, rgb: [f32; 3]) -> [u8; 3] {
        rgb.map(|x| {
            let x = (x as f64 * self.exposure).clamp(0.0, 1.0);
            // The sRGB transfer curve (IEC 61966-2-1).
            let y = if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            (y * 255.0).round() as u8
        })
    }
}

impl std::fmt::Display for Tone {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "exposure {:.4}, sRGB curve, clipped", self.exposure)
    }
}

/// Whether [`write()`] knows what to do with a file of this name. Errors: [`Error::InvalidParam`].
pub fn check_name(path: &Path) -> Result<()> {
    match extension(path).as_str() {
        "exr" | "png" => Ok(()),
        _ => Err(Error::InvalidParam {
            name: "picture",
            value: path.display().to_string(),
            range: "name it .exr (linear radiance) or .png (tone-mapped)",
        }),
    }
}

/// Writes a picture as its name's extension says. A PNG's tone curve is returned, for telling.
///
/// `exposure` is for PNG; `None` chooses one that shows most of the picture.
/// Errors: [`Error::InvalidParam`] for another extension, [`Error::NotFinite`], [`Error::Write`].
pub fn write(path: &Path, image: &Image, exposure: Option<f64>) -> Result<Option<Tone>> {
    check_name(path)?;
    if !image.rgb.as_flattened().iter().all(|x| x.is_finite()) {
        return Err(Error::NotFinite { what: format!("a pixel of {}", path.display()) });
    }
    if extension(path) == "exr" {
        atomic::write(path, &exr(image).map_err(|e| failed(path, e))?)?;
        return Ok(None);
    }
    let tone = exposure.map_or_else(|| Tone::auto(&image.rgb), |exposure| Tone { exposure });
    let pixels: Vec<u8> = image.rgb.iter().flat_map(|&c| tone.map(c)).collect();
    let mut bytes = Cursor::new(Vec::new());
    ::image::write_buffer_with_format(
        &mut bytes,
        &pixels,
        image.width,
        image.height,
        ::image::ExtendedColorType::Rgb8,
        ::image::ImageFormat::Png,
    )
    .map_err(|e| failed(path, e))?;
    atomic::write(path, bytes.get_ref())?;
    Ok(Some(tone))
}

fn exr(image: &Image) -> std::result::Result<Vec<u8>, exr::error::Error> {
    use exr::prelude::*;
    let width = image.width as usize;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = image.rgb[at.y() * width + at.x()];
        (r, g, b)
    });
    let mut file = exr::prelude::Image::from_channels((width, image.height as usize), channels);
    file.attributes.chromaticities = Some(attribute::Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    file.layer_data.attributes.software_name = Text::new_or_none("raycell");
    file.layer_data.attributes.comments = Text::new_or_none("linear radiance, W/m2/sr, Rec.709");
    let mut bytes = Cursor::new(Vec::new());
    file.write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn failed(path: &Path, e: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::Write { path: path.into(), source: std::io::Error::other(e) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Image {
        Image { width: 3, height: 2, rgb: (0..6).map(|i| [i as f32 * 0.1, 0.5, 1e-3 * i as f32]).collect() }
    }

    #[test]
    fn exr_keeps_every_bit() {
        use exr::prelude::*;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.EXR");
        assert_eq!(super::write(&path, &picture(), None).unwrap(), None);
        let image = read_first_flat_layer_from_file(&path).unwrap();
        assert!(image.attributes.chromaticities.is_some());
        let names: Vec<String> = image.layer_data.channel_data.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R"]);
        let red: Vec<f32> = image.layer_data.channel_data.list[2].sample_data.values_as_f32().collect();
        assert_eq!(red, picture().rgb.iter().map(|c| c[0]).collect::<Vec<_>>());
    }

    #[test]
    fn png_is_exposed_and_curved() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let tone = write(&path, &picture(), Some(2.0)).unwrap().unwrap();
        assert_eq!(tone.to_string(), "exposure 2.0000, sRGB curve, clipped");
        let back = ::image::open(&path).unwrap().to_rgb8();
        assert_eq!(back.dimensions(), (3, 2));
        assert_eq!(back.get_pixel(0, 0).0, [0, 255, 0]);
        assert_eq!(back.get_pixel(1, 0).0[0], 124); // 0.2 linear
        assert_eq!(Tone::auto(&[[0.0; 3]; 4]).exposure, 1.0);
        assert!((Tone::auto(&picture().rgb).exposure - 1.6).abs() < 1e-6);
    }

    #[test]
    fn bad_pictures_are_refused() {
        let mut image = picture();
        assert!(matches!(write(Path::new("a.gif"), &image, None), Err(Error::InvalidParam { .. })));
        assert!(matches!(write(Path::new("gone/a.png"), &image, None), Err(Error::Write { .. })));
        image.rgb[1][1] = f32::NAN;
        assert!(matches!(write(Path::new("gone/a.png"), &image, None), Err(Error::NotFinite { .. })));
    }
}
