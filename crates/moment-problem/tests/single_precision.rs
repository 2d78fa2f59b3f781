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

/// Distance of the lower bounds.
fn distance(pair: FloatFloat, truth: DoubleDouble) -> f64 {
    let value = f64::from(pair.to_f32());
    assert!((0.0..=1.0).contains(&value), "{value}");
    (value - truth.to_f64()).abs()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Alphas in circulation for single precision; b* of the interior, so that every vector becomes valid.
    #[test]
    fn pairs_of_floats_agree_with_double_double((surfaces, z_f) in kernels()) {
        let z_f = f64::from(z_f as f32);
        let s = f64::from((2.0 * z_f - 1.0) as f32);
        let four = [0.0, 0.375, 0.0, 0.375];
        let six = [0.0, 0.48, 0.0, 0.451, 0.0, 0.45];
        let inside = [0.5, 0.375, 0.3125, 0.273_437_5];
        let lower = |surfaces: &[(f64, f64)]| {
            let pairs = stored::<FloatFloat, 4>(surfaces, true, 5e-7, four);
            let truth = stored::<DoubleDouble, 4>(surfaces, true, 5e-7, four);
            let h4 = distance(
                hamburger4(&pairs, FloatFloat::from(s as f32)).lower,
                hamburger4(&truth, DoubleDouble::from(s)).lower,
            );
            let pairs = stored::<FloatFloat, 6>(surfaces, true, 5e-6, six);
            let truth = stored::<DoubleDouble, 6>(surfaces, true, 5e-6, six);
            let h6 = distance(
                hamburger(&pairs, FloatFloat::from(s as f32)).lower,
                hamburger(&truth, DoubleDouble::from(s)).lower,
            );
            let pairs = stored::<FloatFloat, 4>(surfaces, false, 2e-6, inside);
            let truth = stored::<DoubleDouble, 4>(surfaces, false, 2e-6, inside);
            let hausdorff = distance(
                hausdorff4(&pairs, FloatFloat::from(z_f as f32)).lower,
                hausdorff4(&truth, DoubleDouble::from(z_f)).lower,
            );
            [h4, h6, hausdorff]
        };
        let errors = lower(&surfaces);
        prop_assert!(errors.iter().all(|&error| error < 1e-4), "{errors:?} {surfaces:?} {z_f}");
    }
}
