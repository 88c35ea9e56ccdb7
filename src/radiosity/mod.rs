//! From the cells' footprints, or from patches, to a linear system, and its solution.

pub mod coefficients;
pub mod components;
pub mod energy;
pub mod gauss_seidel;
pub mod learned;
pub mod patches;
pub mod refined;
pub mod solver;
pub mod winding;
