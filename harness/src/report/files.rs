//! Whole files or none.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use super::ReportError;

/// Makes a folder with all its parents; one that exists is fine.
pub(crate) fn create_directory(path: &Path) -> Result<(), ReportError> {
    // Asked first because the system's own message for a file in the way, "file exists", explains little.
    if path.exists() && !path.is_dir() {
        return Err(ReportError::NotADirectory { path: path.to_owned() });
    }
    fs::create_dir_all(path).map_err(|source| ReportError::CreateDirectory { path: path.to_owned(), source })
}

/// Looks whether a file could be written, by one beside its place that is gone again at once.
pub(crate) fn check_writable(path: &Path) -> Result<(), ReportError> {
    let fail = |source| ReportError::Write { path: path.to_owned(), source };
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

/// A document as JSON, for people too; `what` is the file's name, for the message.
pub(crate) fn json(what: &str, document: &impl serde::Serialize) -> Result<Vec<u8>, ReportError> {
    let made = serde_json::to_vec_pretty(document);
    let mut json = made.map_err(|error| ReportError::Made { what: what.to_owned(), reason: error.to_string() })?;
    json.push(b'\n');
    Ok(json)
}

/// Writes a file beside its place and renames it, so that readers see the old contents or the new, never a part.
pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), ReportError> {
    let fail = |source| ReportError::Write { path: path.to_owned(), source };
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
