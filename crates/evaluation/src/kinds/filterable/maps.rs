//! Signed error maps in light space: one grey PNG per technique and view, 128 where G = F, one step 1/127 of intensity,
//! darker where light leaks, brighter where the shadow is too dark. A texel shows its fragment of largest error.

use super::plan::FilterablePlan;
use super::view::View;
use crate::error::EvaluationError;
use crate::experiment::keys::words;
use crate::pictures::{png, signed_grey};
use crate::run_directory::RecordedFile;
use applications::errors;
use image::GrayImage;

/// The maps of a view, if the experiment wants any.
pub(crate) fn draw(plan: &FilterablePlan<'_>, view: &View) -> Result<Vec<RecordedFile>, EvaluationError> {
    let settings = &plan.experiment.maps;
    if !settings.covers(&view.scene, &view.name) {
        return Ok(Vec::new());
    }
    let application = plan.hard_shadow(view, 0);
    let mut files = Vec::new();
    let techniques = plan.experiment.technique.iter().zip(&plan.methods);
    for (technique, method) in techniques.filter(|(technique, _)| settings.shows(technique)) {
        let fail = |error| technique.failure(error);
        let shader = method.prepare(&view.map, &plan.kernel).map_err(fail)?;
        let errors = errors(&application, &shader, &view.receivers).map_err(fail)?;
        let image = reduced(view, settings.size, &errors);
        let scene = plan.experiment.scenery.words(&view.scene);
        files.push(png(map_name(&scene, &view.name, &technique.name), image.into())?);
    }
    Ok(files)
}

/// File name of the error map of a technique and view, the scene as
/// [`SceneSettings::words`](crate::SceneSettings::words) has it.
pub fn map_name(scene: &str, view: &str, technique: &str) -> String {
    format!("map-{scene}-{}-{}.png", words(view), words(technique))
}

/// The error of largest size in each block of texels, as grey.
fn reduced(view: &View, limit: u32, errors: &[f64]) -> GrayImage {
    let size = view.map.width().max(view.map.height());
    let block = size.div_ceil(limit.max(1) as usize).max(1);
    let (width, height) = (view.map.width().div_ceil(block), view.map.height().div_ceil(block));
    let mut worst = vec![0.0f64; width * height];
    for (receiver, &error) in view.receivers.iter().zip(errors) {
        let value = &mut worst[receiver.y / block * width + receiver.x / block];
        if error.abs() > value.abs() {
            *value = error;
        }
    }
    GrayImage::from_fn(width as u32, height as u32, |x, y| {
        signed_grey(worst[y as usize * width + x as usize])
    })
}

#[cfg(test)]
mod tests {
    use super::map_name;

    #[test]
    fn names_are_plain_file_names() {
        let name = map_name("tower", "low sun", "EVSM 4, c = 5.54");
        assert_eq!(name, "map-tower-low-sun-evsm-4-c-5-54.png");
    }
}
