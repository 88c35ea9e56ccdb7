//! Textures: images whose texels vary a material over a surface, and their texture coordinates.
//!
//! Coordinates are u to the right and v down from the upper left corner of the image, whose rows are stored from the top
//! (glTF's convention; an OBJ's v is turned by its reader). An image repeats unless it is clamped to its edge.

use crate::error::{Error, Result};
use std::io::Cursor;
use std::sync::OnceLock;

/// Most texels along a side of an image.
pub const MOST_TEXELS: u32 = 16_384;
/// Most repeats of an image that a coordinate may name.
pub const MOST_REPEATS: f64 = 65_536.0;
/// Texels that a byte of a compressed image may stand for; one that claims more is cut off, or a bomb.
const TEXELS_A_BYTE: u64 = 16_384;
/// Alpha from which on a cut-out is there, where its file does not say.
pub const CUTOFF: f64 = 0.5;

/// An image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Name or path, for messages.
    pub name: String,
    /// Texels in a row, up to 16,384.
    pub width: u32,
    /// Rows, up to 16,384.
    pub height: u32,
    /// Its texels, rows from the top: `width * height`.
    pub texels: Texels,
}

/// Texels as their file has them, red, green, blue and alpha; alpha is linear in all.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Colours of eight bits in sRGB (IEC 61966-2-1).
    Srgb(Vec<[u8; 4]>),
    /// Numbers of eight bits, linear: 255 is 1.
    Linear(Vec<[u8; 4]>),
    /// Linear floats.
    Float(Vec<[f32; 4]>),
}

/// How the numbers of an image of integers are meant; floats are linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Meaning {
    /// Colours in sRGB.
    Colour,
    /// A channel of coverage, linear: it becomes the alpha.
    Alpha(Channel),
}

/// What of an image a cut-out reads (MTL `-imfchan`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Channel {
    /// Alpha where the image has one, else the mean of the colours.
    Any,
    Red,
    Green,
    Blue,
    Alpha,
    Luminance,
}

/// A texture on a material: which one, and how its coordinates are made from the surface's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// Index into [`super::Scene::textures`].
    pub texture: u32,
    /// Rows of the affine matrix that takes a surface's (u, v, 1) to the image's u and v.
    pub transform: [[f64; 3]; 2],
    /// Whether the image is clamped to its edge along u and v; else it repeats.
    pub clamp: [bool; 2],
}

impl Map {
    /// A texture as the surface's coordinates have it, repeated.
    pub fn new(texture: u32) -> Map {
        Map { texture, transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], clamp: [false; 2] }
    }

    /// Image coordinates of a surface's.
    pub(crate) fn place(&self, uv: [f64; 2]) -> [f64; 2] {
        self.transform.map(|[a, b, c]| a * uv[0] + b * uv[1] + c)
    }
}

/// Checks that an image can be looked up at a coordinate. Errors: [`Error::InvalidTexture`].
pub(crate) fn check_uv(uv: &[f64; 2], place: impl Fn() -> String) -> Result<()> {
    if uv.iter().all(|x| x.abs() <= MOST_REPEATS) {
        return Ok(());
    }
    let what = format!("is {uv:?}, beyond 65536 repeats");
    Err(Error::InvalidTexture { place: place(), what, cure: "unwrap the mesh anew" })
}

/// The linear value of an eight-bit sRGB one.
pub(crate) fn srgb8(x: u8) -> f32 {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|i| srgb(i as f64 / 255.0) as f32))[x as usize]
}

