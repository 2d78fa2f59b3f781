//! The ways to hold a summed-area table that are compared.

use moment_problem::arithmetic::Real;
use quantization::QuantizationError;
use serde::{Deserialize, Serialize};
use shadow_filtering::DepthMap;

use super::{Fit, Means, MomentField, PrefixSums, SummedMoments};
use crate::region::Region;

/// How a table holds its sums.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Table {
    /// 32-bit whole numbers of scale floor((2^32 - 1) / N), as published but for the scale's rounding.
    #[default]
    Uint32,
    /// 16-bit whole numbers of scale floor((2^16 - 1) / N).
    Uint16,
    /// Single floats, no limit N.
    Float32,
    /// Double floats, which stand for exact moments.
    Float64,
}

impl Table {
    /// Whether it counts that far.
    ///
    /// # Errors
    /// [`QuantizationError::Parameter`] for more texels than 16 bits can count, and for none.
    pub fn check(self, texels: u32) -> Result<(), QuantizationError> {
        match self {
            Self::Uint16 if !(1..=LARGEST_UINT16).contains(&texels) => {
                let reason = format!("16 bits hold sums of 1 to {LARGEST_UINT16} texels");
                Err(QuantizationError::Parameter { key: "texels", value: texels.to_string(), reason })
            }
            Self::Uint32 | Self::Uint16 | Self::Float32 | Self::Float64 => Ok(()),
        }
    }
}

/// A table of any kind.
#[derive(Clone, Debug)]
pub enum StoredSums {
    /// Whole numbers.
    Whole(SummedMoments),
    /// Single floats.
    Single(PrefixSums<f32>),
    /// Double floats.
    Double(PrefixSums<f64>),
}

/// Largest code of 16 bits.
const LARGEST_UINT16: u32 = 65535;

impl StoredSums {
    /// The sums of what `encode` makes of each depth of a map, for regions of at most `texels` texels.
    ///
    /// # Errors
    /// As [`SummedMoments::new`]; [`QuantizationError::Parameter`] for more texels than 16 bits can count.
    pub fn new(
        table: Table,
        map: &DepthMap,
        channels: usize,
        texels: u32,
        encode: impl Fn(f64, &mut [f64]),
    ) -> Result<Self, QuantizationError> {
        let (size, depths) = ([map.width(), map.height()], map.depths());
        Ok(match table {
            Table::Uint32 => Self::Whole(SummedMoments::new(size, depths, channels, texels, encode)?),
            Table::Uint16 => {
                table.check(texels)?;
                let scale = LARGEST_UINT16.checked_div(texels).unwrap_or_default();
                // Differences of wrapped sums are exact: all that is lost is the rounding of texels.
                let scale = f64::from(scale);
                let rounded = |depth: f64, out: &mut [f64]| {
                    encode(depth, out);
                    out.iter_mut().for_each(|value| *value = (*value * scale).round() / scale);
                };
                Self::Whole(SummedMoments::new(size, depths, channels, texels, rounded)?)
            }
            Table::Float32 => Self::Single(PrefixSums::new(size, depths, channels, encode)?),
            Table::Float64 => Self::Double(PrefixSums::new(size, depths, channels, encode)?),
        })
    }
}

impl<R: Real> MomentField<R> for StoredSums {
    fn means(&self, region: &Region<R>, fit: Fit) -> Result<Means<R>, QuantizationError> {
        match self {
            Self::Whole(sums) => sums.means(region, fit),
            Self::Single(sums) => sums.means(region, fit),
            Self::Double(sums) => sums.means(region, fit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_round_texels_and_count_no_further() {
        let map = DepthMap::new(8, 8, vec![0.501; 64]).unwrap();
        let first = |depth: f64, out: &mut [f64]| out[0] = depth;
        let mean = |table, texels| {
            let field = StoredSums::new(table, &map, 1, texels, first).unwrap();
            let region = Region { low: [0.0; 2], high: [5.0, 6.0] };
            let means: Means<f64> = field.means(&region, Fit::Covered).unwrap();
            means[0]
        };
        let exact = f64::from(0.501f32);
        for table in [Table::Uint32, Table::Float32, Table::Float64] {
            assert!((mean(table, 64) - exact).abs() < 1e-6, "{table:?}");
        }
        let step = 1.0 / f64::from(65535 / 64u32);
        assert!((mean(Table::Uint16, 64) - (exact / step).round() * step).abs() < 1e-6);
        assert!(StoredSums::new(Table::Uint16, &map, 1, 70000, first).is_err());
        assert!(StoredSums::new(Table::Uint16, &map, 1, 0, first).is_err());
    }
}
