//! Sums that do not depend on their order (`wgsl/lib/fixed.wgsl`): 64-bit fixed point as two u32 with
//! carry (design §1, step 9).
//!
//! | sum | unit | bound of the sum | in units |
//! |---|---|---|---|
//! | features, distortion | 2^-32 | 64 a ray, 2^24 rays | 2^62 |
//! | weights w, normalised so that all rays together weigh at most 1 | 2^-58 | 1 | 2^58 |
//! | first moments w (y - p), in local lengths | 2^-58 | 2 sqrt 3 | 2^60 |
//! | second moments | 2^-58 | 12 | 2^62 |
//! | sources w s, s at most the brightest emission (1) times a sampling weight | 2^-58 | 16 | 2^62 |

use crate::layout::{Fixed, NodeSource};

/// Units of features and distortions.
pub const FEATURE_UNIT: f32 = 4294967296.0;
/// Units of normalised weights and what they multiply.
pub const UNIT: f32 = 288230376151711744.0; // 2^58

/// `value * unit` truncated toward zero, exactly: `unit` is a power of two, and the kernel splits the
/// same number into words without rounding.
pub fn encode(value: f32, unit: f32) -> i64 {
    (value as f64 * unit as f64) as i64
}

impl NodeSource {
    /// Adds another's sums.
    pub fn add(&mut self, other: &NodeSource) {
        for k in 0..3 {
            self.value[k].add(other.value[k].units());
            self.first[k].add(other.first[k].units());
            self.second[k].add(other.second[k].units());
        }
    }
}

impl Fixed {
    /// Adds a number of units.
    pub fn add(&mut self, units: i64) {
        *self = Fixed::from_units(self.units().wrapping_add(units));
    }

    /// The sum as a number of units.
    pub fn units(self) -> i64 {
        ((self.hi as u64) << 32 | self.lo as u64) as i64
    }

    /// From a number of units.
    pub fn from_units(units: i64) -> Fixed {
        Fixed { lo: units as u32, hi: (units as u64 >> 32) as u32 }
    }

    /// The sum as a number.
    pub fn value(self, unit: f32) -> f64 {
        self.units() as f64 / unit as f64
    }
}
