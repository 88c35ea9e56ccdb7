//! How wrong a result is, and what it costs to be less so.
//!
//! `reference` makes truths by path tracing, `truth` is their file, `norms` measures answers by them.

pub mod norms;
pub mod reference;
pub mod truth;
