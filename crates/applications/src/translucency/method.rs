//! Methods for shadows of translucent surfaces, each prepared for a lit view.

use quantization::NumberFormat;
use serde::{Deserialize, Serialize};
use shadow_filtering::{
    ChannelMap, DepthMap, FilteringError, Kernel, Receiver, SPECIAL, Technique, encode, filter,
};

use super::{
    LayeredMap, OpaqueOccluders, Rounding, Series, StochasticMap, TranslucentShadow, absorption_map,
    blended_map,
};
use crate::application::Estimate;

/// What shadow maps do that know no translucency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Treatment {
    /// Every surface is opaque.
    Opaque,
    /// Surfaces of an opacity of at least one half are opaque, others are not there.
    Tested,
    /// Translucent surfaces cast no shadow.
    Ignored,
}

/// A method.
pub enum TranslucentMethod {
    /// A filterable shadow map of transmittance, blended back to front.
    Blended {
        /// What is stored and how it is read.
        technique: Box<Technique>,
        /// Where blending rounds.
        rounding: Rounding,
    },
    /// Moments of absorbance.
    Absorbance {
        /// The bound of its distribution.
        technique: Box<Technique>,
        /// What becomes of opaque surfaces.
        opaque: OpaqueOccluders,
        /// The shadow map of opaque surfaces that stand apart.
        apart: Box<Technique>,
    },
    /// A Fourier opacity map.
    Fourier {
        /// Pairs of coefficients beside a_0.
        pairs: usize,
        /// Number format of sums.
        format: NumberFormat,
        /// What becomes of opaque surfaces.
        opaque: OpaqueOccluders,
        /// The shadow map of opaque surfaces that stand apart.
        apart: Box<Technique>,
    },
    /// A stochastic shadow map with percentage-closer filtering.
    Stochastic {
        /// Samples a texel.
        samples: usize,
    },
    /// A deep shadow map: every surface of every texel, exact but for the receiver's plane.
    Deep,
    /// Percentage-closer filtering without translucency.
    Comparison(Treatment),
}

/// A method prepared for a view.
pub enum PreparedTranslucent<'a> {
    /// A filtered map.
    Blended(&'a Technique, ChannelMap<f64>),
    /// A filtered series, with the filtered map of opaque surfaces.
    Added(Series<'a>, ChannelMap<f64>, Option<(&'a Technique, ChannelMap<f64>)>),
    /// Samples.
    Stochastic(StochasticMap),
    /// The truth's own map.
    Deep,
    /// A shadow map.
    Comparison(DepthMap),
}

