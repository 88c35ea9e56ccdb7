//! What is told, and where: words go to stderr, what a command was asked for to stdout.
//!
//! With `--json` stdout gets exactly one JSON object, whatever happens: the result, or
//! `{"error":{"kind","message","exit"}}`. A closed stream is nobody's fault: who has read enough, leaves.

use crate::error::{Error, Result};
use anstream::AutoStream;
use clap::builder::styling::{AnsiColor, Style};
use clap::{Args, ColorChoice};
use serde_json::Value;
use std::ffi::OsString;
use std::io::{self, ErrorKind, Write};

/// How it talks. The same for every command, and understood before and after its name.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = "Talk")]
pub struct Console {
    /// Print one JSON object to stdout: the result or the error.
    ///
    /// A bake prints its report, an error {"error":{"kind","message","exit"}}. Words for people still go to
    /// stderr; --quiet silences them.
    #[arg(long, global = true)]
    pub json: bool,
    /// Say nothing but errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// When to colour messages; auto is on a terminal, unless NO_COLOR is set.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value = "auto")]
    pub color: ColorChoice,
}

impl Console {
    /// What the raw arguments say, for errors that come before or from their parsing.
    pub fn from_args(args: &[OsString]) -> Console {
        let args: Vec<_> = args.iter().skip(1).map(|a| a.to_string_lossy()).take_while(|a| a != "--").collect();
        let color = args.iter().enumerate().rev().find_map(|(i, a)| match a.strip_prefix("--color") {
            Some("") => args.get(i + 1).map(|a| a.as_ref()),
            Some(rest) => rest.strip_prefix('='),
            None => None,
        });
        let color = color.and_then(|c| c.parse().ok()).unwrap_or(ColorChoice::Auto);
        Console { json: args.iter().any(|a| a == "--json"), quiet: false, color }
    }

    /// A line for the user, unless quiet.
    pub fn line(&self, text: &str) {
        if !self.quiet {
            self.say(None, text);
        }
    }

    /// Something the user should know, unless quiet.
    pub fn warning(&self, text: &str) {
        if !self.quiet {
            self.say(Some(("warning", AnsiColor::Yellow)), text);
        }
    }

    /// What went wrong: in words, in the form scripts may look for, and with `--json` as an object.
    pub fn error(&self, kind: &str, message: &str, exit: u8) {
        self.say(Some(("error", AnsiColor::Red)), message);
        self.error_object(kind, message, exit);
    }

    /// The object alone, where the words have been said.
    pub fn error_object(&self, kind: &str, message: &str, exit: u8) {
        if self.json {
            let object = serde_json::json!({"error": {"kind": kind, "message": message, "exit": exit}});
            // There is nobody left to tell.
            let _ = stdout(&format!("{object}\n"));
        }
    }

    /// What the command was asked for. Errors: [`Error::Write`] where stdout is full.
    pub fn result(&self, text: &str, object: &Value) -> Result<()> {
        if self.json { stdout(&format!("{object}\n")) } else { stdout(text) }
    }

    fn say(&self, label: Option<(&str, AnsiColor)>, text: &str) {
        let color = match self.color {
            ColorChoice::Auto => anstream::ColorChoice::Auto,
            ColorChoice::Always => anstream::ColorChoice::Always,
            ColorChoice::Never => anstream::ColorChoice::Never,
        };
        let mut stderr = AutoStream::new(io::stderr(), color);
        let label = label.map(|(word, color)| {
            let style = Style::new().fg_color(Some(color.into())).bold();
            format!("{style}{word}:{style:#} ")
        });
        let _ = writeln!(stderr, "raycell: {}{text}", label.unwrap_or_default());
    }
}

fn stdout(text: &str) -> Result<()> {
    let mut out = io::stdout();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::Write { path: "stdout".into(), source: e }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_raw_arguments_are_understood() {
        let of = |text: &str| Console::from_args(&text.split_whitespace().map(OsString::from).collect::<Vec<_>>());
        for (args, json, color) in [
            ("raycell bake --json", true, ColorChoice::Auto),
            ("raycell --color never --color=always bake", false, ColorChoice::Always),
            ("raycell bake --color", false, ColorChoice::Auto),
            ("raycell bake -- --json --color=never", false, ColorChoice::Auto),
        ] {
            let console = of(args);
            assert_eq!((console.json, console.color), (json, color), "{args}");
        }
    }
}
