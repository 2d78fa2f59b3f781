//! The tables of a quantisation experiment in Markdown.

use crate::filterable_tables::table;
use crate::quantization_summary::QuantizationTables;
use evaluation::{BiasRecord, ComparisonRecord};

/// All tables, each with a sentence on how to read it.
pub(crate) fn markdown(tables: &QuantizationTables) -> String {
    let parts = [
        gains(tables),
        errors(tables),
        comparisons(tables),
        circulation(tables),
        targets(tables),
        views(tables),
    ];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n")
}

fn percent(value: f64) -> String {
    format!("{:.3}", 100.0 * value)
}

fn words(header: &[&str]) -> Vec<String> {
    header.iter().map(|&word| word.to_owned()).collect()
}

fn dash(value: Option<String>) -> String {
    value.unwrap_or_else(|| "-".to_owned())
}

/// Seven digits are more than any table's reader compares; small ones in powers of ten.
fn alpha(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") }
}

fn gains(tables: &QuantizationTables) -> String {
    let rows: Vec<Vec<String>> = tables
        .gains
        .iter()
        .map(|g| {
            let overshoot = |min: f64, max: f64| format!("{:.0e}", (-min).max(max - 1.0).max(0.0));
            vec![
                format!("`{}`", g.basis),
                g.transform.clone(),
                g.range.clone(),
                dash(g.gain_bits.map(|bits| format!("{bits:.5}"))),
                dash(g.bound_bits.map(|bits| format!("{:.4}", (bits * 1e4).ceil() / 1e4))),
                dash(g.gain_bits.zip(g.bound_bits).map(|(gain, bound)| format!("{:.4}", bound - gain))),
                dash(g.range_min.zip(g.range_max).map(|(min, max)| overshoot(min, max))),
                dash(g.starts_at_best.zip(g.starts).map(|(hits, starts)| format!("{hits} of {starts}"))),
                dash(tables.seconds(&g.basis, &g.transform).map(|s| format!("{s:.2}"))),
            ]
        })
        .collect();
    let header = [
        "basis",
        "transform",
        "depths",
        "gain, bits",
        "bound, bits",
        "gap",
        "overshoot",
        "starts at best",
        "time, s",
    ];
    let mut text = table("Gains", &words(&header), &rows);
    text.push_str(
        "\nGain: log2 |det theta| in units of depths in [0, 1]; more is better. Bound: no transform gains more, proved. \
         Overshoot: how far stored values can leave [0, 1], proved. Starts at best: random starts of the search that came \
         to the same gain. Time with all threads of the run, proof included.\n",
    );
    text
}

