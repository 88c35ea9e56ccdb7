//! What several commands have in common: groups of flags, and what becomes of them.

pub mod camera;
pub mod goal;
pub mod interrupt;
pub mod kept;
pub mod machine;
pub mod network;
pub mod paper;
pub mod points;
pub mod results;
pub mod scene;
