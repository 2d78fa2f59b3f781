//! Every technique against the conformance suite, and direct computations for each.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

mod conformance;

use moment_problem::arithmetic::Real;
use moment_problem::{Basis, DepthDistribution, Interval, MomentBound, closed_form};
use shadow_filtering::*;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

fn maps() -> Vec<DepthMap> {
    conformance::maps().unwrap()
}

fn technique(toml: &str) -> Technique {
    toml::from_str::<TechniqueSpec>(toml).unwrap().build().unwrap()
}

fn moments(bound: MomentBound) -> Technique {
    TechniqueSpec::from(bound).build().unwrap()
}

#[test]
fn every_technique_does_what_techniques_do() {
    let mut compared = 0;
    for toml in [
        "bound = 'vsm'",
        "bound = 'esm'\nexponent = 80.0",
        "bound = 'evsm'\nexponent = 42.0",
        "bound = 'evsm'\nexponent = 42.0\nnegative_exponent = 42.0",
        "bound = 'evsm'\nexponent = 5.54\nnegative_exponent = 5.54\nformat = 'f16'",
        "bound = 'lvsm'\nlayers = 4",
        "bound = 'csm'\ncoefficients = 4",
        "bound = 'csm'\ncoefficients = 16",
        "bound = 'hamburger4'",
        "bound = 'hamburger6'",
        "bound = 'hamburger8'",
        "bound = 'hausdorff4'",
        "bound = 'trigonometric4'",
    ] {
        let technique = technique(toml);
        assert!(technique.is_lower_bound(), "{toml}");
        compared += conformance::check(&technique).unwrap();
    }
    assert!(compared > 50_000, "{compared}");
    // Not in the usual variable, and no bound.
    conformance::check(&technique("bound = 'hamburger4'\nrange = 'unit'\nalpha = 1e-6")).unwrap();
    conformance::check(&technique("bound = 'hamburger4'\nbeta = 0.5")).unwrap();
}

#[test]
fn the_suite_finds_a_bound_that_is_none() {
    /// Markov's inequality with the wrong sign of a squared deviation.
    struct Optimist;
    impl ShadowBound for Optimist {
        fn name(&self) -> String {
            "optimist".to_owned()
        }
        fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
            (z_f - b[0] + R::from_f64(0.5)).clamp_unit()
        }
    }
    let encoding = || {
        quantization::Encoding::new(
            quantization::AffineTransform::identity(2),
            quantization::NumberFormat::F32,
        )
    };
    let basis = || Box::new("power:2".parse::<Basis>().unwrap());
    let wrong = Technique::new(basis(), encoding(), Box::new(Optimist)).unwrap();
    let message = conformance::check(&wrong).unwrap_err();
    assert!(message.contains("optimist") && message.contains('>'), "{message}");
}

/// The certified method for a basis, from the exact distribution.
fn exact(basis: &str, interval: Interval, z: &DepthDistribution, z_f: f64) -> f64 {
    let basis: Basis = basis.parse().unwrap();
    closed_form(&basis, interval).unwrap().unwrap().bounds_of(z, z_f).unwrap().lower
}

#[test]
fn each_technique_agrees_with_the_moment_problem_of_its_kernel() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let mut random = Random(5);
    let cases = [
        (technique("bound = 'vsm'"), "power:2", Interval::Real),
        (technique("bound = 'esm'\nexponent = 20.0"), "exp(20z)", Interval::Real),
        (moments(MomentBound::Hamburger4), "power:4", Interval::Real),
        (moments(MomentBound::Hamburger6), "power:6", Interval::Real),
        (moments(MomentBound::Hausdorff4), "power:4", Interval::Unit),
        (moments(MomentBound::Trigonometric4), "trig:2", Interval::Unit),
    ];
    for map in [&maps()[4], &maps()[7]] {
        for (technique, basis, interval) in &cases {
            let filtered = filter(&encode::<f64>(map, technique).unwrap(), &kernel);
            for _ in 0..60 {
                let (x, y) = ((random.unit() * 48.0) as usize, (random.unit() * 48.0) as usize);
                let z_f = random.unit();
                let g = technique.shade(filtered.texel(x, y), z_f).unwrap();
                let sharp = exact(basis, *interval, &kernel.distribution(map, x, y), z_f);
                assert!((g - sharp).abs() < 1e-6, "{basis} at ({x}, {y}), {z_f}: {g} and {sharp}");
            }
        }
    }
}

#[test]
fn closed_forms_agree_with_the_linear_program_on_the_same_moments() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let mut random = Random(9);
    let bounds = [(MomentBound::Hausdorff4, "power:4"), (MomentBound::Trigonometric4, "trig:2")];
    for (bound, basis) in bounds {
        let (closed, program) = (moments(bound), technique(&format!("basis = '{basis}'")));
        let biased = TechniqueSpec::from(bound).biased_moments().unwrap().unwrap();
        for map in maps() {
            let filtered = filter(&encode::<f64>(&map, &closed).unwrap(), &kernel);
            for _ in 0..15 {
                let (x, y) = ((random.unit() * 48.0) as usize, (random.unit() * 48.0) as usize);
                let z_f = random.unit();
                let g = closed.bounds(filtered.texel(x, y), z_f).unwrap().lower;
                let solved = program.shade(&biased.biased(filtered.texel(x, y)), z_f).unwrap();
                assert!((g - solved).abs() < 1e-6, "{basis} at ({x}, {y}), {z_f}: {g} and {solved}");
            }
        }
    }
}

