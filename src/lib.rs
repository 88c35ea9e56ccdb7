//! raycell bakes global illumination: a neural mesh of light rays learns how light flows through a
//! scene, is read as the coefficients of a linear system, and is solved on the GPU through [`wgpu`].
//!
//! ```
//! use raycell::scene::Material;
//! use raycell::{Backend, Flow, Params, Scene, SurfacePoint, bake};
//!
//! # fn main() -> raycell::Result<()> {
//! let (grey, lamp) = (Material::new("grey", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.0; 3], [10.0; 3]));
//! let floor = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]; // counter-clockwise seen from the lit side
//! let light = [[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [0.0, 0.5, 1.0]];
//! let scene = Scene::from_triangles("two triangles", &[(floor, 0), (light, 1)], vec![grey, lamp])?;
//! let params = Params { rays: 2048, ..Params::default() };
//! let solution = bake(&Backend::Cpu, &scene, &params, &mut |_| Flow::Continue)?;
//! let answers = solution.query(&Backend::Cpu, &[SurfacePoint { p: [0.3, 0.0, 0.3], n: [0.0, 1.0, 0.0] }])?;
//! println!("radiosity {:?} W/m2", answers[0].b);
//! # assert!(answers[0].b.iter().all(|b| *b > 1.0 && *b < 5.0 * std::f64::consts::PI), "{answers:?}");
//! # Ok(())
//! # }
//! ```
//!
//! - **On a GPU:** [`gpu::Gpu::new`] takes a host's own device and queue (`examples/embed.rs`);
//!   [`gpu::device::open`] opens one for those who have none. [`Backend::Cpu`] is the oracle:
//!   plain Rust, slow, no driver.
//! - **Scenes:** [`Scene::load`] reads OBJ, glTF and TOML, [`Scene::from_triangles`] takes what is in memory.
//!   Metres, linear Rec.709, surfaces lit on the side of their counter-clockwise winding.
//! - **Results:** [`Solution::query`] at any points, [`Solution::render`] for pictures,
//!   [`Solution::vertices`] for meshes, [`Solution::save`] for later. [`output`] writes the files.
//! - **Other light:** [`Solution::relight`] takes new emission, light groups and reflectance without training again.
//! - **Stopping:** [`bake_from`] fills a [`Checkpoint`] and goes on from one; [`Checkpoint::solution`] is what was
//!   known when it stopped.
//! - **Trust:** [`selftest::run`] holds a machine's driver against closed forms.
//! - **Progress:** the closure hears [`Event`]s and may answer [`Flow::Stop`]. The library prints
//!   nothing and keeps no global state; what fails is an [`Error`] that names the cure.
//!
//! What these pages leave out is public for the tests and benches alone (`pass`, `twin`, `layout` and their like):
//! it is not covered by semantic versioning. `docs/api.txt` lists what is.
//!
//! `cli`, a default feature, is the program; `--no-default-features` builds the library alone.

pub mod accuracy;
pub mod bake;
mod baker;
pub mod checkpoint;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod disjoint;
pub mod doctor;
pub mod effects;
pub mod engine;
pub mod error;
pub mod gpu;
mod hash;
#[doc(hidden)]
pub mod layout;
#[cfg(feature = "cli")]
mod memory;
#[doc(hidden)]
pub mod network;
pub mod output;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod paper;
pub mod params;
#[doc(hidden)]
pub mod pass;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod plot;
pub mod progress;
#[doc(hidden)]
pub mod radiosity;
pub mod relight;
pub mod scene;
pub mod selftest;
#[doc(hidden)]
pub mod shade;
pub mod solution;
mod stream;
#[doc(hidden)]
pub mod twin;

pub use accuracy::Goal;
pub use bake::{bake, bake_from};
pub use baker::{Baked, Baker, LIGHT_TEXTURE_WIDTH, Ready};
pub use checkpoint::Checkpoint;
pub use engine::Backend;
pub use error::{Error, Result};
pub use params::{Cells, Direct, Method, Mode, Norm, Params, Solver};
pub use progress::{Event, Flow};
pub use relight::Change;
pub use scene::Scene;
pub use solution::{Answer, Camera, Image, Solution, Status, SurfacePoint};
pub use wgpu;

/// The README's program compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
