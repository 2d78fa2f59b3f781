//! From an experiment to its tables.

use super::agreement;
use super::maps;
use super::picture;
use super::records::{AgreementRecord, FilterableRecord, ViewRecord};
use super::settings::{FilterableExperiment, FilterableTechnique};
use super::statistics::{Group, Outcome, TOLERANCE, record};
use super::timing;
use super::view::{CLASSES, LoadedScene, Sample, View};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use rayon::prelude::*;
use shadow_filtering::{ChannelMap, FilteringError, Kernel, Receiver, Technique, encode, filter};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A technique prepared for any view.
pub(crate) enum Method {
    Prefiltered(Box<Technique>),
    Comparison(Kernel),
}

/// A technique prepared for one view.
pub(crate) enum Shader<'a> {
    Prefiltered(&'a Technique, ChannelMap<f64>),
    Comparison(&'a Kernel, &'a View),
}

impl Method {
    pub(crate) fn new(settings: &FilterableTechnique) -> Result<Self, EvaluationError> {
        let method = match (&settings.method, &settings.comparison) {
            (Some(method), _) => method.build().map(|technique| Self::Prefiltered(Box::new(technique))),
            (None, Some(kernel)) => kernel.build().map(Self::Comparison),
            (None, None) => {
                let reason = format!("technique `{}` needs either `method` or `comparison`", settings.name);
                return Err(EvaluationError::Value(reason));
            }
        };
        method.map_err(|error| settings.failure(error))
    }

    pub(crate) fn prepare<'a>(
        &'a self,
        view: &'a View,
        kernel: &Kernel,
    ) -> Result<Shader<'a>, FilteringError> {
        Ok(match self {
            Self::Prefiltered(technique) => {
                let filtered = filter(&encode(&view.map, technique)?, kernel);
                Shader::Prefiltered(technique, filtered)
            }
            Self::Comparison(own) => Shader::Comparison(own, view),
        })
    }

    fn is_bound(&self) -> bool {
        matches!(self, Self::Prefiltered(technique) if technique.is_lower_bound())
    }

    fn bits_per_texel(&self) -> usize {
        match self {
            Self::Prefiltered(technique) => technique.bits_per_texel(),
            // A single-precision depth.
            Self::Comparison(_) => 32,
        }
    }
}

impl Shader<'_> {
    /// G at a texel and depth.
    pub(crate) fn shade(&self, x: usize, y: usize, z: f64) -> Result<f64, FilteringError> {
        match self {
            Self::Prefiltered(technique, filtered) => technique.shade(filtered.texel(x, y), z),
            Self::Comparison(kernel, view) => Ok(kernel.percentage_closer(&view.map, x, y, z)),
        }
    }
}

/// The experiment with everything that does not depend on a view.
pub(crate) struct Plan<'a> {
    pub(crate) experiment: &'a FilterableExperiment,
    pub(crate) kernel: Kernel,
    pub(crate) methods: Vec<Method>,
}

/// Outcomes of one technique on one view, by bias.
struct Evaluated {
    by_bias: Vec<Vec<Outcome>>,
    error: String,
}

