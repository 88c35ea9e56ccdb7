//! raycell
pub mod bake;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod engine;
pub mod error;
pub mod gpu;
pub mod layout;
pub mod network;
pub mod output;
pub mod params;
pub mod pass;
pub mod progress;
pub mod radiosity;
pub mod scene;
pub mod shade;
pub mod solution;
pub mod twin;
pub use bake::{Backend, bake};
pub use error::{Error, Result};
pub use params::{Direct, Params};
pub use scene::Scene;
pub use solution::Solution;
pub use wgpu;