impl TranslucentMethod {
    /// Draws and filters what the method needs. `ranks` are those of [`blended_map`], `seed` is that of samples.
    ///
    /// # Errors
    /// [`FilteringError::NotFinite`] where a value has no number.
    pub fn prepare<'a>(
        &'a self,
        map: &LayeredMap,
        kernel: &Kernel,
        ranks: Option<&[f32]>,
        seed: u64,
    ) -> Result<PreparedTranslucent<'a>, FilteringError> {
        let beside = |technique: &'a Technique, opaque: OpaqueOccluders| -> Result<_, FilteringError> {
            match opaque {
                OpaqueOccluders::Apart => {
                    let depths = first_depths(map, |opacity| opacity == 1.0)?;
                    Ok(Some((technique, filter(&encode::<f64>(&depths, technique)?, kernel))))
                }
                OpaqueOccluders::Within | OpaqueOccluders::LeftOut => Ok(None),
            }
        };
        Ok(match self {
            Self::Blended { technique, rounding } => {
                let blended = blended_map(map, technique, ranks, *rounding)?;
                PreparedTranslucent::Blended(technique, filter(&blended, kernel))
            }
            Self::Absorbance { technique, opaque, apart } => {
                let series = Series::Moments(technique);
                let format = technique.encoding().format();
                let filtered = absorption_map(map, &series, *opaque, format, kernel)?;
                PreparedTranslucent::Added(series, filtered, beside(apart, *opaque)?)
            }
            Self::Fourier { pairs, format, opaque, apart } => {
                let series = Series::Fourier(*pairs);
                let filtered = absorption_map(map, &series, *opaque, *format, kernel)?;
                PreparedTranslucent::Added(series, filtered, beside(apart, *opaque)?)
            }
            Self::Stochastic { samples } => {
                PreparedTranslucent::Stochastic(StochasticMap::new(map, *samples, seed))
            }
            Self::Deep => PreparedTranslucent::Deep,
            Self::Comparison(treatment) => PreparedTranslucent::Comparison(match treatment {
                Treatment::Opaque => first_depths(map, |opacity| opacity > 0.0)?,
                Treatment::Tested => first_depths(map, |opacity| opacity >= 0.5)?,
                Treatment::Ignored => first_depths(map, |opacity| opacity == 1.0)?,
            }),
        })
    }

    /// Memory of a texel in bits. A deep shadow map has a depth and a transmittance for each of `layers` surfaces.
    pub fn bits_per_texel(&self, layers: f64) -> f64 {
        // A single-precision depth, and what stands beside it.
        const DEPTH: f64 = 32.0;
        let beside = |technique: &Technique, opaque: OpaqueOccluders| match opaque {
            OpaqueOccluders::Apart => technique.bits_per_texel() as f64,
            OpaqueOccluders::Within | OpaqueOccluders::LeftOut => 0.0,
        };
        match self {
            Self::Blended { technique, .. } => technique.bits_per_texel() as f64,
            Self::Absorbance { technique, opaque, apart } => {
                let format = technique.encoding().format();
                format.bits_per_texel(1 + technique.channels()) as f64 + beside(apart, *opaque)
            }
            Self::Fourier { pairs, format, opaque, apart } => {
                format.bits_per_texel(1 + 2 * pairs) as f64 + beside(apart, *opaque)
            }
            Self::Stochastic { samples } => DEPTH * *samples as f64,
            Self::Deep => 2.0 * DEPTH * layers,
            Self::Comparison(_) => DEPTH,
        }
    }

    /// Operations of drawing a surface into a texel: its values, and the blend or sum of each.
    pub fn draw_operations(&self) -> f64 {
        let special = SPECIAL as f64;
        match self {
            // A power each, the transform, then two products and a sum.
            Self::Blended { technique, .. } => {
                let channels = technique.channels() as f64;
                channels + technique.decode_operations() as f64 + 3.0 * channels
            }
            // The logarithm, then a product and a sum each.
            Self::Absorbance { technique, .. } => special + 3.0 * (1.0 + technique.channels() as f64),
            Self::Fourier { pairs, .. } => special + *pairs as f64 * (2.0 * special + 4.0) + 2.0,
            // A random number and a comparison for each sample.
            Self::Stochastic { samples } => 4.0 * *samples as f64,
            Self::Deep | Self::Comparison(_) => 1.0,
        }
    }

    /// Channels that are filtered; 0 for what is compared tap by tap.
    pub fn filtered_channels(&self) -> usize {
        let beside = |technique: &Technique, opaque: OpaqueOccluders| match opaque {
            OpaqueOccluders::Apart => technique.channels(),
            OpaqueOccluders::Within | OpaqueOccluders::LeftOut => 0,
        };
        match self {
            Self::Blended { technique, .. } => technique.channels(),
            Self::Absorbance { technique, opaque, apart } => {
                1 + technique.channels() + beside(apart, *opaque)
            }
            Self::Fourier { pairs, opaque, apart, .. } => 1 + 2 * pairs + beside(apart, *opaque),
            Self::Stochastic { .. } | Self::Deep | Self::Comparison(_) => 0,
        }
    }

    /// Whether surfaces have to be drawn in order.
    pub fn needs_order(&self) -> bool {
        matches!(self, Self::Blended { .. } | Self::Deep)
    }
}

/// The shadow map of the surfaces that are wanted by their opacity.
fn first_depths(map: &LayeredMap, wanted: impl Fn(f64) -> bool) -> Result<DepthMap, FilteringError> {
    let [width, height] = map.size();
    let first = |texel| {
        let mut layers = map.layers(texel).iter();
        layers.find(|layer| wanted(layer.opacity())).map_or(1.0, |layer| layer.depth() as f32)
    };
    DepthMap::new(width, height, (0..width * height).map(first).collect())
}

