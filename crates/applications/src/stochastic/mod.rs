//! Soft shadows from one shadow map of rays that start all over the light (Liktor et al., *Stochastic Soft Shadow
//! Mapping*, 2015).

mod radius;

pub use radius::{circle_of_confusion, coarser_weight};
