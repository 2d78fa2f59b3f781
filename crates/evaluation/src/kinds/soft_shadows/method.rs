//! A method as an experiment writes it down, and as it is prepared for a view.

use crate::error::EvaluationError;
use applications::Estimate;
use applications::field::{Fit, Table};
use applications::soft_shadow::{
    BlockerSearch, Blockers, Filter, Fragment, Penumbra, Reconstruction, ReconstructionError, SoftMethod,
    SoftReceiver, SoftShadow, Storage, Warp,
};
use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;
use quantization::QuantizationError;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthMap, FilteringError};

/// Where the corners of filter regions lie.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Corners {
    /// Where they are, by nine regions (BHS16 section 3.4).
    #[default]
    Interpolated,
    /// On the nearest border of texels.
    Nearest,
    /// On one of the next borders, at random by blue noise over the screen.
    Dithered,
}

/// In which numbers means, bounds and penumbrae are computed.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// `f64`.
    #[default]
    Double,
    /// `f32`, as shaders do.
    Single,
}

/// A method: percentage-closer without a bound, else moments. Left out, every key is as BHS16 publishes it.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MethodSetting {
    /// How moments are read; texels are compared one by one without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<MomentBound>,
    /// c of exponentially warped depths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exponent: Option<f64>,
    /// Which powers are stored.
    #[serde(default)]
    pub storage: Storage,
    /// alpha; 5e-6.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_bias: Option<f64>,
    /// b*; half of the mass at each end of the range.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub centre: Vec<f64>,
    /// How sums are held.
    #[serde(default)]
    pub table: Table,
    /// N over the texels of the largest region that the light asks for; 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<f64>,
    /// Weight of the receiver in the average blocker depth; 0.01, for percentage-closer methods 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epsilon: Option<f64>,
    /// Share of blockers above which a receiver is in the umbra; 0.99, for percentage-closer methods 1: never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub umbra: Option<f64>,
    /// Corners of filter regions.
    #[serde(default)]
    pub corners: Corners,
    /// Share of the depth bias that the blocker search takes; 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub search_bias: Option<f64>,
    /// Whether small filters take less of the depth bias.
    #[serde(default)]
    pub growing_bias: bool,
    /// Least full width of a filter in texels.
    #[serde(default)]
    pub least_width: f64,
    /// Full width in texels that neither search nor filter exceeds; as the light wants it without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_width: Option<f64>,
    /// Full width in texels of a filter of fixed size, which searches no blockers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Numbers that are computed with.
    #[serde(default)]
    pub precision: Precision,
}

/// alpha of BHS16.
pub(crate) const PUBLISHED_BIAS: f64 = 5e-6;

/// A method on one map and light.
pub(crate) enum Prepared {
    Double(Box<SoftMethod<f64>>),
    Single(Box<SoftMethod<f32>>),
}

impl MethodSetting {
    /// Whether every texel is compared.
    pub(crate) fn is_percentage_closer(&self) -> bool {
        self.bound.is_none()
    }

    /// Whether there is a table of sums.
    pub(crate) fn bits_per_texel(&self) -> usize {
        let channel = match self.table {
            Table::Uint32 | Table::Float32 => 32,
            Table::Uint16 => 16,
            Table::Float64 => 64,
        };
        self.bound.map_or(32, |bound| bound.order() * channel)
    }

