//! The tables of a `translucent-shadows` run, each with a note on how to read it.

use super::summary::TranslucentTables;
use crate::kinds::rows::{distinct, least_ns, percent};
use crate::page::{Block, RecordedPicture, Table, Text, in_percent, row};
use evaluation::{BlendingRecord, TranslucentPicture, TranslucentRecord};

pub(super) fn blocks(tables: &TranslucentTables<'_>) -> Vec<Block> {
    [
        pictures(tables),
        errors(tables),
        scenes(tables),
        groups(tables),
        leaks(tables),
        colour(tables),
        stability(tables),
        cost(tables),
        views(tables),
    ]
    .concat()
}

fn pictured(picture: &TranslucentPicture) -> [Block; 2] {
    let title = format!("{}, view \"{}\"", picture.scene, picture.view);
    let note =
        "Smoke and glass are lit by what each method finds at their own depth. Below, parts magnified.";
    RecordedPicture::new(&picture.id, title, picture.output, &picture.techniques)
        .with_legend("the truth", note)
}

fn pictures(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let mut blocks: Vec<Block> = tables.experiment.picture.iter().flat_map(pictured).collect();
    let table = Table::of(&tables.pictures)
        .left("picture", |r| &r.picture)
        .left("technique", |r| &r.technique)
        .right("error on opaque surfaces, %", |r| percent(r.l1_error))
        .right("pixels", |r| r.pixels)
        .right("error on smoke and glass, %", |r| percent(r.veil_error))
        .right("surfaces", |r| r.veils);
    blocks.extend(Block::section(3, "The pictures in numbers", table, None));
    blocks
}

fn errors(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let all = tables.experiment.technique.iter().filter_map(|t| tables.row(&t.name, "all"));
    let mut rows: Vec<&TranslucentRecord> = all.collect();
    rows.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
    let of = |row: &TranslucentRecord, class: &str| tables.row(&row.technique, class);
    let table = Table::of(rows)
        .left("technique", |r| &r.technique)
        .right("error, %", |r| percent(r.l1_error))
        .right("standard error", |r| percent(r.standard_error))
        .right("surfaces", |r| of(r, "surfaces").map(|r| percent(r.l1_error)))
        .right("signed", |r| of(r, "surfaces").map(|r| percent(r.signed_mean)))
        .right("inside", |r| of(r, "inside").map(|r| percent(r.l1_error)))
        .right("signed", |r| of(r, "inside").map(|r| percent(r.signed_mean)))
        .right("p95", |r| in_percent(r.p95, 1))
        .right("largest", |r| in_percent(r.max_error, 1))
        .right("bits", |r| format!("{:.0}", r.bits_per_texel));
    let note = Text::from(
        "Mean |shadow - truth| in percent of the light over all views; less is better. Surfaces: opaque ones that face the light. \
         Inside: smoke and glass, shadowed by themselves, at their own depths. Signed: below 0 light leaks. The truth is the \
         kernel's mean of 1 - prod (1 - alpha) over surfaces in front of the receiver's plane, tap by tap.",
    );
    Block::section(2, "Which is closest", table, Some(note))
}

/// Each view by itself.
fn scenes(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let views: Vec<[&str; 2]> = tables.views.iter().map(|v| [v.scene.as_str(), v.view.as_str()]).collect();
    let error = |technique: &str, [scene, view]: [&str; 2]| {
        let of = |r: &&TranslucentRecord| {
            r.scene == scene && r.view == view && r.technique == technique && r.class == "all"
        };
        tables.records.iter().find(of).filter(|r| r.receivers > r.failed).map(|r| percent(r.l1_error))
    };
    let cells = |technique: &str| {
        let errors = views.iter().map(|&view| error(technique, view).into()).collect();
        [row![technique], errors].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(views.iter().map(|[scene, view]| format!("{scene} {view}")))
        .rows(tables.experiment.technique.iter().map(|t| cells(&t.name)));
    Block::section(2, "By view", table, Some(Text::from("Mean |shadow - truth| in percent; less is better.")))
}

fn groups(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (by, title) in [("layers", "By translucent layers in front"), ("opacity", "By their mean opacity")] {
        let groups: Vec<&str> =
            distinct(tables.groups.iter().filter(|g| g.by == by).map(|g| g.group.as_str()));
        let error = |technique: &str, group: &str| {
            let mut rows = tables.groups.iter();
            let of = rows.find(|g| g.by == by && g.group == group && g.technique == technique);
            of.map(|g| percent(g.l1_error))
        };
        let cells = |technique: &str| {
            let errors = groups.iter().map(|group| error(technique, group).into()).collect();
            [row![technique], errors].concat()
        };
        let table = Table::default()
            .left(["technique"])
            .right(groups.iter().map(|group| (*group).to_owned()))
            .rows(tables.experiment.technique.iter().map(|t| cells(&t.name)));
        let note = Text::from(
            "Mean |shadow - truth| in percent over all receivers of the group; less is better. Layers are those of the receiver's \
             own texel before the first opaque surface.",
        );
        blocks.extend(Block::section(2, title, table, Some(note)));
    }
    blocks
}

fn leaks(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let rows = tables.experiment.technique.iter().filter_map(|t| tables.row(&t.name, "all"));
    let table = Table::of(rows)
        .left("technique", |r| &r.technique)
        .right("leak, %", |r| percent(r.leak))
        .right("receivers that leak, %", |r| in_percent(r.leak_share, 1))
        .right("overshoot, %", |r| percent(r.overshoot))
        .right("receivers above, %", |r| in_percent(r.above_share, 1))
        .right("outside of [0, 1], %", |r| in_percent(r.outside_share, 1))
        .right("farthest", |r| in_percent(r.outside_most, 1));
    let note = Text::from(
        "Against the kernel's mean shadow at the depth that techniques compare, so that nothing but the method differs. Leak and \
         overshoot are means of what is missing and of what is too much; receivers count from 1 % on. Outside: answers that had to \
         be moved into [0, 1], which is how ringing shows.",
    );
    Block::section(2, "Leaking and ringing", table, Some(note))
}

fn colour(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.colour)
        .left("scene", |r| format!("{} {}", r.scene, r.view))
        .left("technique", |r| &r.technique)
        .left("light", |r| &r.channel)
        .right("a map a channel, %", |r| percent(r.l1_error))
        .right("one map for all, %", |r| percent(r.one_map_error))
        .right("mean truth, %", |r| in_percent(r.mean_truth, 1));
    let note = Text::from("Mean |shadow - truth| in light of one colour; one map holds the luminance.");
    Block::section(2, "Coloured glass", table, Some(note))
}

