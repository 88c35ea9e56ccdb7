//! From the cells' footprints to a linear system, and its solution.

pub mod coefficients;
pub mod components;
pub mod energy;
pub mod solver;
pub mod winding;
