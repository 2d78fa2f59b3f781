//! The exact bound of a known distribution, from its depths and not from its moments: moments to 32 digits do not
//! tell apart the depths of a thin surface.
//!
//! On the line the bound is attained by Gauss' quadrature with a node at z_f. Orthogonal polynomials by Stieltjes'
//! procedure, in depths relative to z_f; the matrix of their recurrence, its last entry changed so that z_f becomes an
//! eigenvalue; nodes by Sturm sequences and bisection; the weight of a node is the reciprocal of the sum of squares of
//! the orthonormal polynomials there. This shares no step with the closed forms. On \[0, 1\] the case with both ends takes
//! expectations over the depths; trigonometric bounds are the closed form, where 32 digits of the moments suffice.

use super::input::{Input, Moments};
use moment_problem::MomentBound;
use moment_problem::arithmetic::{DoubleDouble, Real};

type Wide = DoubleDouble;

/// Most orthogonal polynomials.
const MAX_DEGREE: usize = 4;

/// Halvings of a node's bracket, in logarithms: to the last place of double precision.
const HALVINGS: usize = 64;

/// Newton steps in double-double after that.
const NEWTON_STEPS: usize = 2;

/// Nodes nearer to z_f than this are z_f; further away than the reciprocal they are at infinity.
const NEAREST: f64 = 1e-40;

/// Trigonometric bounds that move by more than this when their moments move by [`NUDGE`] are not known: a thousandth of
/// the least excess that is counted.
const KNOWN: f64 = 1e-9;

/// Some hundred roundings of double-double, as many as moments go through.
const NUDGE: f64 = 1e-29;

/// A Newton step of more than this part of a node's distance is no polish: bisection is good to 1e-14.
const POLISH: f64 = 1e-6;

/// The exact lower bound of the distribution's moments at z_f; `None` where 32 digits do not suffice.
pub(crate) fn lower(bound: MomentBound, input: &Input, moments: &Moments<Wide>) -> Option<f64> {
    if input.distinct_depths() <= bound.determined_depths() {
        return Some(input.mass_before());
    }
    match bound {
        MomentBound::Trigonometric4 => trigonometric(input, moments),
        MomentBound::Hausdorff4 => Some(hausdorff(input)),
        MomentBound::Hamburger2
        | MomentBound::Hamburger4
        | MomentBound::Hamburger6
        | MomentBound::Hamburger8 => {
            let polynomials = Polynomials::new(&centred(input), bound.order() / 2);
            Some(polynomials.weight_before().to_f64().clamp(0.0, 1.0))
        }
    }
}

/// The smallest pivot of B = L D L^T, for moments of 2 z - 1.
pub(crate) fn smallest_pivot(input: &Input, order: usize) -> f64 {
    let degree = order / 2;
    if input.distinct_depths() <= degree {
        return 0.0;
    }
    let polynomials = Polynomials::new(&centred(input), degree);
    // The pivots are the squared norms of the monic polynomials; doubling depths multiplies them by 4^k.
    (1..=degree).map(|k| polynomials.norms[k].to_f64() * 4f64.powi(k as i32)).fold(f64::INFINITY, f64::min)
}

/// Depths relative to z_f, with weights.
fn centred(input: &Input) -> Vec<(Wide, Wide)> {
    let z_f = Wide::from(input.z_f);
    input.atoms.iter().map(|&(z, w)| (Wide::from(z) - z_f, Wide::from(w))).collect()
}

fn trigonometric(input: &Input, moments: &Moments<Wide>) -> Option<f64> {
    let z_f = Wide::from(input.z_f);
    let at = |factor: f64| {
        let scale = Wide::from(1.0) + Wide::from(factor);
        MomentBound::Trigonometric4.bounds(&moments.waves.map(|b| b * scale), z_f).lower.to_f64()
    };
    let value = at(0.0);
    ([NUDGE, -NUDGE].iter().all(|&nudge| (at(nudge) - value).abs() < KNOWN)).then_some(value)
}

