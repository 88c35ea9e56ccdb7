//! What a bake keeps in its folder so that it can be stopped: the checkpoint, and a partial solution.

use super::super::exit::{self, Failure};
use super::super::log::Log;
use crate::checkpoint::Checkpoint;
use crate::error::{Error, Result};
use crate::output::report;
use crate::params::Params;
use crate::scene::Scene;
use crate::solution::Solution;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The checkpoint's name in a bake's folder.
const NAME: &str = "checkpoint.rcell";

/// The checkpoint in a bake's folder.
pub struct Kept {
    pub checkpoint: Checkpoint,
    file: PathBuf,
}

impl Kept {
    /// The checkpoint to begin with: with `resume` the folder's own, where it has one.
    pub fn open(folder: &Path, resume: bool, log: &Log) -> Result<Kept> {
        let file = folder.join(NAME);
        let mut checkpoint = Checkpoint::default();
        if resume && file.exists() {
            checkpoint = Checkpoint::load(&file)?;
            let reached = checkpoint.reached().unwrap_or("the read-out".into());
            log.line(&format!("going on from {} ({reached})", file.display()));
        } else if resume {
            log.line(&format!("there is no {}: baking from the beginning", file.display()));
        } else if file.exists() {
            log.warning(&format!("{} of an earlier bake is overwritten; --resume would go on from it", file.display()));
        }
        checkpoint.keep_in(&file);
        Ok(Kept { checkpoint, file })
    }

    /// The bake and its read-out ended with an error: saves what there is, where it can be gone on from. With `safe`
    /// the folder holds a whole solution of a smaller rung, which is worth more than a part of the next.
    pub fn stopped(
        &self,
        error: Error,
        scene: &Scene,
        params: &Params,
        safe: bool,
        finish: impl FnOnce(&mut report::Report),
    ) -> Failure {
        let code = exit::of(&error).1;
        if self.checkpoint.is_empty() || matches!(error, Error::OtherBake { .. } | Error::Format { .. }) {
            return error.into();
        }
        if code != exit::INTERRUPTED && code != exit::DEVICE_LOST {
            // It would end the same way again; a file that is not there cannot be removed, and need not.
            let _ = std::fs::remove_file(&self.file);
            return error.into();
        }
        let own = self.checkpoint.params().unwrap_or(params);
        let saved = if safe { self.save_checkpoint() } else { self.save(scene, own, finish) };
        match saved {
            Ok(words) => {
                let why = if code == exit::INTERRUPTED { "interrupted".into() } else { error.to_string() };
                Failure { words: Some(format!("{why}; {words}; go on with: {}", command(std::env::args_os()))), error }
            }
            Err(unsaved) => Failure { words: Some(format!("{error}; and nothing could be saved: {unsaved}")), error },
        }
    }

    /// Saves the checkpoint alone; says so.
    fn save_checkpoint(&self) -> Result<String> {
        self.checkpoint.save(&self.file)?;
        Ok(format!("saved {}; solution.rcell beside it is whole, of a smaller rung", self.file.display()))
    }

    /// Saves the checkpoint, the solution as far as it is known and its report; says what was saved.
    fn save(&self, scene: &Scene, params: &Params, finish: impl FnOnce(&mut report::Report)) -> Result<String> {
        self.checkpoint.save(&self.file)?;
        let folder = self.file.parent().unwrap_or(Path::new(""));
        let mut solution = self.checkpoint.solution(scene, params)?;
        let path = folder.join("solution.rcell");
        solution.save(&path)?;
        let report = solution.report_mut();
        finish(report);
        let reached = report.reached.clone();
        let words = format!(
            "saved {} and {} ({})",
            self.file.display(),
            path.display(),
            reached.as_ref().map_or("whole; its read-out is missing".into(), |r| format!("partial: {r}"))
        );
        report.reached = reached.or(Some("the read-out".into()));
        report::write(&folder.join("report.json"), report)?;
        Ok(words)
    }

    /// All that was asked for is written: there is nothing to go on with.
    pub fn done(self) -> Result<()> {
        match std::fs::remove_file(&self.file) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(Error::Write { path: self.file, source }),
            _ => Ok(()),
        }
    }
}

/// The solution in a folder where it is whole and of this very bake: without a checkpoint reading out is all there is
/// to do. Of a climb any rung will do.
pub fn already(folder: &Path, scene: &Scene, params: &Params, climb: bool) -> Option<Solution> {
    if folder.join(NAME).exists() && !climb {
        return None;
    }
    let solution = Solution::load(&folder.join("solution.rcell")).ok()?;
    let then = solution.scene();
    let same = !solution.is_partial()
        && solution.report().relit.is_none()
        && match climb {
            true => (0..=Params::LAST_RUNG).any(|n| params.rung(n) == solution.report().params),
            false => solution.report().params == *params,
        }
        && (then.space, &then.vertices, &then.faces, &then.materials)
            == (scene.space, &scene.vertices, &scene.faces, &scene.materials)
        && (&then.textures, &then.uvs, &then.face_uvs) == (&scene.textures, &scene.uvs, &scene.face_uvs);
    same.then_some(solution)
}

/// Takes over what an earlier run told of the very bake that `report` is of: its times, memory and rungs.
pub fn recall(report: &mut report::Report, folder: &Path) {
    let read = report::Report::read(folder).ok();
    let Some(before) = read.filter(|b| b.params == report.params && b.estimated_error == report.estimated_error) else { return };
    report.seconds = report::Seconds { readout: report.seconds.readout, ..before.seconds };
    report.effects = before.effects;
    report.memory_bytes = before.memory_bytes;
    report.extra = before.extra;
    if let (Some(now), Some(then)) = (&mut report.target, before.target) {
        now.rungs = then.rungs;
    }
}

/// A warning where a solution that was given is partial.
pub fn warn_if_partial(solution: &Solution, log: &Log) {
    if let Some(reached) = solution.report().reached.as_ref().filter(|_| solution.is_partial()) {
        log.warning(&format!(
            "this solution is partial, its light provisional: the bake was stopped at {reached}; raycell bake --resume goes on"
        ));
    }
}

/// The command line that goes on, to be pasted into a shell.
fn command(args: impl Iterator<Item = OsString>) -> String {
    let mut words: Vec<String> = args.map(|a| a.to_string_lossy().into_owned()).collect();
    if !words.iter().any(|w| w == "--resume") {
        let at = words.iter().position(|w| w == "bake").map_or(words.len(), |at| at + 1);
        words.insert(at, "--resume".into());
    }
    let plain = |w: &String| !w.is_empty() && w.chars().all(|c| c.is_ascii_alphanumeric() || "_-./,=:+@%".contains(c));
    let quoted: Vec<String> =
        words.into_iter().map(|w| if plain(&w) { w } else { format!("'{}'", w.replace('\'', r"'\''")) }).collect();
    quoted.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_can_be_pasted() {
        let of = |words: &[&str]| command(words.iter().map(OsString::from));
        assert_eq!(of(&["raycell", "bake", "a.obj", "-o", "out"]), "raycell bake --resume a.obj -o out");
        assert_eq!(of(&["raycell", "bake", "--resume", "a.obj"]), "raycell bake --resume a.obj");
        assert_eq!(of(&["raycell", "--quiet", "bake", "--", "it's.obj"]), r"raycell --quiet bake --resume -- 'it'\''s.obj'");
    }
}
