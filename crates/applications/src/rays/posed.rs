//! Triangles that stand still, and others that move as one.

use scenes::Pose;

use super::tree::Triangles;

/// A scene in one frame. The tree of what moves is built once, where it is modelled; rays are moved in its place.
#[derive(Clone, Copy)]
pub struct PosedTriangles<'a> {
    /// What stands still.
    pub still: &'a Triangles,
    /// What moves, and where it is.
    pub moving: Option<(&'a Triangles, Pose)>,
}

impl PosedTriangles<'_> {
    /// The first surface on the way from `origin` along `direction`: the fraction of the direction in \[0, 1\], and whether it
    /// moves. Of two equally near ones the one that stands still.
    pub fn first(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, bool)> {
        let still = self.still.first(origin, direction, false).map(|(at, _)| (at, false));
        let moving = self.first_moving(origin, direction).map(|at| (at, true));
        match (still, moving) {
            (Some(still), Some(moving)) => Some(if moving.0 < still.0 { moving } else { still }),
            (still, moving) => still.or(moving),
        }
    }

    /// The first surface that moves, the others left out.
    pub fn first_moving(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
        let (triangles, pose) = self.moving?;
        let (origin, direction) = (pose.part_position(origin), pose.part_direction(direction));
        triangles.first(origin, direction, false).map(|(at, _)| at)
    }
}
