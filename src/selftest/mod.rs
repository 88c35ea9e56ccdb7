//! The physics part of the hard cases (`docs/hard_cases.md`) on the machine that a bake would use, because drivers
//! differ: closed forms beside what this one finds.

mod driver;
mod factors;
mod light;
mod scenes;
mod trial;
mod visibility;

use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::progress::{Event, Flow};
use serde::Serialize;
use trial::Trial;

/// A number that is known, beside what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Outcome {
    /// The case in `docs/hard_cases.md`.
    pub case: &'static str,
    /// What was asked.
    pub what: String,
    /// What it is.
    pub truth: f64,
    /// What was found; none where an error came first.
    pub got: Option<f64>,
    /// How far apart the two may be.
    pub tolerance: f64,
    /// Whether they are no farther apart.
    pub pass: bool,
    /// The error that came first.
    pub error: Option<String>,
}

/// What a test puts wrong on purpose, to see the cases fail.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spoil {
    /// Nothing.
    #[default]
    Nothing,
    /// Flatland's kernel has the norm that its light has not.
    Norm,
    /// All truths are others.
    Truths,
}

/// A case: its name in the catalogue, and how it is tried.
struct Case {
    name: &'static str,
    run: fn(&mut Trial) -> Result<()>,
    /// Whether it asks the driver something that plain Rust has no answer to.
    driver: bool,
}

const fn case(name: &'static str, run: fn(&mut Trial) -> Result<()>) -> Case {
    Case { name, run, driver: false }
}

const fn of_drivers(name: &'static str, run: fn(&mut Trial) -> Result<()>) -> Case {
    Case { name, run, driver: true }
}

/// Quick ones first, so that a hopeless driver is soon found out.
const CASES: &[Case] = &[
    of_drivers("H06", driver::loops),
    of_drivers("H01", driver::dispatches),
    case("H10", driver::not_numbers),
    case("G01", driver::sums),
    case("A01", factors::common_edge),
    case("A02", factors::hinges),
    case("A03", factors::common_corner),
    case("A06", factors::gaps),
    case("A10", factors::coplanar),
    case("A11", factors::back_to_back),
    case("A12", factors::tetrahedron),
    case("A17", factors::scales),
    case("E09", factors::concentric),
    case("E13", factors::rows),
    case("D01", visibility::convex),
    case("D02", visibility::watertight),
    case("D06", visibility::strings),
    case("D03", visibility::dark_room),
    case("D05", visibility::penumbra),
    case("E01", light::furnace),
    case("E05", light::kirchhoff),
    case("E06", light::halves),
    case("E11", light::energy),
    case("E16", light::lit_square),
    case("E19", light::norm),
    case("G03", light::same_bytes),
    of_drivers("H16", light::twin),
];

/// Runs all cases; on the twin those that are not about drivers. Half a minute on a software driver.
///
/// A case that fails is an [`Outcome`], also where it ends with an error. Errors: [`Error::DeviceLost`], after which
/// nothing more can be found out; [`Error::Cancelled`].
pub fn run(backend: &Backend, progress: &mut dyn FnMut(&Event) -> Flow) -> Result<Vec<Outcome>> {
    run_with(backend, &[], Spoil::Nothing, progress)
}

/// Runs the cases of these names, or all where there is none.
///
/// Errors: also [`Error::InvalidParam`] for a name that no case has.
#[doc(hidden)]
pub fn run_with(
    backend: &Backend,
    names: &[String],
    spoil: Spoil,
    progress: &mut dyn FnMut(&Event) -> Flow,
) -> Result<Vec<Outcome>> {
    if let Some(unknown) = names.iter().find(|name| !CASES.iter().any(|case| case.name.eq_ignore_ascii_case(name))) {
        let range = "give names as the table of raycell selftest shows them";
        return Err(Error::InvalidParam { name: "CASE", value: unknown.clone(), range });
    }
    let mut outcomes = Vec::new();
    for case in CASES {
        let asked = names.is_empty() || names.iter().any(|name| case.name.eq_ignore_ascii_case(name));
        if !asked || (case.driver && matches!(backend, Backend::Cpu)) {
            continue;
        }
        if progress(&Event::Stage { name: case.name }) == Flow::Stop {
            return Err(Error::Cancelled);
        }
        let mut trial = Trial::new(backend, case.name, spoil, progress);
        match (case.run)(&mut trial) {
            Ok(()) => {}
            Err(error @ (Error::DeviceLost { .. } | Error::Cancelled)) => return Err(error),
            Err(error) => trial.failed(&error),
        }
        outcomes.extend(trial.outcomes());
    }
    Ok(outcomes)
}
