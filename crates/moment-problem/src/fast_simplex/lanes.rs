//! Eight doubles at a time, with the same bits on every machine: sums are fused everywhere and searches prefer the
//! lowest lane.

use super::support::LANES;

/// A vector of [`LANES`] doubles.
pub(super) trait Lanes: Copy {
    fn splat(value: f64) -> Self;
    fn load(values: &[f64; LANES]) -> Self;
    fn store(self, values: &mut [f64; LANES]);
    /// self * factor + addend, rounded once.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// addend - self * factor, rounded once.
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self;
    fn add(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// `other` where it is larger (a NaN in `other` is passed over).
    fn max(self, other: Self) -> Self;
    /// `other` where it is smaller (a NaN in `other` is passed over).
    fn min(self, other: Self) -> Self;
    /// `yes` in lanes where self < other, `no` elsewhere.
    fn where_less(self, other: Self, yes: Self, no: Self) -> Self;
    /// Least value and the first lane that has it.
    fn least(self) -> (f64, usize);

    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        let mut values = [0.0; LANES];
        self.store(&mut values);
        values[lane % LANES]
    }
}

/// Plain Rust.
#[derive(Clone, Copy)]
pub(super) struct Portable([f64; LANES]);

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let mut values = self.0;
        for (value, &other) in values.iter_mut().zip(&other.0) {
            *value = of(*value, other);
        }
        Self(values)
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn load(values: &[f64; LANES]) -> Self {
        Self(*values)
    }
    #[inline(always)]
    fn store(self, values: &mut [f64; LANES]) {
        *values = self.0;
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        let mut values = addend.0;
        for i in 0..LANES {
            values[i] = self.0[i].mul_add(factor.0[i], values[i]);
        }
        Self(values)
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        let mut values = addend.0;
        for i in 0..LANES {
            values[i] = (-self.0[i]).mul_add(factor.0[i], values[i]);
        }
        Self(values)
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.zip(self, |a, _| a.abs())
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
    fn where_less(self, other: Self, yes: Self, no: Self) -> Self {
        let mut values = no.0;
        for i in 0..LANES {
            if self.0[i] < other.0[i] {
                values[i] = yes.0[i];
            }
        }
        Self(values)
    }
    #[inline(always)]
    fn least(self) -> (f64, usize) {
        let mut best = 0;
        for i in 1..LANES {
            if self.0[i] < self.0[best] {
                best = i;
            }
        }
        (self.0[best], best)
    }
}

/// Two registers of AVX2 with fused multiplication. Values exist only where the features were detected.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(super) struct Avx2(std::arch::x86_64::__m256d, std::arch::x86_64::__m256d);

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Avx2, LANES, Lanes};
    use std::arch::x86_64::*;

    /// One instruction on both halves.
    macro_rules! both {
        ($of:ident, $($argument:expr),+) => {
            // SAFETY: this type is used only inside functions compiled for AVX2 and FMA, which are called only where
            // these were detected.
            unsafe { Avx2($of($($argument.0),+), $of($($argument.1),+)) }
        };
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(value: f64) -> Self {
            // SAFETY: as in `both`.
            let half = unsafe { _mm256_set1_pd(value) };
            Self(half, half)
        }
        #[inline(always)]
        fn load(values: &[f64; LANES]) -> Self {
            // SAFETY: as in `both`; the eight values are readable, unaligned.
            unsafe { Self(_mm256_loadu_pd(values.as_ptr()), _mm256_loadu_pd(values.as_ptr().add(4))) }
        }
        #[inline(always)]
        fn store(self, values: &mut [f64; LANES]) {
            // SAFETY: as in `both`; the eight values are writable, unaligned.
            unsafe {
                _mm256_storeu_pd(values.as_mut_ptr(), self.0);
                _mm256_storeu_pd(values.as_mut_ptr().add(4), self.1);
            }
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            both!(_mm256_fmadd_pd, self, factor, addend)
        }
        #[inline(always)]
        fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
            both!(_mm256_fnmadd_pd, self, factor, addend)
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            both!(_mm256_add_pd, self, other)
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            both!(_mm256_mul_pd, self, other)
        }
        #[inline(always)]
        fn div(self, other: Self) -> Self {
            both!(_mm256_div_pd, self, other)
        }
        #[inline(always)]
        fn abs(self) -> Self {
            let sign = Self::splat(-0.0);
            both!(_mm256_andnot_pd, sign, self)
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // The instruction returns its second operand unless the first is larger.
            both!(_mm256_max_pd, other, self)
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            both!(_mm256_min_pd, other, self)
        }
        #[inline(always)]
        fn where_less(self, other: Self, yes: Self, no: Self) -> Self {
            // SAFETY: as in `both`.
            let mask = unsafe {
                Self(
                    _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0),
                    _mm256_cmp_pd::<_CMP_LT_OQ>(self.1, other.1),
                )
            };
            both!(_mm256_blendv_pd, no, yes, mask)
        }
        #[inline(always)]
        fn least(self) -> (f64, usize) {
            // SAFETY: as in `both`.
            unsafe {
                let four = _mm256_min_pd(self.0, self.1);
                let two = _mm_min_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd::<1>(four));
                let one = _mm_min_sd(two, _mm_unpackhi_pd(two, two));
                let least = _mm256_broadcastsd_pd(one);
                let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, least));
                let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_EQ_OQ>(self.1, least));
                let lane = (low | (high << (LANES / 2))).trailing_zeros() as usize;
                (_mm_cvtsd_f64(one), lane.min(LANES - 1))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on some values, as bits.
    #[inline(always)]
    fn exercise<V: Lanes>() -> Vec<u64> {
        let a = V::load(&[1.5, -0.0, 3.25, -7.0, 1e300, 0.1, 0.7, -7.0]);
        let b = V::load(&[0.3, 2.0, -1.0, 1.0 / 3.0, 1e300, -0.2, 0.7, 5.0]);
        let c = V::splat(-0.03);
        let results = [
            a.mul_add(b, c),
            a.neg_mul_add(b, c),
            a.add(b),
            a.mul(b),
            a.div(b),
            a.abs(),
            a.max(b),
            b.max(a),
            a.min(b),
            a.where_less(b, c, V::zero()),
        ];
        let mut bits: Vec<u64> =
            results.iter().flat_map(|v| (0..LANES).map(|i| v.lane(i).to_bits())).collect();
        let (least, lane) = a.least();
        bits.extend([least.to_bits(), lane as u64]);
        bits
    }

    #[test]
    fn all_widths_agree_bit_for_bit() {
        let portable = exercise::<Portable>();
        assert_eq!(portable[portable.len() - 2..], [(-7.0f64).to_bits(), 3]);
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,fma")]
            fn wide() -> Vec<u64> {
                exercise::<Avx2>()
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the features were detected.
                assert_eq!(portable, unsafe { wide() });
            }
        }
    }
}
