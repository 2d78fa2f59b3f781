//! From an experiment to its tables.

use super::records::{
    ColourRecord, TranslucentCost, TranslucentGroup, TranslucentRecord, TranslucentViewRecord,
};
use super::settings::TranslucentShadowsExperiment;
use super::view::{Group, Sample, View};
use super::{colour, picture, stability, timing};
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::{LoadedScene, spread};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use crate::statistics::{ErrorSummary, rounded, rounded_to};
use applications::translucency::TranslucentMethod;
use applications::truths;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shadow_filtering::{Kernel, Receiver};

/// Names of the classes.
const CLASSES: [&str; 3] = ["all", "surfaces", "inside"];

/// A difference that can be seen.
const VISIBLE: f64 = 0.01;

/// Groups by the number of layers: the least number of each.
const LAYERS: [(usize, &str); 6] =
    [(0, "0"), (1, "1"), (2, "2 to 3"), (4, "4 to 7"), (8, "8 to 15"), (16, "16 and more")];

/// Groups by opacity: the upper end of each.
const OPACITIES: [(f64, &str); 4] =
    [(0.1, "up to 0.1"), (0.3, "0.1 to 0.3"), (0.6, "0.3 to 0.6"), (1.0, "0.6 to 1")];

/// Receivers over which operations are averaged.
const COUNTED: usize = 200;

/// The experiment with its methods built.
pub(crate) struct Plan<'a> {
    pub(crate) experiment: &'a TranslucentShadowsExperiment,
    pub(crate) kernel: Kernel,
    pub(crate) methods: Vec<TranslucentMethod>,
}

/// One technique on one receiver.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct Answer {
    /// G - F; NaN where it failed.
    error: f64,
    /// F_Z - G.
    leak: f64,
    /// Distance from \[0, 1\] before the answer was moved there.
    outside: f64,
}

/// An answer with what it is about.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    group: Group,
    truth: f64,
    answer: Answer,
}

/// What judging a view leaves.
#[derive(Clone, Deserialize, Serialize)]
struct Found {
    row: TranslucentViewRecord,
    /// Surfaces that are drawn into a texel on average.
    layers: f64,
    /// By receiver.
    groups: Vec<Group>,
    truths: Vec<f64>,
    /// By technique and receiver, with the reason where some failed.
    judged: Vec<(Vec<Answer>, String)>,
    costs: Vec<TranslucentCost>,
    colours: Vec<ColourRecord>,
}

/// A technique on all views, by scene and view.
#[derive(Default)]
struct Judged {
    views: Vec<([String; 2], Vec<Outcome>)>,
    error: String,
}

