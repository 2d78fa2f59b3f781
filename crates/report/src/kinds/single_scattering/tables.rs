//! The tables of a `single-scattering` run, each with a note on how to read it.

use super::summary::{ALL, ScatteringTables};
use super::{passes, smallest};
use crate::kinds::rows::{distinct, least_ns, least_time, millions_a_second, percent};
use crate::page::{Block, RecordedPicture, Table, Text, in_percent, row};
use evaluation::{EdgeRecord, ScatteringPicture, ScatteringRecord, StoredBiasRecord};

pub(super) fn blocks(tables: &ScatteringTables<'_>) -> Vec<Block> {
    [
        pictures(tables),
        errors(tables),
        by_class(tables, "steps", "Error by complexity: depth steps along the row", STEPS_NOTE),
        by_class(tables, "epipole", "Error by distance from the epipole, in degrees", EPIPOLE_NOTE),
        by_class(tables, "standpoint", "Error by standpoint", STANDPOINT_NOTE),
        by_scene(tables),
        smallest::blocks(tables),
        aliasing(tables),
        stability(tables),
        edges(tables),
        truth(tables),
        cost(tables),
        passes::blocks(tables),
    ]
    .concat()
}

const STEPS_NOTE: &str = "Error and signed mean in percent by the number of depth steps along the rectified row up to the end of \
                          the ray: what a prefix has to hold. Above 0 light leaks. In brackets the share of rays.";

const EPIPOLE_NOTE: &str = "The same by the angle between the ray and the light's axis, whichever end is nearer. On the axis one \
                            texel answers for all distances.";

const STANDPOINT_NOTE: &str = "The same by the camera: its own place in the scene, looking into the light, along the light, under \
                               the ground, or a place of one scene.";

fn pictured(picture: &ScatteringPicture) -> [Block; 2] {
    let view = if picture.view.is_empty() { "first view" } else { &picture.view };
    let title = format!("{}, {view}, standpoint \"{}\"", picture.scene, picture.standpoint);
    let note = format!("Below, parts magnified, contrasts stretched by {}.", picture.stretch);
    RecordedPicture::new(&picture.id, title, picture.output, &picture.techniques)
        .with_legend("the shadow map's exact integral", &note)
}

fn pictures(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let mut blocks: Vec<Block> = tables.experiment.picture.iter().flat_map(pictured).collect();
    let table = Table::of(&tables.pictures)
        .left("picture", |r| &r.picture)
        .left("technique", |r| &r.technique)
        .right("error, %", |r| percent(r.l1_error))
        .right("roughness, %", |r| percent(r.roughness))
        .right("boundaries, %", |r| percent(r.boundaries))
        .right("pixels", |r| r.pixels);
    let note = Text::from(
        "Error: mean |method - truth| of the lit share. Roughness: mean difference of the errors of neighbouring pixels where \
         the truth is smooth: noise, stripes and boundaries that are none. Boundaries: share of these neighbours whose errors \
         differ by more than 5 %.",
    );
    blocks.extend(Block::section(3, "The pictures in numbers", table, Some(note)));
    blocks
}

fn errors(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let techniques = tables.experiment.technique.iter();
    let mut rows: Vec<&ScatteringRecord> =
        techniques.filter_map(|technique| tables.pooled(&technique.name, ALL)).collect();
    rows.sort_by(|a, b| a.l1_error.total_cmp(&b.l1_error));
    let table = Table::of(rows)
        .left("technique", |r| &r.technique)
        .right("bits a texel", |r| r.bits_per_texel)
        .right("error, %", |r| percent(r.l1_error))
        .right("standard error", |r| r.standard_error.map(percent))
        .right("signed", |r| percent(r.signed_mean))
        .right("p95", |r| in_percent(r.p95, 1))
        .right("largest", |r| in_percent(r.maximum, 1))
        .right("from the geometry", |r| percent(r.geometry_error))
        .right("failed", |r| r.failed);
    let note = Text::from(
        "All in percent of the light that would be scattered without shadows; less is better. Error: mean |method - truth| over \
         all view rays of all cameras, the truth being the exact integral with the visibility of the shadow map. Signed: above 0 \
         light leaks. From the geometry: the same error against shadow rays.",
    );
    Block::section(2, "Errors over all views", table, Some(note))
}

