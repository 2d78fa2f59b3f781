//! Pictures of frames: the truth, then techniques, each beside the other and with magnified parts below.

use super::animation::Reel;
use super::judge::At;
use super::records::TemporalPictureRecord;
use super::run::{Lighting, LitPixels, Plan};
use super::settings::{TemporalPicture, TemporalShadowsExperiment};
use crate::error::EvaluationError;
use crate::kinds::filterable::map_name;
use crate::lit_frames::{Lit, MappedLight, Ready, Sight, Stage};
use crate::pictures::{png, side_by_side, signed_grey};
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;
use applications::temporal::Shaded;
use image::{DynamicImage, GrayImage, RgbaImage, imageops};
use rayon::prelude::*;
use scenes::LightView;

/// A judged frame under a light.
pub(super) struct Shown<'a> {
    pub(super) at: &'a At<'a>,
    pub(super) light: &'a MappedLight,
    pub(super) lit: &'a LitPixels,
    pub(super) setting: usize,
}

/// A column of a picture.
#[derive(Clone)]
struct Cell {
    technique: usize,
    /// Counted from 1.
    frame: usize,
    shadows: Vec<Option<f64>>,
    image: RgbaImage,
}

/// A picture as far as it is known.
#[derive(Clone)]
struct Page<'a> {
    setting: &'a TemporalPicture,
    view: String,
    cells: Vec<Cell>,
    truth: Option<(Vec<Option<f64>>, RgbaImage)>,
    /// Pixels of the picture, row by row, in the buffer.
    constant: bool,
}

/// All pictures of a run.
#[derive(Clone)]
pub(super) struct Album<'a> {
    experiment: &'a TemporalShadowsExperiment,
    pages: Vec<Page<'a>>,
    reels: Vec<Reel<'a>>,
}

/// Pictures, and rows with the places of their pictures.
type Drawn = (Vec<RecordedFile>, Vec<(usize, TemporalPictureRecord)>);

impl<'a> Album<'a> {
    /// Rejects pictures of scenes and views that are not evaluated.
    pub(super) fn new(
        experiment: &'a TemporalShadowsExperiment,
        stages: &[Stage],
    ) -> Result<Self, EvaluationError> {
        let mut pages = Vec::new();
        for (i, setting) in experiment.picture.iter().enumerate() {
            let place = format!("picture[{i}]");
            let scene = (setting.scene.as_str(), setting.view.as_str());
            let view = experiment.view_of(stages, ("picture", &setting.id, &place), scene)?;
            pages.push(Page { setting, view, cells: Vec::new(), truth: None, constant: false });
        }
        Ok(Self { experiment, pages, reels: Reel::all(experiment, stages)? })
    }

    /// What a frame has for the animations, judged or not.
    pub(super) fn film(&mut self, at: &At<'_>, lighting: &Lighting<'_>) {
        let names = [&self.experiment.light[lighting.setting].name, &self.experiment.path[at.path].name]
            .map(String::as_str);
        self.reels.iter_mut().for_each(|reel| reel.take(at, names, lighting));
    }

