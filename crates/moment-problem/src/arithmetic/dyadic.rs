//! Whole numbers times powers of two, of any size: sums and products are exact, so that signs of determinants and values
//! of certificates need no error analysis. Quotients and roots are rounded to as many bits as asked for.

use super::DoubleDouble;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

/// `mantissa` 2^`exponent`.
#[derive(Clone, Debug)]
pub(crate) struct Dyadic {
    mantissa: BigInt,
    exponent: i64,
}

impl Dyadic {
    pub(crate) fn zero() -> Self {
        Self::integer(0)
    }

    pub(crate) fn one() -> Self {
        Self::integer(1)
    }

    pub(crate) fn integer(value: i64) -> Self {
        Self { mantissa: value.into(), exponent: 0 }
    }

    /// 2^`exponent`.
    pub(crate) fn power_of_two(exponent: i64) -> Self {
        Self { mantissa: 1.into(), exponent }
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.mantissa.sign() == Sign::NoSign
    }

    pub(crate) fn is_positive(&self) -> bool {
        self.mantissa.sign() == Sign::Plus
    }

    pub(crate) fn is_negative(&self) -> bool {
        self.mantissa.sign() == Sign::Minus
    }

    pub(crate) fn square(&self) -> Self {
        self * self
    }

    /// The least k with |self| < 2^k; meaningless for 0.
    pub(crate) fn magnitude(&self) -> i64 {
        self.mantissa.bits() as i64 + self.exponent
    }

    /// The value times 2^`exponent`.
    pub(crate) fn shifted(&self, exponent: i64) -> Self {
        Self { mantissa: self.mantissa.clone(), exponent: self.exponent + exponent }
    }

    /// The value to `bits` binary digits.
    pub(crate) fn rounded(&self, bits: u64) -> Self {
        match self.mantissa.bits().checked_sub(bits) {
            None | Some(0) => self.clone(),
            Some(excess) => {
                Self { mantissa: &self.mantissa >> excess, exponent: self.exponent + excess as i64 }
            }
        }
    }

    /// self / divisor to `bits` binary digits, at most the true value; `divisor` is not 0.
    pub(crate) fn quotient(&self, divisor: &Self, bits: u64) -> Self {
        let shift = (bits + divisor.mantissa.bits()).saturating_sub(self.mantissa.bits()) + 1;
        let numerator = &self.mantissa << shift;
        let mut mantissa = &numerator / &divisor.mantissa;
        // The division of big integers truncates towards 0.
        if (self.is_negative() != divisor.is_negative()) && &mantissa * &divisor.mantissa != numerator {
            mantissa -= 1;
        }
        Self { mantissa, exponent: self.exponent - divisor.exponent - shift as i64 }
    }

    /// The root of a number that is not negative, to `bits` binary digits.
    pub(crate) fn sqrt(&self, bits: u64) -> Self {
        let mut shift = (2 * bits).saturating_sub(self.mantissa.bits()) as i64;
        // The exponent under the root must be even.
        shift += (self.exponent - shift).rem_euclid(2);
        Self { mantissa: (&self.mantissa << shift).sqrt(), exponent: (self.exponent - shift) / 2 }
    }

    /// A double that is not above, within a unit in the last place of those above the subnormal ones.
    pub(crate) fn to_f64_below(&self) -> f64 {
        let nearest = self.to_f64();
        if Self::from(nearest).cmp(self) == Ordering::Greater { nearest.next_down() } else { nearest }
    }

    /// A double that is not below.
    pub(crate) fn to_f64_above(&self) -> f64 {
        let nearest = self.to_f64();
        if Self::from(nearest).cmp(self) == Ordering::Less { nearest.next_up() } else { nearest }
    }

    /// A double within a unit in the last place; finite, the largest double instead of an overflow.
    pub(crate) fn to_f64(&self) -> f64 {
        // 64 bits go through an integer, and then the exponent in two halves, which each are in range.
        let short = self.rounded(64);
        let mantissa = i128::try_from(&short.mantissa).unwrap_or(0) as f64;
        let exponent = short.exponent.clamp(-2000, 2000) as i32;
        let value = mantissa * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2);
        value.clamp(f64::MIN, f64::MAX)
    }
}

