//! Files a bake leaves behind. Each is written whole or not at all ([`atomic`]).

pub mod atomic;
pub mod glb;
pub mod image;
pub mod mesh;
pub mod ply;
pub mod points;
pub mod rcell;
pub mod report;
