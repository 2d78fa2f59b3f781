//! The points of a canonical representation besides z_f: a polynomial with exact coefficients and its real roots.

use crate::arithmetic::{Dyadic, minors};
use crate::error::MomentError;

/// Steps of one root; each at least doubles the correct bits once it is near.
const MAX_STEPS: usize = 80;

/// Sum of c_j u^j = 0 for the points u besides 0, and the weight at 0 as a fraction.
pub(super) struct Equation {
    coefficients: Vec<Dyadic>,
    pub(super) at_z_f: (Dyadic, Dyadic),
}

impl Equation {
    /// The canonical representation through 0 of an even number of moments s_0, s_1, ...
    ///
    /// # Errors
    /// [`MomentError::NotPositiveDefinite`] where no distribution has exactly these moments.
    pub(super) fn of(s: &[Dyadic]) -> Result<Self, MomentError> {
        if s.iter().all(Dyadic::is_zero) {
            // No mass at all, as between the ends where all of it is at these.
            return Ok(Self { coefficients: vec![Dyadic::one()], at_z_f: (Dyadic::zero(), Dyadic::one()) });
        }
        let size = s.len() / 2 + 1;
        let principal = minors(size, size, |i, j| s[i + j].clone());
        let rank = (1..=size).find(|&k| !principal[(1 << k) - 1].is_positive()).unwrap_or(size + 1) - 1;
        if rank < size {
            let next = &principal[(1 << (rank + 1)) - 1];
            let pivot = |k: usize| principal[(1 << k) - 1].to_f64();
            let impossible =
                || MomentError::NotPositiveDefinite { index: rank + 1, pivot: next.to_f64() / pivot(rank) };
            if next.is_negative() || rank == 0 {
                return Err(impossible());
            }
            let mut equation = Self::new(s, rank, Dyadic::zero());
            // As many points as the rank; the polynomial that vanishes there has to explain all moments.
            let is_at_z_f = equation.coefficients[0].is_zero();
            if is_at_z_f {
                equation = Self::new(s, rank - 1, principal[(1 << rank) - 1].clone());
            }
            let first = usize::from(is_at_z_f);
            for i in first..s.len() - equation.coefficients.len() + 1 {
                let terms = equation.coefficients.iter().zip(&s[i..]);
                if !terms.fold(Dyadic::zero(), |sum, (c, s)| &sum + &(c * s)).is_zero() {
                    return Err(impossible());
                }
            }
            return Ok(equation);
        }
        Ok(Self::new(s, size - 1, principal[(1 << size) - 1].clone()))
    }

    /// For `count` points; `determinant` is that of (s_(i+j)), i, j = 0..count.
    fn new(s: &[Dyadic], count: usize, determinant: Dyadic) -> Self {
        let all = (1usize << (count + 1)) - 1;
        let minors = minors(count, count + 1, |i, j| s[i + j + 1].clone());
        let coefficient = |j: usize| {
            let minor = &minors[all & !(1 << j)];
            if j.is_multiple_of(2) { minor.clone() } else { -minor }
        };
        let coefficients: Vec<Dyadic> = (0..=count).map(coefficient).collect();
        let divisor = coefficients[0].clone();
        Self { coefficients, at_z_f: (determinant, divisor) }
    }

