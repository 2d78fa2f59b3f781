//! The tables of a `temporal-shadows` run, each with a note on how to read it.

use super::summary::{ASKED, MENDS, TemporalTables};
use crate::kinds::rows::{distinct, least_ns, least_time, percent, timed};
use crate::page::{Block, RecordedPicture, Table, Text, in_percent, row};
use evaluation::{PathSetting, TemporalPicture, TemporalRecord};

pub(super) fn blocks(tables: &TemporalTables<'_>) -> Vec<Block> {
    [
        pictures(tables),
        closest(tables),
        closest_by_scene(tables),
        errors(tables),
        mends(tables),
        calibration(tables),
        counting(tables),
        truth(tables),
        cost(tables),
    ]
    .concat()
}

fn pictured(picture: &TemporalPicture, size: [u32; 2]) -> [Block; 2] {
    let mut columns = Vec::new();
    for technique in &picture.techniques {
        let mut frames = picture.frames.clone();
        frames.sort_unstable();
        columns.extend(frames.iter().map(|frame| format!("{technique}, frame {frame}")));
    }
    let title = format!("{}, light \"{}\", path \"{}\"", picture.scene, picture.light, picture.path);
    RecordedPicture::new(&picture.id, title, size, &columns)
        .with_legend("the area light by shadow rays", "Below, parts magnified.")
}

fn pictures(tables: &TemporalTables<'_>) -> Vec<Block> {
    let (pictures, size) = (&tables.experiment.picture, tables.experiment.camera);
    let mut blocks: Vec<Block> = pictures.iter().flat_map(|picture| pictured(picture, size)).collect();
    let table = Table::of(&tables.pictures)
        .left("picture", |r| &r.picture)
        .left("technique", |r| &r.technique)
        .right("frame", |r| r.frame)
        .right("error, %", |r| r.l1_error.map(percent))
        .right("pixels", |r| r.pixels);
    blocks.extend(Block::section(3, "The pictures in numbers", table, None));
    blocks
}