fn errors(tables: &QuantizationTables) -> String {
    let bits = |b: &BiasRecord| {
        let of = tables.records.iter().find(|r| {
            (&r.bound, &r.transform, &r.format, &r.kernel) == (&b.bound, &b.transform, &b.format, &b.kernel)
        });
        dash(of.map(|r| r.bits_per_texel.to_string()))
    };
    let rows: Vec<Vec<String>> = tables
        .best()
        .into_iter()
        .map(|b| {
            let exact = tables.exact(&b.bound, &b.kernel);
            let lost = |error: f64| dash(exact.map(|exact| format!("{:+.3}", 100.0 * (error - exact))));
            let valid = tables.most_valid(b).unwrap_or(b);
            vec![
                b.bound.clone(),
                b.transform.clone(),
                b.format.clone(),
                b.kernel.clone(),
                bits(b),
                dash(exact.map(percent)),
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
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let header = [
        "bound",
        "transform",
        "format",
        "filter",
        "bits a texel",
        "L1, not quantised",
        "invalid, alpha 0",
        "alpha of least error (b*)",
        "L1 added",
        "change",
        "false shadows",
        "invalid",
        "alpha, 99.9 % valid (b*)",
        "all valid",
        "L1 added",
        "change",
    ];
    let mut text = table("Error by format", &words(&header), &rows);
    text.push_str(
        "\nErrors and shares in percent; less is better. L1 added: mean |G - F| minus that of the same bound without \
         quantisation. Change: mean distance of G from the same bound without quantisation. False shadows: share of \
         fragments with G more than 1/255 above PCF of the same depth, which no lower bound exceeds. Invalid: moment \
         vectors whose moment matrix is not positive definite after the bias. Two biases are shown for each format: that \
         of least error, and the least that makes 99.9 % of the vectors valid, each with the b* that serves it best. \
         Values are rounded when stored and after each of the two filter passes; all else is computed in f64. For \
         Hausdorff 4 validity means the same matrix, not the constraints of the interval.\n",
    );
    text
}

fn comparisons(tables: &QuantizationTables) -> String {
    // The least error among transforms that keep nearly all vectors valid.
    let valid = |c: &ComparisonRecord, transform: &str| {
        let same = |b: &&BiasRecord| {
            (b.bound.as_str(), b.format.as_str(), b.transform.as_str()) == (&c.bound, &c.format, transform)
        };
        let bias = tables.biases.iter().find(same).and_then(|b| tables.most_valid(b));
        dash(bias.map(|b| format!("{} at {}", percent(b.valid_l1_error), alpha(b.alpha_999))))
    };
    let rows: Vec<Vec<String>> = tables
        .comparisons
        .iter()
        .map(|c| {
            vec![
                c.bound.clone(),
                c.format.clone(),
                c.transform.clone(),
                c.baseline.clone(),
                percent(c.l1_error),
                percent(c.baseline_l1_error),
                format!("{:+.4} ± {:.4}", 100.0 * c.difference, 100.0 * c.standard_error),
                format!("{} ({})", alpha(c.alpha), c.target),
                format!("{} ({})", alpha(c.baseline_alpha), c.baseline_target),
                format!("{} of {}", c.better_views, c.views),
                valid(c, &c.transform),
                valid(c, &c.baseline),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let header = [
        "bound",
        "format",
        "transform",
        "against",
        "L1",
        "its L1",
        "difference",
        "alpha (b*)",
        "its alpha (b*)",
        "views in which it is better",
        "L1 at 99.9 % valid",
        "its L1 at 99.9 % valid",
    ];
    let mut text = table("What a transform buys", &words(&header), &rows);
    text.push_str(
        "\nErrors in percent, difference in points with its standard error on the same fragments: negative means that the \
         transform is better. Each has its own best b* and alpha: those of least error, and in the last two columns the least \
         alpha that makes 99.9 % of the vectors valid.\n",
    );
    text
}

fn circulation(tables: &QuantizationTables) -> String {
    let rows: Vec<Vec<String>> = tables
        .biases
        .iter()
        .filter_map(|b| {
            let best = tables.most_valid(b)?;
            let valid = format!("{} ({})", alpha(best.alpha_999), best.target);
            Some(vec![
                b.bound.clone(),
                b.transform.clone(),
                b.format.clone(),
                b.range.clone(),
                alpha(b.circulated_alpha?),
                percent(b.circulated_failure_share?),
                percent(b.circulated_l1_error?),
                alpha(b.best_alpha),
                percent(b.best_l1_error),
                alpha(b.alpha_999),
                percent(b.valid_l1_error),
                valid,
                b.source.clone(),
            ])
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let header = [
        "bound",
        "transform",
        "format",
        "depths",
        "alpha",
        "invalid",
        "L1",
        "best alpha, same b*",
        "its L1",
        "99.9 % valid, same b*",
        "its L1",
        "99.9 % valid (best b*)",
        "source of alpha and b*",
    ];
    let mut text = table("Biases in circulation", &words(&header), &rows);
    text.push_str("\nInvalid vectors and errors in percent. They were chosen for arithmetic in single precision as well.\n");
    text
}

fn targets(tables: &QuantizationTables) -> String {
    let rows: Vec<Vec<String>> = tables
        .biases
        .iter()
        .filter(|b| b.target == "fastest")
        .map(|b| {
            let numbers = |text: &str| -> String {
                let short = |word: &str| word.parse::<f64>().map_or(word.to_owned(), |v| format!("{v:.4}"));
                text.split(' ')
                    .map(|word| word.split(':').map(short).collect::<Vec<_>>().join(":"))
                    .collect::<Vec<_>>()
                    .join(" ")
            };
            vec![
                b.bound.clone(),
                b.transform.clone(),
                b.format.clone(),
                b.range.clone(),
                numbers(&b.moments),
                numbers(&b.distribution),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let header = ["bound", "transform", "format", "depths", "b*", "depth:weight"];
    let mut text = table("The b* that raises det B fastest", &words(&header), &rows);
    text.push_str(
        "\nAt the alpha that 99 % of the stored vectors need, for a sample of kernels before storage.\n",
    );
    text
}

fn views(tables: &QuantizationTables) -> String {
    let rows: Vec<Vec<String>> = tables
        .views
        .iter()
        .map(|v| {
            vec![
                format!("{} {}", v.scene, v.view),
                v.fragments.to_string(),
                v.sampled.to_string(),
                format!("{:.1}", 100.0 * v.mean_reference),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    table("Views", &words(&["view", "fragments", "evaluated", "mean F, %"]), &rows)
}
