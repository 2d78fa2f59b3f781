//! Soft shadows as an application: receivers on surfaces, the light's occluded fraction as the truth, and any method as
//! an estimate.

use quantization::QuantizationError;
use shadow_filtering::{DepthMap, FilteringError};

use super::{
    AreaTruth, BlockerSearch, Filter, Fragment, Penumbra, Reconstruction, filterable_soft_shadow,
    filtered_hard_shadow, percentage_closer_soft_shadow,
};
use crate::application::{Application, Estimate};
use crate::area_light::PlacedLight;
use crate::field::SummedMoments;
use crate::rays::{Surface, Triangles};

/// A view lit by an area light.
#[derive(Clone, Copy)]
pub struct SoftShadow<'a> {
    /// What occludes.
    pub scene: &'a Triangles,
    /// The light.
    pub light: PlacedLight,
    /// How much of it is occluded.
    pub truth: &'a AreaTruth,
    /// The shadow map seen from the light's middle.
    pub map: &'a DepthMap,
    /// How it hangs together with the light.
    pub penumbra: Penumbra<f64>,
}

/// A shaded point, in the world and on the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftReceiver {
    /// Where it lies.
    pub surface: Surface,
    /// On the map.
    pub fragment: Fragment<f64>,
    /// Receivers of different streams have independent shadow rays.
    pub stream: u64,
}

impl Application for SoftShadow<'_> {
    type Receiver = SoftReceiver;

    fn truth(&self, receiver: &SoftReceiver) -> f64 {
        let Surface { position, triangle } = receiver.surface;
        let found =
            self.truth.occluded_fraction(self.scene, &self.light, position, Some(triangle), receiver.stream);
        found.fraction
    }
}

/// A method prepared for one view.
#[derive(Clone, Debug)]
pub enum SoftMethod {
    /// Percentage-closer soft shadows.
    PercentageCloser(BlockerSearch<f64>, Filter<f64>),
    /// Two queries to a field of moments: moment and variance soft shadow mapping.
    Filterable(SummedMoments, Reconstruction<f64>, BlockerSearch<f64>, Filter<f64>),
    /// Hard shadows, filtered with one size in texels.
    FilteredHard(SummedMoments, Reconstruction<f64>, [f64; 2], Filter<f64>),
}

impl SoftMethod {
    /// The map as a summed-area table of the moments that a reconstruction reads, for regions of at most `texels`.
    ///
    /// # Errors
    /// As [`SummedMoments::new`].
    pub fn field(
        map: &DepthMap,
        technique: &Reconstruction<f64>,
        texels: u32,
    ) -> Result<SummedMoments, QuantizationError> {
        let encode = |depth: f64, out: &mut [f64]| technique.encode(depth, out);
        SummedMoments::new([map.width(), map.height()], map.depths(), technique.channels(), texels, encode)
    }
}

impl Estimate<SoftShadow<'_>> for SoftMethod {
    fn estimate(&self, view: &SoftShadow<'_>, receiver: &SoftReceiver) -> Result<f64, FilteringError> {
        let (penumbra, fragment) = (&view.penumbra, &receiver.fragment);
        Ok(match self {
            Self::PercentageCloser(search, filter) => {
                percentage_closer_soft_shadow(view.map, penumbra, search, filter, fragment)
            }
            Self::Filterable(field, technique, search, filter) => {
                filterable_soft_shadow(field, technique, penumbra, search, filter, fragment)?
            }
            Self::FilteredHard(field, technique, widths, filter) => {
                filtered_hard_shadow(field, technique, *widths, filter, fragment)?
            }
        })
    }
}
