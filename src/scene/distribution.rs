//! Fixed-point distributions, as the passes invert them (hard case B13: f32 prefix sums lose small weights).

/// The fixed-point cumulative distribution of weights, in 2^-32: the upper end of each one's interval.
/// The last positive one, and whatever follows, ends at `u32::MAX`, so that rounding loses none.
pub fn cumulative(weights: &[f64]) -> Vec<u32> {
    let total: f64 = weights.iter().sum();
    let last = weights.iter().rposition(|&w| w > 0.0).unwrap_or(0);
    let mut sum = 0.0;
    let end = |(i, w): (usize, &f64)| {
        sum += w;
        if i >= last { u32::MAX } else { (sum / total * 4294967296.0).min(4294967295.0) as u32 }
    };
    weights.iter().enumerate().map(end).collect()
}
