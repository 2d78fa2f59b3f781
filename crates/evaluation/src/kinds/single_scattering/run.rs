//! From an experiment to its tables.

use super::records::{AliasingRecord, ScatteringPictureRecord, ScatteringRecord, ScatteringViewRecord};
use super::settings::SingleScatteringExperiment;
use super::shot::{Maps, Shot, Source, epipole_distance};
use super::statistics::{Class, Group, LEAST_STEP, Outcome, epipole_class, record, steps_class};
use super::view::{LitScene, ScatteringScene};
use super::{aliasing, cost, edges, passes, picture, stability, timing};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::{LoadedScene, chosen};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use crate::statistics::rounded;
use crate::timing::TimedSample;
use applications::scattering::{Rectified, RectifiedMap, ViewRay};
use applications::soft_shadow::{AreaTruth, BlueNoise, OccludedFraction};
use applications::truths;
use rayon::prelude::*;
use scenes::LightView;
use serde::{Deserialize, Serialize};
use shadow_filtering::{Kernel, Technique};

/// What the run needs everywhere.
pub(super) struct Plan<'a> {
    pub(super) experiment: &'a SingleScatteringExperiment,
    /// What the techniques store, by technique.
    pub(super) techniques: Vec<Option<Technique>>,
    pub(super) source: Technique,
    pub(super) kernel: Kernel,
    pub(super) noise: BlueNoise,
    pub(super) nets: AreaTruth,
}

/// A camera under a light, judged.
#[derive(Clone, Deserialize, Serialize)]
struct Finding {
    scene: usize,
    view: String,
    standpoint: usize,
    is_complete: bool,
    truth: Vec<f64>,
    geometry: Vec<OccludedFraction>,
    steps: Vec<u8>,
    epipole: Vec<u8>,
    /// By technique.
    answers: Vec<Vec<f32>>,
}

/// All cameras under a light.
#[derive(Clone, Default, Deserialize, Serialize)]
struct LightFinding {
    findings: Vec<Finding>,
    rows: Vec<ScatteringViewRecord>,
    files: Vec<RecordedFile>,
    drawn: Vec<ScatteringPictureRecord>,
    moved: Vec<AliasingRecord>,
    biased: stability::Tally,
    /// Of the first light.
    samples: Vec<TimedSample>,
}

impl LightFinding {
    fn followed_by(mut self, later: Self) -> Self {
        self.findings.extend(later.findings);
        self.rows.extend(later.rows);
        self.files.extend(later.files);
        self.drawn.extend(later.drawn);
        self.moved.extend(later.moved);
        self.biased.merge(&later.biased);
        self.samples.extend(later.samples);
        self
    }
}

impl SingleScatteringExperiment {
    /// Evaluates light by light, camera by camera; then draws, and times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let value = |error: String| EvaluationError::Value(error);
        let loaded = LoadedScene::load_all(&self.scenery.scenes, &self.scenery.views)?;
        let scenes = loaded.iter().enumerate().map(|(index, scene)| ScatteringScene::new(self, index, scene));
        let scenes: Vec<ScatteringScene<'_>> = scenes.collect::<Result<_, _>>()?;
        let plan = Plan {
            experiment: self,
            techniques: self.built()?,
            source: self.source.build().map_err(|error| value(format!("source: {error}")))?,
            kernel: self.scenery.filter()?,
            noise: BlueNoise::new(self.scenery.seed),
            nets: self.truth.nets(self.scenery.seed)?,
        };
        picture::check(&plan, &scenes)?;
        let stands = |label: &str| self.standpoint.iter().filter(|setting| setting.is_in(label)).count();
        // By light: the scene, and how many cameras come before.
        let (mut lights, mut before) = (Vec::new(), 0);
        for (index, scene) in scenes.iter().enumerate() {
            for light in scene.lights {
                lights.push((index, light, before));
                before += stands(scene.label);
            }
        }
        let one = |number: usize| {
            let (index, light, before) = lights[number];
            plan.of_light((&loaded[index], &scenes[index]), (index, light), (before, number == 0))
        };
        let costs: Vec<u64> = lights.iter().map(|light| 1 + stands(scenes[light.0].label) as u64).collect();
        let found = match shards::numbered(context, "lights", &costs, &one)? {
            Gathered::All(found) => {
                found.into_iter().fold(LightFinding::default(), LightFinding::followed_by)
            }
            Gathered::Part(recorded) => return Ok(recorded),
        };
        let LightFinding { findings, rows, mut files, drawn, moved, biased, samples } = found;
        if findings.is_empty() {
            return Err(EvaluationError::key("standpoint", "no standpoint is for any of the scenes"));
        }
        let labels: Vec<&str> = scenes.iter().map(|scene| scene.label).collect();
        let records = plan.records(&labels, &findings);
        let trials = records.len();
        let failed = records.iter().filter(|record| !record.error.is_empty()).count();
        files.extend([
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("views.csv", &rows)?,
            RecordedFile::csv("costs.csv", &cost::records(&plan))?,
            RecordedFile::csv("samples.csv", &samples)?,
        ]);
        if let Some(timing) = &self.passes {
            let (frames, gpu) = passes::time(&plan, (&loaded[0], &scenes[0]), timing);
            files.push(RecordedFile::csv("gpu.csv", &[gpu])?);
            if !frames.is_empty() {
                files.push(RecordedFile::csv("frames.csv", &frames)?);
            }
        }
        if !drawn.is_empty() {
            files.push(RecordedFile::csv("pictures.csv", &drawn)?);
        }
        if self.aliasing.is_some() {
            files.push(RecordedFile::csv("aliasing.csv", &moved)?);
        }
        if let Some(stability) = &self.stability {
            files.push(RecordedFile::csv("stability.csv", &biased.records(stability))?);
            files.push(RecordedFile::csv("edges.csv", &edges::records(stability, self.scenery.seed)?)?);
        }
        Ok(Recorded { files, trials, failed, complete: true })
    }
}

