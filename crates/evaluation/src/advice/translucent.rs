//! Translucent casters: maps of transmittance and of absorption against the kernel's mean of what all surfaces take.

use super::budget::{Budget, Costs};
use super::query::Measured;
use super::race::{Course, Race, add_chunks, by_view, shuffled};
use super::shipping::BiasInView;
use super::together::{Member, Shared};
use crate::error::EvaluationError;
use crate::kinds::speed_accuracy::{FrameCost, FrameSetting, SceneView};
use crate::kinds::translucent_shadows::{Plan, TranslucentTechnique, View};
use crate::statistics::Sums;
use applications::{Application, BiasSetting};
use rayon::prelude::*;
use serde::Serialize;
use shadow_filtering::DepthBias;
use std::ops::Range;

/// A method with everything that has to be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TranslucentChoice {
    /// Method.
    pub technique: String,
    /// Number format of what is stored; depths for methods that compare taps.
    pub format: String,
    /// Number of moments; 0 for other functions and for depths.
    pub moments: usize,
    /// Moment bias.
    pub alpha: Option<f64>,
    /// Blend of the bounds.
    pub beta: f64,
    /// Whether surfaces have to be drawn in the order of their depths.
    pub ordered: bool,
    /// Depth bias in texel depths of the map.
    pub bias_texels: f64,
    /// Depth bias in slopes of the receiver.
    pub bias_slopes: f64,
    /// Side of the shadow map in texels.
    pub size: u32,
    /// Its error.
    #[serde(flatten)]
    pub error: Measured,
    /// Memory of a texel.
    pub bits_per_texel: f64,
    /// Memory of the map.
    pub map_bytes: u64,
    /// Modelled cost of a frame, in the unit of hard shadows.
    pub cost: f64,
    /// The same in milliseconds on the card of the budget.
    pub cost_ms: f64,
    /// The depth bias in each view.
    pub depth_bias: Vec<BiasInView>,
}

/// Receivers of one task.
const CHUNK: usize = 256;

/// Receivers whose truth says what doing nothing errs by.
const YARDSTICK: usize = 1 << 14;

struct Entry {
    technique: usize,
    cost: f64,
    bits_per_texel: f64,
    map_bytes: u64,
}

/// Every method on the receivers of all views.
pub(super) struct TranslucentCourse<'a> {
    plan: &'a Plan<'a>,
    bias: &'a [DepthBias],
    views: &'a [(&'a SceneView, View)],
    side: u32,
    entries: Vec<Entry>,
    shuffled: Vec<(u32, u32)>,
    /// In the shuffled order, as far as they were asked.
    truth: Vec<f32>,
}

impl<'a> TranslucentCourse<'a> {
    /// Those of the techniques that a budget leaves.
    pub(super) fn new(
        (plan, techniques, bias): (&'a Plan<'a>, &[usize], &'a [DepthBias]),
        views: &'a [(&'a SceneView, View)],
        (frame, budget): (FrameSetting, &Budget),
    ) -> Result<Self, EvaluationError> {
        let side = views.first().map_or(0, |(_, view)| view.map.size()[0]) as u32;
        let texels = f64::from(side).powi(2);
        let pixels = f64::from(frame.width) * f64::from(frame.height);
        let mut costs = Costs::default();
        let mut entries = Vec::new();
        for &technique in techniques {
            // All views are drawn in turn: what they cost on average.
            let mut drawn = FrameCost { bytes: 0.0, operations: 0.0 };
            let mut bits = 0.0;
            for (_, view) in views {
                let share = 1.0 / views.len() as f64;
                let cost = plan.cost(technique, view)?;
                let layers = texels * cost.layers;
                drawn.bytes += share * (layers * cost.bytes_per_layer + pixels * cost.bytes_per_texel);
                drawn.operations +=
                    share * (layers * cost.operations_per_layer + pixels * cost.operations_per_receiver);
                bits += share * 8.0 * cost.bytes_per_texel;
            }
            let filtered = match plan.methods[technique].filtered_channels() {
                0 => 0.0,
                channels => FrameCost::made((bits as usize, channels), side, plan.kernel.size()).total(),
            };
            let cost = Shared::depth(side).cost + drawn.total() + filtered;
            let map_bytes = (texels * bits / 8.0) as u64;
            if costs.admits(budget, cost, map_bytes) {
                entries.push(Entry { technique, cost, bits_per_texel: bits, map_bytes });
            }
        }
        costs.check(budget, "translucent casters", entries.is_empty())?;
        entries.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let counts = views.iter().map(|(_, view)| view.samples.len());
        let shuffled = shuffled(counts, plan.experiment.scenery.seed);
        let mut course = Self { plan, bias, views, side, entries, shuffled, truth: Vec::new() };
        course.know(YARDSTICK);
        Ok(course)
    }

    fn technique(&self, arm: usize) -> &'a TranslucentTechnique {
        &self.plan.experiment.technique[self.entries[arm].technique]
    }

    /// With what others may share.
    pub(super) fn member(&self, arm: usize) -> Member {
        let Entry { cost, map_bytes, .. } = self.entries[arm];
        Member {
            application: "translucent casters",
            name: format!("{}, {1}x{1}", self.technique(arm).name, self.side),
            cost,
            bytes: map_bytes,
            uses: vec![Shared::depth(self.side)],
        }
    }

    fn know(&mut self, upto: usize) {
        let upto = upto.min(self.shuffled.len());
        let from = self.truth.len();
        let one = |place: usize| {
            let (view, sample) = self.shuffled[place];
            let (_, view) = &self.views[view as usize];
            let shadow = view.shadow(self.plan.experiment, &self.plan.kernel);
            shadow.truth(&view.samples[sample as usize].receiver) as f32
        };
        let found: Vec<f32> = (from..upto).into_par_iter().map(one).collect();
        self.truth.extend(found);
    }

    /// What doing nothing errs by: the mean truth over the receivers that were asked.
    pub(super) fn nothing(&self) -> f64 {
        self.truth.iter().map(|&truth| f64::from(truth)).sum::<f64>() / self.truth.len().max(1) as f64
    }
}

