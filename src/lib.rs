//! raycell
pub mod engine;
pub mod error;
pub mod gpu;
pub mod layout;
pub mod network;
pub mod params;
pub mod pass;
pub mod progress;
pub mod radiosity;
pub mod scene;
pub mod twin;
pub use error::{Error, Result};
pub use params::{Direct, Params};
pub use scene::Scene;
pub use wgpu;