impl TranslucentShadowsExperiment {
    /// Judges view by view, then draws, and times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let plan = Plan::new(self)?;
        let scenes = LoadedScene::load_all(&self.scenery.scenes, &self.scenery.views)?;
        picture::check(self, &scenes)?;
        if !scenes.iter().any(LoadedScene::may_be_translucent) {
            let reason = format!("nothing on {} lets light through", self.scenery.scenes.join(", "));
            return Err(EvaluationError::key("scenes", reason));
        }
        let views: Vec<_> =
            scenes.iter().flat_map(|scene| scene.lights.iter().map(move |light| (scene, light))).collect();
        let view = |number: usize| View::new(self, &plan.kernel, views[number], number);
        let one = |number: usize| {
            let (loaded, light) = views[number];
            let is_first = std::ptr::eq(light, &loaded.lights[0]);
            let view = view(number)?;
            let colours = if is_first { colour::records(&plan, views[number], &view)? } else { Vec::new() };
            plan.found([loaded.label, light.name.as_str()], &view, colours)
        };
        let found = match shards::numbered(context, "views", &vec![1; views.len()], &one)? {
            Gathered::All(found) => found,
            Gathered::Part(recorded) => return Ok(recorded),
        };
        let mut judged: Vec<Judged> = self.technique.iter().map(|_| Judged::default()).collect();
        let (mut view_rows, mut colours) = (Vec::new(), Vec::new());
        let layers = found.first().map_or(0.0, |first| first.layers);
        let costs = found.first().map(|first| first.costs.clone()).unwrap_or_default();
        for found in found {
            let names = [&found.row.scene, &found.row.view].map(String::clone);
            for (judged, (answers, error)) in judged.iter_mut().zip(found.judged) {
                let receivers = found.groups.iter().zip(&found.truths).zip(answers);
                let outcomes =
                    receivers.map(|((&group, &truth), answer)| Outcome { group, truth, answer }).collect();
                judged.views.push((names.clone(), outcomes));
                if judged.error.is_empty() {
                    judged.error = error;
                }
            }
            view_rows.push(found.row);
            colours.extend(found.colours);
        }
        let samples = if views.is_empty() { Vec::new() } else { timing::time(&plan, &view(0)?)? };
        let rows: Vec<TranslucentRecord> = judged
            .iter()
            .enumerate()
            .flat_map(|(index, judged)| {
                self.records(index, judged, plan.methods[index].bits_per_texel(layers))
            })
            .collect();
        let groups: Vec<TranslucentGroup> =
            judged.iter().enumerate().flat_map(|(index, judged)| self.groups(index, judged)).collect();
        let failed = rows.iter().filter(|row| !row.error.is_empty()).count();
        let trials = rows.len();
        let mut files = picture::draw(&plan, &scenes)?;
        files.extend([
            RecordedFile::csv("records.csv", &rows)?,
            RecordedFile::csv("groups.csv", &groups)?,
            RecordedFile::csv("views.csv", &view_rows)?,
            RecordedFile::csv("cost.csv", &costs)?,
            RecordedFile::csv("samples.csv", &samples)?,
        ]);
        if !colours.is_empty() {
            files.push(RecordedFile::csv("colour.csv", &colours)?);
        }
        if let Some(setting) = &self.stability {
            let rows = stability::records(setting, self.scenery.seed)?;
            files.push(RecordedFile::csv("stability.csv", &rows)?);
        }
        Ok(Recorded { files, trials, failed, complete: true })
    }

    /// Rows of a technique: by view, and over all of them.
    fn records(&self, index: usize, judged: &Judged, bits_per_texel: f64) -> Vec<TranslucentRecord> {
        let technique = self.technique[index].name.as_str();
        let mut rows = Vec::new();
        let all: Vec<&Outcome> = judged.views.iter().flat_map(|(_, outcomes)| outcomes).collect();
        let mut add = |names: [&str; 2], outcomes: &[&Outcome]| {
            for class in CLASSES {
                let row = record([names[0], names[1], technique, class], outcomes);
                rows.push(TranslucentRecord {
                    bits_per_texel: rounded(bits_per_texel),
                    error: judged.error.clone(),
                    ..row
                });
            }
        };
        for ([scene, view], outcomes) in &judged.views {
            add([scene, view], &outcomes.iter().collect::<Vec<_>>());
        }
        add(["all", "all"], &all);
        rows
    }

    /// A technique by the layers in front of receivers, and by their opacity.
    fn groups(&self, index: usize, judged: &Judged) -> Vec<TranslucentGroup> {
        let all =
            judged.views.iter().flat_map(|(_, outcomes)| outcomes).filter(|o| o.answer.error.is_finite());
        let (mut layers, mut opacities) = (vec![Vec::new(); LAYERS.len()], vec![Vec::new(); OPACITIES.len()]);
        for outcome in all {
            let group = &outcome.group;
            let place = LAYERS.partition_point(|&(least, _)| least <= group.layers).saturating_sub(1);
            layers[place].push(outcome);
            if group.layers > 0 {
                let place = OPACITIES.partition_point(|&(end, _)| end < group.opacity);
                opacities[place.min(OPACITIES.len() - 1)].push(outcome);
            }
        }
        let named = LAYERS.iter().map(|&(_, name)| ("layers", name)).zip(&layers);
        let named = named.chain(OPACITIES.iter().map(|&(_, name)| ("opacity", name)).zip(&opacities));
        let row = |((by, group), outcomes): ((&str, &str), &Vec<&Outcome>)| {
            let errors: Vec<f64> = outcomes.iter().map(|outcome| outcome.answer.error).collect();
            let summary = ErrorSummary::of(&errors);
            let truth = outcomes.iter().map(|outcome| outcome.truth).sum::<f64>();
            TranslucentGroup {
                technique: self.technique[index].name.clone(),
                by: by.to_owned(),
                group: group.to_owned(),
                receivers: outcomes.len(),
                mean_truth: rounded(truth / outcomes.len().max(1) as f64),
                l1_error: summary.mean,
                standard_error: summary.standard_error,
                signed_mean: summary.signed_mean,
            }
        };
        named.map(row).filter(|row| row.receivers > 0).collect()
    }
}

