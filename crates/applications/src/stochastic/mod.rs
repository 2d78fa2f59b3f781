//! Soft shadows from one shadow map of rays that start all over the light (Liktor et al., *Stochastic Soft Shadow
//! Mapping*, 2015).

mod filter;
mod flatland;
mod lens_map;
mod level;
mod plane;
mod radius;

pub use filter::{FilterPlane, LightRay, PlaneSample, between_planes, filtered};
pub use flatland::{Segment, visible_length};
pub use lens_map::{Lens, LensMap, LensSample, STRATA};
pub use plane::{FilteredPlane, Footprint, PlaneError, PlaneFilter, SampleCentre, TILE, filter_plane};
pub use radius::{circle_of_confusion, coarser_weight};
