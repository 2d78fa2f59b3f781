//! From an experiment to its tables.

use super::method::Choice;
use super::picture;
use super::records::{PlaneRecord, StochasticRecord, StochasticViewRecord};
use super::settings::StochasticShadowsExperiment;
use super::shading::{LitFrame, Traced};
use super::{modulation, timing};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::chosen;
use crate::lit_frames::{
    Anew, Lit, Ready, Scenery, Seen, Sight, Stage, Window, largest_coordinate, middle_map,
};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use crate::statistics::{ErrorSummary, rounded};
use applications::rays::{Segment, Triangles};
use applications::soft_shadow::{AreaTruth, OccludedFraction};
use rayon::prelude::*;
use scenes::vector::{minus, norm};
use scenes::{CameraPath, LightView, Movement};
use serde::{Deserialize, Serialize};

/// Names of the classes.
const CLASSES: [&str; 3] = ["all", "penumbra", "contact"];

/// A judged pixel.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub(super) seen: Seen,
    pub(super) truth: OccludedFraction,
    contact: bool,
}

/// One technique on one pixel.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct Outcome {
    /// NaN where it failed.
    shadow: f32,
    truth: f32,
    contact: bool,
    /// |shadow - that of another map|.
    noise: Option<f32>,
    unreached: bool,
}

/// What a technique costs.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Cost {
    planes: usize,
    size: u32,
    bits_per_texel: usize,
    mebibytes: f64,
    lookups: usize,
}

/// Outcomes of a technique.
#[derive(Clone, Deserialize, Serialize)]
struct Judged {
    outcomes: Vec<Outcome>,
    cost: Cost,
    error: String,
}

/// What judging leaves.
#[derive(Clone, Default, Deserialize, Serialize)]
struct Ledger {
    rows: Vec<StochasticRecord>,
    views: Vec<StochasticViewRecord>,
    planes: Vec<PlaneRecord>,
    /// Of all scenes, by view, light and technique.
    pooled: Vec<(String, [usize; 2], Judged)>,
}

impl Ledger {
    /// With what judging a later view has left.
    fn followed_by(mut self, later: Self) -> Self {
        self.rows.extend(later.rows);
        self.views.extend(later.views);
        self.planes.extend(later.planes);
        for (view, key, judged) in later.pooled {
            self.add(&view, key, judged);
        }
        self
    }

    /// Pools outcomes with those of other scenes.
    fn add(&mut self, view: &str, key: [usize; 2], judged: Judged) {
        match self.pooled.iter_mut().find(|(v, k, _)| v == view && *k == key) {
            Some((_, _, all)) => {
                all.outcomes.extend(judged.outcomes);
                if all.error.is_empty() {
                    all.error = judged.error;
                }
            }
            None => self.pooled.push((view.to_owned(), key, judged)),
        }
    }
}

