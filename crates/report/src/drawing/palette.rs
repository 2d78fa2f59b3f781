//! Colours that the colour-blind can tell apart, on white paper and on a dark page.

use plotters::style::RGBColor;
use std::fmt::Write as _;

// Each differs from the others by a CIEDE2000 of at least 13, seen by anybody, and from the paper by a contrast of 3.
pub(crate) const BLACK: RGBColor = RGBColor(0, 0, 0);
pub(crate) const VERMILLION: RGBColor = RGBColor(174, 38, 1);
pub(crate) const SKY_BLUE: RGBColor = RGBColor(93, 117, 246);
pub(crate) const GREEN: RGBColor = RGBColor(12, 168, 107);
pub(crate) const PURPLE: RGBColor = RGBColor(178, 126, 164);
pub(crate) const BLUE: RGBColor = RGBColor(3, 49, 140);
pub(crate) const ORANGE: RGBColor = RGBColor(214, 102, 3);
pub(crate) const BROWN: RGBColor = RGBColor(86, 55, 53);
pub(crate) const GREY: RGBColor = RGBColor(110, 110, 110);

/// Colours of curves that are no techniques, in their order.
pub(crate) const CURVE_COLOURS: [RGBColor; 6] = [VERMILLION, SKY_BLUE, GREEN, PURPLE, BLUE, ORANGE];

pub(crate) const GRID: RGBColor = RGBColor(225, 225, 225);
/// Ticks and axes.
pub(crate) const RUG: RGBColor = RGBColor(90, 90, 90);
/// Where a map has no values.
pub(crate) const EMPTY: RGBColor = RGBColor(240, 240, 240);
pub(crate) const PAPER: RGBColor = RGBColor(255, 255, 255);

/// What stands for a colour on a dark page; pictures and maps of values keep theirs.
const DARK: [(RGBColor, RGBColor); 13] = [
    (PAPER, RGBColor(24, 28, 34)),
    (BLACK, RGBColor(230, 232, 235)),
    (GREY, RGBColor(154, 163, 173)),
    (RUG, RGBColor(169, 176, 186)),
    (GRID, RGBColor(53, 59, 68)),
    (EMPTY, RGBColor(42, 48, 56)),
    (ORANGE, RGBColor(210, 206, 21)),
    (PURPLE, RGBColor(255, 170, 170)),
    (VERMILLION, RGBColor(229, 92, 30)),
    (BROWN, RGBColor(146, 110, 122)),
    (GREEN, RGBColor(2, 169, 114)),
    (BLUE, RGBColor(47, 110, 212)),
    (SKY_BLUE, RGBColor(144, 193, 234)),
];

