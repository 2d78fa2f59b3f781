//! One self-contained page about several runs: no network, no build step, works from disk.

use crate::error::ReportError;
use crate::published::comparison;
use base64::Engine;
use evaluation::{Experiment, Kind, PictureSetting, RunDirectory, Scale, SpeedAccuracyRecord};
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
        if let Some(points) = points(run)? {
            let json = serde_json::to_string(&points).unwrap_or_default();
            let _ = writeln!(
                sections,
                "<div class=\"explorer\" data-points=\"{}\"></div>\n<noscript>The chart below is the same without filters.</noscript>",
                escaped(&json)
            );
        }
        sections += &body(run)?;
        sections += "</section>\n";
    }
    let mut papers = String::new();
    pulldown_cmark::html::push_html(
        &mut papers,
        with_scrolling_tables(Parser::new_ext(&comparison(runs)?, Options::ENABLE_TABLES)).into_iter(),
    );
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>msm: filterable shadow maps, measured</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>Filterable shadow maps, measured</h1>\n<nav aria-label=\"experiments\"><ul>\n<li><a href=\"#papers\">the papers</a></li>\n{links}</ul></nav></header>\n<main>\n\
         <section id=\"papers\">\n<h2>The papers beside these measurements</h2>\n{papers}</section>\n{sections}</main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    ))
}

/// The experiment's name: the directory above the run's.
fn title(run: &RunDirectory) -> String {
    let parent = run.path().parent().and_then(|path| path.file_name());
    parent.map(|name| name.to_string_lossy().into_owned()).unwrap_or_else(|| "run".to_owned())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
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

/// Pictures of techniques side by side, for runs that have them.
fn side_by_side(run: &RunDirectory) -> Result<Vec<PictureSetting>, ReportError> {
    let experiment = Experiment::read(&run.path().join("experiment.toml"), Scale::Quick, None)?;
    Ok(match experiment.kind {
        Kind::SpeedAccuracy(speed) => speed.picture,
        _ => Vec::new(),
    })
}

/// Two columns of a picture under a slider.
fn comparer(picture: &PictureSetting) -> String {
    let [width, height] = picture.output;
    let names = serde_json::to_string(&picture.techniques).unwrap_or_default();
    format!(
        "<div class=\"comparer\" data-width=\"{width}\" data-height=\"{height}\" data-names=\"{}\"></div>\n",
        escaped(&names)
    )
}

/// The run's page with its pictures inside.
fn body(run: &RunDirectory) -> Result<String, ReportError> {
    let pictures = side_by_side(run)?;
    let text = run.text("README.md")?;
    let mut events = Vec::new();
    let mut picture: Option<(String, String)> = None;
    for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Image { dest_url, .. }) => {
                picture = Some((dest_url.to_string(), String::new()))
            }
            Event::End(TagEnd::Image) => {
                if let Some((file, title)) = picture.take() {
                    let mut html = figure(run, &file, &title)?;
                    let compared = pictures.iter().find(|picture| format!("{}.png", picture.id) == file);
                    html += &compared.map(comparer).unwrap_or_default();
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
        let bytes = run.bytes(file)?;
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        format!("<img alt=\"{label}\" src=\"data:image/png;base64,{data}\">")
    };
    Ok(format!(
        "<span class=\"figure\" tabindex=\"0\">{picture}<span class=\"caption\">{label}</span></span>"
    ))
}