    /// Rejects what cannot be prepared; `place` is the method's key.
    pub(crate) fn check(&self, name: &str, place: &str) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| {
            Err(EvaluationError::key(format!("{place}.{key}"), format!("technique `{name}`: {reason}")))
        };
        if self.is_percentage_closer() {
            let of_moments = [
                ("exponent", self.exponent.is_some()),
                ("storage", self.storage != Storage::Unit),
                ("moment_bias", self.moment_bias.is_some()),
                ("centre", !self.centre.is_empty()),
                ("table", self.table != Table::Uint32),
                ("region", self.region.is_some()),
                ("width", self.width.is_some()),
            ];
            if let Some((key, _)) = of_moments.into_iter().find(|(_, is_given)| *is_given) {
                return fail(key, format!("{key} needs moments, that is, a bound"));
            }
        }
        let share = |value: Option<f64>| value.is_none_or(|value| (0.0..=1.0).contains(&value));
        let positive = |value: Option<f64>| value.is_none_or(|value| value > 0.0 && value.is_finite());
        for (key, value, fits, range) in [
            ("epsilon", self.epsilon, share(self.epsilon), "[0, 1]"),
            ("umbra", self.umbra, share(self.umbra), "[0, 1]"),
            ("search_bias", self.search_bias, share(self.search_bias), "[0, 1]"),
            ("region", self.region, positive(self.region), "(0, infinity)"),
            ("most_width", self.most_width, positive(self.most_width), "(0, infinity)"),
            ("width", self.width, positive(self.width), "(0, infinity)"),
            (
                "least_width",
                Some(self.least_width),
                (0.0..f64::INFINITY).contains(&self.least_width),
                "[0, infinity)",
            ),
        ] {
            if let (Some(value), false) = (value, fits) {
                return fail(key, format!("{key} = {value} is not in {range}"));
            }
        }
        match self.reconstruction() {
            Ok(_) => Ok(()),
            Err(error) => {
                let key = match &error {
                    ReconstructionError::Parameter { key, .. } => key,
                    ReconstructionError::NoPoints { .. } => "bound",
                    ReconstructionError::Storage { .. } => "storage",
                    ReconstructionError::Centre { .. } => "centre",
                };
                fail(key, error.to_string())
            }
        }
    }

    /// How moments are read; `None` for percentage-closer methods.
    pub(super) fn reconstruction(&self) -> Result<Option<Reconstruction<f64>>, ReconstructionError> {
        let Some(bound) = self.bound else { return Ok(None) };
        let warp = self.exponent.map_or(Warp::None, Warp::Exponential);
        let plain = Reconstruction::new(bound, warp, self.moment_bias.unwrap_or(PUBLISHED_BIAS))?;
        let stored = if self.storage == Storage::Unit { plain } else { plain.stored(self.storage)? };
        Ok(Some(if self.centre.is_empty() { stored } else { stored.centred(&self.centre)? }))
    }

    pub(super) fn search<R: Real>(&self) -> BlockerSearch<R> {
        let published = if self.is_percentage_closer() {
            BlockerSearch::percentage_closer()
        } else {
            BlockerSearch::published()
        };
        let given = |value: Option<f64>, otherwise: R| value.map_or(otherwise, R::from_f64);
        BlockerSearch {
            epsilon: given(self.epsilon, published.epsilon),
            umbra: given(self.umbra, published.umbra),
            bias_share: given(self.search_bias, published.bias_share),
            most_width: given(self.most_width, published.most_width),
            fit: published.fit,
        }
    }

    pub(crate) fn filter<R: Real>(&self, penumbra: &Penumbra<f64>) -> Filter<R> {
        let largest = penumbra.search(1.0);
        let full = if self.growing_bias { largest[0].max(largest[1]) } else { 0.0 };
        Filter {
            fit: if self.corners == Corners::Interpolated { Fit::Covered } else { Fit::Nearest },
            dithered: self.corners == Corners::Dithered,
            least_width: R::from_f64(self.least_width),
            full_bias_width: R::from_f64(full),
        }
    }

    /// epsilon.
    pub(super) fn weight(&self) -> f64 {
        self.search::<f64>().epsilon
    }

    /// Full widths of the filter for an average blocker depth.
    pub(super) fn filtered(&self, penumbra: &Penumbra<f64>, depth: f64, average: f64) -> [f64; 2] {
        let most = self.search::<f64>().most_width;
        let widths = penumbra.filter(depth, average).map(|width| width.min(most).max(self.least_width));
        self.width.map_or(widths, |width| [width; 2])
    }

    /// N of the table: the largest region, of which a smaller or larger one may be asked.
    pub(super) fn texels(&self, map: &DepthMap, penumbra: &Penumbra<f64>) -> u32 {
        let size = [map.width(), map.height()];
        let square = |width: f64| {
            let side = |k: usize| (width.ceil() + 1.0).min(size[k] as f64);
            (side(0) * side(1)) as u32
        };
        let largest = penumbra.largest_region(size);
        let needed = match (self.width, self.most_width) {
            (Some(width), _) => square(width.max(self.least_width)),
            (None, Some(width)) => largest.min(square(width.max(self.least_width))),
            (None, None) => largest.max(square(self.least_width)),
        };
        (self.region.unwrap_or(1.0) * f64::from(needed)).round().max(1.0) as u32
    }

    /// The key that keeps a map's table from holding the largest sums, with the reason.
    pub(crate) fn check_table(
        &self,
        map: &DepthMap,
        penumbra: &Penumbra<f64>,
    ) -> Result<(), (&'static str, String)> {
        if self.is_percentage_closer() {
            return Ok(());
        }
        let (held, side) = (self.texels(map, penumbra), map.width().min(map.height()));
        if let Some(width) = self.width.filter(|&width| width > side as f64) {
            return Err(("width", format!("a filter of {width} texels exceeds the map of {side}")));
        }
        let needed = Self { region: None, ..self.clone() }.texels(map, penumbra);
        if held < needed {
            return Err((
                "region",
                format!("the table holds sums of {held} texels, the largest region has {needed}"),
            ));
        }
        self.table.check(held).map_err(|error| ("table", error.to_string()))
    }

    /// The method on a map.
    pub(crate) fn prepare(
        &self,
        map: &DepthMap,
        penumbra: &Penumbra<f64>,
    ) -> Result<Prepared, QuantizationError> {
        Ok(match self.precision {
            Precision::Double => Prepared::Double(Box::new(self.built(map, penumbra)?)),
            Precision::Single => Prepared::Single(Box::new(self.built(map, penumbra)?)),
        })
    }

    fn built<R: Real>(
        &self,
        map: &DepthMap,
        penumbra: &Penumbra<f64>,
    ) -> Result<SoftMethod<R>, QuantizationError> {
        let filter = self.filter(penumbra);
        // What makes no sense was refused when the file was read.
        let Ok(Some(technique)) = self.reconstruction() else {
            return Ok(SoftMethod::PercentageCloser(self.search(), filter));
        };
        let technique = technique.cast::<R>();
        let field = SoftMethod::field(self.table, map, &technique, self.texels(map, penumbra))?;
        Ok(match self.width {
            Some(width) => SoftMethod::FilteredHard(field, technique, [R::from_f64(width); 2], filter),
            None => SoftMethod::Filterable(field, technique, self.search(), filter),
        })
    }

    /// The same with nothing rounded: what arithmetic and storage change is told against it.
    pub(super) fn exact(&self) -> Self {
        let table = if self.is_percentage_closer() { Table::Uint32 } else { Table::Float64 };
        Self { table, region: None, precision: Precision::Double, ..self.clone() }
    }
}

impl Prepared {
    pub(crate) fn estimate(
        &self,
        view: &SoftShadow<'_>,
        receiver: &SoftReceiver,
    ) -> Result<f64, FilteringError> {
        match self {
            Self::Double(method) => method.estimate(view, receiver),
            Self::Single(method) => method.estimate(view, receiver),
        }
    }

    /// What the blocker search finds; `None` for methods that do not search.
    pub(super) fn blockers(
        &self,
        view: &SoftShadow<'_>,
        fragment: &Fragment<f64>,
    ) -> Result<Option<Blockers<f64>>, FilteringError> {
        Ok(match self {
            Self::Double(method) => method.blockers(view, fragment)?,
            Self::Single(method) => method
                .blockers(view, fragment)?
                .map(|found| Blockers { mass: found.mass.to_f64(), depth_sum: found.depth_sum.to_f64() }),
        })
    }
}
