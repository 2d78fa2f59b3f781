//! Methods that make every frame anew from the map of the light's middle.

use super::light::{MappedLight, on_map};
use super::scenery::{Scenery, Seen};
use crate::error::EvaluationError;
use crate::fragments::depth_map;
use crate::kinds::soft_shadows::{MethodSetting, Prepared};
use applications::rays::{Surface, Triangles};
use applications::samples::{PoissonTaps, TapShape};
use applications::soft_shadow::{
    AreaTruth, BlockerSearch, Filter, SoftReceiver, SoftShadow, percentage_closer_soft_shadow,
};
use applications::temporal::SampledField;
use quantization::QuantizationError;
use shadow_filtering::{DepthBias, DepthMap};
use shadow_renderer::{Backend, render_in_frame};

/// The streams of taps, apart from those of pixels and rays.
pub(crate) const TAP_STREAM: u64 = 0x7a95;

/// Texels that two queries to a summed-area table read: four for the search, sixteen for the nine regions of the filter.
const TABLE_LOOKUPS: f32 = 20.0;

/// The whole map of the light's middle in a frame.
pub(crate) fn middle_map(
    scenery: &Scenery<'_>,
    light: &MappedLight,
    frame: usize,
) -> Result<DepthMap, EvaluationError> {
    let scene = scenery.scene.at(frame);
    let fail = |error: String| EvaluationError::Value(format!("scene `{}`: {error}", scene.name));
    let (stack, _) = render_in_frame(&scene, &light.frame, Backend::Cpu).map_err(|e| fail(e.to_string()))?;
    depth_map(&stack).map_err(|error| fail(error.to_string()))
}

/// A method without memory.
#[derive(Clone, Copy)]
pub(crate) enum Anew<'a> {
    /// Percentage-closer soft shadows with so many taps for search and filter each.
    Taps(usize),
    /// A method of the kind `soft-shadows`.
    Soft(&'a MethodSetting),
}

/// Most taps of a search or a filter.
pub(crate) const MAX_TAPS: usize = 1024;

impl Anew<'_> {
    /// Rejects what cannot be made; `place` is the key of the technique.
    pub(crate) fn check(&self, name: &str, place: &str) -> Result<(), EvaluationError> {
        match self {
            Self::Taps(taps) if (1..=MAX_TAPS).contains(taps) => Ok(()),
            Self::Taps(taps) => {
                let reason = format!("technique `{name}`: taps = {taps} is not between 1 and {MAX_TAPS}");
                Err(EvaluationError::key(format!("{place}.taps"), reason))
            }
            Self::Soft(method) => method.check(name, &format!("{place}.method")),
        }
    }

    /// Bits of a texel of its map or table.
    pub(crate) fn bits_per_texel(&self) -> usize {
        match self {
            Self::Taps(_) => 32,
            Self::Soft(method) => method.bits_per_texel(),
        }
    }
}

/// A method on a map.
pub(crate) enum Ready {
    Taps(PoissonTaps),
    Soft(Box<Prepared>),
}

/// What methods know of a light besides the map.
#[derive(Clone, Copy)]
pub(crate) struct Lit<'a> {
    pub(crate) map: &'a DepthMap,
    pub(crate) light: &'a MappedLight,
    /// The rays are not used; methods take the map.
    pub(crate) truth: &'a AreaTruth,
    pub(crate) triangles: &'a Triangles,
}

impl Ready {
    pub(crate) fn new(method: Anew<'_>, lit: &Lit<'_>, seed: u64) -> Result<Self, QuantizationError> {
        Ok(match method {
            Anew::Taps(taps) => Self::Taps(PoissonTaps::new(TapShape::Square, taps, seed, TAP_STREAM)),
            Anew::Soft(method) => Self::Soft(Box::new(method.prepare(lit.map, &lit.light.penumbra)?)),
        })
    }

    pub(crate) fn lookups(&self) -> f32 {
        match self {
            Self::Taps(taps) => 2.0 * taps.points().len() as f32,
            Self::Soft(_) => TABLE_LOOKUPS,
        }
    }

    /// The shadow of a surface; `Err` with the reason where there is none.
    pub(crate) fn shadow(
        &self,
        lit: &Lit<'_>,
        bias: (&DepthBias, f64),
        seen: &Seen,
        position: [f64; 3],
    ) -> Result<f64, String> {
        let MappedLight { frame, texel_depth, penumbra, .. } = lit.light;
        let Some(placed) = on_map(frame, *texel_depth, bias, (position, seen.normal)) else { return Ok(0.0) };
        match self {
            Self::Taps(taps) => {
                let texel = |[x, y]: [f64; 2]| f64::from(lit.map.at(x.floor() as isize, y.floor() as isize));
                let field = SampledField { depth: texel, taps };
                let (search, filter) = (BlockerSearch::percentage_closer(), Filter::published());
                Ok(percentage_closer_soft_shadow(&field, penumbra, &search, &filter, &placed.fragment))
            }
            Self::Soft(method) => {
                let view = SoftShadow {
                    scene: lit.triangles,
                    light: lit.light.placed,
                    truth: lit.truth,
                    map: lit.map,
                    penumbra: *penumbra,
                };
                let surface = Surface { triangle: seen.triangle, position };
                let receiver = SoftReceiver { surface, fragment: placed.fragment, stream: 0 };
                method.estimate(&view, &receiver).map_err(|error| error.to_string())
            }
        }
    }
}