/// As on the line if all nodes lie in \[0, 1\], else with nodes 0, z_f, t and 1.
fn hausdorff(input: &Input) -> f64 {
    let polynomials = Polynomials::new(&centred(input), 2);
    let z_f = Wide::from(input.z_f);
    let one = Wide::from(1.0);
    let nodes = polynomials.nodes_below(f64::INFINITY);
    let inside =
        polynomials.nodes_below(-input.z_f) == 0 && polynomials.nodes_below(1.0 - input.z_f) == nodes;
    if inside || input.z_f <= 0.0 || input.z_f >= 1.0 {
        return polynomials.weight_before().to_f64().clamp(0.0, 1.0);
    }
    let mean = |of: &dyn Fn(Wide) -> Wide| {
        let terms = input.atoms.iter().map(|&(z, w)| of(Wide::from(z)) * Wide::from(w));
        terms.fold(Wide::zero(), |sum, term| sum + term)
    };
    let first = mean(&|z| z * (one - z) * (z - z_f));
    let second = mean(&|z| z * z * (one - z) * (z - z_f));
    let t = if first == Wide::zero() { one } else { (second / first).max(Wide::zero()).min(one) };
    let ratio = |numerator: Wide, divisor: Wide| {
        if divisor == Wide::zero() { Wide::zero() } else { numerator / divisor }
    };
    let lower = if t < z_f {
        let at_z_f = ratio(mean(&|z| z * (one - z) * (z - t)), z_f * (one - z_f) * (z_f - t));
        let at_one = ratio(mean(&|z| z * (z - z_f) * (z - t)), (one - z_f) * (one - t));
        one - at_z_f - at_one
    } else {
        ratio(mean(&|z| (one - z) * (z - z_f) * (z - t)), z_f * t)
    };
    lower.to_f64().clamp(0.0, 1.0)
}

/// Monic orthogonal polynomials of degrees 0 to n in u = z - z_f, and the recurrence
/// P_(k+1) = (u - a_k) P_k - b_k P_(k-1) with a_n chosen so that P_(n+1) vanishes at z_f.
pub(crate) struct Polynomials {
    degree: usize,
    a: [Wide; MAX_DEGREE + 1],
    b: [Wide; MAX_DEGREE + 1],
    norms: [Wide; MAX_DEGREE + 1],
    /// a_n, infinite where P_n vanishes at z_f.
    last: f64,
}

impl Polynomials {
    /// Stieltjes' procedure; the distribution has more than `degree` depths.
    pub(crate) fn new(atoms: &[(Wide, Wide)], degree: usize) -> Self {
        const ROWS: usize = MAX_DEGREE + 1;
        let zero = Wide::zero();
        let (a, b, norms) = ([zero; ROWS], [zero; ROWS], [Wide::from(1.0); ROWS]);
        let mut result = Self { degree, a, b, norms, last: 0.0 };
        let mut before = vec![zero; atoms.len()];
        let mut values = vec![Wide::from(1.0); atoms.len()];
        for k in 0..=degree {
            let (mut norm, mut mean) = (zero, zero);
            for (&(u, w), &value) in atoms.iter().zip(&values) {
                let square = w * value * value;
                norm = norm + square;
                mean = mean + square * u;
            }
            result.norms[k] = norm;
            result.b[k] = if k > 0 { norm / result.norms[k - 1] } else { zero };
            result.a[k] = mean / norm;
            for ((&(u, _), value), earlier) in atoms.iter().zip(&mut values).zip(&mut before) {
                let next = (u - result.a[k]) * *value - result.b[k] * *earlier;
                *earlier = std::mem::replace(value, next);
            }
        }
        let at_z_f = result.values(zero);
        let below = if degree > 0 { at_z_f[degree - 1] } else { zero };
        let last = (-(result.b[degree] * below) / at_z_f[degree]).to_f64();
        result.last = if last.is_finite() { last } else { f64::INFINITY };
        result
    }

    /// P_0 to P_n at u.
    pub(crate) fn values(&self, u: Wide) -> [Wide; MAX_DEGREE + 1] {
        let mut values = [Wide::from(1.0); MAX_DEGREE + 1];
        for k in 0..self.degree {
            let before = if k > 0 { values[k - 1] } else { Wide::zero() };
            values[k + 1] = (u - self.a[k]) * values[k] - self.b[k] * before;
        }
        values
    }

    /// Number of nodes below u, by Sturm's sequence; z_f itself is one of all.
    fn nodes_below(&self, u: f64) -> usize {
        self.negative_pivots(u, self.degree + 1)
    }

