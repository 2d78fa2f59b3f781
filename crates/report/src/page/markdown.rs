//! A page as Markdown.

use crate::page::{Block, Page, Span, Table, Text};

/// The page of a run, README.md of its directory.
pub(crate) fn page(page: &Page) -> String {
    let mut text = "<!-- Written by `msm report` from the files beside it. -->\n".to_owned();
    let (opening, origin) = (page.opening(), page.origin());
    let blocks = opening.iter().chain(&page.content.body).chain(&origin).map(block);
    text += &blocks.collect::<Vec<_>>().join("\n");
    text
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(level, text) => format!("{} {text}\n", "#".repeat(usize::from(*level))),
        Block::Paragraph(text) => inline(text) + "\n",
        Block::Commands(lines) => format!("```sh\n{lines}\n```\n"),
        Block::Table(of) => table(of),
        Block::Drawing(drawing) => format!("![{}]({}.svg)\n", drawing.title, drawing.id),
        Block::Picture(picture) => format!("![{}]({}.png)\n", picture.title, picture.id),
    }
}

pub(crate) fn table(table: &Table) -> String {
    let rules = table.columns.iter().map(|column| if column.right { "--:|" } else { "---|" });
    let mut text = format!("{}|{}\n", row(table.columns.iter().map(|c| &c.name)), rules.collect::<String>());
    text.extend(table.rows.iter().map(row));
    text
}

fn row<'a>(cells: impl IntoIterator<Item = &'a Text>) -> String {
    let mut line = "|".to_owned();
    for cell in cells {
        // Neither may a cell end early nor a row.
        let words = inline(cell).replace('|', "\\|").replace('\n', " ");
        line += &if cell.0.is_empty() { " |".to_owned() } else { format!(" {words} |") };
    }
    line + "\n"
}

pub(crate) fn inline(text: &Text) -> String {
    let span = |span: &Span| match span {
        Span::Plain(text) | Span::Prose(text) => text.clone(),
        Span::Code(text) => format!("`{text}`"),
        Span::Emphasis(text) => format!("*{text}*"),
        Span::Strong(text) => format!("**{text}**"),
        Span::Link(text, to) => format!("[{text}]({to})"),
    };
    text.0.iter().map(span).collect()
}