impl Course for TranslucentCourse<'_> {
    fn arms(&self) -> Vec<(f64, usize)> {
        self.entries.iter().map(|entry| (entry.cost, self.bias.len())).collect()
    }

    fn receivers(&self) -> usize {
        self.shuffled.len()
    }

    fn sums(
        &mut self,
        arm: usize,
        range: Range<usize>,
        variants: &[usize],
    ) -> Result<Vec<Sums>, EvaluationError> {
        self.know(range.end);
        let (technique, index) = (self.technique(arm), self.entries[arm].technique);
        let fail =
            |reason: String| EvaluationError::Value(format!("technique `{}`: {reason}", technique.name));
        let mut sums = vec![Sums::default(); variants.len()];
        for (number, places) in by_view(&self.shuffled, range) {
            let (_, view) = &self.views[number];
            let shadow = view.shadow(self.plan.experiment, &self.plan.kernel);
            let ranks = view.ranks(technique.order).map_err(&fail)?;
            let seed = self.plan.experiment.scenery.seed;
            let prepared = self.plan.methods[index]
                .prepare(&view.map, &self.plan.kernel, ranks, seed)
                .map_err(|error| fail(error.to_string()))?;
            let of_chunk = |places: &[usize]| {
                let mut sums = vec![Sums::default(); variants.len()];
                for (sums, &variant) in sums.iter_mut().zip(variants) {
                    let bias = BiasSetting { technique: self.bias[variant], ..shadow.bias };
                    let biased = applications::translucency::TranslucentShadow { bias, ..shadow };
                    for &place in places {
                        let receiver = &view.samples[self.shuffled[place].1 as usize].receiver;
                        let truth = self.truth[place];
                        let answer = prepared.unclamped(&biased, receiver).ok().filter(|g| g.is_finite());
                        // No answer errs as much as any could.
                        let error = answer.map_or(1.0, |g| g.clamp(0.0, 1.0) as f32 - truth);
                        sums.push(error, truth);
                    }
                }
                sums
            };
            add_chunks(&mut sums, &places, CHUNK, of_chunk);
        }
        Ok(sums)
    }
}

/// An arm as it is told; `nothing` is what doing nothing errs by, above 0.
pub(super) fn choice(
    race: &Race<TranslucentCourse<'_>>,
    arm: usize,
    nothing: f64,
    (unit, budget): (f64, &Budget),
) -> TranslucentChoice {
    let (variant, estimate) = race.best_variant(arm);
    let course = &race.course;
    let (technique, bias) = (course.technique(arm), course.bias[variant]);
    let Entry { technique: index, cost, bits_per_texel, map_bytes } = course.entries[arm];
    let stored = technique.blended.as_ref().or(technique.absorbance.as_ref());
    let format = match (stored, technique.fourier) {
        (Some(stored), _) => stored.format().name(),
        (None, Some(_)) => "f16".to_owned(),
        (None, None) => "depths".to_owned(),
    };
    TranslucentChoice {
        technique: technique.name.clone(),
        format,
        moments: stored.and_then(|stored| stored.moment_bound()).map_or(0, |bound| bound.order()),
        alpha: stored.and_then(|stored| stored.alpha),
        beta: stored.map_or(0.0, |stored| stored.beta),
        ordered: course.plan.methods[index].needs_order(),
        bias_texels: bias.texels,
        bias_slopes: bias.slopes,
        size: course.side,
        error: Measured::new(estimate, nothing),
        bits_per_texel,
        map_bytes,
        cost: cost / unit,
        cost_ms: budget.milliseconds(cost),
        depth_bias: course.views.iter().map(|(view, _)| BiasInView::new(bias, 1, view)).collect(),
    }
}
