//! Scenes in their medium: by the truth of the shadow map, then by each technique, with magnified parts of stretched contrast
//! below (BHS16 Figures 4, 5 and 7), and grey maps of method - truth.

use super::records::ScatteringPictureRecord;
use super::run::Plan;
use super::settings::ScatteringPicture;
use super::shot::{Maps, Shot, Source};
use super::view::{LitScene, ScatteringScene};
use crate::error::EvaluationError;
use crate::kinds::filterable::map_name;
use crate::pictures::{neighbours, png, signed_grey, stretched_side_by_side};
use crate::run_directory::RecordedFile;
use crate::statistics::{percentile, rounded};
use applications::truths;
use image::{DynamicImage, GrayImage, Rgba, RgbaImage};
use rayon::prelude::*;
use scenes::vector::dot;
use shadow_renderer::NO_TRIANGLE;
use std::f64::consts::PI;

/// Truths of neighbours that differ by less belong to one smooth stretch.
const SMOOTH: f64 = 0.02;

/// Differences of neighbours' errors from here on are seen as a boundary.
const BOUNDARY: f64 = 0.05;

/// Linear RGB of light that the medium scatters: a sun's, warmer than the sky.
const SUNLIGHT: [f64; 3] = [1.0, 0.93, 0.8];

/// Rejects pictures of scenes, views or places that are not evaluated; an empty view means the first.
pub(super) fn check(plan: &Plan<'_>, scenes: &[ScatteringScene<'_>]) -> Result<(), EvaluationError> {
    for (i, picture) in plan.experiment.picture.iter().enumerate() {
        let known = scenes.iter().find(|scene| scene.label == picture.scene);
        let is_lit = |scene: &&ScatteringScene<'_>| {
            picture.view.is_empty() || scene.lights.iter().any(|light| light.name == picture.view)
        };
        let stands = plan.experiment.stands(&picture.standpoint, &format!("picture[{i}].standpoint"))?;
        if known.filter(is_lit).is_none() || !plan.experiment.standpoint[stands].is_in(&picture.scene) {
            let ScatteringPicture { id, scene, view, standpoint, .. } = picture;
            let reason = format!(
                "picture `{id}`: view `{view}` of scene `{scene}` is not evaluated from standpoint `{standpoint}`"
            );
            return Err(EvaluationError::key(format!("picture[{i}].view"), reason));
        }
    }
    Ok(())
}

/// The pictures of a light view with their error maps, and their rows.
pub(super) fn draw(
    plan: &Plan<'_>,
    scene: &ScatteringScene<'_>,
    (lit, source): (&LitScene<'_>, &Source<'_>),
    (files, rows): (&mut Vec<RecordedFile>, &mut Vec<ScatteringPictureRecord>),
) -> Result<(), EvaluationError> {
    for (index, picture) in plan.experiment.picture.iter().enumerate() {
        let is_first = scene.lights.first().is_some_and(|light| light.name == lit.light.name);
        let is_meant = picture.view == lit.light.name || (picture.view.is_empty() && is_first);
        if picture.scene == scene.label && is_meant {
            draw_one(plan, scene, (lit, source), (&format!("picture[{index}]"), picture), (files, rows))?;
        }
    }
    Ok(())
}

fn draw_one(
    plan: &Plan<'_>,
    scene: &ScatteringScene<'_>,
    (lit, source): (&LitScene<'_>, &Source<'_>),
    (key, picture): (&str, &ScatteringPicture),
    (files, rows): (&mut Vec<RecordedFile>, &mut Vec<ScatteringPictureRecord>),
) -> Result<(), EvaluationError> {
    let experiment = plan.experiment;
    let stands = experiment.stands(&picture.standpoint, &format!("{key}.standpoint"))?;
    let camera = experiment.standpoint[stands].camera(scene.scene, &scene.extent, lit.axes.light);
    let shot = Shot::new(lit, camera, picture.output, (&plan.noise, 0))?;
    let techniques = experiment.named(&picture.techniques, &format!("{key}.techniques"))?;
    let maps = Maps::new(experiment, &shot, source, &techniques)?;
    let truth = truths(&shot.view, &shot.rays);
    let air = Air::new(&shot, lit, &truth);
    let mut columns = vec![air.seen(&shot, &truth)];
    let [width, height] = picture.output;
    for index in techniques {
        let technique = &experiment.technique[index];
        let settings = (experiment.guard_band, experiment.scenery.seed);
        let method = technique.method.prepare(&shot, &maps, plan.techniques[index].as_ref(), settings)?;
        let shares: Vec<f64> = shot.rays.par_iter().map(|ray| method.lit(&shot.view, ray)).collect();
        let errors: Vec<f64> = shares
            .iter()
            .zip(&truth)
            .map(|(share, truth)| if share.is_finite() { share - truth } else { 0.0 })
            .collect();
        columns.push(air.seen(&shot, &shares));
        // Dark where light is missing, as for shadows: their map shows method - truth of the shadowed share.
        let grey = GrayImage::from_fn(width, height, |x, y| signed_grey(-errors[(y * width + x) as usize]));
        files.push(png(map_name(&picture.id, &picture.standpoint, &technique.name), grey.into())?);
        let [roughness, boundaries] = roughness(width as usize, &truth, &errors);
        rows.push(ScatteringPictureRecord {
            picture: picture.id.clone(),
            technique: technique.name.clone(),
            pixels: errors.len(),
            l1_error: rounded(
                errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len().max(1) as f64,
            ),
            roughness: rounded(roughness),
            boundaries: rounded(boundaries),
        });
    }
    let all = stretched_side_by_side(&columns, picture.output, &picture.insets, picture.stretch);
    files.push(png(format!("{}.png", picture.id), DynamicImage::from(all).to_rgb8().into())?);
    Ok(())
}

