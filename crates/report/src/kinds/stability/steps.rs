//! How errors of a heat map are shown, as colours in the figure and as words under the pointer.

use evaluation::CellRecord;
use plotters::style::RGBColor;
use std::collections::BTreeMap;

/// Powers of ten that have a colour: errors below 1e-8 have the first one, above 1e-1 the last.
pub(crate) const LEAST: i32 = -8;

/// Dark for small, bright for large errors, in equal steps of lightness (after the map `cividis`).
pub(crate) const STEP_COLOURS: [RGBColor; 9] = [
    RGBColor(0, 32, 77),
    RGBColor(30, 54, 108),
    RGBColor(67, 78, 108),
    RGBColor(96, 101, 112),
    RGBColor(124, 123, 120),
    RGBColor(156, 148, 119),
    RGBColor(188, 174, 108),
    RGBColor(222, 201, 90),
    RGBColor(255, 234, 70),
];

pub(crate) fn step(error: f64) -> usize {
    // Saturating casts; an error of zero is in the first step.
    ((error.max(1e-300).log10() - f64::from(LEAST) + 1.0).max(0.0) as usize).min(STEP_COLOURS.len() - 1)
}

/// A failure's mark: a cross with these arms, in halves of its size.
pub(crate) struct Cross {
    pub(crate) colour: RGBColor,
    pub(crate) arms: [[(i32, i32); 2]; 2],
}

pub(crate) const MARKS: [Cross; 2] = [
    Cross { colour: RGBColor(213, 0, 50), arms: [[(-1, -1), (1, 1)], [(-1, 1), (1, -1)]] },
    Cross { colour: RGBColor(0, 200, 255), arms: [[(-1, 0), (1, 0)], [(0, -1), (0, 1)]] },
];

/// A letter a cell, row by row from the top: `.` for none, the step of its error from `a` on, as a capital where a false shadow
/// is visible, `!` where there was no number.
pub(crate) fn letters(cells: &[&CellRecord], count: usize) -> String {
    let mut letters = vec![b'.'; count * count];
    for cell in cells.iter().filter(|c| c.x < count && c.y < count) {
        let letter = b'a' + step(cell.error_max) as u8;
        letters[(count - 1 - cell.y) * count + cell.x] = match (cell.not_finite > 0, cell.visible > 0) {
            (true, _) => b'!',
            (false, true) => letter.to_ascii_uppercase(),
            (false, false) => letter,
        };
    }
    letters.into_iter().map(char::from).collect()
}

/// What each of these [`letters`] means.
pub(crate) fn meanings() -> BTreeMap<char, String> {
    let last = STEP_COLOURS.len() - 1;
    let mut meanings =
        BTreeMap::from([('.', "no inputs".to_owned()), ('!', "no number for some inputs".to_owned())]);
    for step in 0..=last {
        let power = LEAST + step as i32;
        let words = if step == last {
            format!("largest error above {}", 10f64.powi(power - 1))
        } else {
            format!("largest error below 1e{power}")
        };
        let letter = char::from(b'a' + step as u8);
        meanings.insert(letter.to_ascii_uppercase(), format!("{words}, a visible false shadow"));
        meanings.insert(letter, words);
    }
    meanings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_has_a_letter_whose_meaning_holds() {
        let meanings = meanings();
        for (error, meaning) in [
            (0.0, "largest error below 1e-8"),
            (0.9e-8, "largest error below 1e-8"),
            (1.1e-8, "largest error below 1e-7"),
            (0.09, "largest error below 1e-1"),
            (0.11, "largest error above 0.1"),
            (1e9, "largest error above 0.1"),
        ] {
            assert_eq!(meanings[&char::from(b'a' + step(error) as u8)], meaning, "{error}");
        }
    }
}
