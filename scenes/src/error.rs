//! What can be wrong with a scene.

use std::path::PathBuf;

/// Why there is no scene. Every message says what is wrong and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The catalogue has no scene of this name.
    #[error("there is no scene named '{name}': use one of {known}, or a path that ends in .gltf or .glb")]
    UnknownScene {
        /// The name that was asked for.
        name: String,
        /// The names that there are, separated by commas.
        known: String,
    },
    /// The scale factor is not a number within its range.
    #[error("scene scale {scale} is out of range: use a number from {min} to {max}")]
    ScaleOutOfRange {
        /// The factor that was asked for.
        scale: f64,
        /// Least factor.
        min: f64,
        /// Greatest factor.
        max: f64,
    },
    /// The scene's file cannot be read.
    #[error("cannot read scene file '{}': {source}; check the path and its permissions", path.display())]
    Read {
        /// The path as it was given.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A buffer file that the scene's file names cannot be read.
    #[error(
        "{scene}: buffers[{buffer}] is in file '{}', which cannot be read: {source}; put it there, or export as .glb, which holds everything",
        path.display()
    )]
    ReadBuffer {
        /// Path of the scene's file, or its name if it was given as bytes.
        scene: String,
        /// Index of the buffer.
        buffer: usize,
        /// Where the file was looked for.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A required extension changes geometry in a way that is not understood here.
    #[error("{scene}: the file requires extension {extension}, which is not supported: {advice}")]
    RequiredExtension {
        /// Path of the scene's file, or its name if it was given as bytes.
        scene: String,
        /// Name of the extension.
        extension: String,
        /// What to do.
        advice: &'static str,
    },
    /// The file is not what it says, or breaks a rule of glTF.
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
        matches!(self, Self::UnknownScene { .. } | Self::ScaleOutOfRange { .. })
    }
}
