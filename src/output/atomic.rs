//! Whole files or none: write beside the target, flush to disk, rename.

use crate::error::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file so that a reader sees the old bytes or all the new ones, never a part.
///
/// What is not a plain file (a pipe, `/dev/stdout`) is written to directly.
/// Errors: [`Error::Write`]; the temporary file is gone then.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let result = match std::fs::metadata(path) {
        Ok(there) if !there.is_file() && !there.is_dir() => {
            OpenOptions::new().write(true).open(path).and_then(|mut file| file.write_all(bytes))
        }
        _ => replace(path, bytes),
    };
    result.map_err(|source| Error::Write { path: path.into(), source })
}

/// Refuses a folder in which no file can be made, before work is done for it. Errors: [`Error::Write`].
pub fn check_folder(path: &Path) -> Result<()> {
    let probe = path.join(format!(".raycell.{}.tmp", std::process::id()));
    let made = OpenOptions::new().write(true).create(true).truncate(true).open(&probe);
    let gone = made.and_then(|_| std::fs::remove_file(&probe));
    gone.map_err(|source| Error::Write { path: path.into(), source })
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    // A name of our own, also where several processes write the same file.
    let (temporary, mut file) = (0..)
        .map(|n| {
            let mut hidden = std::ffi::OsString::from(".");
            hidden.push(name);
            hidden.push(format!(".{}-{n}.tmp", std::process::id()));
            let path = folder.join(hidden);
            let file = OpenOptions::new().write(true).create_new(true).open(&path);
            (Temporary(path), file)
        })
        .find_map(|(path, file)| match file {
            Ok(file) => Some(Ok((path, file))),
            Err(e) => {
                // Not ours to remove.
                std::mem::forget(path);
                (e.kind() != io::ErrorKind::AlreadyExists).then_some(Err(e))
            }
        })
        .unwrap_or_else(|| Err(io::ErrorKind::AlreadyExists.into()))?;
    file.write_all(bytes)?;
    file.sync_all()?;
    drop(file);
    std::fs::rename(&temporary.0, path)?;
    std::mem::forget(temporary);
    // The rename itself reaches the disk with the folder; some systems cannot open one, and need not.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Removes the temporary file unless it has been renamed.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_whole_and_nothing_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.bin");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        // A folder in the way: refused, and no temporary stays.
        std::fs::create_dir(dir.path().join("b")).unwrap();
        std::fs::write(dir.path().join("b/inside"), b"").unwrap();
        assert!(matches!(write(&dir.path().join("b"), b"x"), Err(Error::Write { .. })));
        assert!(matches!(write(&dir.path().join("gone/c"), b"x"), Err(Error::Write { .. })));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 2);
    }
}
