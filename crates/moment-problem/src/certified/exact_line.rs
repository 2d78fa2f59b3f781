//! Power moments on the whole line without rounding: for kernels that double-double does not resolve.
//!
//! Depths, weights, moments and z_f are binary fractions, so the moments s_k about z_f and all determinants of them are
//! computed exactly (the sign of a pivot is never a guess, and moving or scaling the depths changes nothing). The points
//! besides z_f are the roots of the polynomial R of degree n with E\[u R(u) q(u)\] = 0 for all q of lower degree,
//! u = z - z_f; its coefficients are minors of (s_(i+j+1)), and the weight at z_f is det (s_(i+j)) / det (s_(i+j+2)).
//! Roots are rounded to so many bits as the certificate needs: with Hermite's polynomials h_a (1 at the point u_a, 0 at z_f
//! and, with slope 0, at all other points) the sum of E\[h_a\] over the points in front is a proved lower bound for *any* points
//! (see `hermite`), the same over those behind a proved bound of the mass behind, and what both and the exact
//! weight at z_f leave of the total mass is all that the two bounds can be wrong by. Precision is doubled until that is
//! nothing.

use super::bounds::{Bounds, Certificate, sorted_support};
use super::semi_infinite::CERTIFIED_GAP;
use crate::arithmetic::{DoubleDouble, Dyadic, minors};
use crate::error::MomentError;

/// Bits of the roots to start with: pairs of surfaces 1e-15 apart are resolved.
const FIRST_PRECISION: u64 = 192;

/// Bits at which the search for a proof ends. Six times the exponent range of doubles.
const LAST_PRECISION: u64 = 12_288;

/// What both bounds may be wrong by, as a binary exponent, before precision is doubled: a thousandth of the last place of 1.
const NO_ERROR: i64 = -63;

/// Steps of one root; each at least doubles the correct bits once it is near.
const MAX_STEPS: usize = 80;

/// Parts of the arcsine distribution that are mixed in, as binary exponents, to reach the set of moments from just outside:
/// from the rounding of double-double to a few roundings of doubles.
pub(crate) const MIXTURES: [i64; 8] = [-102, -94, -86, -76, -66, -56, -51, -47];

/// Moments of the arcsine distribution on \[-1, 1\] of even order, times 128.
const ARCSINE: [i64; 5] = [128, 64, 48, 40, 35];

/// E\[u^k\], k = 0..M, times an unknown total mass near 1; u = z - z_f.
pub(crate) struct ExactLine {
    z_f: f64,
    moments: Vec<Dyadic>,
}

impl ExactLine {
    /// The first `order` moments of finitely many depths.
    pub(crate) fn of_atoms(depths: &[f64], weights: &[DoubleDouble], order: usize, z_f: f64) -> Self {
        let mut moments = vec![Dyadic::zero(); order + 1];
        for (&z, &w) in depths.iter().zip(weights) {
            let u = &Dyadic::from(z) - &Dyadic::from(z_f);
            let mut term = Dyadic::from(w);
            for moment in &mut moments {
                *moment = &*moment + &term;
                term = &term * &u;
            }
        }
        Self { z_f, moments }
    }

    /// E\[z\], E\[z^2\], ... as they are.
    pub(crate) fn of_moments(moments: &[DoubleDouble], z_f: f64) -> Self {
        let raw = std::iter::once(Dyadic::one()).chain(moments.iter().map(|&b| Dyadic::from(b)));
        Self::about(raw.collect(), z_f)
    }

    /// The same with the part 2^`exponent` of an arcsine distribution about 0, as wide as the moments are.
    pub(crate) fn of_mixture(moments: &[DoubleDouble], z_f: f64, exponent: i64) -> Self {
        let raw: Vec<Dyadic> = moments.iter().map(|&b| Dyadic::from(b)).collect();
        let width = |k: usize| raw[k - 1].magnitude().div_euclid(k as i64) + 1;
        let even = (2..=raw.len()).step_by(2).filter(|k| !raw[k - 1].is_zero());
        let width = even.map(width).max().unwrap_or(0);
        let share = Dyadic::power_of_two(exponent);
        let rest = &Dyadic::one() - &share;
        let mixed = raw.iter().enumerate().map(|(i, b)| {
            let k = i + 1;
            let other = if k % 2 == 0 { Dyadic::integer(ARCSINE[k / 2]) } else { Dyadic::zero() };
            &(&rest * b) + &other.shifted(exponent - 7 + width * k as i64)
        });
        Self::about(std::iter::once(Dyadic::one()).chain(mixed).collect(), z_f)
    }