fn by_class(tables: &ScatteringTables<'_>, group: &str, heading: &str, note: &str) -> Vec<Block> {
    let of_group = tables.records.iter().filter(|r| r.scene == "all" && r.group == group && r.rays > 0);
    let classes = distinct(of_group.map(|r| r.class.as_str()));
    let all =
        tables.experiment.technique.first().and_then(|t| tables.pooled(&t.name, ALL)).map_or(0, |r| r.rays);
    let share = |class: &str| {
        let first = tables.experiment.technique.first();
        let rays = first.and_then(|t| tables.pooled(&t.name, (group, class))).map_or(0, |r| r.rays);
        format!("{class} ({:.0} %)", 100.0 * rays as f64 / all.max(1) as f64)
    };
    let cells = |technique: &str| {
        let cell = |class: &&str| -> Text {
            let found = tables.pooled(technique, (group, class));
            found.map(|r| format!("{} ({:+.2})", percent(r.l1_error), 100.0 * r.signed_mean)).into()
        };
        [row![technique], classes.iter().map(cell).collect()].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(classes.iter().map(|class| share(class)))
        .rows(tables.experiment.technique.iter().map(|technique| cells(&technique.name)));
    Block::section(2, heading, table, Some(Text::from(note)))
}

fn by_scene(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let views = distinct(tables.views.iter().map(|v| (v.scene.as_str(), v.view.as_str())));
    let cells = |technique: &str| {
        let error = |&(scene, view): &(&str, &str)| -> Text {
            let of = tables.records.iter().filter(|r| {
                r.technique == technique && r.scene == scene && r.view == view && r.group == "all"
            });
            let (mut sum, mut rays) = (0.0, 0);
            for record in of {
                sum += record.l1_error * record.rays as f64;
                rays += record.rays;
            }
            (rays > 0).then(|| percent(sum / rays as f64)).into()
        };
        [row![technique], views.iter().map(error).collect()].concat()
    };
    let table = Table::default()
        .left(["technique"])
        .right(views.iter().map(|(scene, view)| format!("{scene} {view}")))
        .rows(tables.experiment.technique.iter().map(|technique| cells(&technique.name)));
    Block::section(2, "Error by scene and light, over all standpoints, in percent", table, None)
}

fn aliasing(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let motions = distinct(tables.aliasing.iter().map(|r| (r.motion.as_str(), r.shift)));
    let techniques = distinct(tables.aliasing.iter().map(|r| r.technique.as_str()));
    let mean = |technique: &str, (motion, shift): (&str, f64), of: &dyn Fn(usize) -> f64| {
        let rows = tables.aliasing.iter().enumerate();
        let rows = rows.filter(|(_, r)| r.technique == technique && r.motion == motion && r.shift == shift);
        let values: Vec<f64> = rows.map(|(i, _)| of(i)).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    };
    let mut rows = Vec::new();
    if let Some(first) = techniques.first() {
        let truth = |&at: &(&str, f64)| {
            Text::from(in_percent(mean(first, at, &|i| tables.aliasing[i].truth_change), 3))
        };
        rows.push([row!["the truth itself changes by"], motions.iter().map(truth).collect()].concat());
    }
    for technique in &techniques {
        let flicker = |&at: &(&str, f64)| {
            Text::from(in_percent(mean(technique, at, &|i| tables.aliasing[i].flicker), 3))
        };
        rows.push([row![*technique], motions.iter().map(flicker).collect()].concat());
    }
    let table = Table::default()
        .left(["technique"])
        .right(motions.iter().map(|(motion, shift)| format!("{motion} by {shift}")))
        .rows(rows);
    let note = Text::from(
        "Flicker in percent: mean |change of the picture - change of the truth| while the camera moves to the side, or turns, by \
         so many pixels; mean over all views from their first standpoint.",
    );
    let rows_there = !tables.aliasing.is_empty();
    if rows_there { Block::section(2, "Aliasing under motion", table, Some(note)) } else { Vec::new() }
}

fn stability(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let keys = distinct(tables.stability.iter().map(|r| (r.bound.as_str(), r.format.as_str())));
    let best = |&(bound, format): &(&str, &str)| {
        let rows: Vec<&StoredBiasRecord> =
            tables.stability.iter().filter(|r| r.bound == bound && r.format == format).collect();
        let least = rows.iter().copied().min_by(|a, b| a.l1_error.total_cmp(&b.l1_error))?;
        let valid = rows.iter().find(|r| r.invalid == 0);
        let first = rows.first()?;
        let share = |r: &StoredBiasRecord| in_percent(r.invalid as f64 / r.rays.max(1) as f64, 2);
        let alpha = |r: &StoredBiasRecord| format!("{:.1e}", r.alpha);
        Some(row![
            bound,
            format,
            &first.transform,
            percent(first.l1_error),
            share(first),
            valid.map(|r| alpha(r)),
            valid.map(|r| percent(r.l1_error)),
            alpha(least),
            percent(least.l1_error),
            percent(least.change),
            rows.iter().map(|r| r.failed).sum::<usize>(),
        ])
    };
    let first = tables.stability.first().map_or(0.0, |r| r.alpha);
    let table = Table::default()
        .left(["bound", "format", "transform"])
        .right([
            format!("error at {first:.0e}, %"),
            "invalid there, %".to_owned(),
            "least valid alpha".to_owned(),
            "error there, %".to_owned(),
            "best alpha".to_owned(),
            "error there, %".to_owned(),
            "change there, %".to_owned(),
            "failed".to_owned(),
        ])
        .rows(keys.iter().filter_map(best));
    let note = Text::from(
        "Single precision. Invalid: biased moments that are those of no distribution, by the pivots of their matrix. Least valid \
         alpha: the least at which none is. Change: mean distance from the same bound of unrounded moments. Failed: answers that \
         are no number between 0 and 1, at any alpha.",
    );
    Block::section(2, "Moment bias by bound and format", table, Some(note))
}

fn edges(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let scientific = |value: f64| format!("{value:.1e}");
    let table = Table::of(&tables.edges)
        .left("case", |r: &EdgeRecord| &r.case)
        .left("bound", |r| &r.bound)
        .right("alpha", |r| format!("{:.0e}", r.alpha))
        .right("error, %", |r| percent(r.mean_error))
        .right("largest", |r| in_percent(r.largest_error, 1))
        .right("single against double", |r| scientific(r.mean_change))
        .right("largest", |r| scientific(r.largest_change))
        .right("failed", |r| r.failed);
    let note = Text::from(
        "Rows made by hand: of few depths in random order, for rays across the light unless the name says otherwise. Error: mean \
         |beta 0.5 in double precision - exact distribution|, which one and two depths must not have. Single against double: what \
         32-bit sums and bounds do, at one bias.",
    );
    Block::section(3, "At the edge", table, Some(note))
}

fn truth(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let table = Table::of(&tables.views)
        .left("view", |v| format!("{} {}", v.scene, v.view))
        .left("standpoint", |v| &v.standpoint)
        .right("evaluated", |v| v.sampled)
        .right("endless", |v| v.endless)
        .left("camera", |v| if v.camera_lit { "lit" } else { "in shadow" })
        .right("epipole, degrees", |v| format!("{:.1}", v.epipole))
        .right("pi - theta", |v| format!("{:.0} to {:.0}", v.least_inclination, v.greatest_inclination))
        .right("azimuths", |v| format!("{:.0}", v.azimuths))
        .right("steps", |v| format!("{:.1}", v.mean_steps))
        .right("lit, %", |v| in_percent(v.mean_truth, 1))
        .right("by shadow rays", |v| in_percent(v.mean_geometry, 1))
        .right("difference, %", |v| percent(v.difference))
        .right("signed", |v| percent(v.signed_difference))
        .right("standard error, %", |v| percent(v.standard_error))
        .right("largest", |v| percent(v.largest_standard_error))
        .right("shadow rays", |v| v.shadow_rays);
    let note = Text::from(
        "Lit: the mean share of the scattered light that is not shadowed, by the shadow map, walked texel by texel in closed form, \
         and by shadow rays from the view ray to the light. Their difference is what no shadow map of this size can know. \
         Epipole: least angle between a pixel and the light's axis.",
    );
    Block::section(2, "The truth", table, Some(note))
}

fn cost(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let time = |technique: &str, stage| least_ns(&tables.samples, technique, stage);
    let per_ray = |technique: &str| {
        least_time(&tables.samples, technique, "look up").or(least_time(&tables.samples, technique, "march"))
    };
    let timed = tables.experiment.technique.iter().filter(|t| per_ray(&t.name).is_some());
    let table = Table::of(timed)
        .left("technique", |t| &t.name)
        .right("resample, ns a texel", |t| time(&t.name, "resample"))
        .right("encode and sum, ns a texel", |t| time(&t.name, "prefix"))
        .right("ns a view ray", |t| per_ray(&t.name).map(|ns| format!("{ns:.0}")));
    let walk = least_time(&tables.samples, "truth", "walk").unwrap_or_default();
    let rays = millions_a_second(&tables.samples, "truth", "rays");
    let note = Text::from(format!(
        "On the first camera, the least of the recorded repetitions. The exact walk takes {walk:.0} ns a view ray, shadow rays \
         {rays:.2} million a second."
    ));
    Block::section(2, "Time on one core", table, Some(note))
}
