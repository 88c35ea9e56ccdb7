//! Hard cases: what breaks global-illumination solvers, each with a truth nobody can argue with. `docs/hard_cases.md` is
//! the catalogue; a case `A01` is passed by the tests whose names begin with `a01_`. `ci/hard_cases` runs them and counts.

mod catalogue;
#[path = "../common/mod.rs"]
mod common;
mod faults;
mod geometry;
mod gpu;
mod input;
mod leaks;
mod network;
mod paging;
mod random;
mod scale;
mod setup;
mod solutions;
mod sums;
mod visibility;
