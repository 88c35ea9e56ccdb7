//! The plain-Rust twin of each GPU pass: slow, readable, and the oracle that tests hold the kernels against.

pub mod emit;
pub mod math;
pub mod sobol;
pub mod trace;
