//! Pictures of what is recommended: the reference, the recommended technique and the next cheaper one from the scene's camera,
//! with the parts magnified where they differ most, and where they differ at all.

use super::hard::HardCourse;
use super::race::Race;
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Seen, Source};
use crate::kinds::speed_accuracy::FreeParameters;
use crate::pictures::{png, side_by_side, signed_grey};
use crate::run_directory::RecordedFile;
use applications::Application;
use image::{DynamicImage, GrayImage, RgbaImage};
use rayon::prelude::*;
use shadow_filtering::{FilteringError, Position, Receiver};
use shadow_renderer::Frame;

/// Pixels of a picture.
const SIZE: [u32; 2] = [1920, 1080];

/// Side of a magnified part in pixels, and how many there are.
const INSET: u32 = 120;
const INSETS: usize = 3;

/// The first view: reference.png, recommended.png, next-cheaper.png, difference maps of both, and comparison.png with all of
/// them side by side.
pub(super) fn draw(
    loaded: &LoadedScene<'_>,
    race: &Race<HardCourse<'_>>,
    (used, cheaper): (usize, Option<usize>),
) -> Result<Vec<RecordedFile>, EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("picture: {reason}"));
    let (plan, views) = (race.course.plan(), race.course.views());
    let (Source::Scene(scene), Some(view)) = (&loaded.source, views.first()) else {
        return Err(fail("a stack has no camera".to_owned()));
    };
    let Some(light) = &view.frame else { return Err(fail("a stack has no light frame".to_owned())) };
    let frame = Frame::render(scene, SIZE[0], SIZE[1]).map_err(|error| fail(error.to_string()))?;
    let seen = Seen { frame: &frame, light };
    let shadows = |shadow: &(dyn Fn(&Receiver, Position) -> f32 + Sync)| -> Vec<f32> {
        let pixel = |i: usize| seen.receiver(i).map_or(0.0, |(receiver, at)| shadow(&receiver, at));
        (0..seen.len()).into_par_iter().map(pixel).collect()
    };
    let shaded = |shadows: &[f32]| {
        let visibility: Vec<f32> = shadows.iter().map(|shadow| 1.0 - shadow).collect();
        frame.shade(&view.light, &visibility)
    };
    let reference = plan.hard_shadow(&view.map, view.texel_depth, shadow_filtering::DepthBias::default());
    let truth = shadows(&|receiver, _| reference.truth(receiver) as f32);
    let mut columns: Vec<(&str, RgbaImage)> = vec![("reference", shaded(&truth))];
    let (mut files, mut insets) = (Vec::new(), Vec::new());
    for (name, arm) in [("recommended", Some(used)), ("next-cheaper", cheaper)] {
        let Some(arm) = arm else { continue };
        let (candidate, divisor, FreeParameters { index, bias, blend, .. }) =
            race.course.place(arm, race.best_variant(arm).0);
        let candidate = &plan.candidates[candidate];
        let (technique, kernel) = (candidate.technique(), &plan.kernels[divisor]);
        let Some(map) = &view.maps[divisor] else { continue };
        let filtered =
            technique.filtered(map, kernel).map_err(|error: FilteringError| fail(error.to_string()))?;
        let scale = f64::from(plan.experiment.divisors[divisor]);
        let limit = plan.experiment.scenery.plane_limit;
        let shadow = shadows(&|receiver, at| {
            let mut moments = vec![0.0f32; technique.channels()];
            // A filtered map has an answer everywhere.
            let at = Position { x: at.x / scale, y: at.y / scale };
            let _ = technique.moments(&filtered, at, &mut moments);
            let own = Receiver { gradient: receiver.gradient.map(|slope| slope * scale), ..*receiver };
            let z = bias.compared(&own, view.texel_depth * scale, limit);
            blend.apply(candidate.bounds(&moments, index, z as f32))
        });
        columns.push((name, shaded(&shadow)));
        let errors: Vec<f32> = shadow.iter().zip(&truth).map(|(shadow, truth)| shadow - truth).collect();
        if insets.is_empty() {
            insets = worst_parts(&errors);
        }
        let grey = GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| {
            signed_grey(f64::from(errors[(y * SIZE[0] + x) as usize]))
        });
        files.push(png(format!("{name}-difference.png"), grey.into())?);
    }
    for (name, picture) in &columns {
        files.push(png(format!("{name}.png"), DynamicImage::from(picture.clone()).to_rgb8().into())?);
    }
    let pictures: Vec<RgbaImage> = columns.into_iter().map(|(_, picture)| picture).collect();
    let all = side_by_side(&pictures, SIZE, &insets);
    files.push(png("comparison.png".to_owned(), DynamicImage::from(all).to_rgb8().into())?);
    Ok(files)
}

/// Left, top and side of the parts of largest mean |error|, apart from each other.
fn worst_parts(errors: &[f32]) -> Vec<[u32; 3]> {
    let [width, height] = SIZE;
    let mean = |left: u32, top: u32| -> f32 {
        let row = |y: u32| {
            let start = (y * width + left) as usize;
            errors[start..start + INSET as usize].iter().map(|error| error.abs()).sum::<f32>()
        };
        (top..top + INSET).map(row).sum()
    };
    let places = (0..width / INSET).flat_map(|x| (0..height / INSET).map(move |y| [x * INSET, y * INSET]));
    let mut parts: Vec<(f32, [u32; 2])> = places.map(|[x, y]| (mean(x, y), [x, y])).collect();
    parts.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    parts.into_iter().take(INSETS).map(|(_, [x, y])| [x, y, INSET]).collect()
}
