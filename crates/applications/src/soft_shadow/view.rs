//! Soft shadows as an application: receivers on surfaces, the light's occluded fraction as the truth, and any method as
//! an estimate.

use moment_problem::arithmetic::Real;
use quantization::QuantizationError;
use shadow_filtering::{DepthMap, FilteringError};

use super::{
    AreaTruth, BlockerSearch, Blockers, Filter, Fragment, OccludedFraction, Penumbra, Reconstruction,
    filterable_blockers, filterable_soft_shadow, filtered_hard_shadow, percentage_closer_blockers,
    percentage_closer_soft_shadow,
};
use crate::application::{Application, Estimate};
use crate::area_light::PlacedLight;
use crate::field::{StoredSums, Table};
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

impl SoftShadow<'_> {
    /// The truth at a receiver with its standard error.
    pub fn occluded(&self, receiver: &SoftReceiver) -> OccludedFraction {
        let Surface { position, triangle } = receiver.surface;
        self.truth.occluded_fraction(self.scene, &self.light, position, Some(triangle), receiver.stream)
    }
}

impl Application for SoftShadow<'_> {
    type Receiver = SoftReceiver;

    fn truth(&self, receiver: &SoftReceiver) -> f64 {
        self.occluded(receiver).fraction
    }
}

/// A method prepared for one view, computing in the precision `R`.
#[derive(Clone, Debug)]
pub enum SoftMethod<R> {
    /// Percentage-closer soft shadows.
    PercentageCloser(BlockerSearch<R>, Filter<R>),
    /// Two queries to a field of moments: moment and variance soft shadow mapping.
    Filterable(StoredSums, Reconstruction<R>, BlockerSearch<R>, Filter<R>),
    /// Hard shadows, filtered with one size in texels.
    FilteredHard(StoredSums, Reconstruction<R>, [R; 2], Filter<R>),
}

impl<R: Real> SoftMethod<R> {
    /// The map as a summed-area table of the moments that a reconstruction reads, for regions of at most `texels`.
    ///
    /// # Errors
    /// As [`StoredSums::new`].
    pub fn field(
        table: Table,
        map: &DepthMap,
        technique: &Reconstruction<R>,
        texels: u32,
    ) -> Result<StoredSums, QuantizationError> {
        let technique = technique.cast::<f64>();
        let encode = |depth: f64, out: &mut [f64]| technique.encode(depth, out);
        StoredSums::new(table, map, technique.channels(), texels, encode)
    }

    /// What the blocker search of a receiver finds; `None` for filters of fixed size, which search nothing.
    ///
    /// # Errors
    /// As [`filterable_soft_shadow`].
    pub fn blockers(
        &self,
        view: &SoftShadow<'_>,
        fragment: &Fragment<f64>,
    ) -> Result<Option<Blockers<R>>, QuantizationError> {
        let (penumbra, fragment) = (&view.penumbra.cast(), &fragment.cast());
        Ok(match self {
            Self::PercentageCloser(search, _) => {
                Some(percentage_closer_blockers(view.map, penumbra, search, fragment))
            }
            Self::Filterable(field, technique, search, _) => {
                Some(filterable_blockers(field, technique, penumbra, search, fragment)?)
            }
            Self::FilteredHard(..) => None,
        })
    }
}

impl<R: Real + Send + Sync> Estimate<SoftShadow<'_>> for SoftMethod<R> {
    fn estimate(&self, view: &SoftShadow<'_>, receiver: &SoftReceiver) -> Result<f64, FilteringError> {
        let (penumbra, fragment) = (&view.penumbra.cast(), &receiver.fragment.cast());
        let intensity = match self {
            Self::PercentageCloser(search, filter) => {
                percentage_closer_soft_shadow(view.map, penumbra, search, filter, fragment)
            }
            Self::Filterable(field, technique, search, filter) => {
                filterable_soft_shadow(field, technique, penumbra, search, filter, fragment)?
            }
            Self::FilteredHard(field, technique, widths, filter) => {
                filtered_hard_shadow(field, technique, *widths, filter, fragment)?
            }
        };
        Ok(intensity.to_f64())
    }
}
