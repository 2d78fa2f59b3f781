//! Optimised transforms: published gains, ranges by an independent route, bounds, bad input.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use moment_problem::Basis;
use quantization::{
    AffineTransform, DepthInterval, Optimum, QuantizationError, Search, Structure, optimise, transform_range,
};

fn found(basis: &str, structure: Structure, starts: Option<usize>) -> Optimum {
    let search = Search { structure, starts, seed: 1 };
    optimise(&basis.parse().unwrap(), DepthInterval::UNIT, &search).unwrap()
}

/// Least and largest stored value by brute force, sharing nothing with the optimiser: samples in machine precision,
/// each bracketed extremum refined by golden sections.
fn range_by_search(basis: &Basis, interval: DepthInterval, theta: &AffineTransform) -> (f64, f64) {
    const SAMPLES: usize = 4000;
    let m = theta.order();
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for row in 0..m {
        for sign in [1.0, -1.0] {
            let value = |z: f64| {
                let b = basis.evaluate(z);
                sign * (theta.offset()[row] + theta.row(row).iter().zip(&b).map(|(t, b)| t * b).sum::<f64>())
            };
            let z = |i: usize| interval.start() + interval.length() * i as f64 / SAMPLES as f64;
            let samples: Vec<f64> = (0..=SAMPLES).map(|i| value(z(i))).collect();
            let mut best = samples[0].max(samples[SAMPLES]);
            for i in 1..SAMPLES {
                if samples[i] >= samples[i - 1] && samples[i] >= samples[i + 1] {
                    let (mut low, mut high) = (z(i - 1), z(i + 1));
                    for _ in 0..80 {
                        let (a, b) = (high - 0.618 * (high - low), low + 0.618 * (high - low));
                        if value(a) > value(b) { high = b } else { low = a }
                    }
                    best = best.max(value(0.5 * (low + high)));
                }
            }
            if sign > 0.0 { range.1 = range.1.max(best) } else { range.0 = range.0.min(-best) }
        }
    }
    range
}

/// 1e-9: what the project demands of a range; rounding a matrix of order 8 leaves some 1e-12.
const RANGE_TOLERANCE: f64 = 1e-9;

#[test]
fn gains_of_power_moments_reach_or_beat_the_published_ones() {
    for (order, structure, least, starts) in [
        (1, Structure::Dense, 0.0, None),
        (2, Structure::Dense, 2.0, None),
        (3, Structure::Dense, 6.2075, None),
        (4, Structure::Dense, 12.2783, None),
        (4, Structure::Parity, 12.2075, None),
        (5, Structure::Dense, 20.3756, None),
        (6, Structure::Dense, 30.5870, None),
        (6, Structure::Parity, 30.5115, None),
        (8, Structure::Dense, 56.80, Some(400)),
        (8, Structure::Parity, 56.70, Some(60)),
    ] {
        let optimum = found(&format!("power:{order}"), structure, starts);
        let gain = optimum.gain_bits;
        assert!((least - 1e-9..least + 0.015).contains(&gain), "order {order}, {structure:?}: {gain}");
        assert!(gain <= optimum.bound_bits, "order {order}: {gain} > {}", optimum.bound_bits);
        let basis = Basis::power(order);
        let (min, max) = range_by_search(&basis, DepthInterval::UNIT, &optimum.transform);
        assert!(min >= -RANGE_TOLERANCE && max <= 1.0 + RANGE_TOLERANCE, "order {order}: {min:e} {max}");
        assert!(min < RANGE_TOLERANCE && max > 1.0 - RANGE_TOLERANCE, "order {order}: {min:e} {max}");
        // What is proved holds what was found.
        let proved = (optimum.range_min, optimum.range_max);
        assert!(
            proved.0 <= min + 1e-10 && proved.1 >= max - 1e-10,
            "order {order}: {proved:?} {min:e} {max}"
        );
        assert!(proved.0 >= -RANGE_TOLERANCE && proved.1 <= 1.0 + RANGE_TOLERANCE, "{proved:?}");
    }
}

#[test]
fn order_two_is_closed_to_a_thousandth_of_a_bit_and_bounds_hold_elsewhere() {
    let two = found("power:2", Structure::Dense, None);
    assert!(two.bound_bits - two.gain_bits < 1e-3 && two.bound_bits >= two.gain_bits, "{two:?}");
    // The published transform: z and 4 z - 4 z^2.
    let expected = [1.0, 0.0, 4.0, -4.0];
    for (entry, expected) in two.transform.matrix().iter().zip(expected) {
        assert!((entry - expected).abs() < 1e-9, "{:?}", two.transform.matrix());
    }
}