impl<'a> Plan<'a> {
    pub(crate) fn new(experiment: &'a TranslucentShadowsExperiment) -> Result<Self, EvaluationError> {
        let methods = experiment.technique.iter().map(|technique| technique.method());
        Ok(Self {
            experiment,
            kernel: experiment.scenery.filter()?,
            methods: methods.collect::<Result<_, _>>()?,
        })
    }

    /// All techniques on the samples of a view.
    fn found(
        &self,
        names: [&str; 2],
        view: &View,
        colours: Vec<ColourRecord>,
    ) -> Result<Found, EvaluationError> {
        let shadow = view.shadow(self.experiment, &self.kernel);
        let receivers: Vec<Receiver> = view.samples.iter().map(|sample| sample.receiver).collect();
        let truth = truths(&shadow, &receivers);
        let all = 0..self.methods.len();
        Ok(Found {
            row: view.record(names, &truth),
            layers: view.drawn(),
            groups: view.samples.iter().map(|sample| sample.group).collect(),
            judged: all.clone().map(|index| self.judge(index, view, &truth)).collect::<Result<_, _>>()?,
            costs: all.map(|index| self.cost(index, view)).collect::<Result<_, _>>()?,
            truths: truth,
            colours,
        })
    }

    /// A technique on the samples of a view, and why it failed where it did.
    fn judge(
        &self,
        index: usize,
        view: &View,
        truth: &[f64],
    ) -> Result<(Vec<Answer>, String), EvaluationError> {
        let technique = &self.experiment.technique[index];
        let shadow = view.shadow(self.experiment, &self.kernel);
        const FAILED: Answer = Answer { error: f64::NAN, leak: 0.0, outside: 0.0 };
        let ranks = match view.ranks(technique.order) {
            Ok(ranks) => ranks,
            Err(reason) => return Ok((vec![FAILED; truth.len()], reason)),
        };
        let prepared = self.methods[index]
            .prepare(&view.map, &self.kernel, ranks, self.experiment.scenery.seed)
            .map_err(|error| EvaluationError::Value(format!("technique `{}`: {error}", technique.name)))?;
        let judge = |(sample, &truth): (&Sample, &f64)| {
            let answer = prepared.unclamped(&shadow, &sample.receiver).map_err(|error| error.to_string())?;
            if !answer.is_finite() {
                return Err(format!("{answer} is no shadow"));
            }
            let g = answer.clamp(0.0, 1.0);
            let at_depth = shadow.at_depth(&sample.receiver, shadow.compared(&sample.receiver));
            let (error, leak) = (g - truth, at_depth - g);
            Ok(Answer { error, leak, outside: (answer - g).abs() })
        };
        let answers: Vec<Result<Answer, String>> = view.samples.par_iter().zip(truth).map(judge).collect();
        let error = answers.iter().find_map(|answer| answer.as_ref().err().cloned()).unwrap_or_default();
        Ok((answers.into_iter().map(|answer| answer.unwrap_or(FAILED)).collect(), error))
    }

