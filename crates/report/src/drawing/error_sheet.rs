//! Recorded error maps side by side, coloured and labelled.

use super::hover::escaped;
use crate::error::ReportError;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use evaluation::EvaluationError;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// How a grey of 128 + 127 (G - F) is shown.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum ErrorColours {
    /// |G - F| from white over orange to black.
    Magnitude,
    /// G - F from blue (light leaks) over white to red (shadow where none belongs).
    Signed,
}

/// Errors of this size and above have the last colour: differences between techniques are small ones.
const FULL: f64 = 0.5;

impl ErrorColours {
    fn colour(self, grey: u8) -> [u8; 3] {
        let error = ((f64::from(grey) - 128.0) / 127.0 / FULL).clamp(-1.0, 1.0);
        let corners: &[[f64; 3]] = match (self, error < 0.0) {
            (Self::Magnitude, _) => {
                &[[255.0, 255.0, 255.0], [240.0, 180.0, 60.0], [190.0, 60.0, 20.0], [30.0, 0.0, 20.0]]
            }
            (Self::Signed, true) => &[[255.0, 255.0, 255.0], [86.0, 160.0, 220.0], [0.0, 50.0, 110.0]],
            (Self::Signed, false) => &[[255.0, 255.0, 255.0], [225.0, 110.0, 60.0], [110.0, 20.0, 0.0]],
        };
        let position = error.abs() * (corners.len() - 1) as f64;
        let lower = (position as usize).min(corners.len() - 2);
        let fraction = position - lower as f64;
        [0, 1, 2].map(|k| {
            (corners[lower][k] + fraction * (corners[lower + 1][k] - corners[lower][k])).round() as u8
        })
    }
}

const TILE: u32 = 180;
const GAP: u32 = 12;
const LABEL: u32 = 20;
const COLUMNS: u32 = 4;

/// The sheet as an SVG document: one tile a technique, and a scale beside two lines on what a pixel shows.
pub(crate) fn error_sheet(
    tiles: &[(String, PathBuf)],
    title: &str,
    colours: ErrorColours,
    pixel: [&str; 2],
) -> Result<String, ReportError> {
    if tiles.is_empty() {
        return Err(ReportError::Empty { figure: title.to_owned() });
    }
    let rows = (tiles.len() as u32).div_ceil(COLUMNS);
    let (width, top) = (COLUMNS * (TILE + GAP) + GAP, 34);
    let scale = top + rows * (TILE + LABEL + GAP);
    let height = scale + 44;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
         <text x=\"{}\" y=\"22\" font-size=\"15\" text-anchor=\"middle\">{}</text>\n",
        width / 2,
        escaped(title)
    );
    for (i, (name, path)) in tiles.iter().enumerate() {
        let (column, row) = (i as u32 % COLUMNS, i as u32 / COLUMNS);
        let (x, y) = (GAP + column * (TILE + GAP), top + row * (TILE + LABEL + GAP));
        let png = STANDARD.encode(coloured(path, colours)?);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "<text x=\"{x}\" y=\"{}\">{}</text>\n<image x=\"{x}\" y=\"{}\" width=\"{TILE}\" height=\"{TILE}\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{png}\"/>\n\
             <rect x=\"{x}\" y=\"{}\" width=\"{TILE}\" height=\"{TILE}\" fill=\"none\" stroke=\"#5a5a5a\"/>",
            y + 14,
            escaped(name),
            y + LABEL,
            y + LABEL
        );
    }
    text.push_str(&bar(colours, scale, pixel));
    text.push_str("</svg>\n");
    Ok(text)
}

fn bar(colours: ErrorColours, y: u32, [above, below]: [&str; 2]) -> String {
    let (from, to) = if colours == ErrorColours::Signed { (-FULL, FULL) } else { (0.0, FULL) };
    let (steps, step) = (64, 5);
    let mut text = String::new();
    for i in 0..steps {
        let error = from + (to - from) * (f64::from(i) + 0.5) / f64::from(steps);
        let [r, g, b] = colours.colour((128.0 + 127.0 * error).round() as u8);
        // Writing to a string cannot fail. Colours of values are not those of paper and ink, which a dark page changes.
        let _ = writeln!(
            text,
            "<rect x=\"{}\" y=\"{y}\" width=\"{step}\" height=\"12\" fill=\"rgb({r} {g} {b})\"/>",
            GAP as i32 + i * step
        );
    }
    let end = GAP as i32 + steps * step;
    let (left, right) = match colours {
        ErrorColours::Signed => ("-0.5 and less: light leaks", "0.5 and more: too dark"),
        ErrorColours::Magnitude => ("0", "0.5 and more"),
    };
    let _ = writeln!(
        text,
        "<text x=\"{GAP}\" y=\"{0}\">{left}</text>\n<text x=\"{end}\" y=\"{0}\" text-anchor=\"end\">{right}</text>\n\
         <text x=\"{1}\" y=\"{2}\">{above}</text>\n\
         <text x=\"{1}\" y=\"{0}\">{below}</text>",
        y + 28,
        end + 16,
        y + 11
    );
    text
}

/// A recorded map with its greys replaced by colours, as a PNG with a palette.
fn coloured(path: &Path, colours: ErrorColours) -> Result<Vec<u8>, ReportError> {
    let input =
        |reason: String| ReportError::Records(EvaluationError::Input { path: path.to_owned(), reason });
    let bytes = std::fs::read(path).map_err(|error| input(error.to_string()))?;
    let image = image::load_from_memory(&bytes).map_err(|error| input(error.to_string()))?.into_luma8();
    let palette: Vec<u8> = (0..=255).flat_map(|grey| colours.colour(grey)).collect();
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, image.width(), image.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().map_err(|error| input(error.to_string()))?;
    writer.write_image_data(image.as_raw()).map_err(|error| input(error.to_string()))?;
    writer.finish().map_err(|error| input(error.to_string()))?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_is_white_and_signs_differ() {
        for colours in [ErrorColours::Magnitude, ErrorColours::Signed] {
            assert_eq!(colours.colour(128), [255; 3]);
        }
        let [r, _, b] = ErrorColours::Signed.colour(0);
        assert!(b > r);
        let [r, _, b] = ErrorColours::Signed.colour(255);
        assert!(r > b);
        assert_eq!(ErrorColours::Magnitude.colour(1), ErrorColours::Magnitude.colour(255));
    }
}
