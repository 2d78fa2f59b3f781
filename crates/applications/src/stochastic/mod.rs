//! Soft shadows from one shadow map of rays that start all over the light (Liktor et al., *Stochastic Soft Shadow
//! Mapping*, 2015).

mod edges;
mod filter;
mod flatland;
mod layout;
mod lens_map;
mod level;
mod merging;
mod plane;
mod radius;
mod shaders;
mod shading;

pub use filter::{FilterPlane, LightRay, PlaneSample, between_planes, filtered};
pub use flatland::{Segment, visible_length};
pub use lens_map::{Lens, LensMap, LensSample, STRATA};
pub use plane::{FilteredPlane, Footprint, PlaneError, PlaneFilter, SampleCentre, TILE, filter_plane};
pub use radius::{circle_of_confusion, coarser_weight};
pub use shaders::{FilterPass, FilterShaders, plane_uniform};
pub use shading::{PlaneFragment, PlaneSet};
