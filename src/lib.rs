//! raycell
pub mod bake;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod error;
pub mod layout;
pub mod output;
pub mod params;
pub mod progress;
pub mod scene;
pub use error::{Error, Result};
pub use params::{Direct, Params};
pub use scene::Scene;
