//! `raycell doctor`: what is wrong with a scene.

use crate::doctor::{self, Finding};
use crate::error::{Error, Result};
use crate::scene::Scene;
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Flags {
    /// Scene to look at: an .obj file with its .mtl.
    pub scene: PathBuf,
    /// Print the findings as one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Report<'a> {
    scene: &'a str,
    findings: &'a [Finding],
}

/// Prints the findings to stdout, a line each; answers how many there are.
pub fn run(flags: Flags) -> Result<usize> {
    let scene = Scene::read(&flags.scene)?;
    let findings = doctor::examine(&scene)?;
    let text = if flags.json {
        let report = Report { scene: &scene.name, findings: &findings };
        serde_json::to_string_pretty(&report).map_err(|e| Error::NotFinite { what: e.to_string() })? + "\n"
    } else {
        findings.iter().map(|f| format!("{}: {f}\n", f.check.name())).collect()
    };
    // A reader that has seen enough (head) is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Write { path: "stdout".into(), source: e }),
        _ => Ok(findings.len()),
    }
}