fn stability(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let Some(setting) = &tables.experiment.stability else { return Vec::new() };
    let table = Table::of(tables.stability.iter().filter(|r| r.layers > 1 || setting.layers.len() == 1))
        .left("bound", |r| &r.bound)
        .left("format", |r| &r.format)
        .left("depths", |r| &r.case)
        .right("opacity", |r| r.opacity.to_string())
        .right("layers", |r| r.layers)
        .right("invalid, no bias, %", |r| share(r, r.invalid_unbiased))
        .right(format!("invalid, alpha {:.0e}, %", setting.alpha), |r| share(r, r.invalid))
        .right("smallest alpha", |r| r.smallest_alpha.map(|alpha| format!("{alpha:.1e}")))
        .right("largest error, steps of 1/65535", |r| format!("{:.1}", r.largest_error));
    let note = Text::from(
        "Random texels whose layers are blended back to front, rounded to the format after each. Invalid: moments of no \
         distribution. Smallest alpha: the least of the moment biases with which every texel is valid. Eight bits: opacities \
         rounded to 1/255.",
    );
    Block::section(2, "How many layers a format carries", table, Some(note))
}

fn share(record: &BlendingRecord, count: usize) -> String {
    in_percent(count as f64 / record.trials.max(1) as f64, 1)
}

fn cost(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.cost)
        .left("technique", |c| &c.technique)
        .right("error, %", |c| tables.row(&c.technique, "all").map(|r| percent(r.l1_error)))
        .right("bytes a texel", |c| format!("{:.0}", c.bytes_per_texel))
        .right("bytes a surface drawn", |c| format!("{:.0}", c.bytes_per_layer))
        .right("operations a surface drawn", |c| format!("{:.0}", c.operations_per_layer))
        .right("operations a receiver", |c| format!("{:.0}", c.operations_per_receiver))
        .right("filter, ns a texel", |c| least_ns(&tables.samples, &c.technique, "filter"))
        .right("shade, ns a receiver", |c| least_ns(&tables.samples, &c.technique, "shade"))
        .left("in order", |c| if c.ordered { "yes" } else { "no" });
    let layers = tables.cost.first().map_or(0.0, |cost| cost.layers);
    let note = Text::from(format!(
        "Bytes and operations are modelled; times are the least of the recorded repetitions on one core and hold drawing, \
         blending and filtering of the whole map apart from the answers. On the first view {layers:.2} surfaces are drawn into a texel on average. Blending reads and \
         writes a texel; a division, root or elementary function counts as four operations. Methods of samples and layers compare \
         at each tap of the kernel, the others read one filtered texel."
    ));
    Block::section(2, "Cost", table, Some(note))
}

fn views(tables: &TranslucentTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.views)
        .left("view", |v| format!("{} {}", v.scene, v.view))
        .right("stack entries", |v| v.stack_entries)
        .right("translucent", |v| v.translucent_entries)
        .right("mean layers", |v| format!("{:.2}", v.mean_layers))
        .right("most layers", |v| v.layers)
        .right("opaque receivers", |v| v.surfaces)
        .right("translucent receivers", |v| v.inside)
        .right("evaluated", |v| v.sampled)
        .right("mean truth, %", |v| in_percent(v.mean_truth, 1))
        .right("partly in shadow, %", |v| in_percent(v.partial, 1));
    Block::section(2, "Views", table, None)
}