#[test]
fn exponential_variance_and_layers_are_cantelli_in_their_warps() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let map = &maps()[4];
    let evsm = technique("bound = 'evsm'\nexponent = 10.0\nnegative_exponent = 5.0");
    let lvsm = technique("bound = 'lvsm'\nlayers = 4");
    let mut random = Random(6);
    for _ in 0..200 {
        let (x, y) = ((random.unit() * 48.0) as usize, (random.unit() * 48.0) as usize);
        let z_f = random.unit();
        let z = kernel.distribution(map, x, y);
        let warped = |warp: &dyn Fn(f64) -> f64| {
            let weights: Vec<f64> = z.weights().iter().map(|&w| w.to_f64()).collect();
            let depths: Vec<f64> = z.depths().iter().map(|&depth| warp(depth)).collect();
            let mean: f64 = depths.iter().zip(&weights).map(|(z, w)| z * w).sum();
            let variance: f64 = depths.iter().zip(&weights).map(|(z, w)| w * (z - mean).powi(2)).sum();
            let offset = warp(z_f) - mean;
            if offset <= 0.0 { 0.0 } else { offset * offset / (variance + offset * offset) }
        };
        let shade = |technique: &Technique| {
            let filtered = filter(&encode::<f64>(map, technique).unwrap(), &kernel);
            technique.shade(filtered.texel(x, y), z_f).unwrap()
        };
        let both =
            warped(&|z| (10.0 * (2.0 * z - 1.0)).exp()).max(warped(&|z| -(-5.0 * (2.0 * z - 1.0)).exp()));
        assert!((shade(&evsm) - both).abs() < 1e-6);
        let layer = ((4.0 * z_f) as usize).min(3) as f64;
        let layered = warped(&|z| (4.0 * z - layer).clamp(0.0, 1.0));
        assert!((shade(&lvsm) - layered).abs() < 1e-6, "{z_f}");
    }
}

#[test]
fn two_surfaces_are_reconstructed_by_four_moments_and_three_by_six() {
    let share = |depths: &[f64], bound: MomentBound, z_f: f64| {
        let technique = moments(bound);
        let mut sums = vec![0.0; technique.channels()];
        let mut vector = sums.clone();
        for &depth in depths {
            technique.evaluate(depth, &mut vector);
            sums.iter_mut().zip(&vector).for_each(|(sum, v)| *sum += v / depths.len() as f64);
        }
        technique.bounds(&sums, z_f).unwrap()
    };
    for bound in [MomentBound::Hamburger4, MomentBound::Hausdorff4, MomentBound::Trigonometric4] {
        let pair = share(&[0.3, 0.3, 0.3, 0.8], bound, 0.8);
        assert!((pair.lower - 0.75).abs() < 1e-3 && pair.upper > 0.999, "{bound:?}: {pair:?}");
    }
    let pair = share(&[0.2, 0.5, 0.9], MomentBound::Hamburger6, 0.7);
    assert!((pair.lower - 2.0 / 3.0).abs() < 1e-3 && (pair.upper - 2.0 / 3.0).abs() < 1e-3);
}

#[test]
fn beta_blends_the_bounds() {
    let build = |beta: f64| technique(&format!("bound = 'hamburger4'\nbeta = {beta:?}"));
    let filtered = [0.1, 0.4, 0.05, 0.3];
    let bounds = build(0.0).bounds(&filtered, 0.6).unwrap();
    for beta in [0.0, 0.5, 1.0] {
        let expected = bounds.lower + beta * (bounds.upper - bounds.lower);
        assert_eq!(build(beta).shade(&filtered, 0.6).unwrap(), expected);
    }
    assert!(build(0.0).is_lower_bound() && !build(0.5).is_lower_bound());
}

#[test]
fn impossible_parameters_are_errors_that_name_key_and_value() {
    let error = |text: &str| {
        let spec: Result<TechniqueSpec, _> = toml::from_str(text);
        match spec {
            Err(error) => error.to_string(),
            Ok(spec) => spec.build().map(|technique| technique.name()).unwrap_err().to_string(),
        }
    };
    for (text, needles) in [
        ("bound = 'magic'", ["magic", "vsm"]),
        ("kind = 'vsm'", ["kind = vsm", "bound"]),
        ("alpha = 0.1", ["bound", "missing"]),
        ("bound = 'esm'\nexponent = 100.0", ["exponent = 100", "f32"]),
        ("bound = 'esm'\nexponent = -1.0", ["exponent = -1", "positive"]),
        ("bound = 'esm'\nexponent = 2.0\nformat = 'unorm16'", ["format = unorm16", "exponential warps"]),
        ("bound = 'evsm'\nexponent = 43.0", ["exponent = 43", "42"]),
        (
            "bound = 'evsm'\nexponent = 5.0\nnegative_exponent = 6.0\nformat = 'f16'",
            ["negative_exponent = 6", "f16"],
        ),
        ("bound = 'vsm'\nexponent = 5.0", ["exponent = 5", "`vsm` has no exponent"]),
        ("bound = 'lvsm'\nlayers = 0", ["layers = 0", "1 to 64"]),
        ("bound = 'csm'\ncoefficients = 0", ["coefficients = 0", "64"]),
        ("bound = 'hamburger4'\nalpha = 1.5", ["alpha = 1.5", "[0, 1]"]),
        ("bound = 'hamburger4'\ncentre = [0.5]", ["centre = [0.5]", "4 numbers"]),
        ("bound = 'hamburger4'\ntransform = 'magic'", ["transform = magic", "plain"]),
        ("bound = 'hausdorff4'\nrange = 'signed'", ["range = signed", "0 to 1"]),
        ("bound = 'hausdorff4'\nbeta = nan", ["beta = NaN", "[0, 1]"]),
        ("bound = 'hausdorff4'\ngamma = 1", ["gamma", "unknown"]),
        ("basis = 'sinh(z)'", ["sinh", ""]),
    ] {
        let message = error(text);
        assert!(needles.iter().all(|needle| message.contains(needle)), "{text}: {message}");
    }
}
