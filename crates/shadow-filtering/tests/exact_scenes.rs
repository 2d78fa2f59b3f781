//! Scenes whose shadows every technique, or every technique of four moments and more, must get right.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used, missing_docs)]

use proptest::prelude::*;
use shadow_filtering::*;

/// What double precision leaves of exactness, in shadow intensity.
const TOLERANCE: f64 = 1e-9;
const SIZE: usize = 15;

fn build(list: &[&str]) -> Vec<Technique> {
    let one = |text: &&str| toml::from_str::<TechniqueSpec>(text).unwrap().build().unwrap();
    list.iter().map(one).collect()
}

fn moment_techniques() -> Vec<Technique> {
    build(&[
        "bound = 'hamburger4'",
        "bound = 'hausdorff4'",
        "bound = 'trigonometric4'",
        "bound = 'hamburger6'",
        "bound = 'hamburger8'",
    ])
}

fn all_techniques() -> Vec<Technique> {
    let mut all = build(&[
        "bound = 'vsm'",
        "bound = 'esm'\nexponent = 80.0",
        "bound = 'evsm'\nexponent = 42.0",
        "bound = 'evsm'\nexponent = 42.0\nnegative_exponent = 42.0",
        "bound = 'lvsm'\nlayers = 4",
        "bound = 'csm'\ncoefficients = 16",
        "basis = 'z, z^2, exp(-4z), exp(4z)'",
    ]);
    all.extend(moment_techniques());
    all
}

/// G and F of a technique at the middle of a map.
fn compared(technique: &Technique, map: &DepthMap, z_f: f64) -> (f64, f64) {
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let filtered = filter(&encode::<f64>(map, technique).unwrap(), &kernel);
    let middle = SIZE / 2;
    let g = technique.shade(filtered.texel(middle, middle), z_f).unwrap();
    (g, kernel.percentage_closer(map, middle, middle, z_f))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(4), ..ProptestConfig::default() })]

    /// The receiver is the surface itself, or is moved towards the light by a bias.
    #[test]
    fn a_scene_of_constant_depth_has_no_error(depth in 0.0f32..=1.0, bias in 0.0f64..0.02) {
        let map = DepthMap::new(SIZE, SIZE, vec![depth; SIZE * SIZE]).unwrap();
        for technique in all_techniques() {
            for z_f in [f64::from(depth), (f64::from(depth) - bias).max(0.0)] {
                let (g, f) = compared(&technique, &map, z_f);
                prop_assert_eq!(f, 0.0);
                prop_assert!(g <= TOLERANCE, "{} at {z_f}: {g}", technique.name());
            }
        }
    }

    /// A wall before another. Depths closer than a twentieth of the range are beyond double precision: 1e-16 in a
    /// moment moves a weight by 1e-16 over the gap to the fourth power and the least weight, 2e-3.
    #[test]
    fn two_constant_depths_are_exact_from_four_moments_on(
        front in 0.02f32..0.9,
        gap in 0.05f32..0.9,
        bias in prop::sample::select(vec![0.0f64, 1e-4, 1e-3, 0.01]),
        pattern in prop::collection::vec(0.0f32..1.0, SIZE * SIZE),
        share in 0.05f32..0.95,
    ) {
        let back = (front + gap).min(0.98);
        prop_assume!(back - front >= 0.05);
        let depths = pattern.iter().map(|&p| if p < share { front } else { back }).collect();
        let map = DepthMap::new(SIZE, SIZE, depths).unwrap();
        for technique in moment_techniques() {
            for z_f in [front, back].map(|depth| f64::from(depth) - bias) {
                let (g, f) = compared(&technique, &map, z_f);
                prop_assert!((g - f).abs() <= TOLERANCE, "{} at {z_f}: {g} and {f}", technique.name());
            }
        }
    }
}
