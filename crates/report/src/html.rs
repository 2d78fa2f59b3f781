//! One self-contained page about several runs: no network, no build step, works from disk.

use crate::error::ReportError;
use crate::hover::escaped;
use crate::published::comparison;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evaluation::{
    Experiment, PictureSetting, RunDirectory, Scale, SearchExperiment, SearchRecord, SpeedAccuracyExperiment,
    SpeedAccuracyRecord, SpeedViewRecord,
};
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd};
use serde::Serialize;
use std::fmt::Write as _;

const STYLE: &str = include_str!("report.css");
const SCRIPT: &str = include_str!("report.js");

/// A point of the chart of error against cost.
#[derive(Serialize)]
struct Point {
    technique: String,
    format: String,
    size: u32,
    bits: usize,
    cost: f64,
    error: f64,
    front: bool,
}

/// The page; each run must have been reported before.
///
/// # Errors
/// [`ReportError::Records`] for a directory without page or with pictures that cannot be read.
pub fn html(runs: &[RunDirectory]) -> Result<String, ReportError> {
    let mut sections = String::new();
    let mut links = String::new();
    for run in runs {
        let name = title(run);
        let id: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(links, "<li><a href=\"#{id}\">{}</a></li>", escaped(&name));
        let _ = writeln!(sections, "<section id=\"{id}\">\n<h2>{}</h2>", escaped(&name));
        sections += &body(run, &explorers(run)?)?;
        sections += "</section>\n";
    }
    let papers = table(&comparison(runs)?);
    let answers = table(&answers(runs)?);
    let origins = table(&origins(runs)?);
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>msm: filterable shadow maps, measured</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>Filterable shadow maps, measured</h1>\n<nav aria-label=\"experiments\"><ul>\n<li><a href=\"#answers\">answers</a></li>\n<li><a href=\"#papers\">the papers</a></li>\n{links}\
         <li><a href=\"#origins\">origins</a></li>\n</ul></nav></header>\n<main>\n\
         <section id=\"answers\">\n<h2>Answers</h2>\n{answers}</section>\n\
         <section id=\"papers\">\n<h2>The papers beside these measurements</h2>\n{papers}</section>\n{sections}<section id=\"origins\">\n<h2>Where the numbers come from</h2>\n{origins}</section>\n</main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}

fn table(markdown: &str) -> String {
    let mut html = String::new();
    let events = with_scrolling_tables(Parser::new_ext(markdown, Options::ENABLE_TABLES));
    pulldown_cmark::html::push_html(&mut html, events.into_iter());
    html
}

/// A paragraph of a run's page that begins with this word, up to the end of its first sentence.
pub fn first_sentence(page: &str, word: &str) -> String {
    let start = page.find(&format!("**{word}.** ")).map_or(page.len(), |at| at + word.len() + 6);
    let paragraph = page[start..].split("\n\n").next().unwrap_or_default();
    let ends = [". ", ".\n", "? ", "?\n"].iter().filter_map(|end| paragraph.find(end));
    paragraph[..ends.min().map_or(paragraph.len(), |end| end + 1)].replace('\n', " ")
}

/// Each experiment's question with the sentence that answers it.
fn answers(runs: &[RunDirectory]) -> Result<String, ReportError> {
    let mut text = "| experiment | question | answer |\n|---|---|---|\n".to_owned();
    for run in runs {
        let (name, page) = (title(run), run.text("README.md")?);
        let cell = |word: &str| first_sentence(&page, word).replace('|', "\\|");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| [{name}](#{name}) | {} | {} |", cell("Question"), cell("Answer"));
    }
    Ok(text)
}

/// Commit, command and machine of each run.
fn origins(runs: &[RunDirectory]) -> Result<String, ReportError> {
    let mut text =
        "| experiment | command | commit | compiler | machine | started | seconds |\n|---|---|---|---|---|---|--:|\n".to_owned();
    for run in runs {
        let p = run.provenance()?;
        let changed = if p.build.dirty == "false" { "" } else { " and changes" };
        let _ = writeln!(
            text,
            "| {} | `{}` | {}{changed} | {} | {} threads on {}, {} | {} | {:.0} |",
            title(run),
            p.command,
            p.build.commit.get(..12).unwrap_or(&p.build.commit),
            p.build.rustc,
            p.threads,
            p.cpu,
            p.os,
            p.started,
            p.seconds
        );
    }
    Ok(text)
}

/// What a reader can play with: charts with filters, and pictures to compare.
fn explorers(run: &RunDirectory) -> Result<String, ReportError> {
    let mut html = String::new();
    if let Some(points) = points(run)? {
        let json = serde_json::to_string(&points).unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = writeln!(
            html,
            "<div class=\"explorer\" data-points=\"{}\"></div>\n<noscript>The chart below is the same without filters.</noscript>",
            escaped(&json)
        );
    }
    if let Some(candidates) = candidates(run)? {
        let json = serde_json::to_string(&candidates).unwrap_or_default();
        let _ = writeln!(html, "<div class=\"candidates\" data-candidates=\"{}\"></div>", escaped(&json));
    }
    html += &every_view(run)?;
    Ok(html)
}

/// The experiment's name: the directory above the run's.
fn title(run: &RunDirectory) -> String {
    let parent = run.path().parent().and_then(|path| path.file_name());
    parent.map(|name| name.to_string_lossy().into_owned()).unwrap_or_else(|| "run".to_owned())
}

/// The best of each technique, format and size over all fragments, for runs that have them.
fn points(run: &RunDirectory) -> Result<Option<Vec<Point>>, ReportError> {
    if !run.path().join("orders.csv").is_file() {
        return Ok(None);
    }
    let records: Vec<SpeedAccuracyRecord> = run.rows("records.csv")?;
    let best = records.into_iter().filter(|r| r.best && r.scene == "all");
    let point = |r: SpeedAccuracyRecord| Point {
        technique: r.technique,
        format: r.format,
        size: r.size,
        bits: r.bits_per_texel,
        cost: r.cost,
        error: r.l1_error,
        front: r.on_front == Some(true),
    };
    Ok(Some(best.map(point).collect()))
}

/// The experiment of a run that compares speed and accuracy.
fn speed_accuracy(run: &RunDirectory) -> Result<Option<SpeedAccuracyExperiment>, ReportError> {
    let experiment = Experiment::read(&run.path().join("experiment.toml"), Scale::Quick, None)?;
    Ok(experiment.settings().cloned())
}

/// A picture whose columns are compared.
#[derive(Serialize)]
struct Compared {
    name: String,
    source: String,
}

/// Two columns of a picture under a slider; the first of all where there are several.
fn comparer(pictures: &[PictureSetting], sources: &[Compared]) -> String {
    let Some(first) = pictures.first() else { return String::new() };
    let [width, height] = first.output;
    let names = serde_json::to_string(&first.techniques).unwrap_or_default();
    let sources = serde_json::to_string(sources).unwrap_or_default();
    format!(
        "<div class=\"comparer\" data-width=\"{width}\" data-height=\"{height}\" data-names=\"{}\" data-pictures=\"{}\"></div>\n",
        escaped(&names),
        escaped(&sources)
    )
}

/// The pictures of all views, for runs that have them.
fn every_view(run: &RunDirectory) -> Result<String, ReportError> {
    let Some(experiment) = speed_accuracy(run)?.filter(|speed| speed.every_view.is_some()) else {
        return Ok(String::new());
    };
    let views: Vec<SpeedViewRecord> = run.rows("views.csv")?;
    let views = views.iter().map(|view| (view.scene.as_str(), view.view.as_str()));
    let pictures = experiment.pictures_of_views(views);
    let source = |picture: &PictureSetting| {
        let name = format!("{}, {}", picture.scene, picture.view);
        Ok(Compared { name, source: data(run, &format!("{}.png", picture.id))? })
    };
    let sources = pictures.iter().map(source).collect::<Result<Vec<_>, ReportError>>()?;
    Ok(comparer(&pictures, &sources))
}

/// All candidates of a search in little space.
#[derive(Serialize)]
struct Candidates {
    functions: Vec<String>,
    sizes: Vec<CandidatesOfSize>,
}

/// Best first: for each candidate its functions' places, a byte each, and the error in units of 1e-7, four bytes with the
/// least first; in base 64.
#[derive(Serialize)]
struct CandidatesOfSize {
    m: usize,
    data: String,
}

fn candidates(run: &RunDirectory) -> Result<Option<Candidates>, ReportError> {
    if !run.path().join("stages.csv").is_file() {
        return Ok(None);
    }
    let experiment = Experiment::read(&run.path().join("experiment.toml"), Scale::Quick, None)?;
    let mut functions: Vec<String> = match experiment.settings::<SearchExperiment>() {
        Some(search) => search.functions()?.iter().map(|f| f.name().to_owned()).collect(),
        None => Vec::new(),
    };
    let mut sizes: Vec<(usize, Vec<u8>)> = Vec::new();
    for record in run.rows::<SearchRecord>("records.csv")?.iter().filter(|r| r.fragments > 0) {
        let place = sizes.iter().position(|(m, _)| *m == record.m).unwrap_or_else(|| {
            sizes.push((record.m, Vec::new()));
            sizes.len() - 1
        });
        for function in record.basis.split(", ") {
            let index = functions.iter().position(|known| known == function).unwrap_or_else(|| {
                functions.push(function.to_owned());
                functions.len() - 1
            });
            sizes[place].1.push(index as u8);
        }
        sizes[place].1.extend(((record.l1_error * 1e7).round() as u32).to_le_bytes());
    }
    // A byte cannot name more of them.
    if functions.len() > 256 {
        return Ok(None);
    }
    let encode = |(m, bytes): (usize, Vec<u8>)| CandidatesOfSize { m, data: STANDARD.encode(bytes) };
    let sizes = sizes.into_iter().map(encode).collect();
    Ok(Some(Candidates { functions, sizes }))
}

/// A recorded PNG as an address.
fn data(run: &RunDirectory, file: &str) -> Result<String, ReportError> {
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(run.bytes(file)?)))
}

