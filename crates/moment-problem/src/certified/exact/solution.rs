//! What points prove: Hermite's polynomials through them and their exact expectations.

use super::super::bounds::{Bounds, Certificate, sorted_support};
use crate::arithmetic::Dyadic;

/// Points of less weight carry nothing that doubles hold; they are left out of the support that is returned.
const NODE_WEIGHT: f64 = 1e-26;

/// A weight that is negative by less than this (a binary exponent) is a rounded zero.
const NO_WEIGHT: i64 = -60;

/// A polynomial: `numerator` over u^0, u^1, ..., over `divisor`.
struct Hermite {
    numerator: Vec<Dyadic>,
    divisor: Dyadic,
}

impl Hermite {
    /// 1 at one of the points, 0 at the others and at u = 0; slope 0 at all points before `ends`, which are simple.
    fn new(points: &[Dyadic], ends: &[Dyadic], index: usize) -> Self {
        let is_end = index >= points.len();
        let at = if is_end { &ends[index - points.len()] } else { &points[index] };
        // The other zeros with their multiplicities.
        let origin = Dyadic::zero();
        let double = points.iter().map(|u| (u, 2));
        let simple = ends.iter().map(|u| (u, 1));
        let mut zeros: Vec<(&Dyadic, i64)> = double.chain(simple).collect();
        zeros.remove(index);
        zeros.push((&origin, 1));
        let mut factors = vec![Dyadic::one()];
        for &(u, multiplicity) in &zeros {
            for _ in 0..multiplicity {
                factors.push(Dyadic::zero());
                for i in (1..factors.len()).rev() {
                    factors[i] = &factors[i - 1] - &(u * &factors[i]);
                }
                factors[0] = -&(u * &factors[0]);
            }
        }
        let steps: Vec<Dyadic> = zeros.iter().map(|&(u, _)| at - u).collect();
        let product = |left_out: usize| {
            let kept = steps.iter().enumerate().filter(|&(j, _)| j != left_out);
            kept.fold(Dyadic::one(), |product, (_, step)| &product * step)
        };
        let common = product(usize::MAX);
        let powers = zeros.iter().zip(&steps).filter(|((_, multiplicity), _)| *multiplicity == 2);
        let value = powers.fold(common.clone(), |value, (_, step)| &value * step);
        if is_end {
            return Self { numerator: factors, divisor: value };
        }
        // Slope 0 at the point: times 1 - (u - u_a) sum m_j / (u_a - u_j), over the common denominator.
        let terms = zeros.iter().enumerate().map(|(j, &(_, multiplicity))| {
            let term = product(j);
            if multiplicity == 2 { term.shifted(1) } else { term }
        });
        let slope = -&terms.fold(Dyadic::zero(), |sum, term| &sum + &term);
        let constant = &common - &(at * &slope);
        let mut numerator = vec![Dyadic::zero(); factors.len() + 1];
        for (i, factor) in factors.iter().enumerate() {
            numerator[i] = &numerator[i] + &(factor * &constant);
            numerator[i + 1] = &numerator[i + 1] + &(factor * &slope);
        }
        Self { numerator, divisor: &value * &common }
    }

    /// Its expectation, not above the true one, as a multiple of the total mass.
    fn expectation(&self, moments: &[Dyadic], precision: u64) -> Dyadic {
        let terms = self.numerator.iter().zip(moments);
        let sum = terms.fold(Dyadic::zero(), |sum, (c, s)| &sum + &(c * s));
        sum.quotient(&(&self.divisor * &moments[0]), precision)
    }
}

/// Points besides z_f with what they prove.
pub(super) struct Solution {
    points: Vec<Dyadic>,
    weights: Vec<Dyadic>,
    polynomials: Vec<Hermite>,
    at_z_f: Dyadic,
    front: Dyadic,
    behind: Dyadic,
    /// What front, behind and the weight at z_f leave of the mass 1: no bound can be wrong by more.
    pub(super) missing: Dyadic,
    order: usize,
    precision: u64,
}

impl Solution {
    /// `at_z_f` is a fraction; `points` and `ends` differ from each other and from 0, which is z_f.
    pub(super) fn new(
        moments: &[Dyadic],
        at_z_f: &(Dyadic, Dyadic),
        mut points: Vec<Dyadic>,
        ends: &[Dyadic],
        precision: u64,
    ) -> Self {
        let count = points.len() + ends.len();
        let polynomials: Vec<Hermite> = (0..count).map(|i| Hermite::new(&points, ends, i)).collect();
        let weights: Vec<Dyadic> = polynomials.iter().map(|h| h.expectation(moments, precision)).collect();
        points.extend_from_slice(ends);
        let sum = |inside: &dyn Fn(&Dyadic) -> bool| {
            let chosen = points.iter().zip(&weights).filter(|(u, _)| inside(u));
            chosen.fold(Dyadic::zero(), |sum, (_, w)| &sum + w)
        };
        let (front, behind) = (sum(&Dyadic::is_negative), sum(&Dyadic::is_positive));
        let at_z_f = at_z_f.0.quotient(&(&at_z_f.1 * &moments[0]), precision);
        let missing = &(&(&Dyadic::one() - &front) - &behind) - &at_z_f;
        let order = moments.len() - 1;
        Self { points, weights, polynomials, at_z_f, front, behind, missing, order, precision }
    }

    /// Whether no weight is negative but for rounding.
    pub(super) fn is_distribution(&self) -> bool {
        let mut weights = self.weights.iter().chain([&self.at_z_f]);
        weights.all(|w| !w.is_negative() || w.magnitude() < NO_WEIGHT)
    }

    pub(super) fn into_bounds(self, z_f: f64) -> Bounds {
        let lower_dual = self.dual(z_f, Dyadic::is_negative);
        let upper_dual = self.dual(z_f, Dyadic::is_positive);
        let points = self.points.iter().zip(&self.weights);
        let points = points.map(|(u, w)| ((&Dyadic::from(z_f) + u).to_f64(), w.to_f64()));
        let (support, weights) = sorted_support(points.chain([(z_f, self.at_z_f.to_f64())]), NODE_WEIGHT);
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
    fn dual(&self, z_f: f64, chosen: impl Fn(&Dyadic) -> bool) -> Vec<f64> {
        let mut sum = vec![Dyadic::zero(); self.order + 1];
        for (_, polynomial) in self.points.iter().zip(&self.polynomials).filter(|(u, _)| chosen(u)) {
            for (value, c) in sum.iter_mut().zip(&polynomial.numerator) {
                *value = &*value + &c.quotient(&polynomial.divisor, 2 * self.precision);
            }
        }
        // From powers of u = z - z_f to powers of z: Horner's scheme at -z_f, again and again.
        let z_f = Dyadic::from(z_f);
        for start in 0..sum.len() {
            for i in (start..sum.len() - 1).rev() {
                sum[i] = &sum[i] - &(&z_f * &sum[i + 1]);
            }
        }
        sum.iter().map(Dyadic::to_f64).collect()
    }
}
