//! The figures of a `stochastic-shadows` run: errors by light, and sheets of error maps.

use super::summary::{BASES, OTHERS, StochasticTables};
use crate::drawing::{ErrorColours, Series, error_curves, error_point, error_sheet};
use crate::error::ReportError;
use crate::page::Drawing;
use evaluation::{RunDirectory, map_name};

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] =
    ["shadow minus truth at each pixel; pixels", "that do not face the light count as right"];

pub(super) fn draw(run: &RunDirectory, tables: &StochasticTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let mut figures = Vec::new();
    if tables.experiment.light.len() > 1 {
        let ours = ["published", "four moments", "mended"];
        let roles: Vec<&str> = ours.into_iter().chain(OTHERS).collect();
        let title = "Distance from the area light by its size (less is better)";
        figures.extend(by_light(tables, ("methods", title), &roles, "all")?);
        let title = "At contacts: distance from the area light by its size (less is better)";
        figures.extend(by_light(tables, ("contacts", title), &roles, "contact")?);
        let title = "Representations on the same planes (less is better)";
        figures.extend(by_light(tables, ("bases", title), &BASES, "all")?);
        let planes = ["one plane", "two planes", "four moments", "eight planes", "planes at receivers"];
        figures.extend(by_light(
            tables,
            ("planes", "Four moments by filter planes (less is better)"),
            &planes,
            "all",
        )?);
    }
    for picture in &tables.experiment.picture {
        let map =
            |name: &String| (name.clone(), run.path().join(map_name(&picture.id, &picture.light, name)));
        let tiles: Vec<_> = picture.techniques.iter().map(map).collect();
        let title = format!("shadow - truth, {}, light \"{}\"", picture.scene, picture.light);
        let sheet = error_sheet(&tiles, &title, ErrorColours::Signed, PIXEL)?;
        figures.push(Drawing::new(format!("leak-{}", picture.id), title, sheet));
    }
    Ok(figures)
}

fn by_light(
    tables: &StochasticTables<'_>,
    (id, title): (&str, &str),
    roles: &[&str],
    class: &str,
) -> Result<Option<Drawing>, ReportError> {
    let curve = |role: &&str| {
        let name = tables.named(role)?;
        let point = |light: &evaluation::ScaledLight| {
            let row = tables.row(&light.name, name, class)?;
            Some(error_point(name, light.scale, light.name.clone(), row.l1_error))
        };
        let points: Vec<_> = tables.experiment.light.iter().filter_map(point).collect();
        (!points.is_empty()).then(|| Series { name: name.to_owned(), points })
    };
    let curves: Vec<Series> = roles.iter().filter_map(curve).collect();
    if curves.is_empty() {
        return Ok(None);
    }
    let labels = ("light, by the length of its side", "mean |shadow - truth|");
    error_curves(id, title, labels, &curves).map(Some)
}
