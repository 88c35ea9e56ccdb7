//! Files a bake leaves behind. Each is written whole or not at all ([`atomic`]).

#[doc(hidden)]
pub mod atomic;
pub mod glb;
pub mod image;
pub mod mesh;
pub mod ply;
pub mod points;
#[doc(hidden)]
pub mod rcell;
pub mod report;
