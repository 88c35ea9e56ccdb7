//! The host's part of both networks: the cells' topology and growth, the nodes of the surface.

mod boxes;
pub mod candidates;
pub mod complex;
pub mod groups;
pub mod growth;
pub mod nodes;
pub mod pairs;
pub mod supervised;
pub mod tiles;
