//! The tables of a `soft-shadows` run, each with a note on how to read it.

use super::summary::SoftTables;
use super::sweeps;
use crate::kinds::rows::{distinct, least_ns, millions_a_second, percent, timed};
use crate::page::{Block, RecordedPicture, Table, Text, in_percent, row};
use evaluation::{DepthBias, Population, SoftPicture, SoftRecord};

pub(super) fn blocks(tables: &SoftTables<'_>) -> Vec<Block> {
    [
        pictures(tables),
        errors(tables),
        by_class(tables, "width", "Width of the penumbra"),
        by_class(tables, "layers", "Occluding layers"),
        by_view(tables),
        by_bias(tables),
        sweeps::blocks(tables),
        truth(tables),
        cost(tables),
        tables.gpu_blocks(),
    ]
    .concat()
}

fn pictured(picture: &SoftPicture) -> [Block; 2] {
    let view = if picture.view.is_empty() { "first view" } else { &picture.view };
    let title = format!("{}, {view}, light \"{}\"", picture.scene, picture.light);
    let note = "Each method under its best depth bias; below, parts magnified.";
    RecordedPicture::new(&picture.id, title, picture.size(), &picture.techniques)
        .with_legend("the area light by shadow rays", note)
}

fn pictures(tables: &SoftTables<'_>) -> Vec<Block> {
    let mut blocks: Vec<Block> = tables.experiment.picture.iter().flat_map(pictured).collect();
    let table = Table::of(&tables.pictures)
        .left("picture", |r| &r.picture)
        .left("technique", |r| &r.technique)
        .right("error, %", |r| percent(r.mean_error))
        .right("roughness, %", |r| percent(r.roughness))
        .right("pixels", |r| r.pixels);
    let note = Text::from(
        "Error: mean |method - truth| of pixels that face the light. Roughness: mean difference of the errors of neighbouring \
         pixels in penumbrae, where the truth is smooth: stripes, blocks and noise; the truth's own error makes about 0.3.",
    );
    blocks.extend(Block::section(3, "The pictures in numbers", table, Some(note)));
    blocks
}

fn errors(tables: &SoftTables<'_>) -> Vec<Block> {
    let mut blocks = vec![Block::heading(2, "Errors over all views")];
    for light in tables.lights() {
        let mut rows: Vec<&SoftRecord> = tables
            .experiment
            .technique
            .iter()
            .filter_map(|technique| tables.whole(light, Population::Fragments, &technique.name))
            .collect();
        rows.sort_by(|a, b| a.mean_error.total_cmp(&b.mean_error));
        let camera = |r: &SoftRecord| tables.whole(light, Population::Camera, &r.technique);
        let bias = |r: &SoftRecord| {
            let bias = tables.experiment.bias.get(r.bias);
            bias.map(|DepthBias { texels, slopes }| format!("{texels} + {slopes} s"))
        };
        let table = Table::of(rows)
            .left("technique", |r| &r.technique)
            .right("bits a texel", |r| r.bits_per_texel)
            .right("fragments, %", |r| percent(r.mean_error))
            .right("standard error", |r| r.standard_error.map(percent))
            .right("signed", |r| percent(r.signed_mean))
            .right("p95", |r| in_percent(r.p95, 1))
            .right("from the first", |r| percent(r.mean_to_first))
            .right("camera, %", |r| camera(r).map(|r| percent(r.mean_error)))
            .right("signed", |r| camera(r).map(|r| percent(r.signed_mean)))
            .right("p95", |r| camera(r).map(|r| in_percent(r.p95, 1)))
            .right("from the first", |r| camera(r).map(|r| percent(r.mean_to_first)))
            .right("bias", bias)
            .right("failed", |r| r.failed);
        blocks.extend(Block::section(3, &format!("Light \"{light}\""), table, None));
    }
    blocks.push(Block::paragraph(format!(
        "All in percent of the light; less is better. Error: mean |method - truth|, on the light-facing fragments of the stack \
         and on what the camera sees. Signed: below 0 light leaks, above 0 shadows fall where none belong. From the first: mean \
         distance from {}. Bias: the depth bias in texel depths and slopes s of the receiver with which the method is best, \
         fragments and pixels weighing alike. Every method knows the light; those with a size in their name look no further than that.",
        tables.experiment.technique[0].name
    )));
    blocks
}

fn by_class(tables: &SoftTables<'_>, group: &str, heading: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    for light in tables.lights() {
        let of = |technique: &str, class: &str| {
            tables.pooled((light, Population::Fragments), technique, (group, class))
        };
        let first = &tables.experiment.technique[0].name;
        let all = tables.records.iter().filter(|r| r.group == group).map(|r| r.class.as_str());
        let classes: Vec<&str> = distinct(all)
            .into_iter()
            .filter(|class| of(first, class).is_some_and(|r| r.receivers > 0))
            .collect();
        let total: usize = classes.iter().filter_map(|class| of(first, class)).map(|r| r.receivers).sum();
        let name = |class: &&str| {
            let count = of(first, class).map_or(0, |r| r.receivers);
            format!("{class} ({} %)", in_percent(count as f64 / total.max(1) as f64, 0))
        };
        let cells = |technique: &str| {
            let error = |class: &&str| of(technique, class).map(|r| percent(r.mean_error)).into();
            let signed = |class: &&str| of(technique, class).map(|r| percent(r.signed_mean)).into();
            let (errors, signs) = (classes.iter().map(error).collect(), classes.iter().map(signed).collect());
            [row![technique], errors, signs].concat()
        };
        let table = Table::default()
            .left(["technique"])
            .right(classes.iter().map(name))
            .right(classes.iter().map(|class| format!("signed, {class}")))
            .rows(tables.experiment.technique.iter().map(|technique| cells(&technique.name)));
        blocks.extend(Block::section(3, &format!("Light \"{light}\""), table, None));
    }
    if blocks.is_empty() {
        return blocks;
    }
    let note = if group == "width" {
        "Error and signed mean in percent over fragments by the width in texels of the filter that percentage-closer soft \
         shadows take; lit: their search finds no blocker. In brackets the share of fragments."
    } else {
        "Error and signed mean in percent over fragments by the largest number of light-facing surfaces in front of the \
         fragment above any texel of that filter. Two and more are fused to one by every method. In brackets the share of \
         fragments."
    };
    [vec![Block::heading(2, heading)], blocks, vec![Block::paragraph(note)]].concat()
}