impl Plan<'_> {
    /// All cameras under a light, and its pictures; `before` cameras come before these.
    fn of_light(
        &self,
        (loaded, scene): (&LoadedScene<'_>, &ScatteringScene<'_>),
        (index, light): (usize, &LightView),
        (before, is_timed): (usize, bool),
    ) -> Result<LightFinding, EvaluationError> {
        let experiment = self.experiment;
        let mut found = LightFinding::default();
        let lit = LitScene::new(loaded, scene, light, (experiment.scenery.size, &self.kernel, &self.source))?;
        let source = Source { technique: &self.source, stored: &lit.stored };
        let mut first = None;
        for (standpoint, setting) in experiment.standpoint.iter().enumerate() {
            if !setting.is_in(scene.label) {
                continue;
            }
            let camera = setting.camera(scene.scene, &scene.extent, lit.axes.light);
            let number = before + found.findings.len();
            let shot = Shot::new(&lit, camera, experiment.camera, (&self.noise, number))?;
            let all: Vec<usize> = (0..experiment.technique.len()).collect();
            let maps = Maps::new(experiment, &shot, &source, &all)?;
            let (finding, row) = self.finding((index, scene), standpoint, (&lit, &shot, &maps))?;
            found.findings.push(finding);
            found.rows.push(row);
            first.get_or_insert((shot, maps));
        }
        picture::draw(self, scene, (&lit, &source), (&mut found.files, &mut found.drawn))?;
        if let Some((shot, maps)) = first {
            found.moved = aliasing::records(self, scene, (&lit, &source), &shot)?;
            found.biased.add(self, &shot, &maps)?;
            if is_timed {
                found.samples = timing::time(self, scene, &shot, &source)?;
            }
        }
        Ok(found)
    }

    fn finding(
        &self,
        (index, scene): (usize, &ScatteringScene<'_>),
        standpoint: usize,
        (lit, shot, maps): (&LitScene<'_>, &Shot<'_>, &Maps),
    ) -> Result<(Finding, ScatteringViewRecord), EvaluationError> {
        let experiment = self.experiment;
        let stream = index * experiment.standpoint.len() + standpoint;
        let places = chosen(shot.rays.len(), experiment.scenery.fragments, experiment.scenery.seed, stream);
        let rays: Vec<ViewRay> = places.iter().map(|&place| shot.rays[place]).collect();
        let truth = truths(&shot.view, &rays);
        let geometry: Vec<OccludedFraction> =
            rays.par_iter().map(|ray| shot.view.traced(&scene.triangles, &self.nets, ray)).collect();
        let nearest = maps.get(false, experiment.guard_band)?;
        let steps: Vec<usize> = rays.iter().map(|ray| complexity(shot, nearest, ray)).collect();
        let mut answers = Vec::new();
        for (technique, stored) in experiment.technique.iter().zip(&self.techniques) {
            let settings = (experiment.guard_band, experiment.scenery.seed);
            let method = technique.method.prepare(shot, maps, stored.as_ref(), settings)?;
            answers.push(rays.par_iter().map(|ray| method.lit(&shot.view, ray) as f32).collect());
        }
        let count = rays.len().max(1) as f64;
        let mean = |of: &dyn Fn(usize) -> f64| (0..rays.len()).map(of).sum::<f64>() / count;
        let rectification = &nearest.rectification;
        let origin = shot.view.axes.direction(shot.view.camera);
        let row = ScatteringViewRecord {
            scene: lit.label.to_owned(),
            view: lit.light.name.clone(),
            standpoint: experiment.standpoint[standpoint].name.clone(),
            all: shot.rays.len(),
            sampled: rays.len(),
            endless: rays.iter().filter(|ray| ray.length == f64::INFINITY).count(),
            camera_lit: shot.view.light.is_lit(origin),
            epipole: rounded(shot.epipole()),
            least_inclination: rounded(rectification.flipped[0].to_degrees()),
            greatest_inclination: rounded(rectification.flipped[1].to_degrees()),
            azimuths: rounded(rectification.phi_extent.to_degrees()),
            column_width: rounded(rectification.column_width()),
            extinction: rounded(shot.view.medium.extinction()),
            mean_truth: rounded(mean(&|i| truth[i])),
            mean_geometry: rounded(mean(&|i| geometry[i].fraction)),
            difference: rounded(mean(&|i| (truth[i] - geometry[i].fraction).abs())),
            signed_difference: rounded(mean(&|i| truth[i] - geometry[i].fraction)),
            standard_error: rounded(mean(&|i| geometry[i].standard_error)),
            largest_standard_error: rounded(geometry.iter().map(|g| g.standard_error).fold(0.0, f64::max)),
            shadow_rays: geometry.iter().map(|g| g.rays as u64).sum(),
            mean_steps: rounded(mean(&|i| steps[i] as f64)),
        };
        let finding = Finding {
            scene: index,
            view: lit.light.name.clone(),
            standpoint,
            is_complete: rays.len() == shot.rays.len(),
            truth,
            geometry,
            steps: steps.iter().map(|&steps| steps_class(steps) as u8).collect(),
            epipole: rays.iter().map(|ray| epipole_class(epipole_distance(&shot.view, ray)) as u8).collect(),
            answers,
        };
        Ok((finding, row))
    }

    /// Rows of every camera, every scene, every standpoint and all together, the last by class too.
    fn records(&self, labels: &[&str], findings: &[Finding]) -> Vec<ScatteringRecord> {
        let mut records = Vec::new();
        for (technique, (of, stored)) in self.experiment.technique.iter().zip(&self.techniques).enumerate() {
            let bits_per_texel = of.method.bits_per_texel(stored.as_ref());
            let mut push = |names: [&str; 3], class: Class<'_>, findings: &[&Finding]| {
                let outcomes: Vec<Outcome> = findings.iter().flat_map(|f| f.outcomes(technique)).collect();
                let group = Group {
                    scene: names[0],
                    view: names[1],
                    standpoint: names[2],
                    technique: &of.name,
                    class,
                    sampled: !findings.iter().all(|finding| finding.is_complete),
                    bits_per_texel,
                };
                records.push(record(&group, &outcomes, ""));
            };
            for finding in findings {
                let standpoint = self.experiment.standpoint[finding.standpoint].name.as_str();
                push([labels[finding.scene], &finding.view, standpoint], Class::All, &[finding]);
            }
            for (scene, label) in labels.iter().enumerate() {
                let of_scene: Vec<&Finding> = findings.iter().filter(|f| f.scene == scene).collect();
                push([label, "all", "all"], Class::All, &of_scene);
            }
            for (standpoint, setting) in self.experiment.standpoint.iter().enumerate() {
                let from: Vec<&Finding> = findings.iter().filter(|f| f.standpoint == standpoint).collect();
                if !from.is_empty() {
                    push(["all", "all", &setting.name], Class::Standpoint(&setting.name), &from);
                }
            }
            let all: Vec<&Finding> = findings.iter().collect();
            for class in Class::each() {
                push(["all", "all", "all"], class, &all);
            }
        }
        records
    }
}

impl Finding {
    fn outcomes(&self, technique: usize) -> impl Iterator<Item = Outcome> {
        (0..self.truth.len()).map(move |i| Outcome {
            answer: self.answers[technique][i],
            truth: self.truth[i] as f32,
            geometry: self.geometry[i].fraction as f32,
            steps: self.steps[i],
            epipole: self.epipole[i],
        })
    }
}

/// Depth steps along a ray's row up to its end.
fn complexity(shot: &Shot<'_>, nearest: &RectifiedMap, ray: &ViewRay) -> usize {
    let rectification = &nearest.rectification;
    let at = Rectified::of(shot.view.axes.direction(ray.direction));
    let column = shot.view.end(ray) * at.r / rectification.column_width();
    nearest.depth_steps(rectification.row(at.phi), column as usize, LEAST_STEP)
}