/// Rows of the asked methods by light and path.
fn closest(tables: &TemporalTables<'_>) -> Vec<Block> {
    let columns: Vec<(&str, &PathSetting)> = tables
        .lights()
        .flat_map(|light| tables.experiment.path.iter().map(move |path| (light, path)))
        .collect();
    let cells = |name: &str| {
        let find = |&column: &(&str, &PathSetting)| tables.last(column, name, "all");
        let error = |column| find(column).map(|row| percent(row.l1_error)).into();
        let row = columns.first().and_then(find);
        let cost = row![
            row.map(|row| row.maps),
            row.map(|row| row.bits_per_texel),
            row.map(|row| row.bytes_per_pixel),
            row.map(|row| format!("{:.0}", row.lookups)),
        ];
        [row![name], columns.iter().map(error).collect(), cost].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(columns.iter().map(|(light, path)| format!("{light}: {}", path.name)))
        .right(["maps a frame", "bits a texel", "bytes a pixel", "lookups"])
        .rows(ASKED.iter().filter_map(|role| tables.named(role)).map(cells));
    let note = Text::from(
        "Mean |shadow - truth| in percent over all scenes in the last judged frame of each path; less is better. Every method has \
         one map a frame of the size of the experiment, seen from a point of the light (what gathers) or from its middle; stochastic \
         maps send a ray for each texel from a point of their own. Bits of a texel: the map, table or all planes; bytes: what \
         stays of a pixel from frame to frame; lookups: texels that a pixel reads.",
    );
    Block::section(2, "Which is closest", table, Some(note))
}

/// Errors further apart than so many standard errors of their difference are told apart: 99 % where both are normal.
const APART: f64 = 2.58;

/// The closest and the next in every scene, by light and path.
fn closest_by_scene(tables: &TemporalTables<'_>) -> Vec<Block> {
    let names: Vec<&str> = ASKED.iter().filter_map(|role| tables.named(role)).collect();
    let scenes = distinct(tables.views.iter().map(|view| view.scene.as_str()));
    let mut rows = Vec::new();
    for light in tables.lights() {
        for path in &tables.experiment.path {
            let frame = path.judged.last().copied().unwrap_or_default();
            let cell = |scene: &&str| {
                let at = (light, path.name.as_str(), frame);
                let of = names.iter().filter_map(|name| tables.row_of(scene, at, name, "all"));
                let mut of: Vec<&TemporalRecord> = of.filter(|row| row.error.is_empty()).collect();
                of.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
                let text = |row: &TemporalRecord| format!("{} {}", row.technique, percent(row.l1_error));
                let words = match of.as_slice() {
                    [] => String::new(),
                    [only] => text(only),
                    [first, second, ..] => {
                        let spread = first.standard_error.hypot(second.standard_error);
                        let is_apart = second.l1_error - first.l1_error > APART * spread;
                        format!("{}{}{}", text(first), if is_apart { " < " } else { " ~ " }, text(second))
                    }
                };
                words.into()
            };
            rows.push([row![light, path.name.as_str()], scenes.iter().map(cell).collect()].concat());
        }
    }
    let table = Table::default().left(["light", "path"]).left(scenes.iter().copied()).rows(rows);
    let note = Text::from(
        "The closest of these methods and the next, mean |shadow - truth| in percent; ~ where the two are not further apart than \
         the sampling of pixels allows to say (99 %).",
    );
    Block::section(3, "By scene", table, Some(note))
}

fn errors(tables: &TemporalTables<'_>) -> Vec<Block> {
    let Some(light) = tables.middle() else { return Vec::new() };
    let mut blocks = vec![Block::heading(2, format!("Errors by path, light \"{light}\""))];
    for path in &tables.experiment.path {
        let find =
            |name: &str, class: &str| tables.last((light, path), name, class).filter(|r| r.receivers > 0);
        let all = tables.experiment.technique.iter().filter_map(|t| find(&t.name, "all"));
        let mut rows: Vec<&TemporalRecord> = all.collect();
        rows.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
        let of = |row: &TemporalRecord, class: &str| find(&row.technique, class).map(|r| percent(r.l1_error));
        let table = Table::of(rows)
            .left("technique", |r| &r.technique)
            .right("error, %", |r| percent(r.l1_error))
            .right("standard error", |r| percent(r.standard_error))
            .right("signed", |r| percent(r.signed_mean))
            .right("p95", |r| in_percent(r.p95, 1))
            .right("penumbra", |r| of(r, "penumbra"))
            .right("new", |r| of(r, "new"))
            .right("changed", |r| of(r, "changed"))
            .right("flicker", |r| r.flicker.map(percent))
            .right("restarted", |r| r.restarted.map(|share| in_percent(share, 1)))
            .right("filtered", |r| r.filtered.map(|share| in_percent(share, 1)))
            .right("lookups", |r| format!("{:.1}", r.lookups));
        let frame = path.judged.last().copied().unwrap_or_default();
        blocks.extend(Block::section(3, &format!("Path \"{}\", frame {frame}", path.name), table, None));
    }
    blocks.push(Block::paragraph(
        "All in percent of the light or of the pixels; less is better. Penumbra: truths from 0.01 to 0.99. New: surfaces that came \
         into view within 8 frames. Changed: pixels whose truth was another one 8 frames before, where moving shadows are and \
         were. Flicker: mean change from the frame before at the same place of the scene, where the truth stays. Restarted: \
         histories that began in this frame. Lookups: texels of maps, tables and buffers that a pixel reads.",
    ));
    blocks
}

/// What each mend does to the published method.
fn mends(tables: &TemporalTables<'_>) -> Vec<Block> {
    let (Some(light), Some(published)) = (tables.middle(), tables.named("published")) else {
        return Vec::new();
    };
    let paths = &tables.experiment.path;
    let find = |name: &str, path: &PathSetting, class: &str| {
        tables.last((light, path), name, class).filter(|row| row.receivers > 0)
    };
    let change = |name: &str, path: &PathSetting, class: &str| {
        let (own, before) = (find(name, path, class)?, find(published, path, class)?);
        Some(format!("{:+.2}", 100.0 * (own.l1_error - before.l1_error)))
    };
    let flicker = |name: &str, path: &PathSetting| {
        let of = |name| find(name, path, "all").and_then(|row| row.flicker);
        Some(format!("{:+.2}", 100.0 * (of(name)? - of(published)?)))
    };
    let cells = |name: &str| {
        let errors = paths.iter().map(|path| change(name, path, "all").into()).collect();
        let changed = tables.moving().map(|path| change(name, path, "changed").into()).into_iter().collect();
        let flickers = paths.iter().map(|path| flicker(name, path).into()).collect();
        [row![name], errors, changed, flickers].concat()
    };
    let roles = MENDS.iter().chain(&["mended"]);
    let moving = tables.moving().map(|path| format!("{}, changed", path.name));
    let table = Table::default()
        .left(["mend"])
        .right(paths.iter().map(|path| path.name.clone()))
        .right(moving)
        .right(paths.iter().map(|path| format!("flicker, {}", path.name)))
        .rows(roles.filter_map(|role| tables.named(role)).map(cells));
    let note = Text::from(format!(
        "Change of the error and of the flicker of {published} in percentage points of the light, light \"{light}\", last judged \
         frame of each path; below 0 is better. Each mend alone, then all together."
    ));
    Block::section(2, "What the mends do", table, Some(note))
}

fn calibration(tables: &TemporalTables<'_>) -> Vec<Block> {
    let (Some(light), Some(path)) = (tables.middle(), tables.still()) else { return Vec::new() };
    let mut rows = Vec::new();
    for role in ["sampling", "sampling by rays", "published", "cautious", "mended"] {
        let Some(name) = tables.named(role) else { continue };
        let of = |&frame: &usize| tables.row((light, &path.name, frame), name, "penumbra");
        rows.extend(path.judged.iter().filter_map(of));
    }
    let in_percents = |value: Option<f64>, digits| value.map(|value| in_percent(value, digits));
    let table = Table::of(rows)
        .left("technique", |r| &r.technique)
        .right("frame", |r| r.frame)
        .right("n", |r| r.tests.map(|tests| format!("{tests:.1}")))
        .right("rms error of the estimate, %", |r| in_percents(r.estimate_rms, 2))
        .right("believed, %", |r| in_percents(r.believed_rms, 2))
        .right("within, %", |r| in_percents(r.within, 0))
        .right("falsely certain, %", |r| in_percents(r.falsely_certain, 0))
        .right("filtered, %", |r| in_percents(r.filtered, 0));
    let note = Text::from(
        "Pixels in penumbrae, nothing moving. Within: share of pixels whose estimate is as near to the truth as the standard error \
         says; 68 % is right. Falsely certain: an error of 0 is believed in, and the estimate is off by more than 2 %.",
    );
    Block::section(2, "Does the standard error hold?", table, Some(note))
}

fn counting(tables: &TemporalTables<'_>) -> Vec<Block> {
    let asked = ["sampling", "published", "published in f32", "capped"];
    let names: Vec<&str> = asked.iter().filter_map(|role| tables.named(role)).collect();
    let rows = tables.counts.iter().filter(|r| names.contains(&r.technique.as_str()));
    let table = Table::of(rows)
        .left("technique", |r| &r.technique)
        .left("format", |r| &r.format)
        .right("frames", |r| r.frames)
        .right("n", |r| format!("{:.0}", r.tests))
        .right("mean error, %", |r| percent(r.mean_error))
        .right("largest, %", |r| in_percent(r.largest_error, 1));
    let note = Text::from(
        "Single pixels whose share of shadow is known, under Halton's points. In half floats n stops at 2048 while rho goes on.",
    );
    Block::section(2, "How long formats count", table, Some(note))
}

fn truth(tables: &TemporalTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.views)
        .left("scene", |v| &v.scene)
        .left("light", |v| &v.light)
        .left("path", |v| &v.path)
        .right("frames", |v| v.frames)
        .left("moves", |v| if v.moving { "yes" } else { "no" })
        .right("triangles", |v| v.triangles)
        .right("pixels", |v| v.pixels)
        .right("judged", |v| v.judged)
        .right("in penumbra", |v| v.penumbra)
        .right("penumbra, pixels", |v| format!("{:.1}", v.penumbra_pixels))
        .right("mean truth, %", |v| in_percent(v.mean_truth, 1))
        .right("standard error, %", |v| percent(v.mean_standard_error))
        .right("largest", |v| percent(v.largest_standard_error))
        .right("rays", |v| v.rays);
    let note = Text::from(
        "The truth is the share of the light's area that a surface does not see, by shadow rays; numbers of the last judged frame. \
         Everything random follows from the seed in views.csv.",
    );
    Block::section(2, "The truth", table, Some(note))
}

fn cost(tables: &TemporalTables<'_>) -> Vec<Block> {
    let time = |technique: &str| least_ns(&tables.samples, technique, "frame");
    let table = Table::of(timed(&tables.experiment.technique, &tables.samples, "frame"))
        .left("technique", |t| &t.name)
        .right("ns a pixel", |t| time(&t.name));
    let maps = least_time(&tables.samples, "", "map").unwrap_or_default();
    let note = Text::from(format!(
        "A frame whose pixels have a history, on the first scene, the least of the recorded repetitions; reading a texel of the \
         map takes {maps:.0} ns more, as it is traced and not drawn, and so do texels that a method alone reads."
    ));
    Block::section(2, "Time on one core", table, Some(note))
}
