//! Pictures of a scene with the shadows of several techniques side by side, and magnified parts below (MSM15 Figures 1,
//! 6 and 8). Computed on the CPU, so that they are the same everywhere.

use super::scenery::{SceneView, SpeedPlan};
use super::settings::PictureSetting;
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Source};
use crate::run_directory::RecordedFile;
use applications::Application;
use image::{DynamicImage, ImageFormat, RgbaImage, imageops};
use rayon::prelude::*;
use shadow_filtering::{FilteringError, Position, Receiver};
use shadow_renderer::{Frame, LightFrame, NO_TRIANGLE};
use std::io::Cursor;

/// Pixels between pictures.
pub const PICTURE_GAP: u32 = 6;

impl SpeedPlan<'_> {
    /// One PNG for each picture: a column for the reference and for each technique.
    pub(crate) fn pictures(&self) -> Result<Vec<RecordedFile>, EvaluationError> {
        self.experiment.picture.iter().map(|picture| self.picture(picture)).collect()
    }

    /// The same for each of these scenes and views.
    pub(crate) fn pictures_of_views(
        &self,
        views: &[SceneView],
    ) -> Result<Vec<RecordedFile>, EvaluationError> {
        let views = views.iter().map(|view| (view.scene.as_str(), view.view.as_str()));
        self.experiment.pictures_of_views(views).iter().map(|picture| self.picture(picture)).collect()
    }

    fn picture(&self, picture: &PictureSetting) -> Result<RecordedFile, EvaluationError> {
        let fail = |reason: String| EvaluationError::Value(format!("picture `{}`: {reason}", picture.id));
        let experiment = self.experiment;
        // Without a name, the first view.
        let views = if picture.view.is_empty() { &[][..] } else { std::slice::from_ref(&picture.view) };
        let scenes = LoadedScene::load_all(std::slice::from_ref(&picture.scene), views)?;
        let (loaded, light) = (&scenes[0], &scenes[0].lights[0]);
        let Source::Scene(scene) = &loaded.source else {
            return Err(fail("a stack has no camera".to_owned()));
        };
        let lit = loaded.lit(light, experiment.scenery.size, &self.kernel)?;
        let [width, height] = picture.output;
        let frame = Frame::render(scene, width, height).map_err(|error| fail(error.to_string()))?;
        let Some(fitted) = &lit.frame else {
            return Err(fail("a stack has no light frame".to_owned()));
        };
        let surfaces = Surfaces { frame: &frame, light: fitted };
        let application = self.hard_shadow(&lit.map, lit.texel_depth, picture.bias);
        let mut columns =
            vec![frame.shade(light, &surfaces.visibility(|receiver, _| application.truth(receiver) as f32))];
        for name in &picture.techniques {
            let candidate = self
                .candidates
                .iter()
                .find(|candidate| format!("{}, {}", candidate.name, candidate.format) == *name)
                .ok_or_else(|| fail(format!("technique `{name}` is not a candidate")))?;
            let technique = candidate.technique();
            let filtered = technique
                .filtered(&lit.map, &self.kernel)
                .map_err(|error: FilteringError| fail(error.to_string()))?;
            let channels = candidate.channels();
            let visibility = surfaces.visibility(|receiver, at| {
                let mut moments = vec![0.0f32; channels];
                // A filtered map has an answer everywhere.
                let _ = technique.moments(&filtered, at, &mut moments);
                candidate.bounds(&moments, 0, application.compared(receiver) as f32)[0]
            });
            columns.push(frame.shade(light, &visibility));
        }
        let mut bytes = Vec::new();
        DynamicImage::from(composed(&columns, picture))
            .to_rgb8()
            .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
            .map_err(|error| fail(error.to_string()))?;
        Ok(RecordedFile { name: format!("{}.png", picture.id), bytes })
    }
}

struct Surfaces<'a> {
    frame: &'a Frame,
    light: &'a LightFrame,
}

impl Surfaces<'_> {
    /// 1 minus the shadow of each pixel.
    fn visibility(&self, shadow: impl Fn(&Receiver, Position) -> f32 + Sync) -> Vec<f32> {
        let light = self.light;
        let pixel = |i: usize| {
            if self.frame.triangle[i] == NO_TRIANGLE {
                return 1.0;
            }
            let [x, y, depth] = light.project(self.frame.position[i].map(f64::from));
            let inside = |t: f64, size: u32| (t.max(0.0) as usize).min(size as usize - 1);
            // The tangent plane in light space: its gradient makes the plane's tangents follow depth.
            let normal = self.frame.normal[i].map(f64::from);
            let dot = |axis: [f64; 3]| (0..3).map(|k| axis[k] * normal[k]).sum::<f64>();
            let along = dot(light.forward) * light.depth_range;
            let slope = |axis: [f64; 3], texels: f64| {
                let slope = -dot(axis) / (texels * along);
                if slope.is_finite() { slope } else { 0.0 }
            };
            let gradient =
                [slope(light.right, light.texels_per_unit[0]), slope(light.down, light.texels_per_unit[1])];
            let receiver =
                Receiver { x: inside(x, light.width), y: inside(y, light.height), depth, gradient };
            1.0 - shadow(&receiver, Position { x, y })
        };
        (0..self.frame.triangle.len()).into_par_iter().map(pixel).collect()
    }
}

/// Columns of pictures with their magnified parts below.
fn composed(columns: &[RgbaImage], picture: &PictureSetting) -> RgbaImage {
    let [width, height] = picture.output;
    let insets = picture.insets.len() as u32;
    let gaps = PICTURE_GAP * insets.saturating_sub(1);
    let side = width.saturating_sub(gaps).checked_div(insets).map_or(0, |side| side.max(1));
    let total = (
        columns.len() as u32 * (width + PICTURE_GAP) - PICTURE_GAP,
        height + if insets > 0 { PICTURE_GAP + side } else { 0 },
    );
    let mut all = RgbaImage::from_pixel(total.0, total.1, image::Rgba([255; 4]));
    for (column, image) in columns.iter().enumerate() {
        let left = column as u32 * (width + PICTURE_GAP);
        imageops::replace(&mut all, image, i64::from(left), 0);
        for (i, &[x, y, size]) in picture.insets.iter().enumerate() {
            let part = imageops::crop_imm(image, x, y, size, size).to_image();
            let large = imageops::resize(&part, side, side, imageops::FilterType::Nearest);
            let at = (left + i as u32 * (side + PICTURE_GAP), height + PICTURE_GAP);
            imageops::replace(&mut all, &large, i64::from(at.0), i64::from(at.1));
        }
    }
    all
}
