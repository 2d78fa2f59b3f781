//! Methods of soft shadows that are raced: those of the experiment in several kinds of tables, and percentage-closer soft
//! shadows with a few taps.

use crate::error::EvaluationError;
use crate::kinds::soft_shadows::{MethodSetting, PUBLISHED_BIAS, Prepared, SoftShadowsExperiment};
use crate::kinds::speed_accuracy::{FrameCost, FrameSetting, moment_operations};
use crate::lit_frames::TAP_STREAM;
use applications::field::{Fit, Table};
use applications::samples::{PoissonTaps, TapShape};
use applications::soft_shadow::{
    BlockerSearch, Filter, Penumbra, SoftReceiver, SoftShadow, percentage_closer_soft_shadow,
};
use applications::temporal::SampledField;
use serde::Serialize;
use shadow_filtering::DepthMap;

/// Calling everything lit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NothingSoft {
    /// What it errs by over the receivers seen: their mean truth.
    pub l1_error: f64,
    /// What it errs by at least over all receivers, as certain as the other intervals.
    pub l1_error_low: f64,
}

/// What percentage-closer soft shadows read around a receiver, full widths in texels of the reference's map.
pub(super) struct Texels {
    pub(super) search: [f64; 2],
    /// `None` without blockers, where nothing is filtered.
    pub(super) filter: Option<[f64; 2]>,
}

/// A method.
pub(super) enum SoftCandidate {
    Method {
        name: String,
        setting: Box<MethodSetting>,
    },
    /// Percentage-closer soft shadows with so many taps for search and filter each.
    Taps {
        taps: PoissonTaps,
    },
}

/// A method on a map.
pub(super) enum Ready<'a> {
    Method(Prepared),
    Taps(&'a PoissonTaps),
}

/// Corners of a region in a table, and of the nine regions of an interpolated one.
const CORNERS: f64 = 4.0;
const INTERPOLATED_CORNERS: f64 = 16.0;

/// Bits of a depth.
const DEPTH_BITS: usize = 32;

impl SoftCandidate {
    /// All that an experiment offers: each method in each table, taps.
    pub(super) fn all(experiment: &SoftShadowsExperiment) -> Vec<Self> {
        let advice = experiment.advice.clone().unwrap_or_default();
        let mut all = Vec::new();
        for technique in &experiment.technique {
            if !(advice.techniques.is_empty() || advice.techniques.contains(&technique.name)) {
                continue;
            }
            let given = technique.method.table;
            let tables = match &advice.tables[..] {
                tables if !tables.is_empty() && !technique.method.is_percentage_closer() => tables,
                _ => std::slice::from_ref(&given),
            };
            for &table in tables {
                let setting = Box::new(MethodSetting { table, ..technique.method.clone() });
                all.push(Self::Method { name: technique.name.clone(), setting });
            }
        }
        let seed = experiment.scenery.seed;
        all.extend(
            advice
                .taps
                .iter()
                .map(|&taps| Self::Taps { taps: PoissonTaps::new(TapShape::Square, taps, seed, TAP_STREAM) }),
        );
        all
    }

    pub(super) fn name(&self) -> String {
        match self {
            Self::Method { name, .. } => name.clone(),
            Self::Taps { taps } => format!("PCSS, {} taps", taps.points().len()),
        }
    }

    /// Whether a map's table holds all sums that a light asks for.
    pub(super) fn is_held(&self, map: &DepthMap, penumbra: &Penumbra<f64>) -> bool {
        match self {
            Self::Method { setting, .. } => setting.check_table(map, penumbra).is_ok(),
            Self::Taps { .. } => true,
        }
    }

    fn setting(&self) -> Option<&MethodSetting> {
        match self {
            Self::Method { setting, .. } => Some(setting).filter(|setting| setting.bound.is_some()),
            Self::Taps { .. } => None,
        }
        .map(Box::as_ref)
    }

    pub(super) fn format(&self) -> String {
        let Some(setting) = self.setting() else { return "depths in f32".to_owned() };
        let table = match setting.table {
            Table::Uint32 => "sums in 32-bit integers",
            Table::Uint16 => "sums in 16-bit integers",
            Table::Float32 => "sums in single floats",
            Table::Float64 => "sums in double floats",
        };
        table.to_owned()
    }

    pub(super) fn storage(&self) -> String {
        use applications::soft_shadow::Storage;
        let Some(setting) = self.setting() else { return String::new() };
        match setting.storage {
            Storage::Unit => "unit",
            Storage::Signed => "signed",
            Storage::Sparse => "sparse",
        }
        .to_owned()
    }

