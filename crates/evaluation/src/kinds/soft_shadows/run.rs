//! From an experiment to its tables.

use super::records::{SoftRecord, SoftViewRecord};
use super::settings::SoftShadowsExperiment;
use super::statistics::{Class, Group, Outcome, record, width_class};
use super::sweep::Sweeps;
use super::view::{POPULATIONS, Point, SoftScene, SoftView, other_outline, truths};
use super::{picture, receiver, timing};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::LoadedScene;
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use crate::statistics::rounded;
use applications::soft_shadow::{AreaTruth, BlueNoise, OccludedFraction, SoftReceiver, SoftShadow};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// One in so many receivers tells what the light's outline does.
const OUTLINE_STEP: usize = 4;

/// One population of a view under a light.
#[derive(Clone, Deserialize, Serialize)]
pub(super) struct Judged {
    pub(super) truth: Vec<OccludedFraction>,
    pub(super) widths: Vec<f64>,
    layers: Vec<usize>,
    /// By technique, then bias, then receiver; NaN where a technique failed.
    pub(super) intensities: Vec<Vec<Vec<f32>>>,
    /// By technique; empty where nothing failed.
    errors: Vec<String>,
    is_complete: bool,
}

/// A view under a light.
#[derive(Clone, Deserialize, Serialize)]
pub(super) struct Finding {
    pub(super) view: usize,
    pub(super) light: usize,
    pub(super) judged: [Judged; 2],
    rows: Vec<SoftViewRecord>,
    sweeps: Sweeps,
}

/// What the run needs everywhere.
pub(super) struct SoftPlan<'a> {
    pub(super) experiment: &'a SoftShadowsExperiment,
    pub(super) views: &'a [SoftView<'a>],
    pub(super) truth: AreaTruth,
    pub(super) noise: BlueNoise,
}

impl SoftShadowsExperiment {
    /// Evaluates view by view, light by light; then draws, and times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let loaded = LoadedScene::load_all(&self.scenery.scenes, &self.scenery.views)?;
        let kernel = self.scenery.filter()?;
        let noise = BlueNoise::new(self.scenery.seed);
        let scenes = loaded.iter().enumerate().map(|(index, scene)| SoftScene::new(self, index, scene));
        let scenes: Vec<SoftScene<'_>> = scenes.collect::<Result<_, _>>()?;
        let mut views = Vec::new();
        for scene in &scenes {
            for light in &scene.loaded.lights {
                views.push(SoftView::new(self, (&kernel, &noise), scene, light, views.len())?);
            }
        }
        let truth = self.truth.nets(self.scenery.seed)?;
        let plan = SoftPlan { experiment: self, views: &views, truth, noise };
        picture::check(&plan)?;
        let pairs = plan.pairs()?;
        for &(view, light) in &pairs {
            plan.check_regions(view, light)?;
        }
        let costs = vec![1; pairs.len()];
        let one = |number: usize| plan.finding(pairs[number].0, pairs[number].1);
        let findings = match shards::numbered(context, "views under lights", &costs, &one)? {
            Gathered::All(findings) => findings,
            Gathered::Part(recorded) => return Ok(recorded),
        };
        let mut sweeps = Sweeps::default();
        findings.iter().for_each(|finding| sweeps.merge(&finding.sweeps));
        let rows: Vec<&SoftViewRecord> = findings.iter().flat_map(|finding| &finding.rows).collect();
        let best = plan.best(&findings);
        let records = plan.records(&findings, &best);
        let trials = records.len();
        let failed = records.iter().filter(|record| !record.error.is_empty()).count();
        let mut files = picture::draw(&plan, &best)?;
        files.extend(receiver::draw(&plan, &findings, &best)?);
        files.extend([
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("views.csv", &rows)?,
            RecordedFile::csv("samples.csv", &timing::time(&plan)?)?,
        ]);
        if let Some(passes) = &self.passes {
            let (samples, gpu) = plan.pass_times(passes);
            files.extend([RecordedFile::csv("gpu.csv", &[gpu])?, RecordedFile::csv("passes.csv", &samples)?]);
        }
        if !self.sweep.is_empty() {
            files.push(RecordedFile::csv("sweeps.csv", &sweeps.records(self)?)?);
        }
        Ok(Recorded { files, trials, failed, complete: true })
    }
}

