//! From an experiment to its tables.

use super::cost::FrameCost;
use super::orders::{self, LARGEST_RANK, ORDERS};
use super::records::{OrderRecord, OrderShare, SpeedAccuracyRecord};
use super::scenery::{FreeParameters, SceneView, SpeedPlan};
use super::settings::{Blend, SpeedAccuracyExperiment};
use super::timing;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::ViewRecord;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::statistics::Sums;
use crate::statistics::rounded;
use rayon::prelude::*;
use shadow_filtering::{DepthBias, Kernel, Receiver};

/// Format of percentage-closer filtering, which competes with nobody: it cannot be filtered in advance.
const COMPARED: &str = "depth";

/// One technique, format and size with the sums of all variants by view.
struct Measured {
    technique: String,
    format: String,
    size: u32,
    variants: Vec<FreeParameters>,
    bits_per_texel: usize,
    operations: f64,
    cost: FrameCost,
    /// By view, then variant.
    sums: Vec<Vec<Sums>>,
    /// Why there are none, or empty.
    error: String,
}

impl SpeedPlan<'_> {
    /// Modelled cost of a frame with a candidate.
    pub(crate) fn cost(&self, candidate: usize, divisor: usize) -> FrameCost {
        let (experiment, candidate) = (self.experiment, &self.candidates[candidate]);
        FrameCost::prefiltered(
            experiment.frame,
            experiment.scenery.size / experiment.divisors[divisor],
            (candidate.technique().bits_per_texel(), candidate.channels()),
            self.kernels[divisor].size(),
            candidate.operations,
        )
    }

    /// The unit of costs: the first candidate at the reference's size.
    pub(crate) fn unit_cost(&self) -> f64 {
        let (experiment, candidate) = (self.experiment, &self.candidates[0]);
        let storage = (candidate.technique().bits_per_texel(), candidate.channels());
        let kernel = self.kernel.size();
        FrameCost::prefiltered(
            experiment.frame,
            experiment.scenery.size,
            storage,
            kernel,
            candidate.operations,
        )
        .total()
    }

    /// Percentage-closer filtering around the nearest texel, without a receiver plane, minus F.
    fn comparison_errors(
        &self,
        (kernel, divisor): (&Kernel, usize),
        view: &SceneView,
        (fragments, truth): (&[u32], &[f32]),
    ) -> Vec<f32> {
        let Some(map) = &view.maps[divisor] else { return Vec::new() };
        let (biases, scale) = (&self.experiment.biases, self.experiment.divisors[divisor]);
        let errors = |(&fragment, &truth): (&u32, &f32)| -> Vec<f32> {
            let receiver = &view.receivers[fragment as usize];
            let (x, y) = (receiver.x / scale as usize, receiver.y / scale as usize);
            let gradient = receiver.gradient.map(|slope| slope * f64::from(scale));
            let own = Receiver { gradient, ..*receiver };
            let under = |bias: &DepthBias| {
                let texel_depth = view.texel_depth * f64::from(scale);
                let z = bias.compared(&own, texel_depth, self.experiment.scenery.plane_limit);
                kernel.percentage_closer(map, x, y, z) as f32 - truth
            };
            biases.iter().map(under).collect()
        };
        fragments.par_iter().zip(truth).flat_map_iter(errors).collect()
    }
}