/// As CSS.
pub(crate) fn css(colour: RGBColor) -> String {
    let RGBColor(r, g, b) = colour;
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The same colour on a dark page.
pub(crate) fn dark(colour: RGBColor) -> RGBColor {
    DARK.iter().find(|(light, _)| *light == colour).map_or(colour, |(_, dark)| *dark)
}

/// Rules for drawings on a dark page.
pub(crate) fn dark_rules() -> String {
    let mut rules = String::new();
    for (light, dark) in DARK {
        for property in ["fill", "stroke"] {
            // Writing to a string cannot fail.
            let _ = writeln!(
                rules,
                ".figure svg [{property}=\"{}\" i] {{ {property}: {}; }}",
                css(light),
                css(dark)
            );
        }
    }
    rules
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that a screen gives, of each channel.
    fn linear(RGBColor(r, g, b): RGBColor) -> [f64; 3] {
        [r, g, b].map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }

    /// Of WCAG 2.
    fn contrast(a: RGBColor, b: RGBColor) -> f64 {
        let luminance = |c| {
            let [r, g, b] = linear(c);
            0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05
        };
        let (a, b) = (luminance(a), luminance(b));
        a.max(b) / a.min(b)
    }

    /// What is seen without one kind of cones (Machado, Oliveira and Fernandes 2009, severity 1), and by all three.
    const EYES: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    ];

    /// CIELAB under D65 of what these eyes see.
    fn lab(eyes: &[[f64; 3]; 3], colour: RGBColor) -> [f64; 3] {
        let light = linear(colour);
        let [r, g, b] =
            eyes.map(|row| row.iter().zip(light).map(|(m, c)| m * c).sum::<f64>().clamp(0.0, 1.0));
        let f = |t: f64| {
            if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 }
        };
        let x = f((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
        let y = f(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
        let z = f((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// CIEDE2000 (Sharma, Wu and Dalal 2005).
    fn difference([l1, a1, b1]: [f64; 3], [l2, a2, b2]: [f64; 3]) -> f64 {
        let root = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
        let g = 1.5 - 0.5 * root((a1.hypot(b1) + a2.hypot(b2)) / 2.0);
        let (a1, a2) = (g * a1, g * a2);
        let (c1, c2) = (a1.hypot(b1), a2.hypot(b2));
        let hue = |a: f64, b: f64| {
            if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).to_degrees().rem_euclid(360.0) }
        };
        let (h1, h2) = (hue(a1, b1), hue(a2, b2));
        let turn = if c1 * c2 == 0.0 { 0.0 } else { (h2 - h1 + 180.0).rem_euclid(360.0) - 180.0 };
        let (l, c) = ((l1 + l2) / 2.0, (c1 + c2) / 2.0);
        let h = if c1 * c2 == 0.0 { h1 + h2 } else { (h1 + turn / 2.0).rem_euclid(360.0) };
        let cosine = |degrees: f64| degrees.to_radians().cos();
        let t = 1.0 - 0.17 * cosine(h - 30.0) + 0.24 * cosine(2.0 * h) + 0.32 * cosine(3.0 * h + 6.0)
            - 0.2 * cosine(4.0 * h - 63.0);
        let lightness = (l2 - l1) / (1.0 + 0.015 * (l - 50.0).powi(2) / (20.0 + (l - 50.0).powi(2)).sqrt());
        let chroma = (c2 - c1) / (1.0 + 0.045 * c);
        let angle = 2.0 * (c1 * c2).sqrt() * (turn / 2.0).to_radians().sin() / (1.0 + 0.015 * c * t);
        let mixed = -2.0 * root(c) * (60.0 * (-((h - 275.0) / 25.0).powi(2)).exp()).to_radians().sin();
        (lightness.powi(2) + chroma.powi(2) + angle.powi(2) + mixed * chroma * angle).sqrt()
    }

    /// Colours of techniques: they share charts.
    const TECHNIQUES: [RGBColor; 9] = [BLACK, GREY, ORANGE, PURPLE, VERMILLION, BROWN, GREEN, BLUE, SKY_BLUE];

    #[test]
    fn the_difference_is_that_of_published_pairs() {
        let near = |a, b, expected: f64| assert!((difference(a, b) - expected).abs() < 1e-4, "{a:?}");
        near([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425);
        near([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535);
        near([6.7747, -0.2908, -2.4247], [5.8714, -0.0985, -2.2286], 0.6377);
        near([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669);
    }

    /// Text next to marks is read with 10; half of that still separates neighbours, and shapes, dashes and names carry the rest.
    const LEAST_DIFFERENCE: f64 = 12.0;

    #[test]
    fn everybody_can_tell_techniques_apart_on_both_pages() {
        for page in [|c| c, dark] {
            for eyes in &EYES {
                for (i, &a) in TECHNIQUES.iter().enumerate() {
                    for &b in &TECHNIQUES[..i] {
                        let seen = difference(lab(eyes, page(a)), lab(eyes, page(b)));
                        assert!(seen >= LEAST_DIFFERENCE, "{a:?} {b:?}: {seen}");
                    }
                }
            }
        }
    }

    #[test]
    fn marks_and_words_stand_out_from_the_paper() {
        for page in [|c| c, dark] {
            for colour in TECHNIQUES {
                let found = contrast(page(colour), page(PAPER));
                assert!(found >= 3.0, "{colour:?}: {found}");
            }
            for words in [BLACK, RUG, GREY] {
                let found = contrast(page(words), page(PAPER));
                assert!(found >= 4.5, "{words:?}: {found}");
            }
        }
    }

    #[test]
    fn every_colour_has_one_counterpart() {
        let rules = dark_rules();
        for colour in TECHNIQUES {
            assert_ne!(dark(colour), colour);
            assert!(rules.contains(&css(dark(colour))), "{rules}");
        }
    }
}
