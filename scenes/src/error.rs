//! What can be wrong with a scene.

use std::path::PathBuf;

/// Why there is no scene. Every message says what is wrong and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The catalogue has no scene of this name, or the scale factor is out of range.
    #[error("{0}")]
    Argument(String),
    /// The scene's file cannot be read.
    #[error("cannot read scene file '{}': {source}; check the path and its permissions", path.display())]
    Read {
        /// The path as it was given.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not what it says, breaks a rule of glTF or needs what is not supported, or one of its buffers cannot be read.
    #[error("{scene}: {problem}")]
    Invalid {
        /// Path of the scene's file, or its name if it was given as bytes.
        scene: String,
        /// What is wrong and what to do.
        problem: String,
    },
}

impl SceneError {
    /// Whether the caller's argument is at fault (name or scale), rather than a file.
    pub fn is_argument(&self) -> bool {
        matches!(self, Self::Argument(_))
    }
}
