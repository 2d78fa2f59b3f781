//! Single scattering: the lit share of view rays by prefiltered maps and ray marching against the whole shadow map.

use super::budget::{Budget, Costs};
use super::query::Measured;
use super::race::{Course, Race, by_view, shuffled};
use super::together::{Member, Shared};
use crate::error::EvaluationError;
use crate::kinds::single_scattering::{RayMethod, Rays, SingleScatteringExperiment};
use crate::kinds::speed_accuracy::FrameCost;
use crate::statistics::Sums;
use serde::Serialize;
use std::ops::Range;

/// A method with everything that has to be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScatteringChoice {
    /// Method.
    pub technique: String,
    /// Number format of prefix sums; depths for ray marching.
    pub format: String,
    /// Number of moments; 0 for other functions and for ray marching.
    pub moments: usize,
    /// Moment bias.
    pub alpha: Option<f64>,
    /// Blend of the bounds.
    pub beta: f64,
    /// Affine transform of what is stored.
    pub transform: String,
    /// Samples a ray; 0 for prefix sums.
    pub samples: usize,
    /// Columns and rows of the map that is looked up.
    pub map: [usize; 2],
    /// Side of the shadow map.
    pub size: u32,
    /// Whether the shadow map is filtered while it is resampled.
    pub filtered: bool,
    /// Its error.
    #[serde(flatten)]
    pub error: Measured,
    /// Memory of a texel.
    pub bits_per_texel: usize,
    /// Memory of the map.
    pub map_bytes: u64,
    /// Modelled cost of a frame, in the unit of hard shadows.
    pub cost: f64,
    /// The same in milliseconds on the card of the budget.
    pub cost_ms: f64,
}

/// Every method on the rays of all cameras.
pub(super) struct ScatteringCourse<'a> {
    experiment: &'a SingleScatteringExperiment,
    rays: &'a Rays<'a>,
    methods: Vec<RayMethod>,
    shuffled: Vec<(u32, u32)>,
    /// Lit shares in the shuffled order, as far as they were asked.
    truth: Vec<f32>,
}

/// The moment shadow map that is resampled with a filter.
fn source(experiment: &SingleScatteringExperiment, rays: &Rays<'_>, side: u32) -> Shared {
    let (spec, kernel) = (&experiment.source, experiment.scenery.kernel);
    let technique = rays.source();
    let (bits, taps) = (technique.bits_per_texel(), kernel.build().map_or(0, |kernel| kernel.size()));
    let made = FrameCost::made((bits, technique.channels()), side, taps).total();
    let bound = spec.bound.map_or("certified", |bound| bound.as_str());
    Shared::filtered([bound, spec.transform(), &spec.format().name(), &kernel.to_string()], side, made, bits)
}

/// Rays whose truth says what doing nothing errs by.
const YARDSTICK: usize = 1 << 14;

impl<'a> ScatteringCourse<'a> {
    /// Those that a budget leaves.
    pub(super) fn new(
        experiment: &'a SingleScatteringExperiment,
        rays: &'a Rays<'a>,
        budget: &Budget,
    ) -> Result<Self, EvaluationError> {
        let mut costs = Costs::default();
        let mut methods = rays.methods();
        let side = experiment.scenery.size;
        for method in &mut methods {
            // The experiment tells what a method adds; here nobody else has made what it reads.
            method.cost += Shared::depth(side).cost;
            if experiment.technique[method.index].method.filtered {
                method.cost += source(experiment, rays, side).cost;
            }
        }
        methods.retain(|method| costs.admits(budget, method.cost, method.map_bytes));
        costs.check(budget, "single scattering", methods.is_empty())?;
        methods.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let shuffled = shuffled(rays.counts(), experiment.scenery.seed);
        let mut course = Self { experiment, rays, methods, shuffled, truth: Vec::new() };
        course.know(YARDSTICK);
        Ok(course)
    }

    /// With what others may share.
    pub(super) fn member(&self, arm: usize) -> Member {
        let method = &self.methods[arm];
        let side = self.experiment.scenery.size;
        let mut uses = vec![Shared::depth(side)];
        if self.experiment.technique[method.index].method.filtered {
            uses.push(source(self.experiment, self.rays, side));
        }
        Member {
            application: "single scattering",
            name: format!("{}, {side}x{side}", method.name),
            cost: method.cost,
            // Marched rays read the depth map.
            bytes: if method.steps > 0 { 0 } else { method.map_bytes },
            uses,
        }
    }

    fn know(&mut self, upto: usize) {
        let upto = upto.min(self.shuffled.len());
        let from = self.truth.len();
        if upto <= from {
            return;
        }
        self.truth.resize(upto, 0.0);
        for (shot, places) in by_view(&self.shuffled, from..upto) {
            let rays: Vec<usize> = places.iter().map(|&place| self.shuffled[place].1 as usize).collect();
            for (place, lit) in places.iter().zip(self.rays.truths(shot, &rays)) {
                self.truth[*place] = lit as f32;
            }
        }
    }

    /// What a medium without shadows errs by: the mean of 1 minus the lit share, over the rays that were asked.
    pub(super) fn nothing(&self) -> f64 {
        let shadows = self.truth.iter().map(|&lit| 1.0 - f64::from(lit)).sum::<f64>();
        shadows / self.truth.len().max(1) as f64
    }
}

impl Course for ScatteringCourse<'_> {
    fn arms(&self) -> Vec<(f64, usize)> {
        self.methods.iter().map(|method| (method.cost, 1)).collect()
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
        let mut sums = Sums::default();
        for (shot, places) in by_view(&self.shuffled, range) {
            let rays: Vec<usize> = places.iter().map(|&place| self.shuffled[place].1 as usize).collect();
            let answers = self.rays.estimates(self.methods[arm].index, shot, &rays)?;
            for (&place, answer) in places.iter().zip(answers) {
                let truth = self.truth[place];
                // No answer errs as much as any could.
                let error = if answer.is_nan() { 1.0 } else { answer as f32 - truth };
                sums.push(error, 1.0 - truth);
            }
        }
        Ok(vec![sums; variants.len()])
    }
}

/// An arm as it is told; `nothing` is what doing nothing errs by, above 0.
pub(super) fn choice(
    race: &Race<ScatteringCourse<'_>>,
    arm: usize,
    nothing: f64,
    (unit, budget): (f64, &Budget),
) -> ScatteringChoice {
    let course = &race.course;
    let RayMethod { index, name, cost, steps, bits_per_texel, map_bytes } = &course.methods[arm];
    let method = &course.experiment.technique[*index].method;
    let stored = method.stored.as_ref();
    let size = course.experiment.scenery.size;
    let side = size as usize;
    ScatteringChoice {
        technique: name.clone(),
        format: stored.map_or("depths in 16 bits".to_owned(), |stored| stored.format().name()),
        moments: stored.and_then(|stored| stored.moment_bound()).map_or(0, |bound| bound.order()),
        alpha: stored.and_then(|stored| stored.alpha),
        beta: stored.map_or(0.0, |stored| stored.beta),
        transform: stored.map_or(String::new(), |stored| stored.transform().to_owned()),
        samples: *steps,
        map: if *steps > 0 { [side, side] } else { course.experiment.rectified },
        size,
        filtered: method.filtered,
        error: Measured::new(race.error(arm), nothing),
        bits_per_texel: *bits_per_texel,
        map_bytes: *map_bytes,
        cost: cost / unit,
        cost_ms: budget.milliseconds(*cost),
    }
}
