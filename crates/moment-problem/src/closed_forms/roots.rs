//! Closed forms for the roots of monic polynomials all of whose roots are real, using square roots only.
//!
//! The polynomials of the moment problem are of this kind. Rounding can push a double root off the real axis; every
//! discriminant is therefore clamped at 0, which returns the real part.

use crate::arithmetic::Real;

/// Roots of x^2 + b x + c, ascending, without cancellation.
#[inline(always)]
pub fn quadratic<R: Real>(b: R, c: R) -> [R; 2] {
    let half = R::from_f64(0.5);
    let b_half = b * half;
    let root = (b_half * b_half - c).max(R::zero()).sqrt();
    let far = if b_half < R::zero() { root - b_half } else { -(root + b_half) };
    let near = if far == R::zero() { far } else { c / far };
    if near < far { [near, far] } else { [far, near] }
}

/// Roots of x^3 + a x^2 + b x + c, ascending.
///
/// The depressed root of largest magnitude is 2 r cos(phi) with cos 3 phi known (Viete); the cosine of the third of
/// an angle is the root in \[sqrt(3)/2, 1\] of 4 x^3 - 3 x = cos 3 phi, found by Newton's method from a chord, so that
/// no trigonometric function is needed in any precision. The others follow by deflation.
pub fn cubic<R: Real>(a: R, b: R, c: R) -> [R; 3] {
    let constant = R::from_f64;
    let shift = -(a / constant(3.0));
    let p = b + a * shift;
    let q = shift * (shift * (a + shift) + b) + c; // the polynomial at `shift`
    let r = (-(p / constant(3.0))).max(R::zero()).sqrt();
    let scale = constant(2.0) * r * r * r;
    if scale <= constant(R::TINY) {
        return [shift; 3];
    }
    let target = (q.abs() / scale).min(R::one());
    let third = third_angle_cosine(target);
    let depressed = constant(2.0) * r * third;
    let first = polish(&[a, b, c], shift + if q > R::zero() { -depressed } else { depressed });
    // Deflate from the end that does not cancel: remove a large root backwards, a small one forwards.
    let cube = first * first * first;
    let (linear, rest) = if cube.abs() > c.abs() {
        let rest = -(c / first);
        ((rest - b) / first, rest)
    } else {
        let linear = a + first;
        (linear, b + first * linear)
    };
    let [second, third] = quadratic(linear, rest);
    let mut roots = [first, second, third];
    sort(&mut roots);
    roots
}

/// cos(acos(target) / 3) for target in \[0, 1\].
fn third_angle_cosine<R: Real>(target: R) -> R {
    let constant = R::from_f64;
    // The chord from (0, sqrt 3 / 2) to (1, 1) is within 0.005; Newton squares that error.
    let mut x = constant(0.866_025_403_784_438_6) + constant(0.133_974_596_215_561_4) * target;
    let steps = if R::EPSILON > 1e-10 {
        2
    } else if R::EPSILON > 1e-20 {
        3
    } else {
        5
    };
    for _ in 0..steps {
        let square = x * x;
        let value = (constant(4.0) * square - constant(3.0)) * x - target;
        x = x - value / (constant(12.0) * square - constant(3.0));
    }
    x
}

/// Roots of x^4 + a x^3 + b x^2 + c x + d, ascending: two quadratic factors from the largest root of the resolvent
/// cubic (Ferrari), the largest root of which is divided out; then Newton's method on the original polynomial.
pub fn quartic<R: Real>(a: R, b: R, c: R, d: R) -> [R; 4] {
    let constant = R::from_f64;
    let shift = -(a / constant(4.0));
    // Taylor coefficients at the shift: the depressed quartic y^4 + p y^2 + q y + r.
    let p = b + constant(1.5) * a * shift;
    let q = ((constant(4.0) * shift + constant(3.0) * a) * shift + constant(2.0) * b) * shift + c;
    let r = (((shift + a) * shift + b) * shift + c) * shift + d;
    let resolvent = cubic(constant(2.0) * p, p * p - constant(4.0) * r, -(q * q));
    let square = resolvent[2];
    if square <= constant(R::TINY) {
        return [shift; 4];
    }
    let s = square.sqrt();
    let half = constant(0.5);
    let [y1, y2] = quadratic(s, half * (p + square - q / s));
    let [y3, y4] = quadratic(-s, half * (p + square + q / s));
    // The shift costs digits where the roots differ in size by orders of magnitude, so only the root of largest size
    // is kept; dividing by it from the constant end does not cancel.
    let coefficients = [a, b, c, d];
    let larger = |x: R, y: R| if y.abs() > x.abs() { y } else { x };
    let largest =
        polish(&coefficients, larger(larger(y1 + shift, y2 + shift), larger(y3 + shift, y4 + shift)));
    let constant_term = -(d / largest);
    let linear = (constant_term - c) / largest;
    let [x1, x2, x3] = cubic((linear - b) / largest, linear, constant_term);
    let mut roots =
        [polish(&coefficients, x1), polish(&coefficients, x2), polish(&coefficients, x3), largest];
    sort(&mut roots);
    roots
}

