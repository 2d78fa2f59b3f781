//! Views with their receivers: fragments of the stack, and pixels of the camera.

use super::settings::SoftShadowsExperiment;
use crate::error::EvaluationError;
use crate::fragments::light::{penumbra, placed};
use crate::fragments::{Lit, LoadedScene, Seen, Source, chosen};
use applications::PlacedLight;
use applications::rays::{Surface, Triangles};
use applications::soft_shadow::{
    AreaTruth, BlockerSearch, BlueNoise, Fragment, OccludedFraction, SoftReceiver, SoftShadow,
    percentage_closer_blockers,
};
use rayon::prelude::*;
use scenes::{AreaLight, LightView, Outline, Scene};
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, DepthMap, Kernel, Receiver};
use shadow_renderer::{Frame, LightFrame, ShadowMapStack};

/// Which receivers.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Population {
    /// Light-facing entries of the stack, seen or not.
    Fragments,
    /// What the camera sees of surfaces that face the light.
    Camera,
}

pub(super) const POPULATIONS: [Population; 2] = [Population::Fragments, Population::Camera];

/// A shaded point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) receiver: Receiver,
    pub(super) position: [f64; 2],
    pub(super) surface: Surface,
    stream: u64,
    noise: [f64; 2],
}

/// A scene for maps and rays.
pub(super) struct SoftScene<'a> {
    pub(super) loaded: &'a LoadedScene<'a>,
    pub(super) scene: &'a Scene,
    pub(super) triangles: Triangles,
    pub(super) seen: Frame,
}

/// A light direction of a scene.
pub(super) struct SoftView<'a> {
    pub(super) scene: &'a SoftScene<'a>,
    pub(super) light: &'a LightView,
    pub(super) stack: std::borrow::Cow<'a, ShadowMapStack>,
    pub(super) map: DepthMap,
    pub(super) texel_depth: f64,
    pub(super) frame: LightFrame,
    /// All of each population.
    pub(super) all: [usize; 2],
    /// Of which no triangle was found near.
    pub(super) lost: [usize; 2],
    /// Those evaluated.
    pub(super) points: [Vec<Point>; 2],
    plane_limit: f64,
}

/// How far a fragment may lie from its triangle along the light, in depths and in depths per texel of slope: the map's
/// coordinates are whole multiples of 2^-24 and of 1/256 texel.
const REACH: [f64; 2] = [1e-6, 0.02];

/// Streams of a view; those of a population are half of it.
const STREAMS: u64 = 1 << 33;

impl<'a> SoftScene<'a> {
    pub(super) fn new(
        experiment: &SoftShadowsExperiment,
        index: usize,
        loaded: &'a LoadedScene<'a>,
    ) -> Result<Self, EvaluationError> {
        let key = format!("scenes[{index}]");
        let Source::Scene(scene) = &loaded.source else {
            let reason = format!("scene `{}` is a stack: shadow rays need triangles", loaded.label);
            return Err(EvaluationError::key(key, reason));
        };
        let fail = |reason: String| {
            EvaluationError::key(key.as_str(), format!("scene `{}`: {reason}", loaded.label))
        };
        let triangles = Triangles::of_scene(scene).map_err(|error| fail(error.to_string()))?;
        let [width, height] = experiment.camera;
        let seen = Frame::render(scene, width, height).map_err(|error| fail(error.to_string()))?;
        Ok(Self { loaded, scene, triangles, seen })
    }
}

impl<'a> SoftView<'a> {
    /// Renders and samples. `number` counts views over all scenes.
    pub(super) fn new(
        experiment: &SoftShadowsExperiment,
        (kernel, noise): (&Kernel, &BlueNoise),
        scene: &'a SoftScene<'a>,
        light: &'a LightView,
        number: usize,
    ) -> Result<Self, EvaluationError> {
        let Lit { stack, map, texel_depth, frame, receivers } =
            scene.loaded.lit(light, experiment.scenery.size, kernel)?;
        let frame = frame.ok_or_else(|| {
            EvaluationError::Value(format!("scene `{}`: a stack has no frame", scene.loaded.label))
        })?;
        let seen = Seen { frame: &scene.seen, light: &frame };
        let pixels: Vec<usize> =
            (0..seen.len()).filter(|&i| seen.receiver(i).is_some() && seen.faces_light(i)).collect();
        let wanted = [experiment.scenery.fragments, experiment.pixels];
        let all = [receivers.len(), pixels.len()];
        let width = scene.seen.width as usize;
        let points = [0, 1].map(|population| {
            let stream = number as u64 * STREAMS + population as u64 * (STREAMS / 2);
            let streams = 2 * number + population;
            let indices = chosen(all[population], wanted[population], experiment.scenery.seed, streams);
            let point = |&index: &usize| {
                let (receiver, position, at) = if population == 0 {
                    let receiver = receivers[index];
                    let at = [receiver.x, receiver.y];
                    (receiver, at.map(|texel| texel as f64 + 0.5), at)
                } else {
                    let pixel = pixels[index];
                    let (receiver, at) = seen.receiver(pixel)?;
                    (receiver, [at.x, at.y], [pixel % width, pixel / width])
                };
                let surface = surface(&scene.triangles, &frame, &receiver, position)?;
                let noise = noise.at(at[0], at[1]);
                Some(Point { receiver, position, surface, stream: stream + index as u64, noise })
            };
            let found: Vec<Option<Point>> = indices.par_iter().map(point).collect();
            (found.len(), found.into_iter().flatten().collect::<Vec<Point>>())
        });
        let lost = [0, 1].map(|k| points[k].0 - points[k].1.len());
        Ok(Self {
            scene,
            light,
            stack,
            map,
            texel_depth,
            frame,
            all,
            lost,
            points: points.map(|(_, points)| points),
            plane_limit: experiment.scenery.plane_limit,
        })
    }