/// The run's page with its pictures inside and `explorers` below the answer.
fn body(run: &RunDirectory, explorers: &str) -> Result<String, ReportError> {
    let text = run.text("README.md")?;
    let answer = text.find("**Answer.**").unwrap_or_default();
    let end = text[answer..].find("\n\n").map_or(text.len(), |end| answer + end);
    Ok(rendered(run, &text[..end])? + explorers + &rendered(run, &text[end..])?)
}

fn rendered(run: &RunDirectory, text: &str) -> Result<String, ReportError> {
    let pictures = speed_accuracy(run)?.map(|speed| speed.picture).unwrap_or_default();
    let mut events = Vec::new();
    let mut picture: Option<(String, String)> = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Image { dest_url, .. }) => {
                picture = Some((dest_url.to_string(), String::new()))
            }
            Event::End(TagEnd::Image) => {
                if let Some((file, title)) = picture.take() {
                    let mut html = figure(run, &file, &title)?;
                    let compared = pictures.iter().find(|picture| format!("{}.png", picture.id) == file);
                    html += &compared
                        .map(|picture| comparer(std::slice::from_ref(picture), &[]))
                        .unwrap_or_default();
                    events.push(Event::InlineHtml(CowStr::from(html)));
                }
            }
            Event::Text(words) | Event::Code(words) if picture.is_some() => {
                if let Some((_, title)) = &mut picture {
                    title.push_str(&words);
                }
            }
            // The page's own comment about how it was made.
            Event::Html(_) => {}
            _ => events.push(event),
        }
    }
    let mut html = String::new();
    pulldown_cmark::html::push_html(&mut html, with_scrolling_tables(events).into_iter());
    Ok(html)
}

