//! Doubles side by side, one linear program in each lane. Every operation is done lane by lane and rounded once, so that a
//! program's result depends neither on the number of lanes nor on what the others hold.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

/// Lanes of the widest vector.
pub(super) const MAX_LANES: usize = 8;

/// One value for each lane, in memory.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneValues(pub(super) [f64; MAX_LANES]);

/// Entries of a column, or moments, behind the row of ones; zero beyond the rank.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Quad(pub(super) [f64; 4]);

/// A truth value for each lane.
pub(super) trait Mask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Lane i from bit i.
    fn of(bits: u32) -> Self;
    /// Bit i from lane i.
    fn bits(self) -> u32;
}

/// A vector of [`Lanes::COUNT`] doubles.
pub(super) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    const COUNT: usize;
    type Mask: Mask;

    fn splat(value: f64) -> Self;
    fn load(values: &LaneValues) -> Self;
    fn store(self, values: &mut LaneValues);
    /// self * factor + addend, rounded once.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// addend - self * factor, rounded once.
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self;
    fn abs(self) -> Self;
    fn floor(self) -> Self;
    /// `other` where it is larger (a NaN in `other` is passed over).
    fn max(self, other: Self) -> Self;
    /// `other` where it is smaller (a NaN in `other` is passed over).
    fn min(self, other: Self) -> Self;
    fn less(self, other: Self) -> Self::Mask;
    /// self >= other, false for NaN.
    fn at_least(self, other: Self) -> Self::Mask;
    fn equal(self, other: Self) -> Self::Mask;
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The rows of `table` that the lanes name, transposed; whatever names no row (NaN included) takes the last one.
    fn gather(table: &[Quad], index: Self) -> [Self; 4];

    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

/// Repeats a block for i = 0, 1, ... below a constant of at most 5, without a loop that the compiler might keep.
macro_rules! unrolled {
    ($i:ident < $n:expr, $body:block) => {{
        { let $i = 0usize; if $i < $n $body }
        { let $i = 1usize; if $i < $n $body }
        { let $i = 2usize; if $i < $n $body }
        { let $i = 3usize; if $i < $n $body }
        { let $i = 4usize; if $i < $n $body }
    }};
}
pub(super) use unrolled;

/// Plain Rust, four lanes.
#[derive(Clone, Copy)]
pub(super) struct Portable([f64; 4]);

/// Bits of [`Portable`]'s lanes.
#[derive(Clone, Copy)]
pub(super) struct PortableMask(u32);

impl BitAnd for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0 & 15)
    }
}

impl Mask for PortableMask {
    #[inline(always)]
    fn of(bits: u32) -> Self {
        Self(bits & 15)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
}

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| of(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn compare(self, other: Self, of: impl Fn(f64, f64) -> bool) -> PortableMask {
        PortableMask((0..4).map(|i| u32::from(of(self.0[i], other.0[i])) << i).sum())
    }
}

macro_rules! portable_operator {
    ($name:ident, $method:ident, $operator:tt) => {
        impl $name for Portable {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
            }
        }
    };
}
portable_operator!(Add, add, +);
portable_operator!(Sub, sub, -);
portable_operator!(Mul, mul, *);
portable_operator!(Div, div, /);

impl Lanes for Portable {
    const COUNT: usize = 4;
    type Mask = PortableMask;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; 4])
    }
    #[inline(always)]
    fn load(values: &LaneValues) -> Self {
        Self(std::array::from_fn(|i| values.0[i]))
    }
    #[inline(always)]
    fn store(self, values: &mut LaneValues) {
        values.0[..4].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i].mul_add(factor.0[i], addend.0[i])))
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        Self(std::array::from_fn(|i| (-self.0[i]).mul_add(factor.0[i], addend.0[i])))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.map(f64::floor))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if b > a { b } else { a })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if b < a { b } else { a })
    }
    #[inline(always)]
    fn less(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a >= b)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a == b)
    }
    #[inline(always)]
    fn select(mask: PortableMask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if mask.0 >> i & 1 == 1 { yes.0[i] } else { no.0[i] }))
    }
    #[inline(always)]
    fn gather(table: &[Quad], index: Self) -> [Self; 4] {
        let last = table.len() - 1;
        let row = |lane: usize| {
            let at = index.0[lane];
            let inside = at > -1.0 && at < table.len() as f64;
            table[if inside { at as usize } else { last }].0
        };
        let rows: [[f64; 4]; 4] = std::array::from_fn(row);
        std::array::from_fn(|i| Self(std::array::from_fn(|lane| rows[lane][i])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(target_arch = "x86_64")]
    use crate::lane_simplex::vectors::{Avx2, Avx512};

    /// Every operation on the first four lanes, as bits.
    #[inline(always)]
    fn exercise<V: Lanes>() -> Vec<u64> {
        let a = V::load(&LaneValues([1.5, -0.0, 3.25, -7.0, 1e300, 0.1, 0.7, -7.0]));
        let b = V::load(&LaneValues([0.3, 2.0, f64::NAN, 1.0 / 3.0, 1e300, -0.2, 0.7, 5.0]));
        let c = V::splat(-0.03);
        let table: Vec<Quad> = (0..9).map(|i| Quad(std::array::from_fn(|k| (10 * i + k) as f64))).collect();
        let index = V::load(&LaneValues([3.0, f64::NAN, -4.0, 8.0, 9.0, 0.0, 1e30, 7.0]));
        let mut results = vec![
            a + b,
            a - b,
            a * b,
            a / b,
            a.mul_add(b, c),
            a.neg_mul_add(b, c),
            a.abs(),
            a.floor(),
            a.max(b),
            b.max(a),
            a.min(b),
            b.min(a),
            V::select(a.less(b), c, b),
        ];
        results.extend(V::gather(&table, index));
        let mut values = LaneValues([0.0; MAX_LANES]);
        let mut bits = Vec::new();
        for vector in results {
            vector.store(&mut values);
            // Which NaN a sum gives is not specified.
            bits.extend(values.0[..4].iter().map(|value| if value.is_nan() { 1 } else { value.to_bits() }));
        }
        for mask in
            [a.less(b), a.at_least(b), a.equal(a), !a.less(b), V::Mask::of(5) | a.less(b) & a.equal(a)]
        {
            bits.push(u64::from(mask.bits() & 15));
        }
        bits
    }

    #[test]
    fn all_widths_agree_bit_for_bit() {
        let portable = exercise::<Portable>();
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,fma")]
            fn avx2() -> Vec<u64> {
                exercise::<Avx2>()
            }
            #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
            fn avx512() -> Vec<u64> {
                exercise::<Avx512>()
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the features were detected.
                assert_eq!(portable, unsafe { avx2() });
            }
            if is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") {
                // SAFETY: the features were detected.
                assert_eq!(portable, unsafe { avx512() });
            }
        }
        assert_eq!(portable[4 * 13..4 * 14], [30.0, 80.0, 80.0, 80.0].map(f64::to_bits));
    }
}
