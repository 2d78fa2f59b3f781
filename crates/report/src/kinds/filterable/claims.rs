//! What the papers publish about filterable shadow maps.

use super::summary::{Agreement, Tables};
use crate::kinds::PUBLISHED_RATIO;
use crate::page::{Claim, percent};
use evaluation::FilterableExperiment;

pub(crate) fn claims(tables: &Tables, experiment: &FilterableExperiment) -> Vec<Claim> {
    // An experiment about the reference itself is not what the papers measured.
    if experiment.bias.iter().any(|bias| bias.reference != experiment.bias[0].reference) {
        return Vec::new();
    }
    let pooled = |name: &str| tables.row(("all", "all"), name, 0, "all").map(|r| r.l1_error);
    let percent = |fraction| percent(fraction, 2);
    let (hamburger, trigonometric) = (pooled("Hamburger 4"), pooled("Trigonometric 4"));
    let best = tables.pooled(0);
    let others: Vec<String> = ["VSM", "EVSM 4, c = 10", "ESM, c = 80", "CSM, M = 16"]
        .iter()
        .filter_map(|name| Some(format!("{name} {}", percent(pooled(name)?))))
        .collect();
    let agreements = tables.agreements();
    [
        Claim::new(
            "MSM15 3.2",
            "Mean distance from percentage-closer filtering: 1.93 % for trigonometric moments, 2.19 % for power moments \
             (scenes and depth bias not public)",
            hamburger.zip(trigonometric).map(|(hamburger, trigonometric)| {
                format!(
                    "{} and {} by the closed forms ({:.3} times, published {PUBLISHED_RATIO:.3})",
                    percent(trigonometric),
                    percent(hamburger),
                    hamburger / trigonometric
                )
            }),
        ),
        Claim::new(
            "MSM15 5",
            "Four moments produce less artifacts than other filterable shadow maps; trigonometric moments leak as much as \
             Hausdorff",
            hamburger.zip(pooled("Hausdorff 4")).zip(trigonometric).map(|((hamburger, hausdorff), t)| {
                format!(
                    "Hamburger 4 {}, Hausdorff 4 {}, trigonometric 4 {}; {}",
                    percent(hamburger),
                    percent(hausdorff),
                    percent(t),
                    others.join(", ")
                )
            }),
        ),
        Claim::new(
            "MSM15 4",
            "The closed forms of Hausdorff and trigonometric moments solve Problem 1",
            (!agreements.is_empty() && experiment.agreement_fragments > 0).then(|| {
                let of = |a: &Agreement| {
                    format!("{} within {:.1e} on {} fragments", a.technique, a.largest, a.fragments)
                };
                let all: Vec<String> = agreements.iter().map(of).collect();
                format!("Against the certified linear program: {}", all.join(", "))
            }),
        ),
        Claim::new(
            "MSM15 3",
            "Solutions of Problem 1 never overestimate the shadow",
            best.iter().any(|r| r.unbiased_violations.is_some()).then(|| {
                let checked = best.iter().filter(|r| r.unbiased_violations.is_some());
                let (mut violations, mut fragments) = (0, 0);
                for r in checked {
                    violations += r.unbiased_violations.unwrap_or_default();
                    fragments += r.fragments;
                }
                format!("{violations} of {fragments} comparisons without biases do")
            }),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}
