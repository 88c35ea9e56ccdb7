//! What a bake tells its caller, and what the caller answers. The library itself never prints.

/// Something worth telling while a bake runs.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A stage begins: "bvh", "train", "coefficients", "solve", "direct", "readout".
    Stage {
        /// Its name, as in the report's `seconds`.
        name: &'static str,
    },
    /// Light rays shot so far in this stage.
    Rays {
        /// Rays shot.
        done: u64,
        /// Rays the stage will shoot.
        total: u64,
    },
    /// The network has grown.
    Cells {
        /// Cells now.
        count: u64,
    },
    /// A Jacobi sweep has ended.
    Sweep {
        /// Sweeps so far.
        n: u32,
        /// Relative residual.
        residual: f64,
    },
    /// Something odd that does not stop the bake; also in the report's `warnings`.
    Warning(String),
}

/// The caller's answer to an [`Event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Stop as soon as possible; the call ends with [`crate::Error::Cancelled`].
    Stop,
}
