//! Shadows of translucent surfaces (BHS16 section 4): a light ray leaves a distribution of where its light was taken, and
//! the bounds of opaque shadows apply to it as they are.

mod fourier;
mod layers;

pub use fourier::FourierOpacity;
pub use layers::{Layer, LayerError, blended, in_front, taken};
