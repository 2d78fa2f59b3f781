//! The distribution that attains both bounds of power moments on the line, by the polynomial in w = 1 / (z - z_f): see
//! [`hamburger`](super::hamburger).

use super::pair::Pair;
use super::roots;
use crate::arithmetic::Real;

/// A pivot of the Hankel matrix counts as zero up to this many rounding errors of the moment it is computed from.
/// Four covers the two products and two differences that a pivot goes through.
const PIVOT_ROUNDINGS: f64 = 4.0;

#[inline(always)]
pub(super) fn pivot_floor<R: Real>(moment: R) -> R {
    R::from_f64(PIVOT_ROUNDINGS * R::EPSILON) * moment.abs() + R::from_f64(R::TINY)
}

/// A pivot that cannot be negative. Where rounding made it so, it tells how large the rounding is, and the weight at
/// z_f, which is proportional to the last pivot, becomes as uncertain as the moments are.
#[inline(always)]
pub(super) fn positive_pivot<R: Real>(pivot: R, moment: R) -> R {
    pivot.abs().max(pivot_floor(moment))
}

/// Largest number of support points: m = 8 moments have 5.
const MAX_POINTS: usize = 5;

/// The distribution that attains both bounds: z_f and the points z_f + 1 / w_i.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Canonical<R> {
    /// Weight at z_f.
    pub at_z_f: R,
    /// w_i = 1 / (z_i - z_f), ascending; `count` are used.
    pub inverse_offsets: [R; MAX_POINTS - 1],
    /// Number of points besides z_f.
    pub count: usize,
    /// Moments about z_f of orders 0 to `count`.
    shifted: [R; MAX_POINTS],
    /// Taylor coefficients at z_f of P_0 to P_count.
    pub taylor: [[R; MAX_POINTS]; MAX_POINTS],
    /// d_0 to d_count.
    pivots: [R; MAX_POINTS],
    /// First pivot that was not positive beyond rounding, with its (1-based) index.
    pub singular: Option<(usize, R)>,
}

/// Solves for the support by the w-polynomial; M = 2, 4, 6 or 8.
pub(crate) fn canonical<R: Real, const M: usize>(moments: &[R; M], z_f: R) -> Canonical<R> {
    const { assert!(M == 2 || M == 4 || M == 6 || M == 8) }
    let zero = R::zero();
    let hankel = |i: usize| if i == 0 { R::one() } else { moments[i - 1] };
    let full = M / 2 + 1;

    // LDL^T of the Hankel matrix, together with the Taylor coefficients at z_f of the rows of L^-1 (1, z, z^2, ...),
    // which are the orthogonal polynomials P_k.
    let mut lower = [[zero; MAX_POINTS]; MAX_POINTS];
    let mut pivots = [R::one(); MAX_POINTS];
    let mut taylor = [[zero; MAX_POINTS]; MAX_POINTS];
    taylor[0][0] = R::one();
    let mut power = taylor[0];
    let mut points = full;
    let mut singular = None;
    for k in 1..full {
        for j in 0..k {
            let mut sum = hankel(k + j);
            for i in 0..j {
                sum = sum - lower[k][i] * lower[j][i] * pivots[i];
            }
            lower[k][j] = sum / pivots[j];
        }
        let mut pivot = hankel(2 * k);
        for i in 0..k {
            pivot = pivot - lower[k][i] * lower[k][i] * pivots[i];
        }
        for i in (0..=k).rev() {
            power[i] = z_f * power[i] + if i > 0 { power[i - 1] } else { zero };
        }
        taylor[k] = power;
        let (before, rest) = taylor.split_at_mut(k);
        for (earlier, &factor) in before.iter().zip(&lower[k]) {
            for (value, &coefficient) in rest[0].iter_mut().zip(earlier) {
                *value = *value - factor * coefficient;
            }
        }
        let floor = pivot_floor(hankel(2 * k));
        if pivot <= floor {
            singular = Some((k + 1, pivot));
            pivots[k] = positive_pivot(pivot, hankel(2 * k));
            points = k + 1;
            break;
        }
        pivots[k] = pivot;
    }

    let mut q = [zero; MAX_POINTS];
    for k in 0..points {
        let factor = taylor[k][0] / pivots[k];
        for i in 0..=k {
            q[i] = q[i] + factor * taylor[k][i];
        }
    }
    let a = q.map(|coefficient| coefficient / q[0]);
    let mut inverse_offsets = [zero; MAX_POINTS - 1];
    match points {
        2 => inverse_offsets[0] = -a[1],
        3 => inverse_offsets[..2].copy_from_slice(&roots::quadratic(a[1], a[2])),
        4 => inverse_offsets[..3].copy_from_slice(&roots::cubic(a[1], a[2], a[3])),
        _ => inverse_offsets = roots::quartic(a[1], a[2], a[3], a[4]),
    }

    // Moments about z_f: E[(z - z_f)^k] by repeated t_j <- t_(j+1) - z_f t_j.
    let mut shifted = [zero; MAX_POINTS];
    for (i, value) in shifted.iter_mut().enumerate().take(points) {
        *value = hankel(i);
    }
    for k in 1..points {
        for j in (k..points).rev() {
            shifted[j] = shifted[j] - z_f * shifted[j - 1];
        }
    }
    Canonical {
        at_z_f: R::one() / q[0],
        inverse_offsets,
        count: points - 1,
        shifted,
        taylor,
        pivots,
        singular,
    }
}

