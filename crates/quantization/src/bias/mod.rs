//! Biases: moments b become (1 - alpha) b + alpha b* (MSM15 section 4.2), which pulls vectors that rounding has thrown
//! out of the valid set back into it.

pub(crate) mod moment_matrix;

use crate::interval::DepthInterval;
use moment_matrix::MomentMatrix;
use moment_problem::Basis;
use nalgebra::DMatrix;

/// b* as the moments of a distribution Z* of depths.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// b*.
    pub moments: Vec<f64>,
    /// Depths of Z*.
    pub depths: Vec<f64>,
    /// Their weights, which sum to 1.
    pub weights: Vec<f64>,
}

impl Target {
    /// Moments of a distribution of depths.
    pub fn new(basis: &Basis, depths: &[f64], weights: &[f64]) -> Self {
        let mut moments = vec![0.0; basis.len()];
        for (&z, &weight) in depths.iter().zip(weights) {
            moments.iter_mut().zip(basis.evaluate(z)).for_each(|(sum, value)| *sum += weight * value);
        }
        Self { moments, depths: depths.to_vec(), weights: weights.to_vec() }
    }

    /// Half of the mass at each end of the interval: MSM15's b*, which raises det B fastest for kernels of m / 2
    /// surfaces, so that one more makes B regular.
    pub fn ends(basis: &Basis, interval: DepthInterval) -> Self {
        Self::new(basis, &[interval.start(), interval.end()], &[0.5, 0.5])
    }
}

/// Depths among which Z* is chosen.
const CANDIDATES: usize = 128;

/// Steps of the ascent; weights move by some 1 / steps in the end.
const ASCENT_STEPS: usize = 2000;

/// Weights below this are dropped from Z*.
const NO_WEIGHT: f64 = 1e-4;

/// The b* that raises det B fastest: Z* maximises the mean of ln det B((1 - alpha) b + alpha b*) over a workload.
///
/// MSM15 section 4.2 maximises the derivative of det B at alpha = 0, which is the same for vectors of m / 2 surfaces.
/// It vanishes for fewer surfaces, where one more does not make B regular; the logarithm at the alpha in use ranks
/// these too. The mean is concave in Z*; the weights climb by factors E\[phi^T B^-1 phi\], as for D-optimal designs.
/// Vectors whose B stays singular whatever is added are left out.
pub fn fastest(
    matrix: &MomentMatrix,
    basis: &Basis,
    interval: DepthInterval,
    workload: &[Vec<f64>],
    alpha: f64,
) -> Target {
    let depths: Vec<f64> =
        (0..=CANDIDATES).map(|i| interval.at(2.0 * i as f64 / CANDIDATES as f64 - 1.0)).collect();
    let functions: Vec<Vec<f64>> = depths.iter().map(|&z| matrix.functions(z)).collect();
    let mut weights = vec![1.0 / depths.len() as f64; depths.len()];
    let n = matrix.rows();
    for _ in 0..ASCENT_STEPS {
        let moments = Target::new(basis, &depths, &weights).moments;
        let mut sum = DMatrix::zeros(n, n);
        for b in workload {
            let biased = biased(b, &moments, alpha);
            let inverse = DMatrix::from_fn(n, n, |i, j| matrix.entry(&biased, i, j)).try_inverse();
            if let Some(inverse) = inverse.filter(|m| m.iter().all(|v| v.is_finite()) && m[(0, 0)] > 0.0) {
                sum += inverse;
            }
        }
        let slope = |phi: &Vec<f64>| -> f64 {
            let terms = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            terms.map(|(i, j)| phi[i] * sum[(i, j)] * phi[j]).sum::<f64>().max(0.0)
        };
        let slopes: Vec<f64> = functions.iter().map(slope).collect();
        let mean: f64 = slopes.iter().zip(&weights).map(|(s, w)| s * w).sum();
        if mean.is_nan() || mean <= 0.0 {
            break;
        }
        weights.iter_mut().zip(&slopes).for_each(|(w, s)| *w *= s / mean);
    }
    let kept: Vec<usize> = (0..depths.len()).filter(|&i| weights[i] > NO_WEIGHT).collect();
    let total: f64 = kept.iter().map(|&i| weights[i]).sum();
    let depths: Vec<f64> = kept.iter().map(|&i| depths[i]).collect();
    let weights: Vec<f64> = kept.iter().map(|&i| weights[i] / total).collect();
    Target::new(basis, &depths, &weights)
}

