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
//! let technique = TechniqueSpec::named("hamburger4")?.build()?;
//! let filtered = filter(&encode::<f64>(&map, &technique)?, &kernel);
//! let g = technique.shade(filtered.texel(16, 16), 0.8)?;
//! let f = kernel.distribution(&map, 16, 16).cdf(0.8);
//! assert!((g - f).abs() < 1e-4, "two surfaces are reconstructed: {g} and {f}");
//! # Ok::<(), FilteringError>(())
//! ```

#![deny(missing_docs)]

mod basis;
mod bound;
mod compute_passes;
mod depth_map;
mod encoding;
mod error;
mod kernel;
mod operations;
mod passes;
mod pcf;
mod regions;
mod spec;
mod standalone;
mod surfaces;
mod technique;
mod techniques;
mod transforms;
pub mod wgsl;

pub use basis::{AnyBasis, DepthBasis};
pub use bound::{AnyBound, RealTime, ShadowBound};
pub use depth_map::{ChannelMap, DepthMap};
pub use error::FilteringError;
pub use kernel::{Kernel, KernelSpec, MAX_KERNEL_SIZE};
pub use operations::SPECIAL;
pub use passes::comparison_shaders;
pub use pcf::{DepthBias, Receiver, Reference};
pub use regions::{
    KernelField, MipTexel, Position, Pyramid, StoredField, SummedAreaField, encode, filter, resolve,
};
pub use spec::{BoundName, Range, TechniqueSpec};
pub use standalone::{ShadowPass, Surroundings};
pub use surfaces::SurfaceCounter;
pub use technique::{Precision, Technique};
pub use techniques::BiasedMoments;
