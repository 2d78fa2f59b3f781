//! The figures of a `filterable` experiment: single kernels and sheets of error maps.

use super::summary::FilterableTables;
use crate::drawing::{
    Arrow, Chart, Curve, DEPTH_LABEL, ErrorColours, F_STROKE, GREEN, INTENSITY_LABEL, Stroke, beside_charts,
    error_sheet,
};
use crate::error::ReportError;
use crate::page::Drawing;
use evaluation::{KernelRecord, Picture, PictureRecord, RunDirectory, map_name};
use moment_problem::DepthDistribution;

/// What a pixel of an error map shows.
const PIXEL: [&str; 2] = ["a pixel shows the fragment of largest error", "in its texels, whatever the layer"];

/// All figures of a run.
pub(crate) fn draw(run: &RunDirectory, tables: &FilterableTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let experiment = tables.experiment;
    let mut figures = Vec::new();
    for picture in &experiment.picture {
        figures.push(kernel(tables, picture)?);
    }
    for view in &tables.views {
        if !experiment.maps.covers(&view.scene, &view.view) {
            continue;
        }
        let scene = experiment.scenery.words(&view.scene);
        let mut tiles = Vec::new();
        for technique in experiment.technique.iter().filter(|t| experiment.maps.shows(t)) {
            let path = run.path().join(map_name(&scene, &view.view, &technique.name));
            tiles.push((technique.name.clone(), path));
        }
        let stem = map_name(&scene, &view.view, "");
        let stem = stem.trim_start_matches("map-").trim_end_matches(".png").trim_end_matches('-');
        let titled = |what: &str| format!("{what}, {} from {}", view.scene, view.view);
        let (error, leak) = (titled("|G - F|"), titled("G - F"));
        figures.push(Drawing {
            id: format!("error-{stem}"),
            svg: error_sheet(&tiles, &error, ErrorColours::Magnitude, PIXEL)?,
            title: error,
        });
        figures.push(Drawing {
            id: format!("leak-{stem}"),
            svg: error_sheet(&tiles, &leak, ErrorColours::Signed, PIXEL)?,
            title: leak,
        });
    }
    Ok(figures)
}

/// F and the techniques over all fragment depths, beside the kernel (MSM15 Figure 2).
fn kernel(tables: &FilterableTables<'_>, picture: &Picture) -> Result<Drawing, ReportError> {
    const CHART: u32 = 420;
    let empty = || ReportError::Empty { figure: picture.id.clone() };
    let taps: Vec<&PictureRecord> = tables.kernels.iter().filter(|r| r.picture == picture.id).collect();
    let first = *taps.first().ok_or_else(empty)?;
    let (depths, weights): (Vec<f64>, Vec<f64>) = taps.iter().map(|tap| (tap.depth, tap.weight)).unzip();
    let distribution = DepthDistribution::new(&depths, &weights).map_err(|_| empty())?;
    let texels: Vec<KernelRecord> = taps
        .iter()
        .map(|tap| KernelRecord {
            kernel: String::new(),
            x_texel: tap.x_kernel,
            y_texel: tap.y_kernel,
            depth: tap.depth,
        })
        .collect();
    let view = if picture.view.is_empty() {
        let of_scene = tables.views.iter().find(|view| view.scene == picture.scene);
        of_scene.map_or(String::new(), |view| view.view.clone())
    } else {
        picture.view.clone()
    };
    let place = format!("{} from {view}, texel ({}, {})", picture.scene, first.x_texel, first.y_texel);
    let title = match first.receiver {
        None => format!("The kernel at {place}"),
        Some(_) => format!("The kernel where {} errs most: {place}", picture.techniques[0]),
    };
    let mut entries = vec![(F_STROKE, "F (PCF)".to_owned())];
    let mut curves = Vec::new();
    let strokes = Stroke::of_techniques(picture.techniques.iter().map(String::as_str));
    for (i, (name, stroke)) in picture.techniques.iter().zip(strokes).enumerate() {
        let points = tables.curves.iter().filter(|r| r.picture == picture.id && r.technique == *name);
        // Good techniques coincide for long stretches: a wide line shows beneath a narrow one.
        let width = 5 + 3 * (picture.techniques.len() - 1 - i) as u32;
        let stroke = Stroke { width, ..stroke };
        curves.push(Curve {
            name: name.clone(),
            points: points.map(|r| (r.z_f, r.intensity)).collect(),
            stroke,
        });
        entries.push((stroke, name.clone()));
    }
    let arrows = first.receiver.map(|depth| Arrow {
        depth,
        tip: distribution.cdf_inclusive(depth) + 0.04,
        colour: GREEN,
        text: "the fragment".to_owned(),
    });
    let chart = Chart {
        title: String::new(),
        depths: (0.0, 1.0),
        x_label: DEPTH_LABEL,
        y_label: INTENSITY_LABEL,
        distribution: Some(&distribution),
        rug: true,
        curves,
        arrows: arrows.into_iter().collect(),
    };
    let kernel = ("layer 0", &texels.iter().collect::<Vec<_>>()[..], &[][..]);
    let svg = beside_charts((&picture.id, &title), kernel, (&[chart], CHART), &entries)?;
    Ok(Drawing { id: picture.id.clone(), title, svg })
}
