//! From the cells' footprints, or from patches, to a linear system, and its solution.

pub mod cell_links;
pub mod coefficients;
pub mod components;
pub mod display;
pub mod ends;
pub mod energy;
pub mod exchange;
pub mod gauss_seidel;
pub mod links;
pub mod nystrom;
pub mod patches;
pub mod sampled;
pub mod solver;
pub mod winding;
