//! A straight line through error against cost, both in logarithms: error = c cost^-p.

/// The line, and how far the runs lie off it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The exponent p: halving the error costs 2^(1/p) times as much.
    pub exponent: f64,
    /// Standard error of the exponent.
    pub exponent_error: f64,
    /// Least and greatest cost that was measured.
    pub costs: [f64; 2],
    /// Their greatest and least errors by the line.
    pub errors: [f64; 2],
    /// Standard deviation of the runs about the line, in ln(error).
    pub scatter: f64,
    n: f64,
    mean: [f64; 2],
    sxx: f64,
}

/// What a given error is foreseen to cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Most likely.
    pub cost: f64,
    /// Lower end of an interval that a further run lies in nine times of ten, by the scatter of those made.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Whether nothing near it was measured: cheaper or dearer than all runs.
    pub beyond: bool,
}

/// Student's t, 95th percentile: a tenth of all lies beyond it, both sides taken together.
fn student(freedom: usize) -> f64 {
    const T: [f64; 12] = [6.314, 2.920, 2.353, 2.132, 2.015, 1.943, 1.895, 1.860, 1.833, 1.812, 1.796, 1.782];
    T.get(freedom.wrapping_sub(1)).copied().unwrap_or(if freedom == 0 { f64::INFINITY } else { 1.645 + 1.6 / freedom as f64 })
}

impl Fit {
    /// Least squares over (cost, error) of single runs. None where fewer than three costs differ, or errors are not
    /// positive.
    pub fn new(runs: &[[f64; 2]]) -> Option<Fit> {
        let logs: Vec<[f64; 2]> = runs.iter().filter(|r| r[0] > 0.0 && r[1] > 0.0).map(|r| r.map(f64::ln)).collect();
        let n = logs.len() as f64;
        let mean = [0, 1].map(|k| logs.iter().map(|l| l[k]).sum::<f64>() / n);
        let sum = |a: usize, b: usize| logs.iter().map(|l| (l[a] - mean[a]) * (l[b] - mean[b])).sum::<f64>();
        let (sxx, sxy, syy) = (sum(0, 0), sum(0, 1), sum(1, 1));
        let mut costs: Vec<f64> = logs.iter().map(|l| l[0]).collect();
        costs.sort_by(f64::total_cmp);
        // Runs of a setting cost nearly the same.
        let steps = costs.windows(2).filter(|w| w[1] - w[0] > 0.1).count();
        if logs.len() < 3 || steps < 2 || sxx <= 0.0 {
            return None;
        }
        let slope = sxy / sxx;
        let scatter = ((syy - slope * sxy).max(0.0) / (n - 2.0)).sqrt();
        let ends = [costs[0], costs[costs.len() - 1]];
        Some(Fit {
            exponent: -slope,
            exponent_error: scatter / sxx.sqrt(),
            costs: ends.map(f64::exp),
            errors: ends.map(|x| (mean[1] + slope * (x - mean[0])).exp()),
            scatter,
            n,
            mean,
            sxx,
        })
    }

    /// Whether the error falls with the cost at all, more surely than nineteen to one.
    pub fn falls(&self) -> bool {
        self.exponent > self.exponent_error * student(self.n as usize - 2) && self.exponent > 0.01
    }

    /// The error that the line gives for a cost.
    pub fn error_at(&self, cost: f64) -> f64 {
        (self.mean[1] - self.exponent * (cost.ln() - self.mean[0])).exp()
    }

    /// Times the cost that half the error takes; none where it does not fall.
    pub fn halving(&self) -> Option<f64> {
        self.falls().then(|| 2f64.powf(1.0 / self.exponent))
    }

    /// What an error costs; none where it does not fall.
    pub fn forecast(&self, error: f64) -> Option<Forecast> {
        if !self.falls() {
            return None;
        }
        let at = self.mean[0] + (self.mean[1] - error.ln()) / self.exponent;
        let spread = self.scatter * (1.0 + 1.0 / self.n + (at - self.mean[0]).powi(2) / self.sxx).sqrt();
        let off = student(self.n as usize - 2) * spread / self.exponent;
        let [first, last] = self.costs.map(f64::ln);
        let beyond = at < first - 0.2 || at > last + 0.2;
        Some(Forecast { cost: at.exp(), low: (at - off).exp(), high: (at + off).exp(), beyond })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_again() {
        let runs: Vec<[f64; 2]> = [1.0f64, 4.0, 16.0, 64.0].iter().map(|&t| [t, 0.08 * t.powf(-0.5)]).collect();
        let fit = Fit::new(&runs).unwrap();
        assert!((fit.exponent - 0.5).abs() < 1e-12 && fit.scatter < 1e-9, "{fit:?}");
        assert!((fit.halving().unwrap() - 4.0).abs() < 1e-9 && (fit.error_at(4.0) - 0.04).abs() < 1e-12);
        let f = fit.forecast(0.02).unwrap();
        assert!((f.cost - 16.0).abs() < 1e-9 && !f.beyond && f.low <= f.cost && f.high >= f.cost);
        let f = fit.forecast(0.001).unwrap();
        assert!(f.beyond && (f.cost - 6400.0).abs() < 1e-6);
    }

    #[test]
    fn scatter_widens_the_interval_and_no_slope_is_none() {
        let runs: Vec<[f64; 2]> =
            (0..8).map(|i| [4f64.powi(i / 2), 0.08 * 2f64.powi(-(i / 2)) * if i % 2 == 0 { 1.1 } else { 0.9 }]).collect();
        let fit = Fit::new(&runs).unwrap();
        let f = fit.forecast(0.02).unwrap();
        // t(6) * 0.116 * 1.1 / 0.5 = 0.49 in ln.
        assert!((fit.exponent - 0.5).abs() < 0.03 && (1.5..1.8).contains(&(f.high / f.cost)), "{fit:?} {f:?}");
        let flat: Vec<[f64; 2]> = runs.iter().map(|r| [r[0], 0.02 + 1e-4 * r[0].sin()]).collect();
        assert!(Fit::new(&flat).unwrap().forecast(0.01).is_none());
        assert!(Fit::new(&[[1.0, 0.1], [1.1, 0.09], [8.0, 0.02]]).is_none());
    }
}
