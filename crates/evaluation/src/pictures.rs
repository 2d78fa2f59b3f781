//! Pictures side by side with magnified parts below, and what their settings may say.

use crate::error::EvaluationError;
use crate::experiment::keys::{file_name, refuse};
use crate::fragments::MAX_SIZE;
use crate::run_directory::RecordedFile;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ImageFormat, Luma, RgbaImage, imageops};
use std::io::Cursor;

/// Pixels between pictures.
pub const PICTURE_GAP: u32 = 6;

/// Rejects pictures without pixels and squares that leave them; the reason names the key and value.
pub(crate) fn check_output([width, height]: [u32; 2], insets: &[[u32; 3]]) -> Result<(), String> {
    if width == 0 || height == 0 || width > MAX_SIZE || height > MAX_SIZE {
        return Err(format!("output = {width}x{height} is not between 1 and {MAX_SIZE}"));
    }
    for &[x, y, side] in insets {
        let end = |start: u32| u64::from(start) + u64::from(side);
        if side == 0 || end(x) > u64::from(width) || end(y) > u64::from(height) {
            return Err(format!("inset [{x}, {y}, {side}] is not inside {width}x{height}"));
        }
    }
    Ok(())
}

/// Rejects a camera without pixels or with too many.
pub(crate) fn check_camera(camera: [u32; 2], most: u32) -> Result<(), EvaluationError> {
    let [width, height] = camera;
    if camera.iter().any(|side| !(1..=most).contains(side)) {
        return refuse("camera", format!("camera = {width}x{height} is not between 1 and {most}"));
    }
    Ok(())
}

/// Rejects a picture whose `id` is no file name, or whose output and magnified parts are none.
pub(crate) fn check_picture(
    place: &str,
    id: &str,
    output: [u32; 2],
    insets: &[[u32; 3]],
) -> Result<(), EvaluationError> {
    file_name(&format!("{place}.id"), "picture", id)?;
    check_output(output, insets).or_else(|reason| refuse(place, format!("picture `{id}`: {reason}")))
}

/// Lets pictures of other scenes, each with its scene and view, show the first view of this one.
pub(crate) fn move_to<'a>(scene: &str, pictures: impl Iterator<Item = (&'a mut String, &'a mut String)>) {
    for (shown, view) in pictures {
        scene.clone_into(shown);
        view.clear();
    }
}

/// Columns of pictures of one size with their magnified parts below.
pub(crate) fn side_by_side(columns: &[RgbaImage], output: [u32; 2], insets: &[[u32; 3]]) -> RgbaImage {
    stretched_side_by_side(columns, output, insets, 1.0)
}

/// The same with contrasts of the parts stretched about the mean colour of the part in the first column.
pub(crate) fn stretched_side_by_side(
    columns: &[RgbaImage],
    output: [u32; 2],
    insets: &[[u32; 3]],
    stretch: f32,
) -> RgbaImage {
    let [width, height] = output;
    let count = insets.len() as u32;
    let gaps = PICTURE_GAP * count.saturating_sub(1);
    let side = width.saturating_sub(gaps).checked_div(count).map_or(0, |side| side.max(1));
    let total = (
        columns.len() as u32 * (width + PICTURE_GAP) - PICTURE_GAP,
        height + if count > 0 { PICTURE_GAP + side } else { 0 },
    );
    let mut all = RgbaImage::from_pixel(total.0, total.1, image::Rgba([255; 4]));
    for (column, image) in columns.iter().enumerate() {
        let left = column as u32 * (width + PICTURE_GAP);
        imageops::replace(&mut all, image, i64::from(left), 0);
        for (i, &[x, y, size]) in insets.iter().enumerate() {
            let part_of = |image: &RgbaImage| imageops::crop_imm(image, x, y, size, size).to_image();
            let mut part = part_of(image);
            if let Some(first) = columns.first().filter(|_| stretch != 1.0) {
                stretch_contrast(&mut part, mean_colour(&part_of(first)), stretch);
            }
            let large = imageops::resize(&part, side, side, imageops::FilterType::Nearest);
            let at = (left + i as u32 * (side + PICTURE_GAP), height + PICTURE_GAP);
            imageops::replace(&mut all, &large, i64::from(at.0), i64::from(at.1));
        }
    }
    all
}

fn mean_colour(picture: &RgbaImage) -> [f32; 3] {
    let count = picture.pixels().len().max(1) as f32;
    [0, 1, 2].map(|k| picture.pixels().map(|pixel| f32::from(pixel[k])).sum::<f32>() / count)
}

fn stretch_contrast(picture: &mut RgbaImage, about: [f32; 3], factor: f32) {
    for pixel in picture.pixels_mut() {
        for k in 0..3 {
            pixel[k] = (about[k] + factor * (f32::from(pixel[k]) - about[k])).round().clamp(0.0, 255.0) as u8;
        }
    }
}

/// Pixels with the one to the right and the one below, row by row.
pub(crate) fn neighbours(width: usize, pixels: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..pixels).flat_map(move |i| {
        let right = (i % width + 1 < width).then_some(i + 1);
        let below = (i + width < pixels).then_some(i + width);
        [right, below].into_iter().flatten().map(move |j| (i, j))
    })
}

/// An error as grey: 128 for none, one step 1/127.
pub(crate) fn signed_grey(error: f64) -> Luma<u8> {
    Luma([(128.0 + 127.0 * error).round().clamp(0.0, 255.0) as u8])
}

/// A picture as a PNG of the run.
pub(crate) fn png(name: String, picture: DynamicImage) -> Result<RecordedFile, EvaluationError> {
    let mut bytes = Vec::new();
    picture
        .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
        .map_err(|error| EvaluationError::Table { table: name.clone(), reason: error.to_string() })?;
    Ok(RecordedFile { name, bytes })
}

/// The same in fewer bytes, for pictures of many frames.
pub(crate) fn small_png(name: String, picture: &DynamicImage) -> Result<RecordedFile, EvaluationError> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    picture
        .write_with_encoder(encoder)
        .map_err(|error| EvaluationError::Table { table: name.clone(), reason: error.to_string() })?;
    Ok(RecordedFile { name, bytes })
}