impl Plan<'_> {
    /// Depth that techniques compare under a bias.
    pub(crate) fn compared(&self, view: &View, receiver: &Receiver, bias: usize) -> f64 {
        let settings = &self.experiment.bias[bias].technique;
        let limit = self.experiment.plane_limit;
        (receiver.depth - settings.depth(receiver, view.texel_depth, limit)).clamp(0.0, 1.0)
    }

    /// F under a bias.
    pub(crate) fn reference(&self, view: &View, receiver: &Receiver, bias: usize) -> f64 {
        let reference = self.experiment.reference(&self.experiment.bias[bias]);
        reference.intensity(&view.map, &self.kernel, receiver, view.texel_depth)
    }

    fn evaluate(&self, technique: usize, view: &View, truth: &Truth) -> Result<Evaluated, EvaluationError> {
        let settings = &self.experiment.technique[technique];
        let method = &self.methods[technique];
        let shader = method.prepare(view, &self.kernel).map_err(|error| settings.failure(error))?;
        let few = if settings.is_certified() { self.experiment.certified_fragments } else { usize::MAX };
        let chosen = spread(view.samples.len(), few);
        let one = |&index: &usize| -> Result<Vec<Outcome>, FilteringError> {
            let Sample { receiver, class } = view.samples[index];
            let violates = method.is_bound() && {
                let g = shader.shade(receiver.x, receiver.y, receiver.depth)?;
                g > truth.unbiased[index] + TOLERANCE
            };
            let under = |bias: usize| {
                let z = self.compared(view, &receiver, bias);
                let g = shader.shade(receiver.x, receiver.y, z)?;
                Ok(Outcome {
                    error: (g - truth.reference[bias][index]) as f32,
                    leak: (truth.plain[bias][index] - g) as f32,
                    violates,
                    class: class as u8,
                })
            };
            (0..self.experiment.bias.len()).map(under).collect()
        };
        let results: Vec<Result<Vec<Outcome>, FilteringError>> = chosen.par_iter().map(one).collect();
        let mut evaluated =
            Evaluated { by_bias: vec![Vec::new(); self.experiment.bias.len()], error: String::new() };
        let mut failed = 0;
        let mut reason = None;
        for result in results {
            match result {
                Ok(outcomes) => {
                    evaluated.by_bias.iter_mut().zip(outcomes).for_each(|(list, outcome)| list.push(outcome));
                }
                Err(error) => {
                    failed += 1;
                    reason.get_or_insert(error);
                }
            }
        }
        if let Some(reason) = reason {
            evaluated.error = format!("{failed} of {} fragments failed: {reason}", chosen.len());
        }
        Ok(evaluated)
    }
}

/// PCF of the samples of a view: F by bias, F_Z at the techniques' depths by bias, F_Z at z_f.
struct Truth {
    reference: Vec<Vec<f64>>,
    plain: Vec<Vec<f64>>,
    unbiased: Vec<f64>,
}

impl Truth {
    fn new(plan: &Plan<'_>, view: &View) -> Self {
        let each = |of: &(dyn Fn(&Receiver) -> f64 + Sync)| -> Vec<f64> {
            view.samples.par_iter().map(|sample| of(&sample.receiver)).collect()
        };
        let plain = |r: &Receiver, z: f64| plan.kernel.percentage_closer(&view.map, r.x, r.y, z);
        let biases = 0..plan.experiment.bias.len();
        Self {
            reference: biases.clone().map(|bias| each(&|r| plan.reference(view, r, bias))).collect(),
            plain: biases.map(|bias| each(&|r| plain(r, plan.compared(view, r, bias)))).collect(),
            unbiased: each(&|r| plain(r, r.depth)),
        }
    }
}

/// Evenly spread indices, at most `wanted`.
pub(crate) fn spread(all: usize, wanted: usize) -> Vec<usize> {
    if wanted >= all {
        return (0..all).collect();
    }
    (0..wanted).map(|i| (2 * i + 1) * all / (2 * wanted)).collect()
}

/// What is kept of the views.
#[derive(Default)]
struct Tables {
    views: Vec<ViewRecord>,
    complete: Vec<bool>,
    /// By technique and view.
    evaluated: Vec<Vec<Evaluated>>,
    agreement: Vec<AgreementRecord>,
    files: Vec<RecordedFile>,
    pictures: picture::Tables,
    samples: Vec<super::records::FilterableSample>,
}

