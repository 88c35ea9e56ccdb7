//! How a command ends: exit codes, as the README promises them, and the name of every error.

use crate::error::Error;
use serde_json::Value;

/// Done.
pub const DONE: u8 = 0;
/// `doctor` found something.
pub const FOUND: u8 = 1;
/// A target was not reached, or a case of the self-test failed.
pub const MISSED: u8 = 1;
/// Bad input or usage.
pub const USAGE: u8 = 2;
/// No usable device.
pub const NO_DEVICE: u8 = 3;
/// Device lost.
pub const DEVICE_LOST: u8 = 4;
/// Interrupted.
pub const INTERRUPTED: u8 = 130;

/// A command that did its work.
pub struct Done {
    /// Exit code.
    pub code: u8,
    /// What it prints for people; empty where files are the result.
    pub text: String,
    /// What it prints with `--json`.
    pub object: Value,
}

impl Done {
    /// A success whose result lies in files.
    pub fn new(object: Value) -> Done {
        Done { code: DONE, text: String::new(), object }
    }

    /// With words for people.
    pub fn text(self, text: String) -> Done {
        Done { text, ..self }
    }
}

/// Why a command did not do its work, and what to say in place of the error's own words.
pub struct Failure {
    /// The error.
    pub error: Error,
    /// Other words for it.
    pub words: Option<String>,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        Failure { error, words: None }
    }
}

/// An error's name for scripts, and its exit code.
pub fn of(e: &Error) -> (&'static str, u8) {
    match e {
        Error::Read { .. } => ("read", USAGE),
        Error::Write { .. } => ("write", USAGE),
        Error::Format { .. } => ("format", USAGE),
        Error::Strict { .. } => ("strict", USAGE),
        Error::EmptyScene { .. } => ("empty_scene", USAGE),
        Error::NotFlat { .. } => ("not_flat", USAGE),
        Error::InvalidVertex { .. } => ("invalid_vertex", USAGE),
        Error::IndexOutOfRange { .. } => ("index_out_of_range", USAGE),
        Error::InvalidReflectance { .. } => ("invalid_reflectance", USAGE),
        Error::InvalidLight { .. } => ("invalid_light", USAGE),
        Error::InvalidEmission { .. } => ("invalid_emission", USAGE),
        Error::InvalidMirror { .. } => ("invalid_mirror", USAGE),
        Error::InvalidTexture { .. } => ("invalid_texture", USAGE),
        Error::InvalidParam { .. } => ("invalid_param", USAGE),
        Error::UnknownName { .. } => ("unknown_name", USAGE),
        Error::OtherBake { .. } => ("other_bake", USAGE),
        Error::Overflow { .. } => ("overflow", USAGE),
        Error::NotContractive { .. } => ("not_contractive", USAGE),
        Error::NoDevice { .. } => ("no_device", NO_DEVICE),
        Error::Limit { .. } => ("limit", NO_DEVICE),
        Error::NoSuchDevice { .. } => ("no_such_device", NO_DEVICE),
        Error::DeviceLost { .. } => ("device_lost", DEVICE_LOST),
        Error::OutOfMemory { .. } => ("out_of_memory", DEVICE_LOST),
        Error::Device { .. } => ("device", DEVICE_LOST),
        Error::Unfinished { .. } => ("unfinished", DEVICE_LOST),
        Error::NotFinite { .. } => ("not_finite", DEVICE_LOST),
        Error::Cancelled => ("interrupted", INTERRUPTED),
    }
}
