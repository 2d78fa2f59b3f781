//! Where the costs of hard shadows come from.

use super::AdviceOptions;
use super::budget::Budget;
use crate::fragments::LoadedScene;
use crate::kinds::speed_accuracy::{MeasuredFrames, SceneView, SpeedPlan};
use serde::Serialize;

/// What costs of hard shadows are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostSource {
    /// `modelled`, or `measured` where frames were timed.
    pub source: &'static str,
    /// The graphics processor, or why there are no times; empty where none were asked for.
    pub adapter: String,
    /// Combinations of technique, format and map size that were timed; the others are modelled in the same unit.
    pub measured: usize,
    /// Milliseconds of the unit of costs, where it was timed.
    pub unit_ms: Option<f64>,
    /// The factor between modelled and measured cost that two thirds of them stay within, and the largest.
    pub model_factor: Option<[f64; 2]>,
}

impl CostSource {
    /// Times the candidates where that is wanted and possible.
    pub(super) fn of(
        options: &AdviceOptions<'_>,
        plan: &SpeedPlan<'_>,
        loaded: &LoadedScene<'_>,
        views: &[SceneView],
    ) -> (Self, Option<MeasuredFrames>) {
        let modelled = |reason: String| Self {
            source: "modelled",
            adapter: reason,
            measured: 0,
            unit_ms: None,
            model_factor: None,
        };
        let Some(view) = views.first().filter(|_| options.gpu) else {
            return (modelled(String::new()), None);
        };
        match plan.measured(loaded, view, false) {
            Ok(frames) => {
                let told = Self {
                    source: "measured",
                    adapter: frames.adapter.clone(),
                    measured: frames.count(),
                    unit_ms: Some(frames.unit()),
                    model_factor: Some(frames.error_of_model(plan)),
                };
                (told, Some(frames))
            }
            Err(reason) => (modelled(reason), None),
        }
    }

    /// The budget with the bandwidth at which the unit takes its measured time.
    pub(super) fn calibrated(&self, budget: &Budget, plan: &SpeedPlan<'_>) -> Budget {
        let bandwidth = self.unit_ms.map(|time| plan.unit_cost() / (time * 1e6));
        Budget { bandwidth: bandwidth.unwrap_or(budget.bandwidth), ..*budget }
    }
}
