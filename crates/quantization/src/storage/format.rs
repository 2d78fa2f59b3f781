//! Number formats of textures and what they do to a value.

use crate::error::QuantizationError;
use moment_problem::arithmetic::Half;
use std::fmt;
use std::str::FromStr;

/// How one channel of a texel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberFormat {
    /// 8 bits that stand for 0 to 1.
    Unorm8,
    /// 10 bits that stand for 0 to 1, three to a R10G10B10A2 texel.
    Unorm10,
    /// 16 bits that stand for 0 to 1.
    Unorm16,
    /// Half float.
    F16,
    /// Single float.
    F32,
    /// 32-bit fixed point whose sums over a kernel fit 32 bits (BHS16 section 3.2).
    U32Fixed {
        /// N: most texels of a kernel.
        texels: u32,
    },
}

/// Largest finite half float.
const LARGEST_F16: f64 = 65504.0;

/// Exponent and bits of the fraction of half floats.
const F16_LEAST_EXPONENT: i32 = -14;
const F16_FRACTION_BITS: i32 = 10;

/// How numbers become bits.
enum Coding {
    /// Multiples of 1 / steps from 0 to 1.
    Fixed {
        steps: f64,
    },
    Half,
    Single,
}

impl NumberFormat {
    /// Name in experiments: `unorm8`, `unorm10`, `unorm16`, `f16`, `f32`, `u32/N`.
    pub fn name(self) -> String {
        self.to_string()
    }

    /// Bits of a channel.
    pub fn bits(self) -> usize {
        match self {
            Self::Unorm8 => 8,
            Self::Unorm10 => 10,
            Self::Unorm16 | Self::F16 => 16,
            Self::F32 | Self::U32Fixed { .. } => 32,
        }
    }

    /// Bits of a texel of so many channels, with those that the texture wastes: R10G10B10A2 holds three channels of 10
    /// bits and two unused bits.
    pub fn bits_per_texel(self, channels: usize) -> usize {
        match self {
            Self::Unorm10 => 32 * channels.div_ceil(3),
            Self::Unorm8 | Self::Unorm16 | Self::F16 | Self::F32 | Self::U32Fixed { .. } => {
                self.bits() * channels
            }
        }
    }

    fn coding(self) -> Coding {
        match self {
            Self::Unorm8 => Coding::Fixed { steps: 255.0 },
            Self::Unorm10 => Coding::Fixed { steps: 1023.0 },
            Self::Unorm16 => Coding::Fixed { steps: 65535.0 },
            Self::U32Fixed { texels } => Coding::Fixed { steps: f64::from(Self::fixed_point_scale(texels)) },
            Self::F16 => Coding::Half,
            Self::F32 => Coding::Single,
        }
    }

    /// The code of 1 in fixed point for kernels of N texels: the largest whole number of which N fit into 32 bits.
    /// BHS16 takes (2^32 - 1) / N itself, whose rounding up would let N ones overflow. N = 0 counts as 1.
    pub fn fixed_point_scale(texels: u32) -> u32 {
        u32::MAX / texels.max(1)
    }

    /// The bits that are stored. Fixed point clamps to \[0, 1\], half floats to finite numbers; NaN becomes 0. Rounding
    /// is to nearest, ties to even for floats and up for fixed point, as the Direct3D 11.3 specification has it
    /// (sections 3.2.3.6 and 3.1.3).
    pub fn encode(self, value: f64) -> u32 {
        let value = if value.is_nan() { 0.0 } else { value };
        match self.coding() {
            // A saturating cast of a number within the type's range.
            Coding::Fixed { steps } => (value.clamp(0.0, 1.0) * steps + 0.5).floor() as u32,
            Coding::Half => half_bits(value),
            Coding::Single => (value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32).to_bits(),
        }
    }

