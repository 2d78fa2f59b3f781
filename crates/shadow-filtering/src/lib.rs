//! Filterable shadow maps: kernels, separable filters, percentage-closer filtering, and every technique as a pure
//! function of filtered data.
//!
//! The crate takes plain arrays of depths and knows nothing of scenes or graphics adapters. Depths are fractions of
//! the depth range, 0 at the light and 1 at the far plane; a texel that nothing covers has depth 1, as in a shadow map
//! cleared to the far plane. Shadow intensities are fractions of the kernel's weight: 0 lit, 1 in shadow.
//!
//! ```
//! use shadow_filtering::*;
//! // A caster at depth 0.3 over the left half of a receiver at depth 0.8.
//! let depths = (0..32 * 32).map(|t| if t % 32 < 16 { 0.3 } else { 0.8 }).collect();
//! let map = DepthMap::new(32, 32, depths)?;
//! let kernel = Kernel::gaussian(9, 2.4)?;
//! let technique = TechniqueSpec::Hamburger4(MomentOptions::default()).build()?;
//! let filtered = filter(&encode::<f64>(&map, technique.as_ref())?, &kernel);
//! let g = technique.shade(filtered.texel(16, 16), 0.8)?;
//! let f = kernel.distribution(&map, 16, 16).cdf(0.8);
//! assert!((g - f).abs() < 1e-4, "two surfaces are reconstructed: {g} and {f}");
//! # Ok::<(), FilteringError>(())
//! ```

#![deny(missing_docs)]

mod depth_map;
mod error;
mod filter;
mod kernel;
mod operations;
mod passes;
mod pcf;
mod pyramid;
mod real_time;
pub mod shaders;
mod spec;
mod stored;
mod stored_technique;
mod surfaces;
mod technique;
pub mod techniques;

pub use depth_map::{ChannelMap, DepthMap};
pub use error::FilteringError;
pub use filter::{encode, filter};
pub use kernel::{Kernel, KernelSpec, MAX_KERNEL_SIZE};
pub use operations::SPECIAL;
pub use passes::comparison_shaders;
pub use pcf::{DepthBias, Receiver, Reference};
pub use pyramid::{mip_chain, resolve};
pub use real_time::RealTime;
pub use spec::{MomentOptions, TechniqueSpec};
pub use stored::{StoredMap, StoredMoments};
pub use stored_technique::{Position, StoredTechnique};
pub use surfaces::SurfaceCounter;
pub use technique::{StorageFormat, Technique};
