//! From the cells' footprints to a linear system, and its solution.

pub mod coefficients;
pub mod components;
pub mod ends;
pub mod energy;
pub mod links;
pub mod nystrom;
pub mod solver;
pub mod winding;
