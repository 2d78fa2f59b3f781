//! Single scattering in participating media (BHS16 section 2).
//!
//! Radiance towards a camera at p from a view ray of direction v and length s, for a directional light that travels along l:
//! f E int_0^s e^(-sigma_t t) V(p + t v) dt. A [`Medium`] has sigma_t and the phase function f, a [`LightMap`] the visibility
//! V; [`Rectification`] maps view rays to rows of constant depth, so that prefix sums along rows answer all of them.

mod light_map;
mod medium;
mod prefix;
mod rectification;
mod resample;
mod two_depths;

pub use light_map::{LightMap, LitInterval};
pub use medium::{Medium, MediumError};
pub use prefix::{PrefixRow, adaptive_blend, scattered, step_weights};
pub use rectification::{Frustum, LightAxes, Rectification, RectificationError, Rectified};
pub use resample::{Resampled, resample};
pub use two_depths::{TwoDepths, two_depths};