impl<R: Real> Canonical<R> {
    /// E\[phi\] where phi(z_f) = 0 and phi(z_i) = `values[i]`, by Newton's divided differences in w: for the evidence
    /// in double-double, where points may lie at infinity.
    ///
    /// With N = count, u = z - z_f and w = 1 / u the function w^N phi is a polynomial of degree N - 1 in w, and the
    /// expectation of u^k corresponds to the coefficient of w^(N-k).
    pub(crate) fn expectation(&self, values: [R; MAX_POINTS - 1]) -> R {
        let n = self.count;
        let zero = R::zero();
        let w = &self.inverse_offsets;
        let mut table = [zero; MAX_POINTS - 1];
        for i in 0..n {
            table[i] = if values[i] == zero { zero } else { values[i] * w[i].powi(n as i32) };
        }
        for order in 1..n {
            for i in (order..n).rev() {
                let step = w[i] - w[i - order];
                table[i] = if step == zero { zero } else { (table[i] - table[i - 1]) / step };
            }
        }
        // Horner's rule from the Newton form to monomial coefficients.
        let mut coefficients = [zero; MAX_POINTS - 1];
        for i in (0..n).rev() {
            for j in (1..n).rev() {
                coefficients[j] = coefficients[j - 1] - w[i] * coefficients[j];
            }
            coefficients[0] = table[i] - w[i] * coefficients[0];
        }
        let terms = (0..n).map(|j| coefficients[j] * self.shifted[n - j]);
        terms.fold(zero, |sum, term| sum + term)
    }

    /// What a relative change of all moments does to [`Canonical::at_z_f`] at most, relative to it and per unit: at_z_f
    /// (sum |x_i| sqrt b_2i)^2 for the coefficients x of K(z_f, z), as |b_(i+j)| <= sqrt(b_2i b_2j).
    pub(crate) fn sensitivity<const M: usize>(&self, moments: &[R; M], z_f: f64) -> f64 {
        if M == 2 {
            // x = (1 - b_1 p / d, p / d) for p = z_f - b_1, at_z_f = d / (d + p^2), and b_1^2 = b_2 - d.
            return 6.0 * moments[1].to_f64() / self.pivots[1].to_f64();
        }
        let mut q = [0.0; MAX_POINTS];
        for (row, pivot) in self.taylor.iter().zip(&self.pivots).take(self.count + 1) {
            let factor = (row[0] / *pivot).to_f64();
            q.iter_mut().zip(row).for_each(|(q, c)| *q += factor * c.to_f64());
        }
        // From powers of z - z_f to powers of z, in absolute values.
        let mut x = q.map(f64::abs);
        for start in 0..self.count {
            for i in (start..self.count).rev() {
                x[i] += z_f.abs() * x[i + 1];
            }
        }
        let size = |i: usize| if i == 0 { 1.0 } else { moments[2 * i - 1].to_f64().abs().sqrt() };
        self.at_z_f.to_f64() * (0..=self.count).map(|i| x[i] * size(i)).sum::<f64>().powi(2)
    }

