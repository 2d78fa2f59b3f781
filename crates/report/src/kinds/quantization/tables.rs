//! The tables of a quantisation experiment, each with a note on how to read it.

use super::summary::{QuantizationTables, percent};
use crate::kinds::rows::views;
use crate::page::{Block, Table, Text, code};
use evaluation::{BiasRecord, ComparisonRecord};

pub(crate) fn blocks(tables: &QuantizationTables) -> Vec<Block> {
    [
        gains(tables),
        errors(tables),
        comparisons(tables),
        circulation(tables),
        targets(tables),
        views(2, &tables.views),
    ]
    .concat()
}

/// Seven digits are more than any table's reader compares; small ones in powers of ten.
fn alpha(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

fn gains(tables: &QuantizationTables) -> Vec<Block> {
    let overshoot = |(min, max): (f64, f64)| format!("{:.0e}", (-min).max(max - 1.0).max(0.0));
    let table = Table::of(&tables.gains)
        .left("basis", |g| code(&g.basis))
        .right("transform", |g| &g.transform)
        .right("depths", |g| &g.range)
        .right("gain, bits", |g| g.gain_bits.map(|bits| format!("{bits:.5}")))
        .right("bound, bits", |g| g.bound_bits.map(|bits| format!("{:.4}", (bits * 1e4).ceil() / 1e4)))
        .right("gap", |g| g.gain_bits.zip(g.bound_bits).map(|(gain, bound)| format!("{:.4}", bound - gain)))
        .right("overshoot", |g| g.range_min.zip(g.range_max).map(overshoot))
        .right("starts at best", |g| g.starts_at_best.zip(g.starts).map(|(hits, n)| format!("{hits} of {n}")))
        .right("time, s", |g| tables.seconds(&g.basis, &g.transform).map(|s| format!("{s:.2}")));
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
    let exact = |b: &BiasRecord| tables.exact(&b.bound, &b.kernel);
    let lost = |b: &BiasRecord, error: f64| exact(b).map(|exact| format!("{:+.3}", 100.0 * (error - exact)));
    let rows = tables.best().into_iter().map(|b| (b, tables.most_valid(b).unwrap_or(b)));
    let table = Table::of(rows)
        .left("bound", |(b, _)| &b.bound)
        .right("transform", |(b, _)| &b.transform)
        .right("format", |(b, _)| &b.format)
        .right("filter", |(b, _)| &b.kernel)
        .right("bits a texel", |(b, _)| bits(b))
        .right("L1, not quantised", |(b, _)| exact(b).map(percent))
        .right("invalid, alpha 0", |(b, _)| percent(b.invalid_unbiased))
        .right("alpha of least error (b*)", |(b, _)| format!("{} ({})", alpha(b.best_alpha), b.target))
        .right("L1 added", |(b, _)| lost(b, b.best_l1_error))
        .right("change", |(b, _)| percent(b.best_change))
        .right("false shadows", |(b, _)| percent(b.best_excess_share))
        .right("invalid", |(b, _)| percent(b.best_failure_share))
        .right("alpha, 99.9 % valid (b*)", |(_, valid)| {
            format!("{} ({})", alpha(valid.alpha_999), valid.target)
        })
        .right("all valid", |(_, valid)| alpha(valid.alpha_all))
        .right("L1 added", |(b, valid)| lost(b, valid.valid_l1_error))
        .right("change", |(_, valid)| percent(valid.valid_change));
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
    let difference =
        |c: &ComparisonRecord| format!("{:+.4} ± {:.4}", 100.0 * c.difference, 100.0 * c.standard_error);
    let table = Table::of(&tables.comparison)
        .left("bound", |c| &c.bound)
        .right("format", |c| &c.format)
        .right("transform", |c| &c.transform)
        .right("against", |c| &c.baseline)
        .right("L1", |c| percent(c.l1_error))
        .right("its L1", |c| percent(c.baseline_l1_error))
        .right("difference", difference)
        .right("alpha (b*)", |c| format!("{} ({})", alpha(c.alpha), c.target))
        .right("its alpha (b*)", |c| format!("{} ({})", alpha(c.baseline_alpha), c.baseline_target))
        .right("views in which it is better", |c| format!("{} of {}", c.better_views, c.views))
        .right("L1 at 99.9 % valid", |c| valid(c, &c.transform))
        .right("its L1 at 99.9 % valid", |c| valid(c, &c.baseline));
    let note = Text::from(
        "Errors in percent, difference in points with its standard error on the same fragments: negative means that the \
         transform is better. Each has its own best b* and alpha: those of least error, and in the last two columns the least \
         alpha that makes 99.9 % of the vectors valid.",
    );
    Block::section(2, "What a transform buys", table, Some(note))
}

fn circulation(tables: &QuantizationTables) -> Vec<Block> {
    let rows = tables.biases.iter().filter_map(|b| {
        let circulated = (b.circulated_alpha?, b.circulated_failure_share?, b.circulated_l1_error?);
        Some((b, circulated, tables.most_valid(b)?))
    });
    let table = Table::of(rows)
        .left("bound", |(b, ..)| &b.bound)
        .right("transform", |(b, ..)| &b.transform)
        .right("format", |(b, ..)| &b.format)
        .right("depths", |(b, ..)| &b.range)
        .right("alpha", |(_, circulated, _)| alpha(circulated.0))
        .right("invalid", |(_, circulated, _)| percent(circulated.1))
        .right("L1", |(_, circulated, _)| percent(circulated.2))
        .right("best alpha, same b*", |(b, ..)| alpha(b.best_alpha))
        .right("its L1", |(b, ..)| percent(b.best_l1_error))
        .right("99.9 % valid, same b*", |(b, ..)| alpha(b.alpha_999))
        .right("its L1", |(b, ..)| percent(b.valid_l1_error))
        .right("99.9 % valid (best b*)", |(.., best)| format!("{} ({})", alpha(best.alpha_999), best.target))
        .right("source of alpha and b*", |(b, ..)| &b.source);
    let note = Text::from(
        "Invalid vectors and errors in percent. They were chosen for arithmetic in single precision as well.",
    );
    Block::section(2, "Biases in circulation", table, Some(note))
}

fn targets(tables: &QuantizationTables) -> Vec<Block> {
    let short = |word: &str| word.parse::<f64>().map_or(word.to_owned(), |v| format!("{v:.4}"));
    let pair = |word: &str| word.split(':').map(short).collect::<Vec<_>>().join(":");
    let numbers = |text: &str| text.split(' ').map(pair).collect::<Vec<_>>().join(" ");
    let table = Table::of(tables.biases.iter().filter(|b| b.target == "fastest"))
        .left("bound", |b| &b.bound)
        .right("transform", |b| &b.transform)
        .right("format", |b| &b.format)
        .right("depths", |b| &b.range)
        .right("b*", |b| numbers(&b.moments))
        .right("depth:weight", |b| numbers(&b.distribution));
    let note = Text::from(
        "At the alpha that 99 % of the stored vectors need, for a sample of kernels before storage.",
    );
    Block::section(2, "The b* that raises det B fastest", table, Some(note))
}
