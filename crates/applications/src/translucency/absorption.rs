//! Maps of absorption, which add up whatever the order of surfaces: moments of absorbance, as order-independent transparency
//! uses them, and Fourier opacity maps (Jansen and Bavoil 2010).

use quantization::NumberFormat;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shadow_filtering::{ChannelMap, FilteringError, Kernel, Technique, filter};

use super::{FourierOpacity, Layer, LayeredMap};

/// What becomes of opaque surfaces, whose absorption is infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OpaqueOccluders {
    /// They have a shadow map of their own, and both transmittances are multiplied.
    #[default]
    Apart,
    /// They count as surfaces of opacity [`NEARLY_OPAQUE`].
    Within,
    /// They cast no shadow.
    LeftOut,
}

/// Opacity that stands for 1 where absorption has to be finite: half a step of eight bits below it.
pub const NEARLY_OPAQUE: f64 = 1.0 - 0.5 / 255.0;

/// Total absorption below which there is no shadow, as order-independent transparency has it.
const LEAST_ABSORPTION: f64 = 1e-3;

/// What is added up for each surface.
pub enum Series<'a> {
    /// Absorption, and the technique's functions of depth weighted with it.
    Moments(&'a Technique),
    /// a_0 and so many pairs a_k, b_k.
    Fourier(usize),
}

impl Series<'_> {
    /// Values a texel.
    pub fn channels(&self) -> usize {
        match self {
            Self::Moments(technique) => 1 + technique.channels(),
            Self::Fourier(pairs) => 1 + 2 * pairs,
        }
    }

    fn of(&self, layer: &Layer, absorption: f64, out: &mut [f64]) {
        match self {
            Self::Moments(technique) => {
                out[0] = absorption;
                technique.evaluate(layer.depth(), &mut out[1..]);
                out[1..].iter_mut().for_each(|value| *value *= absorption);
            }
            Self::Fourier(_) => FourierOpacity::coefficients_of(layer.depth(), absorption, out),
        }
    }

    /// Transmittance up to a depth by filtered values; not clamped, as a series may ring.
    ///
    /// # Errors
    /// As [`Technique::shade`].
    pub fn transmittance(&self, values: &[f64], z: f64) -> Result<f64, FilteringError> {
        match self {
            Self::Moments(_) if values[0] < LEAST_ABSORPTION => Ok(1.0),
            Self::Moments(technique) => {
                let b: Vec<f64> = values[1..].iter().map(|value| value / values[0]).collect();
                Ok((-values[0] * technique.shade(&b, z)?).exp())
            }
            Self::Fourier(_) => Ok((-FourierOpacity::of_coefficients(values.to_vec()).absorption(z)).exp()),
        }
    }
}

/// The filtered map of a series, summed in `format`. Surfaces behind the first opaque one add nothing.
///
/// # Errors
/// [`FilteringError::NotFinite`] where a value has no number.
pub fn absorption_map(
    map: &LayeredMap,
    series: &Series<'_>,
    opaque: OpaqueOccluders,
    format: NumberFormat,
    kernel: &Kernel,
) -> Result<ChannelMap<f64>, FilteringError> {
    let [width, height] = map.size();
    let channels = series.channels();
    let mut data = vec![0.0; width * height * channels];
    data.par_chunks_mut(width * channels).enumerate().for_each(|(y, row)| {
        let mut own = vec![0.0; channels];
        for (x, sum) in row.chunks_exact_mut(channels).enumerate() {
            for layer in map.layers(y * width + x) {
                let is_opaque = layer.opacity() == 1.0;
                if is_opaque && opaque != OpaqueOccluders::Within {
                    break;
                }
                // Below the step of eight bits nothing is that opaque.
                let absorption = -(-layer.opacity().min(NEARLY_OPAQUE)).ln_1p();
                series.of(layer, absorption, &mut own);
                sum.iter_mut().zip(&own).for_each(|(sum, value)| *sum = format.round(*sum + value));
                if is_opaque {
                    break;
                }
            }
        }
    });
    Ok(filter(&ChannelMap::new(width, height, channels, data)?, kernel))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shadow_filtering::TechniqueSpec;

    /// Layers of opacity 1/2 at 0.2, 0.4 and 0.6 in every texel, then an opaque one.
    fn map() -> LayeredMap {
        let texel = [(0.2, 0.5), (0.4, 0.5), (0.6, 0.5), (0.8, 1.0)];
        LayeredMap::new([3, 3], (0..=9).map(|t| 4 * t).collect(), texel.into_iter().cycle().take(36)).unwrap()
    }

    #[test]
    fn few_layers_are_reconstructed_and_the_order_does_not_matter() {
        let technique = TechniqueSpec::named("hamburger6").unwrap().build().unwrap();
        let series = Series::Moments(&technique);
        let kernel = Kernel::uniform(1).unwrap();
        let filtered =
            absorption_map(&map(), &series, OpaqueOccluders::Apart, NumberFormat::F32, &kernel).unwrap();
        for (z, expected) in [(0.1, 1.0), (0.3, 0.5), (0.5, 0.25), (0.7, 0.125)] {
            let found = series.transmittance(filtered.texel(1, 1), z).unwrap();
            // Six moments hold three surfaces and z_f; the bound is off by what the moment bias moves.
            assert!((found - expected).abs() < 0.08, "{z}: {found} instead of {expected}");
        }
        let clear = LayeredMap::new([1, 1], vec![0, 0], std::iter::empty()).unwrap();
        let nothing =
            absorption_map(&clear, &series, OpaqueOccluders::Within, NumberFormat::F16, &kernel).unwrap();
        assert_eq!(series.transmittance(nothing.texel(0, 0), 0.9).unwrap(), 1.0);
    }

    #[test]
    fn opaque_surfaces_are_apart_within_or_left_out() {
        let series = Series::Fourier(16);
        let kernel = Kernel::uniform(1).unwrap();
        let at = |opaque| {
            let filtered = absorption_map(&map(), &series, opaque, NumberFormat::F32, &kernel).unwrap();
            series.transmittance(filtered.texel(0, 2), 0.95).unwrap()
        };
        assert!((at(OpaqueOccluders::Apart) - 0.125).abs() < 0.02);
        assert_eq!(at(OpaqueOccluders::Apart), at(OpaqueOccluders::LeftOut));
        assert!(at(OpaqueOccluders::Within) < 0.01);
    }
}
