//! Error statistics of a group of fragments.

use super::records::FilterableRecord;
use crate::statistics::{Sums, percentile, rounded};
use serde::{Deserialize, Serialize};

/// A bound may pass F by no more than this; 1e-6 of intensity is a quarter of a thousandth of an 8-bit step.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// One technique on one fragment.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(from = "Short", into = "Short")]
pub(crate) struct Outcome {
    /// G - F.
    pub(crate) error: f32,
    /// F.
    pub(crate) reference: f32,
    /// F_Z - G at the same depth.
    pub(crate) leak: f32,
    pub(crate) violates: bool,
    pub(crate) class: u8,
}

/// Short in checkpoints, which hold all of them.
type Short = (f32, f32, f32, bool, u8);

impl From<Outcome> for Short {
    fn from(outcome: Outcome) -> Self {
        (outcome.error, outcome.reference, outcome.leak, outcome.violates, outcome.class)
    }
}

impl From<Short> for Outcome {
    fn from((error, reference, leak, violates, class): Short) -> Self {
        Self { error, reference, leak, violates, class }
    }
}

/// Names of a group.
pub(crate) struct Group<'a> {
    pub(crate) scene: &'a str,
    pub(crate) view: &'a str,
    pub(crate) technique: &'a str,
    pub(crate) bias: usize,
    pub(crate) class: Option<usize>,
    /// Whether the group is a sample of the fragments.
    pub(crate) sampled: bool,
    pub(crate) is_bound: bool,
    pub(crate) bits_per_texel: usize,
}

/// The row of a group. The order of the outcomes is fixed, and so are the rounding errors of the sums.
pub(crate) fn record(group: &Group<'_>, outcomes: &[&[Outcome]], error: &str) -> FilterableRecord {
    let members = || {
        let all = outcomes.iter().copied().flatten();
        all.filter(|outcome| group.class.is_none_or(|class| usize::from(outcome.class) == class))
    };
    let mut sums = Sums::default();
    members().for_each(|outcome| sums.push(outcome.error, outcome.reference));
    let mut magnitudes: Vec<f64> = members().map(|outcome| f64::from(outcome.error).abs()).collect();
    magnitudes.sort_by(f64::total_cmp);
    // An empty group has no errors; its count says so.
    let divisor = sums.count.max(1) as f64;
    let mean = |of: &dyn Fn(&Outcome) -> f64| rounded(members().map(of).sum::<f64>() / divisor);
    FilterableRecord {
        scene: group.scene.to_owned(),
        view: group.view.to_owned(),
        technique: group.technique.to_owned(),
        bias: group.bias,
        class: match group.class {
            None => "all".to_owned(),
            Some(3) => "4+".to_owned(),
            Some(class) => (class + 1).to_string(),
        },
        fragments: sums.count,
        l1_error: rounded(sums.mean()),
        signed_mean: rounded(sums.signed / divisor),
        rms: rounded((sums.square / divisor).sqrt()),
        p95: rounded(percentile(&magnitudes, 0.95)),
        maximum: rounded(magnitudes.last().copied().unwrap_or_default()),
        share_above: mean(&|outcome| f64::from(u8::from(f64::from(outcome.error) > TOLERANCE))),
        standard_error: group.sampled.then(|| rounded(sums.standard_error())),
        relative_error: sums.relative_error().map(rounded),
        relative_standard_error: sums.relative_standard_error().filter(|_| group.sampled).map(rounded),
        leak: mean(&|outcome| f64::from(outcome.leak)),
        unbiased_violations: group.is_bound.then(|| members().filter(|outcome| outcome.violates).count()),
        bits_per_texel: group.bits_per_texel,
        error: error.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_a_known_group() {
        let outcome =
            |error: f32, class: u8| Outcome { error, reference: 0.5, leak: 0.5, violates: class == 3, class };
        let outcomes: Vec<Outcome> =
            [(-0.5, 0), (0.25, 0), (0.0, 1), (-1.0, 3)].map(|(error, class)| outcome(error, class)).into();
        let group = |class| Group {
            scene: "s",
            view: "v",
            technique: "t",
            bias: 0,
            class,
            sampled: true,
            is_bound: true,
            bits_per_texel: 64,
        };
        let all = record(&group(None), &[&outcomes[..2], &outcomes[2..]], "");
        assert_eq!((all.fragments, all.l1_error, all.signed_mean), (4, 0.4375, -0.3125));
        assert_eq!((all.p95, all.maximum, all.share_above, all.leak), (1.0, 1.0, 0.25, 0.5));
        // Doing nothing errs by 0.5 on each.
        assert_eq!(all.relative_error, Some(0.875));
        assert_eq!(all.rms, rounded((1.3125f64 / 4.0).sqrt()));
        assert_eq!(all.unbiased_violations, Some(1));
        // Standard deviation of 0.5, 0.25, 0, 1 over the root of 4.
        let variance = 1.3125 / 4.0 - 0.4375f64.powi(2);
        assert_eq!(all.standard_error, Some(rounded(variance.sqrt() / 2.0)));
        let one = record(&group(Some(0)), &[&outcomes], "");
        assert_eq!((one.class.as_str(), one.fragments, one.l1_error), ("1", 2, 0.375));
        let none = record(&group(Some(2)), &[&outcomes], "");
        assert_eq!((none.fragments, none.l1_error, none.maximum), (0, 0.0, 0.0));
        assert_eq!(record(&group(Some(3)), &[&outcomes], "").class, "4+");
    }
}
