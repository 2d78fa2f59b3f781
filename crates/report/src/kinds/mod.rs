//! The kinds of experiments: each a folder with its numbers, tables, figures and claims.

mod bounds;
mod filterable;
mod quantization;
mod ranking_map;
pub(crate) mod reference;
pub(crate) mod rows;
mod search;
mod single_scattering;
mod soft_shadows;
mod speed_accuracy;
mod stability;
mod stochastic_shadows;
mod stored;
mod temporal_shadows;
mod translucent_shadows;

use crate::error::ReportError;
use crate::page::{Content, Page};
use evaluation::{Experiment, Provenance, RunDirectory, Scale};
use std::any::Any;

/// How runs of one kind of experiment are reported.
pub(crate) struct KindPage {
    /// As `kind` in its TOML.
    name: &'static str,
    content: fn(&Reported<'_>) -> Result<Content, ReportError>,
    /// Constants of this kind's figures and explorers that the page's script shares, as JavaScript.
    script: fn() -> String,
}

/// One line a kind.
const KINDS: &[&KindPage] = &[
    &bounds::PAGE,
    &filterable::PAGE,
    &quantization::PAGE,
    &search::PAGE,
    &ranking_map::PAGE,
    &stability::PAGE,
    &speed_accuracy::PAGE,
    &soft_shadows::PAGE,
    &single_scattering::PAGE,
    &temporal_shadows::PAGE,
    &stochastic_shadows::PAGE,
    &translucent_shadows::PAGE,
];

/// Error of four power moments over that of trigonometric moments, 2.19 % / 1.93 % (MSM15 section 3.2).
const PUBLISHED_RATIO: f64 = 2.19 / 1.93;

/// A run with what it was to do and where it comes from.
pub(crate) struct Reported<'a> {
    pub(crate) run: &'a RunDirectory,
    pub(crate) experiment: &'a Experiment,
    pub(crate) provenance: &'a Provenance,
}

impl Reported<'_> {
    /// The settings of its kind.
    fn settings<T: Any>(&self) -> Result<&T, ReportError> {
        self.experiment.settings().ok_or_else(|| self.unknown())
    }

    fn unknown(&self) -> ReportError {
        ReportError::Kind { kind: self.experiment.kind_name() }
    }
}

/// Reads a run's records and draws its figures.
///
/// # Errors
/// [`ReportError`] for records that cannot be read or drawn.
pub fn page(run: &RunDirectory) -> Result<Page, ReportError> {
    let experiment = Experiment::read(&run.path().join("experiment.toml"), Scale::Quick, None)?;
    let provenance = run.provenance()?;
    let reported = Reported { run, experiment: &experiment, provenance: &provenance };
    let kind = KINDS.iter().find(|kind| kind.name == experiment.kind_name());
    let content = (kind.ok_or_else(|| reported.unknown())?.content)(&reported)?;
    Ok(Page {
        run: run.clone(),
        question: experiment.question().to_owned(),
        expectation: experiment.expectation().to_owned(),
        content,
        provenance,
    })
}

/// What the page's script shares with the figures of all kinds.
pub(crate) fn script() -> String {
    KINDS.iter().map(|kind| (kind.script)()).collect()
}
