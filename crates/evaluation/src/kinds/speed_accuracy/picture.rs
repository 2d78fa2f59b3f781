//! Pictures of a scene with the shadows of several techniques side by side, and magnified parts below (MSM15 Figures 1,
//! 6 and 8). Computed on the CPU, so that they are the same everywhere.

use super::scenery::{SceneView, SpeedPlan};
use super::settings::PictureSetting;
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Seen, Source};
use crate::pictures::{png, side_by_side};
use crate::run_directory::RecordedFile;
use applications::Application;
use image::DynamicImage;
use rayon::prelude::*;
use shadow_filtering::{FilteringError, Position, Receiver};
use shadow_renderer::Frame;

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
        let seen = Seen { frame: &frame, light: fitted };
        let application = self.hard_shadow(&lit.map, lit.texel_depth, picture.bias);
        let mut columns =
            vec![frame.shade(light, &visibility(&seen, |receiver, _| application.truth(receiver) as f32))];
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
            let visibility = visibility(&seen, |receiver, at| {
                let mut moments = vec![0.0f32; channels];
                // A filtered map has an answer everywhere.
                let _ = technique.moments(&filtered, at, &mut moments);
                candidate.bounds(&moments, 0, application.compared(receiver) as f32)[0]
            });
            columns.push(frame.shade(light, &visibility));
        }
        let picture_name = format!("{}.png", picture.id);
        let all = side_by_side(&columns, picture.output, &picture.insets);
        png(picture_name, DynamicImage::from(all).to_rgb8().into())
    }
}

/// 1 minus the shadow of each pixel.
fn visibility(seen: &Seen<'_>, shadow: impl Fn(&Receiver, Position) -> f32 + Sync) -> Vec<f32> {
    let pixel = |i: usize| seen.receiver(i).map_or(1.0, |(receiver, at)| 1.0 - shadow(&receiver, at));
    (0..seen.len()).into_par_iter().map(pixel).collect()
}
