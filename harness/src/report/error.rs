//! What can go wrong when results are written or read.

use std::io;
use std::path::PathBuf;

use crate::files::FileError;

/// Why results could not be written or read. Every message names the file and, where the user can do something, what.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file or folder cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// There is no run to read: the file looked for, and what such files are called.
    #[error("there is no {path}; give the folder that a run was written to, or its {1}", path = .0.display())]
    Missing(PathBuf, &'static str),
    /// A file cannot be read.
    #[error("cannot read {path}: {1}", path = .0.display())]
    Read(PathBuf, #[source] io::Error),
    /// A compressed file that is damaged, or only the beginning of one.
    #[error("cannot unpack {path}: {1}; it is damaged or cut short: copy it once more, or run again", path = .0.display())]
    Packed(PathBuf, #[source] io::Error),
    /// A file that is larger than records are, or would be unpacked, with the most bytes.
    #[error("{path} holds more than {mib} MiB of JSON, the most that is read of a record; give what a run was written to", path = .0.display(), mib = .1 >> 20)]
    TooLarge(PathBuf, u64),
    /// What no run can have come to: what the file says.
    #[error("{path} is no record of a run: {1}; it was changed or made by something else: run again", path = .0.display())]
    Unmeasured(PathBuf, String),
    /// A file that is not JSON, or only the beginning of it; what was looked for, where and why.
    #[error("{path} is not a whole JSON document (truncated, or not a {1}): {2}; copy it once more, or run again", path = .0.display())]
    NotJson(PathBuf, &'static str, #[source] serde_json::Error),
    /// JSON without a schema number, and what was looked for.
    #[error("{path} has no \"schema\" and so is not a {1}; give the folder that a run was written to", path = .0.display())]
    NoSchema(PathBuf, &'static str),
    /// A run of another version of this program: its schema, as written there, and the one that this program reads.
    #[error("{path} follows schema {1}, this program reads schema {2}; use the version of the program that wrote it, or run again", path = .0.display())]
    Schema(PathBuf, String, u32),
    /// A file's contents cannot be made: its name, and why.
    #[error("cannot make {0}: {1}")]
    NotMade(String, String),
}
