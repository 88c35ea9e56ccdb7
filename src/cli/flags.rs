//! The table of all commands, and of those that are only promised. A command has a file of its own beside this one.

use super::{adapters, bake, doctor, query, render};
use clap::{Parser, Subcommand};
use std::ffi::OsString;

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
    Bake(bake::Flags),
    /// Light at the points of a CSV file, from a solution.
    Query(query::Flags),
    /// A picture, from a solution or straight from a scene.
    Render(render::Flags),
    /// Say what is wrong with a scene: each fault with its object, a number and the cure.
    Doctor(doctor::Flags),
    /// List what raycell can run on, and with which limits.
    Adapters(adapters::Flags),
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
        assert!(not_built(&args("raycell explain a.obj")).unwrap().starts_with("explain"));
        // A scene may be called what it likes.
        assert!(not_built(&args("raycell bake paper")).is_none());
        assert!(not_built(&args("raycell bake -- --json")).is_none());
    }
}
