//! How far a result can be trusted, and what it would cost to trust it more.

pub(crate) mod estimate;
mod ladder;

pub use ladder::{Climb, Goal, climb};
