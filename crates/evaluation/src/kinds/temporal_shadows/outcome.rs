//! Classes of pixels, and the rows of groups of them.

use super::records::TemporalRecord;
use crate::statistics::{ErrorSummary, rounded};
use serde::{Deserialize, Serialize};

/// One technique on one judged pixel.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct Outcome {
    /// As shown; NaN where it failed.
    pub(super) shadow: f32,
    pub(super) truth: f32,
    pub(super) classes: Classes,
    /// |shadow - that of the frame before|, where the truth does not change.
    pub(super) flicker: Option<f32>,
    /// Of methods that gather.
    pub(super) gathered: Option<Gathered>,
    pub(super) lookups: f32,
}

/// What a buffer says of a pixel.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(super) struct Gathered {
    pub(super) estimate: f32,
    pub(super) believed: f32,
    pub(super) tests: f32,
    pub(super) restarted: bool,
    pub(super) filtered: bool,
}

/// Which classes a pixel belongs to, beside `all`.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct Classes {
    pub(super) penumbra: bool,
    pub(super) new: bool,
    pub(super) changed: bool,
}

/// Names of the classes.
pub(super) const CLASSES: [&str; 4] = ["all", "penumbra", "new", "changed"];

impl Classes {
    fn holds(self, class: &str) -> bool {
        match class {
            "penumbra" => self.penumbra,
            "new" => self.new,
            "changed" => self.changed,
            _ => true,
        }
    }
}

/// What does not depend on the pixels of a row.
#[derive(Clone, Debug)]
pub(super) struct Group<'a> {
    pub(super) scene: &'a str,
    pub(super) view: &'a str,
    pub(super) light: &'a str,
    pub(super) path: &'a str,
    pub(super) frame: usize,
    pub(super) technique: &'a str,
    pub(super) maps: usize,
    pub(super) bytes_per_pixel: usize,
    pub(super) bits_per_texel: usize,
    pub(super) error: &'a str,
}

/// From which error on a pixel that believes in none is wrong about itself.
const WRONG: f64 = 0.02;

/// The row of a class.
pub(super) fn record(group: &Group<'_>, class: &str, outcomes: &[Outcome]) -> TemporalRecord {
    let members: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.classes.holds(class)).collect();
    let answered: Vec<&Outcome> = members.iter().filter(|o| o.shadow.is_finite()).copied().collect();
    // An empty group has no errors; its count says so.
    let count = answered.len().max(1) as f64;
    let errors: Vec<f64> = answered.iter().map(|o| f64::from(o.shadow) - f64::from(o.truth)).collect();
    let summary = ErrorSummary::of(&errors);
    let flickers: Vec<f64> = answered.iter().filter_map(|o| o.flicker.map(f64::from)).collect();
    let gathered: Vec<(&Gathered, f64)> = answered
        .iter()
        .filter_map(|o| o.gathered.as_ref().map(|g| (g, f64::from(g.estimate) - f64::from(o.truth))))
        .collect();
    let of_gathered = |value: &dyn Fn(&Gathered, f64) -> f64| {
        let sum: f64 = gathered.iter().map(|(gathered, error)| value(gathered, *error)).sum();
        (!gathered.is_empty()).then(|| sum / gathered.len() as f64)
    };
    let share = |is: bool| if is { 1.0 } else { 0.0 };
    let believed = |g: &Gathered| f64::from(g.believed);
    TemporalRecord {
        application: "temporal".to_owned(),
        scene: group.scene.to_owned(),
        view: group.view.to_owned(),
        light: group.light.to_owned(),
        path: group.path.to_owned(),
        frame: group.frame,
        technique: group.technique.to_owned(),
        class: class.to_owned(),
        receivers: members.len(),
        l1_error: summary.mean,
        standard_error: summary.standard_error,
        signed_mean: summary.signed_mean,
        p95: summary.p95,
        flicker: (!flickers.is_empty())
            .then(|| rounded(flickers.iter().sum::<f64>() / flickers.len() as f64)),
        estimate_error: of_gathered(&|_, error| error.abs()).map(rounded),
        estimate_rms: of_gathered(&|_, error| error * error).map(|mean| rounded(mean.sqrt())),
        believed_rms: of_gathered(&|g, _| believed(g).powi(2)).map(|mean| rounded(mean.sqrt())),
        within: of_gathered(&|g, error| share(error.abs() <= believed(g))).map(rounded),
        falsely_certain: of_gathered(&|g, error| share(believed(g) == 0.0 && error.abs() > WRONG))
            .map(rounded),
        tests: of_gathered(&|g, _| f64::from(g.tests)).map(rounded),
        restarted: of_gathered(&|g, _| share(g.restarted)).map(rounded),
        filtered: of_gathered(&|g, _| share(g.filtered)).map(rounded),
        lookups: rounded(answered.iter().map(|o| f64::from(o.lookups)).sum::<f64>() / count),
        maps: group.maps,
        bytes_per_pixel: group.bytes_per_pixel,
        bits_per_texel: group.bits_per_texel,
        failed: members.len() - answered.len(),
        error: group.error.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_known_pixels() {
        let outcome = |shadow: f32, truth: f32, believed: f32, changed: bool| Outcome {
            shadow,
            truth,
            classes: Classes { penumbra: true, new: false, changed },
            flicker: changed.then_some(0.5),
            gathered: Some(Gathered {
                estimate: shadow,
                believed,
                tests: 4.0,
                restarted: changed,
                filtered: false,
            }),
            lookups: 2.0,
        };
        let outcomes = [
            outcome(0.5, 0.75, 0.5, true),
            outcome(0.5, 0.25, 0.0, false),
            outcome(f32::NAN, 0.5, 0.0, false),
        ];
        let group = Group {
            scene: "s",
            view: "v",
            light: "l",
            path: "p",
            frame: 3,
            technique: "t",
            maps: 1,
            bytes_per_pixel: 16,
            bits_per_texel: 32,
            error: "",
        };
        let all = record(&group, "all", &outcomes);
        assert_eq!((all.receivers, all.failed, all.l1_error, all.signed_mean), (3, 1, 0.25, 0.0));
        assert_eq!((all.within, all.falsely_certain, all.restarted), (Some(0.5), Some(0.5), Some(0.5)));
        assert_eq!((all.flicker, all.estimate_rms), (Some(0.5), Some(0.25)));
        let changed = record(&group, "changed", &outcomes);
        assert_eq!((changed.receivers, changed.signed_mean), (1, -0.25));
        let new = record(&group, "new", &outcomes);
        assert_eq!((new.receivers, new.l1_error, new.flicker, new.tests), (0, 0.0, None, None));
    }
}
