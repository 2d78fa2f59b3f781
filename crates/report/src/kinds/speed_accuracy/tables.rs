//! The tables of a `speed-accuracy` run, each with a note on how to read it.

use super::summary::{SpeedTables, Time};
use crate::kinds::rows::distinct;
use crate::page::{Block, RecordedPicture, Table, Text, percent, row};
use evaluation::{PictureSetting, SpeedAccuracyRecord};

pub(crate) fn blocks(tables: &SpeedTables<'_>) -> Vec<Block> {
    [
        pictures(tables),
        front(tables),
        techniques(tables),
        times(tables),
        tables.gpu_blocks(),
        needs(tables),
        tables.level().blocks(3),
    ]
    .concat()
}

/// A picture with its columns.
pub(crate) fn recorded_picture(picture: &PictureSetting) -> RecordedPicture {
    let view = if picture.view.is_empty() { "first view" } else { &picture.view };
    let title = format!("{}, {view}", picture.scene);
    RecordedPicture::new(&picture.id, title, picture.output, &picture.techniques)
}

fn pictures(tables: &SpeedTables<'_>) -> Vec<Block> {
    let mut blocks = Vec::new();
    let every = tables.pictures();
    if let Some(first) = every.first() {
        let links = every.iter().map(|of| Text::default().link(&of.title, format!("{}.png", of.id)));
        let columns = first.columns.techniques.join("; ");
        let head = Text::from(format!("From every view, PCF with receiver plane, then {columns}: "));
        blocks.push(Block::Paragraph(Text::joined([head, Text::joined(links, ", "), ".".into()], "")));
    }
    for picture in &tables.experiment.picture {
        let (texels, slopes) = (picture.bias.texels, picture.bias.slopes);
        let note = format!(
            "Lower bounds as they are, depth bias {texels} texels + {slopes} slopes; below, parts of the pictures magnified."
        );
        blocks.extend(recorded_picture(picture).with_legend("PCF with receiver plane", &note));
    }
    blocks
}

fn error(record: &SpeedAccuracyRecord) -> String {
    let margin = record.standard_error.map(|e| format!(" ± {:.2}", 200.0 * e)).unwrap_or_default();
    format!("{:.2}{margin} %", 100.0 * record.l1_error)
}

/// In units of doing nothing, with two standard errors.
fn relative(record: &SpeedAccuracyRecord) -> Option<String> {
    let margin = record.relative_standard_error.map(|e| format!(" ± {:.4}", 2.0 * e)).unwrap_or_default();
    record.relative_error.map(|error| format!("{error:.4}{margin}"))
}

fn blend(record: &SpeedAccuracyRecord) -> String {
    match (record.beta > 0.0, record.leak_reduction > 0.0) {
        (false, false) => "lower bound".to_owned(),
        (true, false) => format!("beta {}", record.beta),
        (false, true) => format!("leak reduction {}", record.leak_reduction),
        (true, true) => format!("beta {}, leak reduction {}", record.beta, record.leak_reduction),
    }
}

fn alpha(record: &SpeedAccuracyRecord) -> Option<String> {
    record.alpha.map(|alpha| format!("{alpha:e}"))
}

fn front(tables: &SpeedTables<'_>) -> Vec<Block> {
    let bytes = |r: &SpeedAccuracyRecord| f64::from(r.size).powi(2) * r.bits_per_texel as f64 / 8.0;
    let table = Table::of(tables.front().into_iter().chain(tables.nothing()))
        .left("technique", |r| &r.technique)
        .left("format", |r| &r.format)
        .right("map", |r| r.size)
        .right("alpha", alpha)
        .left("depth bias", |r| format!("{} texels + {} slopes", r.bias_texels, r.bias_slopes))
        .left("blend", blend)
        .right("bits a texel", |r| r.bits_per_texel)
        .right("map memory", |r| format!("{:.2} MiB", bytes(r) / f64::from(1 << 20)))
        .right("operations", |r| format!("{:.0}", r.operations))
        .right("cost", |r| format!("{:.3}", r.cost))
        .right("error", error)
        .right("relative", relative);
    let size = tables.full_size();
    let note = Text::from("Lower is better everywhere. ")
        .emphasis("Error")
        .and(format!(
            ": mean |G - F| over all fragments with two standard errors; F is PCF with a receiver plane on the \
             {size}x{size} map. "
        ))
        .emphasis("Relative")
        .and(
            ": the sum of |G - F| over that of F, which is what calling every fragment lit errs by; ground in the light does \
             not dilute it. Neighbours whose intervals overlap have no order. ",
        )
        .emphasis("Cost")
        .and(
            ": modelled memory traffic and arithmetic of a frame, 1 for the first technique at full size; it is no \
             time. ",
        )
        .emphasis("Operations")
        .and(": decoding and shading one fragment. ")
        .emphasis("Blend")
        .and(
            ": beta is the share of the way from the lower to the upper bound, leak reduction p divides shadows by \
             1 - p.",
        );
    Block::section(3, "Nothing is cheaper and more accurate", table, Some(note))
}

