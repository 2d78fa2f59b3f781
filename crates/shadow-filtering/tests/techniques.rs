//! One conformance suite that every technique runs, and direct computations for each.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use moment_problem::{Basis, DepthDistribution, Interval, closed_form};
use shadow_filtering::techniques::*;
use shadow_filtering::*;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

const SIZE: usize = 48;

/// Kernels of every kind: flat, last-bit noise, tilted, two surfaces, leaves over ground, far plane, noise.
fn maps() -> Vec<DepthMap> {
    let mut random = Random(3);
    let mut maps = Vec::new();
    for kind in 0..8 {
        let noise: Vec<f64> = (0..SIZE * SIZE).map(|_| random.unit()).collect();
        let depth = |t: usize| {
            let (x, y) = ((t % SIZE) as f64 / SIZE as f64, (t / SIZE) as f64 / SIZE as f64);
            match kind {
                0 => 0.6,
                1 => 0.6 + (noise[t] * 3.0).floor() / f64::from(1 << 24),
                2 => 0.2 + 0.5 * x + 0.1 * y,
                3 => {
                    if x + 0.3 * y < 0.6 {
                        0.25
                    } else {
                        0.65
                    }
                }
                4 => {
                    if noise[t] < 0.4 {
                        0.3 + 0.2 * noise[t]
                    } else {
                        0.8 + 0.1 * x
                    }
                }
                5 => {
                    if x < 0.4 {
                        0.1
                    } else if y < 0.5 {
                        1.0
                    } else {
                        0.0
                    }
                }
                6 => 0.5 + 1e-5 * (x + noise[t]),
                _ => noise[t],
            }
        };
        let depths = (0..SIZE * SIZE).map(|t| depth(t) as f32).collect();
        maps.push(DepthMap::new(SIZE, SIZE, depths).unwrap());
    }
    maps
}

fn moments(bound: MomentBound) -> Moments {
    Moments::new(bound, MomentOptions::default()).unwrap()
}

fn techniques() -> Vec<Box<dyn Technique>> {
    let toml = r#"
        technique = [
            { kind = "vsm" },
            { kind = "esm", exponent = 80.0 },
            { kind = "evsm", positive = 42.0 },
            { kind = "evsm", positive = 42.0, negative = 42.0 },
            { kind = "evsm", positive = 5.54, negative = 5.54, format = "f16" },
            { kind = "lvsm", layers = 4 },
            { kind = "csm", coefficients = 4 },
            { kind = "csm", coefficients = 16 },
            { kind = "hamburger4" },
            { kind = "hamburger6" },
            { kind = "hamburger8" },
            { kind = "hausdorff4" },
            { kind = "trigonometric4" },
        ]"#;
    #[derive(serde::Deserialize)]
    struct List {
        technique: Vec<TechniqueSpec>,
    }
    let list: List = toml::from_str(toml).unwrap();
    list.technique.iter().map(|spec| spec.build().unwrap()).collect()
}

/// Receivers of a map: each texel's own depth and others.
fn receivers(map: &DepthMap) -> Vec<(usize, usize, f64)> {
    let mut random = Random(11);
    let mut receivers = Vec::new();
    for (y, x) in (0..SIZE).step_by(5).flat_map(|y| (0..SIZE).step_by(5).map(move |x| (y, x))) {
        let own = f64::from(map.at(x as isize, y as isize));
        let other = f64::from(map.at((x + 3) as isize, (y + 2) as isize));
        let at = |z: f64| (x, y, z.clamp(0.0, 1.0));
        receivers.extend([own, other, own + 1e-7, own + 0.01, random.unit(), 0.0, 1.0].map(at));
    }
    receivers
}

#[test]
fn bounds_never_exceed_plain_percentage_closer_filtering() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let mut checked = 0;
    for technique in techniques() {
        assert!(technique.is_lower_bound());
        for (number, map) in maps().iter().enumerate() {
            let filtered = filter(&encode::<f64>(map, technique.as_ref()).unwrap(), &kernel);
            for (x, y, z_f) in receivers(map) {
                let g = technique.shade(filtered.texel(x, y), z_f).unwrap();
                let f = kernel.percentage_closer(map, x, y, z_f);
                let name = technique.name();
                assert!((0.0..=1.0).contains(&g), "{name}: {g}");
                assert!(g <= f + 1e-6, "{name}, map {number} at ({x}, {y}), z_f {z_f}: {g} > {f}");
                checked += 1;
            }
        }
    }
    assert!(checked > 50_000, "{checked}");
}

