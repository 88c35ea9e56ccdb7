//! raycell
pub mod engine;
pub mod error;
pub mod layout;
pub mod params;
pub mod scene;
pub mod twin;
pub use error::{Error, Result};
pub use params::{Direct, Params};
pub use scene::Scene;
