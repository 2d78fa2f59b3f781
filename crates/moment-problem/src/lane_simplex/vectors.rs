//! Lanes in the vector registers of x86-64. Values exist only inside functions compiled for the features, which are called
//! only where these were detected.

// Intrinsics of vectors in registers are safe inside functions compiled for them, which inlining alone makes of these.
#![allow(unused_unsafe)]

use super::lanes::{LaneValues, Lanes, Mask, Quad};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

/// Four doubles; needs AVX2 and FMA.
#[derive(Clone, Copy)]
pub(super) struct Avx2(__m256d);

/// All bits of a lane, or none.
#[derive(Clone, Copy)]
pub(super) struct Avx2Mask(__m256d);

/// Eight doubles; needs AVX-512 F, DQ and VL.
#[derive(Clone, Copy)]
pub(super) struct Avx512(__m512d);

/// A bit for each lane.
#[derive(Clone, Copy)]
pub(super) struct Avx512Mask(__mmask8);

macro_rules! operator {
    ($type:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: a value exists, so the features were detected.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}
operator!(Avx2, Add, add, _mm256_add_pd);
operator!(Avx2, Sub, sub, _mm256_sub_pd);
operator!(Avx2, Mul, mul, _mm256_mul_pd);
operator!(Avx2, Div, div, _mm256_div_pd);
operator!(Avx2Mask, BitAnd, bitand, _mm256_and_pd);
operator!(Avx2Mask, BitOr, bitor, _mm256_or_pd);
operator!(Avx512, Add, add, _mm512_add_pd);
operator!(Avx512, Sub, sub, _mm512_sub_pd);
operator!(Avx512, Mul, mul, _mm512_mul_pd);
operator!(Avx512, Div, div, _mm512_div_pd);

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: a value exists, so the features were detected.
        unsafe { Self(_mm256_xor_pd(self.0, _mm256_castsi256_pd(_mm256_set1_epi64x(-1)))) }
    }
}

impl Mask for Avx2Mask {
    #[inline(always)]
    fn of(bits: u32) -> Self {
        // SAFETY: masks are made only where the features were detected.
        unsafe {
            let lanes = _mm256_setr_epi64x(1, 2, 4, 8);
            let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(bits)), lanes);
            Self(_mm256_castsi256_pd(_mm256_cmpeq_epi64(set, lanes)))
        }
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: a value exists, so the features were detected.
        unsafe { _mm256_movemask_pd(self.0) as u32 }
    }
}

