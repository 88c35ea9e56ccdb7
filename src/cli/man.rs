//! `raycell man`: manual pages, from the same table as the flags.

use super::console::Console;
use super::exit::Done;
use super::flags;
use crate::error::{Error, Result};
use crate::output::atomic;
use clap::Args;
use clap_mangen::Man;
use serde_json::json;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  raycell man > raycell.1
      The page of the program as a whole.
  raycell man -o man1
      A page for every command: raycell.1, raycell-bake.1, and so on. Read one with: man -l man1/raycell-bake.1";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Folder for a page a command, made where it does not exist. Without it the main page goes to stdout.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

pub fn run(flags: Flags, console: &Console) -> Result<Done> {
    let mut table = flags::table();
    table.build();
    let Some(dir) = flags.output else {
        let text = page(table)?.1;
        let object = json!({"command": "man", "text": &text});
        return Ok(Done::new(object).text(text));
    };
    std::fs::create_dir_all(&dir).map_err(|source| Error::Write { path: dir.clone(), source })?;
    let mut files = Vec::new();
    // `help` repeats what every page says.
    let commands = table.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect::<Vec<_>>();
    for command in [table].into_iter().chain(commands) {
        let (name, text) = page(command)?;
        let path = dir.join(name);
        atomic::write(&path, text.as_bytes())?;
        console.line(&format!("wrote {}", path.display()));
        files.push(path.display().to_string());
    }
    Ok(Done::new(json!({"command": "man", "files": files})))
}

/// A page's file name and text.
fn page(command: clap::Command) -> Result<(String, String)> {
    let man = Man::new(command).source(concat!("raycell ", env!("CARGO_PKG_VERSION"))).manual("raycell manual");
    let mut text = Vec::new();
    man.render(&mut text).map_err(|source| Error::Write { path: man.get_filename().into(), source })?;
    Ok((man.get_filename(), String::from_utf8_lossy(&text).into_owned()))
}
