//! What the papers publish about the search for a basis.

use super::summary::{SearchTables, error};
use crate::kinds::PUBLISHED_RATIO;
use crate::page::{Claim, Text};
use evaluation::{Provenance, SearchExperiment, SearchRecord};

pub(crate) fn claims(
    tables: &SearchTables,
    experiment: &SearchExperiment,
    provenance: &Provenance,
) -> Vec<Claim> {
    let all = tables.of(4).len();
    let programs: u64 = tables.stages.iter().map(|stage| stage.programs).sum();
    let ratio = |trigonometric: f64, power: f64| format!("{:.3} times", power / trigonometric);
    let both = tables.trigonometric().zip(tables.power());
    let rank =
        |r: &SearchRecord| format!("rank {} ({} to {}) with {}", r.rank, r.rank_low, r.rank_high, error(r));
    [
        Claim::new(
            "MSM15 3.2",
            "66 045 bases of four of 37 functions; 392 billion linear programs, several weeks on a cluster",
            (all > 0).then(|| {
                format!(
                    "{all} bases of four of {} functions; {:.0} million certified programs, as bases that cannot win leave \
                     early; {:.0} s on {} threads ({})",
                    experiment.functions().map_or(0, |f| f.len()),
                    programs as f64 / 1e6,
                    provenance.seconds,
                    provenance.threads,
                    provenance.cpu
                )
            }),
        ),
        Claim::new(
            "MSM15 3.2",
            "The trigonometric moment problem realises the minimal error, 1.93 %",
            tables.trigonometric().zip(tables.of(4).first()).map(|(trigonometric, best)| {
                let best = Text::from("; the best, ").code(&best.basis).and(format!(", {}", error(best)));
                Text::joined([rank(trigonometric).into(), best], "")
            }),
        ),
        Claim::new(
            "MSM15 3.2",
            &format!(
                "Four power moments err by 2.19 %, {PUBLISHED_RATIO:.3} times the trigonometric ones; both are among \
                 the smallest"
            ),
            both.map(|(t, p)| format!("{}, {}", rank(p), ratio(t.l1_error, p.l1_error))),
        ),
        Claim::new(
            "MSM15 Figure 4",
            "Many candidates perform similarly well",
            tables.of(4).first().map(|best| {
                let near = tables.of(4).iter().filter(|r| r.l1_error <= 1.1 * best.l1_error).count();
                format!("{near} are within a tenth of the best one's error")
            }),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}