impl SpeedAccuracyExperiment {
    /// Evaluates all techniques, then times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let plan = SpeedPlan::new(self)?;
        let views = plan.scenery()?;
        let samples: Vec<Vec<u32>> = views
            .iter()
            .enumerate()
            .map(|(number, view)| view.sample(self.scenery.fragments, self.scenery.seed, number))
            .collect();
        let truths: Vec<Vec<f32>> =
            views.iter().zip(&samples).map(|(view, sample)| plan.reference(view, sample)).collect();
        let sizes: Vec<usize> = (0..self.divisors.len())
            .filter(|&divisor| views.iter().all(|view| view.maps[divisor].is_some()))
            .collect();
        let total = (plan.candidates.len() + self.comparison.len()) * sizes.len();
        let mut measured = Vec::new();
        for (candidate, of) in plan.candidates.iter().enumerate() {
            for &divisor in &sizes {
                let variants = plan.variants(candidate);
                let all = views.iter().zip(&samples).zip(&truths);
                let sums: Result<Vec<_>, EvaluationError> = all
                    .map(|((view, sample), truth)| {
                        plan.sums((candidate, divisor), view, (sample, truth), &variants)
                    })
                    .collect();
                let (sums, error) = match sums {
                    Ok(sums) => (sums, String::new()),
                    // Nothing is known of any view then.
                    Err(error) => {
                        (vec![vec![Sums::default(); variants.len()]; views.len()], error.to_string())
                    }
                };
                measured.push(Measured {
                    technique: of.name.clone(),
                    format: of.format.clone(),
                    size: self.scenery.size / self.divisors[divisor],
                    variants,
                    bits_per_texel: of.technique().bits_per_texel(),
                    operations: of.operations,
                    cost: plan.cost(candidate, divisor),
                    sums,
                    error,
                });
                (context.progress)(measured.len(), total);
            }
        }
        for comparison in &self.comparison {
            for &divisor in &sizes {
                let kernel = Self::divided(comparison.kernel, self.divisors[divisor]).build();
                let kernel = kernel.map_err(|error| EvaluationError::Value(error.to_string()))?;
                let side = self.scenery.size / self.divisors[divisor];
                let all = views.iter().zip(&samples).zip(&truths);
                let errors = all.map(|((view, sample), truth)| {
                    plan.comparison_errors((&kernel, divisor), view, (sample, truth))
                });
                measured.push(Measured {
                    technique: comparison.name.clone(),
                    format: COMPARED.to_owned(),
                    size: side,
                    variants: self
                        .biases
                        .iter()
                        .map(|&bias| FreeParameters { index: 0, alpha: None, bias, blend: Blend::default() })
                        .collect(),
                    bits_per_texel: 32,
                    operations: (kernel.size() * kernel.size() * 3) as f64,
                    cost: FrameCost::comparison(self.frame, side, kernel.size()),
                    sums: errors.map(|errors| summed(&errors, self.biases.len())).collect(),
                    error: String::new(),
                });
                (context.progress)(measured.len(), total);
            }
        }
        let records = self.records(&measured, &views, plan.unit_cost());
        let needs: Vec<OrderRecord> =
            views.iter().enumerate().map(|(number, view)| orders::needed(&plan, view, number)).collect();
        let view_records = views.iter().zip(&samples).map(|(view, sample)| ViewRecord {
            scene: view.scene.clone(),
            view: view.view.clone(),
            fragments: view.receivers.len(),
            sampled: sample.len(),
            layers: Some(view.layers),
            ..ViewRecord::default()
        });
        let timings = timing::time(&plan, &views[0], &samples[0])?;
        let pictures = plan.pictures()?;
        let mut files = vec![
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("orders.csv", &self.order_shares(&needs))?,
            RecordedFile::csv("views.csv", &view_records.collect::<Vec<_>>())?,
            RecordedFile::csv("samples.csv", &timings)?,
        ];
        files.extend(pictures);
        files.extend(plan.pictures_of_views(&views)?);
        if let Some(timing) = &self.frames {
            let times = plan.frame_times(timing);
            files.push(RecordedFile::csv("gpu.csv", &[times.gpu])?);
            if !times.samples.is_empty() {
                files.push(RecordedFile::csv("frames.csv", &times.samples)?);
            }
        }
        let failed = measured.iter().filter(|of| !of.error.is_empty()).count();
        Ok(Recorded { files, trials: measured.len(), failed, complete: true })
    }

    /// Pooled rows of all variants, then rows of scenes and views for the best variant.
    fn records(&self, measured: &[Measured], views: &[SceneView], unit: f64) -> Vec<SpeedAccuracyRecord> {
        let pooled = |of: &Measured, variant: usize, wanted: &dyn Fn(&SceneView) -> bool| {
            let mut sums = Sums::default();
            for (view, by_variant) in views.iter().zip(&of.sums) {
                if wanted(view) {
                    sums.add(&by_variant[variant]);
                }
            }
            sums
        };
        let best_of =
            |of: &Measured| {
                let errors = (0..of.variants.len()).map(|variant| pooled(of, variant, &|_| true).mean());
                errors.enumerate().fold((0, f64::INFINITY), |best, (variant, error)| {
                    if error < best.1 { (variant, error) } else { best }
                })
            };
        let bests: Vec<(usize, f64)> = measured.iter().map(best_of).collect();
        let front = |index: usize| {
            let (cost, error) = (measured[index].cost.total(), bests[index].1);
            let competes = |of: &Measured| of.format != COMPARED && of.error.is_empty();
            competes(&measured[index])
                && !measured.iter().zip(&bests).any(|(other, &(_, other_error))| {
                    let other_cost = other.cost.total();
                    competes(other)
                        && other_cost <= cost
                        && other_error <= error
                        && (other_cost < cost || other_error < error)
                })
        };
        let is_complete = self.scenery.fragments == 0
            || views.iter().all(|view| view.receivers.len() <= self.scenery.fragments);
        let row = |index: usize, variant: usize, (scene, view): (&str, &str), sums: Sums| {
            let of = &measured[index];
            let FreeParameters { alpha, bias, blend, .. } = of.variants[variant];
            let count = sums.count.max(1) as f64;
            let best = variant == bests[index].0;
            SpeedAccuracyRecord {
                scene: scene.to_owned(),
                view: view.to_owned(),
                technique: of.technique.clone(),
                format: of.format.clone(),
                size: of.size,
                alpha,
                bias_texels: bias.texels,
                bias_slopes: bias.slopes,
                beta: blend.beta,
                leak_reduction: blend.leak_reduction,
                best,
                fragments: sums.count,
                l1_error: rounded(sums.mean()),
                standard_error: (!is_complete).then(|| rounded(sums.deviation() / count.sqrt())),
                signed_mean: rounded(sums.signed / count),
                bits_per_texel: of.bits_per_texel,
                operations: rounded(of.operations),
                cost: rounded(of.cost.total() / unit),
                on_front: (best && scene == "all").then(|| front(index)),
                error: of.error.clone(),
            }
        };
        let mut records = Vec::new();
        for (index, of) in measured.iter().enumerate() {
            for variant in 0..of.variants.len() {
                records.push(row(index, variant, ("all", "all"), pooled(of, variant, &|_| true)));
            }
        }
        let mut scenes: Vec<&str> = views.iter().map(|view| view.scene.as_str()).collect();
        scenes.dedup();
        for (index, of) in measured.iter().enumerate() {
            let best = bests[index].0;
            for &scene in &scenes {
                let sums = pooled(of, best, &|view| view.scene == scene);
                records.push(row(index, best, (scene, "all"), sums));
            }
            for (view, sums) in views.iter().zip(&of.sums) {
                records.push(row(index, best, (&view.scene, &view.view), sums[best]));
            }
        }
        records
    }

    pub(crate) fn order_shares(&self, needs: &[OrderRecord]) -> Vec<OrderShare> {
        let mut shares = Vec::new();
        for need in needs {
            let mut push = |by: &str, tolerance: f64, names: Vec<String>, values: &[f64]| {
                shares.extend(names.into_iter().zip(values).map(|(needs, &share)| OrderShare {
                    scene: need.scene.clone(),
                    view: need.view.clone(),
                    by: by.to_owned(),
                    tolerance,
                    needs,
                    fragments: need.fragments,
                    share,
                }));
            };
            let ranks = (1..=LARGEST_RANK).map(|rank| rank.to_string()).collect();
            push("rank", self.orders.rank_tolerance, ranks, &need.ranks);
            for (by, shares) in [("gap", &need.by_gap), ("loss", &need.by_loss)] {
                for (&tolerance, values) in self.orders.gap_tolerances.iter().zip(shares) {
                    let orders = ORDERS.iter().map(|bound| bound.order().to_string());
                    push(by, tolerance, orders.chain(["more".to_owned()]).collect(), values);
                }
            }
        }
        shares
    }
}

fn summed(errors: &[f32], variants: usize) -> Vec<Sums> {
    let mut sums = vec![Sums::default(); variants];
    for item in errors.chunks_exact(variants) {
        sums.iter_mut().zip(item).for_each(|(sums, &error)| sums.push(error));
    }
    sums
}