    /// Negative pivots among the first ones of the recurrence's matrix minus u.
    fn negative_pivots(&self, u: f64, rows: usize) -> usize {
        let mut count = 0;
        let mut q = 1.0;
        for k in 0..rows {
            let diagonal = if k == self.degree { self.last } else { self.a[k].to_f64() };
            if diagonal == f64::INFINITY {
                break;
            }
            let coupling = if k > 0 { self.b[k].to_f64() } else { 0.0 };
            q = if u == f64::INFINITY { -1.0 } else { diagonal - u - coupling / q };
            if q == 0.0 {
                q = f64::MIN_POSITIVE;
            }
            count += usize::from(q < 0.0);
        }
        count
    }

    /// Sum of the weights of all nodes in front of z_f.
    fn weight_before(&self) -> Wide {
        // At z_f the last pivot is zero, whatever its rounding says.
        let front = self.negative_pivots(0.0, self.degree);
        (0..front).fold(Wide::zero(), |sum, index| sum + self.weight(self.node(index)))
    }

    /// The node in front of z_f that has so many below it.
    fn node(&self, index: usize) -> Wide {
        // u = -e^t descends as t grows.
        let (mut near, mut far) = (NEAREST.ln(), -NEAREST.ln());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            if self.nodes_below(-middle.exp()) > index { near = middle } else { far = middle }
        }
        let mut u = Wide::from(-(0.5 * (near + far)).exp());
        let at_z_f = self.values(Wide::zero());
        for _ in 0..NEWTON_STEPS {
            // K(z_f, u) and its slope.
            let (mut value, mut slope) = (Wide::zero(), Wide::zero());
            let mut p = [Wide::from(1.0), Wide::zero()];
            let mut d = [Wide::zero(); 2];
            for (k, &at_z_f) in at_z_f.iter().enumerate().take(self.degree + 1) {
                let factor = at_z_f / self.norms[k];
                value = value + factor * p[0];
                slope = slope + factor * d[0];
                let next = (u - self.a[k]) * p[0] - self.b[k] * p[1];
                let next_slope = p[0] + (u - self.a[k]) * d[0] - self.b[k] * d[1];
                (p, d) = ([next, p[0]], [next_slope, d[0]]);
            }
            let step = value / slope;
            // Newton's method only polishes: a large step, or none, would leave for another node.
            if step.abs().to_f64() <= POLISH * u.abs().to_f64() {
                u = u - step;
            }
        }
        u
    }

    fn weight(&self, u: Wide) -> Wide {
        let values = self.values(u);
        let terms = (0..=self.degree).map(|k| values[k] * values[k] / self.norms[k]);
        Wide::from(1.0) / terms.fold(Wide::zero(), |sum, term| sum + term)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    /// On inputs that 32 digits resolve, quadrature from the depths agrees with the closed forms from the moments.
    #[test]
    fn quadrature_agrees_with_the_closed_forms() {
        let mut random = Random::substream(3, 0, 0);
        for _ in 0..400 {
            let count = 6 + (4.0 * random.unit()) as usize;
            let spread = 10f64.powf(-2.0 * random.unit());
            let atoms: Vec<(f64, f64)> = (0..count)
                .map(|i| (if i % 2 == 0 { 0.3 } else { 0.6 } + spread * 0.3 * random.unit(), random.unit()))
                .collect();
            let input = Input::new(atoms, 0.2 + 0.6 * random.unit());
            let moments = Moments::exact(&input);
            for bound in [
                MomentBound::Hamburger2,
                MomentBound::Hamburger4,
                MomentBound::Hamburger6,
                MomentBound::Hamburger8,
                MomentBound::Hausdorff4,
            ] {
                let quadrature = lower(bound, &input, &moments).unwrap();
                let closed = bound.bounds(&moments.unit, Wide::from(input.z_f)).lower.to_f64();
                assert!((quadrature - closed).abs() < 1e-9, "{bound:?} {input:?}: {quadrature} {closed}");
                assert!(quadrature <= input.mass_before() + 1e-12);
            }
        }
    }

    #[test]
    fn the_smallest_pivot_is_that_of_the_matrix() {
        // Equal masses at -1, 0 and 1: b_2 = b_4 = 2/3, so D = (1, 2/3, 2/3 - 4/9).
        let third = 1.0 / 3.0;
        let input = Input::new(vec![(0.0, third), (0.5, third), (1.0, third)], 0.25);
        assert!((smallest_pivot(&input, 4) - 2.0 / 9.0).abs() < 1e-12);
        assert_eq!(smallest_pivot(&input, 6), 0.0);
    }
}
