//! Effects: each is right where a scene calls for it, and costs nothing where it does not. A file an effect.

mod absent;
#[path = "../common/mod.rs"]
mod common;
mod cutouts;
mod lights;
mod maps;
mod medium;
mod mirrors;
mod outside;
mod sky;
mod textures;