impl StochasticShadowsExperiment {
    /// Judges scene by scene and light by light, then draws, and times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let truth = self.truth.nets(self.scenery.seed)?;
        let stages = self.scenery.scenes.iter().enumerate();
        let stages: Vec<Stage> = stages.map(|(i, label)| Stage::load(label, i)).collect::<Result<_, _>>()?;
        for stage in &stages {
            for view in stage.views(&self.scenery.views)? {
                self.light.iter().try_for_each(|light| light.of(view).map(|_| ()))?;
            }
        }
        picture::check(self, &stages)?;
        let mut pairs = Vec::new();
        for (number, stage) in stages.iter().enumerate() {
            for (place, view) in stage.views(&self.scenery.views)?.into_iter().enumerate() {
                pairs.extend((0..self.light.len()).map(|light| (number, place, view, light)));
            }
        }
        let one = |pair: usize| {
            let (number, place, view, index) = pairs[pair];
            let (stage, mut ledger) = (&stages[number], Ledger::default());
            let scenery = stage.on(false);
            let sight = self.sight(&scenery, self.camera, self.zoom, 0)?;
            let lit = self.lit_frame(&scenery, 0, (self.light[index].of(view)?, &sight))?;
            let stream = ((number * stages.len() + place) * self.light.len() + index) as u64;
            self.judge((stage, &scenery), &lit, (&truth, index, stream), &mut ledger)?;
            Ok(ledger)
        };
        let costs = vec![1; pairs.len()];
        let mut ledger = match shards::numbered(context, "views under lights", &costs, &one)? {
            Gathered::All(ledgers) => ledgers.into_iter().fold(Ledger::default(), Ledger::followed_by),
            Gathered::Part(recorded) => return Ok(recorded),
        };
        pool(self, &mut ledger);
        let trials = ledger.rows.len();
        let failed = ledger.rows.iter().filter(|row| !row.error.is_empty()).count();
        let mut files = picture::draw(self, &stages, &truth)?;
        files.extend([
            RecordedFile::csv("records.csv", &ledger.rows)?,
            RecordedFile::csv("views.csv", &ledger.views)?,
            RecordedFile::csv("planes.csv", &ledger.planes)?,
            RecordedFile::csv("samples.csv", &timing::time(self, &stages[0])?)?,
        ]);
        if let Some(rows) = modulation::measure(self, &truth)? {
            files.push(RecordedFile::csv("modulation.csv", &rows)?);
        }
        Ok(Recorded { files, trials, failed, complete: true })
    }

    /// What a camera that stands still sees in a frame.
    pub(super) fn sight(
        &self,
        scenery: &Scenery<'_>,
        camera: [u32; 2],
        zoom: f64,
        frame: usize,
    ) -> Result<Sight, EvaluationError> {
        let path = CameraPath { movement: Movement::Still, degrees: 0.0, zoom, frames: frame + 1 };
        Sight::new(&Window { camera, overscan: 0.0 }, scenery, &path, frame)
    }

    fn judge(
        &self,
        (stage, scenery): (&Stage, &Scenery<'_>),
        lit: &LitFrame<'_>,
        (truth, index, stream): (&AreaTruth, usize, u64),
        ledger: &mut Ledger,
    ) -> Result<(), EvaluationError> {
        let whole = scenery.whole(0)?;
        let triangles = whole.triangles();
        let largest = largest_coordinate(&scenery.scene.at(0));
        let all: Vec<usize> = (0..lit.seen.len()).filter(|&pixel| lit.seen[pixel].is_some()).collect();
        let indices = chosen(all.len(), self.scenery.fragments, self.scenery.seed, stream as usize);
        let sample = |&place: &usize| {
            let pixel = all[place];
            let seen = lit.seen[pixel]?;
            Some(self.sample(lit, (triangles, largest), truth, &seen, pixel as u64))
        };
        let samples: Vec<Sample> = indices.par_iter().filter_map(sample).collect();
        let names = [&stage.label, &lit.light.view.name, &self.light[index].name];
        let techniques: Vec<usize> = (0..self.technique.len()).collect();
        let mut judged: Vec<Option<Judged>> = techniques.iter().map(|_| None).collect();
        // Two maps, of other points of the light: their difference is noise. One after the other, for memory.
        let mut firsts: Vec<Vec<Option<f64>>> = vec![Vec::new(); techniques.len()];
        for repetition in [1, 0] {
            let mut traced = Traced::new();
            for group in lit.groups(&self.filtered(&techniques), 2 * stream + repetition, &mut traced)? {
                let [scene, view, light] = names.map(String::as_str);
                for (member, technique) in group.techniques() {
                    let shade = |sample: &Sample| group.shadow(member, self.bias(technique), &sample.seen);
                    let answers: Vec<Result<Option<f64>, String>> = samples.par_iter().map(shade).collect();
                    if repetition == 1 {
                        firsts[technique] = answers.into_iter().map(|answer| answer.ok().flatten()).collect();
                        continue;
                    }
                    if member == 0 {
                        let name = self.technique[technique].name.as_str();
                        ledger.planes.extend(group.plane_records([scene, view, light, name]));
                    }
                    let (bits_per_texel, mebibytes) = group.memory(member);
                    let planes = group.planes();
                    let lookups = group.lookups();
                    let cost = Cost { planes, size: group.size(), bits_per_texel, mebibytes, lookups };
                    judged[technique] = Some(of_answers(&samples, answers, Some(&firsts[technique]), cost));
                }
            }
        }
        let map = middle_map(scenery, &lit.light, 0)?;
        let lit_by = Lit { map: &map, light: &lit.light, truth, triangles };
        for technique in techniques {
            if let Some(Choice::Anew(method)) = self.technique[technique].choice() {
                judged[technique] = Some(self.made_anew(method, technique, &samples, &lit_by));
            }
        }
        let [scene, view, light] = names.map(String::as_str);
        for (technique, judged) in judged.into_iter().enumerate() {
            let Some(judged) = judged else { continue };
            let name = self.technique[technique].name.as_str();
            ledger
                .rows
                .extend(CLASSES.iter().map(|class| record([scene, view, light, name], class, &judged)));
            ledger.add(view, [index, technique], judged);
        }
        ledger.views.push(self.view_record(names, lit, (&samples, scenery)));
        Ok(())
    }

    /// A surface with its truth.
    pub(super) fn sample(
        &self,
        lit: &LitFrame<'_>,
        (triangles, largest): (&Triangles, f64),
        truth: &AreaTruth,
        seen: &Seen,
        stream: u64,
    ) -> Sample {
        let surface = seen.surface(triangles, largest);
        let from = Some(surface.triangle);
        let placed = &lit.light.placed;
        let truth = truth.occluded_fraction(triangles, placed, surface.position, from, stream);
        // As long as so many texels of the map are wide on the surface.
        let frame = &lit.light.frame;
        let distance = frame.near + frame.project(surface.position)[2] * frame.depth_range;
        let [x, y] = frame.texels_per_unit;
        let reach = self.contact * distance / (frame.near * (x * y).sqrt());
        let towards = minus(placed.middle, surface.position);
        let direction = towards.map(|c| c * (reach / norm(towards)).min(1.0));
        let contact =
            triangles.occludes(&Segment { origin: surface.position, direction, endless: false, from });
        Sample { seen: *seen, truth, contact }
    }

    fn made_anew(&self, method: Anew<'_>, technique: usize, samples: &[Sample], lit: &Lit<'_>) -> Judged {
        let size = lit.light.frame.width;
        let bits_per_texel = method.bits_per_texel();
        let texels = f64::from(size) * f64::from(lit.light.frame.height);
        let mebibytes = bits_per_texel as f64 / 8.0 * texels / f64::from(1 << 20);
        let cost = Cost { planes: 0, size, bits_per_texel, mebibytes, lookups: 0 };
        match Ready::new(method, lit, self.scenery.seed) {
            Ok(ready) => {
                let shade = |sample: &Sample| {
                    let shadow = ready.shadow(lit, self.bias(technique), &sample.seen, sample.seen.position);
                    shadow.map(Some)
                };
                let answers = samples.par_iter().map(shade).collect();
                of_answers(samples, answers, None, Cost { lookups: ready.lookups() as usize, ..cost })
            }
            Err(error) => {
                let answers = samples.iter().map(|_| Err(error.to_string())).collect();
                of_answers(samples, answers, None, cost)
            }
        }
    }

    fn view_record(
        &self,
        [scene, view, light]: [&String; 3],
        lit: &LitFrame<'_>,
        (samples, scenery): (&[Sample], &Scenery<'_>),
    ) -> StochasticViewRecord {
        let count = samples.len().max(1) as f64;
        let mean = |value: &dyn Fn(&OccludedFraction) -> f64| {
            samples.iter().map(|sample| value(&sample.truth)).sum::<f64>() / count
        };
        StochasticViewRecord {
            scene: scene.clone(),
            view: view.clone(),
            light: light.clone(),
            shape: lit.light.view.light.to_string(),
            triangles: scenery.scene.at(0).triangles.len(),
            pixels: lit.seen.iter().flatten().count(),
            judged: samples.len(),
            penumbra: samples.iter().filter(|sample| is_penumbra(sample.truth.fraction)).count(),
            contact: samples.iter().filter(|sample| sample.contact).count(),
            mean_truth: rounded(mean(&|truth| truth.fraction)),
            mean_standard_error: rounded(mean(&|truth| truth.standard_error)),
            largest_standard_error: rounded(
                samples.iter().map(|sample| sample.truth.standard_error).fold(0.0, f64::max),
            ),
            rays: samples.iter().map(|sample| sample.truth.rays as u64).sum(),
            seed: self.scenery.seed,
        }
    }

    /// The views of a name, or all that are wanted.
    pub(super) fn view_of<'s>(
        &self,
        stage: &'s Stage,
        name: &str,
    ) -> Result<Option<&'s LightView>, EvaluationError> {
        let views = stage.views(&self.scenery.views)?;
        Ok(views.into_iter().find(|view| name.is_empty() || view.name == name))
    }
}

