//! Values that appear when a reader points at a figure: invisible shapes over the drawing, with titles that browsers show.
//!
//! Shapes are collected for the figure that the thread draws at the moment, in units of the finer canvas, and written by
//! [`svg`](super::canvas::svg) after everything else, so that they lie on top.

use std::cell::RefCell;
use std::fmt::Write as _;

thread_local! {
    static SHAPES: RefCell<String> = const { RefCell::new(String::new()) };
}

/// A corner of a shape on the whole canvas.
type Corner = (i32, i32);

fn rectangle(attributes: &str, [(left, top), (right, bottom)]: [Corner; 2], inside: &str) {
    let (x, y) = (left.min(right), top.min(bottom));
    let (width, height) = ((right - left).abs(), (bottom - top).abs());
    SHAPES.with_borrow_mut(|shapes| {
        // Writing to a string cannot fail.
        let _ = writeln!(
            shapes,
            "<rect {attributes} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill-opacity=\"0\">{inside}</rect>"
        );
    });
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A rectangle whose value is `label`.
pub(crate) fn spot(corners: [Corner; 2], label: &str) {
    rectangle("class=\"spot\"", corners, &format!("<title>{}</title>", escaped(label)));
}

/// A square around a point.
pub(crate) fn around((x, y): Corner, radius: i32, label: &str) {
    spot([(x - radius, y - radius), (x + radius, y + radius)], label);
}

/// A grid of cells whose values are letters, row by row from the top; the page's script says what they mean. Titles for
/// thousands of cells would be longer than the figure.
pub(crate) fn grid(corners: [Corner; 2], title: &str, axes: [(&str, f64, f64); 2], cells: &str) {
    let [x, y] = axes.map(|(name, from, to)| escaped(&format!("[\"{name}\", {from:e}, {to:e}]")));
    let attributes = format!(
        "class=\"grid\" data-title=\"{}\" data-x=\"{x}\" data-y=\"{y}\" data-cells=\"{cells}\"",
        escaped(title)
    );
    rectangle(&attributes, corners, "");
}

/// What was collected since the last call.
pub(crate) fn take() -> String {
    SHAPES.take()
}
