//! What techniques make of one receiver: the depths of its search region with the filters, and the share in front of every
//! depth, as it is and as the moments say.

use super::summary::SoftTables;
use crate::drawing::{Arrow, BLACK, Chart, Curve, DEPTH_LABEL, F_STROKE, Outlined, Stroke, beside_charts};
use crate::error::ReportError;
use crate::page::{Drawing, percent};
use evaluation::{KernelRecord, ReceiverRecord, SearchTexel, SoftPicture};
use moment_problem::DepthDistribution;

/// Height of the chart in pixels.
const CHART: u32 = 460;

pub(super) fn draw(tables: &SoftTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let drawn = tables.experiment.receiver.iter().map(|picture| one(tables, picture));
    Ok(drawn.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

fn one(tables: &SoftTables<'_>, picture: &SoftPicture) -> Result<Option<Drawing>, ReportError> {
    let texels: Vec<&SearchTexel> = tables.kernels.iter().filter(|t| t.picture == picture.id).collect();
    let rows: Vec<&ReceiverRecord> = tables.receivers.iter().filter(|r| r.picture == picture.id).collect();
    let (Some(first), Some(left), Some(top)) =
        (rows.first(), texels.iter().map(|t| t.x_texel).min(), texels.iter().map(|t| t.y_texel).min())
    else {
        return Ok(None);
    };
    let depths: Vec<f64> = texels.iter().map(|t| t.depth).collect();
    let distribution = DepthDistribution::new(&depths, &vec![1.0 / depths.len() as f64; depths.len()])
        .map_err(|_| ReportError::Empty { figure: picture.id.clone() })?;
    let kernel: Vec<KernelRecord> = texels
        .iter()
        .map(|t| KernelRecord {
            kernel: String::new(),
            x_texel: t.x_texel - left,
            y_texel: t.y_texel - top,
            depth: t.depth,
        })
        .collect();
    let mut entries = vec![(F_STROKE, "texels of the search region".to_owned())];
    let (mut curves, mut outlined) = (Vec::new(), Vec::new());
    let mut arrows = vec![Arrow {
        depth: first.depth,
        tip: distribution.cdf_inclusive(first.depth) + 0.04,
        colour: BLACK,
        text: format!("receiver, truth {}", percent(first.truth, 0)),
    }];
    let strokes = Stroke::of_techniques(rows.iter().map(|row| row.technique.as_str()));
    for (row, stroke) in rows.iter().zip(strokes) {
        let colour = stroke.colour;
        let points = tables.curves.iter().filter(|p| p.picture == picture.id && p.technique == row.technique);
        let points: Vec<(f64, Option<f64>)> = points.map(|p| (p.z_f, Some(p.intensity))).collect();
        entries.push((
            stroke,
            format!(
                "{}: {} by {:.0} x {:.0}",
                row.technique,
                percent(row.intensity, 0),
                row.width,
                row.height
            ),
        ));
        arrows.push(Arrow {
            depth: row.average,
            tip: distribution.cdf_inclusive(row.average) + 0.04,
            colour,
            text: "blockers on average".to_owned(),
        });
        curves.push(Curve { name: row.technique.clone(), points, stroke });
        let corner = [row.x - 0.5 * row.width - left as f64, row.y - 0.5 * row.height - top as f64];
        outlined.push(Outlined { corner, size: [row.width, row.height], colour });
    }
    let chart = Chart {
        title: String::new(),
        depths: (0.0, 1.0),
        x_label: DEPTH_LABEL,
        y_label: "share of the search region in front (fraction)",
        distribution: Some(&distribution),
        rug: true,
        curves,
        arrows,
    };
    let title = format!(
        "Where {} errs most in a wide penumbra: {} from {}, texel ({:.0}, {:.0})",
        first.technique,
        first.scene,
        first.view,
        first.x.floor(),
        first.y.floor()
    );
    let texels: Vec<&KernelRecord> = kernel.iter().collect();
    let svg = beside_charts(
        (&picture.id, &title),
        ("search region", &texels, &outlined),
        (&[chart], CHART),
        &entries,
    )?;
    Ok(Some(Drawing::new(picture.id.clone(), title, svg)))
}