    /// Moments about z_f from those about 0, by repeated s_j <- s_j - z_f s_(j-1).
    fn about(mut moments: Vec<Dyadic>, z_f: f64) -> Self {
        let z = Dyadic::from(z_f);
        for k in 1..moments.len() {
            for j in (k..moments.len()).rev() {
                moments[j] = &moments[j] - &(&z * &moments[j - 1]);
            }
        }
        Self { z_f, moments }
    }

    /// Both bounds, proved.
    ///
    /// # Errors
    /// [`MomentError::NotPositiveDefinite`] where no distribution has exactly these moments, [`MomentError::Uncertified`]
    /// where the last precision does not suffice.
    pub(crate) fn bounds(&self) -> Result<Bounds, MomentError> {
        let equation = self.equation()?;
        let mut precision = FIRST_PRECISION;
        let mut gap = f64::INFINITY;
        while precision <= LAST_PRECISION {
            if let Some(points) = equation.points(precision) {
                let solution = Solution::new(self, &equation.at_z_f, points, precision);
                if solution.missing.is_zero() || solution.missing.magnitude() <= NO_ERROR {
                    return Ok(solution.into_bounds(self));
                }
                gap = solution.missing.to_f64();
                if 2 * precision > LAST_PRECISION && gap <= CERTIFIED_GAP {
                    return Ok(solution.into_bounds(self));
                }
            }
            precision *= 2;
        }
        Err(MomentError::Uncertified { gap })
    }

    /// The polynomial of the points besides z_f, and the weight at z_f.
    fn equation(&self) -> Result<Equation, MomentError> {
        let s = &self.moments;
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
            let mut equation = Equation::new(s, rank, Dyadic::zero());
            // As many points as the rank; the polynomial that vanishes there has to explain all moments.
            let is_at_z_f = equation.coefficients[0].is_zero();
            if is_at_z_f {
                equation = Equation::new(s, rank - 1, principal[(1 << rank) - 1].clone());
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
        Ok(Equation::new(s, size - 1, principal[(1 << size) - 1].clone()))
    }
}

/// Sum of c_j u^j = 0 for the points u besides 0, and the weight at 0 as a fraction.
struct Equation {
    coefficients: Vec<Dyadic>,
    at_z_f: (Dyadic, Dyadic),
}

impl Equation {
    /// For `count` points; `determinant` is that of (s_(i+j)), i, j = 0..count.
    fn new(s: &[Dyadic], count: usize, determinant: Dyadic) -> Self {
        let all = (1usize << (count + 1)) - 1;
        let minors = minors(count, count + 1, |i, j| s[i + j + 1].clone());
        let coefficient = |j: usize| {
            let minor = &minors[all & !(1 << j)];
            if j % 2 == 0 { minor.clone() } else { -minor }
        };
        let coefficients: Vec<Dyadic> = (0..=count).map(coefficient).collect();
        let divisor = coefficients[0].clone();
        Self { coefficients, at_z_f: (determinant, divisor) }
    }