    /// What a frame has for the pictures.
    pub(super) fn take<'t>(
        &mut self,
        plan: &Plan<'_>,
        shown: &Shown<'_>,
        lit: &Lit<'_>,
        tracks: impl Fn(usize) -> Option<&'t [Option<Shaded>]>,
    ) -> Result<(), EvaluationError> {
        let experiment = self.experiment;
        let (at, frame) = (shown.at, shown.at.frame + 1);
        for page in &mut self.pages {
            let setting = page.setting;
            let is_here = setting.scene == at.stage.label
                && page.view == shown.light.view.name
                && setting.light == experiment.light[shown.setting].name
                && setting.path == experiment.path[at.path].name;
            if !is_here || !setting.frames.contains(&frame) {
                continue;
            }
            page.constant = at.constant;
            for name in &setting.techniques {
                let Some(technique) = experiment.technique.iter().position(|t| t.name == *name) else {
                    continue;
                };
                let shadows = match tracks(technique) {
                    Some(shaded) => shaded.iter().map(|shaded| shaded.map(|shaded| shaded.shadow)).collect(),
                    None => made_anew(plan, shown, lit, technique)?,
                };
                let image = shown.picture(&shadows);
                page.cells.push(Cell { technique, frame, shadows, image });
            }
            if setting.frames.iter().max() == Some(&frame) {
                let truth = |pixel: usize| {
                    let seen = shown.lit.seen[pixel].filter(|_| at.sight.is_shown(pixel))?;
                    let surface = seen.surface(lit.triangles, at.largest);
                    let (position, from) = (surface.position, Some(surface.triangle));
                    let light = &shown.light.placed;
                    let stream = pixel as u64;
                    Some(plan.truth.occluded_fraction(lit.triangles, light, position, from, stream).fraction)
                };
                let truth: Vec<Option<f64>> =
                    (0..shown.lit.pixels.len()).into_par_iter().map(truth).collect();
                let image = shown.picture(&truth);
                page.truth = Some((truth, image));
            }
        }
        Ok(())
    }

    /// Pictures, grey maps of shadow - truth in the last frame, and the rows of pictures.csv, each with its picture's place.
    pub(super) fn files(&self) -> Result<Drawn, EvaluationError> {
        let (mut files, mut rows) = (Vec::new(), Vec::new());
        for reel in &self.reels {
            files.extend(reel.file()?);
        }
        let [width, height] = self.experiment.camera;
        for (place, page) in self.pages.iter().enumerate() {
            let Some((truth, image)) = &page.truth else { continue };
            let setting = page.setting;
            let mut columns = vec![image.clone()];
            let last = setting.frames.iter().max().copied().unwrap_or_default();
            // By technique, then frame, as they are named.
            let mut cells: Vec<&Cell> = page.cells.iter().collect();
            cells.sort_by_key(|cell| {
                let name = &self.experiment.technique[cell.technique].name;
                (setting.techniques.iter().position(|t| t == name), cell.frame)
            });
            for cell in cells {
                columns.push(cell.image.clone());
                let technique = self.experiment.technique[cell.technique].name.clone();
                let pairs = truth.iter().zip(&cell.shadows);
                let errors: Vec<f64> =
                    pairs.filter_map(|(truth, shadow)| truth.zip(*shadow).map(|(t, s)| s - t)).collect();
                let is_comparable = page.constant || cell.frame == last;
                let mean = errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len().max(1) as f64;
                if cell.frame == last {
                    let grey = cell.grey(truth, [width, height], self.experiment.window().margin());
                    files.push(png(map_name(&setting.id, &setting.light, &technique), grey.into())?);
                }
                let row = TemporalPictureRecord {
                    picture: setting.id.clone(),
                    technique,
                    frame: cell.frame,
                    pixels: errors.len(),
                    l1_error: is_comparable.then(|| rounded(mean)),
                };
                rows.push((place, row));
            }
            let all = side_by_side(&columns, [width, height], &setting.insets);
            files.push(png(format!("{}.png", setting.id), DynamicImage::from(all).to_rgb8().into())?);
        }
        Ok((files, rows))
    }
}

impl Cell {
    fn grey(&self, truth: &[Option<f64>], [width, height]: [u32; 2], margin: [u32; 2]) -> GrayImage {
        let whole = width + 2 * margin[0];
        GrayImage::from_fn(width, height, |x, y| {
            let i = ((y + margin[1]) * whole + x + margin[0]) as usize;
            signed_grey(truth[i].zip(self.shadows[i]).map_or(0.0, |(truth, shadow)| shadow - truth))
        })
    }
}

impl Shown<'_> {
    /// The frame without its border.
    fn picture(&self, shadows: &[Option<f64>]) -> RgbaImage {
        shaded(self.at.sight, &self.light.view, shadows)
    }
}

/// A frame under a light, without its border.
pub(super) fn shaded(sight: &Sight, light: &LightView, shadows: &[Option<f64>]) -> RgbaImage {
    // Surfaces that face away from the light are dark by their cosine.
    let visibility: Vec<f32> = shadows.iter().map(|shadow| 1.0 - shadow.unwrap_or(0.0) as f32).collect();
    let whole = sight.frame.shade(light, &visibility);
    let [x, y] = sight.margin;
    imageops::crop_imm(&whole, x, y, whole.width() - 2 * x, whole.height() - 2 * y).to_image()
}

/// Every pixel by a method without memory; what fails stays lit, and the records count it.
fn made_anew(
    plan: &Plan<'_>,
    shown: &Shown<'_>,
    lit: &Lit<'_>,
    index: usize,
) -> Result<Vec<Option<f64>>, EvaluationError> {
    let technique = &plan.experiment.technique[index];
    let fail = |error: String| EvaluationError::Value(format!("technique `{}`: {error}", technique.name));
    let method = technique.choice.anew().ok_or_else(|| fail("has no frame here".to_owned()))?;
    let seed = plan.experiment.scenery.seed;
    let ready = Ready::new(method, lit, seed).map_err(|error| fail(error.to_string()))?;
    let one = |pixel: usize| {
        let seen = shown.lit.seen[pixel].as_ref()?;
        Some(ready.shadow(lit, plan.bias(index), seen, seen.position).unwrap_or(0.0))
    };
    Ok((0..shown.lit.seen.len()).into_par_iter().map(one).collect())
}
