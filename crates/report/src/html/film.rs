//! Frames that play: a picture of all of them, of which the page shows one.

use crate::drawing::escaped;
use crate::page::{Film, json};

/// The picture with its caption; without a script its first frame stands still. `source` is its address.
pub(crate) fn html(film: &Film, source: &str) -> String {
    let [width, height] = film.size;
    let title = escaped(&film.title);
    format!(
        "<figure class=\"film\" data-frames=\"{}\"><img alt=\"{} frames that follow each other\" src=\"{source}\" width=\"{width}\" height=\"{height}\" \
         style=\"aspect-ratio: {width} / {height}\"><figcaption>{title}</figcaption></figure>\n",
        escaped(&json(&film.frames)),
        film.frames.len()
    )
}
