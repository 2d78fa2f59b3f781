//! What renders, and what solves linear programs.

use clap::ValueEnum;

/// Where work is done.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum BackendName {
    /// The CPU.
    Cpu,
    /// A graphics processor.
    Gpu,
    /// A graphics processor if there is a fast one, else the CPU.
    Auto,
}

macro_rules! backend {
    ($backend:ty) => {
        impl From<BackendName> for $backend {
            fn from(name: BackendName) -> Self {
                match name {
                    BackendName::Cpu => Self::Cpu,
                    BackendName::Gpu => Self::Gpu,
                    BackendName::Auto => Self::Auto,
                }
            }
        }
    };
}

backend!(evaluation::Backend);
backend!(shadow_renderer::Backend);
