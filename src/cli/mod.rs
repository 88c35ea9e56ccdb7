//! The command line: flags, then a job, then files and an exit code.

mod adapters;
mod bake;
mod completions;
mod console;
mod doctor;
mod exit;
mod explain;
mod flags;
mod log;
mod man;
mod paper;
mod query;
mod relight;
mod render;
mod selftest;
mod shared;
mod sweep;

use crate::error::Error;
use clap::error::ErrorKind;
use console::Console;
use exit::{Done, Failure};
use flags::Command;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs the program on the process's own arguments.
pub fn run() -> ExitCode {
    let args: Vec<OsString> = std::env::args_os().collect();
    let early = Console::from_args(&args);
    let (command, console) = match flags::parse(args, early.color) {
        Ok(flags) => (flags.command, flags.console),
        Err(e) => {
            // Help and version are no errors; a closed pipe is nobody's fault.
            let _ = e.print();
            let code = e.exit_code() as u8;
            if !matches!(e.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
                let text = e.render().to_string();
                early.error_object("usage", text.trim_start_matches("error: ").trim_end(), code);
            }
            return code.into();
        }
    };
    let done = obey(command, &console).and_then(|done| {
        console.result(&done.text, &done.object)?;
        Ok(done.code)
    });
    match done {
        Ok(code) => code.into(),
        Err(Failure { error, words }) => {
            let (kind, code) = exit::of(&error);
            let message = words.unwrap_or_else(|| match &error {
                Error::Cancelled => "interrupted; nothing was written".to_string(),
                _ => error.to_string(),
            });
            console.error(kind, &message, code);
            code.into()
        }
    }
}

fn obey(command: Command, console: &Console) -> Result<Done, Failure> {
    let done = match command {
        Command::Bake(flags) => return bake::run(flags, console),
        Command::Query(flags) => query::run(flags, console),
        Command::Relight(flags) => return relight::run(flags, console),
        Command::Render(flags) => render::run(flags, console),
        Command::Sweep(flags) => return sweep::run(flags, console),
        Command::Paper(flags) => return paper::run(flags, console),
        Command::Doctor(flags) => doctor::run(flags),
        Command::Explain(flags) => explain::run(flags),
        Command::Selftest(flags) => selftest::run(flags, console),
        Command::Adapters(flags) => adapters::run(flags),
        Command::Man(flags) => man::run(flags, console),
        Command::Completions(flags) => completions::run(flags),
    };
    Ok(done?)
}
