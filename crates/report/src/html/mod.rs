//! One self-contained page about several runs: no network, no build step, works from disk.

mod archive;
mod blocks;
mod compact;
mod film;
mod pictures;
mod tradeoffs;

use crate::comparison;
use crate::drawing::escaped;
use crate::error::ReportError;
use crate::kinds;
use crate::page::{Block, Page, Table, Text, code};
use blocks::{block, explorer, folded, folded_figure, inline, table};
use evaluation::Provenance;
use std::fmt::Write as _;
use std::path::Path;

const STYLE: &str = concat!(include_str!("report.css"), include_str!("film.css"));
const SCRIPT: &str = concat!(
    include_str!("archive.js"),
    include_str!("tables.js"),
    include_str!("pictures.js"),
    include_str!("charts.js"),
    include_str!("candidates.js"),
    include_str!("film.js")
);
/// The library of the interactive charts, with its style and licence; `assets/README.md` says where they are from.
const LIBRARY: &str = include_str!("../../assets/uPlot.iife.min.js");
const LIBRARY_STYLE: &str = include_str!("../../assets/uPlot.min.css");
const LIBRARY_LICENCE: &str = include_str!("../../assets/uPlot.LICENSE");

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
        let mut heading = String::new();
        // A part within a part that is not there is a part itself: no level is skipped.
        let mut has_parts = false;
        let mut drawn = 0;
        for part in page.content.body.iter().chain(&page.origin()) {
            if let Block::Heading(level, text) = part {
                heading.clone_from(text);
                has_parts |= *level == 2;
            }
            sections += &match part {
                Block::Heading(_, text) if !has_parts => block(&page.run, &Block::heading(2, text))?,
                Block::Table(of) if of.rows.len() > FOLDED_ROWS => folded(of, &heading),
                Block::Drawing(drawing) => {
                    drawn += 1;
                    let figure = block(&page.run, part)?;
                    if drawn > OPEN_FIGURES { folded_figure(&figure, &drawing.title) } else { figure }
                }
                Block::Heading(..)
                | Block::Paragraph(_)
                | Block::Commands(_)
                | Block::Table(_)
                | Block::Picture(_) => block(&page.run, part)?,
            };
        }
        sections += "</section>\n";
    }
    let papers = table(&comparison::table(pages));
    let answers = table(&answers(pages, &headings));
    let origins = table(&origins(pages));
    let shared = tradeoffs::script() + &kinds::script();
    let colours = tradeoffs::style();
    let first = first_screen(pages)?;
    let page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>msm: filterable shadow maps, measured</title>\n<style>\n{LIBRARY_STYLE}\n{STYLE}{colours}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#main\">to the content</a>\n<header><h1>Filterable shadow maps, measured</h1></header>\n<nav aria-label=\"experiments\"><ul>\n<li><a href=\"#answers\">answers</a></li>\n<li><a href=\"#papers\">the papers</a></li>\n{links}\
         <li><a href=\"#origins\">origins</a></li>\n</ul></nav>\n<main id=\"main\">\n{first}\
         <section id=\"answers\">\n<h2>Answers</h2>\n{answers}</section>\n\
         <section id=\"papers\">\n<h2>The papers beside these measurements</h2>\n{papers}</section>\n{sections}<section id=\"origins\">\n<h2>Where the numbers come from</h2>\n{origins}</section>\n</main>\n"
    );
    let (page, archive) = archive::moved(&pictures::compact(&without_paths(page, pages)));
    Ok(format!(
        "{page}<script type=\"text/plain\" id=\"archive\">{archive}</script>\n<script>\n/*\n{LIBRARY_LICENCE}*/\n{LIBRARY}</script>\n\
         <script>\n\"use strict\";\n{shared}{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}

/// Further drawings of an experiment are folded.
const OPEN_FIGURES: usize = 2;

/// Tables of more rows are folded.
const FOLDED_ROWS: usize = 8;

/// Whose answers are told first.
const FIRST: [&str; 3] = ["speed-accuracy", "soft-shadows", "candidate-search"];

/// Three sentences, a figure, and what an error is.
fn first_screen(pages: &[Page]) -> Result<String, ReportError> {
    let named = |name: &&str| pages.iter().find(|page| page.name() == **name);
    let mut told: Vec<&Page> = FIRST.iter().filter_map(named).collect();
    // Where none of these is there, whatever is.
    let others = pages.iter().filter(|page| !told.iter().any(|known| std::ptr::eq(*known, *page)));
    let others: Vec<&Page> = others.take(FIRST.len() - told.len()).collect();
    told.extend(others);
    let sentences = told.iter().filter_map(|page| page.content.answer.first());
    let sentences: String = sentences.map(|sentence| format!("<li>{}</li>\n", inline(sentence))).collect();
    let all = tradeoffs::applications(pages);
    let figure = if all.is_empty() {
        // Experiments that have no cost have a figure.
        let is_drawing = |part: &&Block| matches!(part, Block::Drawing(_));
        let drawn = told.iter().find_map(|page| Some((page, page.content.body.iter().find(is_drawing)?)));
        drawn.map(|(page, part)| block(&page.run, part)).transpose()?.unwrap_or_default()
    } else {
        tradeoffs::figure(&all)?
    };
    Ok(format!(
        "<section id=\"first\">\n<ul class=\"told\">\n{sentences}</ul>\n{figure}<p>An error is the mean distance between a \
         technique's shadow and the true one over the light-facing surfaces of all views, seen or not; the truth of hard \
         shadows is percentage-closer filtering, that of soft shadows are shadow rays to the whole light. Lower is better, and \
         further left is cheaper.</p>\n</section>\n"
    ))
}

/// Scenes are called by their files' names, not by where somebody keeps them.
fn without_paths(mut html: String, pages: &[Page]) -> String {
    let mut folders: Vec<String> = Vec::new();
    for page in pages {
        for scene in page.scenes().into_iter().filter(|scene| Path::new(scene).is_absolute()) {
            let folder = Path::new(&scene).parent().map(|folder| format!("{}/", folder.display()));
            folders.extend(folder.filter(|folder| folder.len() > 1));
        }
    }
    // Longer ones first, so that no folder cuts a piece off another.
    folders.sort_by_key(|folder| std::cmp::Reverse(folder.len()));
    folders.dedup();
    for folder in folders {
        html = html.replace(&escaped(&folder), "");
    }
    html
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