#[test]
fn the_filtered_map_holds_the_moments_of_the_kernel() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    for technique in techniques() {
        for map in maps() {
            let filtered = filter(&encode::<f64>(&map, technique.as_ref()).unwrap(), &kernel);
            let z = kernel.distribution(&map, 17, 22);
            let mut sums = vec![0.0; technique.channels()];
            let mut vector = sums.clone();
            for (&depth, &weight) in z.depths().iter().zip(z.weights()) {
                technique.encode(depth, &mut vector);
                let weight = moment_problem::arithmetic::Real::to_f64(weight);
                sums.iter_mut().zip(&vector).for_each(|(sum, v)| *sum += weight * v);
            }
            for (sum, value) in sums.iter().zip(filtered.texel(17, 22)) {
                assert!((sum - value).abs() <= 1e-13 * (1.0 + sum.abs()), "{}", technique.name());
            }
        }
    }
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
    let esm = Exponential::new(20.0, StorageFormat::F32).unwrap();
    let cases: [(&dyn Technique, &str, Interval); 6] = [
        (&Variance, "power:2", Interval::Real),
        (&esm, "exp(20z)", Interval::Real),
        (&moments(MomentBound::Hamburger4), "power:4", Interval::Real),
        (&moments(MomentBound::Hamburger6), "power:6", Interval::Real),
        (&moments(MomentBound::Hausdorff4), "power:4", Interval::Unit),
        (&moments(MomentBound::Trigonometric4), "trig:2", Interval::Unit),
    ];
    for map in [&maps()[4], &maps()[7]] {
        for (technique, basis, interval) in cases {
            let filtered = filter(&encode::<f64>(map, technique).unwrap(), &kernel);
            for _ in 0..60 {
                let (x, y) = ((random.unit() * 48.0) as usize, (random.unit() * 48.0) as usize);
                let z_f = random.unit();
                let g = technique.shade(filtered.texel(x, y), z_f).unwrap();
                let sharp = exact(basis, interval, &kernel.distribution(map, x, y), z_f);
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
        let (technique, program) = (moments(bound), Certified::new(basis).unwrap());
        for map in maps() {
            let filtered = filter(&encode::<f64>(&map, &technique).unwrap(), &kernel);
            for _ in 0..15 {
                let (x, y) = ((random.unit() * 48.0) as usize, (random.unit() * 48.0) as usize);
                let z_f = random.unit();
                let g = technique.bounds(filtered.texel(x, y), z_f).lower;
                let solved = program.shade(&technique.biased(filtered.texel(x, y)), z_f).unwrap();
                assert!((g - solved).abs() < 1e-6, "{basis} at ({x}, {y}), {z_f}: {g} and {solved}");
            }
        }
    }
}

#[test]
fn exponential_variance_and_layers_are_cantelli_in_their_warps() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let map = &maps()[4];
    let evsm = ExponentialVariance::new(10.0, Some(5.0), StorageFormat::F32).unwrap();
    let lvsm = LayeredVariance::new(4).unwrap();
    let mut random = Random(6);
    for _ in 0..200 {
        let (x, y) = ((random.unit() * 48.0) as usize, (random.unit() * 48.0) as usize);
        let z_f = random.unit();
        let z = kernel.distribution(map, x, y);
        let warped = |warp: &dyn Fn(f64) -> f64| {
            let weights: Vec<f64> =
                z.weights().iter().map(|&w| moment_problem::arithmetic::Real::to_f64(w)).collect();
            let depths: Vec<f64> = z.depths().iter().map(|&depth| warp(depth)).collect();
            let mean: f64 = depths.iter().zip(&weights).map(|(z, w)| z * w).sum();
            let variance: f64 = depths.iter().zip(&weights).map(|(z, w)| w * (z - mean).powi(2)).sum();
            let offset = warp(z_f) - mean;
            if offset <= 0.0 { 0.0 } else { offset * offset / (variance + offset * offset) }
        };
        let shade = |technique: &dyn Technique| {
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
fn convolution_shadow_maps_are_the_filtered_response_and_tend_to_the_shadow_test() {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let map = &maps()[4];
    for coefficients in [1, 4, 16] {
        let csm = Convolution::new(coefficients).unwrap();
        let filtered = filter(&encode::<f64>(map, &csm).unwrap(), &kernel);
        let z = kernel.distribution(map, 20, 30);
        for i in 0..=50 {
            let z_f = f64::from(i) / 50.0;
            let atoms = z.depths().iter().zip(z.weights());
            let expected: f64 = atoms
                .map(|(&depth, &w)| moment_problem::arithmetic::Real::to_f64(w) * csm.response(z_f - depth))
                .sum();
            let g = csm.shade(filtered.texel(20, 30), z_f).unwrap();
            assert!((g - expected.clamp(0.0, 1.0)).abs() < 1e-12, "{g} and {expected}");
        }
        // Below the test everywhere, between the nodes of the search too.
        for i in -50_000..=50_000 {
            let t = f64::from(i) / 50_000.0;
            assert!(csm.response(t) <= if t > 0.0 { 1.0 } else { 0.0 }, "{coefficients} at {t}");
        }
    }
    let fine = Convolution::new(64).unwrap();
    for i in 1..20 {
        let t = f64::from(i) / 20.0;
        assert!(fine.response(t) > 0.98, "{t}: {}", fine.response(t));
        assert!(fine.response(-t).abs() < 0.02, "-{t}: {}", fine.response(-t));
    }
}

#[test]
fn two_surfaces_are_reconstructed_by_four_moments_and_three_by_six() {
    let share = |depths: &[f64], bound: MomentBound, z_f: f64| {
        let technique = moments(bound);
        let mut sums = vec![0.0; technique.channels()];
        let mut vector = sums.clone();
        for &depth in depths {
            technique.encode(depth, &mut vector);
            sums.iter_mut().zip(&vector).for_each(|(sum, v)| *sum += v / depths.len() as f64);
        }
        technique.bounds(&sums, z_f)
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
    let options = |beta| MomentOptions { alpha: None, beta };
    let build = |beta| Moments::new(MomentBound::Hamburger4, options(beta)).unwrap();
    let filtered = [0.1, 0.4, 0.05, 0.3];
    let bounds = build(0.0).bounds(&filtered, 0.6);
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
        ("kind = 'magic'", ["magic", "vsm"]),
        ("kind = 'esm'\nexponent = 100.0", ["exponent = 100", "f32"]),
        ("kind = 'esm'\nexponent = -1.0", ["exponent = -1", "positive"]),
        ("kind = 'evsm'\npositive = 43.0", ["positive = 43", "42"]),
        ("kind = 'evsm'\npositive = 5.0\nnegative = 6.0\nformat = 'f16'", ["negative = 6", "f16"]),
        ("kind = 'lvsm'\nlayers = 0", ["layers = 0", "1 to 64"]),
        ("kind = 'csm'\ncoefficients = 0", ["coefficients = 0", "64"]),
        ("kind = 'hamburger4'\nalpha = 1.5", ["alpha = 1.5", "[0, 1]"]),
        ("kind = 'hausdorff4'\nbeta = nan", ["beta = NaN", "[0, 1]"]),
        ("kind = 'hausdorff4'\ngamma = 1", ["gamma", "unknown"]),
        ("kind = 'certified'\nbasis = 'sinh(z)'", ["sinh", ""]),
    ] {
        let message = error(text);
        assert!(needles.iter().all(|needle| message.contains(needle)), "{text}: {message}");
    }
}

#[test]
fn depths_outside_are_clamped_and_never_warped_to_infinity() {
    for technique in techniques() {
        let mut near = vec![0.0; technique.channels()];
        let mut far = near.clone();
        for (outside, inside) in [(-7.0, 0.0), (1e300, 1.0), (f64::INFINITY, 1.0), (f64::NAN, 1.0)] {
            technique.encode(outside, &mut near);
            technique.encode(inside, &mut far);
            assert_eq!(near, far);
            assert!(near.iter().all(|value| value.is_finite()));
            let g = technique.shade(&near, outside).unwrap();
            assert_eq!(g, technique.shade(&near, inside).unwrap());
        }
    }
}
