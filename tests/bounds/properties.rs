//! Metamorphic relations (MSM15 section 4 and Problem 1) and agreement between independent routes.

use crate::samples::sample;
use moment_problem::hamburger::hamburger;
use moment_problem::hausdorff::hausdorff4;
use moment_problem::trigonometric::trigonometric4;
use moment_problem::{
    Basis, Chebyshev, DepthDistribution, ExchangeSimplex, Hamburger, Hausdorff4, LinearProgram, LowerBound,
    Trigonometric4,
};
use random_stream::Random;

const TOLERANCE: f64 = 2e-8;

fn exchange(basis: &str) -> ExchangeSimplex {
    ExchangeSimplex::new(&basis.parse().unwrap()).unwrap()
}

#[test]
fn hamburger_is_below_hausdorff_which_is_the_linear_program() {
    let (hamburger, hausdorff) = (Hamburger::<4>::default(), Hausdorff4::new().unwrap());
    let program = LinearProgram::new(&Basis::power(4)).unwrap();
    let mut random = Random::new(1);
    let mut refused = 0;
    for _ in 0..150 {
        let s = sample(&mut random);
        let line = hamburger.bounds_of(&s.z, s.z_f).unwrap();
        let unit = hausdorff.bounds_of(&s.z, s.z_f).unwrap_or_else(|e| panic!("{e} {s:?}"));
        // A narrow cluster next to z_f can be too much for both solvers; then there is an error and no number.
        let Ok(lp) = program.bounds_of(&s.z, s.z_f) else {
            refused += 1;
            continue;
        };
        assert!(line.lower <= unit.lower + TOLERANCE && line.upper >= unit.upper - TOLERANCE, "{s:?}");
        assert!(
            (unit.lower - lp.lower).abs() < TOLERANCE && (unit.upper - lp.upper).abs() < TOLERANCE,
            "{s:?}"
        );
        assert!(lp.lower <= s.z.cdf(s.z_f) + TOLERANCE, "{s:?}");
    }
    println!("linear program: {refused} of 150 refused");
    assert!(refused <= 5, "{refused} of 150 refused");
}

/// Hamburger bounds do not change under affine depth maps (MSM15 section 4); a mirror exchanges the two bounds.
#[test]
fn hamburger_bounds_are_affinely_invariant() {
    let mut random = Random::new(2);
    let solvers: [&dyn LowerBound; 4] = [
        &Chebyshev::default(),
        &Hamburger::<4>::default(),
        &Hamburger::<6>::default(),
        &Hamburger::<8>::default(),
    ];
    for _ in 0..300 {
        let s = sample(&mut random);
        // Powers of two and their sums map the sample's depths exactly, so that only the solver rounds.
        let (scale, shift) =
            ([0.25, 2.0, 8.0, -0.5, -4.0][random.below(5)], [0.0, -1.0, 0.5][random.below(3)]);
        let exact = |z: f64| (z * 1048576.0).round() / 1048576.0;
        let depths: Vec<f64> = s.z.depths().iter().map(|&z| exact(z)).collect();
        let weights: Vec<f64> = s.z.weights().iter().map(|w| w.to_f64()).collect();
        let z_f = exact(s.z_f);
        let plain = DepthDistribution::new(&depths, &weights).unwrap();
        let mapped: Vec<f64> = depths.iter().map(|z| z * scale + shift).collect();
        let mapped = DepthDistribution::new(&mapped, &weights).unwrap();
        for solver in solvers {
            let a = solver.bounds_of(&plain, z_f).unwrap();
            let b = solver.bounds_of(&mapped, z_f * scale + shift).unwrap();
            let (lower, upper) =
                if scale > 0.0 { (b.lower, b.upper) } else { (1.0 - b.upper, 1.0 - b.lower) };
            assert!(
                (a.lower - lower).abs() < 1e-6 && (a.upper - upper).abs() < 1e-6,
                "{} {a:?} {b:?}",
                solver.name()
            );
        }
    }
}

