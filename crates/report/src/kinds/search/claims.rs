//! What the papers publish about the search for a basis.

use super::summary::{POWER_4, SearchTables, TRIGONOMETRIC_4};
use crate::kinds::PUBLISHED_RATIO;
use crate::page::{Claim, Measured, Missing, Text, count_of, recorded};
use evaluation::{Provenance, SearchRecord};

/// Nothing where no basis has four functions, of which alone the papers speak.
pub(crate) fn claims(tables: &SearchTables<'_>, provenance: &Provenance) -> Vec<Claim> {
    if tables.of(4).count() == 0 {
        return Vec::new();
    }
    [
        Claim::new(
            "MSM15 3.2",
            "66 045 bases of four of 37 functions; 392 billion linear programs, several weeks on a cluster",
            recorded(extent(tables, provenance)),
        ),
        Claim::new(
            "MSM15 3.2",
            "The trigonometric moment problem realises the minimal error, 1.93 %",
            minimum(tables),
        ),
        Claim::new(
            "MSM15 3.2",
            format!(
                "Four power moments err by 2.19 %, {PUBLISHED_RATIO:.3} times the trigonometric ones; both are among \
                 the smallest"
            ),
            ratio(tables),
        ),
        Claim::new("MSM15 Figure 4", "Many candidates perform similarly well", recorded(near(tables))),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn extent(tables: &SearchTables<'_>, provenance: &Provenance) -> Option<String> {
    let all = tables.of(4).count();
    let programs: u64 = tables.stages.iter().map(|stage| stage.programs).sum();
    // What shards took is not in the record of their merge.
    let part = if provenance.command.contains(" --merge ") { "to merge its shards " } else { "" };
    (all > 0).then(|| {
        format!(
            "{all} bases of four of {} functions; {} certified programs, as bases that cannot win leave \
             early; {:.0} s {part}on {} threads ({})",
            tables.experiment.functions().map_or(0, |f| f.len()),
            count_of(programs),
            provenance.seconds,
            provenance.threads,
            provenance.cpu
        )
    })
}

fn candidate<'a>(tables: &'a SearchTables<'_>, basis: &str) -> Measured<&'a SearchRecord> {
    let unasked = || Missing::Unasked(Text::default().code(basis).and(" is no candidate"));
    tables.find(basis).ok_or_else(unasked)
}

fn rank(tables: &SearchTables<'_>, r: &SearchRecord) -> String {
    format!("rank {} ({} to {}) with {}", r.rank, r.rank_low, r.rank_high, tables.error(r))
}

fn minimum(tables: &SearchTables<'_>) -> Measured<Text> {
    let trigonometric = candidate(tables, TRIGONOMETRIC_4)?;
    let all = tables.of(4);
    let best = recorded(all.first())?;
    let head = format!("{}; the least mean, ", rank(tables, trigonometric));
    Ok(Text::from(head).code(&best.basis).and(format!(", {}", tables.error(best))))
}

fn ratio(tables: &SearchTables<'_>) -> Measured<String> {
    let (power, trigonometric) = (candidate(tables, POWER_4)?, candidate(tables, TRIGONOMETRIC_4)?);
    Ok(format!("{}, {:.3} times", rank(tables, power), power.l1_error / trigonometric.l1_error))
}

fn near(tables: &SearchTables<'_>) -> Option<String> {
    let all = tables.of(4);
    let best = all.first()?;
    let near = all.count_if(|r| r.l1_error <= 1.1 * best.l1_error);
    Some(format!("{near} are within a tenth of the best one's error"))
}
