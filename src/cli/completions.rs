//! `raycell completions`: what a shell offers on the tab key, from the same table as the flags.

use super::exit::Done;
use super::flags;
use crate::error::Result;
use clap::Args;
use clap_complete::Shell;
use serde_json::json;

const EXAMPLES: &str = "\
Examples:
  raycell completions bash > ~/.local/share/bash-completion/completions/raycell
      For bash, from the next shell on.
  raycell completions zsh > ~/.zfunc/_raycell
      For zsh, with this in .zshrc: fpath+=~/.zfunc; autoload -U compinit; compinit
  raycell completions fish > ~/.config/fish/completions/raycell.fish
      For fish.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Shell to write them for.
    #[arg(value_enum)]
    pub shell: Shell,
}

pub fn run(flags: Flags) -> Result<Done> {
    let mut script = Vec::new();
    clap_complete::generate(flags.shell, &mut flags::table(), "raycell", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    let object = json!({"command": "completions", "shell": flags.shell.to_string(), "script": &script});
    Ok(Done::new(object).text(script))
}
