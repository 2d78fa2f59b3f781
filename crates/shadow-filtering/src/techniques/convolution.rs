//! Convolution shadow maps: a truncated Fourier series of the shadow test (MSM15 section 2, after Annen et al. 2007),
//! biased to a lower bound.
//!
//! The square wave of half-period P gives \[t > 0\] ~ p(t) = 1/2 + 2/pi sum_k a_k sin(c_k t) / (2 k - 1) with
//! c_k = pi (2 k - 1) / P, k = 1..M, for t = z_f - z in (-P, P). The factors a_k = e^(-d (k/M)^2) damp the ringing as
//! Annen et al. do. sin(c_k (z_f - z)) expands into products of a function of z_f and one of z, so cos(c_k z) and
//! sin(c_k z) are stored: 2 M channels.
//!
//! Lower bound: q(t) = (p(t - delta) - low) / (high - low), with low the maximum of p(t - delta) over t <= 0 and high
//! that over all t, stays below \[t > 0\] everywhere, hence E\[q(z_f - z)\] <= F_Z(z_f). P = 1 + 2 delta keeps the
//! falling edge of the wave out of reach. Damping and delta are those of least area between q and the test over t in
//! \[-1, 1\], because ringing below 0 behind the receiver costs as much as a soft edge in front of it.
//!
//! Where no lower bound is wanted, `fourier` takes the series as it is published: no damping, delta = 0, P = 1, and p itself.

use super::{Parts, count_of};
use crate::basis::DepthBasis;
use crate::bound::ShadowBound;
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use crate::wgsl;
use moment_problem::arithmetic::Real;
use std::f64::consts::PI;

/// Most coefficients accepted.
const MAX_COEFFICIENTS: usize = 64;

/// Nodes per shortest wavelength at which the extrema of p are sought: when choosing constants, and for the chosen.
const NODES_PER_WAVE: (usize, usize) = (8, 64);

/// M Fourier coefficients (pairs) on \[0, 1\].
#[derive(Clone)]
struct Convolution {
    /// c_1; c_k = (2 k - 1) c_1.
    frequency: f64,
    /// Amplitudes 2/pi a_k / (2 k - 1).
    amplitudes: Vec<f64>,
    delta: f64,
    low: f64,
    high: f64,
    is_lower_bound: bool,
}

impl Convolution {
    /// The truncated series itself, which rings to both sides of the shadow test.
    fn series_itself(coefficients: usize) -> Self {
        let amplitudes = (1..=coefficients).map(|k| 2.0 / PI / (2 * k - 1) as f64).collect();
        Self { frequency: PI, amplitudes, delta: 0.0, low: 0.0, high: 1.0, is_lower_bound: false }
    }

    /// The damping and delta of least area; M is 1 to [`MAX_COEFFICIENTS`].
    fn new(coefficients: usize) -> Option<Self> {
        let mut best: Option<(f64, Self)> = None;
        for damping in [0.0, 0.5, 1.0, 2.0, 3.0] {
            for step in 1..=16 {
                // The transition is about P / (2 M) wide.
                let delta = f64::from(step) / (8 * coefficients) as f64;
                let candidate = Self::with(coefficients, damping, delta);
                let area = candidate.area();
                if best.as_ref().is_none_or(|(least, _)| area < *least) {
                    best = Some((area, candidate));
                }
            }
        }
        let (_, mut technique) = best?;
        (technique.low, technique.high) = technique.extrema(NODES_PER_WAVE.1);
        Some(technique)
    }

    fn with(coefficients: usize, damping: f64, delta: f64) -> Self {
        let half_period = 1.0 + 2.0 * delta;
        let amplitudes = (1..=coefficients).map(|k| {
            let share = k as f64 / coefficients as f64;
            2.0 / PI * (-damping * share * share).exp() / (2 * k - 1) as f64
        });
        let mut technique = Self {
            frequency: PI / half_period,
            amplitudes: amplitudes.collect(),
            delta,
            low: 0.0,
            high: 1.0,
            is_lower_bound: true,
        };
        (technique.low, technique.high) = technique.extrema(NODES_PER_WAVE.0);
        technique
    }

    /// p(t).
    fn series(&self, t: f64) -> f64 {
        let mut sum = 0.5;
        odd_multiples(self.frequency * t, self.amplitudes.len(), |k, _, sine| {
            sum += self.amplitudes[k] * sine
        });
        sum
    }

    /// Upper bounds of p(t - delta) over t in \[-1, 0\] and over \[-1, 1\].
    fn extrema(&self, nodes_per_wave: usize) -> (f64, f64) {
        let nodes = 2 * nodes_per_wave * self.amplitudes.len();
        let step = 1.0 / nodes as f64;
        let frequencies = (0..self.amplitudes.len()).map(|k| (2 * k + 1) as f64 * self.frequency);
        let curvature: f64 = frequencies.zip(&self.amplitudes).map(|(c, a)| a * c * c).sum();
        // A maximum within half a step of a node exceeds it by no more than this.
        let between = curvature * step * step / 8.0;
        let largest = |from: isize, to: isize| {
            let values = (from..=to).map(|i| self.series(i as f64 * step - self.delta));
            values.fold(f64::NEG_INFINITY, f64::max) + between
        };
        let nodes = nodes as isize;
        let low = largest(-nodes, 0);
        (low, low.max(largest(0, nodes)))
    }

    /// Area between the test and q over t in \[-1, 1\]; q is never above the test.
    fn area(&self) -> f64 {
        if self.high <= self.low {
            return f64::INFINITY;
        }
        let cells = 32 * self.amplitudes.len();
        let missing = (0..2 * cells).map(|i| {
            let t = (i as f64 + 0.5) / cells as f64 - 1.0;
            (if t > 0.0 { 1.0 } else { 0.0 }) - self.response(t)
        });
        missing.sum::<f64>() / cells as f64
    }

