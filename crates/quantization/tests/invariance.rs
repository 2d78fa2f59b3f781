//! Gain, range and proved bound are those of the normalised interval, whatever the unit of depth.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use moment_problem::Basis;
use proptest::prelude::*;
use quantization::{
    DepthInterval, Optimum, QuantizationError, RANGE_TOLERANCE, Search, bound, optimise, transform_range,
};

/// Enough for the published gain at these orders.
const SEARCH: Search = Search { structure: quantization::Structure::Dense, starts: Some(48), seed: 1 };

fn found(basis: &Basis, start: f64, end: f64) -> Optimum {
    let interval = DepthInterval::new(start, end).unwrap();
    let optimum = optimise(basis, interval, &SEARCH).unwrap();
    let (min, max) = transform_range(basis, optimum.depths, &optimum.transform);
    assert!(min >= -RANGE_TOLERANCE && max <= 1.0 + RANGE_TOLERANCE, "{interval}: {min} {max}");
    assert!(min <= RANGE_TOLERANCE && max >= 1.0 - RANGE_TOLERANCE, "{interval}: {min} {max}");
    assert_eq!((min, max), (optimum.range_min, optimum.range_max));
    assert!(optimum.gain_bits <= optimum.bound_bits + 1e-9);
    optimum
}

#[test]
fn metres_kilometres_and_slices_gain_what_unit_depths_gain() {
    for (order, gain, start, end) in [
        (6, 30.587, 0.3, 1000.0),
        (4, 12.278, 1.0, 100_000.0),
        (4, 12.278, 0.5, 0.5001),
        (6, 30.587, 0.5, 0.5001),
        (4, 12.278, -3e7, -2e7),
        (2, 2.0, 1e12, 2e12),
        // Rounded here, the matrix would leave 4e-4 of its box unused.
        (5, 20.375_678, 807.504_692_500_976_4, 810.620_688_791_863),
    ] {
        let optimum = found(&Basis::power(order), start, end);
        assert!(
            (optimum.gain_bits - gain).abs() < 1e-3,
            "{order} on [{start}, {end}]: {}",
            optimum.gain_bits
        );
    }
    // Exponential warps of any size: those of exp(30z) are the powers of one number.
    let warped = found(&"exp(30z),exp(60z)".parse().unwrap(), 0.0, 1.0);
    let squares = found(&Basis::power(2), 1.0, 30f64.exp());
    let scale = 3.0 * (30f64.exp() - 1.0).log2();
    assert!((warped.gain_bits + scale - squares.gain_bits).abs() < 1e-6, "{}", warped.gain_bits);
}

#[test]
fn what_does_not_survive_rounding_is_an_error_with_its_numbers() {
    let basis: Basis = "z, z^3, exp(1z)".parse().unwrap();
    let interval = DepthInterval::new(0.5, 0.50001).unwrap();
    let error = optimise(&basis, interval, &SEARCH).unwrap_err();
    assert!(
        matches!(error, QuantizationError::Contradicted { .. } | QuantizationError::Singular { .. }),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn every_affine_image_of_an_interval_gains_the_same(
        order in 1..=5usize,
        start in -1e3..1e3f64,
        length in (-4.0..6.0f64).prop_map(|power| 10f64.powf(power)),
    ) {
        let basis = Basis::power(order);
        let signed = found(&basis, -1.0, 1.0);
        let image = found(&basis, start, start + length);
        prop_assert!((image.gain_bits - signed.gain_bits).abs() < 1e-6, "{} {}", image.gain_bits, signed.gain_bits);
        prop_assert!((image.bound_bits - signed.bound_bits).abs() < 1e-9);
        // The bound of |det theta| itself grows with the unit of depth, by the determinant between the two bases.
        let interval = DepthInterval::new(start, start + length).unwrap();
        let raw = bound(&basis, interval).unwrap();
        let between = 0.5 * (order * (order + 1)) as f64 * interval.length().log2();
        prop_assert!((raw + between - signed.bound_bits).abs() < 1e-9);
    }
}
