//! Hard shadows: filterable shadow maps against percentage-closer filtering.

use super::budget::{Budget, Costs};
use super::query::Measured;
use super::race::{Course, Race, by_view, shuffled};
use super::shipping::Shipping;
use super::together::{Member, Shared};
use crate::error::EvaluationError;
use crate::kinds::speed_accuracy::{
    FrameCost, FreeParameters, MeasuredFrames, SceneView, SpeedAccuracyExperiment, SpeedPlan,
};
use crate::statistics::Sums;
use serde::Serialize;
use std::ops::Range;

/// A technique with everything that has to be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Technique.
    pub technique: String,
    /// Number format.
    pub format: String,
    /// Affine transform of what is stored.
    pub transform: String,
    /// Moment bias; `None` for techniques without.
    pub alpha: Option<f64>,
    /// Depth bias in texel depths of the map.
    pub bias_texels: f64,
    /// Depth bias in slopes of the receiver.
    pub bias_slopes: f64,
    /// 0 for the lower bound, towards 1 for the upper.
    pub beta: f64,
    /// What shadows are divided by, subtracted from 1.
    pub leak_reduction: f64,
    /// Side of the shadow map in texels.
    pub size: u32,
    /// Texels of its filter kernel along a side.
    pub kernel_size: usize,
    /// Its error.
    #[serde(flatten)]
    pub error: Measured,
    /// Memory of a texel.
    pub bits_per_texel: usize,
    /// Memory of the filtered map.
    pub map_bytes: u64,
    /// Operations of decoding and shading a fragment.
    pub operations: f64,
    /// Cost of a frame, 1 for the first candidate at the reference's size: modelled, or measured.
    pub cost: f64,
    /// Whether it was measured on a graphics processor.
    pub cost_is_measured: bool,
    /// The same in milliseconds on the card of the budget.
    pub cost_ms: f64,
    /// What an implementation needs beside.
    pub shipping: Shipping,
}

/// Calling everything lit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nothing {
    /// What it errs by: the mean of F over all fragments.
    pub l1_error: f64,
    /// Share of the fragments with F > 0: the others are in the light over their whole kernel.
    pub shadowed_share: f64,
    /// Side of a texel of the reference's map in the scene's units, the largest of all views; `None` for a stack. Smaller
    /// things cast no shadow on it.
    pub texel_side: Option<f64>,
}

struct Entry {
    candidate: usize,
    divisor: usize,
    /// In modelled bytes, or as many as the unit moves in the measured time.
    cost: f64,
    is_measured: bool,
    variants: Vec<FreeParameters>,
}

/// Every technique in every format and map size.
pub(super) struct HardCourse<'a> {
    plan: &'a SpeedPlan<'a>,
    views: &'a [SceneView],
    entries: Vec<Entry>,
    shuffled: Vec<(u32, u32)>,
    /// F of all fragments, in the shuffled order. All of it is needed: what doing nothing errs by is the yardstick of every
    /// candidate, and is to be certain.
    truth: Vec<f32>,
}

impl<'a> HardCourse<'a> {
    /// Those that a budget leaves.
    pub(super) fn new(
        (plan, measured): (&'a SpeedPlan<'a>, Option<&MeasuredFrames>),
        views: &'a [SceneView],
        budget: &Budget,
    ) -> Result<Self, EvaluationError> {
        let mut entries = Vec::new();
        let mut costs = Costs::default();
        for candidate in 0..plan.candidates.len() {
            for divisor in 0..plan.kernels.len() {
                if views.iter().any(|view| view.maps[divisor].is_none()) {
                    continue;
                }
                let timed = measured.and_then(|frames| frames.relative(candidate, divisor));
                let modelled = || plan.cost(candidate, divisor).total();
                let cost = timed.map_or_else(modelled, |relative| relative * plan.unit_cost());
                if costs.admits(budget, cost, map_bytes(plan, candidate, divisor)) {
                    let (is_measured, variants) = (timed.is_some(), plan.variants(candidate));
                    entries.push(Entry { candidate, divisor, cost, is_measured, variants });
                }
            }
        }
        costs.check(budget, "hard shadows", entries.is_empty())?;
        entries.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let shuffled = shuffled(views.iter().map(|view| view.receivers.len()), plan.experiment.scenery.seed);
        let of_view = |view: &SceneView| {
            let all: Vec<u32> = (0..view.receivers.len() as u32).collect();
            plan.reference(view, &all)
        };
        let truths: Vec<Vec<f32>> = views.iter().map(of_view).collect();
        let truth =
            shuffled.iter().map(|&(view, fragment)| truths[view as usize][fragment as usize]).collect();
        Ok(Self { plan, views, entries, shuffled, truth })
    }

