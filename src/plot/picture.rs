//! A picture as a panel.

use super::Fault;
use super::sheet::{Area, unit};
use image::RgbImage;
use image::imageops::{FilterType, resize};
use plotters::element::BitMapElement;

/// An RGB picture, rows from the top, as large as fits into the area.
pub fn picture(area: &Area, rgb: &[[u8; 3]], width: u32, height: u32) -> Result<(), Fault> {
    let (w, h) = area.dim_in_pixel();
    let (w, h) = (w as f64 - 2.0 * unit(6.0) as f64, h as f64 - 2.0 * unit(6.0) as f64);
    let scale = (w / width as f64).min(h / height as f64);
    let (across, down) = ((width as f64 * scale) as u32, (height as f64 * scale) as u32);
    let at = (unit(6.0) + ((w - across as f64) / 2.0) as i32, unit(6.0) + ((h - down as f64) / 2.0) as i32);
    let small = RgbImage::from_raw(width, height, rgb.as_flattened().to_vec()).ok_or("a picture of another size")?;
    let bytes = resize(&small, across, down, FilterType::Triangle).into_raw();
    let image: BitMapElement<_> = BitMapElement::with_owned_buffer(at, (across, down), bytes).ok_or("a picture of no size")?;
    area.draw(&image)?;
    Ok(())
}
