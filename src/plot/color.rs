//! Colours: one map for values, whose brightness rises evenly so that it prints in grey, and a few for lines.

use plotters::style::RGBColor;

/// Text and axes.
pub const INK: RGBColor = RGBColor(34, 34, 34);
/// What is there to be compared with.
pub const GREY: RGBColor = RGBColor(140, 140, 140);
/// Paper.
pub const PAPER: RGBColor = RGBColor(255, 255, 255);
/// Colours of lines and dots, of different brightness each (after Okabe and Ito, 2008).
pub const SERIES: [RGBColor; 6] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// What values look like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// The value of the darkest colour.
    pub low: f64,
    /// The value of the brightest colour.
    pub high: f64,
}

/// Nine colours of viridis (van der Walt and Smith, 2015, CC0).
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];

impl Map {
    /// From 0 to the largest of the values.
    pub fn upto(peak: f64) -> Map {
        Map { low: 0.0, high: if peak > 0.0 { peak } else { 1.0 } }
    }

    /// The colour of a value; ends stand for all beyond.
    pub fn of(&self, value: f64) -> RGBColor {
        let x = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
        let i = (x as usize).min(VIRIDIS.len() - 2);
        let c: [u8; 3] = std::array::from_fn(|k| {
            let (a, b) = (VIRIDIS[i][k], VIRIDIS[i + 1][k]);
            (a + (b - a) * (x - i as f64)).round() as u8
        });
        RGBColor(c[0], c[1], c[2])
    }
}

/// What is too little or too much, from -1 (blue) over 0 (white) to 1 (red); ends stand for all beyond.
pub fn signed(x: f64) -> RGBColor {
    let to = if x < 0.0 { SERIES[1] } else { SERIES[0] };
    shade(to, 1.0 - x.abs().min(1.0))
}

/// A colour nearer to white (`share` above 0) or black (below).
pub fn shade(c: RGBColor, share: f64) -> RGBColor {
    let to = if share > 0.0 { 255.0 } else { 0.0 };
    let mix = |x: u8| (x as f64 + (to - x as f64) * share.abs()).round() as u8;
    RGBColor(mix(c.0), mix(c.1), mix(c.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_with_the_value() {
        let map = Map { low: -1.0, high: 3.0 };
        let grey = |v: f64| {
            let c = map.of(v);
            0.2126 * c.0 as f64 + 0.7152 * c.1 as f64 + 0.0722 * c.2 as f64
        };
        let greys: Vec<f64> = (0..=64).map(|i| grey(-1.0 + i as f64 / 16.0)).collect();
        assert!(greys.windows(2).all(|w| w[1] > w[0]), "{greys:?}");
        assert_eq!((map.of(-9.0), map.of(9.0)), (map.of(-1.0), map.of(3.0)));
    }
}
