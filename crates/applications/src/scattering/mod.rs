//! Single scattering in participating media (BHS16 section 2).
//!
//! Radiance towards a camera at p from a view ray of direction v and length s, for a directional light that travels along l:
//! f E int_0^s e^(-sigma_t t) V(p + t v) dt. A [`Medium`] has sigma_t and the phase function f, a [`LightMap`] the visibility
//! V; [`Rectification`] maps view rays to rows of constant depth, so that prefix sums along rows answer all of them.
//!
//! As an [`Application`](crate::Application), [`SingleScattering`] asks for the lit share: the integral over the same with V = 1.

mod light_map;
mod marched;
mod medium;
mod prefiltered;
mod prefix;
mod rectification;
mod rectified_map;
mod resample;
mod shaders;
mod spacing;
#[cfg(test)]
mod tests;
mod two_depths;
mod view;

pub use light_map::{LightMap, LitInterval};
pub use marched::{Jitter, Marched};
pub use medium::{Medium, MediumError};
pub use prefiltered::{Blending, ExactPrefixes, Prefiltered, StoredPrefixes};
pub use prefix::{adaptive_blend, prefix_means, relative_weights, scattered, step_weights};
pub use rectification::{Frustum, LightAxes, Rectification, RectificationError, Rectified};
pub use rectified_map::{FilteredDepths, RectifiedMap, RectifiedTexel};
pub use resample::{Resampled, resample};
pub use shaders::{
    look_up_between_shader, look_up_shader, march_shader, prefix_map_shader, prefix_words,
    resample_filtered_shader, resample_shader, scattering_uniform,
};
pub use spacing::Spacing;
pub use two_depths::{TwoDepths, two_depths};
pub use view::{SingleScattering, ViewRay};
