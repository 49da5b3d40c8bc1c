//! Rays, truth, scenes and answers as files that any program reads: `.npy` arrays, one a field, a manifest and a `.glb` (docs/exchange.md).

pub mod answers;
mod glb;
pub mod npy;
mod rays;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use tracebench_scenes::SceneError;

pub use glb::{SCENE_FILE, glb, write_scene};
pub(crate) use rays::is_name;
pub use rays::{
    MANIFEST, Manifest, NO_TRIANGLE, SavedRays, TRUTHS_CHECKED, check_truth, ray_set, read, read_truth, scene, write,
};

use crate::files::FileError;

/// Why files of rays or answers cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ExchangeError {
    /// A file cannot be read.
    #[error("cannot read {path}: {1}; check that it is there and may be read", path = .0.display())]
    Read(PathBuf, #[source] io::Error),
    /// A file, which is the field of its name, is not what it must be: what is wrong, and what to do.
    #[error("{path}: {1}", path = .0.display())]
    Invalid(PathBuf, String),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The scene cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl ExchangeError {
    fn invalid(path: &Path, problem: impl Into<String>) -> Self {
        Self::Invalid(path.to_owned(), problem.into())
    }
}

/// The most bytes of a text beside arrays.
const MAX_TEXT: u64 = 1 << 20;

/// A whole small file.
fn text(path: &Path) -> Result<String, ExchangeError> {
    let fail = |source| ExchangeError::Read(path.to_owned(), source);
    let mut text = String::new();
    open(path)?.take(MAX_TEXT + 1).read_to_string(&mut text).map_err(fail)?;
    if text.len() as u64 > MAX_TEXT {
        return Err(ExchangeError::invalid(path, format!("has more than {MAX_TEXT} bytes")));
    }
    Ok(text)
}

/// A regular file, opened: a pipe may never end.
fn open(path: &Path) -> Result<File, ExchangeError> {
    let fail = |source| ExchangeError::Read(path.to_owned(), source);
    if !path.metadata().map_err(fail)?.is_file() {
        return Err(fail(io::Error::new(io::ErrorKind::InvalidInput, "it is no regular file")));
    }
    File::open(path).map_err(fail)
}
