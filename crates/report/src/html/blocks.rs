//! Parts of a page as HTML.

use super::compact::compact;
use crate::drawing::escaped;
use crate::error::ReportError;
use crate::html::film;
use crate::page::{Block, Drawing, Explorer, PictureColumns, RecordedPicture, Span, Table, Text, json};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evaluation::{PICTURE_GAP, RunDirectory};
use pulldown_cmark::{Event, Parser, Tag, TagEnd};
use serde::Serialize;
use std::fmt::Write as _;

pub(crate) fn block(run: &RunDirectory, block: &Block) -> Result<String, ReportError> {
    Ok(match block {
        // The page has the first level, experiments the second.
        Block::Heading(level, text) => {
            let level = (level + 1).max(3);
            format!("<h{level}>{}</h{level}>\n", escaped(text))
        }
        Block::Paragraph(text) => format!("<p>{}</p>\n", inline(text)),
        Block::Commands(lines) => {
            format!("<pre><code class=\"language-sh\">{}\n</code></pre>\n", escaped(lines))
        }
        Block::Table(of) => table(of),
        Block::Drawing(drawing) => framed(&svg(drawing), &drawing.title),
        Block::Picture(picture) => {
            // The caption has the title: who cannot see the picture is told what stands in it.
            let techniques = picture.columns.techniques.join(", ");
            let label = escaped(&format!("side by side: the truth, {techniques}"));
            let image = format!("<img alt=\"{label}\" src=\"{}\">", data(run, &picture.id)?);
            framed(&image, &picture.title) + &comparer(&picture.columns, &[])
        }
    })
}

pub(crate) fn inline(text: &Text) -> String {
    let span = |span: &Span| match span {
        Span::Plain(text) => escaped(text),
        Span::Code(text) => format!("<code>{}</code>", escaped(text)),
        Span::Emphasis(text) => format!("<em>{}</em>", escaped(text)),
        Span::Strong(text) => format!("<strong>{}</strong>", escaped(text)),
        // The page stands alone: files beside a run are not beside the page.
        Span::Link(text, to) if !leads_somewhere(to) => escaped(text),
        Span::Link(text, to) => format!("<a href=\"{}\">{}</a>", escaped(to), escaped(text)),
        Span::Prose(markdown) => {
            let mut html = String::new();
            let mut is_dead = false;
            let kept = Parser::new(markdown).filter(|event| match event {
                Event::Start(Tag::Link { dest_url, .. }) => {
                    is_dead = !leads_somewhere(dest_url);
                    !is_dead
                }
                Event::End(TagEnd::Link) => !std::mem::take(&mut is_dead),
                _ => true,
            });
            pulldown_cmark::html::push_html(&mut html, kept);
            let html = html.trim_end();
            html.strip_prefix("<p>").and_then(|html| html.strip_suffix("</p>")).unwrap_or(html).to_owned()
        }
    };
    text.0.iter().map(span).collect()
}

/// Whether a link of the page works wherever the page lies.
fn leads_somewhere(to: &str) -> bool {
    to.starts_with('#') || to.starts_with("https://") || to.starts_with("http://")
}

/// A table behind its heading, to be opened by those who want the numbers.
pub(crate) fn folded(of: &Table, heading: &str) -> String {
    let rows = of.rows.len();
    format!(
        "<details><summary>{}: {rows} rows</summary>\n{}</details>\n",
        if heading.is_empty() { "Table".to_owned() } else { escaped(heading) },
        table(of)
    )
}

/// A figure behind its title.
pub(crate) fn folded_figure(figure: &str, title: &str) -> String {
    format!("<details><summary>{}</summary>\n{figure}</details>\n", escaped(title))
}

/// In a box that scrolls: wide tables must not widen the page.
pub(crate) fn table(table: &Table) -> String {
    let side = |i: usize| match table.columns.get(i) {
        Some(column) if column.right => " class=r",
        _ => "",
    };
    let mut html = "<div class=\"table\" tabindex=\"0\"><table><thead><tr>".to_owned();
    // Writing to a string cannot fail.
    for (i, column) in table.columns.iter().enumerate() {
        let _ = write!(html, "<th{}>{}</th>", side(i), inline(&column.name));
    }
    html += "</tr></thead><tbody>\n";
    for row in &table.rows {
        html += "<tr>";
        for (i, cell) in row.iter().enumerate() {
            // A cell ends where the next one begins, as HTML has it: thousands of end tags say nothing.
            let _ = write!(html, "<td{}>{}", side(i), inline(cell));
        }
        html.push('\n');
    }
    html + "</tbody></table></div>\n"
}

pub(crate) fn explorer(run: &RunDirectory, explorer: &Explorer) -> Result<String, ReportError> {
    Ok(match explorer {
        Explorer::Chart { class, data } => {
            format!("<div class=\"{class}\" data-{class}=\"{}\"></div>\n", escaped(data))
        }
        Explorer::Pictures(columns, pictures) => {
            let source = |picture: &RecordedPicture| {
                Ok(Source { name: picture.title.clone(), source: data(run, &picture.id)? })
            };
            comparer(columns, &pictures.iter().map(source).collect::<Result<Vec<_>, ReportError>>()?)
        }
        Explorer::Film(film) => film::html(film, &data(run, &film.id)?),
    })
}

/// A picture whose columns are compared.
#[derive(Serialize)]
struct Source {
    name: String,
    source: String,
}

/// Two columns of a picture under a slider: of the one before it, or of `sources`.
fn comparer(columns: &PictureColumns, sources: &[Source]) -> String {
    let [width, height] = columns.size;
    format!(
        "<div class=\"comparer\" data-width=\"{width}\" data-height=\"{height}\" data-gap=\"{PICTURE_GAP}\" data-names=\"{}\" data-pictures=\"{}\"></div>\n",
        escaped(&json(&columns.techniques)),
        escaped(&json(sources))
    )
}

/// A recorded PNG as an address.
fn data(run: &RunDirectory, id: &str) -> Result<String, ReportError> {
    let bytes = run.bytes(&format!("{id}.png"))?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

fn svg(drawing: &Drawing) -> String {
    let svg = compact(&drawing.svg[drawing.svg.find("<svg").unwrap_or_default()..]);
    let label = escaped(&drawing.title);
    svg.replacen("<svg", &format!("<svg role=\"img\" aria-label=\"{label}\""), 1)
}

fn framed(picture: &str, title: &str) -> String {
    let caption = escaped(title);
    format!(
        "<p><span class=\"figure\" tabindex=\"0\">{picture}<span class=\"caption\">{caption}</span></span></p>\n"
    )
}