#[test]
fn other_bases_are_optimised_within_their_box() {
    for basis in ["trig:2", "z, exp(-2z), sin(3pi z)", "z, z^2, exp(4z), 1/(1+25(z-1/2)^2)"] {
        let optimum = found(basis, Structure::Dense, Some(12));
        let basis: Basis = basis.parse().unwrap();
        let (min, max) = range_by_search(&basis, DepthInterval::UNIT, &optimum.transform);
        assert!(min >= -RANGE_TOLERANCE && max <= 1.0 + RANGE_TOLERANCE, "{basis}: {min:e} {max}");
        assert!(min < RANGE_TOLERANCE && max > 1.0 - RANGE_TOLERANCE, "{basis}");
        assert!(optimum.gain_bits <= optimum.bound_bits, "{basis}");
        // Storing each function scaled to [0, 1] is one of the transforms that it must beat.
        let identity = AffineTransform::identity(basis.len());
        let scaled: f64 = (0..basis.len())
            .map(|j| {
                let single = Basis::new(vec![basis.functions()[j].clone()]).unwrap();
                let (min, max) = transform_range(&single, DepthInterval::UNIT, &AffineTransform::identity(1));
                -(max - min).log2()
            })
            .sum();
        assert!(optimum.gain_bits >= scaled - 1e-9, "{basis}: {} {scaled}", optimum.gain_bits);
        assert_eq!(identity.log2_determinant(), 0.0);
    }
}

#[test]
fn a_signed_interval_gains_the_same_in_units_of_unit_depths() {
    let basis = Basis::power(5);
    let search = Search { starts: Some(64), ..Search::default() };
    let unit = optimise(&basis, DepthInterval::UNIT, &search).unwrap();
    for interval in [DepthInterval::SIGNED, DepthInterval::new(-2.0, 0.5).unwrap()] {
        let other = optimise(&basis, interval, &search).unwrap();
        assert!((other.gain_bits - unit.gain_bits).abs() < 1e-9, "{interval}: {}", other.gain_bits);
        assert!((other.bound_bits - unit.bound_bits).abs() < 1e-9, "{interval}");
    }
    // Half of the entries vanish where rows are even or odd about 0.
    let search = Search { structure: Structure::Parity, ..search };
    let parity = optimise(&basis, DepthInterval::SIGNED, &search).unwrap();
    for i in 0..5 {
        let row = parity.transform.row(i);
        let (odd, even) = ([row[0], row[2], row[4]], [row[1], row[3]]);
        assert!(odd.iter().all(|&v| v == 0.0) || even.iter().all(|&v| v == 0.0), "{row:?}");
    }
}

#[test]
fn results_depend_on_the_seed_only_and_not_on_threads() {
    let basis = Basis::power(5);
    let search = Search { starts: Some(16), ..Search::default() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| optimise(&basis, DepthInterval::UNIT, &search).unwrap().transform)
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn bad_input_is_an_error_with_its_numbers() {
    let message = |basis: &str, search: &Search| {
        optimise(&basis.parse().unwrap(), DepthInterval::UNIT, search).unwrap_err().to_string()
    };
    let search = Search::default();
    assert!(message("z, 2-3z", &search).contains("`2-3z`"));
    assert!(message("z", &Search { starts: Some(0), ..search }).contains("0 starts"));
    assert!(message("z, exp(1z)", &Search { structure: Structure::Parity, ..search }).contains("exp(1z)"));
    assert_eq!(
        DepthInterval::new(0.25, 0.25).unwrap_err(),
        QuantizationError::Interval { start: 0.25, end: 0.25 }
    );
    assert!("power:0".parse::<Basis>().is_err() && "power:17".parse::<Basis>().is_err());
}

#[test]
fn the_highest_order_works() {
    let search = Search { starts: Some(1), ..Search::default() };
    let optimum = optimise(&Basis::power(16), DepthInterval::SIGNED, &search).unwrap();
    assert!(optimum.gain_bits > 240.0 && optimum.gain_bits < optimum.bound_bits, "{}", optimum.gain_bits);
    // Entries reach 1e5: rounding them moves the range by some 1e-11.
    assert!(optimum.range_min > -1e-9 && optimum.range_max < 1.0 + 1e-9);
}