/// Value and slope at x of the monic polynomial with the given lower coefficients.
fn horner<R: Real>(coefficients: &[R], x: R) -> (R, R) {
    let (mut value, mut slope) = (R::one(), R::zero());
    for &coefficient in coefficients {
        slope = slope * x + value;
        value = value * x + coefficient;
    }
    (value, slope)
}

/// Up to two Newton steps, each taken only if the residual decreases.
fn polish<R: Real>(coefficients: &[R], mut x: R) -> R {
    let (mut value, mut slope) = horner(coefficients, x);
    for _ in 0..2 {
        let next = x - value / slope;
        let (next_value, next_slope) = horner(coefficients, next);
        // A comparison with NaN is false, which rejects the step.
        if next_value.abs() < value.abs() {
            (x, value, slope) = (next, next_value, next_slope);
        } else {
            break;
        }
    }
    x
}

fn sort<R: Real, const N: usize>(values: &mut [R; N]) {
    for i in 1..N {
        let mut j = i;
        while j > 0 && values[j] < values[j - 1] {
            values.swap(j, j - 1);
            j -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::DoubleDouble;
    use proptest::prelude::*;

    fn expand<R: Real>(roots: &[R]) -> Vec<R> {
        let mut coefficients = vec![R::one()];
        for &root in roots {
            coefficients.push(R::zero());
            for i in (1..coefficients.len()).rev() {
                coefficients[i] = coefficients[i] - root * coefficients[i - 1];
            }
        }
        coefficients
    }

    fn check<R: Real>(mut roots: Vec<f64>, tolerance: f64) {
        roots.sort_by(f64::total_cmp);
        let exact: Vec<R> = roots.iter().map(|&x| R::from_f64(x)).collect();
        let c = expand(&exact);
        let found = match roots.len() {
            2 => quadratic(c[1], c[2]).to_vec(),
            3 => cubic(c[1], c[2], c[3]).to_vec(),
            _ => quartic(c[1], c[2], c[3], c[4]).to_vec(),
        };
        for (found, exact) in found.iter().zip(&roots) {
            let error = (found.to_f64() - exact).abs();
            assert!(error <= tolerance, "{found:?} against {exact} of {roots:?}");
        }
    }

    /// Separated roots: double ones are ill-conditioned (error eps^(1/k)) and tested below.
    fn separated(count: usize) -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(0.05..1.0f64, count).prop_flat_map(|gaps| {
            (-3.0..1.0f64).prop_map(move |start| {
                gaps.iter()
                    .scan(start, |x, gap| {
                        *x += gap;
                        Some(*x)
                    })
                    .collect()
            })
        })
    }

    proptest! {
        #[test]
        fn roots_are_recovered(two in separated(2), three in separated(3), four in separated(4)) {
            for roots in [two, three, four] {
                check::<f64>(roots.clone(), 1e-10);
                check::<f32>(roots.clone(), 0.02);
                check::<DoubleDouble>(roots, 1e-15);
            }
        }

        #[test]
        fn roots_of_very_different_size_keep_relative_accuracy(e in prop::collection::vec(-4.0..4.0f64, 4)) {
            let roots: Vec<f64> = e.iter().enumerate().map(|(i, e)| 10f64.powf(*e) * if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
            for n in 2..=4 {
                let mut sorted = roots[..n].to_vec();
                sorted.sort_by(f64::total_cmp);
                prop_assume!(sorted.windows(2).all(|w| w[1] - w[0] > 0.1 * w[0].abs().max(w[1].abs())));
                let c = expand(&sorted);
                let found = match n { 2 => quadratic(c[1], c[2]).to_vec(), 3 => cubic(c[1], c[2], c[3]).to_vec(), _ => quartic(c[1], c[2], c[3], c[4]).to_vec() };
                for (found, exact) in found.iter().zip(&sorted) {
                    prop_assert!((found - exact).abs() <= 1e-6 * exact.abs(), "{found} against {exact} of {sorted:?}");
                }
            }
        }
    }

    #[test]
    fn multiple_roots_and_zeros_are_finite() {
        for roots in [
            vec![0.0; 2],
            vec![0.0; 3],
            vec![0.0; 4],
            vec![1.0; 3],
            vec![2.0; 4],
            vec![0.0, 0.0, 1.0],
            vec![-1.0, -1.0, 1.0, 1.0],
        ] {
            check::<f64>(roots.clone(), 1e-3);
        }
    }
}
