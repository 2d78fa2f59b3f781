//! The tables of a `stochastic-shadows` run, each with a note on how to read it.

use super::summary::{BASES, CHANGES, OTHERS, StochasticTables};
use crate::kinds::rows::{least_ns, millions_a_second, percent, timed};
use crate::page::{Block, RecordedPicture, Table, Text, in_percent, row};
use evaluation::{StochasticPicture, StochasticRecord};

pub(super) fn blocks(tables: &StochasticTables<'_>) -> Vec<Block> {
    [
        pictures(tables),
        closest(tables),
        errors(tables),
        changes(tables),
        planes(tables),
        modulation(tables),
        truth(tables),
        cost(tables),
    ]
    .concat()
}

fn pictured(picture: &StochasticPicture) -> [Block; 2] {
    let title = format!("{}, light \"{}\"", picture.scene, picture.light);
    RecordedPicture::new(&picture.id, title, picture.output, &picture.techniques)
        .with_legend("the area light by shadow rays", "Below, parts magnified.")
}

fn pictures(tables: &StochasticTables<'_>) -> Vec<Block> {
    let mut blocks: Vec<Block> = tables.experiment.picture.iter().flat_map(pictured).collect();
    let table = Table::of(&tables.pictures)
        .left("picture", |r| &r.picture)
        .left("technique", |r| &r.technique)
        .right("error, %", |r| percent(r.l1_error))
        .right("pixels", |r| r.pixels);
    blocks.extend(Block::section(3, "The pictures in numbers", table, None));
    blocks
}

/// The main methods by light, with what they cost.
fn closest(tables: &StochasticTables<'_>) -> Vec<Block> {
    let lights: Vec<&str> = tables.lights().collect();
    let ours = ["published", "four moments", "mended", "double"];
    let names = ours.iter().chain(&OTHERS).filter_map(|role| tables.named(role));
    let cells = |name: &str| {
        let error = |light: &&str, class| tables.row(light, name, class).map(|r| percent(r.l1_error)).into();
        let of = |class| lights.iter().map(|light| error(light, class)).collect();
        let first = lights.first().and_then(|light| tables.row(light, name, "all"));
        let cost = row![
            first.map(|r| r.lookups),
            first.map(|r| u64::from(r.size) * u64::from(r.size)),
            first.map(|r| format!("{:.1}", r.mebibytes))
        ];
        [row![name], of("all"), of("contact"), cost].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(lights.iter().map(|light| format!("{light} light")))
        .right(lights.iter().map(|light| format!("contacts, {light}")))
        .right(["lookups a pixel", "rays or texels a map", "MiB"])
        .rows(names.map(cells));
    let note = Text::from(
        "Mean |shadow - truth| in percent over all scenes; less is better. Contacts: surfaces whose first blocker towards the \
         light's middle is nearer than some texels of the map. MiB: all filter planes, or the table of sums.",
    );
    Block::section(2, "Which is closest", table, Some(note))
}

fn errors(tables: &StochasticTables<'_>) -> Vec<Block> {
    let mut blocks = vec![Block::heading(2, "Errors by light")];
    for light in tables.lights() {
        let all = tables.experiment.technique.iter().filter_map(|t| tables.row(light, &t.name, "all"));
        let mut rows: Vec<&StochasticRecord> = all.collect();
        rows.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
        let of = |row: &StochasticRecord, class: &str| tables.row(light, &row.technique, class);
        let table = Table::of(rows)
            .left("technique", |r| &r.technique)
            .right("error, %", |r| percent(r.l1_error))
            .right("standard error", |r| percent(r.standard_error))
            .right("signed", |r| percent(r.signed_mean))
            .right("p95", |r| in_percent(r.p95, 1))
            .right("penumbra", |r| of(r, "penumbra").map(|r| percent(r.l1_error)))
            .right("contact", |r| of(r, "contact").map(|r| percent(r.l1_error)))
            .right("signed", |r| of(r, "contact").map(|r| percent(r.signed_mean)))
            .right("noise", |r| r.noise.map(percent))
            .right("unreached", |r| percent(r.unreached))
            .right("bits", |r| r.bits_per_texel);
        blocks.extend(Block::section(3, &format!("Light \"{light}\""), table, None));
    }
    blocks.push(Block::paragraph(
        "All in percent of the light or of the pixels; less is better. Signed: below 0 light leaks. Noise: mean difference from a \
         map with other points of the light, which is what flickers if points change from frame to frame. Unreached: pixels that \
         no sample reaches, taken as lit. Bits: of a texel of each plane, or of the table.",
    ));
    blocks
}

/// What each change does to four moments on four planes.
fn changes(tables: &StochasticTables<'_>) -> Vec<Block> {
    let Some(before) = tables.named("four moments") else { return Vec::new() };
    let lights: Vec<&str> = tables.lights().collect();
    let change = |name: &str, light: &str, class: &str| {
        let (own, old) = (tables.row(light, name, class)?, tables.row(light, before, class)?);
        Some(format!("{:+.2}", 100.0 * (own.l1_error - old.l1_error)))
    };
    let noise = |name: &str, light: &str| {
        let of = |name| tables.row(light, name, "all").and_then(|row| row.noise);
        Some(format!("{:+.2}", 100.0 * (of(name)? - of(before)?)))
    };
    let cells = |name: &str| {
        let of = |class: &str| lights.iter().map(|light| change(name, light, class).into()).collect();
        let noises = lights.iter().map(|light| noise(name, light).into()).collect();
        [row![name], of("all"), of("contact"), noises].concat()
    };
    let names =
        BASES.iter().chain(&CHANGES).filter_map(|role| tables.named(role)).filter(|name| *name != before);
    let table = Table::default()
        .left(["change"])
        .right(lights.iter().map(|light| format!("{light} light")))
        .right(lights.iter().map(|light| format!("contacts, {light}")))
        .right(lights.iter().map(|light| format!("noise, {light}")))
        .rows(names.map(cells));
    let note = Text::from(
        "Change of error and noise in percentage points of the light against four moments on four planes, all else as published; \
         below 0 is better. Other representations first, then planes, mends of the filter, sizes of the map.",
    );
    Block::section(2, "What each change does", table, Some(note))
}

fn planes(tables: &StochasticTables<'_>) -> Vec<Block> {
    let Some(name) = tables.named("published") else { return Vec::new() };
    let table = Table::of(tables.planes.iter().filter(|r| r.technique == name))
        .left("scene", |r| &r.scene)
        .left("light", |r| &r.light)
        .right("depth", |r| format!("{:.3}", r.depth))
        .left("in focus", |r| if r.in_focus { "yes" } else { "no" })
        .right("tiles that are filtered, %", |r| in_percent(r.active_tiles, 0))
        .right("samples a texel", |r| format!("{:.2}", r.merged))
        .right("cut off, %", |r| in_percent(r.cut_off, 1));
    let note = Text::from(
        "Planes of an even partition. Samples a texel: how many rays were merged, of texels that have any. Cut off: samples whose \
         radius is more than the coarsest of two levels can follow.",
    );
    Block::section(2, "Filter planes", table, Some(note))
}

fn modulation(tables: &StochasticTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.modulation)
        .left("light", |r| &r.light)
        .left("technique", |r| &r.technique)
        .right("true change, %", |r| percent(r.truth_change))
        .right("change, %", |r| percent(r.change))
        .right("error of the change, %", |r| percent(r.change_error))
        .right("correlation", |r| format!("{:.3}", r.correlation))
        .right("error, %", |r| percent(r.l1_error))
        .right("pixels", |r| r.receivers);
    let note = Text::from(
        "Two grids under a square light; the upper one turns, and what stands still is judged before and after. Correlation of the \
         change with the true one: 1 is right, 0 says nothing.",
    );
    Block::section(2, "Modulation of the light field", table, Some(note))
}

