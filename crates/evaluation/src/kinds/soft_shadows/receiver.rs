//! One receiver with its search region: the depths, what moments make of them, where blockers are on average, and which
//! region is filtered.

use super::method::MethodSetting;
use super::picture::Place;
use super::records::{ReceiverRecord, ReconstructionPoint, SearchTexel};
use super::run::{Finding, SoftPlan};
use super::settings::SoftPicture;
use crate::error::EvaluationError;
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;
use applications::field::Fit;
use applications::region::Region;
use applications::soft_shadow::Fragment;

/// Depths from 0 to 1 at which a reconstruction is asked.
const DEPTHS: usize = 241;

/// Filters of at least so many texels across are shown.
const WIDE: f64 = 6.0;

/// The three tables of all receivers.
#[derive(Default)]
struct Tables {
    receivers: Vec<ReceiverRecord>,
    texels: Vec<SearchTexel>,
    points: Vec<ReconstructionPoint>,
}

pub(super) fn draw(
    plan: &SoftPlan<'_>,
    findings: &[Finding],
    best: &[Vec<usize>],
) -> Result<Vec<RecordedFile>, EvaluationError> {
    let mut tables = Tables::default();
    for (index, picture) in plan.experiment.receiver.iter().enumerate() {
        draw_one(plan, (findings, best), (&format!("receiver[{index}]"), picture), &mut tables)?;
    }
    if tables.receivers.is_empty() {
        return Ok(Vec::new());
    }
    Ok(vec![
        RecordedFile::csv("receivers.csv", &tables.receivers)?,
        RecordedFile::csv("kernels.csv", &tables.texels)?,
        RecordedFile::csv("curves.csv", &tables.points)?,
    ])
}

fn draw_one(
    plan: &SoftPlan<'_>,
    (findings, best): (&[Finding], &[Vec<usize>]),
    (key, picture): (&str, &SoftPicture),
    tables: &mut Tables,
) -> Result<(), EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("picture `{}`: {reason}", picture.id));
    let experiment = plan.experiment;
    let Place { view: number, light, techniques } = plan.place(picture, key)?;
    let (view, lit) = (&plan.views[number], plan.lit(number, light)?);
    let Some(finding) = findings.iter().find(|f| f.view == number && f.light == light) else {
        return Ok(());
    };
    let judged = &finding.judged[0];
    let (first, bias) = (techniques[0], best[techniques[0]][light]);
    let errors = judged.intensities[first][bias].iter().zip(&judged.truth);
    let errors = errors.map(|(&answer, truth)| (f64::from(answer) - truth.fraction).abs());
    // In a wide penumbra there is something to see; without any, wherever it errs most.
    let is_wide = |i: usize| judged.widths[i] >= WIDE;
    let any_wide = (0..judged.widths.len()).any(is_wide);
    let shown = errors.enumerate().filter(|(i, error)| error.is_finite() && (is_wide(*i) || !any_wide));
    let worst = shown.max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((worst, _)) = worst else { return Ok(()) };
    let point = &view.points[0][worst];
    let [x, y] = point.position;
    let depth = point.receiver.depth;
    let search = Region::around([x, y], lit.penumbra.search(depth));
    let size = [view.map.width(), view.map.height()];
    let pieces = |k: usize| Fit::Outwards.pieces(search.low[k], search.high[k], size[k]);
    let (columns, rows) = (pieces(0), pieces(1));
    for row in rows.as_slice().iter().flat_map(|piece| piece.first..=piece.last) {
        for column in columns.as_slice().iter().flat_map(|piece| piece.first..=piece.last) {
            tables.texels.push(SearchTexel {
                picture: picture.id.clone(),
                x_texel: column,
                y_texel: row,
                depth: rounded(f64::from(view.map.at(column as isize, row as isize))),
            });
        }
    }
    for index in techniques {
        let technique = &experiment.technique[index];
        let method = technique.method.prepare(lit.map, &lit.penumbra);
        let method = method.map_err(|error| fail(format!("technique `{}`: {error}", technique.name)))?;
        let receiver = view.receiver(point, &experiment.bias[best[index][light]]);
        let fragment = receiver.fragment;
        let blockers = method.blockers(&lit, &fragment).map_err(|error| fail(error.to_string()))?;
        let average = blockers.map_or(depth, |found| found.average(depth, technique.method.weight()));
        let [width, height] = technique.method.filtered(&lit.penumbra, depth, average);
        let intensity = method.estimate(&lit, &receiver).map_err(|error| fail(error.to_string()))?;
        tables.receivers.push(ReceiverRecord {
            picture: picture.id.clone(),
            scene: view.scene.loaded.label.to_owned(),
            view: view.light.name.clone(),
            technique: technique.name.clone(),
            x,
            y,
            depth: rounded(depth),
            compared: rounded(depth - fragment.bias),
            truth: rounded(judged.truth[worst].fraction),
            intensity: rounded(intensity),
            blockers: rounded(blockers.map_or(0.0, |found| found.mass)),
            average: rounded(average),
            width: rounded(width),
            height: rounded(height),
        });
        // The whole region's distribution is asked for its share in front of each depth.
        let whole = MethodSetting { search_bias: Some(1.0), ..technique.method.clone() };
        let whole = whole.prepare(lit.map, &lit.penumbra).map_err(|error| fail(error.to_string()))?;
        for step in 0..DEPTHS {
            let z = step as f64 / (DEPTHS - 1) as f64;
            let at = Fragment { bias: depth - z, ..fragment };
            let found = whole.blockers(&lit, &at).map_err(|error| fail(error.to_string()))?;
            tables.points.extend(found.map(|found| ReconstructionPoint {
                picture: picture.id.clone(),
                technique: technique.name.clone(),
                z_f: rounded(z),
                // A millionth of intensity is far below what a line shows.
                intensity: (found.mass * 1e6).round() / 1e6 + 0.0,
            }));
        }
    }
    Ok(())
}
