//! Classes of receivers, and the rows of groups of them.

use super::records::SoftRecord;
use super::view::Population;
use crate::statistics::{ErrorSummary, rounded};

/// Widths of the filter of percentage-closer soft shadows in texels.
pub(super) const WIDTHS: [&str; 5] = ["lit", "0-1", "1-4", "4-16", "16+"];

/// Light-facing surfaces in front of a receiver within that filter.
pub(super) const LAYERS: [&str; 4] = ["0", "1", "2", "3+"];

/// The class of a width; 0 is that of a search region without blockers.
pub(super) fn width_class(width: f64) -> usize {
    if width > 0.0 { 1 + [1.0, 4.0, 16.0].iter().filter(|&&limit| width > limit).count() } else { 0 }
}

/// One technique on one receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    /// What it makes of the receiver; NaN where it failed.
    pub(super) intensity: f32,
    pub(super) truth: f32,
    /// What the first technique makes of it.
    pub(super) first: f32,
    pub(super) width: u8,
    pub(super) layers: u8,
}

/// Which receivers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Class {
    All,
    Width(usize),
    Layers(usize),
}

impl Class {
    /// Everything, then every class of widths and of layers.
    pub(super) fn each() -> impl Iterator<Item = Self> {
        let widths = (0..WIDTHS.len()).map(Self::Width);
        [Self::All].into_iter().chain(widths).chain((0..LAYERS.len()).map(Self::Layers))
    }

    fn holds(self, outcome: &Outcome) -> bool {
        match self {
            Self::All => true,
            Self::Width(width) => usize::from(outcome.width) == width,
            Self::Layers(layers) => usize::from(outcome.layers) == layers,
        }
    }

    fn names(self) -> [&'static str; 2] {
        match self {
            Self::All => ["all", "all"],
            Self::Width(width) => ["width", WIDTHS[width]],
            Self::Layers(layers) => ["layers", LAYERS[layers]],
        }
    }
}

/// Names of a group.
pub(super) struct Group<'a> {
    pub(super) light: &'a str,
    pub(super) population: Population,
    pub(super) scene: &'a str,
    pub(super) view: &'a str,
    pub(super) technique: &'a str,
    pub(super) bias: usize,
    pub(super) best: bool,
    pub(super) class: Class,
    /// Whether the group is a sample.
    pub(super) sampled: bool,
    pub(super) bits_per_texel: usize,
}

/// The row of a group. The order of the outcomes is fixed, and so are the rounding errors of the sums.
pub(super) fn record(group: &Group<'_>, outcomes: &[Outcome], error: &str) -> SoftRecord {
    let members: Vec<&Outcome> = outcomes.iter().filter(|outcome| group.class.holds(outcome)).collect();
    let answered: Vec<&Outcome> = members.iter().filter(|o| o.intensity.is_finite()).copied().collect();
    let errors: Vec<f64> = answered.iter().map(|o| f64::from(o.intensity) - f64::from(o.truth)).collect();
    let summary = ErrorSummary::of(&errors);
    let to_first = |o: &&Outcome| f64::from((o.intensity - o.first).abs());
    let [name, class] = group.class.names();
    SoftRecord {
        light: group.light.to_owned(),
        population: group.population,
        scene: group.scene.to_owned(),
        view: group.view.to_owned(),
        technique: group.technique.to_owned(),
        bias: group.bias,
        best: group.best,
        group: name.to_owned(),
        class: class.to_owned(),
        receivers: members.len(),
        mean_error: summary.mean,
        standard_error: group.sampled.then_some(summary.standard_error),
        signed_mean: summary.signed_mean,
        p95: summary.p95,
        maximum: summary.maximum,
        mean_to_first: rounded(answered.iter().map(to_first).sum::<f64>() / answered.len().max(1) as f64),
        bits_per_texel: group.bits_per_texel,
        failed: members.len() - answered.len(),
        error: error.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_fall_into_classes() {
        let names = [0.0, 0.5, 1.0, 1.5, 4.0, 9.0, 16.0, 17.0].map(|width| WIDTHS[width_class(width)]);
        assert_eq!(names, ["lit", "0-1", "0-1", "1-4", "1-4", "4-16", "4-16", "16+"]);
    }

    #[test]
    fn statistics_of_a_known_group() {
        let outcome =
            |intensity, truth, first, width, layers| Outcome { intensity, truth, first, width, layers };
        let outcomes = [
            outcome(0.5, 1.0, 0.75, 2, 1),
            outcome(0.25, 0.0, 0.25, 2, 3),
            outcome(f32::NAN, 0.5, 0.5, 0, 0),
        ];
        let group = |class| Group {
            light: "sun",
            population: Population::Camera,
            scene: "s",
            view: "v",
            technique: "t",
            bias: 0,
            best: true,
            class,
            sampled: true,
            bits_per_texel: 128,
        };
        let all = record(&group(Class::All), &outcomes, "");
        assert_eq!((all.receivers, all.failed, all.mean_error, all.signed_mean), (3, 1, 0.375, -0.125));
        assert_eq!((all.p95, all.maximum, all.mean_to_first), (0.5, 0.5, 0.125));
        let narrow = record(&group(Class::Width(2)), &outcomes, "");
        assert_eq!((narrow.receivers, narrow.failed, narrow.class.as_str()), (2, 0, "1-4"));
        let fused = record(&group(Class::Layers(3)), &outcomes, "");
        assert_eq!((fused.receivers, fused.mean_error, fused.group.as_str()), (1, 0.25, "layers"));
        let none = record(&group(Class::Layers(2)), &outcomes, "");
        assert_eq!((none.receivers, none.mean_error, none.maximum), (0, 0.0, 0.0));
        assert_eq!(Class::each().count(), 10);
    }
}