    pub(super) fn nothing(&self) -> Nothing {
        let count = self.truth.len().max(1) as f64;
        Nothing {
            l1_error: self.truth.iter().map(|&f| f64::from(f)).sum::<f64>() / count,
            shadowed_share: self.truth.iter().filter(|&&f| f > 0.0).count() as f64 / count,
            texel_side: self.views.iter().filter_map(SceneView::texel_side).reduce(f64::max),
        }
    }

    pub(super) fn plan(&self) -> &SpeedPlan<'a> {
        self.plan
    }

    pub(super) fn views(&self) -> &[SceneView] {
        self.views
    }

    /// With what others may share.
    pub(super) fn member(&self, arm: usize, race: &Race<Self>) -> Member {
        let (candidate, divisor, _) = self.place(arm, race.best_variant(arm).0);
        let (plan, of) = (self.plan, &self.plan.candidates[candidate]);
        let scale = plan.experiment.divisors[divisor];
        let side = plan.experiment.scenery.size / scale;
        let kernel = SpeedAccuracyExperiment::divided(plan.experiment.scenery.kernel, scale).to_string();
        let spec = &plan.experiment.technique[candidate].method;
        let bound = spec.bound.map_or("certified", |bound| bound.as_str());
        let bits = of.technique().bits_per_texel();
        let made = FrameCost::made((bits, of.channels()), side, plan.kernels[divisor].size()).total();
        let map = Shared::filtered([bound, spec.transform(), &of.format, &kernel], side, made, bits);
        Member {
            application: "hard shadows",
            name: format!("{} in {}, {side}x{side}", of.name, of.format),
            cost: race.arms[arm].cost,
            bytes: 0,
            uses: vec![Shared::depth(side), map],
        }
    }

    /// A candidate by its place in the plan's lists.
    pub(super) fn place(&self, arm: usize, variant: usize) -> (usize, usize, FreeParameters) {
        let entry = &self.entries[arm];
        (entry.candidate, entry.divisor, entry.variants[variant])
    }
}

fn map_bytes(plan: &SpeedPlan<'_>, candidate: usize, divisor: usize) -> u64 {
    let side = plan.experiment.scenery.size / plan.experiment.divisors[divisor];
    u64::from(side).pow(2) * plan.candidates[candidate].technique().bits_per_texel() as u64 / 8
}

impl Course for HardCourse<'_> {
    fn arms(&self) -> Vec<(f64, usize)> {
        self.entries.iter().map(|entry| (entry.cost, entry.variants.len())).collect()
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
        let entry = &self.entries[arm];
        let wanted: Vec<FreeParameters> = variants.iter().map(|&variant| entry.variants[variant]).collect();
        let mut sums = vec![Sums::default(); wanted.len()];
        for (view, places) in by_view(&self.shuffled, range) {
            let fragments: Vec<u32> = places.iter().map(|&i| self.shuffled[i].1).collect();
            let truth: Vec<f32> = places.iter().map(|&i| self.truth[i]).collect();
            let place = (entry.candidate, entry.divisor);
            let more = self.plan.sums(place, &self.views[view], (&fragments, &truth), &wanted)?;
            sums.iter_mut().zip(&more).for_each(|(sums, more)| sums.add(more));
        }
        Ok(sums)
    }
}

/// An arm as it is told; `nothing` is what doing nothing errs by, above 0.
pub(super) fn choice(race: &Race<HardCourse<'_>>, arm: usize, nothing: f64, budget: &Budget) -> Choice {
    let (variant, estimate) = race.best_variant(arm);
    let (plan, views) = (race.course.plan(), race.course.views());
    let (candidate, divisor, FreeParameters { alpha, bias, blend, .. }) = race.course.place(arm, variant);
    let of = &plan.candidates[candidate];
    let scale = plan.experiment.divisors[divisor];
    let setting = &plan.experiment.technique[candidate];
    Choice {
        technique: of.name.clone(),
        format: of.format.clone(),
        transform: setting.method.transform().to_owned(),
        alpha,
        bias_texels: bias.texels,
        bias_slopes: bias.slopes,
        beta: blend.beta,
        leak_reduction: blend.leak_reduction,
        size: plan.experiment.scenery.size / scale,
        kernel_size: plan.kernels[divisor].size(),
        error: Measured::new(estimate, nothing),
        bits_per_texel: of.technique().bits_per_texel(),
        map_bytes: map_bytes(plan, candidate, divisor),
        operations: of.operations,
        cost: race.arms[arm].cost / plan.unit_cost(),
        cost_is_measured: race.course.entries[arm].is_measured,
        cost_ms: budget.milliseconds(race.arms[arm].cost),
        shipping: Shipping::of(&setting.method, of.technique(), &plan.kernels[divisor], (bias, scale), views),
    }
}