    /// The points to `precision` bits, those at infinity left out; `None` if that is not enough to find them.
    fn points(&self, precision: u64) -> Option<Vec<Dyadic>> {
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

/// Hermite's polynomial of one point: `numerator` over u^0, u^1, ..., over `divisor`.
struct Hermite {
    numerator: Vec<Dyadic>,
    divisor: Dyadic,
}

impl Hermite {
    fn new(points: &[Dyadic], index: usize) -> Self {
        let at = &points[index];
        let others = || points.iter().enumerate().filter(move |&(j, _)| j != index).map(|(_, u)| u);
        // u times the squared other factors: 1 at the point after division by its value there.
        let mut factors = vec![Dyadic::zero(), Dyadic::one()];
        for u in others() {
            for _ in 0..2 {
                factors.push(Dyadic::zero());
                for i in (1..factors.len()).rev() {
                    factors[i] = &factors[i - 1] - &(u * &factors[i]);
                }
                factors[0] = -&(u * &factors[0]);
            }
        }
        // Slope 0 at the point: times 1 - (1 / u_a + sum 2 / (u_a - u_j)) (u - u_a), over the common denominator.
        let steps: Vec<Dyadic> = others().map(|u| at - u).collect();
        let product = |left_out: usize| {
            let kept = steps.iter().enumerate().filter(|&(j, _)| j != left_out);
            kept.fold(Dyadic::one(), |product, (_, step)| &product * step)
        };
        let all = product(usize::MAX);
        let sum = (0..steps.len()).fold(Dyadic::zero(), |sum, j| &sum + &product(j));
        let slope = -&(&all + &(at * &sum).shifted(1));
        let common = at * &all;
        let constant = &common - &(at * &slope);
        let mut numerator = vec![Dyadic::zero(); factors.len() + 1];
        for (i, factor) in factors.iter().enumerate() {
            numerator[i] = &numerator[i] + &(factor * &constant);
            numerator[i + 1] = &numerator[i + 1] + &(factor * &slope);
        }
        Self { numerator, divisor: &(&common * &common) * &all }
    }

    /// Its expectation, not above the true one, as a multiple of the total mass.
    fn expectation(&self, moments: &[Dyadic], precision: u64) -> Dyadic {
        let terms = self.numerator.iter().zip(moments);
        let sum = terms.fold(Dyadic::zero(), |sum, (c, s)| &sum + &(c * s));
        sum.quotient(&(&self.divisor * &moments[0]), precision)
    }
}

/// Points besides z_f with what they prove.
struct Solution {
    points: Vec<Dyadic>,
    weights: Vec<Dyadic>,
    polynomials: Vec<Hermite>,
    at_z_f: Dyadic,
    front: Dyadic,
    behind: Dyadic,
    /// What front, behind and the weight at z_f leave of the mass 1: no bound can be wrong by more.
    missing: Dyadic,
    precision: u64,
}

impl Solution {
    fn new(line: &ExactLine, at_z_f: &(Dyadic, Dyadic), points: Vec<Dyadic>, precision: u64) -> Self {
        let polynomials: Vec<Hermite> = (0..points.len()).map(|i| Hermite::new(&points, i)).collect();
        let weights: Vec<Dyadic> =
            polynomials.iter().map(|h| h.expectation(&line.moments, precision)).collect();
        let sum = |inside: &dyn Fn(&Dyadic) -> bool| {
            let chosen = points.iter().zip(&weights).filter(|(u, _)| inside(u));
            chosen.fold(Dyadic::zero(), |sum, (_, w)| &sum + w)
        };
        let (front, behind) = (sum(&Dyadic::is_negative), sum(&Dyadic::is_positive));
        let at_z_f = at_z_f.0.quotient(&(&at_z_f.1 * &line.moments[0]), precision);
        let missing = &(&(&Dyadic::one() - &front) - &behind) - &at_z_f;
        Self { points, weights, polynomials, at_z_f, front, behind, missing, precision }
    }

    fn into_bounds(self, line: &ExactLine) -> Bounds {
        let lower_dual = self.dual(line, Dyadic::is_negative);
        let upper_dual = self.dual(line, Dyadic::is_positive);
        let z_f = Dyadic::from(line.z_f);
        let points = self.points.iter().zip(&self.weights);
        let points = points.map(|(u, w)| ((&z_f + u).to_f64(), w.to_f64()));
        let (support, weights) =
            sorted_support(points.chain([(line.z_f, self.at_z_f.to_f64())]), NODE_WEIGHT);
        let lower = (&self.front + &self.missing).to_f64().clamp(0.0, 1.0);
        let upper = (&self.front + &self.at_z_f).to_f64();
        Bounds {
            lower,
            upper: upper.clamp(lower, 1.0),
            support,
            weights,
            certificate: Certificate {
                lower_dual,
                upper_dual,
                worst_slack: 0.0,
                lower_proved: self.front.to_f64_below().clamp(0.0, 1.0),
                upper_proved: (&Dyadic::one() - &self.behind).to_f64_above().clamp(0.0, 1.0),
            },
        }
    }

    /// Coefficients over 1, z, ..., z^M of the sum of the polynomials of the chosen points.
    fn dual(&self, line: &ExactLine, chosen: impl Fn(&Dyadic) -> bool) -> Vec<f64> {
        let mut sum = vec![Dyadic::zero(); line.moments.len()];
        for (_, polynomial) in self.points.iter().zip(&self.polynomials).filter(|(u, _)| chosen(u)) {
            for (value, c) in sum.iter_mut().zip(&polynomial.numerator) {
                *value = &*value + &c.quotient(&polynomial.divisor, 2 * self.precision);
            }
        }
        // From powers of u = z - z_f to powers of z: Horner's scheme at -z_f, again and again.
        let z_f = Dyadic::from(line.z_f);
        for start in 0..sum.len() {
            for i in (start..sum.len() - 1).rev() {
                sum[i] = &sum[i] - &(&z_f * &sum[i + 1]);
            }
        }
        sum.iter().map(Dyadic::to_f64).collect()
    }
}

/// Points of less weight carry nothing that doubles hold; they are left out of the support that is returned.
const NODE_WEIGHT: f64 = 1e-26;
