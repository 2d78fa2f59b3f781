//! Colours that the colour-blind can tell apart.

use plotters::style::RGBColor;

/// Okabe and Ito's palette.
pub(crate) const BLACK: RGBColor = RGBColor(0, 0, 0);
pub(crate) const VERMILLION: RGBColor = RGBColor(213, 94, 0);
pub(crate) const SKY_BLUE: RGBColor = RGBColor(86, 180, 233);
pub(crate) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(crate) const PURPLE: RGBColor = RGBColor(204, 121, 167);
pub(crate) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(crate) const ORANGE: RGBColor = RGBColor(230, 159, 0);

/// Colours of curves in the order of their techniques.
pub(crate) const CURVE_COLOURS: [RGBColor; 6] = [VERMILLION, SKY_BLUE, GREEN, PURPLE, BLUE, ORANGE];

pub(crate) const GRID: RGBColor = RGBColor(225, 225, 225);
/// Ticks and axes.
pub(crate) const RUG: RGBColor = RGBColor(90, 90, 90);

/// As CSS.
pub(crate) fn css(colour: RGBColor) -> String {
    let RGBColor(r, g, b) = colour;
    format!("#{r:02x}{g:02x}{b:02x}")
}
