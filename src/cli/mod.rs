//! The command line: flags, then a job, then files and an exit code.

mod adapters;
mod bake;
mod doctor;
mod flags;
mod log;
mod query;
mod render;
mod shared;

use crate::error::Error;
use clap::Parser;
use flags::Command;
use std::ffi::OsString;
use std::process::ExitCode;

/// Exit codes, as the README promises them.
mod code {
    pub const FOUND: u8 = 1;
    pub const USAGE: u8 = 2;
    pub const NO_DEVICE: u8 = 3;
    pub const DEVICE_LOST: u8 = 4;
    pub const INTERRUPTED: u8 = 130;
}

/// Runs the program on the process's own arguments.
pub fn run() -> ExitCode {
    let args: Vec<OsString> = std::env::args_os().collect();
    if let Some(refusal) = flags::not_built(&args) {
        log::error(&refusal);
        return code::USAGE.into();
    }
    let flags = match flags::Flags::try_parse_from(args) {
        Ok(flags) => flags,
        Err(e) => {
            // Help and version are no errors; a closed pipe is nobody's fault.
            let _ = e.print();
            return (e.exit_code() as u8).into();
        }
    };
    let done = match flags.command {
        Command::Doctor(flags) => match doctor::run(flags) {
            Ok(0) => Ok(()),
            Ok(_) => return code::FOUND.into(),
            Err(e) => Err(e),
        },
        Command::Bake(flags) => bake::run(flags),
        Command::Query(flags) => query::run(flags),
        Command::Render(flags) => render::run(flags),
        Command::Adapters(flags) => adapters::run(flags),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            match &e {
                Error::Cancelled => log::error("interrupted; nothing was written"),
                _ => log::error(&e.to_string()),
            }
            exit_code(&e).into()
        }
    }
}

fn exit_code(e: &Error) -> u8 {
    match e {
        Error::NoDevice { .. } | Error::Limit { .. } => code::NO_DEVICE,
        Error::Device { .. } | Error::Unfinished { .. } | Error::NotFinite { .. } => code::DEVICE_LOST,
        Error::Cancelled => code::INTERRUPTED,
        _ => code::USAGE,
    }
}
