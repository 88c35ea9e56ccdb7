//! What can be asked for. Nothing is opened here; [`super::run`] does that.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;

/// Flags and commands that are promised but not built, and what to do meanwhile.
const NOT_BUILT: &[(&str, &str)] = &[
    ("--target-error", "set --rays instead: the error falls about as rays^-0.3"),
    ("--time-budget", "set --rays instead: time grows with rays"),
    ("--mode", "bakes run in flux mode"),
    ("--effects", "every bake has diffuse light with exact shadows"),
    ("--quality", "set --rays instead"),
    ("--json", "read report.json in the output folder"),
    ("--resume", "bake again; the same seed gives the same result"),
    ("--two-sided", "duplicate the faces with opposite winding"),
    ("--strict", "read the warnings"),
    ("--kd-space", "Kd is taken as linear Rec.709"),
    ("relight", "bake again with the new lights"),
    ("sweep", "bake with several --rays"),
    ("paper", "bakes run in flux mode"),
    ("explain", "every bake has diffuse light with exact shadows"),
    ("doctor", "read the warnings of a bake"),
];

/// A refusal that names the first promised but unbuilt flag or command in the arguments.
pub fn not_built(args: &[OsString]) -> Option<String> {
    let args: Vec<_> = args.iter().skip(1).map(|a| a.to_string_lossy()).take_while(|a| a != "--").collect();
    let command = args.iter().find(|a| !a.starts_with('-'));
    NOT_BUILT.iter().find_map(|(name, instead)| {
        let given = if name.starts_with('-') {
            args.iter().any(|a| a.split('=').next() == Some(name))
        } else {
            command.is_some_and(|c| c == name)
        };
        given.then(|| format!("{name} is not built yet; {instead}"))
    })
}

/// Global-illumination baker: trains a neural mesh of light rays on a scene and solves it for radiosity.
#[derive(Parser)]
#[command(name = "raycell", version, arg_required_else_help = true)]
#[command(after_help = "\
Exit codes: 0 done; 1 a target was not reached; 2 bad input or usage; 3 no usable device; 4 device lost; 130 interrupted.
wgpu's own variables (WGPU_BACKEND, WGPU_ADAPTER_NAME, ...) are honoured; flags win.")]
pub struct Flags {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Train, solve, and write everything asked for into a folder.
    Bake(Bake),
    /// Light at the points of a CSV file, from a solution.
    Query(Query),
    /// A picture, from a solution or straight from a scene.
    Render(Render),
    /// List what raycell can run on, and with which limits.
    Adapters(Adapters),
}

#[derive(Args)]
pub struct Bake {
    /// Scene to light: an .obj file with its .mtl.
    pub scene: PathBuf,
    /// Folder for the results, made where it does not exist.
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub output: PathBuf,
    /// Also answer these points: CSV with px,py,pz,nx,ny,nz; written to points.csv.
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Also write vertices.ply, the radiosity at every vertex.
    #[arg(long)]
    pub vertices: bool,
    #[command(flatten)]
    pub camera: Camera,
    #[command(flatten)]
    pub network: Network,
    #[command(flatten)]
    pub device: Device,
}

#[derive(Args)]
pub struct Query {
    /// Solution that a bake has written.
    pub solution: PathBuf,
    /// Points: CSV with the columns px,py,pz,nx,ny,nz.
    #[arg(long, value_name = "FILE")]
    pub points: PathBuf,
    /// Answers, row by row.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub device: Device,
}

#[derive(Args)]
pub struct Render {
    /// Solution (.rcell), or a scene (.obj) to be baked first.
    pub input: PathBuf,
    /// Picture: .exr for linear radiance, .png for a tone-mapped one.
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub camera: Camera,
    #[command(flatten)]
    pub network: Network,
    #[command(flatten)]
    pub device: Device,
}

#[derive(Args)]
pub struct Adapters {
    #[command(flatten)]
    pub device: Device,
}

/// Where the light is seen from. A file first, then the flags over it.
#[derive(Args)]
#[command(next_help_heading = "Camera")]
pub struct Camera {
    /// JSON file with camera{eye,target,up,vfov}; bake also renders picture.exr and picture.png.
    #[arg(long, value_name = "FILE")]
    pub camera: Option<PathBuf>,
    /// Position, metres.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,
    /// Point looked at.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub target: Option<[f64; 3]>,
    /// Upward direction [default: 0,1,0].
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub up: Option<[f64; 3]>,
    /// Vertical field of view, degrees [default: 40].
    #[arg(long, value_name = "DEGREES")]
    pub vfov: Option<f64>,
    /// Picture width, pixels [default: 512].
    #[arg(long, value_name = "PIXELS")]
    pub width: Option<u32>,
    /// Picture height, pixels [default: 512].
    #[arg(long, value_name = "PIXELS")]
    pub height: Option<u32>,
    /// What radiance is multiplied by in a PNG [default: from the picture].
    #[arg(long, value_name = "FACTOR")]
    pub exposure: Option<f64>,
}

/// How the network is trained.
#[derive(Args)]
#[command(next_help_heading = "Network")]
pub struct Network {
    /// Seed of every random sequence: same seed, same device, same bytes [default: 1].
    #[arg(long)]
    pub seed: Option<u32>,
    /// Light rays, 1024 to 16777216 [default: 524288].
    #[arg(long)]
    pub rays: Option<u32>,
    /// Cells of the network, 16 to 100000 [default: rays/512; with --direct network rays/128].
    #[arg(long)]
    pub cells: Option<u32>,
    /// How light straight from emitters is carried [default: exact].
    #[arg(long, value_enum)]
    pub direct: Option<Direct>,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Direct {
    /// Sampled exactly at every point.
    Exact,
    /// Through the network like all other light.
    Network,
}

/// What it runs on.
#[derive(Args)]
#[command(next_help_heading = "Device")]
pub struct Device {
    /// Graphics interface; cpu is the slow driver-free oracle and never chosen by auto.
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: Backend,
    /// Only adapters whose name contains this.
    #[arg(long, value_name = "SUBSTRING")]
    pub adapter: Option<String>,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    Auto,
    Vulkan,
    Metal,
    Dx12,
    Gl,
    Cpu,
}

/// "x,y,z" as three finite numbers.
fn vector(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    numbers.and_then(|v| v.try_into().ok()).ok_or_else(|| "give three numbers, as 1,2.5,-3".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_table_of_flags_is_sound() {
        Flags::command().debug_assert();
    }

    #[test]
    fn promised_flags_are_named() {
        let args = |text: &str| text.split_whitespace().map(OsString::from).collect::<Vec<_>>();
        assert!(
            not_built(&args("raycell bake a.obj --target-error=5")).unwrap().starts_with("--target-error is not built yet; ")
        );
        assert!(not_built(&args("raycell doctor a.obj")).unwrap().starts_with("doctor"));
        // A scene may be called what it likes.
        assert!(not_built(&args("raycell bake paper")).is_none());
        assert!(not_built(&args("raycell bake -- --json")).is_none());
    }

    #[test]
    fn vectors() {
        assert_eq!(vector("1, -2.5,3e2"), Ok([1.0, -2.5, 300.0]));
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "a,b,c"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
    }
}
