//! Frames of a path that a page can play: techniques side by side, one frame below the other in one picture.

use super::judge::At;
use super::picture::shaded;
use super::run::Lighting;
use super::settings::TemporalShadowsExperiment;
use crate::error::EvaluationError;
use crate::lit_frames::Stage;
use crate::pictures::{PICTURE_GAP, side_by_side, small_png};
use crate::run_directory::RecordedFile;
use image::{DynamicImage, RgbaImage, imageops};
use serde::{Deserialize, Serialize};

/// What is shown of a path frame by frame, by techniques that gather.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TemporalAnimation {
    /// File name without extension.
    pub id: String,
    /// Scene, as in `scenes`.
    pub scene: String,
    /// View; the first without one.
    #[serde(default)]
    pub view: String,
    /// Name of a light.
    pub light: String,
    /// Name of a path.
    pub path: String,
    /// Names of techniques.
    pub techniques: Vec<String>,
    /// Each so many frames one is shown, the first among them.
    pub every: usize,
}

impl TemporalAnimation {
    /// Frames that are shown of a path of so many.
    pub fn shown(&self, frames: usize) -> usize {
        frames.div_ceil(self.every)
    }

    /// Width and height of a frame whose columns are so large.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let columns = self.techniques.len() as u32;
        [columns * width + columns.saturating_sub(1) * PICTURE_GAP, height]
    }
}

/// An animation as far as it is known.
#[derive(Clone)]
pub(super) struct Reel<'a> {
    setting: &'a TemporalAnimation,
    view: String,
    techniques: Vec<usize>,
    frames: Vec<RgbaImage>,
}

impl<'a> Reel<'a> {
    /// Rejects animations of scenes and views that are not evaluated.
    pub(super) fn all(
        experiment: &'a TemporalShadowsExperiment,
        stages: &[Stage],
    ) -> Result<Vec<Self>, EvaluationError> {
        let of = |(i, setting): (usize, &'a TemporalAnimation)| -> Result<Self, EvaluationError> {
            let place = format!("animation[{i}]");
            let view = experiment.view_of(
                stages,
                ("animation", &setting.id, &place),
                (&setting.scene, &setting.view),
            )?;
            let index = |name: &String| experiment.technique.iter().position(|t| t.name == *name);
            let techniques = setting.techniques.iter().filter_map(index).collect();
            Ok(Self { setting, view, techniques, frames: Vec::new() })
        };
        experiment.animation.iter().enumerate().map(of).collect()
    }

    /// Takes what a frame shows, if it belongs to the animation.
    pub(super) fn take(&mut self, at: &At<'_>, names: [&str; 2], lighting: &Lighting<'_>) {
        let [light, path] = names;
        let setting = self.setting;
        let is_here = setting.scene == at.stage.label
            && self.view == lighting.light.view.name
            && setting.light == light
            && setting.path == path;
        if !is_here || !at.frame.is_multiple_of(setting.every) {
            return;
        }
        let column = |&technique: &usize| {
            let track = lighting.tracks.get(technique)?.as_ref()?;
            let shadows: Vec<Option<f64>> =
                track.shown.iter().map(|shaded| shaded.map(|shaded| shaded.shadow)).collect();
            Some(shaded(at.sight, &lighting.light.view, &shadows))
        };
        let columns: Vec<RgbaImage> = self.techniques.iter().filter_map(column).collect();
        if let Some(first) = columns.first() {
            let size = [first.width(), first.height()];
            self.frames.push(side_by_side(&columns, size, &[]));
        }
    }

    /// All frames, one below the other; nothing of other paths.
    pub(super) fn file(&self) -> Result<Option<RecordedFile>, EvaluationError> {
        let Some(first) = self.frames.first() else { return Ok(None) };
        let [width, height] = [first.width(), first.height()];
        let mut all = RgbaImage::new(width, height * self.frames.len() as u32);
        for (i, frame) in self.frames.iter().enumerate() {
            imageops::replace(&mut all, frame, 0, i64::from(height) * i as i64);
        }
        let name = format!("{}.png", self.setting.id);
        small_png(name, &DynamicImage::from(all).to_rgb8().into()).map(Some)
    }
}
