//! Digits for the legends of pictures.

use image::{Rgb, RgbImage};

/// Pixels per dot of a glyph.
const DOT: u32 = 2;
/// Width of a digit in pixels.
pub(crate) const GLYPH_WIDTH: u32 = 3 * DOT;
/// Height of a digit in pixels.
pub(crate) const GLYPH_HEIGHT: u32 = 5 * DOT;

/// Rows of the digits 0 to 9 from top to bottom, three dots each, leftmost in the highest bit.
const DIGITS: [[u8; 5]; 10] = [
    [0b111, 0b101, 0b101, 0b101, 0b111],
    [0b010, 0b110, 0b010, 0b010, 0b111],
    [0b111, 0b001, 0b111, 0b100, 0b111],
    [0b111, 0b001, 0b011, 0b001, 0b111],
    [0b101, 0b101, 0b111, 0b001, 0b001],
    [0b111, 0b100, 0b111, 0b001, 0b111],
    [0b111, 0b100, 0b111, 0b101, 0b111],
    [0b111, 0b001, 0b010, 0b010, 0b010],
    [0b111, 0b101, 0b111, 0b101, 0b111],
    [0b111, 0b101, 0b111, 0b001, 0b111],
];

/// Draws a number with its upper left corner at (x, y); what lies outside of the picture is cut off.
pub(crate) fn draw_number(picture: &mut RgbImage, x: u32, y: u32, number: u32, color: Rgb<u8>) {
    for (place, digit) in number.to_string().bytes().enumerate() {
        let glyph = DIGITS[usize::from(digit - b'0')];
        let left = x + place as u32 * (GLYPH_WIDTH + 2);
        for (dx, dy) in (0..GLYPH_HEIGHT).flat_map(|dy| (0..GLYPH_WIDTH).map(move |dx| (dx, dy))) {
            let dot = glyph[(dy / DOT) as usize] >> (2 - dx / DOT) & 1;
            if dot == 1 && left + dx < picture.width() && y + dy < picture.height() {
                picture.put_pixel(left + dx, y + dy, color);
            }
        }
    }
}
