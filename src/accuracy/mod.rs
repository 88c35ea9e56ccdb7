//! How wrong a result is, and what it costs to be less so.
//!
//! `reference` makes truths by path tracing, `truth` is their file, `norms` measures answers by them,
//! `sweep` does so along a ladder of settings of every method.

pub mod norms;
pub mod reference;
#[cfg(feature = "cli")]
pub mod sweep;
pub mod truth;
