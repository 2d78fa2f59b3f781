//! The page of a run as data. [`markdown`] and `html` are its two renderers; neither reads the other's text.

mod claim;
pub(crate) mod markdown;
mod number;
mod table;
mod text;
mod tradeoffs;

use crate::error::ReportError;
pub(crate) use claim::{Claim, Measured, Missing, player, recorded};
use evaluation::{Provenance, RecordedFile, RunDirectory};
pub(crate) use number::{count_of, in_percent, median_of, percent, percent_tick};
use serde::Serialize;
pub(crate) use table::{Table, row};
pub(crate) use text::{Span, Text, code};
pub(crate) use tradeoffs::{Breaks, Tradeoff, Tradeoffs, UNSTABLE};

/// Everything that a run's page says and shows, computed from its records alone.
pub struct Page {
    pub(crate) run: RunDirectory,
    pub(crate) question: String,
    pub(crate) expectation: String,
    pub(crate) content: Content,
    pub(crate) provenance: Provenance,
}

/// As JSON, which words and numbers always have.
pub(crate) fn json<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// What a kind of experiment puts on its page.
#[derive(Default)]
pub(crate) struct Content {
    /// The answer to the question, a finding a sentence, the most important first.
    pub(crate) answer: Vec<Text>,
    /// What papers say, for the table of all runs; where it stands on this page is up to `body`.
    pub(crate) claims: Vec<Claim>,
    /// What a reader can play with; below the answer, in HTML only.
    pub(crate) explorers: Vec<Explorer>,
    /// What error costs, for the chart of all runs.
    pub(crate) tradeoffs: Option<Tradeoffs>,
    /// Where stored bounds break, for the same chart.
    pub(crate) breaks: Vec<Breaks>,
    /// Everything below.
    pub(crate) body: Vec<Block>,
}

/// A part of a page.
#[derive(Clone, Debug)]
pub(crate) enum Block {
    /// Level 2 or 3.
    Heading(u8, String),
    Paragraph(Text),
    /// Lines for a shell.
    Commands(String),
    Table(Table),
    Drawing(Drawing),
    Picture(RecordedPicture),
}

/// A drawing with its file stem and title.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) id: String,
    pub(crate) title: String,
    pub(crate) svg: String,
}

/// A picture that the run recorded as a PNG with this file stem.
#[derive(Clone, Debug)]
pub(crate) struct RecordedPicture {
    pub(crate) id: String,
    pub(crate) title: String,
    pub(crate) columns: PictureColumns,
}

/// The reference and techniques side by side in a picture, all of one size in pixels.
#[derive(Clone, Debug)]
pub(crate) struct PictureColumns {
    pub(crate) size: [u32; 2],
    /// Techniques, from the second column on.
    pub(crate) techniques: Vec<String>,
}

/// An element of the HTML page that a script brings to life.
pub(crate) enum Explorer {
    /// The class that the script knows it by, and its data as JSON.
    Chart { class: &'static str, data: String },
    /// Pictures with equal columns, one shown at a time.
    Pictures(PictureColumns, Vec<RecordedPicture>),
    /// Frames that follow each other.
    Film(Film),
}

/// A picture that the run recorded as a PNG with this file stem: frames of one size, one below the other.
pub(crate) struct Film {
    pub(crate) id: String,
    pub(crate) title: String,
    /// Of a frame in pixels.
    pub(crate) size: [u32; 2],
    /// Number of the path's frame that each shows.
    pub(crate) frames: Vec<usize>,
}

impl Page {
    /// Everything that `msm report` writes into the run directory: figures, and the page in Markdown.
    pub fn files(&self) -> Vec<RecordedFile> {
        let drawn = self.content.body.iter().filter_map(|block| match block {
            Block::Drawing(drawing) => Some(RecordedFile {
                name: format!("{}.svg", drawing.id),
                bytes: drawing.svg.clone().into_bytes(),
            }),
            Block::Heading(..)
            | Block::Paragraph(_)
            | Block::Commands(_)
            | Block::Table(_)
            | Block::Picture(_) => None,
        });
        let page = RecordedFile { name: "README.md".to_owned(), bytes: markdown::page(self).into_bytes() };
        drawn.chain([page]).collect()
    }

    /// Writes [`Page::files`] and returns them.
    ///
    /// # Errors
    /// [`ReportError::Records`] where a file cannot be written.
    pub fn write(&self) -> Result<Vec<RecordedFile>, ReportError> {
        let files = self.files();
        for file in &files {
            self.run.write(&file.name, &file.bytes)?;
        }
        Ok(files)
    }

