//! Frames of scenes that may move, lit by an area light: what the kinds that sample the light itself start from.

mod light;
mod made_anew;
mod scenery;
mod settings;

pub(crate) use light::{MappedLight, Placed, PointMap, on_map};
pub(crate) use made_anew::{Anew, Lit, Ready, TAP_STREAM, middle_map};
pub(crate) use scenery::{Scenery, Seen, Sight, Stage, Whole, Window, largest_coordinate};
pub use settings::ScaledLight;
pub(crate) use settings::{MAX_FRAME_SIDE, check_zoom};
