//! The tables of a `filterable` experiment in Markdown.

use crate::filterable_order;
use crate::filterable_summary::Tables;
use evaluation::{DepthBias, FilterableExperiment};
use std::fmt::Write as _;

/// All tables, each with a sentence on how to read it.
pub(crate) fn markdown(experiment: &FilterableExperiment, tables: &Tables) -> String {
    let parts = [
        errors(tables),
        filterable_order::markdown(experiment, tables),
        by_class(tables),
        by_view(tables),
        by_bias(experiment, tables),
        agreement(tables),
        cost(tables),
        views(tables),
    ];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n")
}

pub(crate) fn percent(value: f64) -> String {
    format!("{:.2}", 100.0 * value)
}

/// Header, alignment (all but the first column to the right) and rows.
pub(crate) fn table(heading: &str, header: &[String], rows: &[Vec<String>]) -> String {
    let mut text =
        format!("## {heading}\n\n| {} |\n|---|{}\n", header.join(" | "), "--:|".repeat(header.len() - 1));
    for row in rows {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text
}

fn errors(tables: &Tables) -> String {
    let header = [
        "technique",
        "bits a texel",
        "L1 error",
        "standard error",
        "signed mean",
        "RMS",
        "p95",
        "maximum",
        "share above F",
        "leak",
        "violations",
        "fragments",
    ]
    .map(str::to_owned);
    let rows: Vec<Vec<String>> = tables
        .pooled(0)
        .into_iter()
        .map(|r| {
            vec![
                r.technique.clone(),
                r.bits_per_texel.to_string(),
                percent(r.l1_error),
                r.standard_error.map_or("-".to_owned(), percent),
                percent(r.signed_mean),
                percent(r.rms),
                percent(r.p95),
                percent(r.maximum),
                percent(r.share_above),
                percent(r.leak),
                r.unbiased_violations.map_or("-".to_owned(), |count| count.to_string()),
                r.fragments.to_string(),
            ]
        })
        .collect();
    let mut text = table("Errors over all views", &header, &rows);
    text.push_str(
        "\nAll in percent of shadow intensity. L1 error: mean |G - F|. Signed mean: below 0 light leaks, above 0 \
         shadows fall where none belong. Leak: mean of PCF minus G where both compare the same depth, so that no bias \
         and no receiver plane enters. Violations: fragments at which a lower bound exceeds PCF of the same depth by \
         more than 1e-6. Bits are those of 32-bit channels unless the name says otherwise; computation is in f64.\n",
    );
    text
}

const CLASSES: [&str; 4] = ["1", "2", "3", "4+"];

fn by_class(tables: &Tables) -> String {
    let pooled = tables.pooled(0);
    let Some(most) = pooled.iter().max_by_key(|r| r.fragments) else { return String::new() };
    let share = |class: &str| {
        let count = tables.row(("all", "all"), &most.technique, 0, class).map_or(0, |r| r.fragments);
        count as f64 / most.fragments.max(1) as f64
    };
    let mut header = vec!["technique".to_owned()];
    for class in CLASSES {
        header.push(format!(
            "{class} surface{} ({:.0} %)",
            if class == "1" { "" } else { "s" },
            100.0 * share(class)
        ));
    }
    header.extend(CLASSES.iter().map(|class| format!("leak, {class}")));
    let rows: Vec<Vec<String>> = pooled
        .iter()
        .map(|r| {
            let mut row = vec![r.technique.clone()];
            let of = |class: &&str| tables.row(("all", "all"), &r.technique, 0, class);
            row.extend(CLASSES.iter().map(|class| of(class).map_or("-".to_owned(), |r| percent(r.l1_error))));
            row.extend(CLASSES.iter().map(|class| of(class).map_or("-".to_owned(), |r| percent(r.leak))));
            row
        })
        .collect();
    let mut text = table("Depth complexity", &header, &rows);
    text.push_str(
        "\nL1 error and leak in percent, by the number of surfaces in the kernel: groups of depths without a gap that \
         their planes' slopes do not explain. In brackets the share of fragments. One tilted surface shadows itself in PCF of \
         a single depth; a bound that does not follow has a leak there and yet less error.\n",
    );
    text
}

fn by_view(tables: &Tables) -> String {
    if tables.views.len() < 2 {
        return String::new();
    }
    let mut groups: Vec<(String, String)> = Vec::new();
    for view in &tables.views {
        groups.push((view.scene.clone(), view.view.clone()));
    }
    let mut scenes: Vec<&String> = tables.views.iter().map(|view| &view.scene).collect();
    scenes.dedup();
    groups.extend(scenes.into_iter().map(|scene| (scene.clone(), "all".to_owned())));
    let mut header = vec!["technique".to_owned()];
    header.extend(groups.iter().map(|(scene, view)| format!("{scene} {view}")));
    let rows: Vec<Vec<String>> = tables
        .pooled(0)
        .iter()
        .map(|r| {
            let mut row = vec![r.technique.clone()];
            row.extend(groups.iter().map(|(scene, view)| {
                let record = tables.row((scene, view), &r.technique, 0, "all");
                record.map_or("-".to_owned(), |r| percent(r.l1_error))
            }));
            row
        })
        .collect();
    table("L1 error by view, in percent", &header, &rows)
}

fn by_bias(experiment: &FilterableExperiment, tables: &Tables) -> String {
    if experiment.bias.len() < 2 {
        return String::new();
    }
    let mut header = vec!["technique".to_owned()];
    header.extend(experiment.bias.iter().map(|b| {
        let of = |bias: &DepthBias| format!("{} + {} s", bias.texels, bias.slopes);
        format!("F: {}; G: {}", of(&b.reference), of(&b.technique))
    }));
    let rows: Vec<Vec<String>> = tables
        .pooled(0)
        .iter()
        .map(|r| {
            let mut row = vec![r.technique.clone()];
            row.extend((0..experiment.bias.len()).map(|bias| {
                let record = tables.row(("all", "all"), &r.technique, bias, "all");
                record.map_or("-".to_owned(), |r| percent(r.l1_error))
            }));
            row
        })
        .collect();
    let mut text = table("L1 error by depth bias, in percent", &header, &rows);
    text.push_str(
        "\nThe bias of F and of the techniques: texel depths plus multiples of the receiver's slope s = |g_x| + |g_y|. A \
         texel depth is the step from texel to texel of a plane at 45 degrees to the light. F has its receiver plane on \
         top. All tables above are for the first bias.\n",
    );
    text
}

fn agreement(tables: &Tables) -> String {
    let rows: Vec<Vec<String>> = tables
        .agreements()
        .into_iter()
        .map(|a| {
            vec![a.technique, a.fragments.to_string(), format!("{:.1e}", a.largest), a.failed.to_string()]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let header = ["closed form", "fragments", "largest disagreement", "failed programs"].map(str::to_owned);
    table("Closed forms against the certified linear program", &header, &rows)
}

fn cost(tables: &Tables) -> String {
    let mut rows = Vec::new();
    for r in tables.pooled(0) {
        let Some(shade) = tables.least_time(&r.technique, "shade") else { continue };
        let filter = tables.least_time(&r.technique, "filter");
        rows.push(vec![
            r.technique.clone(),
            filter.map_or("-".to_owned(), |ns| format!("{ns:.0}")),
            format!("{shade:.0}"),
        ]);
    }
    let header = ["technique", "encode and filter, ns a texel", "shade, ns a fragment"].map(str::to_owned);
    let mut text = table("Time on one core", &header, &rows);
    text.push_str("\nf64, the least of the recorded repetitions on the first view.\n");
    text
}

fn views(tables: &Tables) -> String {
    let header = [
        "view",
        "stack entries",
        "layers",
        "fragments",
        "evaluated",
        "texel depth",
        "median slope",
        "mean F, %",
        "clamped",
    ]
    .map(str::to_owned);
    let rows: Vec<Vec<String>> = tables
        .views
        .iter()
        .map(|v| {
            vec![
                format!("{} {}", v.scene, v.view),
                v.stack_entries.to_string(),
                v.layers.to_string(),
                v.fragments.to_string(),
                v.sampled.to_string(),
                format!("{:.5}", v.texel_depth),
                format!("{:.5}", v.median_slope),
                format!("{:.1}", 100.0 * v.mean_reference),
                v.clamped_depths.to_string(),
            ]
        })
        .collect();
    table("Views", &header, &rows)
}