/// (1 - alpha) b + alpha b*.
pub fn biased(b: &[f64], target: &[f64], alpha: f64) -> Vec<f64> {
    b.iter().zip(target).map(|(b, t)| (1.0 - alpha) * b + alpha * t).collect()
}

/// Halvings of the bracket of ln alpha: below the rounding of alpha itself.
const HALVINGS: usize = 60;

/// Least alpha that is told from 0: rounding in double precision moves vectors by about as much.
pub const SMALLEST_ALPHA: f64 = 1e-15;

/// The smallest alpha for which the biased vector is valid; 0 if it is valid as it stands, 1 if no alpha below 1 helps.
/// The valid set is convex and holds b*, so that every larger alpha is valid too.
pub fn smallest_alpha(matrix: &MomentMatrix, b: &[f64], target: &[f64]) -> f64 {
    if matrix.is_valid(b) {
        return 0.0;
    }
    let valid = |alpha: f64| matrix.is_valid(&biased(b, target, alpha));
    let (mut low, mut high) = (SMALLEST_ALPHA.ln(), 0.0f64);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if valid(middle.exp()) { high = middle } else { low = middle }
    }
    high.exp()
}

/// A bias that is in use somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circulated {
    /// Basis, as on the command line.
    pub basis: &'static str,
    /// Depths from -1 to 1, else from 0 to 1.
    pub signed: bool,
    /// Format, as in experiments.
    pub format: &'static str,
    /// alpha.
    pub alpha: f64,
    /// b*.
    pub target: &'static [f64],
    /// Where it stands; `in circulation` for values of public implementations without a publication.
    pub source: &'static str,
}

