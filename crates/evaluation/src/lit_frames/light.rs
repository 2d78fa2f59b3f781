//! Maps from points of a light, and what they say of pixels.

use crate::error::EvaluationError;
use crate::fragments::light::{penumbra, placed};
use crate::fragments::texel_depth;
use applications::PlacedLight;
use applications::rays::PosedTriangles;
use applications::samples::PoissonTaps;
use applications::soft_shadow::{
    BlockerSearch, Filter, Fragment, Penumbra, percentage_closer_blockers, percentage_closer_soft_shadow,
};
use applications::temporal::{MapTexel, SampledField, Start, TracedMap};
use scenes::vector::dot;
use scenes::{LightView, Scene};
use shadow_filtering::{DepthBias, Receiver};
use shadow_renderer::LightFrame;
use std::cell::Cell;
use std::sync::atomic::AtomicU32;

/// A light with the frame of the map that its middle sees.
pub(crate) struct MappedLight {
    pub(crate) view: LightView,
    pub(crate) frame: LightFrame,
    pub(crate) placed: PlacedLight,
    pub(crate) penumbra: Penumbra<f64>,
    pub(crate) texel_depth: f64,
}

impl MappedLight {
    pub(crate) fn new(scene: &Scene, view: LightView, size: u32) -> Result<Self, EvaluationError> {
        let frame = LightFrame::of_view(scene, &view, size, size).map_err(|error| {
            EvaluationError::Value(format!("scene `{}`, view `{}`: {error}", scene.name, view.name))
        })?;
        let (placed, penumbra) = (placed(&view.light, &frame), penumbra(&view.light, &frame));
        Ok(Self { view, frame, placed, penumbra, texel_depth: texel_depth(&frame) })
    }

    /// Full size of the light: the geometric mean of both axes.
    pub(crate) fn size(&self) -> f64 {
        let [a, b] = self.penumbra.half_size;
        2.0 * (a * b).sqrt()
    }

    /// The frame of the map that a point of the light sees: the same planes, shifted so that the middle of the depth range
    /// falls on the same texels.
    pub(crate) fn seen_from(&self, point: [f64; 2]) -> LightFrame {
        let middle = self.placed.middle;
        let offset = self.placed.towards(middle, point);
        let centre = self.frame.near + 0.5 * self.frame.depth_range;
        let shift =
            [self.frame.right, self.frame.down].map(|axis| dot(offset, axis) * self.frame.near / centre);
        let origin_texel =
            [0, 1].map(|k| self.frame.origin_texel[k] + shift[k] * self.frame.texels_per_unit[k]);
        LightFrame { eye: Some([0, 1, 2].map(|k| middle[k] + offset[k])), origin_texel, ..self.frame }
    }
}

/// The map of a frame from one point of the light.
pub(crate) struct PointMap<'a> {
    pub(crate) frame: LightFrame,
    map: TracedMap<'a>,
    light: &'a MappedLight,
}

/// A pixel on a map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) fragment: Fragment<f64>,
    pub(crate) depth: f64,
}

/// A point of a surface on a map; `None` behind the light.
pub(crate) fn on_map(
    frame: &LightFrame,
    texel_depth: f64,
    (bias, plane_limit): (&DepthBias, f64),
    (position, normal): ([f64; 3], [f64; 3]),
) -> Option<Placed> {
    let [x, y, depth] = frame.project(position);
    let distance = frame.near + depth * frame.depth_range;
    if !(distance > 0.0 && x.is_finite() && y.is_finite()) {
        return None;
    }
    let gradient = frame.gradient(position, normal).map(|slope| if slope.is_finite() { slope } else { 0.0 });
    let receiver = Receiver { x: 0, y: 0, depth, gradient };
    let compared = bias.compared(&receiver, texel_depth, plane_limit);
    let fragment = Fragment { position: [x, y], depth, bias: depth - compared, noise: [0.5; 2] };
    Some(Placed { fragment, depth })
}

impl<'a> PointMap<'a> {
    pub(crate) fn new(
        scene: PosedTriangles<'a>,
        light: &'a MappedLight,
        point: [f64; 2],
        memory: Vec<AtomicU32>,
    ) -> Self {
        let frame = light.seen_from(point);
        let ray = move |[x, y]: [f64; 2]| {
            let (near, far) = (frame.unproject([x, y, 0.0]), frame.unproject([x, y, 1.0]));
            [near, [0, 1, 2].map(|k| far[k] - near[k])]
        };
        let size = [frame.width as usize, frame.height as usize];
        Self { frame, map: TracedMap::new(scene, size, ray, memory), light }
    }

    /// The same map where another one of the same rays knows what stands still.
    pub(crate) fn over(self, still: &'a PointMap<'_>) -> Self {
        Self { map: self.map.over(&still.map), ..self }
    }

    pub(crate) fn into_memory(self) -> Vec<AtomicU32> {
        self.map.into_memory()
    }

    /// tau, the distance of what the map saw, and whether that moves.
    pub(crate) fn test(&self, placed: &Placed) -> (bool, f64, bool) {
        let MapTexel { depth, moving } = self.map.at(placed.fragment.position);
        (depth < placed.depth - placed.fragment.bias, self.distance(depth), moving)
    }

    /// Distance from the light's plane.
    pub(crate) fn distance(&self, depth: f64) -> f64 {
        self.frame.near + depth * self.frame.depth_range
    }

    /// Percentage-closer soft shadows with a few taps.
    pub(crate) fn start(&self, placed: &Placed, taps: &PoissonTaps) -> Start {
        let moving = Cell::new(false);
        let depth = |position: [f64; 2]| {
            let texel = self.map.at(position);
            moving.set(moving.get() || texel.moving);
            texel.depth
        };
        let field = SampledField { depth, taps };
        let search = BlockerSearch::percentage_closer();
        let penumbra = &self.light.penumbra;
        let found = percentage_closer_blockers(&field, penumbra, &search, &placed.fragment);
        let blocker = (found.mass > 0.0).then(|| self.distance(found.average(placed.depth, 0.0)));
        let moving = moving.get();
        let filter = Filter::published();
        let fraction = percentage_closer_soft_shadow(&field, penumbra, &search, &filter, &placed.fragment);
        Start { fraction, blocker, moving }
    }
}
