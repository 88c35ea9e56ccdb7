//! How far answers are from a truth: the measures that the sweep, the tests and the examples share.

use super::truth::{Flag, Truth};

/// The error of answers by a truth. Shares, not per cents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Root mean square over points and bands, over the truth's mean, the truth's own noise taken out:
    /// sqrt(mean((B - B*)²) - mean(stderr²)) / mean(B*).
    pub rrmse: f64,
    /// The same with the truth's noise left in.
    pub with_noise: f64,
    /// The truth's noise, sqrt(mean(stderr²))/mean(B*): an error of its size or below is not seen by this truth.
    pub noise: f64,
    /// `with_noise` without the worst 1 % of the points.
    pub trimmed: f64,
    /// Median over the good points of |B - B*|/B*, B the mean over the bands.
    pub median: f64,
    /// Their 90th percentile.
    pub p90: f64,
    /// Sum of all B over that of all B*, less 1.
    pub bias: f64,
}

impl Errors {
    /// Measures radiosities, one a point of the truth.
    pub fn new(b: &[[f64; 3]], truth: &Truth) -> Errors {
        assert_eq!(b.len(), truth.b.len(), "one answer a point");
        let with_noise = rrmse(b, &truth.b);
        let noise = truth.noise();
        let mut relative: Vec<f64> = (0..b.len())
            .filter(|&i| truth.flags[i] == Flag::Good && band_sum(truth.b[i]) > 0.0)
            .map(|i| (band_sum(b[i]) / band_sum(truth.b[i]) - 1.0).abs())
            .collect();
        relative.sort_by(f64::total_cmp);
        let quantile = |q: f64| relative.get((relative.len() as f64 * q) as usize).copied().unwrap_or(f64::NAN);
        let sum = |b: &[[f64; 3]]| b.iter().flatten().sum::<f64>();
        Errors {
            rrmse: (with_noise.powi(2) - noise.powi(2)).max(0.0).sqrt(),
            with_noise,
            noise,
            trimmed: rrmse_without(b, &truth.b, b.len() / 100),
            median: quantile(0.5),
            p90: quantile(0.9),
            bias: sum(b) / sum(&truth.b) - 1.0,
        }
    }
}

fn band_sum(b: [f64; 3]) -> f64 {
    b.iter().sum()
}

/// sqrt(mean (B - B*)²)/mean(B*) over points and bands, without the `drop` worst points.
pub fn rrmse_without(b: &[[f64; 3]], truth: &[[f64; 3]], drop: usize) -> f64 {
    let mut order: Vec<(f64, usize)> = (0..b.len()).map(|i| ((0..3).map(|k| (b[i][k] - truth[i][k]).powi(2)).sum(), i)).collect();
    order.sort_by(|x, y| x.0.total_cmp(&y.0));
    order.truncate(b.len() - drop);
    let n = 3.0 * order.len() as f64;
    let level = order.iter().map(|&(_, i)| truth[i].iter().sum::<f64>()).sum::<f64>() / n;
    (order.iter().map(|o| o.0).sum::<f64>() / n).sqrt() / level
}

/// As [`rrmse_without`], over all points.
pub fn rrmse(b: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    rrmse_without(b, truth, 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solution::SurfacePoint;

    #[test]
    fn the_measures_are_what_they_say() {
        let n = 200;
        let truth = Truth {
            points: vec![SurfacePoint { p: [0.0; 3], n: [0.0, 1.0, 0.0] }; n],
            b: vec![[2.0; 3]; n],
            stderr: vec![[0.06; 3]; n],
            flags: vec![Flag::Good; n],
        };
        // Two points are 50 % off, the others 5 %, half of them up.
        let b: Vec<[f64; 3]> = (0..n).map(|i| [2.0 * if i < 2 { 1.5 } else { 1.05 - 0.1 * (i % 2) as f64 }; 3]).collect();
        let e = Errors::new(&b, &truth);
        let square = (198.0 * 0.05f64.powi(2) + 2.0 * 0.5f64.powi(2)) / 200.0;
        assert!((e.with_noise - square.sqrt()).abs() < 1e-12);
        assert!((e.noise - 0.03).abs() < 1e-12 && (e.rrmse - (square - 0.0009).sqrt()).abs() < 1e-12, "{e:?}");
        assert!((e.trimmed - 0.05).abs() < 1e-12 && (e.median - 0.05).abs() < 1e-12 && (e.p90 - 0.05).abs() < 1e-12);
        assert!((e.bias - 0.005).abs() < 1e-12, "{e:?}");
        // What is below the truth's own noise is 0, not a guess.
        assert_eq!(Errors::new(&truth.b, &truth).rrmse, 0.0);
    }
}
