//! The command line: flags, then a job, then files and an exit code.

mod flags;
mod log;
mod run;

use crate::error::Error;
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

/// Exit codes, as the README promises them. 1 (a target was not reached) comes with the targets.
mod code {
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
    match run::run(flags.command) {
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
