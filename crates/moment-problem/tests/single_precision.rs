//! Bounds from moments in single precision: pairs of floats against the same formulas in double-double.

use moment_problem::arithmetic::{DoubleDouble, FloatFloat, Real};
use moment_problem::hamburger::{hamburger, hamburger4};
use moment_problem::hausdorff::hausdorff4;
use proptest::prelude::*;

/// Up to five surfaces, some of them close, some of small weight, and z_f, sometimes at a surface.
fn kernels() -> impl Strategy<Value = (Vec<(f64, f64)>, f64)> {
    let surface = (0.0..1.0f64, 0.0..6.0f64).prop_map(|(z, digits)| (z, 10f64.powf(-digits)));
    let close = (1usize..=5, -6.0..0.0f64);
    (prop::collection::vec(surface, 1..=5), close, 0.0..1.0f64, any::<bool>()).prop_map(
        |(mut surfaces, (moved, spread), z_f, at_surface)| {
            let centre = surfaces[0].0;
            for (z, _) in surfaces.iter_mut().take(moved) {
                *z = (centre + (*z - centre) * 10f64.powf(spread)).clamp(0.0, 1.0);
            }
            let total: f64 = surfaces.iter().map(|(_, w)| w).sum();
            surfaces.iter_mut().for_each(|(_, w)| *w /= total);
            let z_f = if at_surface { surfaces[surfaces.len() - 1].0 } else { z_f };
            (surfaces, z_f)
        },
    )
}

/// Moments on [-1, 1] or [0, 1], stored as single floats, then biased without a further loss.
fn stored<R: Real, const M: usize>(
    surfaces: &[(f64, f64)],
    signed: bool,
    alpha: f64,
    target: [f64; M],
) -> [R; M] {
    std::array::from_fn(|k| {
        let power = |z: f64| (if signed { 2.0 * z - 1.0 } else { z }).powi(k as i32 + 1);
        let moment = surfaces.iter().map(|&(z, w)| w * power(z)).sum::<f64>() as f32;
        let b = R::from_f64(f64::from(moment));
        b + R::from_f64(alpha) * (R::from_f64(target[k]) - b)
    })
}

/// Relative change of a moment that pairs of floats cannot tell from none: four units in the last of their 48 bits,
/// since a factorisation rounds each moment a few times.
const PAIR_ROUNDING: f64 = 4.0 / (1u64 << 48) as f64;

/// Error where the problem is well-conditioned: far below what any texture holds.
const WELL_CONDITIONED: f64 = 1e-6;

/// What changes of the moments by [`PAIR_ROUNDING`] do to a bound, times this, is still the moments' fault.
const CONDITIONING_SHARE: f64 = 16.0;

/// Error of the lower bound by pairs of floats, and how far rounding of the moments alone may move it.
fn error<const M: usize>(
    surfaces: &[(f64, f64)],
    (signed, alpha, target): (bool, f64, [f64; M]),
    pair: impl Fn(&[FloatFloat; M]) -> FloatFloat,
    double: impl Fn(&[DoubleDouble; M]) -> DoubleDouble,
) -> (f64, f64) {
    let value = f64::from(pair(&stored(surfaces, signed, alpha, target)).to_f32());
    assert!((0.0..=1.0).contains(&value), "{value}");
    let moments: [DoubleDouble; M] = stored(surfaces, signed, alpha, target);
    let truth = double(&moments).to_f64();
    let moved: f64 = (0..M)
        .flat_map(|k| [1.0 + PAIR_ROUNDING, 1.0 - PAIR_ROUNDING].map(|factor| (k, factor)))
        .map(|(k, factor)| {
            let mut moments = moments;
            moments[k] = moments[k] * DoubleDouble::from(factor);
            (double(&moments).to_f64() - truth).abs()
        })
        .sum();
    ((value - truth).abs(), WELL_CONDITIONED + CONDITIONING_SHARE * moved)
}

/// Errors and limits of two, three pivots and of the interval, at alphas in circulation for single precision; b* of
/// the interior, so that every vector becomes valid.
fn errors(surfaces: &[(f64, f64)], z_f: f64) -> [(f64, f64); 3] {
    let z_f = f64::from(z_f as f32);
    let s = f64::from((2.0 * z_f - 1.0) as f32);
    let (pair_s, double_s) = (FloatFloat::from(s as f32), DoubleDouble::from(s));
    let (pair_z, double_z) = (FloatFloat::from(z_f as f32), DoubleDouble::from(z_f));
    [
        error(
            surfaces,
            (true, 5e-7, [0.0, 0.375, 0.0, 0.375]),
            |b| hamburger4(b, pair_s).lower,
            |b| hamburger4(b, double_s).lower,
        ),
        error(
            surfaces,
            (true, 5e-6, [0.0, 0.48, 0.0, 0.451, 0.0, 0.45]),
            |b| hamburger(b, pair_s).lower,
            |b| hamburger(b, double_s).lower,
        ),
        error(
            surfaces,
            (false, 2e-6, [0.5, 0.375, 0.3125, 0.273_437_5]),
            |b| hausdorff4(b, pair_z).lower,
            |b| hausdorff4(b, double_z).lower,
        ),
    ]
}

/// Three surfaces within 1.3e-6, and z_f just behind them: the bound on the interval hangs on the last bits.
#[test]
fn three_close_surfaces_are_wrong_by_what_their_moments_leave_open() {
    let surfaces = [
        (0.766_271_345_305_625, 0.238_060_391_042_054_34),
        (0.766_270_346_390_833_1, 0.465_222_213_212_366_23),
        (0.766_271_521_303_738_8, 0.296_717_395_745_579_3),
    ];
    let errors = errors(&surfaces, 0.766_271_531_581_878_7);
    assert!(errors.iter().all(|(error, limit)| error <= limit), "{errors:?}");
    assert!(errors[2].0 > 1e-4, "{errors:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    #[test]
    fn pairs_of_floats_agree_with_double_double((surfaces, z_f) in kernels()) {
        let errors = errors(&surfaces, z_f);
        prop_assert!(errors.iter().all(|(error, limit)| error <= limit), "{errors:?} {surfaces:?} {z_f}");
    }
}
