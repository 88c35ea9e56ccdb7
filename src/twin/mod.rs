//! The plain-Rust twin of each GPU pass: slow, readable, and the oracle that tests hold the kernels against.

pub mod accumulate;
pub mod adapt;
pub mod assign;
pub mod coefficients;
pub mod deposit;
pub mod direct;
pub mod emit;
pub mod engine;
pub mod fixed;
pub mod gather;
pub mod jacobi;
pub mod kernel;
pub mod lights;
pub mod math;
pub mod readout;
pub mod respond;
pub mod shoot;
pub mod sky;
pub mod sobol;
pub mod texture;
pub mod trace;
pub mod way;
pub mod winner;

pub use engine::TwinEngine;
