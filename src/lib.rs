//! raycell
pub mod error;
pub mod gpu;
pub mod layout;
pub mod params;
pub mod pass;
pub mod scene;
pub mod twin;
pub use error::{Error, Result};
pub use params::{Direct, Params};
pub use scene::Scene;
pub use wgpu;