#[test]
fn bounds_are_monotone_in_the_fragment_depth() {
    let hausdorff = Hausdorff4::new().unwrap();
    let trigonometric = Trigonometric4::new().unwrap();
    let solvers: [&dyn LowerBound; 5] = [
        &Chebyshev::default(),
        &Hamburger::<6>::default(),
        &hausdorff,
        &trigonometric,
        &exchange("z,exp(-2z),ln(1+4z)"),
    ];
    let mut random = Random::new(3);
    for solver in solvers {
        for _ in 0..6 {
            let z = sample(&mut random).z;
            let (mut lower, mut upper) = (0.0, 0.0);
            for i in 0..=24 {
                let b = solver
                    .bounds_of(&z, f64::from(i) / 24.0)
                    .unwrap_or_else(|e| panic!("{} {i} {e} {z:?}", solver.name()));
                assert!(
                    b.lower >= lower - TOLERANCE && b.upper >= upper - TOLERANCE,
                    "{} at {i}: {z:?}",
                    solver.name()
                );
                (lower, upper) = (b.lower, b.upper);
            }
        }
    }
}

#[test]
fn the_bound_depends_on_the_span_only_and_more_functions_sharpen_it() {
    let pairs = [
        ("power:3", "z^3,z+z^2,z-2z^2"),
        ("sin(2pi z),cos(2pi z)", "sin(2pi z)+cos(2pi z),sin(2pi z)-cos(2pi z)"),
        ("exp(1z),exp(2z)", "exp(z)+1,exp(2z)-3exp(z)"),
    ];
    let nested = [("power:3", "power:4"), ("power:4", "power:4,"), ("z,exp(-2z)", "z,exp(-2z),cos(3pi z)")];
    let mut random = Random::new(4);
    for (a, b) in pairs {
        let (a, b) = (exchange(a), exchange(b));
        for _ in 0..30 {
            let s = sample(&mut random);
            let (x, y) = (a.bounds_of(&s.z, s.z_f).unwrap(), b.bounds_of(&s.z, s.z_f).unwrap());
            assert!((x.lower - y.lower).abs() < TOLERANCE && (x.upper - y.upper).abs() < TOLERANCE, "{s:?}");
        }
    }
    for (small, large) in nested {
        let large = large.strip_suffix(',').map_or(large.to_owned(), |_| "z,z^2,z^3,z^4,exp(4z)".to_owned());
        let (small, large) = (exchange(small), exchange(&large));
        for _ in 0..30 {
            let s = sample(&mut random);
            let (x, y) = (small.bounds_of(&s.z, s.z_f).unwrap(), large.bounds_of(&s.z, s.z_f).unwrap());
            assert!(y.lower >= x.lower - TOLERANCE && y.upper <= x.upper + TOLERANCE, "{s:?}");
        }
    }
}

/// MSM15 Proposition 4: m moments determine m / 2 depths.
#[test]
fn few_surfaces_are_reconstructed_exactly() {
    let hausdorff = Hausdorff4::new().unwrap();
    let trigonometric = Trigonometric4::new().unwrap();
    let power6 = exchange("power:6");
    let solvers: [(&dyn LowerBound, usize); 7] = [
        (&Chebyshev::default(), 1),
        (&Hamburger::<4>::default(), 2),
        (&Hamburger::<6>::default(), 3),
        (&Hamburger::<8>::default(), 4),
        (&hausdorff, 2),
        (&trigonometric, 2),
        (&power6, 3),
    ];
    let mut random = Random::new(5);
    for (solver, most) in solvers {
        for _ in 0..40 {
            let count = 1 + random.below(most);
            let depths: Vec<f64> =
                (0..count).map(|i| (i as f64 + 0.1 + 0.8 * random.unit()) / count as f64).collect();
            let raw: Vec<f64> = (0..count).map(|_| 0.1 + random.unit()).collect();
            let sum: f64 = raw.iter().sum();
            let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
            let z = DepthDistribution::new(&depths, &weights).unwrap();
            for z_f in [random.unit(), depths[0], *depths.last().unwrap(), 1.0] {
                let b = solver
                    .bounds_of(&z, z_f)
                    .unwrap_or_else(|e| panic!("{} {e} at {z_f}: {z:?}", solver.name()));
                let error = (b.lower - z.cdf(z_f)).abs().max((b.upper - z.cdf_inclusive(z_f)).abs());
                assert!(error < TOLERANCE, "{} {z:?} at {z_f}: {b:?}", solver.name());
            }
        }
    }
}

