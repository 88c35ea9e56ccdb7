//! How wrong a result is, and what it costs to be less so.
//!
//! `estimate` says how wrong without a truth, and `ladder` climbs until that is little enough. `reference` makes truths by
//! path tracing, `truth` is their file, `norms` measures answers by them, `sweep` does so along a ladder of settings of
//! every method.

pub(crate) mod estimate;
mod ladder;
#[doc(hidden)]
pub mod norms;
#[doc(hidden)]
pub mod reference;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod sweep;
#[doc(hidden)]
pub mod truth;

pub use ladder::{Climb, Goal, climb};
