//! The tables of a quantisation experiment, each with a note on how to read it.

use super::summary::{QuantizationTables, percent};
use crate::page::{Block, Table, Text, code, in_percent, row};
use evaluation::{BiasRecord, ComparisonRecord, GainRecord, QuantizationViewRecord};

pub(crate) fn blocks(tables: &QuantizationTables) -> Vec<Block> {
    [gains(tables), errors(tables), comparisons(tables), circulation(tables), targets(tables), views(tables)]
        .concat()
}

/// Seven digits are more than any table's reader compares; small ones in powers of ten.
fn alpha(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

fn gains(tables: &QuantizationTables) -> Vec<Block> {
    let cells = |g: &GainRecord| {
        let overshoot = |(min, max): (f64, f64)| format!("{:.0e}", (-min).max(max - 1.0).max(0.0));
        row![
            code(&g.basis),
            &g.transform,
            &g.range,
            g.gain_bits.map(|bits| format!("{bits:.5}")),
            g.bound_bits.map(|bits| format!("{:.4}", (bits * 1e4).ceil() / 1e4)),
            g.gain_bits.zip(g.bound_bits).map(|(gain, bound)| format!("{:.4}", bound - gain)),
            g.range_min.zip(g.range_max).map(overshoot),
            g.starts_at_best.zip(g.starts).map(|(hits, starts)| format!("{hits} of {starts}")),
            tables.seconds(&g.basis, &g.transform).map(|s| format!("{s:.2}")),
        ]
    };
    let table = Table::default()
        .left(["basis"])
        .right(["transform", "depths", "gain, bits", "bound, bits", "gap", "overshoot", "starts at best"])
        .right(["time, s"])
        .rows(tables.gains.iter().map(cells));
    let note = Text::from(
        "Gain: log2 |det theta| in units of depths in [0, 1]; more is better. Bound: no transform gains more, proved. \
         Overshoot: how far stored values can leave [0, 1], proved. Starts at best: random starts of the search that came \
         to the same gain. Time with all threads of the run, proof included.",
    );
    Block::section(2, "Gains", table, Some(note))
}

fn errors(tables: &QuantizationTables) -> Vec<Block> {
    let bits = |b: &BiasRecord| {
        let of = tables.records.iter().find(|r| {
            (&r.bound, &r.transform, &r.format, &r.kernel) == (&b.bound, &b.transform, &b.format, &b.kernel)
        });
        of.map(|r| r.bits_per_texel)
    };
    let rows = tables.best().into_iter().map(|b| {
        let exact = tables.exact(&b.bound, &b.kernel);
        let lost = |error: f64| exact.map(|exact| format!("{:+.3}", 100.0 * (error - exact)));
        let valid = tables.most_valid(b).unwrap_or(b);
        row![
            &b.bound,
            &b.transform,
            &b.format,
            &b.kernel,
            bits(b),
            exact.map(percent),
            percent(b.invalid_unbiased),
            format!("{} ({})", alpha(b.best_alpha), b.target),
            lost(b.best_l1_error),
            percent(b.best_change),
            percent(b.best_excess_share),
            percent(b.best_failure_share),
            format!("{} ({})", alpha(valid.alpha_999), valid.target),
            alpha(valid.alpha_all),
            lost(valid.valid_l1_error),
            percent(valid.valid_change),
        ]
    });
    let table = Table::default()
        .left(["bound"])
        .right(["transform", "format", "filter", "bits a texel", "L1, not quantised"])
        .right(["invalid, alpha 0", "alpha of least error (b*)", "L1 added", "change"])
        .right(["false shadows", "invalid", "alpha, 99.9 % valid (b*)", "all valid", "L1 added"])
        .right(["change"])
        .rows(rows);
    let note = Text::from(
        "Errors and shares in percent; less is better. L1 added: mean |G - F| minus that of the same bound without \
         quantisation. Change: mean distance of G from the same bound without quantisation. False shadows: share of \
         fragments with G more than 1/255 above PCF of the same depth, which no lower bound exceeds. Invalid: moment \
         vectors whose moment matrix is not positive definite after the bias. Two biases are shown for each format: that \
         of least error, and the least that makes 99.9 % of the vectors valid, each with the b* that serves it best. \
         Values are rounded when stored and after each of the two filter passes; all else is computed in f64. For \
         Hausdorff 4 validity means the same matrix, not the constraints of the interval.",
    );
    Block::section(2, "Error by format", table, Some(note))
}

fn comparisons(tables: &QuantizationTables) -> Vec<Block> {
    // The least error among transforms that keep nearly all vectors valid.
    let valid = |c: &ComparisonRecord, transform: &str| {
        let same = |b: &&BiasRecord| {
            (b.bound.as_str(), b.format.as_str(), b.transform.as_str()) == (&c.bound, &c.format, transform)
        };
        let bias = tables.biases.iter().find(same).and_then(|b| tables.most_valid(b));
        bias.map(|b| format!("{} at {}", percent(b.valid_l1_error), alpha(b.alpha_999)))
    };
    let rows = tables.comparisons.iter().map(|c| {
        row![
            &c.bound,
            &c.format,
            &c.transform,
            &c.baseline,
            percent(c.l1_error),
            percent(c.baseline_l1_error),
            format!("{:+.4} ± {:.4}", 100.0 * c.difference, 100.0 * c.standard_error),
            format!("{} ({})", alpha(c.alpha), c.target),
            format!("{} ({})", alpha(c.baseline_alpha), c.baseline_target),
            format!("{} of {}", c.better_views, c.views),
            valid(c, &c.transform),
            valid(c, &c.baseline),
        ]
    });
    let table = Table::default()
        .left(["bound"])
        .right(["format", "transform", "against", "L1", "its L1", "difference", "alpha (b*)"])
        .right(["its alpha (b*)", "views in which it is better", "L1 at 99.9 % valid"])
        .right(["its L1 at 99.9 % valid"])
        .rows(rows);
    let note = Text::from(
        "Errors in percent, difference in points with its standard error on the same fragments: negative means that the \
         transform is better. Each has its own best b* and alpha: those of least error, and in the last two columns the least \
         alpha that makes 99.9 % of the vectors valid.",
    );
    Block::section(2, "What a transform buys", table, Some(note))
}

fn circulation(tables: &QuantizationTables) -> Vec<Block> {
    let rows = tables.biases.iter().filter_map(|b| {
        let best = tables.most_valid(b)?;
        let valid = format!("{} ({})", alpha(best.alpha_999), best.target);
        Some(row![
            &b.bound,
            &b.transform,
            &b.format,
            &b.range,
            alpha(b.circulated_alpha?),
            percent(b.circulated_failure_share?),
            percent(b.circulated_l1_error?),
            alpha(b.best_alpha),
            percent(b.best_l1_error),
            alpha(b.alpha_999),
            percent(b.valid_l1_error),
            valid,
            &b.source,
        ])
    });
    let table = Table::default()
        .left(["bound"])
        .right(["transform", "format", "depths", "alpha", "invalid", "L1", "best alpha, same b*"])
        .right(["its L1", "99.9 % valid, same b*", "its L1", "99.9 % valid (best b*)"])
        .right(["source of alpha and b*"])
        .rows(rows);
    let note = Text::from(
        "Invalid vectors and errors in percent. They were chosen for arithmetic in single precision as well.",
    );
    Block::section(2, "Biases in circulation", table, Some(note))
}

fn targets(tables: &QuantizationTables) -> Vec<Block> {
    let rows = tables.biases.iter().filter(|b| b.target == "fastest").map(|b| {
        let numbers = |text: &str| -> String {
            let short = |word: &str| word.parse::<f64>().map_or(word.to_owned(), |v| format!("{v:.4}"));
            text.split(' ')
                .map(|word| word.split(':').map(short).collect::<Vec<_>>().join(":"))
                .collect::<Vec<_>>()
                .join(" ")
        };
        row![&b.bound, &b.transform, &b.format, &b.range, numbers(&b.moments), numbers(&b.distribution),]
    });
    let table = Table::default()
        .left(["bound"])
        .right(["transform", "format", "depths", "b*", "depth:weight"])
        .rows(rows);
    let note = Text::from(
        "At the alpha that 99 % of the stored vectors need, for a sample of kernels before storage.",
    );
    Block::section(2, "The b* that raises det B fastest", table, Some(note))
}

fn views(tables: &QuantizationTables) -> Vec<Block> {
    let cells = |v: &QuantizationViewRecord| {
        row![format!("{} {}", v.scene, v.view), v.fragments, v.sampled, in_percent(v.mean_reference, 1)]
    };
    let table = Table::default()
        .left(["view"])
        .right(["fragments", "evaluated", "mean F, %"])
        .rows(tables.views.iter().map(cells));
    Block::section(2, "Views", table, None)
}
