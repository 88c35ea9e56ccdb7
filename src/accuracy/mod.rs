//! How wrong a result is, and what it costs to be less so.
//!
//! `estimate` says how wrong without a truth, and `ladder` climbs until that is little enough. `reference` makes truths by
//! path tracing, `truth` is their file, `norms` measures answers by them.

pub(crate) mod estimate;
mod ladder;
#[doc(hidden)]
pub mod norms;
#[doc(hidden)]
pub mod reference;
#[doc(hidden)]
pub mod truth;

pub use ladder::{Climb, Goal, climb};
