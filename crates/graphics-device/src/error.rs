//! Why a graphics device could not be used.

use shaders::ShaderError;

/// What a graphics device answers instead of a result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DeviceError {
    /// There is no adapter, or it gives no device; the reason.
    #[error("no adapter: {0}")]
    NoAdapter(String),
    /// The device is gone, and everything on it: only a new one can go on; the driver's reason.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// A buffer or texture does not fit.
    #[error("out of graphics memory")]
    OutOfMemory,
    /// Something that this adapter does not offer.
    #[error("{0}")]
    Unsupported(String),
    /// A shader that cannot be run.
    #[error(transparent)]
    Shader(#[from] ShaderError),
    /// Work that was refused or failed; the device's words.
    #[error("{0}")]
    Failed(String),
}

impl DeviceError {
    pub(crate) fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }
}
