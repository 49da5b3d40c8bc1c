//! Whole files or none: every file is written beside its place and renamed, so no file is ever half-written. No file of somebody else is
//! ever replaced.

mod folder;
#[cfg(test)]
mod tests;

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

pub use folder::{LIST, OutputFolder};

/// How many names a message has at most.
const MAX_NAMES: usize = 12;

/// Why something could not be written. Every message names the file and what to do.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// A folder cannot be made, or nothing can be written into it.
    #[error("cannot write to the output folder {path}: {1}; choose another with --out", path = .0.display())]
    Folder(PathBuf, #[source] io::Error),
    /// A file cannot be written.
    #[error("cannot write {path}: {1}; check that the folder may be written and the disk is not full", path = .0.display())]
    Write(PathBuf, #[source] io::Error),
    /// Files of somebody else lie in a folder where others are to be written, each with the reason.
    #[error(
        "{path} holds what tracebench did not write there or what was changed since: {names}; it stays as it is: move it away, or choose another place",
        path = .0.display(), names = some(.1)
    )]
    InTheWay(PathBuf, Vec<String>),
    /// Another process is at a folder.
    #[error("another process writes into {path}; wait for it, or choose another folder", path = .0.display())]
    Busy(PathBuf),
    /// What has the name of a list is none.
    #[error("{path} is no list of files that tracebench wrote: {1}; move it away, or choose another folder", path = .0.display())]
    NoList(PathBuf, #[source] io::Error),
    /// A file's contents cannot be made.
    #[error("cannot make {0}: {1}")]
    Json(String, #[source] serde_json::Error),
}

fn some(names: &[String]) -> String {
    let more = names.len().saturating_sub(MAX_NAMES);
    let shown = names[..names.len() - more].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// Writes a single file, which the list of its folder then has.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    let (folder, name) = OutputFolder::of_file(path)?;
    folder.write(&name, contents).map(drop)
}

/// Writes a document of the user's anew, as its author would.
pub(crate) fn edit(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    let _writing = writing();
    let edit = || {
        if !fs::symlink_metadata(path)?.is_file() {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, "what is there is no regular file"));
        }
        let mut file = temporary(path.parent().unwrap_or(Path::new("")))?;
        file.write_all(contents)?;
        file.persist(path).map(drop).map_err(|error| error.error)
    };
    edit().map_err(|source| FileError::Write(path.to_owned(), source))
}

/// A temporary file in a folder: a rename does not cross file systems.
fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tracebench-");
    // Temporary files are private by default; results are for everyone whom the user's mask lets read.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The system's word alone: the temporary file's name would only puzzle.
    builder.tempfile_in(folder).map_err(|error| error.raw_os_error().map_or(error, io::Error::from_raw_os_error))
}

/// A document as JSON, on one line: results are kept, and indented they are twice as large. `what` is the file's name, for
/// the message.
pub(crate) fn json(what: &str, document: &impl serde::Serialize) -> Result<Vec<u8>, FileError> {
    let made = serde_json::to_vec(document);
    let mut json = made.map_err(|source| FileError::Json(what.to_owned(), source))?;
    json.push(b'\n');
    Ok(json)
}

/// Held for reading while a file is written.
static WRITING: RwLock<()> = RwLock::new(());

fn writing() -> RwLockReadGuard<'static, ()> {
    WRITING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Lets no file be begun while what is given is there; those that were begun are whole by then. For who ends the process.
pub(crate) fn stop_writing() -> RwLockWriteGuard<'static, ()> {
    WRITING.write().unwrap_or_else(PoisonError::into_inner)
}
