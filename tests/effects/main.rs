//! Effects: each is right where a scene calls for it, and costs nothing where it does not. A file an effect.

mod absent;
mod lights;
mod sky;
#[path = "../common/mod.rs"]
mod common;
