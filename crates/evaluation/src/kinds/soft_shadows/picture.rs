//! Scenes from their cameras: the truth, then each technique, with magnified parts below (BHS16 Figures 10 to 13), and
//! grey maps of method - truth.

use super::records::SoftPictureRecord;
use super::run::SoftPlan;
use super::settings::SoftPicture;
use super::view::{Point, SoftView};
use crate::error::EvaluationError;
use crate::kinds::filterable::map_name;
use crate::pictures::{png, side_by_side, signed_grey};
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;
use applications::Application;
use image::{DynamicImage, GrayImage};
use rayon::prelude::*;
use shadow_renderer::Frame;

/// Truths of neighbours that differ by less belong to one smooth stretch.
const SMOOTH: f64 = 0.05;

/// Where a picture is taken, and what it shows.
pub(super) struct Place {
    pub(super) view: usize,
    pub(super) light: usize,
    pub(super) techniques: Vec<usize>,
}

/// Rejects pictures of scenes or views that are not evaluated; an empty view means the first.
pub(super) fn check(plan: &SoftPlan<'_>) -> Result<(), EvaluationError> {
    let experiment = plan.experiment;
    let pictures = experiment.picture.iter().enumerate();
    for (i, picture) in pictures {
        plan.place(picture, &format!("picture[{i}]"))?;
    }
    for (i, picture) in experiment.receiver.iter().enumerate() {
        plan.place(picture, &format!("receiver[{i}]"))?;
    }
    Ok(())
}

impl SoftPlan<'_> {
    /// Where a picture is taken.
    pub(super) fn place(&self, picture: &SoftPicture, key: &str) -> Result<Place, EvaluationError> {
        let (id, scene, name) = (&picture.id, &picture.scene, &picture.view);
        let light = self.experiment.lit_by(&picture.light, &format!("{key}.light"))?;
        let setting = &self.experiment.light[light];
        let is_meant = |view: &SoftView<'_>| {
            let is_lit = setting.shines_on(view.light) && view.scene.loaded.label == scene.as_str();
            is_lit && (name.is_empty() || view.light.name == *name)
        };
        let techniques = self.experiment.named(&picture.techniques, &format!("{key}.techniques"))?;
        let view = self.views.iter().position(is_meant).ok_or_else(|| {
            let light = &setting.name;
            let reason = format!(
                "picture `{id}`: view `{name}` of scene `{scene}` is not evaluated under light `{light}`"
            );
            EvaluationError::key(format!("{key}.view"), reason)
        })?;
        Ok(Place { view, light, techniques })
    }
}

/// All pictures with their error maps and pictures.csv.
pub(super) fn draw(plan: &SoftPlan<'_>, best: &[Vec<usize>]) -> Result<Vec<RecordedFile>, EvaluationError> {
    let (mut files, mut rows) = (Vec::new(), Vec::new());
    for (index, picture) in plan.experiment.picture.iter().enumerate() {
        draw_one(plan, best, (&format!("picture[{index}]"), picture), (&mut files, &mut rows))?;
    }
    if !rows.is_empty() {
        files.push(RecordedFile::csv("pictures.csv", &rows)?);
    }
    Ok(files)
}

fn draw_one(
    plan: &SoftPlan<'_>,
    best: &[Vec<usize>],
    (key, picture): (&str, &SoftPicture),
    (files, rows): (&mut Vec<RecordedFile>, &mut Vec<SoftPictureRecord>),
) -> Result<(), EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("picture `{}`: {reason}", picture.id));
    let experiment = plan.experiment;
    let Place { view, light, techniques } = plan.place(picture, key)?;
    let (view, lit) = (&plan.views[view], plan.lit(view, light)?);
    let output @ [width, height] = picture.size();
    let frame = Frame::render(view.scene.scene, width, height).map_err(|error| fail(error.to_string()))?;
    let points = view.of_camera(&frame, &plan.noise);
    let shadows = |shade: &(dyn Fn(&Point) -> f64 + Sync)| -> Vec<Option<f64>> {
        points.par_iter().map(|point| point.as_ref().map(shade)).collect()
    };
    let shaded = |shadows: &[Option<f64>]| {
        // Surfaces that face away from the light are dark by their cosine.
        let visibility: Vec<f32> = shadows.iter().map(|shadow| 1.0 - shadow.unwrap_or(0.0) as f32).collect();
        frame.shade(view.light, &visibility)
    };
    let truth = shadows(&|point| lit.truth(&view.receiver(point, &experiment.bias[0])));
    let mut columns = vec![shaded(&truth)];
    for index in techniques {
        let technique = &experiment.technique[index];
        let bias = best[index][light];
        let method = technique.method.prepare(lit.map, &lit.penumbra);
        let method = method.map_err(|error| fail(format!("technique `{}`: {error}", technique.name)))?;
        let shadow = shadows(&|point| {
            let receiver = view.receiver(point, &experiment.bias[bias]);
            // What a table cannot sum stays lit; the records count it.
            method.estimate(&lit, &receiver).unwrap_or(0.0)
        });
        columns.push(shaded(&shadow));
        let pairs = truth.iter().zip(&shadow);
        let errors: Vec<Option<f64>> =
            pairs.map(|(truth, shadow)| truth.zip(*shadow).map(|(truth, shadow)| shadow - truth)).collect();
        let grey = GrayImage::from_fn(width, height, |x, y| {
            signed_grey(errors[(y * width + x) as usize].unwrap_or(0.0))
        });
        files.push(png(map_name(&picture.id, &picture.light, &technique.name), grey.into())?);
        let known: Vec<f64> = errors.iter().flatten().map(|error| error.abs()).collect();
        rows.push(SoftPictureRecord {
            picture: picture.id.clone(),
            technique: technique.name.clone(),
            bias,
            pixels: known.len(),
            mean_error: rounded(known.iter().sum::<f64>() / known.len().max(1) as f64),
            roughness: rounded(roughness(width as usize, &truth, &errors)),
        });
    }
    let all = side_by_side(&columns, output, &picture.insets);
    files.push(png(format!("{}.png", picture.id), DynamicImage::from(all).to_rgb8().into())?);
    Ok(())
}

/// Mean difference of the errors of neighbours whose truths are close and lie in a penumbra: stripes and noise.
fn roughness(width: usize, truth: &[Option<f64>], errors: &[Option<f64>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for (i, (t, e)) in truth.iter().zip(errors).enumerate() {
        let right = (i % width + 1 < width).then_some(i + 1);
        let below = (i + width < truth.len()).then_some(i + width);
        for j in [right, below].into_iter().flatten() {
            if let (Some(t), Some(e), Some(other), Some(error)) = (*t, *e, truth[j], errors[j])
                && (t - other).abs() < SMOOTH
                && (0.01..=0.99).contains(&t)
            {
                sum += (e - error).abs();
                count += 1;
            }
        }
    }
    sum / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripes_are_rough_and_constant_errors_are_not() {
        let truth: Vec<Option<f64>> = (0..64).map(|i| Some(0.5 + 0.001 * f64::from(i % 8))).collect();
        let even = vec![Some(0.2); 64];
        let stripes: Vec<Option<f64>> = (0..64).map(|i| Some(if i % 2 == 0 { 0.1 } else { -0.1 })).collect();
        assert_eq!(roughness(8, &truth, &even), 0.0);
        assert!(roughness(8, &truth, &stripes) > 0.09);
        assert_eq!(roughness(8, &[None; 64], &stripes), 0.0);
    }
}
