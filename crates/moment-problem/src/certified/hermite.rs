//! Dual certificates on the whole line: Hermite interpolation of the step function.
//!
//! Let z_1 = z_f and z_2, ..., z_k be any distinct nodes, and let Q be the polynomial of degree at most 2k - 2 that
//! equals the step \[z < z_f\] at every node and has derivative 0 at every node but z_f. Then Q <= \[z < z_f\] on the
//! whole line (Markov, Stieltjes; by Rolle's theorem Q' has all its 2k - 3 zeros between and at the nodes). So E\[Q\]
//! is a proved lower bound for every choice of nodes; it is the sharp one for the canonical nodes.

use crate::arithmetic::{DoubleDouble, Real};

/// Coefficients over 1, z, z^2, ... of the polynomial of least degree with the given values at all nodes and slope 0
/// at all nodes but the first.
fn interpolate(nodes: &[(DoubleDouble, f64)]) -> Vec<DoubleDouble> {
    let zero = DoubleDouble::zero();
    let mut abscissae = vec![nodes[0].0];
    let mut values = vec![DoubleDouble::from(nodes[0].1)];
    for &(z, value) in &nodes[1..] {
        abscissae.extend([z, z]);
        values.extend([DoubleDouble::from(value); 2]);
    }
    let count = abscissae.len();
    for order in 1..count {
        for i in (order..count).rev() {
            let step = abscissae[i] - abscissae[i - order];
            // Equal abscissae occur for order 1 only and stand for the prescribed slope.
            values[i] = if step == zero { zero } else { (values[i] - values[i - 1]) / step };
        }
    }
    let mut coefficients = vec![zero; count];
    for i in (0..count).rev() {
        for j in (1..count).rev() {
            coefficients[j] = coefficients[j - 1] - abscissae[i] * coefficients[j];
        }
        coefficients[0] = values[i] - abscissae[i] * coefficients[0];
    }
    coefficients
}

/// A dual polynomial with its proved value.
pub(crate) struct Dual {
    pub coefficients: Vec<f64>,
    pub proved: f64,
}

/// The dual polynomial for the step that is 1 where `is_one` holds, through z_f and the other nodes.
///
/// `moments` are E\[z\], E\[z^2\], ...; at least 2 (number of nodes) - 2 of them.
pub(crate) fn dual(
    z_f: DoubleDouble,
    others: &[DoubleDouble],
    moments: &[DoubleDouble],
    is_one: impl Fn(DoubleDouble) -> bool,
) -> Dual {
    let mut nodes = vec![(z_f, 0.0)];
    nodes.extend(others.iter().map(|&z| (z, f64::from(u8::from(is_one(z))))));
    let coefficients = interpolate(&nodes);
    let (mut value, mut size) = (coefficients[0], coefficients[0].to_f64().abs());
    for (&c, &b) in coefficients[1..].iter().zip(moments) {
        value = value + c * b;
        size += (c * b).to_f64().abs();
    }
    // EPSILON is sixteen times the arithmetic's rounding; 32 of them cover the divided differences of nine abscissae
    // and this sum.
    let rounding = size * 32.0 * DoubleDouble::EPSILON + f64::EPSILON;
    let mut coefficients: Vec<f64> = coefficients.into_iter().map(DoubleDouble::to_f64).collect();
    coefficients.resize(moments.len() + 1, 0.0);
    let proved = value.to_f64() - rounding;
    Dual { coefficients, proved: if proved.is_nan() { 0.0 } else { proved.max(0.0) } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_polynomial_stays_below_the_step_for_any_nodes(
            z_f in -2.0..2.0f64, nodes in prop::collection::vec(-3.0..3.0f64, 1..5), z in -20.0..20.0f64,
        ) {
            let separated = |a: f64, b: f64| (a - b).abs() > 0.05;
            prop_assume!(nodes.iter().enumerate().all(|(i, &a)| separated(a, z_f) && nodes[..i].iter().all(|&b| separated(a, b))));
            let others: Vec<DoubleDouble> = nodes.iter().map(|&z| DoubleDouble::from(z)).collect();
            let moments = vec![DoubleDouble::zero(); 2 * nodes.len()];
            for (is_before, step) in [(true, f64::from(u8::from(z < z_f))), (false, f64::from(u8::from(z > z_f)))] {
                let dual = dual(DoubleDouble::from(z_f), &others, &moments, |node| (node.to_f64() < z_f) == is_before);
                let (value, size) = dual.coefficients.iter().rev().fold((0.0, 0.0), |(v, s), &c| (v * z + c, s * z.abs() + c.abs()));
                prop_assert!(value <= step + 1e-12 * size, "{value} above {step} at {z}");
            }
        }
    }
}