impl From<f64> for Dyadic {
    /// Exact for finite numbers.
    fn from(value: f64) -> Self {
        let bits = value.to_bits();
        let (fraction, exponent) = (bits & ((1 << 52) - 1), (bits >> 52 & 0x7ff) as i64);
        let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
        if mantissa == 0 {
            return Self::zero();
        }
        // Few bits make fast products.
        let zeros = mantissa.trailing_zeros();
        let mantissa = BigInt::from(mantissa >> zeros);
        let mantissa = if value < 0.0 { -mantissa } else { mantissa };
        Self { mantissa, exponent: exponent.max(1) - 1075 + i64::from(zeros) }
    }
}

impl From<DoubleDouble> for Dyadic {
    fn from(value: DoubleDouble) -> Self {
        &Self::from(value.to_f64()) + &Self::from(value.low())
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;
    fn add(self, other: Self) -> Dyadic {
        let (high, low) = if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        if high.is_zero() {
            return low.clone();
        }
        let shift = (high.exponent - low.exponent) as u64;
        Dyadic { mantissa: (&high.mantissa << shift) + &low.mantissa, exponent: low.exponent }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;
    fn neg(self) -> Dyadic {
        Dyadic { mantissa: -&self.mantissa, exponent: self.exponent }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;
    fn sub(self, other: Self) -> Dyadic {
        self + &-other
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;
    fn mul(self, other: Self) -> Dyadic {
        if self.is_zero() || other.is_zero() {
            return Dyadic::zero();
        }
        Dyadic { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Dyadic {}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Dyadic {
    fn cmp(&self, other: &Self) -> Ordering {
        match (self - other).mantissa.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }
}

/// All minors of the first rows of a matrix without a division, by expansion along their last row: `result[mask]` has the
/// columns in `mask` and as many rows from the top as columns.
pub(crate) fn minors(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> Dyadic) -> Vec<Dyadic> {
    let mut result = vec![Dyadic::zero(); 1 << columns];
    result[0] = Dyadic::one();
    for mask in 1usize..1 << columns {
        let order = mask.count_ones() as usize;
        if order > rows {
            continue;
        }
        let mut sum = Dyadic::zero();
        let mut sign = order % 2 == 1; // the sign of the first column in the last row
        for column in (0..columns).filter(|column| mask >> column & 1 == 1) {
            let term = &entry(order - 1, column) * &result[mask & !(1 << column)];
            sum = if sign { &sum + &term } else { &sum - &term };
            sign = !sign;
        }
        result[mask] = sum;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_are_kept_and_come_back() {
        for value in [0.0, 1.0, -0.1, 1e-310, -5e-324, f64::MAX, f64::MIN_POSITIVE, 0.810_091_212_301_011_8] {
            let exact = Dyadic::from(value);
            assert_eq!((exact.to_f64(), exact.to_f64_below(), exact.to_f64_above()), (value, value, value));
        }
        let third = Dyadic::one().quotient(&Dyadic::integer(3), 200);
        assert!(third.to_f64_below() < third.to_f64_above());
        let minus = (-&Dyadic::one()).quotient(&Dyadic::integer(3), 200);
        assert!(&minus * &Dyadic::integer(3) <= -&Dyadic::one() && minus.to_f64() == -1.0 / 3.0);
        let root = Dyadic::integer(2).sqrt(300);
        assert!((&root.square() - &Dyadic::integer(2)).magnitude() < -295);
        let small = Dyadic::power_of_two(-2001).sqrt(100);
        assert!((&small.square().shifted(2001) - &Dyadic::one()).magnitude() < -95);
    }

    #[test]
    fn minors_are_determinants() {
        let matrix = [[2, -1, 3], [0, 5, 7], [4, 1, -6]];
        let all = minors(3, 3, |i, j| Dyadic::integer(matrix[i][j]));
        assert_eq!(all[0b111], Dyadic::integer(2 * (-30 - 7) + (0 - 28) + 3 * (0 - 20)));
        assert_eq!(all[0b101], Dyadic::integer(14));
        assert_eq!(all[0b10], Dyadic::integer(-1));
    }
}
