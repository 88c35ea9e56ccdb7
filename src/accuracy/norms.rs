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
    /// Measures radiosities, one a point of the truth; each counts by what of the surface it stands for.
    pub fn new(b: &[[f64; 3]], truth: &Truth) -> Errors {
        assert_eq!(b.len(), truth.b.len(), "one answer a point");
        let off = |i: usize| [0, 1, 2].map(|k| (b[i][k] - truth.b[i][k]).powi(2));
        let with_noise = truth.over(off).sqrt() / truth.mean();
        let noise = truth.noise();
        let mut relative: Vec<(f64, f64)> = (0..b.len())
            .filter(|&i| truth.flags[i] == Flag::Good && band_sum(truth.b[i]) > 0.0)
            .map(|i| ((band_sum(b[i]) / band_sum(truth.b[i]) - 1.0).abs(), truth.weight(i)))
            .collect();
        relative.sort_by(|x, y| x.0.total_cmp(&y.0));
        let all: f64 = relative.iter().map(|r| r.1).sum();
        let quantile = |q: f64| {
            let mut below = 0.0;
            let at = relative.iter().find(|r| {
                below += r.1;
                below > q * all
            });
            at.map_or(f64::NAN, |r| r.0)
        };
        Errors {
            rrmse: (with_noise.powi(2) - noise.powi(2)).max(0.0).sqrt(),
            with_noise,
            noise,
            trimmed: trimmed(b, truth, 0.01),
            median: quantile(0.5),
            p90: quantile(0.9),
            bias: truth.over(|i| b[i]) / truth.mean() - 1.0,
        }
    }
}

fn band_sum(b: [f64; 3]) -> f64 {
    b.iter().sum()
}

/// sqrt(mean (B - B*)²)/mean(B*), without the points that are farthest off: a `share` of the surface.
fn trimmed(b: &[[f64; 3]], truth: &Truth, share: f64) -> f64 {
    let square = |i: usize| (0..3).map(|k| (b[i][k] - truth.b[i][k]).powi(2)).sum::<f64>();
    let mut order: Vec<(f64, usize)> = (0..b.len()).map(|i| (square(i), i)).collect();
    order.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut left = share * order.iter().map(|o| truth.weight(o.1)).sum::<f64>() * (1.0 + 1e-9);
    while let Some(&(_, worst)) = order.last().filter(|o| truth.weight(o.1) <= left) {
        left -= truth.weight(worst);
        order.pop();
    }
    let over = |of: &dyn Fn(&(f64, usize)) -> f64| order.iter().map(|o| truth.weight(o.1) * of(o)).sum::<f64>();
    let n = 3.0 * over(&|_| 1.0);
    (over(&|o| o.0) / n).sqrt() / (over(&|o| band_sum(truth.b[o.1])) / n)
}

/// sqrt(mean (B - B*)²)/mean(B*) over points that stand for as much each, and bands.
pub fn rrmse(b: &[[f64; 3]], truth: &[[f64; 3]]) -> f64 {
    let square: f64 = b.iter().flatten().zip(truth.iter().flatten()).map(|(b, truth)| (b - truth).powi(2)).sum();
    let n = (3 * truth.len()) as f64;
    (square / n).sqrt() / (truth.iter().flatten().sum::<f64>() / n)
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
            weights: Vec::new(),
        };
        // Two points are 50 % off, the others 5 %, half of them up.
        let b: Vec<[f64; 3]> = (0..n).map(|i| [2.0 * if i < 2 { 1.5 } else { 1.05 - 0.1 * (i % 2) as f64 }; 3]).collect();
        let e = Errors::new(&b, &truth);
        let square = (198.0 * 0.05f64.powi(2) + 2.0 * 0.5f64.powi(2)) / 200.0;
        assert!((e.with_noise - square.sqrt()).abs() < 1e-12);
        assert!((e.noise - 0.03).abs() < 1e-12 && (e.rrmse - (square - 0.0009).sqrt()).abs() < 1e-12, "{e:?}");
        assert!((e.trimmed - 0.05).abs() < 1e-12 && (e.median - 0.05).abs() < 1e-12 && (e.p90 - 0.05).abs() < 1e-12);
        assert!((e.bias - 0.005).abs() < 1e-12, "{e:?}");
        // The two stand for twice as much: as if there were four.
        let weights = (0..n).map(|i| if i < 2 { 2.0 } else { 1.0 }).collect();
        let weighted = Errors::new(&b, &Truth { weights, ..truth.clone() });
        let square = (198.0 * 0.05f64.powi(2) + 4.0 * 0.5f64.powi(2)) / 202.0;
        assert!((weighted.with_noise - square.sqrt()).abs() < 1e-12, "{weighted:?}");
        assert!((weighted.bias - (2.0 * 0.5 * 2.0 + 0.0) / 202.0).abs() < 1e-12, "{weighted:?}");
        // Two of 202 are less than a hundredth: one of them stays.
        assert!(weighted.trimmed > 0.05 && weighted.median == e.median, "{weighted:?}");
        // What is below the truth's own noise is 0, not a guess.
        assert_eq!(Errors::new(&truth.b, &truth).rrmse, 0.0);
    }
}
