//! What filterable shadow maps are used for.
//!
//! An application asks a filtered field for moments over regions of its choice, shades them by a technique, and has
//! its own truth.

#![deny(missing_docs)]

mod area_light;
pub mod field;
pub mod rays;
pub mod region;
pub mod samples;
pub mod scattering;
pub mod soft_shadow;
pub mod stochastic;
pub mod temporal;
mod vector;

pub use area_light::{AreaLight, LightError, Outline, PlacedLight, SUN_DEGREES};