    /// q(t): the weight with which a texel at depth z_f - t shadows, possibly negative.
    fn response(&self, t: f64) -> f64 {
        (self.series(t - self.delta) - self.low) / (self.high - self.low)
    }
}

impl DepthBasis for Convolution {
    fn channels(&self) -> usize {
        2 * self.amplitudes.len()
    }

    fn evaluate<R: Real>(&self, z: R, out: &mut [R]) {
        odd_multiples(R::from_f64(self.frequency) * z, self.amplitudes.len(), |k, cosine, sine| {
            (out[2 * k], out[2 * k + 1]) = (cosine, sine);
        });
    }
}

impl ShadowBound for Convolution {
    fn name(&self) -> String {
        let name = if self.is_lower_bound { "CSM" } else { "Fourier series" };
        format!("{name}, M = {}", self.amplitudes.len())
    }

    fn shade<R: Real>(&self, b: &[R], z_f: R) -> R {
        let mut sum = R::from_f64(0.5);
        let angle = R::from_f64(self.frequency) * (z_f - R::from_f64(self.delta));
        odd_multiples(angle, self.amplitudes.len(), |k, cosine, sine| {
            let wave = sine * b[2 * k] - cosine * b[2 * k + 1];
            sum = sum + R::from_f64(self.amplitudes[k]) * wave;
        });
        ((sum - R::from_f64(self.low)) / R::from_f64(self.high - self.low)).clamp_unit()
    }

    fn is_lower_bound(&self) -> bool {
        self.is_lower_bound
    }

    fn shader(&self) -> Option<String> {
        wgsl::convolution(self.frequency, self.delta, [self.low, self.high], &self.amplitudes)
    }
}

/// Calls `each` with k, cos and sin of (2 k + 1) x.
fn odd_multiples<R: Real>(x: R, count: usize, mut each: impl FnMut(usize, R, R)) {
    let (mut sine, mut cosine) = (x.sin(), x.cos());
    let (sine2, cosine2) = ((x + x).sin(), (x + x).cos());
    for k in 0..count {
        each(k, cosine, sine);
        (cosine, sine) = (cosine * cosine2 - sine * sine2, sine * cosine2 + cosine * sine2);
    }
}

/// `coefficients` is M, 1 to 64.
pub(crate) fn parts(spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let coefficients = count_of("coefficients", spec.coefficients, MAX_COEFFICIENTS)?;
    let convolution = Convolution::new(coefficients).ok_or_else(|| {
        FilteringError::parameter("coefficients", coefficients, "leave nothing to choose from")
    })?;
    Ok(Parts::new(convolution.clone(), convolution))
}

/// The same for the series itself.
pub(crate) fn series_parts(spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
    let coefficients = count_of("coefficients", spec.coefficients, MAX_COEFFICIENTS)?;
    let series = Convolution::series_itself(coefficients);
    Ok(Parts::new(series.clone(), series))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth_map::DepthMap;
    use crate::kernel::Kernel;
    use crate::regions::{encode, filter};

    #[test]
    fn convolution_shadow_maps_are_the_filtered_response_and_tend_to_the_shadow_test() {
        let kernel = Kernel::gaussian(9, 2.4).unwrap();
        // Leaves of many depths over tilted ground.
        let depth = |t: usize| match t * 7 % 10 {
            leaf @ 0..4 => 0.3 + 0.05 * leaf as f32,
            _ => 0.8 + 0.002 * (t % 48) as f32,
        };
        let map = &DepthMap::new(48, 48, (0..48 * 48).map(depth).collect()).unwrap();
        for coefficients in [1, 4, 16] {
            let csm = Convolution::new(coefficients).unwrap();
            let technique =
                TechniqueSpec { coefficients: Some(coefficients), ..TechniqueSpec::named("csm").unwrap() };
            let technique = technique.build().unwrap();
            let filtered = filter(&encode::<f64>(map, &technique).unwrap(), &kernel);
            let z = kernel.distribution(map, 20, 30);
            for i in 0..=50 {
                let z_f = f64::from(i) / 50.0;
                let atoms = z.depths().iter().zip(z.weights());
                let expected: f64 = atoms.map(|(&depth, &w)| w.to_f64() * csm.response(z_f - depth)).sum();
                let g = technique.shade(filtered.texel(20, 30), z_f).unwrap();
                assert!((g - expected.clamp(0.0, 1.0)).abs() < 1e-12, "{g} and {expected}");
            }
            // Below the test everywhere, between the nodes of the search too.
            for i in -50_000..=50_000 {
                let t = f64::from(i) / 50_000.0;
                assert!(csm.response(t) <= if t > 0.0 { 1.0 } else { 0.0 }, "{coefficients} at {t}");
            }
        }
        // The series itself overshoots by Gibbs's 9 % and is exact halfway.
        let series = Convolution::series_itself(16);
        let most = (0..1000).map(|i| series.response(f64::from(i) / 1000.0)).fold(0.0, f64::max);
        assert!((most - 1.0895).abs() < 1e-3 && (series.response(0.0) - 0.5).abs() < 1e-15, "{most}");
        let fine = Convolution::new(64).unwrap();
        for i in 1..20 {
            let t = f64::from(i) / 20.0;
            assert!(fine.response(t) > 0.98, "{t}: {}", fine.response(t));
            assert!(fine.response(-t).abs() < 0.02, "-{t}: {}", fine.response(-t));
        }
    }
}