    /// The most important finding, as inline Markdown.
    pub fn finding(&self) -> String {
        self.content.answer.first().map(markdown::inline).unwrap_or_default()
    }

    /// The experiment's name: the directory above the run's.
    pub(crate) fn name(&self) -> String {
        let parent = self.run.path().parent().and_then(|path| path.file_name());
        parent.map_or_else(|| "run".to_owned(), |name| name.to_string_lossy().into_owned())
    }

    /// Scenes that were evaluated, as they were given.
    pub(crate) fn scenes(&self) -> Vec<String> {
        let resolved = self.run.text("experiment.toml").unwrap_or_default();
        let table: toml::Table = resolved.parse().unwrap_or_default();
        let scenes = table.get("scenes").and_then(|scenes| scenes.as_array());
        scenes.into_iter().flatten().filter_map(|scene| Some(scene.as_str()?.to_owned())).collect()
    }

    /// Question and expectation, each a paragraph.
    pub(crate) fn opening(&self) -> [Block; 3] {
        let paragraph = |word: &str, text: Text| {
            let head = Text::default().strong(word).and(" ");
            Block::Paragraph(Text::joined([head, text], ""))
        };
        [
            paragraph("Question.", Text::default().prose(&self.question)),
            paragraph("Expected.", Text::default().prose(&self.expectation)),
            paragraph("Answer.", Text::joined(self.content.answer.iter().cloned(), " ")),
        ]
    }

    /// How to make the page again, and with what it was made.
    pub(crate) fn origin(&self) -> [Block; 3] {
        let p = &self.provenance;
        let changed = match p.build.dirty.as_str() {
            "false" => "",
            "true" => " with uncommitted changes",
            _ => " (whether it was changed is unknown)",
        };
        let mut made = Text::from(format!(
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
            made = made.and(format!("\nSHA-256 of {name}: ")).code(hash).and(".");
        }
        [
            Block::Paragraph(Text::default().strong("Reproduce:")),
            Block::Commands(format!("cargo run --release -- {}", self.arguments())),
            Block::Paragraph(made),
        ]
    }

    /// The command that made the run, without the program's name.
    pub(crate) fn arguments(&self) -> &str {
        let command = &self.provenance.command;
        command.strip_prefix("msm ").unwrap_or(command)
    }
}

impl Drawing {
    pub(crate) fn new(id: impl Into<String>, title: impl Into<String>, svg: String) -> Self {
        Self { id: id.into(), title: title.into(), svg }
    }
}

impl RecordedPicture {
    pub(crate) fn new(id: &str, title: String, size: [u32; 2], techniques: &[String]) -> Self {
        let columns = PictureColumns { size, techniques: techniques.to_vec() };
        Self { id: id.to_owned(), title, columns }
    }

    /// The picture above the names of its columns, of which the first is the reference, and a note on them.
    pub(crate) fn with_legend(self, reference: &str, note: &str) -> [Block; 2] {
        let techniques = self.columns.techniques.join("; ");
        let words = format!("{}, from left to right: {reference}; {techniques}. {note}", self.title);
        [Block::Picture(self), Block::paragraph(words)]
    }
}

impl Block {
    pub(crate) fn heading(level: u8, text: impl Into<String>) -> Self {
        Self::Heading(level, text.into())
    }

    /// Claims, then figures, then tables: the order of most pages.
    pub(crate) fn body(claims: &[Claim], figures: Vec<Drawing>, tables: Vec<Self>) -> Vec<Self> {
        let figures = figures.into_iter().map(Self::Drawing);
        Claim::blocks(claims).into_iter().chain(figures).chain(tables).collect()
    }

    pub(crate) fn paragraph(text: impl Into<Text>) -> Self {
        Self::Paragraph(text.into())
    }

    /// A table under its heading, with a note on how to read it where one is needed; nothing without rows.
    pub(crate) fn section(
        level: u8,
        heading: &str,
        table: impl Into<Table>,
        note: Option<Text>,
    ) -> Vec<Self> {
        let table = table.into();
        if table.rows.is_empty() {
            return Vec::new();
        }
        let parts = [Self::heading(level, heading), Self::Table(table)];
        parts.into_iter().chain(note.map(Self::Paragraph)).collect()
    }
}
