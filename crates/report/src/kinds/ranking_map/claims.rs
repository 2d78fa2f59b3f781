//! What MSM15 says about its ranking.

use super::summary::RankingTables;
use crate::page::{Claim, recorded};

pub(super) fn claims(tables: &RankingTables<'_>) -> Vec<Claim> {
    [Claim::new(
        "MSM15 3.2",
        "One ranking, of one set of scenes with one filter and one depth bias",
        recorded(transfer(tables)),
    )]
    .into_iter()
    .flatten()
    .collect()
}

fn transfer(tables: &RankingTables<'_>) -> Option<String> {
    let least = tables.others().min_by(|a, b| a.correlation.total_cmp(&b.correlation))?;
    let worst = tables.others().max_by(|a, b| a.regret.total_cmp(&b.regret))?;
    Some(format!(
        "Rank correlation over {} other settings is at least {:.3} ({}); the best basis errs at most {:.1} % more than the best \
         of other settings ({})",
        tables.others().count(),
        least.correlation,
        least.variation,
        100.0 * worst.regret,
        worst.variation
    ))
}