impl BitAnd for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask for Avx512Mask {
    #[inline(always)]
    fn of(bits: u32) -> Self {
        Self(bits as u8)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

impl Lanes for Avx2 {
    const COUNT: usize = 4;
    type Mask = Avx2Mask;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: used only where the features were detected.
        Self(unsafe { _mm256_set1_pd(value) })
    }
    #[inline(always)]
    fn load(values: &LaneValues) -> Self {
        // SAFETY: as in `splat`; the first four of eight values are readable.
        Self(unsafe { _mm256_loadu_pd(values.0.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, values: &mut LaneValues) {
        // SAFETY: as in `splat`; the first four of eight values are writable.
        unsafe { _mm256_storeu_pd(values.0.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_fmadd_pd(self.0, factor.0, addend.0) })
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_fnmadd_pd(self.0, factor.0, addend.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_floor_pd(self.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // The instruction returns its second operand unless the first is larger.
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_max_pd(other.0, self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_min_pd(other.0, self.0) })
    }
    #[inline(always)]
    fn less(self, other: Self) -> Avx2Mask {
        // SAFETY: as in `splat`.
        Avx2Mask(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Avx2Mask {
        // SAFETY: as in `splat`.
        Avx2Mask(unsafe { _mm256_cmp_pd::<_CMP_GE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn equal(self, other: Self) -> Avx2Mask {
        // SAFETY: as in `splat`.
        Avx2Mask(unsafe { _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, mask.0) })
    }
    #[inline(always)]
    fn gather(table: &[Quad], index: Self) -> [Self; 4] {
        debug_assert!(!table.is_empty());
        // SAFETY: as in `splat`; as unsigned numbers all indices are at most the last one, what is no number included.
        unsafe {
            let last = _mm_set1_epi32(table.len() as i32 - 1);
            let index = _mm_min_epu32(_mm256_cvttpd_epi32(index.0), last);
            let start = table.as_ptr().cast::<f64>();
            let a = _mm256_load_pd(start.add(4 * _mm_extract_epi32::<0>(index) as usize));
            let b = _mm256_load_pd(start.add(4 * _mm_extract_epi32::<1>(index) as usize));
            let c = _mm256_load_pd(start.add(4 * _mm_extract_epi32::<2>(index) as usize));
            let d = _mm256_load_pd(start.add(4 * _mm_extract_epi32::<3>(index) as usize));
            let (p, q) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
            let (r, s) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
            [
                Self(_mm256_permute2f128_pd::<0x20>(p, r)),
                Self(_mm256_permute2f128_pd::<0x20>(q, s)),
                Self(_mm256_permute2f128_pd::<0x31>(p, r)),
                Self(_mm256_permute2f128_pd::<0x31>(q, s)),
            ]
        }
    }
}

impl Lanes for Avx512 {
    const COUNT: usize = 8;
    type Mask = Avx512Mask;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: used only where the features were detected.
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn load(values: &LaneValues) -> Self {
        // SAFETY: as in `splat`; eight values are readable.
        Self(unsafe { _mm512_loadu_pd(values.0.as_ptr()) })
    }
    #[inline(always)]
    fn store(self, values: &mut LaneValues) {
        // SAFETY: as in `splat`; eight values are writable.
        unsafe { _mm512_storeu_pd(values.0.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, addend.0) })
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, addend: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_fnmadd_pd(self.0, factor.0, addend.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_max_pd(other.0, self.0) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_min_pd(other.0, self.0) })
    }
    #[inline(always)]
    fn less(self, other: Self) -> Avx512Mask {
        // SAFETY: as in `splat`.
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn at_least(self, other: Self) -> Avx512Mask {
        // SAFETY: as in `splat`.
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_GE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn equal(self, other: Self) -> Avx512Mask {
        // SAFETY: as in `splat`.
        Avx512Mask(unsafe { _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
        // SAFETY: as in `splat`.
        Self(unsafe { _mm512_mask_blend_pd(mask.0, no.0, yes.0) })
    }
    #[inline(always)]
    fn gather(table: &[Quad], index: Self) -> [Self; 4] {
        debug_assert!(!table.is_empty());
        let mut place = [0u32; 8];
        // SAFETY: as in `splat`; as unsigned numbers all indices are at most the last one, what is no number included.
        unsafe {
            let last = _mm256_set1_epi32(table.len() as i32 - 1);
            let index = _mm256_min_epu32(_mm512_cvttpd_epi32(index.0), last);
            _mm256_storeu_si256(place.as_mut_ptr().cast(), index);
            let start = table.as_ptr().cast::<f64>();
            // No closures: these would not be compiled for the features.
            macro_rules! two {
                ($i:expr) => {
                    _mm512_insertf64x4::<1>(
                        _mm512_castpd256_pd512(_mm256_load_pd(start.add(4 * place[$i] as usize))),
                        _mm256_load_pd(start.add(4 * place[$i + 4] as usize)),
                    )
                };
            }
            let (a, b, c, d) = (two!(0), two!(1), two!(2), two!(3));
            let (p, q) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
            let (r, s) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
            let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            [
                Self(_mm512_permutex2var_pd(p, low, r)),
                Self(_mm512_permutex2var_pd(q, low, s)),
                Self(_mm512_permutex2var_pd(p, high, r)),
                Self(_mm512_permutex2var_pd(q, high, s)),
            ]
        }
    }
}
