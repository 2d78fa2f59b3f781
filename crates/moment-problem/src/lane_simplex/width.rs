//! Which vectors this machine has, and functions compiled for each.

use super::exact::{ExactBound, ExactSimplex, Start};
use super::lanes::{Portable, Quad};
use super::{Work, solve};

/// How wide the vectors are that the solver was compiled for. Results are the same for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

impl Width {
    /// The widest of this machine.
    pub(super) fn widest() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                let wider = is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl");
                return if wider { Self::Avx512 } else { Self::Avx2 };
            }
        }
        Self::Portable
    }

    /// All that this machine has, the widest first.
    pub(super) fn all() -> Vec<Self> {
        match Self::widest() {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => vec![Self::Avx512, Self::Avx2, Self::Portable],
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => vec![Self::Avx2, Self::Portable],
            Self::Portable => vec![Self::Portable],
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "AVX-512, 8 programs",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "AVX2, 4 programs",
            Self::Portable => "portable, 4 programs",
        }
    }

    /// Solves the programs of a chunk for D = R - 1 functions.
    pub(super) fn solve<const D: usize, const R: usize>(self, work: &mut Work<'_, R>) {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a width is made only where its features were detected.
            Self::Avx512 => unsafe { x86::solve_avx512::<D, R>(work) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Self::Avx2 => unsafe { x86::solve_avx2::<D, R>(work) },
            Self::Portable => solve::<Portable, D, R>(work),
        }
    }

    /// The simplex method in double-double from a start.
    pub(super) fn walk(self, simplex: &ExactSimplex<'_>, start: &Start<'_>) -> Option<ExactBound> {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as in `solve`; every AVX-512 width has AVX2 too.
            Self::Avx512 | Self::Avx2 => unsafe { x86::walk(simplex, start) },
            Self::Portable => simplex.walk(start),
        }
    }

    /// b = T m for each program, in the same order of sums everywhere.
    pub(super) fn moments(self, transform: &[Quad], coordinates: &[f64], rows: &[u32], moments: &mut [Quad]) {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as in `solve`; every AVX-512 width has AVX2 too.
            Self::Avx512 | Self::Avx2 => unsafe { x86::moments(transform, coordinates, rows, moments) },
            Self::Portable => moments_of(transform, coordinates, rows, moments),
        }
    }

    /// values + errors += factor * row over the support, in double-double.
    pub(super) fn accumulate(
        self,
        factor: (f64, f64),
        row: (&[f64], &[f64]),
        values: &mut [f64],
        errors: &mut [f64],
    ) {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as in `moments`.
            Self::Avx512 | Self::Avx2 => unsafe { x86::accumulate(factor, row, values, errors) },
            Self::Portable => add_product(factor, row, values, errors),
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::vectors::{Avx2, Avx512};
    use super::*;

    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    pub(super) fn solve_avx512<const D: usize, const R: usize>(work: &mut Work<'_, R>) {
        solve::<Avx512, D, R>(work);
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn solve_avx2<const D: usize, const R: usize>(work: &mut Work<'_, R>) {
        solve::<Avx2, D, R>(work);
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn walk(simplex: &ExactSimplex<'_>, start: &Start<'_>) -> Option<ExactBound> {
        simplex.walk(start)
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn moments(transform: &[Quad], coordinates: &[f64], rows: &[u32], moments: &mut [Quad]) {
        moments_of(transform, coordinates, rows, moments);
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn accumulate(
        factor: (f64, f64),
        row: (&[f64], &[f64]),
        values: &mut [f64],
        errors: &mut [f64],
    ) {
        add_product(factor, row, values, errors);
    }
}

/// Sums of every so many products are added in the end: short chains round less and wait less.
pub(super) const CHAINS: usize = 4;

#[inline(always)]
fn moments_of(transform: &[Quad], coordinates: &[f64], rows: &[u32], moments: &mut [Quad]) {
    let dimensions = transform.len();
    for (&row, moments) in rows.iter().zip(moments) {
        let coordinates = &coordinates[row as usize * dimensions..][..dimensions];
        let mut sums = [[0.0f64; 4]; CHAINS];
        let (groups, rest) = coordinates.as_chunks::<CHAINS>();
        let (factors, last) = transform.as_chunks::<CHAINS>();
        for (group, factors) in groups.iter().zip(factors) {
            for chain in 0..CHAINS {
                for i in 0..4 {
                    sums[chain][i] = factors[chain].0[i].mul_add(group[chain], sums[chain][i]);
                }
            }
        }
        for (chain, (&value, factor)) in rest.iter().zip(last).enumerate() {
            for i in 0..4 {
                sums[chain][i] = factor.0[i].mul_add(value, sums[chain][i]);
            }
        }
        for i in 0..4 {
            moments.0[i] = (sums[0][i] + sums[1][i]) + (sums[2][i] + sums[3][i]);
        }
    }
}

#[inline(always)]
pub(super) fn add_product(factor: (f64, f64), row: (&[f64], &[f64]), values: &mut [f64], errors: &mut [f64]) {
    for (((&high, &low), value), error) in row.0.iter().zip(row.1).zip(values).zip(errors) {
        let product = factor.0 * high;
        let lost = factor.0.mul_add(high, -product) + (factor.0 * low + factor.1 * high);
        let sum = *value + product;
        let part = sum - *value;
        *error += ((*value - (sum - part)) + (product - part)) + lost;
        *value = sum;
    }
}
