//! The table of all commands. A command has a file of its own beside this one.

use super::console::Console;
use super::{adapters, bake, completions, doctor, explain, man, paper, query, relight, render, selftest, sweep};
use clap::{ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;

const EXAMPLES: &str = "\
Examples:
  raycell bake room.obj --eye 0,1.6,4 --target 0,1,0 -o out
      Light a room and look at it: out/picture.png. Every bake also leaves out/solution.rcell.
  raycell render out/solution.rcell --eye 4,1.6,0 --target 0,1,0 -o side.png
      Look at it again from elsewhere, without baking again.
  raycell query out/solution.rcell --points points.csv -o light.csv
      The light at points, in W/m2.
  raycell bake --help
      All flags of a command, with examples; -h is the short of it.";

const EXIT_CODES: &str = "\
Exit codes: 0 done; 1 doctor found something, a target was missed, or a case of the self-test; 2 bad input or usage; 3 no usable device; 4 device lost; 130 interrupted.
wgpu's own variables (WGPU_BACKEND, WGPU_ADAPTER_NAME, ...) are honoured; flags win.";

/// What was built in: a bug report needs it.
fn long_version() -> String {
    let interfaces = wgpu::Instance::enabled_backend_features();
    let names: Vec<_> = interfaces.iter_names().map(|(name, _)| name.to_lowercase()).collect();
    format!(
        "{}\nwgpu {WGPU}, with {}\nfeatures: cli\n{} {}",
        env!("CARGO_PKG_VERSION"),
        names.join(", "),
        std::env::consts::ARCH,
        std::env::consts::OS
    )
}

/// The wgpu that it speaks; a test holds it against the manifest.
const WGPU: &str = "30";

/// The table that help, parsing, manual pages and completions are made from.
pub fn table() -> clap::Command {
    Flags::command()
}

/// Reads the arguments. Errors, and help, are coloured as `color` says.
pub fn parse(args: Vec<OsString>, color: ColorChoice) -> Result<Flags, clap::Error> {
    let mut table = table().color(color);
    let matches = table.try_get_matches_from_mut(args)?;
    Flags::from_arg_matches(&matches).map_err(|e| e.format(&mut table))
}

/// Global-illumination baker: trains a neural mesh of light rays on a scene and solves it for radiosity.
#[derive(Parser)]
#[command(name = "raycell", version, long_version = long_version())]
#[command(subcommand_required = true, arg_required_else_help = true, args_override_self = true)]
#[command(after_help = EXIT_CODES, after_long_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub struct Flags {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub console: Console,
}

#[derive(Subcommand)]
pub enum Command {
    /// Train, solve, and write everything asked for into a folder.
    Bake(bake::Flags),
    /// Light at the points of a CSV file, from a solution.
    Query(query::Flags),
    /// Other light on a solution: new emission, light groups, or reflectance, without training again.
    Relight(relight::Flags),
    /// A picture, from a solution or straight from a scene.
    Render(render::Flags),
    /// What accuracy costs: the error of every method against time, in words, plots and pictures.
    Sweep(sweep::Flags),
    /// The seed paper's figures, made again: pictures, data, numbers, and a page of all.
    Paper(paper::Flags),
    /// Say what is wrong with a scene: each fault with its object, a number and the cure.
    Doctor(doctor::Flags),
    /// Say which effects a scene calls for, and why.
    Explain(explain::Flags),
    /// Whether this machine's driver computes what is known: closed forms beside what it finds.
    Selftest(selftest::Flags),
    /// List what raycell can run on, and with which limits.
    Adapters(adapters::Flags),
    /// Manual pages: the main one to stdout, or all of them into a folder.
    Man(man::Flags),
    /// What a shell offers on the tab key.
    Completions(completions::Flags),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_flags_is_sound() {
        table().debug_assert();
    }

    /// The command lines of a text, without what the shell makes of them.
    fn commands(text: &str) -> Vec<String> {
        let lines = text.lines().filter_map(|l| l.trim_start().strip_prefix("raycell "));
        let plain = lines.map(|l| l.split(['#', '>', '|']).next().unwrap_or_default().trim().to_string());
        plain.filter(|l| !l.is_empty()).collect()
    }

    fn accepts(command: &str) {
        let args = std::iter::once("raycell").chain(command.split_whitespace()).map(OsString::from).collect();
        if let Err(e) = parse(args, ColorChoice::Never) {
            assert_eq!(e.exit_code(), 0, "raycell {command}\n{e}");
        }
    }

    #[test]
    fn every_example_is_accepted() {
        let mut tables = vec![table()];
        tables.extend(table().get_subcommands().cloned());
        for table in tables {
            let text = table.get_after_long_help().map(|t| t.to_string()).unwrap_or_default();
            let commands = commands(&text);
            assert!(!commands.is_empty(), "{} has no examples", table.get_name());
            commands.iter().for_each(|c| accepts(c));
        }
        let readme: String =
            include_str!("../../README.md").split("```sh").skip(1).filter_map(|s| s.split("```").next()).collect();
        let readme = commands(&readme);
        assert!(readme.len() >= 5, "{readme:?}");
        readme.iter().for_each(|c| accepts(c));
    }

    #[test]
    fn the_version_tells_the_wgpu() {
        let manifest = include_str!("../../Cargo.toml");
        assert!(manifest.contains(&format!("\nwgpu = {{ version = \"{WGPU}\"")), "{WGPU}");
    }
}
