//! Shadows of translucent surfaces (BHS16 section 4): a light ray leaves a distribution of where its light was taken, and
//! the bounds of opaque shadows apply to it as they are.

mod absorption;
mod blending;
mod fourier;
mod layered_map;
mod layers;
mod method;
mod stochastic;

pub use absorption::{NEARLY_OPAQUE, OpaqueOccluders, Series, absorption_map};
pub use blending::{Rounding, blended_map, blended_texel};
pub use fourier::FourierOpacity;
pub use layered_map::{LayeredMap, TranslucentShadow};
pub use layers::{Layer, LayerError, blended, in_front, taken};
pub use method::{PreparedTranslucent, TranslucentMethod, Treatment};
pub use stochastic::StochasticMap;
