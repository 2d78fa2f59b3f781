//! Single scattering in participating media (BHS16 section 2).

mod two_depths;

pub use two_depths::{TwoDepths, two_depths};
