//! One self-contained page about several runs: no network, no build step, works from disk.

mod blocks;

use crate::comparison;
use crate::drawing::escaped;
use crate::error::ReportError;
use crate::kinds;
use crate::page::{Page, Table, Text, code};
use blocks::{block, explorer, table};
use evaluation::Provenance;
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
    let headings = headings(pages);
    for (page, Heading { id, title }) in pages.iter().zip(&headings) {
        // Writing to a string cannot fail.
        let _ = writeln!(links, "<li><a href=\"#{id}\">{}</a></li>", escaped(title));
        let _ = writeln!(sections, "<section id=\"{id}\">\n<h2>{}</h2>", escaped(title));
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
    let answers = table(&answers(pages, &headings));
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

/// Where a run's section begins.
struct Heading {
    id: String,
    title: String,
}

/// Several runs of one experiment are told apart by when they started.
fn headings(pages: &[Page]) -> Vec<Heading> {
    let of = |(number, page): (usize, &Page)| {
        let name = page.name();
        let id: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        if pages.iter().filter(|other| other.name() == name).count() == 1 {
            return Heading { id, title: name };
        }
        Heading { id: format!("{id}-{number}"), title: format!("{name}, {}", page.provenance.started) }
    };
    pages.iter().enumerate().map(of).collect()
}

/// Each experiment's question with the sentence that answers it.
fn answers(pages: &[Page], headings: &[Heading]) -> Table {
    Table::of(pages.iter().zip(headings))
        .left("experiment", |(_, at)| Text::default().link(&at.title, format!("#{}", at.id)))
        .left("question", |(page, _)| Text::default().prose(first_sentence(&page.question)))
        .left("answer", |(page, _)| page.content.answer.first().cloned().unwrap_or_default())
        .into()
}

/// Prose up to the end of its first sentence.
fn first_sentence(prose: &str) -> &str {
    let ends = [". ", ".\n", "? ", "?\n"].iter().filter_map(|end| prose.find(end));
    &prose[..ends.min().map_or(prose.len(), |end| end + 1)]
}

/// Commit, command and machine of each run.
fn origins(pages: &[Page]) -> Table {
    let changed = |page: &Page| if page.provenance.build.dirty == "false" { "" } else { " and changes" };
    let machine = |p: &Provenance| format!("{} threads on {}, {}", p.threads, p.cpu, p.os);
    let commit = |p: &Provenance| p.build.commit.chars().take(12).collect::<String>();
    Table::of(pages)
        .left("experiment", Page::name)
        .left("command", |page| code(&page.provenance.command))
        .left("commit", |page| commit(&page.provenance) + changed(page))
        .left("compiler", |page| &page.provenance.build.rustc)
        .left("machine", |page| machine(&page.provenance))
        .left("started", |page| &page.provenance.started)
        .right("seconds", |page| format!("{:.0}", page.provenance.seconds))
        .into()
}