/// Biases in circulation, for comparison.
pub const CIRCULATED: [Circulated; 12] = [
    Circulated {
        basis: "power:4",
        signed: false,
        format: "f32",
        alpha: 2e-6,
        target: &[0.5, 0.5, 0.5, 0.5],
        source: "MSM15 section 4.2",
    },
    Circulated {
        basis: "power:4",
        signed: false,
        format: "unorm16",
        alpha: 3e-5,
        target: &[0.5, 0.5, 0.5, 0.5],
        source: "MSM15 section 4.3",
    },
    Circulated {
        basis: "power:4",
        signed: false,
        format: "u32/256",
        alpha: 5e-6,
        target: &[0.5, 0.5, 0.5, 0.5],
        source: "BHS16 section 3.5",
    },
    Circulated {
        basis: "power:4",
        signed: true,
        format: "f32",
        alpha: 5e-7,
        target: &[0.0, 0.375, 0.0, 0.375],
        source: "in circulation",
    },
    Circulated {
        basis: "power:4",
        signed: true,
        format: "unorm16",
        alpha: 6e-5,
        target: &[0.0, 0.628, 0.0, 0.628],
        source: "GDC16, with another digit in circulation",
    },
    Circulated {
        basis: "power:6",
        signed: true,
        format: "f32",
        alpha: 5e-6,
        target: &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45],
        source: "in circulation",
    },
    Circulated {
        basis: "power:6",
        signed: true,
        format: "unorm16",
        alpha: 6e-4,
        target: &[0.0, 0.5566, 0.0, 0.489, 0.0, 0.47869],
        source: "in circulation",
    },
    Circulated {
        basis: "power:6",
        signed: true,
        format: "unorm10",
        alpha: 4e-3,
        target: &[0.0, 0.5566, 0.0, 0.489, 0.0, 0.47869],
        source: "BHS16 section 2.5, with the b* in circulation for 16 bits",
    },
    Circulated {
        basis: "power:8",
        signed: true,
        format: "f32",
        alpha: 5e-5,
        target: &[0.0, 0.75, 0.0, 0.676667, 0.0, 0.63, 0.0, 0.600303],
        source: "in circulation",
    },
    Circulated {
        basis: "power:8",
        signed: true,
        format: "unorm16",
        alpha: 2.5e-3,
        target: &[0.0, 0.424749, 0.0, 0.224078, 0.0, 0.153692, 0.0, 0.129004],
        source: "in circulation",
    },
    Circulated {
        basis: "trig:2",
        signed: false,
        format: "f32",
        alpha: 4e-7,
        target: &[0.0, 0.0, 0.0, 0.0],
        source: "in circulation",
    },
    Circulated {
        basis: "trig:2",
        signed: false,
        format: "unorm16",
        alpha: 4e-4,
        target: &[0.0, 0.0, 0.0, 0.0],
        source: "in circulation",
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    /// Vectors of kernels with so many surfaces, each with its mirror image.
    fn workload(basis: &Basis, surfaces: usize, count: usize, interval: DepthInterval) -> Vec<Vec<f64>> {
        let mut random = Random::stream(1, surfaces as u64);
        let mut vectors = Vec::new();
        for _ in 0..count {
            let t: Vec<f64> = (0..surfaces).map(|_| 2.0 * random.unit() - 1.0).collect();
            let weights: Vec<f64> = (0..surfaces).map(|_| 0.1 + random.unit()).collect();
            let total: f64 = weights.iter().sum();
            let weights: Vec<f64> = weights.iter().map(|w| w / total).collect();
            for sign in [1.0, -1.0] {
                let depths: Vec<f64> = t.iter().map(|&t| interval.at(sign * t)).collect();
                vectors.push(Target::new(basis, &depths, &weights).moments);
            }
        }
        vectors
    }

    #[test]
    fn two_surfaces_and_a_small_alpha_give_the_papers_vector() {
        let basis = Basis::power(4);
        let matrix = MomentMatrix::new(&basis).unwrap();
        let vectors = workload(&basis, 2, 400, DepthInterval::UNIT);
        let target = fastest(&matrix, &basis, DepthInterval::UNIT, &vectors, 1e-6);
        for moment in &target.moments {
            assert!((moment - 0.5).abs() < 2e-2, "{target:?}");
        }
        assert_eq!(Target::ends(&basis, DepthInterval::UNIT).moments, [0.5; 4]);
    }

    #[test]
    fn the_fastest_vector_beats_others() {
        let interval = DepthInterval::SIGNED;
        let basis = Basis::power(6);
        let matrix = MomentMatrix::new(&basis).unwrap();
        let vectors = workload(&basis, 2, 60, interval);
        let alpha = 1e-3;
        let value = |target: &[f64]| -> f64 {
            vectors.iter().map(|b| matrix.ln_determinant(&biased(b, target, alpha))).sum()
        };
        let best = fastest(&matrix, &basis, interval, &vectors, alpha);
        assert!((best.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let best_value = value(&best.moments);
        for circulated in CIRCULATED.iter().filter(|c| c.basis == "power:6") {
            assert!(value(circulated.target) < best_value + 1e-6, "{circulated:?}");
        }
        let mut random = Random::stream(5, 0);
        for _ in 0..50 {
            let depths: Vec<f64> = (0..5).map(|_| 2.0 * random.unit() - 1.0).collect();
            assert!(value(&Target::new(&basis, &depths, &[0.2; 5]).moments) < best_value);
        }
    }

    #[test]
    fn the_smallest_alpha_is_where_validity_begins() {
        let basis = Basis::power(2);
        let matrix = MomentMatrix::new(&basis).unwrap();
        let target = Target::ends(&basis, DepthInterval::UNIT).moments;
        assert_eq!(smallest_alpha(&matrix, &[0.5, 0.3], &target), 0.0);
        // Variance -0.01 at mean 1/2: the biased variance is -0.01 (1 - alpha) + 0.25 alpha.
        let alpha = smallest_alpha(&matrix, &[0.5, 0.24], &target);
        assert!((alpha - 0.01 / 0.26).abs() < 1e-12, "{alpha}");
        let b = [0.5, 0.24];
        assert!(matrix.is_valid(&biased(&b, &target, alpha * (1.0 + 1e-9))));
        assert!(!matrix.is_valid(&biased(&b, &target, alpha * (1.0 - 1e-9))));
        // A target on the wrong side never helps.
        assert_eq!(smallest_alpha(&matrix, &b, &[0.5, 0.25]), 1.0);
    }
}
