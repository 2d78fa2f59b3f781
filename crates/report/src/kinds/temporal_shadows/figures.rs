//! The figures of a `temporal-shadows` run: convergence, paths, counting, sheets of error maps.

use super::summary::{ASKED, TemporalTables};
use crate::drawing::{ErrorColours, Series, error_curves, error_point, error_sheet};
use crate::error::ReportError;
use crate::page::{Drawing, Explorer, Film};
use evaluation::{PathSetting, RunDirectory, TemporalAnimation, TemporalRecord, map_name};

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] =
    ["shadow minus truth at each pixel; pixels", "that do not face the light count as right"];

pub(super) fn draw(run: &RunDirectory, tables: &TemporalTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures = Vec::new();
    for light in tables.lights() {
        for path in &tables.experiment.path {
            if path.judged.len() > 1 {
                figures.push(by_frames(tables, light, path)?);
            }
        }
    }
    figures.extend(counting(tables)?);
    for picture in &tables.experiment.picture {
        let map =
            |name: &String| (name.clone(), run.path().join(map_name(&picture.id, &picture.light, name)));
        let tiles: Vec<_> = picture.techniques.iter().map(map).collect();
        let frame = picture.frames.iter().max().copied().unwrap_or_default();
        let title = format!(
            "shadow - truth, {}, light \"{}\", path \"{}\", frame {frame}",
            picture.scene, picture.light, picture.path
        );
        let sheet = error_sheet(&tiles, &title, ErrorColours::Signed, PIXEL)?;
        figures.push(Drawing::new(format!("leak-{}", picture.id), title, sheet));
    }
    Ok(figures)
}

/// Frames that play.
pub(super) fn films(tables: &TemporalTables<'_>) -> Vec<Explorer> {
    let of = |animation: &TemporalAnimation| {
        let path = tables.experiment.path.iter().find(|path| path.name == animation.path)?;
        let frames = (0..animation.shown(path.frames)).map(|i| 1 + i * animation.every);
        let title = format!(
            "{}, light \"{}\", path \"{}\": {}, from left to right",
            animation.scene,
            animation.light,
            animation.path,
            animation.techniques.join(", ")
        );
        let size = animation.size(tables.experiment.camera);
        Some(Explorer::Film(Film { id: animation.id.clone(), title, size, frames: frames.collect() }))
    };
    tables.experiment.animation.iter().filter_map(of).collect()
}

/// Errors over the frames of a path.
fn by_frames(tables: &TemporalTables<'_>, light: &str, path: &PathSetting) -> Result<Drawing, ReportError> {
    let curve = |role: &&str| {
        let name = tables.named(role)?;
        let point =
            |row: &TemporalRecord| error_point(name, row.frame as f64, row.frame.to_string(), row.l1_error);
        let rows =
            path.judged.iter().filter_map(|&frame| tables.row((light, &path.name, frame), name, "all"));
        let points: Vec<_> = rows.map(point).collect();
        (!points.is_empty()).then(|| Series { name: name.to_owned(), points })
    };
    let words = |text: &str| tables.experiment.scenery.words(text);
    let id = format!("frames-{}-{}", words(&path.name), words(light));
    let title =
        format!("Distance from the area light, path \"{}\", light \"{light}\" (less is better)", path.name);
    let curves: Vec<Series> = ASKED.iter().filter_map(curve).collect();
    error_curves(id, title, ("frames so far", "mean |shadow - truth|"), &curves)
}

/// How long formats count.
fn counting(tables: &TemporalTables<'_>) -> Result<Option<Drawing>, ReportError> {
    let curve = |role: &&str| {
        let name = tables.named(role)?;
        let rows = tables.counts.iter().filter(|r| r.technique == name);
        let points: Vec<_> =
            rows.map(|r| error_point(name, r.frames as f64, r.frames.to_string(), r.mean_error)).collect();
        let format = tables.counts.iter().find(|r| r.technique == name).map(|r| r.format.as_str())?;
        Some(Series { name: format!("{name} ({format})"), points })
    };
    let roles = ["sampling", "published", "published in f32", "capped"];
    let curves: Vec<Series> = roles.iter().filter_map(curve).filter(|curve| curve.points.len() > 1).collect();
    if curves.is_empty() {
        return Ok(None);
    }
    let title = "How long the formats of the shadow buffer count (less is better)";
    error_curves("counting", title, ("frames", "mean |estimate - truth| of a pixel"), &curves).map(Some)
}