    /// The value of stored bits. Bits of infinities and NaN, which [`NumberFormat::encode`] never makes, count as the
    /// largest finite number and as 0.
    pub fn decode(self, code: u32) -> f64 {
        match self.coding() {
            Coding::Fixed { steps } => f64::from(code) / steps,
            Coding::Half => half_value(code),
            Coding::Single => {
                let value = f32::from_bits(code);
                let value = if value.is_nan() { 0.0 } else { value.clamp(f32::MIN, f32::MAX) };
                f64::from(value)
            }
        }
    }

    /// What is left of a value once it was stored.
    pub fn round(self, value: f64) -> f64 {
        self.decode(self.encode(value))
    }

    /// [`NumberFormat::round`] in single precision, as a texture unit does it, for whole maps.
    #[inline]
    pub fn round_single(self, value: f32) -> f32 {
        // A comparison with NaN is false.
        let clamped = |low: f32, high: f32| {
            if value > low {
                if value < high { value } else { high }
            } else if value <= low {
                low
            } else {
                0.0
            }
        };
        match self {
            Self::Unorm8 => (clamped(0.0, 1.0) * 255.0 + 0.5).floor() / 255.0,
            Self::Unorm10 => (clamped(0.0, 1.0) * 1023.0 + 0.5).floor() / 1023.0,
            Self::Unorm16 => (clamped(0.0, 1.0) * 65535.0 + 0.5).floor() / 65535.0,
            Self::F16 => Half::nearest(clamped(-LARGEST_F16 as f32, LARGEST_F16 as f32)).to_f32(),
            Self::F32 => clamped(f32::MIN, f32::MAX),
            Self::U32Fixed { .. } => self.round(f64::from(value)) as f32,
        }
    }

    /// Largest distance of neighbouring stored values in \[0, 1\].
    pub fn step(self) -> f64 {
        match self.coding() {
            Coding::Fixed { steps } => 1.0 / steps,
            Coding::Half => 2f64.powi(-F16_FRACTION_BITS - 1),
            Coding::Single => 0.5 * f64::from(f32::EPSILON),
        }
    }
}

fn half_bits(value: f64) -> u32 {
    let sign = if value.is_sign_negative() { 0x8000 } else { 0 };
    let size = value.abs().min(LARGEST_F16);
    let exponent = |size: f64| (((size.to_bits() >> 52) as i32) - 1023).max(F16_LEAST_EXPONENT);
    let quantum = |size: f64| 2f64.powi(exponent(size) - F16_FRACTION_BITS);
    // Rounding may reach the next power of two; every intermediate result is exact.
    let rounded = (size / quantum(size)).round_ties_even() * quantum(size);
    let normal = rounded >= 2f64.powi(F16_LEAST_EXPONENT);
    let biased = if normal { exponent(rounded) + 15 } else { 0 } as u32;
    let fraction = (rounded / quantum(rounded)) as u32 & 0x3ff;
    sign | biased << F16_FRACTION_BITS | fraction
}

fn half_value(code: u32) -> f64 {
    let (exponent, fraction) = ((code >> 10 & 0x1f) as i32, f64::from(code & 0x3ff) / 1024.0);
    let size = match exponent {
        0 => fraction * 2f64.powi(F16_LEAST_EXPONENT),
        31 if fraction > 0.0 => 0.0,
        31 => LARGEST_F16,
        _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
    };
    if code & 0x8000 == 0 { size } else { -size }
}

impl fmt::Display for NumberFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unorm8 => f.write_str("unorm8"),
            Self::Unorm10 => f.write_str("unorm10"),
            Self::Unorm16 => f.write_str("unorm16"),
            Self::F16 => f.write_str("f16"),
            Self::F32 => f.write_str("f32"),
            Self::U32Fixed { texels } => write!(f, "u32/{texels}"),
        }
    }
}

impl FromStr for NumberFormat {
    type Err = QuantizationError;

