//! What filterable shadow maps are used for, a folder each.
//!
//! An application asks a filtered field for moments over regions of its choice, shades them by a technique, and has its
//! own truth. Sampling, statistics, records and pictures are the business of `evaluation`, the same for all.
//!
//! ```
//! use applications::{Application, BiasSetting, HardShadow, ShadowMethod, errors};
//! use shadow_filtering::{DepthMap, Kernel, Receiver, TechniqueSpec};
//! // A caster at depth 0.3 over the left half of a receiver at depth 0.8.
//! let depths = (0..32 * 32).map(|t| if t % 32 < 16 { 0.3 } else { 0.8 }).collect();
//! let (map, kernel) = (DepthMap::new(32, 32, depths)?, Kernel::gaussian(9, 2.4)?);
//! let bias = BiasSetting::default();
//! let view = HardShadow { map: &map, kernel: &kernel, texel_depth: 1e-3, bias, plane_limit: 0.05 };
//! let receiver = Receiver { x: 16, y: 16, depth: 0.8, gradient: [0.0; 2] };
//! assert!(view.truth(&receiver) > 0.4);
//!
//! let technique = TechniqueSpec::named("hamburger4")?.build()?;
//! let method = ShadowMethod::Prefiltered(Box::new(technique));
//! let error = errors(&view, &method.prepare(&map, &kernel)?, &[receiver])?[0];
//! assert!(error.abs() < 1e-4, "two surfaces are reconstructed");
//! # Ok::<(), shadow_filtering::FilteringError>(())
//! ```

#![deny(missing_docs)]

mod application;
mod area_light;
pub mod field;
mod hard_shadow;
mod packed_values;
pub mod rays;
pub mod region;
pub mod samples;
pub mod scattering;
pub mod soft_shadow;
pub mod stochastic;
pub mod temporal;
pub mod translucency;

pub use application::{Application, Estimate, errors, truths};
pub use area_light::PlacedLight;
pub use hard_shadow::{BiasSetting, HardShadow, PreparedShadow, ShadowMethod};