/// Tables in boxes that scroll: wide ones must not widen the page.
fn with_scrolling_tables<'a>(events: impl IntoIterator<Item = Event<'a>>) -> Vec<Event<'a>> {
    let mut all = Vec::new();
    for event in events {
        match event {
            Event::Start(Tag::Table(_)) => {
                all.push(Event::Html(CowStr::from("<div class=\"table\" tabindex=\"0\">")));
                all.push(event);
            }
            Event::End(TagEnd::Table) => {
                all.push(event);
                all.push(Event::Html(CowStr::from("</div>")));
            }
            _ => all.push(event),
        }
    }
    all
}

/// SVG as it is, other pictures as data.
fn figure(run: &RunDirectory, file: &str, title: &str) -> Result<String, ReportError> {
    let label = escaped(title);
    let picture = if file.ends_with(".svg") {
        let svg = run.text(file)?;
        let start = svg.find("<svg").unwrap_or_default();
        svg[start..].replacen("<svg", &format!("<svg role=\"img\" aria-label=\"{label}\""), 1)
    } else {
        format!("<img alt=\"{label}\" src=\"{}\">", data(run, file)?)
    };
    Ok(format!(
        "<span class=\"figure\" tabindex=\"0\">{picture}<span class=\"caption\">{label}</span></span>"
    ))
}
