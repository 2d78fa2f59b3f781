//! Fourier opacity maps (Jansen and Bavoil 2010): absorption along a ray as a truncated Fourier series on \[0, 1\].

use std::f64::consts::TAU;

use super::Layer;

/// Coefficients of the absorption -ln(1 - alpha) by depth: a_0 and pairs a_k, b_k. They are linear, so that filtering
/// averages absorptions, and with them the logarithms of transmittances.
#[derive(Clone, Debug, PartialEq)]
pub struct FourierOpacity {
    /// a_0, then a_1, b_1, a_2, b_2, ...
    coefficients: Vec<f64>,
}

impl FourierOpacity {
    /// Of weighted rays, with `pairs` pairs. `None` if a layer is opaque, whose absorption is infinite.
    pub fn new(rays: &[(f64, &[Layer])], pairs: usize) -> Option<Self> {
        let mut coefficients = vec![0.0; 1 + 2 * pairs];
        let mut own = coefficients.clone();
        for &(weight, layers) in rays {
            for layer in layers {
                let absorption = -(-layer.opacity()).ln_1p();
                if !absorption.is_finite() {
                    return None;
                }
                Self::coefficients_of(layer.depth(), weight * absorption, &mut own);
                coefficients.iter_mut().zip(&own).for_each(|(sum, value)| *sum += value);
            }
        }
        Some(Self { coefficients })
    }

    /// What an absorption at one depth adds to the coefficients, an odd number of them.
    pub fn coefficients_of(depth: f64, absorption: f64, out: &mut [f64]) {
        out[0] = 2.0 * absorption;
        for (k, pair) in (1..).zip(out[1..].chunks_exact_mut(2)) {
            let (sine, cosine) = (TAU * f64::from(k) * depth).sin_cos();
            pair[0] = 2.0 * absorption * cosine;
            pair[1] = 2.0 * absorption * sine;
        }
    }

    /// From coefficients, as filtering leaves them.
    pub fn of_coefficients(coefficients: Vec<f64>) -> Self {
        Self { coefficients }
    }

    /// The absorption up to a depth, which may be negative where the series rings.
    pub fn absorption(&self, z: f64) -> f64 {
        let mut sum = 0.5 * self.coefficients[0] * z;
        for (k, pair) in (1..).zip(self.coefficients[1..].chunks_exact(2)) {
            let frequency = TAU * f64::from(k);
            let (sine, cosine) = (frequency * z).sin_cos();
            sum += (pair[0] * sine + pair[1] * (1.0 - cosine)) / frequency;
        }
        sum
    }

    /// The shadow 1 - e^(-absorption), not clamped.
    pub fn shadow(&self, z: f64) -> f64 {
        1.0 - (-self.absorption(z)).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_pairs_converge_to_the_absorption() {
        let layers = [Layer::new(0.3, 0.4).unwrap(), Layer::new(0.6, 0.5).unwrap()];
        let exact = 1.0 - 0.6 * 0.5;
        for (pairs, tolerance) in [(7, 0.1), (64, 0.01), (1024, 1e-3)] {
            let found = FourierOpacity::new(&[(1.0, &layers)], pairs).unwrap();
            assert!((found.shadow(0.8) - exact).abs() < tolerance, "{pairs}: {}", found.shadow(0.8));
        }
        assert!(FourierOpacity::new(&[(1.0, &[Layer::new(0.5, 1.0).unwrap()])], 3).is_none());
    }
}
