//! Rows of the recorded tables. Shadows and errors are fractions of the light, rounded to 1e-9.

use serde::{Deserialize, Serialize};

/// One row of records.csv: one technique on one class of receivers.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct TranslucentRecord {
    /// `translucent`.
    pub application: String,
    /// Scene, or `all`.
    pub scene: String,
    /// View, or `all`.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// `surfaces`, opaque ones that face the light; `inside`, translucent surfaces at their own depth; `all`, both.
    pub class: String,
    /// Receivers judged.
    pub receivers: usize,
    /// Mean |G - F|.
    pub l1_error: f64,
    /// Standard error of that mean.
    pub standard_error: f64,
    /// Mean of G - F: below 0 light leaks.
    pub signed_mean: f64,
    /// 95th percentile of |G - F|.
    pub p95: f64,
    /// Largest |G - F|.
    pub max_error: f64,
    /// Mean of F_Z - G where it is positive, 0 elsewhere, F_Z being the mean shadow at the depth that techniques compare.
    pub leak: f64,
    /// Share of receivers with G below F_Z by more than 0.01.
    pub leak_share: f64,
    /// Mean of G - F_Z where it is positive, 0 elsewhere.
    pub overshoot: f64,
    /// Share of receivers with G above F_Z by more than 0.01.
    pub above_share: f64,
    /// Share of receivers whose answer lies outside of \[0, 1\] by more than 0.01 before it is moved there.
    pub outside_share: f64,
    /// Largest distance from \[0, 1\] before it is moved there.
    pub outside_most: f64,
    /// Memory of a texel in bits.
    pub bits_per_texel: f64,
    /// Receivers without an answer.
    pub failed: usize,
    /// Why, or empty.
    pub error: String,
}

/// One row of groups.csv: one technique on the receivers of all views behind so many translucent layers, or behind such opacities.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TranslucentGroup {
    /// Technique.
    pub technique: String,
    /// `layers`, translucent ones in front of the receiver at its own texel; `opacity`, their mean.
    pub by: String,
    /// The group.
    pub group: String,
    /// Receivers judged.
    pub receivers: usize,
    /// Mean of F.
    pub mean_truth: f64,
    /// Mean |G - F|.
    pub l1_error: f64,
    /// Standard error of that mean.
    pub standard_error: f64,
    /// Mean of G - F.
    pub signed_mean: f64,
}

/// One row of views.csv.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TranslucentViewRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Entries of the layered shadow map.
    pub stack_entries: usize,
    /// Of which translucent.
    pub translucent_entries: usize,
    /// Layers of covered texels, on average.
    pub mean_layers: f64,
    /// Most layers behind one texel.
    pub layers: u32,
    /// Opaque surfaces that face the light and whose kernel lies inside the map.
    pub surfaces: usize,
    /// Translucent surfaces whose kernel lies inside the map.
    pub inside: usize,
    /// Receivers judged.
    pub sampled: usize,
    /// Unit of biases.
    pub texel_depth: f64,
    /// Mean of F.
    pub mean_truth: f64,
    /// Share of judged receivers with a truth from 0.01 to 0.99.
    pub partial: f64,
}

/// One row of cost.csv, modelled: memory and operations of a technique, over the first view.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TranslucentCost {
    /// Technique.
    pub technique: String,
    /// Memory of a texel in bytes.
    pub bytes_per_texel: f64,
    /// Bytes that drawing a surface into a texel reads and writes.
    pub bytes_per_layer: f64,
    /// Operations of drawing a surface into a texel.
    pub operations_per_layer: f64,
    /// Operations of shading a receiver, with the comparisons of taps.
    pub operations_per_receiver: f64,
    /// Whether surfaces have to be drawn in order.
    pub ordered: bool,
    /// Surfaces drawn into a texel on average: translucent ones, and one that is opaque.
    pub layers: f64,
}

/// One row of colour.csv: light of one colour behind coloured glass.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct ColourRecord {
    /// Scene.
    pub scene: String,
    /// View.
    pub view: String,
    /// Technique.
    pub technique: String,
    /// `red`, `green` or `blue`.
    pub channel: String,
    /// Receivers judged.
    pub receivers: usize,
    /// Mean of F in this light.
    pub mean_truth: f64,
    /// Mean |G - F| with a map of its own.
    pub l1_error: f64,
    /// The same with one map, that of the luminance.
    pub one_map_error: f64,
}

/// One row of stability.csv: layers of one opacity, blended in a format.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct BlendingRecord {
    /// Bound.
    pub bound: String,
    /// Number format.
    pub format: String,
    /// Transform.
    pub transform: String,
    /// `spread`, random depths; `coincident`, all at one depth; `eight bits`, random depths, and opacities rounded to 1/255.
    pub case: String,
    /// Opacity of each layer.
    pub opacity: f64,
    /// Number of layers.
    pub layers: usize,
    /// Texels drawn.
    pub trials: usize,
    /// Texels whose moments no distribution has, without moment bias.
    pub invalid_unbiased: usize,
    /// The same with the experiment's moment bias.
    pub invalid: usize,
    /// Smallest of the moment biases with which all texels are valid; nothing where none is enough.
    pub smallest_alpha: Option<f64>,
    /// Largest distance of a stored value from that without rounding, in steps of 1/65535.
    pub largest_error: f64,
}

/// One row of pictures.csv: a column of a picture.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct TranslucentPictureRecord {
    /// Picture.
    pub picture: String,
    /// Technique.
    pub technique: String,
    /// Pixels whose opaque surface faces the light.
    pub pixels: usize,
    /// Mean |G - F| there.
    pub l1_error: f64,
    /// Translucent surfaces seen in pixels, by their number.
    pub veils: usize,
    /// Mean |G - F| on them.
    pub veil_error: f64,
}
