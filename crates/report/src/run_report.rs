//! Figures and page of a run directory.

use crate::bounds_figures;
use crate::bounds_summary::{Row, Tables, answer};
use crate::canvas::NamedFigure;
use crate::error::ReportError;
use crate::published::{self, Published};
use crate::quantization_summary::QuantizationTables;
use crate::search_summary::SearchTables;
use crate::speed_summary::SpeedTables;
use crate::stability_summary::StabilityTables;
use crate::{
    filterable_figures, filterable_summary, filterable_tables, quantization_figures, quantization_tables,
    search_figures, search_tables, speed_figures, speed_tables, stability_figures, stability_tables,
};
use evaluation::{
    BoundsExperiment, Experiment, FilterableExperiment, KernelRecord, Provenance, QuantizationExperiment,
    RecordedFile, RunDirectory, Scale, SearchExperiment, SpeedAccuracyExperiment, StabilityExperiment,
};
use std::fmt::Write as _;

/// Everything that `msm report` writes into a run directory, computed from its records alone.
pub fn files(run: &RunDirectory) -> Result<Vec<RecordedFile>, ReportError> {
    let experiment = Experiment::read(&run.path().join("experiment.toml"), Scale::Quick, None)?;
    if let Some(bounds) = experiment.settings() {
        bounds_files(run, bounds)
    } else if let Some(filterable) = experiment.settings() {
        filterable_files(run, filterable)
    } else if let Some(quantization) = experiment.settings() {
        quantization_files(run, quantization)
    } else if let Some(search) = experiment.settings() {
        search_files(run, search)
    } else if let Some(stability) = experiment.settings() {
        stability_files(run, stability)
    } else if let Some(speed) = experiment.settings() {
        speed_files(run, speed)
    } else {
        Err(ReportError::Empty { figure: format!("a page for kind \"{}\"", experiment.kind_name()) })
    }
}

fn filterable_files(
    run: &RunDirectory,
    experiment: &FilterableExperiment,
) -> Result<Vec<RecordedFile>, ReportError> {
    let tables = filterable_summary::Tables::read(run, experiment)?;
    let mut files = filterable_figures::draw(run, experiment, &tables)?;
    let page = Page {
        question: &experiment.question,
        expectation: &experiment.expectation,
        answer: tables.answer(experiment),
        table: filterable_tables::markdown(experiment, &tables),
        figures: files.iter().map(|figure| (figure.id.as_str(), figure.title.as_str())).collect(),
        published: published::of_filterable(&tables, experiment),
        provenance: run.provenance()?,
    };
    let page = RecordedFile { name: "README.md".to_owned(), bytes: page.markdown().into_bytes() };
    let mut files: Vec<RecordedFile> = files
        .drain(..)
        .map(|figure| RecordedFile { name: format!("{}.svg", figure.id), bytes: figure.svg.into_bytes() })
        .collect();
    files.push(page);
    Ok(files)
}

fn quantization_files(
    run: &RunDirectory,
    experiment: &QuantizationExperiment,
) -> Result<Vec<RecordedFile>, ReportError> {
    let tables = QuantizationTables::read(run)?;
    let figures = quantization_figures::draw(&tables)?;
    let page = Page {
        question: &experiment.question,
        expectation: &experiment.expectation,
        answer: tables.answer(),
        table: quantization_tables::markdown(&tables),
        figures: figures.iter().map(|figure| (figure.id, figure.title)).collect(),
        published: published::of_quantization(&tables),
        provenance: run.provenance()?,
    };
    Ok(with_page(&page, &figures))
}

/// The files of figures and of their page.
fn with_page(page: &Page<'_>, figures: &[NamedFigure]) -> Vec<RecordedFile> {
    let drawn = figures.iter().map(|figure| RecordedFile {
        name: format!("{}.svg", figure.id),
        bytes: figure.svg.clone().into_bytes(),
    });
    let page = RecordedFile { name: "README.md".to_owned(), bytes: page.markdown().into_bytes() };
    drawn.chain([page]).collect()
}

fn search_files(run: &RunDirectory, experiment: &SearchExperiment) -> Result<Vec<RecordedFile>, ReportError> {
    let tables = SearchTables::read(run)?;
    let provenance = run.provenance()?;
    let figures = search_figures::draw(&tables)?;
    let page = Page {
        question: &experiment.question,
        expectation: &experiment.expectation,
        answer: tables.answer(),
        table: search_tables::markdown(experiment, &tables),
        figures: figures.iter().map(|figure| (figure.id, figure.title)).collect(),
        published: published::of_search(&tables, experiment, &provenance),
        provenance,
    };
    Ok(with_page(&page, &figures))
}

