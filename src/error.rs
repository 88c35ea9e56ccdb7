//! The one error type. Every message says what is wrong, where, and the cure.

use std::path::PathBuf;

/// Everything that can go wrong in raycell.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {path}: {source}; check that the path is right and the file readable")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {path}: {source}; check that the folder exists, is writable and has space")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file does not hold what its name promises.
    #[error("{path}{}: {what}; {cure}", line.map(|l| format!(":{l}")).unwrap_or_default())]
    Format {
        /// The file.
        path: PathBuf,
        /// Line, from 1, where known.
        line: Option<usize>,
        /// What is wrong.
        what: String,
        /// What to do.
        cure: String,
    },
    /// A scene that is odd, where the caller wants none.
    #[error("{what}; {cure}, or leave --strict out")]
    Strict {
        /// The first warning: file, line, and what is odd.
        what: String,
        /// What to do.
        cure: String,
    },
    /// The scene holds no triangle with an area.
    #[error("{scene}: the scene has no triangle with an area; export faces, not only points or lines")]
    EmptyScene {
        /// The scene's name.
        scene: String,
    },
    /// A face of a flatland scene is no segment in the plane z = 0.
    #[error(
        "{place}: face {face} is no segment in the plane z = 0; a flatland scene has no others: give two ends, the second twice"
    )]
    NotFlat {
        /// The scene's name.
        place: String,
        /// Face index, from 0.
        face: usize,
    },
    /// A vertex is NaN, infinite, or more than 32-bit floats hold.
    #[error("{place}: vertex {index} is not finite in 32 bits ({value:?}); re-export the mesh")]
    InvalidVertex {
        /// File and line, or the scene's name.
        place: String,
        /// Vertex index, from 0.
        index: usize,
        /// Its coordinates.
        value: [f64; 3],
    },
    /// A triangle names a vertex or a material that does not exist.
    #[error("{place}: index {index} is out of range (there are {count}); re-export the mesh")]
    IndexOutOfRange {
        /// File and line, or the scene's name and the triangle.
        place: String,
        /// The index as written.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// A reflectance outside [0, 1).
    #[error(
        "{place}: material '{material}': reflectance {value} in the {band} band is not in [0, 1); lower it below 1 (a white wall is about 0.85)"
    )]
    InvalidReflectance {
        /// File and line, or the scene's name.
        place: String,
        /// The material's name.
        material: String,
        /// red, green or blue.
        band: &'static str,
        /// The value.
        value: f64,
    },
    /// An emission that is negative, not finite, or more than 32-bit floats hold.
    #[error(
        "{place}: material '{material}': emission {value} in the {band} band is not a finite number >= 0 in 32 bits; correct it"
    )]
    InvalidEmission {
        /// File and line, or the scene's name.
        place: String,
        /// The material's name.
        material: String,
        /// red, green or blue.
        band: &'static str,
        /// The value.
        value: f64,
    },
    /// A light, or an environment, that cannot shine.
    #[error("light '{light}': {what}; {cure}")]
    InvalidLight {
        /// Its name, or "environment".
        light: String,
        /// What is wrong.
        what: String,
        /// What to do.
        cure: &'static str,
    },
    /// A texture, or a texture coordinate, that cannot be used.
    #[error("{place} {what}; {cure}")]
    InvalidTexture {
        /// The texture, or the file and the line or the scene and the triangle.
        place: String,
        /// What is wrong.
        what: String,
        /// What to do.
        cure: &'static str,
    },
    /// A mirror that reflects all, or shines.
    #[error("{place}: material '{material}': {what}; give a mirror a reflectance below 1 and no emission")]
    InvalidMirror {
        /// File and line, or the scene's name.
        place: String,
        /// The material's name.
        material: String,
        /// What is wrong.
        what: String,
    },
    /// A parameter outside its range.
    #[error("{name} = {value} is out of range: {range}")]
    InvalidParam {
        /// The parameter or flag.
        name: &'static str,
        /// The value.
        value: String,
        /// The allowed range and the cure.
        range: &'static str,
    },
    /// The Jacobi iteration would not converge.
    #[error(
        "the light transfer does not contract (measured factor {factor:.4}, max reflectance {max_rho:.4}); lower the reflectance of '{material}' or shoot more rays"
    )]
    NotContractive {
        /// Measured spectral radius.
        factor: f64,
        /// Largest reflectance.
        max_rho: f64,
        /// The material that has it.
        material: String,
    },
    /// No usable GPU.
    #[error(
        "no usable GPU device: {why}; install a Vulkan driver (ci/setup does on Debian and Ubuntu), choose another --backend, or use --backend cpu"
    )]
    NoDevice {
        /// What was tried and why it failed.
        why: String,
    },
    /// The device cannot do what a kernel needs.
    #[error("{what} needs {need} but the device's {limit} is {have}; {cure}")]
    Limit {
        /// The kernel or the buffer.
        what: String,
        /// The limit's name in wgpu.
        limit: &'static str,
        /// What is needed.
        need: u64,
        /// What there is.
        have: u64,
        /// What to do.
        cure: &'static str,
    },
    /// What was asked for by name is not there.
    #[error("{asked} names nothing to run on; there is: {known}; correct it, leave it out, or use --backend cpu")]
    NoSuchDevice {
        /// The flag or variable, and its value.
        asked: String,
        /// The names there are.
        known: String,
    },
    /// A name that no material and no object of a scene bears.
    #[error("nothing is called '{name}'; there is {known}; correct the name")]
    UnknownName {
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// The device was lost: the driver reset, or the hardware went away.
    #[error("the GPU was lost in {stage}: {why}; the driver may have reset: try again, another --adapter, or --backend cpu")]
    DeviceLost {
        /// The stage or pass.
        stage: String,
        /// The driver's reason.
        why: String,
    },
    /// The device has no memory left.
    #[error("the GPU is out of memory in {stage}: {why}; close what else uses it, lower --rays, or try another --adapter")]
    OutOfMemory {
        /// The stage, or what was to be allocated.
        stage: String,
        /// The driver's reason.
        why: String,
    },
    /// A command failed on the device.
    #[error("the GPU failed in {stage}: {why}; the driver may have reset: try again, another --adapter, or --backend cpu")]
    Device {
        /// The stage or pass.
        stage: String,
        /// The driver's reason.
        why: String,
    },
    /// A kernel did not finish its work (a driver's silent loop limit, for one).
    #[error("kernel {kernel} did not finish on this driver ({why}); please report the adapter, and use --backend cpu meanwhile")]
    Unfinished {
        /// The kernel.
        kernel: &'static str,
        /// What was seen.
        why: String,
    },
    /// A result that is not a finite number: never handed to a user.
    #[error("{what} is not a finite number; please report the scene")]
    NotFinite {
        /// What.
        what: String,
    },
    /// A result too large for the 32-bit floats that meshes and pictures are made of.
    #[error(
        "{what} is {value:e}, more than the 32-bit floats of meshes and pictures hold; ask for points, or lower the emission"
    )]
    Overflow {
        /// What.
        what: String,
        /// The value, in the output's unit.
        value: f64,
    },
    /// A checkpoint of another bake.
    #[error(
        "{place}: this checkpoint is of another bake: {what}; ask for the same as then, or bake from the beginning (without --resume)"
    )]
    OtherBake {
        /// The file, or "the checkpoint".
        place: PathBuf,
        /// What differs.
        what: String,
    },
    /// The caller asked to stop.
    #[error("stopped by the caller")]
    Cancelled,
}

/// Shorthand used throughout the crate.
pub type Result<T> = std::result::Result<T, Error>;
