//! What the papers publish about filterable shadow maps.

use super::summary::{Agreement, FilterableTables};
use crate::kinds::PUBLISHED_RATIO;
use crate::page::{Claim, Measured, percent, player, recorded};

pub(crate) fn claims(tables: &FilterableTables<'_>) -> Vec<Claim> {
    let experiment = tables.experiment;
    // An experiment about the reference itself is not what the papers measured.
    if experiment.bias.iter().any(|bias| bias.reference != experiment.bias[0].reference) {
        return Vec::new();
    }
    [
        Claim::new(
            "MSM15 3.2",
            "Mean distance from percentage-closer filtering: 1.93 % for trigonometric moments, 2.19 % for power moments \
             (scenes and depth bias not public)",
            distances(tables),
        ),
        Claim::new(
            "MSM15 5",
            "Four moments produce less artifacts than other filterable shadow maps; trigonometric moments leak as much as \
             Hausdorff",
            artifacts(tables),
        ),
        Claim::new(
            "MSM15 4",
            "The closed forms of Hausdorff and trigonometric moments solve Problem 1",
            recorded(agreement(tables)),
        ),
        Claim::new("MSM15 3", "Solutions of Problem 1 never overestimate the shadow", recorded(excess(tables))),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Name and error over all views of the technique with a role.
fn error<'a>(tables: &FilterableTables<'a>, role: &'static str) -> Measured<(&'a str, f64)> {
    let name = &player(&tables.experiment.technique, role)?.name;
    let row = recorded(tables.row(("all", "all"), name, 0, "all"))?;
    Ok((name, row.l1_error))
}

fn distances(tables: &FilterableTables<'_>) -> Measured<String> {
    let ((_, power), (_, trigonometric)) = (error(tables, "four moments")?, error(tables, "trigonometric")?);
    Ok(format!(
        "{} and {} by the closed forms ({:.3} times, published {PUBLISHED_RATIO:.3}), against F at a depth bias of {}",
        percent(trigonometric, 2),
        percent(power, 2),
        power / trigonometric,
        tables.level().at()
    ))
}

fn artifacts(tables: &FilterableTables<'_>) -> Measured<String> {
    let moments = |role| Ok(percent(error(tables, role)?.1, 2));
    let named = |role| error(tables, role).map(|(name, error)| format!("{name} {}", percent(error, 2)));
    Ok(format!(
        "Hamburger 4 {}, Hausdorff 4 {}, trigonometric 4 {}; {}, {}, {}, {}",
        moments("four moments")?,
        moments("Hausdorff")?,
        moments("trigonometric")?,
        named("VSM")?,
        named("EVSM")?,
        named("ESM")?,
        named("CSM")?
    ))
}

fn agreement(tables: &FilterableTables<'_>) -> Option<String> {
    let of = |a: &Agreement| format!("{} within {:.1e} on {} fragments", a.technique, a.largest, a.fragments);
    let all: Vec<String> = tables.agreements().iter().map(of).collect();
    let is_compared = !all.is_empty() && tables.experiment.agreement_fragments > 0;
    is_compared.then(|| format!("Against the certified linear program: {}", all.join(", ")))
}

fn excess(tables: &FilterableTables<'_>) -> Option<String> {
    let rows = tables.pooled(0);
    let checked: Vec<(usize, usize)> =
        rows.iter().filter_map(|r| Some((r.unbiased_violations?, r.fragments))).collect();
    let violations: usize = checked.iter().map(|(violations, _)| violations).sum();
    let fragments: usize = checked.iter().map(|(_, fragments)| fragments).sum();
    let text = format!("{violations} of {fragments} comparisons without biases do");
    (!checked.is_empty()).then_some(text)
}