fn stability_files(
    run: &RunDirectory,
    experiment: &StabilityExperiment,
) -> Result<Vec<RecordedFile>, ReportError> {
    let tables = StabilityTables::read(run, experiment)?;
    let figures = stability_figures::draw(&tables)?;
    let page = Page {
        question: &experiment.question,
        expectation: &experiment.expectation,
        answer: tables.answer(),
        table: stability_tables::markdown(&tables),
        figures: figures.iter().map(|figure| (figure.id, figure.title)).collect(),
        published: Vec::new(),
        provenance: run.provenance()?,
    };
    Ok(with_page(&page, &figures))
}

fn speed_files(
    run: &RunDirectory,
    experiment: &SpeedAccuracyExperiment,
) -> Result<Vec<RecordedFile>, ReportError> {
    let tables = SpeedTables::read(run, experiment)?;
    let figures = speed_figures::draw(&tables)?;
    let page = Page {
        question: &experiment.question,
        expectation: &experiment.expectation,
        answer: tables.answer(),
        table: speed_tables::markdown(experiment, &tables),
        figures: figures.iter().map(|figure| (figure.id, figure.title)).collect(),
        published: published::of_speed(&tables),
        provenance: run.provenance()?,
    };
    Ok(with_page(&page, &figures))
}

fn bounds_files(run: &RunDirectory, bounds: &BoundsExperiment) -> Result<Vec<RecordedFile>, ReportError> {
    let tables = Tables::read(run)?;
    let kernels: Vec<KernelRecord> = run.rows("kernels.csv")?;
    let mut files = Vec::new();
    for figure in &bounds.figure {
        let svg = bounds_figures::draw(figure, &tables, &kernels)?;
        files.push(RecordedFile { name: format!("{}.svg", figure.id), bytes: svg.into_bytes() });
    }
    let rows = tables.summary(bounds);
    let figures: Vec<(&str, &str)> =
        bounds.figure.iter().map(|f| (f.id.as_str(), f.title.as_str())).collect();
    let page = Page {
        question: &bounds.question,
        expectation: &bounds.expectation,
        answer: answer(bounds, &tables, &rows),
        table: table(&rows),
        figures,
        published: Vec::new(),
        provenance: run.provenance()?,
    };
    files.push(RecordedFile { name: "README.md".to_owned(), bytes: page.markdown().into_bytes() });
    Ok(files)
}

/// Writes [`files`] and returns them.
pub fn write(run: &RunDirectory) -> Result<Vec<RecordedFile>, ReportError> {
    let files = files(run)?;
    for file in &files {
        run.write(&file.name, &file.bytes)?;
    }
    Ok(files)
}

struct Page<'a> {
    question: &'a str,
    expectation: &'a str,
    answer: String,
    table: String,
    figures: Vec<(&'a str, &'a str)>,
    published: Vec<Published>,
    provenance: Provenance,
}

impl Page<'_> {
    fn markdown(&self) -> String {
        let mut text = String::new();
        let mut line = |content: &str| {
            text.push_str(content);
            text.push('\n');
        };
        line("<!-- Written by `msm report` from the files beside it. -->");
        line(&format!("**Question.** {}\n", self.question.trim()));
        line(&format!("**Expected.** {}\n", self.expectation.trim()));
        line(&format!("**Answer.** {}\n", self.answer));
        if !self.published.is_empty() {
            line("### What the papers publish\n");
            line(&published::table(&self.published));
        }
        for (id, title) in &self.figures {
            line(&format!("![{title}]({id}.svg)\n"));
        }
        line(&self.table);
        let p = &self.provenance;
        let changed = match p.build.dirty.as_str() {
            "false" => "",
            "true" => " with uncommitted changes",
            _ => " (whether it was changed is unknown)",
        };
        line("**Reproduce:**\n");
        let command = p.command.strip_prefix("msm ").unwrap_or(&p.command);
        line(&format!("```sh\ncargo run --release -- {command}\n```\n"));
        line(&format!(
            "msm {} at commit {}{changed}, {}. {} threads on {} ({} logical cores), {}. Started {}, {:.1} s. Seed {}.",
            p.build.version,
            p.build.commit,
            p.build.rustc,
            p.threads,
            p.cpu,
            p.logical_cores,
            p.os,
            p.started,
            p.seconds,
            p.seed
        ));
        for (name, hash) in &p.inputs {
            line(&format!("SHA-256 of {name}: `{hash}`."));
        }
        text
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| figure | kernel | technique | m | mean F - G | largest F - G | worst certificate gap | failed | median time |\n\
         |---|---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for row in rows {
        let time = row.median_time_ns.map_or("-".to_owned(), |ns| format!("{:.3} ms", ns / 1e6));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.4} | {:.4} | {:.0e} | {} of {} | {time} |",
            row.figure,
            row.kernel,
            row.technique,
            row.moments,
            row.mean_distance,
            row.largest_distance,
            row.worst_gap,
            row.failed,
            row.trials
        );
    }
    text.push_str(
        "\nF and G are fractions of the kernel's weight, F - G averaged over z_f from 0 to 1 (trapezoidal rule). Time \
         is for both bounds with their certificate, one thread.\n",
    );
    text
}
