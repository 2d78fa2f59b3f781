//! Shadow rays against triangles.
//!
//! A tree of boxes (`obvhs`, eight children a node, in single precision) proposes triangles, an edge test in double
//! precision decides. Neither lets a ray through between two triangles that share an edge or a vertex:
//! - boxes are padded by more than the tree's rounding moves a ray (`tree`);
//! - the sign that the edge test computes is never the opposite of the right one, and zero counts as inside
//!   (`edge_test`).
//!
//! Where a triangle has an alpha mask, the mask's texel decides last, the same that decides in shadow maps (`masks`).

mod boxes;
mod edge_test;
mod masks;
mod posed;
mod query;
mod tree;

pub use posed::PosedTriangles;
pub use query::{LastOccluder, Segment, Surface};
pub use tree::{TriangleError, Triangles};

#[cfg(test)]
mod tests;
