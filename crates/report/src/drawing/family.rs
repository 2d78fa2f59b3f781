//! Which techniques have a colour together, in every figure of the page.

use super::palette::{BLACK, BLUE, BROWN, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, VERMILLION};
use plotters::style::RGBColor;

/// Techniques that have a colour together.
#[derive(Debug)]
pub(crate) struct Family {
    /// In legends and filters.
    pub(crate) name: &'static str,
    pub(crate) colour: RGBColor,
    /// Words of which a technique's name has one, in lower case.
    words: &'static [&'static str],
}

/// The first that a name belongs to is its family.
pub(crate) const FAMILIES: [Family; 8] = [
    Family { name: "trigonometric moments", colour: BLACK, words: &["trigonometric"] },
    Family { name: "Hausdorff moments", colour: SKY_BLUE, words: &["hausdorff"] },
    Family { name: "EVSM", colour: VERMILLION, words: &["evsm", "exponential variance"] },
    Family { name: "ESM", colour: PURPLE, words: &["esm", "exponential"] },
    Family { name: "LVSM", colour: BROWN, words: &["lvsm", "layered"] },
    Family { name: "CSM, Fourier", colour: GREEN, words: &["csm", "convolution", "fourier"] },
    Family {
        name: "VSM",
        colour: ORANGE,
        words: &["vsm", "variance", "two moments", "hamburger 2", "hamburger2"],
    },
    Family { name: "power moments", colour: BLUE, words: &["moment", "hamburger", "absorbance", "power"] },
];

/// What compares depths one by one: percentage-closer filtering and its like, samples, rays.
pub(crate) const COMPARISONS: Family = Family { name: "no moments (PCF, samples)", colour: GREY, words: &[] };

impl Family {
    /// By a technique's name.
    pub(crate) fn of(name: &str) -> &'static Self {
        let name = name.to_lowercase();
        let has = |family: &&Self| family.words.iter().any(|word| name.contains(word));
        FAMILIES.iter().find(has).unwrap_or(&COMPARISONS)
    }

    /// All, in the order of legends.
    pub(crate) fn all() -> impl Iterator<Item = &'static Self> {
        FAMILIES.iter().rev().chain([&COMPARISONS])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_all_applications_find_their_family() {
        for (name, family) in [
            ("VSM", "VSM"),
            ("variance soft shadows", "VSM"),
            ("EVSM 4, c = 5.5", "EVSM"),
            ("exponential variance, c = 10", "EVSM"),
            ("exponential, c = 5", "ESM"),
            ("LVSM, 4 layers", "LVSM"),
            ("Hamburger 4", "power moments"),
            ("moment soft shadows", "power moments"),
            ("Hausdorff 4, unorm16", "Hausdorff moments"),
            ("trigonometric 4, 16 bits", "trigonometric moments"),
            ("convolution, 16 pairs", "CSM, Fourier"),
            ("PCSS 32/32", "no moments (PCF, samples)"),
        ] {
            assert_eq!(Family::of(name).name, family, "{name}");
        }
    }
}
