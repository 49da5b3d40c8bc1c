//! Why a tracer could not build or trace.

use crate::ParameterError;

/// A tracer's refusal or failure. Every message says what is wrong and, where the user can do something, what.
#[derive(Debug, Clone, thiserror::Error)]
pub enum TracerError {
    /// This machine lacks what the tracer needs; with `all` the tracer is skipped with this reason.
    #[error("not available on this machine: {0}")]
    Unavailable(String),
    /// A buffer or texture is larger than the device can create or bind.
    #[error("{name} needs {bytes} bytes, the device allows {limit}: turn down {hint}")]
    TooLarge {
        /// The structure's name, as its paper calls it.
        name: String,
        /// Bytes (or, for a texture's edge, texels) asked for.
        bytes: u64,
        /// The device's limit in the same unit.
        limit: u64,
        /// The parameter or option that makes it smaller.
        hint: String,
    },
    /// The query or end point is one that this tracer does not serve.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// It was told what it cannot be told, or not all.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The device reported an error, or the structure cannot be used.
    #[error("{0}")]
    Failed(String),
}
