//! What only the script needs - values under the pointer, all candidates of a search - in one deflated block: a fifth of the
//! bytes.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write as _;

/// Lines of a drawing that are shapes without a look.
const SHAPES: [&str; 2] = ["<rect class=\"spot\"", "<rect class=\"grid\""];
/// The attribute of explorers with much data.
const DATA: &str = " data-candidates=\"";

#[derive(Default, Serialize)]
struct Archive<'a> {
    /// Shapes of each drawing that has some, in the order of the page.
    shapes: Vec<String>,
    /// The data of each explorer, in the same order, as it stood in an attribute.
    candidates: Vec<&'a str>,
}

/// The page without these, and the block.
pub(super) fn moved(page: &str) -> (String, String) {
    let mut archive = Archive::default();
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some(start) = rest.find(DATA) {
        let (before, after) = rest.split_at(start + DATA.len());
        let end = after.find('"').unwrap_or(after.len());
        archive.candidates.push(&after[..end]);
        out += before;
        rest = &after[end..];
    }
    out += rest;
    let mut page = String::with_capacity(out.len());
    let mut shapes = String::new();
    for line in out.split_inclusive('\n') {
        if SHAPES.iter().any(|shape| line.starts_with(shape)) {
            let (shape, after) = match line.find("</svg>") {
                Some(end) => line.split_at(end),
                None => (line, ""),
            };
            shapes += shape.trim_end();
            page += after;
        } else {
            page += line;
        }
        if line.contains("</svg>") && !shapes.is_empty() {
            archive.shapes.push(std::mem::take(&mut shapes));
            // The script finds its drawings by this.
            if let Some(start) = page.rfind("<svg") {
                page.insert_str(start + "<svg".len(), " data-shapes");
            }
        }
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    // Writing to memory cannot fail; without its block a page shows the same.
    let written = encoder.write_all(crate::page::json(&archive).as_bytes()).and_then(|()| encoder.finish());
    (page, STANDARD.encode(written.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    #[test]
    fn shapes_and_data_leave_the_page_and_nothing_else_does() {
        let page = "<p>\n<svg role=\"img\">\n<path d=\"M0 0\"/>\n<rect class=\"spot\" x=\"1\"><title>a</title></rect>\n\
             <rect class=\"grid\" x=\"2\"></rect>\n</svg>\n<svg>\n</svg>\n<div data-candidates=\"{&quot;m&quot;}\"></div>\n";
        let (left, block) = moved(page);
        assert_eq!(
            left,
            "<p>\n<svg data-shapes role=\"img\">\n<path d=\"M0 0\"/>\n</svg>\n<svg>\n</svg>\n<div data-candidates=\"\"></div>\n"
        );
        let mut text = String::new();
        let bytes = STANDARD.decode(block).unwrap();
        flate2::read::ZlibDecoder::new(&bytes[..]).read_to_string(&mut text).unwrap();
        let archive: serde_json::Value = serde_json::from_str(&text).unwrap();
        let shapes =
            "<rect class=\"spot\" x=\"1\"><title>a</title></rect><rect class=\"grid\" x=\"2\"></rect>";
        assert_eq!(archive["shapes"], serde_json::json!([shapes]));
        assert_eq!(archive["candidates"], serde_json::json!(["{&quot;m&quot;}"]));
    }
}
