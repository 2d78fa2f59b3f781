//! Techniques in pairs, on the fragments that both were evaluated on: a certified basis has some hundred fragments, where
//! others have thousands, and means over different fragments say nothing about who errs less.

use super::records::PairRecord;
use super::tables::Evaluated;
use crate::statistics::rounded;
use std::cmp::Ordering;

/// All pairs under the first bias. `named` says whether a technique was evaluated on all fragments of all views; `evaluated` is
/// by technique and view.
pub(super) fn compared(named: &[(&str, bool)], evaluated: &[Vec<Evaluated>]) -> Vec<PairRecord> {
    let mut pairs = Vec::new();
    for (i, one) in named.iter().enumerate() {
        for (j, other) in named.iter().enumerate().skip(i + 1) {
            let views = evaluated[i].iter().zip(&evaluated[j]);
            let differences: Vec<f64> = views.flat_map(|(a, b)| differences(a, b)).collect();
            let count = differences.len().max(1) as f64;
            let mean = differences.iter().sum::<f64>() / count;
            let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / count;
            pairs.push(PairRecord {
                technique: one.0.to_owned(),
                other: other.0.to_owned(),
                fragments: differences.len(),
                difference: rounded(mean),
                standard_error: (!(one.1 && other.1)).then(|| rounded((variance / count).sqrt())),
            });
        }
    }
    pairs
}

/// |G - F| of one minus that of the other on the samples of a view that both have.
fn differences(one: &Evaluated, other: &Evaluated) -> Vec<f64> {
    let (mut i, mut j) = (0, 0);
    let mut differences = Vec::new();
    while let (Some(a), Some(b)) = (one.places.get(i), other.places.get(j)) {
        match a.cmp(b) {
            Ordering::Less => i += 1,
            Ordering::Greater => j += 1,
            Ordering::Equal => {
                let error = |of: &Evaluated, index: usize| f64::from(of.by_bias[0][index].error.abs());
                differences.push(error(one, i) - error(other, j));
                (i, j) = (i + 1, j + 1);
            }
        }
    }
    differences
}

#[cfg(test)]
mod tests {
    use super::super::statistics::Outcome;
    use super::*;

    fn evaluated(places: &[usize], errors: &[f32]) -> Vec<Evaluated> {
        let outcome = |&error: &f32| Outcome { error, reference: 1.0, leak: 0.0, violates: false, class: 0 };
        let by_bias = vec![errors.iter().map(outcome).collect()];
        vec![Evaluated { by_bias, places: places.to_vec(), error: String::new() }]
    }

    #[test]
    fn few_fragments_are_compared_with_the_same_ones_only() {
        // The few that the first has are easy ones: its mean is lower, and yet it errs more on each.
        let few = evaluated(&[1, 3], &[-0.25, 0.125]);
        let all = evaluated(&[0, 1, 2, 3], &[1.0, 0.125, -1.0, 0.0]);
        let pairs = compared(&[("few", false), ("all", true)], &[few, all]);
        assert_eq!(pairs.len(), 1);
        assert_eq!((pairs[0].fragments, pairs[0].difference, pairs[0].standard_error), (2, 0.125, Some(0.0)));
        let (a, b) = (evaluated(&[0, 1], &[0.5, 0.0]), evaluated(&[0, 1], &[0.25, 0.5]));
        let pairs = compared(&[("a", true), ("b", true)], &[a, b]);
        assert_eq!((pairs[0].difference, pairs[0].standard_error), (-0.125, None));
    }
}