    pub(super) fn moments(&self) -> usize {
        self.setting().and_then(|setting| setting.bound).map_or(0, |bound| bound.order())
    }

    pub(super) fn alpha(&self) -> Option<f64> {
        self.setting().map(|setting| setting.moment_bias.unwrap_or(PUBLISHED_BIAS))
    }

    pub(super) fn bits_per_texel(&self) -> usize {
        match self {
            Self::Method { setting, .. } => setting.bits_per_texel(),
            Self::Taps { .. } => DEPTH_BITS,
        }
    }

    pub(super) fn map_bytes(&self, side: u32) -> u64 {
        u64::from(side).pow(2) * self.bits_per_texel() as u64 / 8
    }

    /// Width that is searched where the light asks for `widest` texels.
    pub(super) fn region(&self, widest: f64) -> f64 {
        match self {
            Self::Method { setting, .. } => match setting.width {
                Some(_) => 0.0,
                None => widest.min(setting.most_width.unwrap_or(f64::INFINITY)),
            },
            Self::Taps { .. } => widest,
        }
    }

    /// Modelled cost on a map of that side, whose texels are `scale` times as wide as the reference's, with the texels read a
    /// pixel.
    pub(super) fn cost(
        &self,
        frame: FrameSetting,
        side: u32,
        around: &[Texels],
        scale: f64,
    ) -> (FrameCost, f64) {
        match self {
            Self::Taps { taps } => {
                let samples = 2.0 * taps.points().len() as f64;
                (FrameCost::compared(frame, side, samples), samples)
            }
            Self::Method { setting, .. } => match setting.bound {
                None => {
                    let most = setting.most_width.unwrap_or(f64::INFINITY);
                    let area = |widths: [f64; 2]| -> f64 {
                        widths.iter().map(|width| (width / scale).min(most) + 1.0).product()
                    };
                    let read = |of: &Texels| area(of.search) + of.filter.map_or(0.0, area);
                    let samples = around.iter().map(read).sum::<f64>() / around.len().max(1) as f64;
                    (FrameCost::compared(frame, side, samples), samples)
                }
                Some(bound) => {
                    let corners = match setting.filter::<f64>(&UNLIT).fit {
                        Fit::Covered => INTERPOLATED_CORNERS,
                        Fit::Outwards | Fit::Nearest => CORNERS,
                    };
                    let searches = if setting.width.is_some() { 0.0 } else { 1.0 };
                    let samples = searches * CORNERS + corners;
                    let operations = (1.0 + searches) * moment_operations(bound);
                    let storage = (setting.bits_per_texel(), bound.order());
                    (FrameCost::summed(frame, side, storage, (samples, operations)), samples)
                }
            },
        }
    }

    pub(super) fn prepare(
        &self,
        map: &DepthMap,
        penumbra: &Penumbra<f64>,
    ) -> Result<Ready<'_>, EvaluationError> {
        match self {
            Self::Taps { taps } => Ok(Ready::Taps(taps)),
            Self::Method { name, setting } => {
                let prepared = setting.prepare(map, penumbra);
                let fail = |error: quantization::QuantizationError| {
                    EvaluationError::Value(format!("technique `{name}`: {error}"))
                };
                prepared.map(Ready::Method).map_err(fail)
            }
        }
    }
}

/// Whether corners are interpolated does not depend on the light.
const UNLIT: Penumbra<f64> =
    Penumbra { half_size: [0.0; 2], near: None, depth_range: 1.0, texels_per_unit: [1.0; 2] };

impl Ready<'_> {
    /// The shadow; without an answer the receiver is lit.
    pub(super) fn shadow(&self, lit: &SoftShadow<'_>, receiver: &SoftReceiver) -> f64 {
        let found = match self {
            Self::Method(method) => method.estimate(lit, receiver).unwrap_or(0.0),
            Self::Taps(taps) => {
                let texel = |[x, y]: [f64; 2]| f64::from(lit.map.at(x.floor() as isize, y.floor() as isize));
                let field = SampledField { depth: texel, taps };
                let (search, filter) = (BlockerSearch::percentage_closer(), Filter::published());
                percentage_closer_soft_shadow(&field, &lit.penumbra, &search, &filter, &receiver.fragment)
            }
        };
        if (0.0..=1.0).contains(&found) { found } else { 0.0 }
    }
}
