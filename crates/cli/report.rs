//! `msm report`: figures and pages of recorded runs, from their files alone.

use crate::outcome::{Failure, Output};
use evaluation::{RunDirectory, write_whole};
use serde::Serialize;
use std::path::PathBuf;

/// Draw the figures and write the page of recorded runs.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Directories that `msm run` wrote.
    #[arg(required = true, value_name = "RUN_DIR")]
    runs: Vec<PathBuf>,
    /// One page about all of them, self-contained.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// The papers' numbers beside those of all runs, as a Markdown table.
    #[arg(long, value_name = "FILE")]
    comparison: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct Answer {
    written: Vec<String>,
}

/// Reads, draws, writes.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut answer = Answer { written: Vec::new() };
    let mut pages = Vec::new();
    for path in &arguments.runs {
        let run = RunDirectory::open(path)?;
        let page = ::report::page(&run)?;
        let files = page.write()?;
        answer.written.extend(files.iter().map(|file| run.path().join(&file.name).display().to_string()));
        pages.push(page);
    }
    if let Some(path) = &arguments.html {
        let page = ::report::html(&pages)?;
        write_whole(path, page.as_bytes())?;
        answer.written.push(path.display().to_string());
    }
    if let Some(path) = &arguments.comparison {
        write_whole(path, ::report::comparison(&pages).as_bytes())?;
        answer.written.push(path.display().to_string());
    }
    arguments.output.emit(&answer, |out| answer.written.iter().try_for_each(|file| writeln!(out, "{file}")))
}
