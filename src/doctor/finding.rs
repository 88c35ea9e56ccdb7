//! What the doctor says: one fault of one object, with a number, a place and the cure.

use crate::scene::Scene;
use serde::Serialize;

/// What was looked for. The names are stable, in kebab case: scripts may rely on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Check {
    /// The reader had to guess or to leave something out.
    Input,
    /// A reflectance outside [0, 1), or not a number.
    Reflectance,
    /// An emission that is negative or not a number.
    Emission,
    /// Triangles without an area.
    Degenerate,
    /// Triangles that are there twice.
    Duplicate,
    /// The scene's size suggests another unit than metres.
    Unit,
    /// So far from the origin that single precision cannot hold its shape.
    FarFromOrigin,
    /// Nothing emits.
    NoEmitter,
    /// An emitter that shines away from everything.
    EmitterFacingAway,
    /// Triangles wound so that light meets their backs.
    Flipped,
    /// A hole or a slit through which light leaks.
    Open,
    /// Objects that run through each other.
    Intersecting,
    /// Surfaces in one plane that cover each other.
    Overlapping,
}

impl Check {
    /// The stable name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Check::Input => "input",
            Check::Reflectance => "reflectance",
            Check::Emission => "emission",
            Check::Degenerate => "degenerate",
            Check::Duplicate => "duplicate",
            Check::Unit => "unit",
            Check::FarFromOrigin => "far-from-origin",
            Check::NoEmitter => "no-emitter",
            Check::EmitterFacingAway => "emitter-facing-away",
            Check::Flipped => "flipped",
            Check::Open => "open",
            Check::Intersecting => "intersecting",
            Check::Overlapping => "overlapping",
        }
    }
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Severity {
    /// A bake refuses the scene.
    Error,
    /// A bake runs; its light is wrong or may be.
    Warning,
}

/// One fault. Its `Display` is one line: what is wrong with which object, and the cure.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Finding {
    /// What was looked for.
    pub check: Check,
    /// How bad it is.
    pub severity: Severity,
    /// The object; the scene's name where it concerns the whole.
    pub object: String,
    /// The other object, where there are two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    /// How many or how much.
    pub number: f64,
    /// What `number` counts or its unit: `triangles`, `m`, `reflectance`, ...
    pub unit: &'static str,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub cure: String,
    /// An example: a world position, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 3]>,
    /// An example: an index into [`crate::Scene::faces`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub face: Option<u32>,
}

impl Finding {
    /// A warning without an example.
    pub(super) fn new(check: Check, object: &str, number: f64, unit: &'static str, message: String, cure: &str) -> Finding {
        Finding {
            check,
            severity: Severity::Warning,
            object: object.into(),
            other: None,
            number,
            unit,
            message,
            cure: cure.into(),
            place: None,
            face: None,
        }
    }

    /// With an example.
    pub(super) fn at(self, face: u32, place: [f64; 3]) -> Finding {
        Finding { face: Some(face), place: Some(place), ..self }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}", self.message)?;
        if let Some([x, y, z]) = self.place {
            write!(f, " (at {x:.6} {y:.6} {z:.6})")?;
        }
        write!(f, "; {}", self.cure)
    }
}

/// What a scene is made of, one of them and several.
pub(super) fn faces(scene: &Scene) -> [&'static str; 2] {
    if scene.is_flatland() { ["segment", "segments"] } else { ["triangle", "triangles"] }
}

/// "1 triangle", "2 triangles".
pub(super) fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// A length with the digits that matter.
pub(super) fn metres(x: f64) -> String {
    match x.abs() {
        a if a >= 1000.0 => format!("{:.3} km", x / 1000.0),
        a if a >= 1.0 => format!("{x:.2} m"),
        a if a >= 1e-3 => format!("{:.2} mm", x * 1e3),
        _ => format!("{x:.2e} m"),
    }
}