    pub(crate) fn cost(&self, index: usize, view: &View) -> Result<TranslucentCost, EvaluationError> {
        let (technique, method) = (&self.experiment.technique[index], &self.methods[index]);
        let shadow = view.shadow(self.experiment, &self.kernel);
        let prepared = method
            .prepare(&view.map, &self.kernel, None, self.experiment.scenery.seed)
            .map_err(|error| EvaluationError::Value(format!("technique `{}`: {error}", technique.name)))?;
        let places = spread(view.samples.len(), COUNTED);
        let operations =
            places.iter().map(|&place| prepared.shade_operations(&shadow, &view.samples[place].receiver));
        let layers = view.drawn();
        let bytes = method.bits_per_texel(layers) / 8.0;
        // Blending reads a texel and writes it; a list grows by its own part, and depths are compared and written.
        let moved = match method {
            TranslucentMethod::Deep => bytes / layers,
            TranslucentMethod::Blended { .. }
            | TranslucentMethod::Absorbance { .. }
            | TranslucentMethod::Fourier { .. }
            | TranslucentMethod::Stochastic { .. }
            | TranslucentMethod::Comparison(_) => 2.0 * bytes,
        };
        let digits = |value: f64| rounded_to(value, 1e3);
        Ok(TranslucentCost {
            technique: technique.name.clone(),
            bytes_per_texel: digits(bytes),
            bytes_per_layer: digits(moved),
            operations_per_layer: digits(method.draw_operations()),
            operations_per_receiver: digits(operations.sum::<f64>() / places.len().max(1) as f64),
            ordered: method.needs_order(),
            layers: digits(layers),
        })
    }

    /// Mean |G - F| of a technique on some receivers of a view.
    pub(super) fn mean_error(
        &self,
        index: usize,
        view: &View,
        receivers: &[Receiver],
        truth: &[f64],
    ) -> Result<f64, EvaluationError> {
        let fail = |error| {
            let name = &self.experiment.technique[index].name;
            EvaluationError::Value(format!("technique `{name}`: {error}"))
        };
        let shadow = view.shadow(self.experiment, &self.kernel);
        let prepared = self.methods[index]
            .prepare(&view.map, &self.kernel, None, self.experiment.scenery.seed)
            .map_err(|error| fail(error.to_string()))?;
        let errors: Result<Vec<f64>, _> = receivers
            .par_iter()
            .zip(truth)
            .map(|(receiver, truth)| {
                let g = prepared.unclamped(&shadow, receiver)?.clamp(0.0, 1.0);
                Ok::<f64, shadow_filtering::FilteringError>((g - truth).abs())
            })
            .collect();
        let errors = errors.map_err(|error| fail(error.to_string()))?;
        Ok(errors.iter().sum::<f64>() / errors.len().max(1) as f64)
    }
}

/// The row of a class.
fn record([scene, view, technique, class]: [&str; 4], outcomes: &[&Outcome]) -> TranslucentRecord {
    let holds = |outcome: &&&Outcome| match class {
        "surfaces" => !outcome.group.inside,
        "inside" => outcome.group.inside,
        _ => true,
    };
    let members: Vec<&Outcome> = outcomes.iter().filter(holds).copied().collect();
    let answered: Vec<&Outcome> = members.iter().filter(|o| o.answer.error.is_finite()).copied().collect();
    // An empty group has no errors; its count says so.
    let count = answered.len().max(1) as f64;
    let errors: Vec<f64> = answered.iter().map(|outcome| outcome.answer.error).collect();
    let summary = ErrorSummary::of(&errors);
    let mean =
        |value: &dyn Fn(&Outcome) -> f64| rounded(answered.iter().map(|o| value(o)).sum::<f64>() / count);
    let share = |holds: &dyn Fn(&Outcome) -> bool| mean(&|o| f64::from(u8::from(holds(o))));
    TranslucentRecord {
        application: "translucent".to_owned(),
        scene: scene.to_owned(),
        view: view.to_owned(),
        technique: technique.to_owned(),
        class: class.to_owned(),
        receivers: members.len(),
        l1_error: summary.mean,
        standard_error: summary.standard_error,
        signed_mean: summary.signed_mean,
        p95: summary.p95,
        max_error: summary.maximum,
        leak: mean(&|o| o.answer.leak.max(0.0)),
        leak_share: share(&|o| o.answer.leak > VISIBLE),
        overshoot: mean(&|o| (-o.answer.leak).max(0.0)),
        above_share: share(&|o| o.answer.leak < -VISIBLE),
        outside_share: share(&|o| o.answer.outside > VISIBLE),
        outside_most: rounded(answered.iter().map(|o| o.answer.outside).fold(0.0, f64::max)),
        bits_per_texel: 0.0,
        failed: members.len() - answered.len(),
        error: String::new(),
    }
}