/// What lies between the camera and the scene.
struct Air {
    /// The surfaces with their shadows and without a medium, linear RGB, 0 to 1.
    surfaces: Vec<[f64; 3]>,
    /// What is left of them, and what a fully lit ray would add.
    transmitted: Vec<f64>,
    added: Vec<f64>,
}

/// Pictures of a view are exposed alike: the air of most pixels stays below this part of white, and so do surfaces, which are
/// dimmed for it.
const BRIGHT: f64 = 0.6;
const MOST: f64 = 0.9;
const SURFACES: f64 = 0.5;

impl Air {
    fn new(shot: &Shot<'_>, lit: &LitScene<'_>, truth: &[f64]) -> Self {
        let visible = |pixel: usize| {
            if shot.frame.triangle[pixel] == NO_TRIANGLE {
                return 1.0;
            }
            // A hundredth of a texel's way towards the light and the camera, off the surface itself.
            let position = shot.frame.position[pixel].map(f64::from);
            let normal = shot.frame.normal[pixel].map(f64::from);
            let [x, y, z] = shot.view.axes.direction(position);
            let slope = 1.0 / dot(normal, shot.view.axes.light).abs().max(0.05);
            let bias = shot.view.light.texel[0].max(shot.view.light.texel[1]) * slope;
            f32::from(u8::from(shot.view.light.is_lit([x, y, z - bias])))
        };
        let visibility: Vec<f32> = (0..shot.rays.len()).map(visible).collect();
        let shaded = shot.frame.shade(lit.light, &visibility);
        let surfaces = shaded.pixels().map(|pixel| [0, 1, 2].map(|k| linear(pixel[k]))).collect();
        let medium = &shot.view.medium;
        let transmitted = shot.rays.iter().map(|ray| medium.transmittance(ray.length)).collect();
        let full = |ray: &applications::scattering::ViewRay| {
            let phase = 4.0 * PI * medium.phase(shot.view.scattering_cosine(ray));
            medium.scattering() * phase * medium.transmitted_length(0.0, ray.length)
        };
        let mut added: Vec<f64> = shot.rays.iter().map(full).collect();
        let lit_air = added.iter().zip(truth).map(|(added, truth)| added * truth);
        let mut known: Vec<f64> = lit_air.filter(|value| value.is_finite()).collect();
        known.sort_by(f64::total_cmp);
        let bright = percentile(&known, MOST);
        let scale = if bright > 0.0 { BRIGHT / bright } else { 0.0 };
        // Without extinction the sky would be infinitely bright.
        added.iter_mut().for_each(|value| *value = if value.is_finite() { *value * scale } else { 1.0 });
        Self { surfaces, transmitted, added }
    }

    fn seen(&self, shot: &Shot<'_>, shares: &[f64]) -> RgbaImage {
        RgbaImage::from_fn(shot.frame.width, shot.frame.height, |x, y| {
            let i = (y * shot.frame.width + x) as usize;
            // An answer that is none stays dark; the records count it.
            let share = if shares[i].is_finite() { shares[i] } else { 0.0 };
            let [r, g, b] = [0, 1, 2].map(|k| {
                encoded(
                    SURFACES * self.transmitted[i] * self.surfaces[i][k]
                        + share * self.added[i] * SUNLIGHT[k],
                )
            });
            Rgba([r, g, b, 255])
        })
    }
}

/// sRGB to linear and back.
fn linear(code: u8) -> f64 {
    let value = f64::from(code) / 255.0;
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn encoded(value: f64) -> u8 {
    let value = value.clamp(0.0, 1.0);
    let code = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
    (255.0 * code + 0.5) as u8
}

/// Mean difference of the errors of neighbours whose truths are close, and the share of these pairs that is a boundary.
fn roughness(width: usize, truth: &[f64], errors: &[f64]) -> [f64; 2] {
    let (mut sum, mut boundaries, mut count) = (0.0, 0usize, 0usize);
    for (i, j) in neighbours(width, truth.len()) {
        if (truth[i] - truth[j]).abs() < SMOOTH {
            let difference = (errors[i] - errors[j]).abs();
            sum += difference;
            boundaries += usize::from(difference > BOUNDARY);
            count += 1;
        }
    }
    [sum / count.max(1) as f64, boundaries as f64 / count.max(1) as f64]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundaries_are_counted_and_smooth_errors_are_not() {
        let truth = [0.5; 64];
        let even: Vec<f64> = (0..64).map(|i| 0.01 * f64::from(i % 8)).collect();
        let edge: Vec<f64> = (0..64).map(|i| if i % 8 < 4 { 0.0 } else { 0.1 }).collect();
        assert_eq!(roughness(8, &truth, &even)[1], 0.0);
        let [mean, share] = roughness(8, &truth, &edge);
        assert!((share - 8.0 / 112.0).abs() < 1e-15 && (mean - 0.8 / 112.0).abs() < 1e-15, "{mean} {share}");
    }

    #[test]
    fn colours_come_back() {
        assert!((0..=255).all(|code| encoded(linear(code)) == code));
    }
}