    /// Support points with weights, z_f first; a point at infinity (w = 0, weight 0) is left out.
    pub(crate) fn points(&self, z_f: R) -> Vec<(R, R)> {
        let mut points = vec![(z_f, self.at_z_f)];
        for i in 0..self.count {
            let w = self.inverse_offsets[i];
            if w != R::zero() {
                let mut indicator = [R::zero(); MAX_POINTS - 1];
                indicator[i] = R::one();
                points.push((z_f + R::one() / w, self.expectation(indicator)));
            }
        }
        points
    }

    /// The weight of the point z_f + 1 / w: its Christoffel number 1 / K(z, z), a sum of squares in which nothing
    /// cancels, whereas weights from the moments lose all digits where a point is close to z_f.
    pub(crate) fn christoffel(&self, w: R) -> R {
        let n = self.count;
        let is_near = w.abs() >= R::one();
        let u = R::one() / w;
        let mut sum = R::zero();
        // Where d_n vanishes the points are the roots of P_n.
        let terms = if self.singular.is_some() { n } else { n + 1 };
        for (row, &pivot) in self.taylor.iter().zip(&self.pivots).take(terms) {
            // P_k(z_f + u), or w^n times it where u is large.
            let value = if is_near {
                row[..=n].iter().rev().fold(R::zero(), |value, &c| value * u + c)
            } else {
                row[..=n].iter().fold(R::zero(), |value, &c| value * w + c)
            };
            sum = sum + value * value / pivot;
        }
        let weight = R::one() / sum;
        if is_near { weight } else { weight * w.powi(2 * n as i32) }
    }

    /// The two bounds.
    pub(crate) fn bounds(&self) -> Pair<R> {
        let zero = R::zero();
        let (mut front, mut behind) = (zero, zero);
        for &w in &self.inverse_offsets[..self.count] {
            if w < zero {
                front = front + self.christoffel(w);
            } else if w > zero {
                behind = behind + self.christoffel(w);
            }
        }
        // All weights sum to 1, but for the rounding of the points.
        let total = front + self.at_z_f + behind;
        let lower = (front / total).min(self.mass_before());
        Pair::clamped(lower, R::one() - behind / total)
    }

    /// The mass in front of z_f from the moments: the expectation of the polynomial in u = z - z_f that is 1 at the
    /// points in front and 0 at the others, by Newton's divided differences (BHS16 section 2.5).
    fn mass_before(&self) -> R {
        let (zero, one) = (R::zero(), R::one());
        // Ascending in u: points in front have w < 0, the nearest the largest |w|; then z_f; then those behind.
        let mut nodes = [zero; MAX_POINTS];
        let mut table = [zero; MAX_POINTS];
        let mut count = 0;
        let w = &self.inverse_offsets[..self.count];
        let infinite = R::from_f64(R::TINY);
        for &w in w.iter().rev().filter(|w| **w < -infinite) {
            nodes[count] = one / w;
            table[count] = one;
            count += 1;
        }
        count += 1;
        for &w in w.iter().rev().filter(|w| **w > infinite) {
            nodes[count] = one / w;
            count += 1;
        }
        for order in 1..count {
            for i in (order..count).rev() {
                let step = nodes[i] - nodes[i - order];
                table[i] = if step == zero { zero } else { (table[i] - table[i - 1]) / step };
            }
        }
        // Horner's rule from the Newton form to monomial coefficients, times the moments about z_f.
        let mut coefficients = [zero; MAX_POINTS];
        for i in (0..count).rev() {
            for j in (1..count).rev() {
                coefficients[j] = coefficients[j - 1] - nodes[i] * coefficients[j];
            }
            coefficients[0] = table[i] - nodes[i] * coefficients[0];
        }
        let terms = coefficients.iter().zip(&self.shifted).take(count);
        terms.fold(zero, |sum, (&c, &moment)| sum + c * moment)
    }
}
