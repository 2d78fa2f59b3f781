//! One self-contained page about several runs: no network, no build step, works from disk.

mod blocks;

use crate::comparison;
use crate::drawing::escaped;
use crate::error::ReportError;
use crate::kinds;
use crate::page::{Page, Table, Text, code, row};
use blocks::{block, explorer, table};
use std::fmt::Write as _;

const STYLE: &str = include_str!("report.css");
const SCRIPT: &str = include_str!("report.js");

/// The pages of several runs as one, after what they answer and what the papers say.
///
/// # Errors
/// [`ReportError::Records`] for recorded pictures that cannot be read.
pub fn html(pages: &[Page]) -> Result<String, ReportError> {
    let mut sections = String::new();
    let mut links = String::new();
    for page in pages {
        let name = page.name();
        let id: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(links, "<li><a href=\"#{id}\">{}</a></li>", escaped(&name));
        let _ = writeln!(sections, "<section id=\"{id}\">\n<h2>{}</h2>", escaped(&name));
        for part in &page.opening() {
            sections += &block(&page.run, part)?;
        }
        for part in &page.content.explorers {
            sections += &explorer(&page.run, part)?;
        }
        for part in page.content.body.iter().chain(&page.origin()) {
            sections += &block(&page.run, part)?;
        }
        sections += "</section>\n";
    }
    let papers = table(&comparison::table(pages));
    let answers = table(&answers(pages));
    let origins = table(&origins(pages));
    let shared = kinds::script();
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>msm: filterable shadow maps, measured</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>Filterable shadow maps, measured</h1>\n<nav aria-label=\"experiments\"><ul>\n<li><a href=\"#answers\">answers</a></li>\n<li><a href=\"#papers\">the papers</a></li>\n{links}\
         <li><a href=\"#origins\">origins</a></li>\n</ul></nav></header>\n<main>\n\
         <section id=\"answers\">\n<h2>Answers</h2>\n{answers}</section>\n\
         <section id=\"papers\">\n<h2>The papers beside these measurements</h2>\n{papers}</section>\n{sections}<section id=\"origins\">\n<h2>Where the numbers come from</h2>\n{origins}</section>\n</main>\n<script>\n\"use strict\";\n{shared}{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}

/// Each experiment's question with the sentence that answers it.
fn answers(pages: &[Page]) -> Table {
    let rows = pages.iter().map(|page| {
        let name = page.name();
        let link = Text::default().link(&name, format!("#{name}"));
        let question = Text::default().prose(first_sentence(&page.question));
        row![link, question, page.content.answer.first().cloned().unwrap_or_default()]
    });
    Table::default().left(["experiment", "question", "answer"]).rows(rows)
}

/// Prose up to the end of its first sentence.
fn first_sentence(prose: &str) -> &str {
    let ends = [". ", ".\n", "? ", "?\n"].iter().filter_map(|end| prose.find(end));
    &prose[..ends.min().map_or(prose.len(), |end| end + 1)]
}

/// Commit, command and machine of each run.
fn origins(pages: &[Page]) -> Table {
    let rows = pages.iter().map(|page| {
        let p = &page.provenance;
        let changed = if p.build.dirty == "false" { "" } else { " and changes" };
        let commit = p.build.commit.get(..12).unwrap_or(&p.build.commit);
        row![
            page.name(),
            code(&p.command),
            format!("{commit}{changed}"),
            &p.build.rustc,
            format!("{} threads on {}, {}", p.threads, p.cpu, p.os),
            &p.started,
            format!("{:.0}", p.seconds)
        ]
    });
    let columns = ["experiment", "command", "commit", "compiler", "machine", "started"];
    Table::default().left(columns).right(["seconds"]).rows(rows)
}