fn techniques(tables: &SpeedTables<'_>) -> Vec<Block> {
    let (scenes, sizes) = (tables.scenes(), tables.sizes());
    let l1_error = |r: Option<&SpeedAccuracyRecord>| Text::from(r.map(|r| percent(r.l1_error, 2)));
    let cells = |r: &SpeedAccuracyRecord| {
        let mut cells =
            row![&r.technique, &r.format, alpha(r), r.bits_per_texel, format!("{:.2}", r.cost), relative(r)];
        cells.extend(sizes.iter().map(|&size| {
            let same = |o: &&SpeedAccuracyRecord| {
                o.size == size && o.technique == r.technique && o.format == r.format
            };
            l1_error(tables.best().chain(tables.nothing()).find(same))
        }));
        cells.extend(scenes.iter().map(|scene| l1_error(tables.part(r, scene, "all"))));
        cells
    };
    let mut full = tables.full();
    full.extend(tables.nothing());
    full.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
    let table = Table::default()
        .left(["technique", "format"])
        .right(["alpha", "bits", "cost", "relative"])
        .right(sizes.iter().map(|size| format!("at {size}")))
        .right(scenes.iter().copied())
        .rows(full.into_iter().map(cells));
    let note = Text::from("Errors of all scenes by side of the map, then of single scenes at full size. ")
        .code("depth")
        .and(" is percentage-closer filtering without a receiver plane.");
    Block::section(3, "Every technique with its own best biases", table, Some(note))
}

fn times(tables: &SpeedTables<'_>) -> Vec<Block> {
    let all = tables.samples.iter();
    let keys = distinct(all.map(|s| (s.technique.as_str(), s.format.as_str(), s.precision.as_str())));
    let cells = |(technique, format, precision)| {
        let of = |stage| {
            let show =
                |Time { least, median, most }: Time| format!("{median:.1} ns ({least:.1} to {most:.1})");
            let ratio = tables.ratio(technique, format, precision, stage);
            row![
                tables.time(technique, format, precision, stage).map(show),
                ratio.map(|ratio| format!("{ratio:.2}"))
            ]
        };
        let stored = if precision == "f32" { format } else { "-" };
        [row![technique, stored, precision], of("shade"), of("filter")].concat()
    };
    let table = Table::default()
        .left(["technique", "format", "precision"])
        .right(["shading a fragment", "ratio", "encoding and filtering a texel", "ratio"])
        .rows(keys.into_iter().map(cells));
    let note = Text::from(
        "Median, least and most over the rounds; ratios are to the first technique in the same round and precision, median. A \
         call at a time, without vector units; what a graphics processor takes is another matter.",
    );
    Block::section(3, "Time on one core", table, Some(note))
}

fn needs(tables: &SpeedTables<'_>) -> Vec<Block> {
    let mut blocks = vec![Block::heading(3, "How many moments kernels need")];
    for (by, tolerance) in tables.need_kinds() {
        let what = match by {
            "rank" => format!(
                "Surfaces in a kernel: eigenvalues of the moment matrix above {tolerance:e} of the largest"
            ),
            "gap" => format!("Least number of moments whose sharp bounds are closer than {tolerance}"),
            _ => format!("Least number of moments whose lower bound loses less than {tolerance} to PCF"),
        };
        let names = tables.needs("all", by, tolerance).into_iter().map(|(needs, _)| needs);
        let cells = |scene| {
            let shares = tables.needs(scene, by, tolerance).into_iter();
            row![scene].into_iter().chain(shares.map(|(_, share)| percent(share, 1).into())).collect()
        };
        let scenes = tables.scenes().into_iter().chain(["all"]);
        let table = Table::default().left(["scene"]).right(names).rows(scenes.map(cells));
        blocks.extend([Block::paragraph(what + ":"), Block::Table(table)]);
    }
    blocks
}