    /// Every pixel of a frame as a receiver; `None` for those that do not face the light.
    pub(super) fn of_camera(&self, frame: &Frame, noise: &BlueNoise) -> Vec<Option<Point>> {
        let seen = Seen { frame, light: &self.frame };
        let width = frame.width as usize;
        let point = |pixel: usize| {
            let (receiver, at) = seen.receiver(pixel)?;
            let position = [at.x, at.y];
            if !seen.faces_light(pixel) {
                return None;
            }
            let surface = surface(&self.scene.triangles, &self.frame, &receiver, position)?;
            let noise = noise.at(pixel % width, pixel / width);
            Some(Point { receiver, position, surface, stream: pixel as u64, noise })
        };
        (0..seen.len()).into_par_iter().map(point).collect()
    }

    /// A point under a depth bias.
    pub(super) fn receiver(&self, point: &Point, bias: &DepthBias) -> SoftReceiver {
        let depth = point.receiver.depth;
        let compared = bias.compared(&point.receiver, self.texel_depth, self.plane_limit);
        SoftReceiver {
            surface: point.surface,
            fragment: Fragment {
                position: point.position,
                depth,
                bias: depth - compared,
                noise: point.noise,
            },
            stream: point.stream,
        }
    }

    /// The view under a light of some extent.
    pub(super) fn lit<'b>(&'b self, light: &AreaLight, truth: &'b AreaTruth) -> SoftShadow<'b> {
        SoftShadow {
            scene: &self.scene.triangles,
            light: placed(light, &self.frame),
            truth,
            map: &self.map,
            penumbra: penumbra(light, &self.frame),
        }
    }

    /// Width in texels of the filter of percentage-closer soft shadows, 0 without blockers, and the largest number of
    /// light-facing surfaces in front of the receiver above any texel of that filter.
    pub(super) fn classified(&self, lit: &SoftShadow<'_>, receiver: &SoftReceiver) -> (f64, usize) {
        let Fragment { position, depth, bias, .. } = receiver.fragment;
        let search = BlockerSearch::percentage_closer();
        let blockers = percentage_closer_blockers(lit.map, &lit.penumbra, &search, &receiver.fragment);
        if blockers.mass <= 0.0 {
            return (0.0, 0);
        }
        let widths = lit.penumbra.filter(depth, blockers.average(depth, 0.0));
        let size = [self.map.width(), self.map.height()];
        let texels = |k: usize| {
            let end = |t: f64| (t.max(0.0) as usize).min(size[k] - 1);
            end(position[k] - 0.5 * widths[k])..=end(position[k] + 0.5 * widths[k])
        };
        let compared = depth - bias;
        let layers = |x: usize, y: usize| {
            let entries = self.stack.layers(x as u32, y as u32);
            entries.filter(|entry| entry.light_facing && f64::from(entry.depth) < compared).count()
        };
        let most = texels(1).flat_map(|y| texels(0).map(move |x| layers(x, y))).max();
        (widths[0].max(widths[1]), most.unwrap_or_default())
    }
}

/// The surface of a receiver at a place of its map, for rays; `None` where no triangle lies near.
pub(crate) fn surface(
    triangles: &Triangles,
    frame: &LightFrame,
    receiver: &Receiver,
    position: [f64; 2],
) -> Option<Surface> {
    let point = frame.unproject([position[0], position[1], receiver.depth]);
    let slope = receiver.gradient[0].abs() + receiver.gradient[1].abs();
    let reach = (REACH[0] + REACH[1] * slope.min(1.0)) * frame.depth_range;
    triangles.surface_near(point, frame.arriving(point), reach)
}

/// The truth of all points.
pub(super) fn truths(lit: &SoftShadow<'_>, receivers: &[SoftReceiver]) -> Vec<OccludedFraction> {
    receivers.par_iter().map(|receiver| lit.occluded(receiver)).collect()
}

/// The light with the other outline and the same area.
pub(super) fn other_outline(light: &PlacedLight) -> PlacedLight {
    let root = std::f64::consts::PI.sqrt();
    let (outline, factor) = match light.outline {
        Outline::Rectangle => (Outline::Disc, 2.0 / root),
        Outline::Disc => (Outline::Rectangle, 0.5 * root),
    };
    PlacedLight { outline, half_axes: light.half_axes.map(|axis| axis.map(|c| factor * c)), ..*light }
}