/// BHS16 section 2.4: the upper bound minus the lower bound is the weight at z_f.
#[test]
fn the_gap_between_the_bounds_is_the_weight_at_the_fragment() {
    let mut random = Random::new(6);
    for _ in 0..300 {
        let s = sample(&mut random);
        let b = Hamburger::<6>::default().bounds_of(&s.z, s.z_f).unwrap();
        let weight = b.support.iter().position(|&z| z == s.z_f).map_or(0.0, |i| b.weights[i]);
        assert!((b.upper - b.lower - weight).abs() < 1e-9, "{s:?} {b:?}");
    }
}

/// The plain f64 functions against the certified values, where the input is well-conditioned enough to compare.
#[test]
fn double_precision_closed_forms_agree_with_the_certified_bounds() {
    let (hausdorff, trigonometric) = (Hausdorff4::new().unwrap(), Trigonometric4::new().unwrap());
    let mut random = Random::new(8);
    let mut worst = [0.0f64; 6];
    for _ in 0..2000 {
        // More separated surfaces than the moments determine: conditioned as well as the orders allow.
        let count = 5 + random.below(4);
        let depths: Vec<f64> =
            (0..count).map(|i| (i as f64 + 0.2 + 0.6 * random.unit()) / count as f64).collect();
        let weights = vec![1.0 / count as f64; count];
        let z = DepthDistribution::new(&depths, &weights).unwrap();
        let z_f = random.unit();
        let b: [f64; 8] = z.moments::<f64>(&Basis::power(8)).try_into().unwrap();
        let t: [f64; 4] = z.moments::<f64>(&Basis::trigonometric(2)).try_into().unwrap();
        let exact = |solver: &dyn LowerBound| {
            let b = solver.bounds_of(&z, z_f).unwrap();
            (b.lower, b.upper)
        };
        let b4: [f64; 4] = std::array::from_fn(|i| b[i]);
        let pairs = [
            (hamburger(&[b[0], b[1]], z_f), exact(&Chebyshev::default())),
            (hamburger(&b4, z_f), exact(&Hamburger::<4>::default())),
            (hamburger::<f64, 6>(&std::array::from_fn(|i| b[i]), z_f), exact(&Hamburger::<6>::default())),
            (hamburger(&b, z_f), exact(&Hamburger::<8>::default())),
            (hausdorff4(&b4, z_f), exact(&hausdorff)),
            (trigonometric4(&t, z_f), exact(&trigonometric)),
        ];
        for ((found, (lower, upper)), worst) in pairs.iter().zip(&mut worst) {
            let error = (found.lower - lower).abs().max((found.upper - upper).abs());
            if error > 1e-3 {
                println!("{z:?} {z_f} {found:?} {lower} {upper}");
            }
            *worst = worst.max(error);
        }
    }
    println!("largest f64 error of Hamburger 2, 4, 6, 8, Hausdorff 4, trigonometric 4: {worst:?}");
    for (worst, limit) in worst.iter().zip([1e-12, 1e-6, 1e-3, 2e-2, 1e-6, 1e-6]) {
        assert!(worst <= &limit, "{worst} above {limit}");
    }
}
