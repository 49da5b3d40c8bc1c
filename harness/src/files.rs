//! Whole files or none: every file is written beside its place and renamed, so no file is ever half-written.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockWriteGuard};

/// Why something could not be written. Every message names the file and what to do.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The output folder cannot be made.
    #[error("cannot create the output folder {}: {source}; choose another folder", path.display())]
    CreateDirectory {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The path given for the output folder is something else.
    #[error("{} is not a folder; choose another output folder", path.display())]
    NotADirectory {
        /// The path.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {source}; check that the folder may be written and the disk is not full", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file's contents cannot be made.
    #[error("cannot make {what}: {source}")]
    Json {
        /// The file's name.
        what: String,
        /// Why.
        source: serde_json::Error,
    },
}

/// Makes a folder with all its parents; one that exists is fine.
pub(crate) fn create_directory(path: &Path) -> Result<(), FileError> {
    // Asked first because the system's own message for a file in the way, "file exists", explains little.
    if path.exists() && !path.is_dir() {
        return Err(FileError::NotADirectory { path: path.to_owned() });
    }
    fs::create_dir_all(path).map_err(|source| FileError::CreateDirectory { path: path.to_owned(), source })
}

/// Looks whether a file could be written, by one beside its place that is gone again at once.
pub(crate) fn check_writable(path: &Path) -> Result<(), FileError> {
    let fail = |source| FileError::Write { path: path.to_owned(), source };
    check_place(path).map_err(fail)?;
    tempfile_beside(path).map(drop).map_err(fail)
}

/// A rename would put a file in the place of a folder's name or of a device such as /dev/null.
fn check_place(path: &Path) -> std::io::Result<()> {
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => {
            Err(std::io::Error::new(std::io::ErrorKind::AlreadyExists, "what is there is no regular file"))
        }
        _ => Ok(()),
    }
}

/// A temporary file in the same folder: a rename does not cross file systems.
fn tempfile_beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // The system's word alone: the temporary file's name would only puzzle.
    builder().tempfile_in(folder).map_err(|error| error.raw_os_error().map_or(error, std::io::Error::from_raw_os_error))
}

/// A document as JSON, on one line: results are kept, and indented they are twice as large. `what` is the file's name, for
/// the message.
pub(crate) fn json(what: &str, document: &impl serde::Serialize) -> Result<Vec<u8>, FileError> {
    let made = serde_json::to_vec(document);
    let mut json = made.map_err(|source| FileError::Json { what: what.to_owned(), source })?;
    json.push(b'\n');
    Ok(json)
}

/// Held for reading while a file is written.
static WRITING: RwLock<()> = RwLock::new(());

/// Lets no file be begun while what is given is there; those that were begun are whole by then. For who ends the process.
pub(crate) fn stop_writing() -> RwLockWriteGuard<'static, ()> {
    WRITING.write().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a file beside its place and renames it, so that readers see the old contents or the new, never a part.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), FileError> {
    let _writing = WRITING.read().unwrap_or_else(PoisonError::into_inner);
    let fail = |source| FileError::Write { path: path.to_owned(), source };
    check_place(path).map_err(fail)?;
    // Of a link the target is written, and the link stays.
    let target = if path.is_symlink() { fs::canonicalize(path).map_err(fail)? } else { path.to_owned() };
    let mut file = tempfile_beside(&target).map_err(fail)?;
    file.write_all(contents).map_err(fail)?;
    file.persist(&target).map_err(|error| fail(error.error))?;
    Ok(())
}

/// Temporary files are private by default; results are for everyone whom the user's mask lets read.
#[cfg(unix)]
fn builder() -> tempfile::Builder<'static, 'static> {
    use std::os::unix::fs::PermissionsExt as _;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tracebench-").permissions(fs::Permissions::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tracebench-");
    builder
}