/// sRGB's transfer function on [0, 1].
pub(crate) fn srgb(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

impl Texture {
    /// Decodes an image file: PNG, JPEG, TGA, BMP, Radiance HDR or OpenEXR. What is wrong is told in words.
    pub(crate) fn decode(name: &str, bytes: &[u8], meaning: Meaning) -> std::result::Result<Texture, String> {
        let said = |e: image::ImageError| e.to_string();
        let open = || {
            let mut reader = image::ImageReader::new(Cursor::new(bytes));
            // The name decides only where the bytes do not tell (TGA).
            if let Ok(format) = image::ImageFormat::from_path(name) {
                reader.set_format(format);
            }
            reader.with_guessed_format()
        };
        let (width, height) = open().map_err(|e| e.to_string())?.into_dimensions().map_err(said)?;
        if width == 0 || height == 0 {
            return Err("it has no texels".into());
        }
        if width > MOST_TEXELS || height > MOST_TEXELS {
            return Err(format!("it has {width} x {height} texels, and no side may have more than {MOST_TEXELS}"));
        }
        if u64::from(width) * u64::from(height) > TEXELS_A_BYTE * bytes.len() as u64 {
            return Err(format!("it is truncated: {} bytes cannot hold {width} x {height} texels", bytes.len()));
        }
        let mut reader = open().map_err(|e| e.to_string())?;
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(64 * u64::from(width) * u64::from(height) + (64 << 20));
        reader.limits(limits);
        let image = reader.decode().map_err(said)?;
        let alpha = image.color().has_alpha();
        let float = matches!(image.color(), image::ColorType::Rgb32F | image::ColorType::Rgba32F);
        let wide = float || image.color().bytes_per_pixel() > image.color().channel_count();
        let texels = match meaning {
            Meaning::Colour if float => Texels::Float(image.into_rgba32f().pixels().map(|p| p.0).collect()),
            // Sixteen bits.
            Meaning::Colour if wide => Texels::Float(
                (image.into_rgba32f().pixels())
                    .map(|p| [0, 1, 2, 3].map(|k| if k < 3 { srgb(f64::from(p.0[k])) as f32 } else { p.0[3] }))
                    .collect(),
            ),
            Meaning::Colour => Texels::Srgb(image.into_rgba8().pixels().map(|p| p.0).collect()),
            Meaning::Alpha(channel) => {
                let pick = |[r, g, b, a]: [f32; 4]| match channel {
                    Channel::Any if alpha => a,
                    Channel::Any => (r + g + b) / 3.0,
                    Channel::Red => r,
                    Channel::Green => g,
                    Channel::Blue => b,
                    Channel::Alpha => a,
                    Channel::Luminance => 0.2126 * r + 0.7152 * g + 0.0722 * b,
                };
                match wide {
                    true => Texels::Float(image.into_rgba32f().pixels().map(|p| [pick(p.0); 4]).collect()),
                    false => Texels::Linear(
                        (image.into_rgba8().pixels())
                            .map(|p| [pick(p.0.map(f32::from)).round().clamp(0.0, 255.0) as u8; 4])
                            .collect(),
                    ),
                }
            }
        };
        Ok(Texture { name: name.into(), width, height, texels })
    }

    /// Checks that it can be used: 1 to 16,384 texels a side, as many as there are, finite and not negative.
    ///
    /// Errors: [`Error::InvalidTexture`].
    pub fn check(&self) -> Result<()> {
        let fail = |what: String, cure| Err(Error::InvalidTexture { place: format!("texture '{}'", self.name), what, cure });
        let (w, h) = (self.width, self.height);
        if w == 0 || h == 0 || w > MOST_TEXELS || h > MOST_TEXELS {
            return fail(format!("has {w} x {h} texels"), "give 1 to 16384 a side");
        }
        let (count, need) = (self.len(), w as usize * h as usize);
        if count != need {
            return fail(format!("holds {count} texels where {w} x {h} are {need}"), "give width times height of them");
        }
        if let Texels::Float(texels) = &self.texels
            && let Some(i) = texels.iter().position(|t| t.iter().any(|x| !(x.is_finite() && *x >= 0.0)))
        {
            let what = format!("holds {:?} at column {}, row {}", texels[i], i % w as usize, i / w as usize);
            return fail(what, "give finite numbers of 0 and above");
        }
        Ok(())
    }

    fn len(&self) -> usize {
        match &self.texels {
            Texels::Srgb(t) | Texels::Linear(t) => t.len(),
            Texels::Float(t) => t.len(),
        }
    }

    /// A texel, linear: column `x`, row `y` from the top.
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let i = y as usize * self.width as usize + x as usize;
        let part = |x: u8| f32::from(x) / 255.0;
        match &self.texels {
            Texels::Srgb(t) => [srgb8(t[i][0]), srgb8(t[i][1]), srgb8(t[i][2]), part(t[i][3])],
            Texels::Linear(t) => t[i].map(part),
            Texels::Float(t) => t[i],
        }
    }

    /// The largest of each band.
    pub(crate) fn most(&self) -> [f32; 3] {
        let mut most = [0.0f32; 3];
        for y in 0..self.height {
            for x in 0..self.width {
                let t = self.texel(x, y);
                most = [0, 1, 2].map(|k| most[k].max(t[k]));
            }
        }
        most
    }

    /// Whether the bands of every texel are one.
    pub(crate) fn is_grey(&self) -> bool {
        let grey = |[r, g, b, _]: [f32; 4]| r == g && g == b;
        match &self.texels {
            Texels::Srgb(t) | Texels::Linear(t) => t.iter().all(|&[r, g, b, _]| r == g && g == b),
            Texels::Float(t) => t.iter().all(|&t| grey(t)),
        }
    }

    /// The same with the mean of the bands in each.
    pub(crate) fn in_grey(&self) -> Texture {
        let texel = |i: u32| {
            let [r, g, b, a] = self.texel(i % self.width, i / self.width);
            let mean = (r + g + b) / 3.0;
            [mean, mean, mean, a]
        };
        let texels = Texels::Float((0..self.width * self.height).map(texel).collect());
        Texture { name: self.name.clone(), width: self.width, height: self.height, texels }
    }

    /// The mean of each band.
    pub(crate) fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for y in 0..self.height {
            for x in 0..self.width {
                let t = self.texel(x, y);
                sum = [0, 1, 2].map(|k| sum[k] + f64::from(t[k]));
            }
        }
        sum.map(|s| s / (f64::from(self.width) * f64::from(self.height)))
    }

    /// The value at image coordinates, between the four texels around (bilinear), in f64.
    pub(crate) fn at(&self, map: &Map, [u, v]: [f64; 2]) -> [f64; 3] {
        let side = |x: f64, n: u32, clamp: bool| {
            let x = x * f64::from(n) - 0.5;
            let low = x.floor();
            let wrap = |i: f64| {
                let n = f64::from(n);
                (if clamp { i.clamp(0.0, n - 1.0) } else { i.rem_euclid(n) }) as u32
            };
            ([wrap(low), wrap(low + 1.0)], x - low)
        };
        let ([x0, x1], a) = side(u, self.width, map.clamp[0]);
        let ([y0, y1], b) = side(v, self.height, map.clamp[1]);
        let t = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| self.texel(x, y));
        [0, 1, 2].map(|k| {
            let [p, q, r, s] = t.map(|t| f64::from(t[k]));
            (p * (1.0 - a) + q * a) * (1.0 - b) + (r * (1.0 - a) + s * a) * b
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_made_linear_and_numbers_are_not() {
        let png = |pixels: &[u8], w: u32, h: u32| {
            let mut out = Vec::new();
            let image = image::RgbImage::from_raw(w, h, pixels.to_vec()).unwrap();
            image.write_to(&mut Cursor::new(&mut out), image::ImageFormat::Png).unwrap();
            out
        };
        let file = png(&[0, 128, 255, 10, 188, 1], 2, 1);
        let colour = Texture::decode("a.png", &file, Meaning::Colour).unwrap();
        // IEC 61966-2-1, in f64.
        let want = |x: u8| {
            let x = f64::from(x) / 255.0;
            (if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
        };
        assert_eq!(colour.texel(0, 0), [0.0, want(128), 1.0, 1.0]);
        assert_eq!(colour.texel(1, 0), [want(10), want(188), want(1), 1.0]);
        let numbers = Texture::decode("a.png", &file, Meaning::Alpha(Channel::Green)).unwrap();
        assert_eq!([numbers.texel(0, 0)[3], numbers.texel(1, 0)[3]], [128.0 / 255.0, 188.0 / 255.0]);
        let mean = Texture::decode("a.png", &file, Meaning::Alpha(Channel::Any)).unwrap();
        assert_eq!(mean.texel(0, 0)[3], 128.0 / 255.0);
        // Cut off, and none at all.
        assert!(Texture::decode("a.png", &file[..file.len() / 2], Meaning::Colour).is_err());
        assert!(Texture::decode("a.png", b"", Meaning::Colour).is_err());
        assert!(Texture::decode("a.png", b"no image", Meaning::Colour).is_err());
    }

    #[test]
    fn floats_are_linear() {
        let mut out = Vec::new();
        let image = image::Rgb32FImage::from_raw(1, 1, vec![0.25, 3.5, 0.0]).unwrap();
        image::DynamicImage::from(image).write_to(&mut Cursor::new(&mut out), image::ImageFormat::OpenExr).unwrap();
        let t = Texture::decode("a.exr", &out, Meaning::Colour).unwrap();
        assert_eq!(t.texel(0, 0), [0.25, 3.5, 0.0, 1.0]);
        assert_eq!(t.most(), [0.25, 3.5, 0.0]);
    }

    #[test]
    fn values_lie_between_texels_and_wrap() {
        let t = Texture {
            name: "t".into(),
            width: 2,
            height: 1,
            texels: Texels::Float(vec![[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 1.0, 1.0]]),
        };
        let (repeated, clamped) = (Map::new(0), Map { clamp: [true; 2], ..Map::new(0) });
        for (u, wrapped, edged) in
            [(0.25, 0.0, 0.0), (0.5, 0.5, 0.5), (0.75, 1.0, 1.0), (0.0, 0.5, 0.0), (1.0, 0.5, 1.0), (-0.75, 0.0, 0.0)]
        {
            assert_eq!(t.at(&repeated, [u, 0.3]), [wrapped, 0.0, 1.0], "{u}");
            assert_eq!(t.at(&clamped, [u, 0.3]), [edged, 0.0, 1.0], "{u}");
        }
    }

    #[test]
    fn sick_textures_are_named() {
        let good = Texture { name: "t".into(), width: 1, height: 1, texels: Texels::Float(vec![[0.5; 4]]) };
        good.check().unwrap();
        for (bad, part) in [
            (Texture { width: 0, ..good.clone() }, "has 0 x 1 texels"),
            (Texture { height: 20_000, ..good.clone() }, "has 1 x 20000 texels"),
            (Texture { width: 2, ..good.clone() }, "holds 1 texels where 2 x 1 are 2"),
            (Texture { texels: Texels::Float(vec![[f32::NAN; 4]]), ..good.clone() }, "NaN"),
            (Texture { texels: Texels::Float(vec![[-1.0; 4]]), ..good.clone() }, "-1.0"),
        ] {
            let said = bad.check().unwrap_err().to_string();
            assert!(said.contains("texture 't'") && said.contains(part), "{said}");
        }
    }
}