fn by_view(tables: &SoftTables<'_>) -> Vec<Block> {
    let Some(light) = tables.widest() else { return Vec::new() };
    let of_light = tables.views.iter().filter(|v| v.light == light);
    let views = distinct(of_light.map(|view| (view.scene.as_str(), view.view.as_str())));
    let find = |technique: &str, (scene, view): (&str, &str)| {
        tables.records.iter().find(|r| {
            let of = r.light == light && r.population == Population::Fragments && r.group == "all";
            of && r.best && r.technique == technique && r.scene == scene && r.view == view
        })
    };
    let cells = |technique: &str| {
        let error = |&place: &(&str, &str)| find(technique, place).map(|r| percent(r.mean_error)).into();
        [row![technique], views.iter().map(error).collect()].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(views.iter().map(|(scene, view)| format!("{scene} {view}")))
        .rows(tables.experiment.technique.iter().map(|technique| cells(&technique.name)));
    Block::section(2, &format!("Error by view, light \"{light}\", in percent of fragments"), table, None)
}

fn by_bias(tables: &SoftTables<'_>) -> Vec<Block> {
    let biases = &tables.experiment.bias;
    if biases.len() < 2 {
        return Vec::new();
    }
    let lights: Vec<&str> = tables.lights().collect();
    let columns: Vec<(&str, usize)> =
        lights.iter().flat_map(|&light| (0..biases.len()).map(move |bias| (light, bias))).collect();
    let find = |technique: &str, (light, bias): (&str, usize)| {
        tables.records.iter().find(|r| {
            let of = r.light == light && r.population == Population::Fragments && r.group == "all";
            of && r.scene == "all" && r.bias == bias && r.technique == technique
        })
    };
    let cells = |technique: &str| {
        let error = |&column: &(&str, usize)| find(technique, column).map(|r| percent(r.mean_error)).into();
        [row![technique], columns.iter().map(error).collect()].concat()
    };
    let name = |&(light, bias): &(&str, usize)| {
        let DepthBias { texels, slopes } = biases[bias];
        format!("{light}: {texels} + {slopes} s")
    };
    let table = Table::default()
        .left(["technique"])
        .right(columns.iter().map(name))
        .rows(tables.experiment.technique.iter().map(|technique| cells(&technique.name)));
    let note = Text::from(
        "Biases in texel depths (what a plane at 45 degrees to the light gains from texel to texel) and in slopes s = |g_x| + \
         |g_y| of the receiver. A filter of width w sees a slope of w s / 2.",
    );
    Block::section(2, "Error by depth bias, in percent of fragments", table, Some(note))
}

fn truth(tables: &SoftTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.views)
        .left("view", |v| format!("{} {}", v.scene, v.view))
        .left("light", |v| format!("{}, {}", v.light, v.shape))
        .left("receivers", |v| if v.population == Population::Camera { "camera" } else { "fragments" })
        .right("all", |v| v.all)
        .right("evaluated", |v| v.sampled)
        .right("lost", |v| v.lost)
        .right("in penumbra", |v| v.penumbra)
        .right("layers", |v| v.layers)
        .right("largest search, texels", |v| format!("{:.1}", v.largest_width))
        .right("N", |v| v.largest_region)
        .right("mean truth, %", |v| in_percent(v.mean_truth, 1))
        .right("standard error, %", |v| percent(v.mean_standard_error))
        .right("largest", |v| percent(v.largest_standard_error))
        .right("rays", |v| v.rays)
        .right("outline, %", |v| percent(v.outline_difference))
        .right("largest", |v| in_percent(v.largest_outline_difference, 1));
    let note = Text::from(
        "The truth is the share of the light's area that a receiver does not see, by shadow rays. Where all of its rays agree a \
         receiver has the standard error of one that does not. Outline: mean distance from the truth of the light of the other \
         outline (rectangle, disc) and the same area; a box filter can only imitate the rectangle. Lost: sampled fragments \
         without a triangle near them. Rays follow from the seed and the streams in views.csv.",
    );
    Block::section(2, "The truth", table, Some(note))
}

fn cost(tables: &SoftTables<'_>) -> Vec<Block> {
    let time = |technique: &str, stage| least_ns(&tables.samples, technique, stage);
    let table = Table::of(timed(&tables.experiment.technique, &tables.samples, "shade"))
        .left("technique", |t| &t.name)
        .right("encode and sum, ns a texel", |t| time(&t.name, "sum"))
        .right("shade, ns a fragment", |t| time(&t.name, "shade"));
    let rays = millions_a_second(&tables.samples, "truth", "rays");
    let note = Text::from(format!(
        "On the first view under the last light, double precision unless the name says otherwise, the least of the recorded \
         repetitions. The truth takes {rays:.2} million rays a second."
    ));
    Block::section(2, "Time on one core", table, Some(note))
}