impl FilterableExperiment {
    fn plan(&self) -> Result<Plan<'_>, EvaluationError> {
        let kernel = self.kernel.build().map_err(|e| EvaluationError::Value(format!("kernel: {e}")))?;
        let methods = self.technique.iter().map(Method::new).collect::<Result<_, _>>()?;
        Ok(Plan { experiment: self, kernel, methods })
    }

    /// Evaluates view by view, then times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let plan = self.plan()?;
        let mut tables = Tables::default();
        tables.evaluated.resize_with(self.technique.len(), Vec::new);
        let scenes = LoadedScene::load_all(&self.scenes, &self.views)?;
        for picture in self.picture.iter().enumerate() {
            picture::check(picture, &scenes)?;
        }
        let total = scenes.iter().map(|scene| scene.lights.len()).sum::<usize>() * self.technique.len();
        let done = AtomicUsize::new(0);
        let mut number = 0;
        for scene in &scenes {
            for light in &scene.lights {
                let view = View::prepare(self, &plan.kernel, scene, light, number)?;
                number += 1;
                let truth = Truth::new(&plan, &view);
                for technique in 0..self.technique.len() {
                    let evaluated = plan.evaluate(technique, &view, &truth)?;
                    tables.evaluated[technique].push(evaluated);
                    (context.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                }
                tables.views.push(view.record(&truth.reference[0]));
                tables.complete.push(view.is_complete());
                tables.agreement.extend(agreement::compare(&plan, &view)?);
                tables.files.extend(maps::draw(&plan, &view)?);
                picture::draw(&plan, &view, &mut tables.pictures)?;
                if number == 1 {
                    tables.samples = timing::time(&plan, &view)?;
                }
            }
        }
        tables.recorded(&plan)
    }
}

impl Tables {
    fn recorded(self, plan: &Plan<'_>) -> Result<Recorded, EvaluationError> {
        let records = self.records(plan);
        let trials = records.len() + self.agreement.len();
        let failed = records.iter().filter(|record| !record.error.is_empty()).count()
            + self.agreement.iter().filter(|record| record.failed > 0).count();
        let mut files = self.files;
        files.extend([
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("views.csv", &self.views)?,
            RecordedFile::csv("samples.csv", &self.samples)?,
        ]);
        if !self.agreement.is_empty() {
            files.push(RecordedFile::csv("agreement.csv", &self.agreement)?);
        }
        if !self.pictures.kernels.is_empty() {
            files.push(RecordedFile::csv("kernels.csv", &self.pictures.kernels)?);
            files.push(RecordedFile::csv("curves.csv", &self.pictures.curves)?);
        }
        Ok(Recorded { files, trials, failed, complete: true })
    }

    /// Rows per view, per scene and pooled, the latter two by class too; for all biases but the first only the pooled row.
    fn records(&self, plan: &Plan<'_>) -> Vec<FilterableRecord> {
        let mut scenes: Vec<&str> = Vec::new();
        for view in &self.views {
            if !scenes.contains(&view.scene.as_str()) {
                scenes.push(&view.scene);
            }
        }
        let mut records = Vec::new();
        for bias in 0..plan.experiment.bias.len() {
            for (technique, settings) in plan.experiment.technique.iter().enumerate() {
                let mut push = |scene: &str, name: &str, views: Vec<usize>, class: Option<usize>| {
                    let evaluated = || views.iter().map(|&view| &self.evaluated[technique][view]);
                    let outcomes: Vec<&[Outcome]> = evaluated().map(|e| e.by_bias[bias].as_slice()).collect();
                    let error = evaluated().map(|e| e.error.as_str()).find(|error| !error.is_empty());
                    let group = Group {
                        scene,
                        view: name,
                        technique: &settings.name,
                        bias,
                        class,
                        sampled: settings.is_certified() || !views.iter().all(|&view| self.complete[view]),
                        is_bound: plan.methods[technique].is_bound(),
                        bits_per_texel: plan.methods[technique].bits_per_texel(),
                    };
                    records.push(record(&group, &outcomes, error.unwrap_or_default()));
                };
                if bias > 0 {
                    push("all", "all", (0..self.views.len()).collect(), None);
                    continue;
                }
                for (index, view) in self.views.iter().enumerate() {
                    push(&view.scene, &view.view, vec![index], None);
                }
                let classes = || [None].into_iter().chain((0..CLASSES).map(Some));
                for scene in &scenes {
                    let of_scene = |&view: &usize| self.views[view].scene == *scene;
                    for class in classes() {
                        push(scene, "all", (0..self.views.len()).filter(of_scene).collect(), class);
                    }
                }
                for class in classes() {
                    push("all", "all", (0..self.views.len()).collect(), class);
                }
            }
        }
        records
    }
}
