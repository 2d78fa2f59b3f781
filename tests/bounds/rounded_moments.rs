//! Moments that arrive as `f64`: rounded, perturbed, impossible or nonsense.

use crate::samples::sample;
use moment_problem::hamburger::{chebyshev, hamburger};
use moment_problem::hausdorff::hausdorff4;
use moment_problem::markov::two_depths;
use moment_problem::trigonometric::trigonometric4;
use moment_problem::{
    Basis, ExchangeSimplex, Hamburger, Hausdorff4, LinearProgram, LowerBound, MomentError, Trigonometric4,
};
use random_stream::Random;

/// Rounding the moments moves the bound by their sensitivity; up to 1e7 of it is tolerated, the rest is skipped.
#[test]
fn bounds_from_rounded_moments_agree_with_those_of_the_distribution() {
    let (hausdorff, trigonometric) = (Hausdorff4::new().unwrap(), Trigonometric4::new().unwrap());
    let exchange = ExchangeSimplex::new(&"z,exp(-2z),cos(3pi z)".parse().unwrap()).unwrap();
    let program = LinearProgram::new(&Basis::power(3)).unwrap();
    let solvers: [(&dyn LowerBound, usize); 6] = [
        (&Hamburger::<4>::default(), 400),
        (&Hamburger::<6>::default(), 400),
        (&hausdorff, 100),
        (&trigonometric, 60),
        (&exchange, 60),
        (&program, 40),
    ];
    for (solver, count) in solvers {
        let mut random = Random::new(11);
        let (mut compared, mut refused) = (0, 0);
        for _ in 0..count {
            let s = sample(&mut random);
            // The bound jumps where z_f meets a surface that the moments determine.
            if s.z.depths().iter().any(|z| (z - s.z_f).abs() < 1e-4) {
                continue;
            }
            let Ok(exact) = solver.bounds_of(&s.z, s.z_f) else { continue };
            let moments: Vec<f64> = s.z.moments(solver.basis());
            match solver.bounds(&moments, s.z_f) {
                Ok(b) => {
                    assert!(b.certificate.lower_proved <= b.lower + 1e-12, "{}: {b:?}", solver.name());
                    assert!(b.certificate.upper_proved >= b.upper - 1e-12, "{}: {b:?}", solver.name());
                    let size = |dual: &[f64]| dual.iter().map(|y| y.abs()).sum::<f64>();
                    if size(&exact.certificate.lower_dual).max(size(&b.certificate.lower_dual)) < 1e7 {
                        compared += 1;
                        assert!(
                            (b.lower - exact.lower).abs() < 1e-6,
                            "{} {s:?}: {b:?} {exact:?}",
                            solver.name()
                        );
                    }
                }
                // Few surfaces lie on the boundary of the set of moments; rounding may put them just outside.
                Err(MomentError::Infeasible { .. } | MomentError::NotPositiveDefinite { .. }) => refused += 1,
                Err(MomentError::Uncertified { .. } | MomentError::Solver { .. }) => refused += 1,
                Err(error) => panic!("{}: {error}", solver.name()),
            }
        }
        println!("{}: {compared} compared, {refused} of {count} refused", solver.name());
        assert!(compared * 4 > count, "{}: only {compared} compared", solver.name());
        assert!(refused * 10 <= count, "{}: {refused} of {count} refused", solver.name());
    }
}

#[test]
fn impossible_moments_are_refused() {
    let hausdorff = Hausdorff4::new().unwrap();
    let trigonometric = Trigonometric4::new().unwrap();
    let exchange = ExchangeSimplex::new(&Basis::power(2)).unwrap();
    let program = LinearProgram::new(&Basis::power(2)).unwrap();
    let cases: [(&dyn LowerBound, &[f64]); 7] = [
        (&Hamburger::<2>::default(), &[0.5, 0.2]),
        (&Hamburger::<4>::default(), &[0.5, 0.3, 0.2, 0.1]),
        (&Hamburger::<6>::default(), &[0.0, 1.0, 0.0, 0.9, 0.0, 1.0]),
        (&hausdorff, &[0.5, 0.6, 0.5, 0.5]),
        (&trigonometric, &[0.9, 0.9, 0.0, 0.0]),
        (&exchange, &[1.5, 2.25]),
        (&program, &[0.5, 0.2]),
    ];
    for (solver, moments) in cases {
        let error = solver.bounds(moments, 0.7).unwrap_err();
        assert!(
            matches!(error, MomentError::Infeasible { .. } | MomentError::NotPositiveDefinite { .. }),
            "{}: {error:?}",
            solver.name()
        );
    }
}

