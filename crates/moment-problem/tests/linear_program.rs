//! Bounds that the solvers behind good_lp refuse on orthonormal rows, and prove in the coordinates of an optimal basis.

#![allow(clippy::unwrap_used)]

use moment_problem::{Basis, DepthDistribution, ExchangeSimplex, LinearProgram, LowerBound};

#[test]
fn other_rows_are_tried_before_a_refusal() {
    let basis: Basis = "z^5,1/(1+z),exp(8z),sin(2pi z)".parse().unwrap();
    let (program, exchange) = (LinearProgram::new(&basis).unwrap(), ExchangeSimplex::new(&basis).unwrap());
    for (depths, weights, z_f) in CASES {
        let z = DepthDistribution::new(depths, weights).unwrap();
        let (found, expected) = (program.bounds_of(&z, z_f).unwrap(), exchange.bounds_of(&z, z_f).unwrap());
        let error = (found.lower - expected.lower).abs().max((found.upper - expected.upper).abs());
        assert!(error <= 2e-8, "{found:?} {expected:?}");
    }
}

/// Depths, weights and z_f.
type Case = (&'static [f64], &'static [f64], f64);

const CASES: [Case; 2] = [
    (
        &[
            0.119333848,
            0.121893013,
            0.123994869,
            0.126245149,
            0.128834758,
            0.131093225,
            0.133226469,
            0.13572535,
            0.138139598,
            0.140290929,
            0.142667094,
            0.145226259,
        ],
        &[
            0.010999355176999242,
            0.04224154157055374,
            0.05203229772349312,
            0.10974199526065291,
            0.14656215953850119,
            0.12282261346176793,
            0.15402268799783164,
            0.1465621595385012,
            0.09416218223663878,
            0.06761211074750725,
            0.04224154157055374,
            0.010999355176999242,
        ],
        0.121893013,
    ),
    (&[0.375, 0.40625], &[0.6484543580739304, 0.3515456419260696], 0.37761276),
];
