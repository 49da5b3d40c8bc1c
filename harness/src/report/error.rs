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
    /// There is no run to read.
    #[error("there is no {}; give the folder that a run was written to, or its {file}", path.display())]
    Missing {
        /// The file looked for.
        path: PathBuf,
        /// What such files are called.
        file: &'static str,
    },
    /// A file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A compressed file that is damaged, or only the beginning of one.
    #[error("cannot unpack {}: {source}; it is damaged or cut short: copy it once more, or run again", path.display())]
    Packed {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file that is larger than records are, or would be unpacked.
    #[error("{} holds more than {} MiB of JSON, the most that is read of a record; give what a run was written to", path.display(), max_bytes >> 20)]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The most.
        max_bytes: u64,
    },
    /// What no run can have come to.
    #[error("{} is no record of a run: {reason}; it was changed or made by something else: run again", path.display())]
    Unmeasured {
        /// The file.
        path: PathBuf,
        /// What it says.
        reason: String,
    },
    /// A file that is not JSON, or only the beginning of it.
    #[error("{} is not a whole JSON document (truncated, or not a {file}): {source}; copy it once more, or run again", path.display())]
    NotJson {
        /// The file.
        path: PathBuf,
        /// What was looked for.
        file: &'static str,
        /// Where and why.
        source: serde_json::Error,
    },
    /// JSON without a schema number.
    #[error("{} has no \"schema\" and so is not a {file}; give the folder that a run was written to", path.display())]
    NoSchema {
        /// The file.
        path: PathBuf,
        /// What was looked for.
        file: &'static str,
    },
    /// A run of another version of this program.
    #[error(
        "{} follows schema {found}, this program reads schema {wanted}; {}", path.display(),
        if found == "2" { "convert it: cargo run --release --example convert_record -- FILE" }
        else { "use the version of the program that wrote it, or run again" }
    )]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its schema, as written there.
        found: String,
        /// The schema that this program reads.
        wanted: u32,
    },
    /// A file's contents cannot be made.
    #[error("cannot make {what}: {reason}")]
    NotMade {
        /// The file's name.
        what: String,
        /// Why.
        reason: String,
    },
}