fn is_penumbra(truth: f64) -> bool {
    (0.01..=0.99).contains(&truth)
}

fn of_answers(
    samples: &[Sample],
    answers: Vec<Result<Option<f64>, String>>,
    firsts: Option<&Vec<Option<f64>>>,
    cost: Cost,
) -> Judged {
    let error = answers.iter().find_map(|answer| answer.as_ref().err().cloned()).unwrap_or_default();
    let outcome = |(i, (answer, sample)): (usize, (Result<Option<f64>, String>, &Sample))| {
        let answer = answer.ok();
        // Where no sample reaches nothing is known to be in shadow.
        let shadow = answer.map_or(f64::NAN, |answer| answer.unwrap_or(0.0));
        let other = firsts.and_then(|firsts| firsts.get(i).copied()).map(|first| first.unwrap_or(0.0));
        Outcome {
            shadow: shadow as f32,
            truth: sample.truth.fraction as f32,
            contact: sample.contact,
            noise: other.map(|other| (shadow - other).abs() as f32),
            unreached: answer == Some(None),
        }
    };
    Judged { outcomes: answers.into_iter().zip(samples).enumerate().map(outcome).collect(), cost, error }
}

/// The row of a class.
fn record([scene, view, light, technique]: [&str; 4], class: &str, judged: &Judged) -> StochasticRecord {
    let holds = |outcome: &&Outcome| match class {
        "penumbra" => is_penumbra(f64::from(outcome.truth)),
        "contact" => outcome.contact,
        _ => true,
    };
    let members: Vec<&Outcome> = judged.outcomes.iter().filter(holds).collect();
    let answered: Vec<&Outcome> = members.iter().filter(|o| o.shadow.is_finite()).copied().collect();
    // An empty group has no errors; its count says so.
    let count = answered.len().max(1) as f64;
    let errors: Vec<f64> = answered.iter().map(|o| f64::from(o.shadow) - f64::from(o.truth)).collect();
    let summary = ErrorSummary::of(&errors);
    let noises: Vec<f64> =
        answered.iter().filter_map(|o| o.noise).filter(|noise| noise.is_finite()).map(f64::from).collect();
    let Cost { planes, size, bits_per_texel, mebibytes, lookups } = judged.cost;
    StochasticRecord {
        application: "stochastic".to_owned(),
        scene: scene.to_owned(),
        view: view.to_owned(),
        light: light.to_owned(),
        technique: technique.to_owned(),
        class: class.to_owned(),
        receivers: members.len(),
        l1_error: summary.mean,
        standard_error: summary.standard_error,
        signed_mean: summary.signed_mean,
        p95: summary.p95,
        noise: (!noises.is_empty()).then(|| rounded(noises.iter().sum::<f64>() / noises.len() as f64)),
        unreached: rounded(answered.iter().filter(|o| o.unreached).count() as f64 / count),
        planes,
        size,
        bits_per_texel,
        mebibytes: rounded(mebibytes),
        lookups,
        failed: members.len() - answered.len(),
        error: judged.error.clone(),
    }
}

/// Rows over all scenes.
fn pool(experiment: &StochasticShadowsExperiment, ledger: &mut Ledger) {
    for (view, [light, technique], judged) in &ledger.pooled {
        let names =
            ["all", view.as_str(), &experiment.light[*light].name, &experiment.technique[*technique].name];
        ledger.rows.extend(CLASSES.iter().map(|class| record(names, class, judged)));
    }
}