impl SoftPlan<'_> {
    /// Every view under every light that is meant for it.
    pub(super) fn pairs(&self) -> Result<Vec<(usize, usize)>, EvaluationError> {
        let lights = &self.experiment.light;
        let all = (0..self.views.len()).flat_map(|view| (0..lights.len()).map(move |light| (view, light)));
        let pairs: Vec<(usize, usize)> =
            all.filter(|&(view, light)| lights[light].shines_on(self.views[view].light)).collect();
        if pairs.is_empty() {
            let reason = "no light is meant for any of the views: those without a shape are for views with a light \
                          of their own, the others for the rest";
            return Err(EvaluationError::key("light", reason));
        }
        Ok(pairs)
    }

    /// Refuses a light whose search region exceeds the map, and tables that cannot hold the sums it asks for. Sweeps may go
    /// there: they count what fails.
    fn check_regions(&self, view: usize, light: usize) -> Result<(), EvaluationError> {
        let lit = self.lit(view, light)?;
        let (of, name) = (&self.views[view], &self.experiment.light[light].name);
        let place =
            format!("under light `{name}` in view `{}` of `{}`", of.light.name, of.scene.loaded.label);
        let widths = lit.penumbra.search(1.0);
        let (width, side) = (widths[0].max(widths[1]), self.experiment.scenery.size);
        if width > f64::from(side) {
            let reason = format!("{place} blockers lie within {width:.0} texels, the map has {side}");
            return Err(EvaluationError::key(format!("light[{light}]"), reason));
        }
        for (index, technique) in self.experiment.technique.iter().enumerate() {
            let name = &technique.name;
            technique.method.check_table(lit.map, &lit.penumbra).map_err(|(key, reason)| {
                let reason = format!("technique `{name}` {place}: {reason}");
                EvaluationError::key(format!("technique[{index}].method.{key}"), reason)
            })?;
        }
        Ok(())
    }

    /// A view under a light, for methods and truth.
    pub(super) fn lit(&self, view: usize, light: usize) -> Result<SoftShadow<'_>, EvaluationError> {
        let view = &self.views[view];
        let area_light = self.experiment.light[light].of(view.light, &format!("light[{light}]"))?;
        Ok(view.lit(&area_light, &self.truth))
    }

    fn finding(&self, view: usize, light: usize) -> Result<Finding, EvaluationError> {
        let mut rows = Vec::new();
        let lit = self.lit(view, light)?;
        let of = &self.views[view];
        let under = |points: &[Point], bias: usize| -> Vec<SoftReceiver> {
            points.iter().map(|point| of.receiver(point, &self.experiment.bias[bias])).collect()
        };
        let mut judged = [0, 1].map(|population| {
            let receivers = under(&of.points[population], 0);
            let truth = truths(&lit, &receivers);
            let classified: Vec<(f64, usize)> =
                receivers.par_iter().map(|receiver| of.classified(&lit, receiver)).collect();
            let (widths, layers) = classified.into_iter().unzip();
            rows.push(self.view_record((view, light, population), &lit, &receivers, &truth));
            let is_complete = truth.len() == of.all[population];
            Judged { truth, widths, layers, intensities: Vec::new(), errors: Vec::new(), is_complete }
        });
        for technique in &self.experiment.technique {
            let prepared = technique.method.prepare(lit.map, &lit.penumbra);
            for (population, judged) in judged.iter_mut().enumerate() {
                let mut reason = prepared.as_ref().err().map(ToString::to_string);
                let mut by_bias = Vec::new();
                for bias in 0..self.experiment.bias.len() {
                    let receivers = under(&of.points[population], bias);
                    let one = |receiver: &SoftReceiver| match &prepared {
                        Ok(method) => method.estimate(&lit, receiver).map_err(|error| error.to_string()),
                        Err(error) => Err(error.to_string()),
                    };
                    let answers: Vec<Result<f64, String>> = receivers.par_iter().map(one).collect();
                    reason = reason.or_else(|| answers.iter().find_map(|answer| answer.clone().err()));
                    let valid = |answer: &f64| (0.0..=1.0).contains(answer);
                    let kept = |answer: Result<f64, String>| {
                        answer.ok().filter(valid).map_or(f32::NAN, |answer| answer as f32)
                    };
                    by_bias.push(answers.into_iter().map(kept).collect());
                }
                judged.intensities.push(by_bias);
                judged.errors.push(reason.unwrap_or_default());
            }
        }
        let known: Vec<f64> = judged[0].truth.iter().map(|truth| truth.fraction).collect();
        let mut sweeps = Sweeps::default();
        sweeps.add(self.experiment, (of, light), (&self.truth, &known, &judged[0].widths))?;
        Ok(Finding { view, light, judged, rows, sweeps })
    }

    fn view_record(
        &self,
        (view, light, population): (usize, usize, usize),
        lit: &SoftShadow<'_>,
        receivers: &[SoftReceiver],
        truth: &[OccludedFraction],
    ) -> SoftViewRecord {
        let of = &self.views[view];
        let count = truth.len().max(1) as f64;
        let mean = |value: &dyn Fn(&OccludedFraction) -> f64| truth.iter().map(value).sum::<f64>() / count;
        let other = SoftShadow { light: other_outline(&lit.light), ..*lit };
        let some: Vec<SoftReceiver> = receivers.iter().step_by(OUTLINE_STEP).copied().collect();
        let others = truths(&other, &some);
        let known = truth.iter().step_by(OUTLINE_STEP);
        let differences: Vec<f64> =
            known.zip(&others).map(|(a, b)| (a.fraction - b.fraction).abs()).collect();
        let streams = || receivers.iter().map(|receiver| receiver.stream);
        let [x, y] = of.frame.texels_per_unit;
        let widths = lit.penumbra.search(1.0);
        let setting = &self.experiment.light[light];
        let shape = setting.shape.as_deref().unwrap_or_default();
        let shape = if shape.is_empty() { of.light.light.to_string() } else { shape.to_owned() };
        SoftViewRecord {
            scene: of.scene.loaded.label.to_owned(),
            view: of.light.name.clone(),
            light: setting.name.clone(),
            shape,
            population: POPULATIONS[population],
            all: of.all[population],
            sampled: truth.len(),
            lost: of.lost[population],
            first_stream: streams().min().unwrap_or_default(),
            last_stream: streams().max().unwrap_or_default(),
            layers: of.stack.layer_statistics().max,
            texels_per_unit: rounded((x * y).sqrt()),
            texel_depth: rounded(of.texel_depth),
            largest_width: rounded(widths[0].max(widths[1])),
            largest_region: lit.penumbra.largest_region([of.map.width(), of.map.height()]),
            mean_truth: rounded(mean(&|t| t.fraction)),
            mean_standard_error: rounded(mean(&|t| t.standard_error)),
            largest_standard_error: rounded(truth.iter().map(|t| t.standard_error).fold(0.0, f64::max)),
            rays: truth.iter().map(|t| t.rays as u64).sum(),
            penumbra: truth.iter().filter(|t| (0.01..=0.99).contains(&t.fraction)).count(),
            outline_difference: rounded(differences.iter().sum::<f64>() / differences.len().max(1) as f64),
            largest_outline_difference: rounded(differences.into_iter().fold(0.0, f64::max)),
        }
    }

    /// The bias of least mean error, by technique and light: fragments and pixels weigh alike. Fragments at the centres of
    /// texels shadow themselves less than what a camera sees does, and would do without a bias.
    fn best(&self, findings: &[Finding]) -> Vec<Vec<usize>> {
        let of_population = |population: usize, technique: usize, light: usize, bias: usize| {
            let of_light = findings.iter().filter(|finding| finding.light == light);
            let errors = of_light.flat_map(|finding| {
                let judged = &finding.judged[population];
                let answers = judged.intensities[technique][bias].iter().zip(&judged.truth);
                answers.map(|(&answer, truth)| (f64::from(answer) - truth.fraction).abs())
            });
            let valid = errors.filter(|error| error.is_finite());
            let (sum, count) = valid.fold((0.0, 0usize), |(sum, count), error| (sum + error, count + 1));
            if count > 0 { sum / count as f64 } else { 0.0 }
        };
        let mean = |technique: usize, light: usize, bias: usize| {
            (0..POPULATIONS.len()).map(|p| of_population(p, technique, light, bias)).sum::<f64>()
        };
        let best = |technique: usize, light: usize| {
            let biases = 0..self.experiment.bias.len();
            let means = biases.map(|bias| (mean(technique, light, bias), bias));
            means.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, bias)| bias)
        };
        let lights = 0..self.experiment.light.len();
        let techniques = 0..self.experiment.technique.len();
        techniques.map(|technique| lights.clone().map(|light| best(technique, light)).collect()).collect()
    }

    /// Rows of every view, every scene and all together under the best bias, the last by class too; for other biases all
    /// together only.
    fn records(&self, findings: &[Finding], best: &[Vec<usize>]) -> Vec<SoftRecord> {
        let mut scenes: Vec<&str> = self.views.iter().map(|view| view.scene.loaded.label).collect();
        scenes.dedup();
        let scene_of = |finding: &Finding| self.views[finding.view].scene.loaded.label;
        let mut records = Vec::new();
        for (light, setting) in self.experiment.light.iter().enumerate() {
            for (population, name) in POPULATIONS.into_iter().enumerate() {
                for (technique, of) in self.experiment.technique.iter().enumerate() {
                    let mut push = |scene: &str, view: &str, bias: usize, class, findings: &[&Finding]| {
                        let outcomes: Vec<Outcome> = findings
                            .iter()
                            .flat_map(|f| f.judged[population].outcomes(technique, bias, best[0][light]))
                            .collect();
                        let judged = || findings.iter().map(|finding| &finding.judged[population]);
                        let error = judged().map(|j| j.errors[technique].as_str()).find(|e| !e.is_empty());
                        let group = Group {
                            light: &setting.name,
                            population: name,
                            scene,
                            view,
                            technique: &of.name,
                            bias,
                            best: bias == best[technique][light],
                            class,
                            sampled: !judged().all(|judged| judged.is_complete),
                            bits_per_texel: of.method.bits_per_texel(),
                        };
                        records.push(record(&group, &outcomes, error.unwrap_or_default()));
                    };
                    let lit: Vec<&Finding> = findings.iter().filter(|f| f.light == light).collect();
                    if lit.is_empty() {
                        continue;
                    }
                    let bias = best[technique][light];
                    for finding in &lit {
                        let view = self.views[finding.view].light.name.as_str();
                        push(scene_of(finding), view, bias, Class::All, &[finding]);
                    }
                    for scene in &scenes {
                        let of_scene: Vec<&Finding> =
                            lit.iter().filter(|f| scene_of(f) == *scene).copied().collect();
                        if !of_scene.is_empty() {
                            push(scene, "all", bias, Class::All, &of_scene);
                        }
                    }
                    for class in Class::each() {
                        push("all", "all", bias, class, &lit);
                    }
                    for other in (0..self.experiment.bias.len()).filter(|&other| other != bias) {
                        push("all", "all", other, Class::All, &lit);
                    }
                }
            }
        }
        records
    }
}

impl Judged {
    fn outcomes(&self, technique: usize, bias: usize, first_bias: usize) -> Vec<Outcome> {
        let answers = self.intensities[technique][bias].iter().zip(&self.intensities[0][first_bias]);
        let classes = self.widths.iter().zip(&self.layers);
        let all = answers.zip(classes).zip(&self.truth);
        all.map(|(((&intensity, &first), (&width, &layers)), truth)| Outcome {
            intensity,
            truth: truth.fraction as f32,
            first,
            width: width_class(width) as u8,
            layers: layers.min(3) as u8,
        })
        .collect()
    }
}
