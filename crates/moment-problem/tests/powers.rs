//! Power moments on [0, 1] in exact arithmetic: orders that double-double does not resolve, and fragments next to a surface.

#![allow(clippy::unwrap_used)]

use moment_problem::{
    Basis, Bounds, DepthDistribution, ExchangeSimplex, Hausdorff4, LowerBound, MomentError, Trigonometric4,
};

/// Answers whose attained and proved values differ by more than this are errors.
const CERTIFIED_GAP: f64 = 1e-8;

fn bounds(basis: &str, atoms: &[(f64, f64)], z_f: f64) -> Result<Bounds, MomentError> {
    let (depths, weights): (Vec<f64>, Vec<f64>) = atoms.iter().copied().unzip();
    let basis: Basis = basis.parse().unwrap();
    let z = DepthDistribution::new(&depths, &weights).unwrap();
    ExchangeSimplex::new(&basis).unwrap().bounds_of(&z, z_f)
}

#[test]
fn few_depths_are_determined_by_many_moments() {
    let atoms = [(0.2, 0.5), (0.45, 0.2), (0.7, 0.3)];
    for order in 6..=16 {
        let found = bounds(&format!("power:{order}"), &atoms, 0.6).unwrap();
        assert!((found.lower - 0.7).abs() < 1e-15 && (found.upper - 0.7).abs() < 1e-15, "{order}: {found:?}");
        assert!(found.gap() < 1e-15, "{order}: {found:?}");
        let at = bounds(&format!("power:{order}"), &[(0.0, 0.3), (0.3, 0.3), (1.0, 0.4)], 0.3).unwrap();
        assert!((at.lower - 0.3).abs() < 1e-15 && (at.upper - 0.6).abs() < 1e-15, "{order}: {at:?}");
    }
}

/// z_f one unit in the last place behind the only surface.
#[test]
fn a_surface_in_front_by_the_last_place_shadows_or_is_refused() {
    let (surface, z_f) = ([(0.5, 1.0)], 0.5000000000000001);
    let found = bounds("power:4", &surface, z_f).unwrap();
    assert!(found.lower == 1.0 && found.gap() <= CERTIFIED_GAP, "{found:?}");
    let z = DepthDistribution::new(&[0.5], &[1.0]).unwrap();
    assert_eq!(Hausdorff4::new().unwrap().bounds_of(&z, z_f).unwrap().lower, 1.0);
    // No exact arithmetic for these: nothing wrong is certified.
    for basis in ["trig:2", "z,exp(-2z),exp(2z),z^2"] {
        match bounds(basis, &surface, z_f) {
            Ok(found) => assert!((found.lower - 1.0).abs() <= CERTIFIED_GAP, "{basis}: {found:?}"),
            Err(MomentError::Uncertified { .. }) => {}
            Err(error) => panic!("{basis}: {error}"),
        }
    }
    if let Ok(found) = Trigonometric4::new().unwrap().bounds_of(&z, z_f) {
        assert!((found.lower - 1.0).abs() <= CERTIFIED_GAP, "{found:?}");
    }
}

/// Sixteen surfaces: every order's bounds enclose F and those of the next order.
#[test]
fn more_moments_never_loosen_the_bounds() {
    for seed in 1u32..6 {
        let random =
            |i: u32| f64::from(i.wrapping_mul(2_654_435_761).wrapping_mul(seed) >> 8) / f64::from(1u32 << 24);
        let atoms: Vec<(f64, f64)> = (1..17).map(|i| (random(i), 0.0625)).collect();
        let z_f = random(99);
        let f: f64 = atoms.iter().filter(|atom| atom.0 < z_f).map(|atom| atom.1).sum();
        let (mut lower, mut upper) = (0.0, 1.0);
        for order in 2..=16 {
            let found = bounds(&format!("power:{order}"), &atoms, z_f).unwrap();
            let tolerance = 2.0 * CERTIFIED_GAP;
            assert!(found.gap() <= CERTIFIED_GAP, "{order}: {found:?}");
            assert!(found.lower <= f && f <= found.upper, "{order}: {found:?} around {f}");
            assert!(
                found.lower >= lower - tolerance && found.upper <= upper + tolerance,
                "{order}: {found:?}"
            );
            (lower, upper) = (found.lower, found.upper);
        }
    }
}

/// Nearly dependent functions: an answer or a refusal, soon.
#[test]
fn nearly_dependent_functions_are_refused_in_time() {
    let atoms = [(0.2, 0.5), (0.45, 0.2), (0.7, 0.3)];
    let basis = "z,z^2,z^3,z^4,z^5,exp(z),exp(-z),exp(2z),exp(-2z),exp(3z),exp(-3z),sin(1pi z),cos(1pi z)";
    match bounds(basis, &atoms, 0.6) {
        Ok(found) => assert!(found.gap() <= CERTIFIED_GAP && found.lower <= 0.7, "{found:?}"),
        Err(error) => assert!(matches!(error, MomentError::Uncertified { .. }), "{error}"),
    }
}
