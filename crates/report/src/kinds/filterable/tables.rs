//! The tables of a `filterable` experiment, each with a note on how to read it.

use super::order;
use super::summary::FilterableTables;
use crate::kinds::rows::{distinct, least_ns, least_time, percent, views};
use crate::page::{Block, Table, Text, in_percent, row};
use evaluation::{DepthBias, FilterableRecord};

pub(crate) fn blocks(tables: &FilterableTables<'_>) -> Vec<Block> {
    [
        errors(tables),
        order::blocks(tables),
        by_class(tables),
        by_view(tables),
        by_bias(tables),
        agreement(tables),
        cost(tables),
        views(2, &tables.views),
        tables.level().blocks(2),
    ]
    .concat()
}

fn l1_error(record: &FilterableRecord) -> String {
    percent(record.l1_error)
}

fn errors(tables: &FilterableTables<'_>) -> Vec<Block> {
    let table = Table::of(tables.pooled(0))
        .left("technique", |r| &r.technique)
        .right("bits a texel", |r| r.bits_per_texel)
        .right("L1 error", l1_error)
        .right("standard error", |r| r.standard_error.map(percent))
        .right("relative", |r| r.relative_error.map(percent))
        .right("its standard error", |r| r.relative_standard_error.map(percent))
        .right("signed mean", |r| percent(r.signed_mean))
        .right("RMS", |r| percent(r.rms))
        .right("p95", |r| percent(r.p95))
        .right("maximum", |r| percent(r.maximum))
        .right("share above F", |r| percent(r.share_above))
        .right("leak", |r| percent(r.leak))
        .right("violations", |r| r.unbiased_violations)
        .right("fragments", |r| r.fragments);
    let note = Text::from(
        "All in percent of shadow intensity. L1 error: mean |G - F|; techniques that were evaluated on fewer fragments stand \
         last, as means over other fragments have no order. Relative: the sum of |G - F| over that of F, which is what \
         calling every fragment lit errs by; ground in the light does not dilute it, and at 100 a technique is of no use. Signed mean: below 0 light leaks, above 0 \
         shadows fall where none belong. Leak: mean of PCF minus G where both compare the same depth, so that no bias \
         and no receiver plane enters. Violations: fragments at which a lower bound exceeds PCF of the same depth by \
         more than 1e-6. Bits are those of 32-bit channels unless the name says otherwise; computation is in f64.",
    );
    Block::section(2, "Errors over all views", table, Some(note))
}

const CLASSES: [&str; 4] = ["1", "2", "3", "4+"];

fn by_class(tables: &FilterableTables<'_>) -> Vec<Block> {
    let pooled = tables.pooled(0);
    let Some(most) = pooled.iter().max_by_key(|r| r.fragments) else { return Vec::new() };
    let of = |technique: &str, class: &str| tables.row(("all", "all"), technique, 0, class);
    let share = |class: &str| {
        let count = of(&most.technique, class).map_or(0, |r| r.fragments);
        count as f64 / most.fragments.max(1) as f64
    };
    let surfaces = |class: &str| {
        let plural = if class == "1" { "" } else { "s" };
        format!("{class} surface{plural} ({} %)", in_percent(share(class), 0))
    };
    let cells = |r: &&FilterableRecord| {
        let error = |class: &&str| of(&r.technique, class).map(l1_error).into();
        let leak = |class: &&str| of(&r.technique, class).map(|r| percent(r.leak)).into();
        [row![&r.technique], CLASSES.iter().map(error).collect(), CLASSES.iter().map(leak).collect()].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(CLASSES.map(surfaces))
        .right(CLASSES.map(|class| format!("leak, {class}")))
        .rows(pooled.iter().map(cells));
    let note = Text::from(
        "L1 error and leak in percent, by the number of surfaces in the kernel: groups of depths without a gap that \
         their planes' slopes do not explain. In brackets the share of fragments. One tilted surface shadows itself in PCF of \
         a single depth; a bound that does not follow has a leak there and yet less error.",
    );
    Block::section(2, "Depth complexity", table, Some(note))
}

fn by_view(tables: &FilterableTables<'_>) -> Vec<Block> {
    if tables.views.len() < 2 {
        return Vec::new();
    }
    let views = tables.views.iter().map(|view| (view.scene.as_str(), view.view.as_str()));
    let scenes = distinct(tables.views.iter().map(|view| view.scene.as_str()));
    let groups: Vec<(&str, &str)> = views.chain(scenes.into_iter().map(|scene| (scene, "all"))).collect();
    let cells = |r: &FilterableRecord| {
        let error = |&place: &(&str, &str)| tables.row(place, &r.technique, 0, "all").map(l1_error).into();
        [row![&r.technique], groups.iter().map(error).collect()].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(groups.iter().map(|(scene, view)| format!("{scene} {view}")))
        .rows(tables.pooled(0).into_iter().map(cells));
    Block::section(2, "L1 error by view, in percent", table, None)
}

fn by_bias(tables: &FilterableTables<'_>) -> Vec<Block> {
    let experiment = tables.experiment;
    if experiment.bias.len() < 2 {
        return Vec::new();
    }
    let names = experiment.bias.iter().map(|b| {
        let of = |bias: &DepthBias| format!("{} + {} s", bias.texels, bias.slopes);
        format!("F: {}; G: {}", of(&b.reference), of(&b.technique))
    });
    let cells = |r: &FilterableRecord| {
        let error = |bias| tables.row(("all", "all"), &r.technique, bias, "all").map(l1_error).into();
        [row![&r.technique], (0..experiment.bias.len()).map(error).collect()].concat()
    };
    let table =
        Table::default().left(["technique"]).right(names).rows(tables.pooled(0).into_iter().map(cells));
    let note = Text::from(
        "The bias of F and of the techniques: texel depths plus multiples of the receiver's slope s = |g_x| + |g_y|. A \
         texel depth is the step from texel to texel of a plane at 45 degrees to the light. F has its receiver plane on \
         top. All tables above are for the first bias.",
    );
    Block::section(2, "L1 error by depth bias, in percent", table, Some(note))
}

fn agreement(tables: &FilterableTables<'_>) -> Vec<Block> {
    let agreements = tables.agreements();
    let table = Table::of(&agreements)
        .left("closed form", |a| &a.technique)
        .right("fragments", |a| a.fragments)
        .right("largest disagreement", |a| format!("{:.1e}", a.largest))
        .right("failed programs", |a| a.failed);
    Block::section(2, "Closed forms against the certified linear program", table, None)
}

fn cost(tables: &FilterableTables<'_>) -> Vec<Block> {
    let time = |technique: &str, stage| least_ns(&tables.samples, technique, stage);
    let is_timed = |r: &&FilterableRecord| least_time(&tables.samples, &r.technique, "shade").is_some();
    let table = Table::of(tables.pooled(0).into_iter().filter(is_timed))
        .left("technique", |r| &r.technique)
        .right("encode and filter, ns a texel", |r| time(&r.technique, "filter"))
        .right("shade, ns a fragment", |r| time(&r.technique, "shade"));
    let note = Text::from("f64, the least of the recorded repetitions on the first view.");
    Block::section(2, "Time on one core", table, Some(note))
}
