//! Grids of coloured cells as one small picture in a figure: a rectangle a cell would be most of the page.
//!
//! The drawing library writes no pictures into SVG without a second image library: a rectangle stands in a picture's place
//! until [`svg`](super::canvas::svg) writes the figure.

use super::canvas::{Area, Drawn};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::{ImageFormat, Rgba, RgbaImage};
use plotters::prelude::{RGBColor, Rectangle};
use plotters::style::Color;
use std::cell::RefCell;
use std::io::Cursor;

/// A colour that nothing else has.
const PLACE: RGBColor = RGBColor(1, 2, 3);
/// How the rectangle in a picture's place begins and ends.
const BEFORE: &str = "<rect";
const AFTER: &str = " opacity=\"1\" fill=\"#010203\" stroke=\"none\"/>";

thread_local! {
    /// Addresses of the pictures of the figure that the thread draws at the moment.
    static PICTURES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Draws cells, row by row from the top, from corner to corner; cells without a colour show what is below.
pub(crate) fn texels(
    area: &Area<'_>,
    corners: [(i32, i32); 2],
    [across, down]: [u32; 2],
    colour: impl Fn(u32, u32) -> Option<RGBColor>,
) -> Drawn {
    let cell = |x, y| colour(x, y).map_or(Rgba([0; 4]), |RGBColor(r, g, b)| Rgba([r, g, b, 255]));
    let mut bytes = Vec::new();
    RgbaImage::from_fn(across, down, cell).write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)?;
    PICTURES.with_borrow_mut(|all| all.push(format!("data:image/png;base64,{}", STANDARD.encode(bytes))));
    area.draw(&Rectangle::new(corners, PLACE.filled()))?;
    Ok(())
}

/// The figure with its pictures in their places.
pub(super) fn placed(mut figure: String) -> String {
    for address in PICTURES.take() {
        let Some(end) = figure.find(AFTER) else { break };
        let picture =
            format!(" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"{address}\"/>");
        figure.replace_range(end..end + AFTER.len(), &picture);
        if let Some(begin) = figure[..end].rfind(BEFORE) {
            figure.replace_range(begin..begin + BEFORE.len(), "<image");
        }
    }
    figure
}

/// Forgets what a drawing that failed may have left.
pub(super) fn forget() {
    PICTURES.take();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::palette::BLUE;
    use crate::drawing::svg;

    #[test]
    fn pictures_stand_in_their_places_in_the_order_of_drawing() {
        let figure = svg("grid", (40, 40), |root| {
            texels(root, [(0, 0), (16, 8)], [2, 1], |x, _| (x == 0).then_some(BLUE))?;
            root.draw(&Rectangle::new([(1, 1), (2, 2)], BLUE.filled()))?;
            texels(root, [(20, 20), (24, 24)], [1, 1], |_, _| Some(BLUE))
        });
        let figure = figure.unwrap();
        let first = figure.find("<image x=\"0\" y=\"0\" width=\"16\" height=\"8\"").unwrap();
        let between = figure.find("x=\"1\" y=\"1\"").unwrap();
        let second = figure.find("<image x=\"20\" y=\"20\"").unwrap();
        assert!(first < between && between < second, "{figure}");
        assert!(!figure.contains("#010203"), "{figure}");
        let address = figure[first..].split("base64,").nth(1).unwrap().split('"').next().unwrap();
        let picture = image::load_from_memory(&STANDARD.decode(address).unwrap()).unwrap().to_rgba8();
        assert_eq!(picture.dimensions(), (2, 1));
        assert_eq!(picture.get_pixel(0, 0).0, [BLUE.0, BLUE.1, BLUE.2, 255]);
        assert_eq!(picture.get_pixel(1, 0).0[3], 0);
    }
}