    /// The points to `precision` bits, those at infinity left out; `None` if that is not enough to find them.
    pub(super) fn points(&self, precision: u64) -> Option<Vec<Dyadic>> {
        let mut high_first: Vec<Dyadic> = self.coefficients.iter().map(|c| c.rounded(precision)).collect();
        // In w = 1 / u the constant is the leading coefficient, which is not 0.
        while high_first.last().is_some_and(Dyadic::is_zero) {
            high_first.pop();
        }
        let exact = high_first.clone();
        let mut points = Vec::new();
        while high_first.len() > 1 {
            let root = if high_first.len() == 3 {
                let roots = quadratic(&high_first, precision)?;
                points.push(roots[0].clone());
                high_first.truncate(2);
                roots[1].clone()
            } else {
                let root = laguerre(&high_first, precision)?;
                let last = high_first.len() - 1;
                for i in 1..last {
                    high_first[i] = (&high_first[i] + &(&root * &high_first[i - 1])).rounded(precision);
                }
                high_first.truncate(last);
                root
            };
            points.push(root);
            if high_first.len() == 2 && points.len() == exact.len() - 1 {
                break;
            }
        }
        let one = Dyadic::one();
        let mut result: Vec<Dyadic> = Vec::new();
        for root in points {
            let w = polish(&exact, root, precision)?;
            let u = one.quotient(&w, precision);
            if result.contains(&u) {
                return None;
            }
            result.push(u);
        }
        Some(result)
    }
}

/// Value, slope and half the curvature of a polynomial, highest power first.
fn taylor(polynomial: &[Dyadic], x: &Dyadic, precision: u64) -> [Dyadic; 3] {
    let mut result = [Dyadic::zero(), Dyadic::zero(), Dyadic::zero()];
    for c in polynomial {
        let [value, slope, half] = &result;
        let half = &(half * x) + slope;
        let slope = &(slope * x) + value;
        let value = &(value * x) + c;
        result = [value, slope, half].map(|number| number.rounded(2 * precision));
    }
    result
}

/// Laguerre's method from 0: for a polynomial with real roots it arrives at the next one from anywhere.
fn laguerre(polynomial: &[Dyadic], precision: u64) -> Option<Dyadic> {
    let degree = Dyadic::integer(polynomial.len() as i64 - 1);
    let less = &degree - &Dyadic::one();
    let mut x = Dyadic::zero();
    for _ in 0..MAX_STEPS {
        let [value, slope, half] = taylor(polynomial, &x, precision);
        if value.is_zero() {
            return Some(x);
        }
        // degree value / (slope +- root), root^2 = (degree - 1) ((degree - 1) slope^2 - degree value curvature)
        let curved = &(&degree * &value) * &half.shifted(1);
        let square = &less * &(&(&less * &slope.square()) - &curved);
        let root = if square.is_positive() { square.sqrt(precision) } else { Dyadic::zero() };
        let divisor = if slope.is_negative() { &slope - &root } else { &slope + &root };
        if divisor.is_zero() {
            return None;
        }
        let step = (&degree * &value).quotient(&divisor, precision);
        x = (&x - &step).rounded(precision);
        if step.magnitude() < x.magnitude() - precision as i64 + 4 {
            return Some(x);
        }
    }
    // Rounding decides where roots are close; the caller proves the result or asks for more bits.
    Some(x)
}

/// Both roots; `None` where rounding has made them complex.
fn quadratic(polynomial: &[Dyadic], precision: u64) -> Option<[Dyadic; 2]> {
    let [a, b, c] = polynomial else { return None };
    let square = &b.square() - &(a * c).shifted(2);
    if !square.is_positive() {
        return None;
    }
    let root = square.sqrt(precision);
    let far = if b.is_negative() { &root - b } else { -&(b + &root) };
    let far_root = far.quotient(&a.shifted(1), precision);
    Some([c.shifted(1).quotient(&far, precision), far_root])
}

/// Newton steps on the polynomial before deflation, as long as they shrink.
fn polish(polynomial: &[Dyadic], mut x: Dyadic, precision: u64) -> Option<Dyadic> {
    let mut before = i64::MAX;
    for _ in 0..4 {
        let [value, slope, _] = taylor(polynomial, &x, precision);
        if value.is_zero() || slope.is_zero() {
            break;
        }
        let step = value.quotient(&slope, precision);
        if step.magnitude() >= before || step.magnitude() >= x.magnitude() {
            break;
        }
        before = step.magnitude();
        x = (&x - &step).rounded(precision);
    }
    (!x.is_zero()).then_some(x)
}