#[test]
fn useless_input_is_a_typed_error() {
    let solver = Hausdorff4::new().unwrap();
    let valid = [0.5, 0.3, 0.2, 0.15];
    assert_eq!(solver.bounds(&valid[..3], 0.5), Err(MomentError::Length { expected: 4, got: 3 }));
    for nonsense in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = solver.bounds(&[0.5, nonsense, 0.2, 0.15], 0.5).unwrap_err();
        assert!(error.to_string().contains("z^2"), "{error}");
        assert!(matches!(solver.bounds(&valid, nonsense), Err(MomentError::NotFinite { .. })));
    }
    assert!(matches!(solver.bounds(&valid, 1.5), Err(MomentError::OutsideInterval { .. })));
}

/// No NaN, nothing outside [0, 1] and no panic, whatever the bits: a million and a half inputs.
#[test]
fn nonsense_never_leaves_the_unit_interval() {
    let mut random = Random::new(12);
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MIN_POSITIVE,
        1e-300,
        1e300,
        5e-324,
    ];
    let draw = |random: &mut Random| match random.below(4) {
        0 => special[random.below(special.len())],
        1 => f64::from_bits(random.next_bits()),
        2 => 1.0 + f64::EPSILON * (random.unit() - 0.5),
        _ => random.unit(),
    };
    fn check(name: &str, lower: f64, upper: f64, input: &[f64]) {
        let valid = 0.0..=1.0;
        assert!(
            valid.contains(&lower) && valid.contains(&upper) && lower <= upper,
            "{name}: {lower}, {upper} from {input:?}"
        );
    }
    for _ in 0..150_000 {
        let b: [f64; 9] = std::array::from_fn(|_| draw(&mut random));
        let z = b[8];
        let four: [f64; 4] = std::array::from_fn(|i| b[i]);
        let eight: [f64; 8] = std::array::from_fn(|i| b[i]);
        let pairs = [
            ("Chebyshev", chebyshev(&[b[0], b[1]], z)),
            ("Hamburger 4", hamburger(&four, z)),
            ("Hamburger 6", hamburger::<f64, 6>(&std::array::from_fn(|i| b[i]), z)),
            ("Hamburger 8", hamburger(&eight, z)),
            ("Hausdorff 4", hausdorff4(&four, z)),
            ("trigonometric 4", trigonometric4(&four, z)),
        ];
        for (name, pair) in pairs {
            check(name, pair.lower, pair.upper, &b);
        }
        let single: [f32; 8] = eight.map(|b| b as f32);
        let z = z as f32;
        let pairs = [
            ("f32 Hamburger 4", hamburger(&std::array::from_fn::<f32, 4, _>(|i| single[i]), z)),
            ("f32 Hamburger 6", hamburger(&std::array::from_fn::<f32, 6, _>(|i| single[i]), z)),
            ("f32 Hamburger 8", hamburger(&single, z)),
            ("f32 Hausdorff 4", hausdorff4(&std::array::from_fn(|i| single[i]), z)),
            ("f32 trigonometric 4", trigonometric4(&std::array::from_fn(|i| single[i]), z)),
        ];
        for (name, pair) in pairs {
            check(name, f64::from(pair.lower), f64::from(pair.upper), &b);
        }
        let weights = two_depths(&[b[0], b[1], b[2]]).map(|(_, w)| w);
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)), "two depths: {weights:?} from {b:?}");
    }
}