fn truth(tables: &StochasticTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.views)
        .left("scene", |v| &v.scene)
        .left("light", |v| &v.light)
        .left("shape", |v| &v.shape)
        .right("triangles", |v| v.triangles)
        .right("pixels", |v| v.pixels)
        .right("judged", |v| v.judged)
        .right("in penumbra", |v| v.penumbra)
        .right("in contact", |v| v.contact)
        .right("mean truth, %", |v| in_percent(v.mean_truth, 1))
        .right("standard error, %", |v| percent(v.mean_standard_error))
        .right("largest", |v| percent(v.largest_standard_error))
        .right("rays", |v| v.rays);
    let note = Text::from(
        "The truth is the share of the light's area that a surface does not see, by shadow rays. Everything random follows from \
         the seed in views.csv.",
    );
    Block::section(2, "The truth", table, Some(note))
}

fn cost(tables: &StochasticTables<'_>) -> Vec<Block> {
    let time = |technique: &str, stage| least_ns(&tables.samples, technique, stage);
    let table = Table::of(timed(&tables.experiment.technique, &tables.samples, "shade"))
        .left("technique", |t| &t.name)
        .right("all planes or sums, ns a texel", |t| time(&t.name, "filter"))
        .right("shade, ns a pixel", |t| time(&t.name, "shade"));
    let rays = millions_a_second(&tables.samples, "", "rays");
    let note = Text::from(format!(
        "On the first scene, the least of the recorded repetitions; the map takes {rays:.2} million rays a second."
    ));
    Block::section(2, "Time on one core", table, Some(note))
}
