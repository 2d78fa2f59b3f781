//! Rows of the recorded tables. Intensities and errors are fractions of the light, rounded to 1e-9.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique in one frame of one path under one light, on one class of pixels.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct TemporalRecord {
    /// `temporal`.
    pub application: String,
    /// Scene, or `all`.
    pub scene: String,
    /// View of the light.
    pub view: String,
    /// Light.
    pub light: String,
    /// Path.
    pub path: String,
    /// Frame, counted from 1: how many maps were seen.
    pub frame: usize,
    /// Technique.
    pub technique: String,
    /// `all`; `penumbra`, truths from 0.01 to 0.99; `new`, surfaces that came into view within 8 frames, the first frame aside;
    /// `changed`, whose truth differs by more than 0.05 from that of 8 frames before: where moving shadows are and were.
    pub class: String,
    /// Pixels judged.
    pub receivers: usize,
    /// Mean |shadow - truth|.
    pub l1_error: f64,
    /// Standard error of that mean.
    pub standard_error: f64,
    /// Mean of shadow - truth: below 0 light leaks.
    pub signed_mean: f64,
    /// 95th percentile of |shadow - truth|.
    pub p95: f64,
    /// Mean |shadow - that of the frame before at the same place of the scene|, where the truth does not change; empty in the
    /// first frame.
    pub flicker: Option<f64>,
    /// Mean |estimate from the pixel's own tests - truth|, of methods that gather.
    pub estimate_error: Option<f64>,
    /// Root of the mean square of that distance.
    pub estimate_rms: Option<f64>,
    /// Root of the mean square of the standard errors that the method believes in.
    pub believed_rms: Option<f64>,
    /// Share of pixels whose estimate lies within its believed standard error of the truth: 68 % of sound ones.
    pub within: Option<f64>,
    /// Share of pixels that believe in an error of 0 and are off by more than 0.02.
    pub falsely_certain: Option<f64>,
    /// Mean n.
    pub tests: Option<f64>,
    /// Share of pixels whose history began in this frame.
    pub restarted: Option<f64>,
    /// Share of pixels that asked their neighbours.
    pub filtered: Option<f64>,
    /// Mean lookups of a pixel into maps, tables and buffers.
    pub lookups: f64,
    /// Shadow maps a frame.
    pub maps: usize,
    /// Bytes of a pixel of the shadow buffers, both of them.
    pub bytes_per_pixel: usize,
    /// Bits of a texel of the map or table, of all planes where there are several.
    pub bits_per_texel: usize,
    /// Pixels without an answer.
    pub failed: usize,
    /// Why, or empty.
    pub error: String,
}

/// One row of views.csv: a path of a scene under a light.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TemporalViewRecord {
    /// Scene.
    pub scene: String,
    /// View of the light.
    pub view: String,
    /// Light.
    pub light: String,
    /// Its shape as text.
    pub shape: String,
    /// Path.
    pub path: String,
    /// Frames.
    pub frames: usize,
    /// Whether a part of the scene moves.
    pub moving: bool,
    /// Triangles, those of the part among them.
    pub triangles: usize,
    /// Pixels of the buffer that show a surface which faces the light, in the last judged frame.
    pub pixels: usize,
    /// Of which were judged.
    pub judged: usize,
    /// Mean of the truth in that frame.
    pub mean_truth: f64,
    /// Mean of its standard error.
    pub mean_standard_error: f64,
    /// Largest.
    pub largest_standard_error: f64,
    /// Shadow rays sent, over all judged frames.
    pub rays: u64,
    /// Pixels in penumbra, with a truth from 0.01 to 0.99.
    pub penumbra: usize,
    /// Mean width on the screen, in pixels, of penumbrae (equation 6 with the blockers of percentage-closer soft shadows).
    pub penumbra_pixels: f64,
    /// Seed of all of it.
    pub seed: u64,
}

/// One row of counts.csv: a method on single pixels of known shadow.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CountRecord {
    /// Technique.
    pub technique: String,
    /// Format of the buffer.
    pub format: String,
    /// Frames so far.
    pub frames: usize,
    /// n.
    pub tests: f64,
    /// Mean |psi - truth|.
    pub mean_error: f64,
    /// Largest.
    pub largest_error: f64,
}

/// One row of pictures.csv: a column of a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TemporalPictureRecord {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Frame, counted from 1.
    pub frame: usize,
    /// Pixels that face the light.
    pub pixels: usize,
    /// Mean |shadow - truth of the last frame|; empty where earlier frames have another truth.
    pub l1_error: Option<f64>,
}