    fn from_str(text: &str) -> Result<Self, QuantizationError> {
        let fixed = |digits: &str| digits.parse().ok().filter(|&texels| texels > 0);
        match text {
            "unorm8" => Ok(Self::Unorm8),
            "unorm10" => Ok(Self::Unorm10),
            "unorm16" => Ok(Self::Unorm16),
            "f16" => Ok(Self::F16),
            "f32" => Ok(Self::F32),
            _ => match text.strip_prefix("u32/").and_then(fixed) {
                Some(texels) => Ok(Self::U32Fixed { texels }),
                None => Err(QuantizationError::Parameter {
                    key: "format",
                    value: text.to_owned(),
                    reason: "known are unorm8, unorm10, unorm16, f16, f32 and u32/N for kernels of at most N texels"
                        .to_owned(),
                }),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_that_are_known() {
        let code = |format: NumberFormat, value| format.encode(value);
        assert_eq!(code(NumberFormat::Unorm16, 0.5), 32768);
        assert_eq!(code(NumberFormat::Unorm10, 1.5), 1023);
        assert_eq!(code(NumberFormat::Unorm10, f64::NAN), 0);
        for (value, bits) in [
            (1.0, 0x3c00),
            (-2.0, 0xc000),
            (65504.0, 0x7bff),
            (1e9, 0x7bff),
            (2f64.powi(-24), 0x0001),
            (2f64.powi(-14), 0x0400),
            (0.1, 0x2e66),
            // Ties go to even, here up to the next power of two and down to 1.
            (2.0 - 2f64.powi(-11), 0x4000),
            (1.0 + 2f64.powi(-11), 0x3c00),
            (2f64.powi(-14) - 2f64.powi(-26), 0x0400),
        ] {
            assert_eq!(code(NumberFormat::F16, value), bits, "{value}");
        }
        assert_eq!(code(NumberFormat::U32Fixed { texels: 256 }, 1.0), (1 << 24) - 1);
        assert_eq!(NumberFormat::F16.decode(0x7c01), 0.0);
        assert_eq!(NumberFormat::Unorm10.bits_per_texel(6), 64);
    }

    #[test]
    fn every_half_float_survives() {
        for code in (0..0x1_0000).filter(|code| code >> 10 & 0x1f != 0x1f) {
            assert_eq!(NumberFormat::F16.encode(NumberFormat::F16.decode(code)), code, "{code:x}");
        }
    }

    #[test]
    fn single_precision_rounds_alike() {
        let mut values: Vec<f32> = (0..20_000).map(|i| (i as f32 - 10_000.0) * 1.37e-4).collect();
        values.extend((-120..120).map(|e| 1.000_33 * 2f32.powf(e as f32 / 4.0)));
        values.extend((0..4000).map(|i| i as f32 * 1.9e-8));
        values.extend([0.0, 1.0, -1.0, 2.0, 65519.0, -1e9, 1.0 + 2f32.powi(-11), f32::INFINITY, f32::NAN]);
        let formats = [
            NumberFormat::Unorm8,
            NumberFormat::Unorm10,
            NumberFormat::Unorm16,
            NumberFormat::F16,
            NumberFormat::F32,
        ];
        for format in formats {
            for &value in &values {
                let (single, double) = (format.round_single(value), format.round(f64::from(value)));
                // Products with 65535 may round across a tie in single precision.
                let step: f64 = if format == NumberFormat::Unorm16 { 1.6e-5 } else { 0.0 };
                let error = (f64::from(single) - double).abs();
                assert!(error <= step.max(6e-8 * double.abs()), "{format} {value}: {single} {double}");
            }
        }
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        let formats = [
            NumberFormat::Unorm8,
            NumberFormat::Unorm10,
            NumberFormat::Unorm16,
            NumberFormat::F16,
            NumberFormat::F32,
        ];
        for format in formats.into_iter().chain([NumberFormat::U32Fixed { texels: 81 }]) {
            assert_eq!(format.name().parse::<NumberFormat>().unwrap(), format);
        }
        for text in ["unorm9", "u32/0", "u32/x", ""] {
            assert!(text.parse::<NumberFormat>().unwrap_err().to_string().contains(text));
        }
    }
}
