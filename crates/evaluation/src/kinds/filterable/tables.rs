//! What is kept of the views, and the rows that they are pooled into.

use super::pairs;
use super::picture;
use super::plan::FilterablePlan;
use super::records::{AgreementRecord, FilterableRecord, PairRecord};
use super::settings::FilterableTechnique;
use super::statistics::{Group, Outcome, record};
use super::view::CLASSES;
use crate::error::EvaluationError;
use crate::fragments::{ReferenceRecord, ViewRecord};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::statistics::NOTHING;
use crate::timing::TimedSample;
use applications::ShadowMethod;
use serde::{Deserialize, Serialize};

/// Outcomes of one technique on one view, by bias.
#[derive(Clone, Deserialize, Serialize)]
pub(super) struct Evaluated {
    pub(super) by_bias: Vec<Vec<Outcome>>,
    /// Which of the view's samples these are, ascending.
    pub(super) places: Vec<usize>,
    pub(super) error: String,
}

/// What is kept of a view.
#[derive(Clone, Deserialize, Serialize)]
pub(super) struct Finding {
    pub(super) view: ViewRecord,
    pub(super) reference: Vec<ReferenceRecord>,
    pub(super) is_complete: bool,
    /// By technique; the last is doing nothing.
    pub(super) evaluated: Vec<Evaluated>,
    pub(super) agreement: Vec<AgreementRecord>,
    pub(super) files: Vec<RecordedFile>,
    pub(super) pictures: picture::Tables,
    /// Of the first view.
    pub(super) samples: Vec<TimedSample>,
}

/// What is kept of the views.
#[derive(Default)]
pub(super) struct Tables {
    views: Vec<ViewRecord>,
    reference: Vec<ReferenceRecord>,
    complete: Vec<bool>,
    /// By technique and view; the last technique is doing nothing.
    evaluated: Vec<Vec<Evaluated>>,
    agreement: Vec<AgreementRecord>,
    files: Vec<RecordedFile>,
    pictures: picture::Tables,
    samples: Vec<TimedSample>,
}

impl Tables {
    /// In the order of the views.
    pub(super) fn new(findings: impl Iterator<Item = Finding>) -> Self {
        let mut tables = Self::default();
        for finding in findings {
            tables.views.push(finding.view);
            tables.reference.extend(finding.reference);
            tables.complete.push(finding.is_complete);
            tables.evaluated.resize_with(finding.evaluated.len(), Vec::new);
            tables.evaluated.iter_mut().zip(finding.evaluated).for_each(|(list, one)| list.push(one));
            tables.agreement.extend(finding.agreement);
            tables.files.extend(finding.files);
            tables.pictures.kernels.extend(finding.pictures.kernels);
            tables.pictures.curves.extend(finding.pictures.curves);
            tables.samples.extend(finding.samples);
        }
        tables
    }

    pub(super) fn recorded(self, plan: &FilterablePlan<'_>) -> Result<Recorded, EvaluationError> {
        let records = self.records(plan);
        let trials = records.len() + self.agreement.len();
        let failed = records.iter().filter(|record| !record.error.is_empty()).count()
            + self.agreement.iter().filter(|record| record.failed > 0).count();
        let pairs = self.pairs(plan);
        let mut files = self.files;
        files.extend([
            RecordedFile::csv("records.csv", &records)?,
            RecordedFile::csv("pairs.csv", &pairs)?,
            RecordedFile::csv("views.csv", &self.views)?,
            RecordedFile::csv("reference.csv", &self.reference)?,
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

    /// Every technique against every other, on the fragments that both have. Doing nothing is not among them: it is what
    /// relative errors compare with.
    fn pairs(&self, plan: &FilterablePlan<'_>) -> Vec<PairRecord> {
        let complete = self.complete.iter().all(|&complete| complete);
        let of = |technique: &'_ FilterableTechnique| complete && !technique.is_certified();
        let techniques = plan.experiment.technique.iter();
        let named: Vec<(&str, bool)> = techniques.map(|one| (one.name.as_str(), of(one))).collect();
        pairs::compared(&named, &self.evaluated)
    }

    /// Rows per view, per scene and pooled, the latter two by class too; for all biases but the first only the pooled row.
    fn records(&self, plan: &FilterablePlan<'_>) -> Vec<FilterableRecord> {
        let mut scenes: Vec<&str> = Vec::new();
        for view in &self.views {
            if !scenes.contains(&view.scene.as_str()) {
                scenes.push(&view.scene);
            }
        }
        let mut records = Vec::new();
        for bias in 0..plan.experiment.bias.len() {
            for technique in 0..=plan.experiment.technique.len() {
                let settings = plan.experiment.technique.get(technique);
                let method = plan.methods.get(technique);
                let is_certified = settings.is_some_and(FilterableTechnique::is_certified);
                let mut push = |scene: &str, name: &str, views: Vec<usize>, class: Option<usize>| {
                    let evaluated = || views.iter().map(|&view| &self.evaluated[technique][view]);
                    let outcomes: Vec<&[Outcome]> = evaluated().map(|e| e.by_bias[bias].as_slice()).collect();
                    let error = evaluated().map(|e| e.error.as_str()).find(|error| !error.is_empty());
                    let group = Group {
                        scene,
                        view: name,
                        technique: settings.map_or(NOTHING, |settings| &settings.name),
                        bias,
                        class,
                        sampled: is_certified || !views.iter().all(|&view| self.complete[view]),
                        is_bound: method.is_some_and(ShadowMethod::is_bound),
                        bits_per_texel: method.map_or(0, ShadowMethod::bits_per_texel),
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