impl PreparedTranslucent<'_> {
    /// The shadow as the method computes it, before it is moved into \[0, 1\].
    ///
    /// # Errors
    /// As [`Technique::shade`].
    pub fn unclamped(
        &self,
        view: &TranslucentShadow<'_>,
        receiver: &Receiver,
    ) -> Result<f64, FilteringError> {
        let (at, z) = ([receiver.x, receiver.y], view.compared(receiver));
        match self {
            Self::Blended(technique, filtered) => shade(technique, filtered, at, z),
            Self::Added(series, filtered, apart) => {
                let through = series.transmittance(filtered.texel(at[0], at[1]), z)?;
                let opaque = match apart {
                    Some((technique, filtered)) => technique.shade(filtered.texel(at[0], at[1]), z)?,
                    None => 0.0,
                };
                Ok(1.0 - through * (1.0 - opaque))
            }
            Self::Stochastic(map) => Ok(map.shadow(view.kernel, at, z)),
            Self::Deep => Ok(view.at_depth(receiver, z)),
            Self::Comparison(map) => Ok(view.kernel.percentage_closer(map, at[0], at[1], z)),
        }
    }

    /// Operations of shading a receiver, counted where a bound is evaluated; taps and texels by what they compare.
    pub fn shade_operations(&self, view: &TranslucentShadow<'_>, receiver: &Receiver) -> f64 {
        let (at, z) = ([receiver.x, receiver.y], view.compared(receiver) as f32);
        let special = SPECIAL as f64;
        let taps = (view.kernel.size() * view.kernel.size()) as f64;
        let bound = |technique: &Technique, b: &[f64]| {
            let b: Vec<f32> = b.iter().map(|&value| value as f32).collect();
            technique.real_time().map_or(0.0, |bound| bound.operations(&b, z) as f64)
        };
        match self {
            Self::Blended(technique, filtered) => {
                let mut b = vec![0.0; technique.channels()];
                technique.restore(filtered.texel(at[0], at[1]), &mut b);
                technique.decode_operations() as f64 + bound(technique, &b)
            }
            Self::Added(series, filtered, apart) => {
                let values = filtered.texel(at[0], at[1]);
                let own = match series {
                    Series::Moments(technique) => {
                        let total = values[0].max(f64::MIN_POSITIVE);
                        let b: Vec<f64> = values[1..].iter().map(|value| value / total).collect();
                        b.len() as f64 * special + bound(technique, &b) + special + 1.0
                    }
                    Series::Fourier(pairs) => *pairs as f64 * (2.0 * special + 6.0) + special,
                };
                let opaque = apart.as_ref().map_or(0.0, |(technique, filtered)| {
                    bound(technique, filtered.texel(at[0], at[1])) + 2.0
                });
                own + opaque
            }
            Self::Stochastic(map) => 3.0 * taps * map.samples() as f64,
            // A search among the layers of each tap.
            Self::Deep => {
                let layers = view.map.layers(at[1] * view.map.size()[0] + at[0]).len() as f64;
                taps * (3.0 + 2.0 * (1.0 + layers).log2())
            }
            Self::Comparison(_) => 3.0 * taps,
        }
    }
}

fn shade(
    technique: &Technique,
    filtered: &ChannelMap<f64>,
    [x, y]: [usize; 2],
    z: f64,
) -> Result<f64, FilteringError> {
    let mut b = vec![0.0; technique.channels()];
    technique.restore(filtered.texel(x, y), &mut b);
    technique.shade(&b, z)
}

impl Estimate<TranslucentShadow<'_>> for PreparedTranslucent<'_> {
    fn estimate(&self, view: &TranslucentShadow<'_>, receiver: &Receiver) -> Result<f64, FilteringError> {
        Ok(self.unclamped(view, receiver)?.clamp(0.0, 1.0))
    }
}
