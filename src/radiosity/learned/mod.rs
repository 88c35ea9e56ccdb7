//! From a kernel that a supervised network has learned to a linear system (`--mode paper`).

pub mod ends;
pub mod links;
pub mod nystrom;
