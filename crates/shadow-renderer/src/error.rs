//! Everything that can go wrong between a scene and its stack, one clear line each.

use std::path::PathBuf;

use graphics_device::DeviceError;
use scenes::InvalidScene;

/// Why no stack, frame or file could be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// Width or height is 0 or above [`crate::MAX_MAP_SIZE`].
    #[error("map size {width}x{height} is not supported: each side must lie in 1..={}", crate::MAX_MAP_SIZE)]
    MapSize {
        /// Requested width in texels.
        width: u32,
        /// Requested height in texels.
        height: u32,
    },
    /// The light direction is zero, infinite or not a number.
    #[error("light direction ({}, {}, {}) must be finite and not zero", .0[0], .0[1], .0[2])]
    LightDirection([f32; 3]),
    /// A local light lies inside the scene or behind it.
    #[error(transparent)]
    Light(#[from] crate::LocalLightError),
    /// The raster pipeline draws the maps of directional lights only.
    #[error(
        "depth maps and frames of the raster pipeline are made for directional lights, not for local ones"
    )]
    Perspective,
    /// The camera cannot see: a value is not finite, eye equals target, or the field of view is not in (0, pi).
    #[error("camera cannot be used: {0}")]
    Camera(&'static str),
    /// The scene has no triangles, a list of it refers to something that is not there, or a number is not finite.
    #[error(transparent)]
    Scene(#[from] InvalidScene),
    /// With a light frame of the caller's choice, a vertex projects too far outside of the map for exact coverage.
    #[error("vertex {vertex} projects to texel ({x}, {y}), more than {limit} texels from the map's origin")]
    GuardBand {
        /// Index into the scene's vertices.
        vertex: usize,
        /// Texel coordinate of the projection.
        x: f64,
        /// Texel coordinate of the projection.
        y: f64,
        /// Largest magnitude supported.
        limit: u32,
    },
    /// More fragments than 32-bit offsets can number.
    #[error(
        "the stack would have {at_least} fragments or more; 32-bit offsets end at {}: use a smaller map",
        u32::MAX
    )]
    TooManyFragments {
        /// Fragments counted or estimated when the work stopped.
        at_least: u64,
    },
    /// The estimated or requested memory is not available.
    #[error(
        "{what} needs about {needed_mib} MiB of memory, {available_mib} MiB are available: use a smaller map"
    )]
    OutOfMemory {
        /// What was about to be allocated.
        what: &'static str,
        /// Estimate of the need, MiB.
        needed_mib: u64,
        /// Available memory, MiB.
        available_mib: u64,
    },
    /// Several lists of a stack contradict each other or contain values outside their domain.
    #[error("stack array '{array}' is invalid: {what}")]
    InvalidStack {
        /// Name of the array as in the file.
        array: &'static str,
        /// What is wrong, with index and value.
        what: String,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file concerned.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A file is no `.npz` archive or lacks an array of the expected type.
    #[error("{}: {what}", path.display())]
    Archive {
        /// The file concerned.
        path: PathBuf,
        /// What was expected and what was found.
        what: String,
    },
    /// The graphics device could not be used; [`crate::render_stack`] answers this by using the CPU.
    #[error("graphics device: {0}")]
    Gpu(#[from] DeviceError),
}
