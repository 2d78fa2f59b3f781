//! Separable filter kernels of odd size.

use crate::depth_map::DepthMap;
use crate::error::FilteringError;
use moment_problem::DepthDistribution;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Largest accepted kernel size in texels.
pub const MAX_KERNEL_SIZE: usize = 129;

/// A kernel as written in an experiment.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
pub enum KernelSpec {
    /// Gaussian, sampled at texel centres.
    Gaussian {
        /// Size in texels, odd.
        size: usize,
        /// Standard deviation in texels.
        sigma: f64,
    },
    /// All texels alike.
    Box {
        /// Size in texels, odd.
        size: usize,
    },
    /// Rows of Pascal's triangle.
    Binomial {
        /// Size in texels, odd.
        size: usize,
    },
}

impl KernelSpec {
    /// The kernel.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] naming the size or sigma that makes no sense.
    pub fn build(&self) -> Result<Kernel, FilteringError> {
        match *self {
            Self::Gaussian { size, sigma } => Kernel::gaussian(size, sigma),
            Self::Box { size } => Kernel::uniform(size),
            Self::Binomial { size } => Kernel::binomial(size),
        }
    }
}

impl fmt::Display for KernelSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Gaussian { size, sigma } => write!(f, "gaussian:{size}:{sigma}"),
            Self::Box { size } => write!(f, "box:{size}"),
            Self::Binomial { size } => write!(f, "binomial:{size}"),
        }
    }
}

impl FromStr for KernelSpec {
    type Err = FilteringError;

    /// `gaussian:SIZE:SIGMA`, `box:SIZE` or `binomial:SIZE`, in texels; refuses kernels that cannot be built.
    fn from_str(text: &str) -> Result<Self, FilteringError> {
        let fail = || {
            let reason = "is none of gaussian:SIZE:SIGMA, box:SIZE and binomial:SIZE";
            FilteringError::parameter("kernel", text, reason)
        };
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let whole = |text: &str| text.parse::<usize>().map_err(|_| fail());
        let spec = match parts[..] {
            ["gaussian", size, sigma] => {
                Self::Gaussian { size: whole(size)?, sigma: sigma.parse().map_err(|_| fail())? }
            }
            ["box", size] => Self::Box { size: whole(size)? },
            ["binomial", size] => Self::Binomial { size: whole(size)? },
            _ => return Err(fail()),
        };
        spec.build().map(|_| spec)
    }
}

/// A separable kernel: the weight of the texel at offset (i, j) is w_i w_j; the w are symmetric and sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    weights: Vec<f64>,
}

impl Kernel {
    /// exp(-i^2 / (2 sigma^2)) at texel centres, divided by the sum. MSM15 section 3.2 uses size 9 and sigma 2.4.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for an even or too large size, or a sigma that is not positive and finite.
    pub fn gaussian(size: usize, sigma: f64) -> Result<Self, FilteringError> {
        let radius = radius_of(size)?;
        if !(sigma.is_finite() && sigma > 0.0) {
            return Err(FilteringError::parameter("sigma", sigma, "must be positive and finite, in texels"));
        }
        Ok(Self::normalised((0..size).map(|i| {
            let offset = i as f64 - radius as f64;
            (-0.5 * (offset / sigma).powi(2)).exp()
        })))
    }

    /// Equal weights.
    ///
    /// # Errors
    /// As [`Kernel::gaussian`] for the size.
    pub fn uniform(size: usize) -> Result<Self, FilteringError> {
        radius_of(size)?;
        Ok(Self::normalised((0..size).map(|_| 1.0)))
    }

    /// Binomial coefficients, a Gaussian of variance (size - 1) / 4 with exact weights.
    ///
    /// # Errors
    /// As [`Kernel::gaussian`] for the size.
    pub fn binomial(size: usize) -> Result<Self, FilteringError> {
        radius_of(size)?;
        let mut coefficient = 1.0;
        Ok(Self::normalised((0..size).map(|i| {
            let current = coefficient;
            coefficient *= (size - 1 - i) as f64 / (i + 1) as f64;
            current
        })))
    }

    fn normalised(weights: impl Iterator<Item = f64>) -> Self {
        let mut weights: Vec<f64> = weights.collect();
        let sum: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= sum;
        }
        Self { weights }
    }

    /// The weights along one axis.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Texels along a side.
    pub fn size(&self) -> usize {
        self.weights.len()
    }

    /// Texels on each side of the middle one.
    pub fn radius(&self) -> usize {
        self.weights.len() / 2
    }

    /// Whether the kernel around a texel lies inside a map.
    pub fn fits(&self, width: usize, height: usize, x: usize, y: usize) -> bool {
        let radius = self.radius();
        x >= radius && y >= radius && x + radius < width && y + radius < height
    }

    /// Taps of the kernel around a texel: offset x, offset y, weight.
    pub fn taps(&self) -> impl Iterator<Item = (isize, isize, f64)> + '_ {
        let radius = self.radius() as isize;
        let axis = move || self.weights.iter().zip(-radius..);
        axis().flat_map(move |(&v, j)| axis().map(move |(&w, i)| (i, j, v * w)))
    }

    /// Z of MSM15: the distribution of depths around a texel, beyond the border those of the nearest texels.
    pub fn distribution(&self, map: &DepthMap, x: usize, y: usize) -> DepthDistribution {
        let (mut depths, mut weights) = (Vec::new(), Vec::new());
        for (i, j, weight) in self.taps() {
            depths.push(f64::from(map.at(x as isize + i, y as isize + j)));
            weights.push(weight);
        }
        DepthDistribution::new(&depths, &weights).expect("depths are finite and weights sum to 1")
    }
}

fn radius_of(size: usize) -> Result<usize, FilteringError> {
    if size.is_multiple_of(2) {
        let reason = "must be odd, or the kernel would have no middle texel";
        return Err(FilteringError::parameter("size", size, reason));
    }
    if size > MAX_KERNEL_SIZE {
        return Err(FilteringError::parameter("size", size, format!("must be at most {MAX_KERNEL_SIZE}")));
    }
    Ok(size / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_symmetric_and_sum_to_one() {
        let kernels = [Kernel::gaussian(9, 2.4), Kernel::uniform(5), Kernel::binomial(7), Kernel::uniform(1)];
        for kernel in kernels.map(Result::unwrap) {
            let weights = kernel.weights();
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!(weights.iter().zip(weights.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-16));
            assert!((kernel.taps().map(|tap| tap.2).sum::<f64>() - 1.0).abs() < 1e-14);
        }
        let binomial = Kernel::binomial(5).unwrap();
        assert_eq!(binomial.weights(), [1.0, 4.0, 6.0, 4.0, 1.0].map(|w| w / 16.0));
    }

    #[test]
    fn impossible_kernels_are_errors_that_name_key_and_value() {
        let message = |kernel: Result<Kernel, FilteringError>| kernel.unwrap_err().to_string();
        assert!(message(Kernel::gaussian(8, 2.0)).starts_with("size = 8: must be odd"));
        assert!(message(Kernel::uniform(0)).contains("size = 0"));
        assert!(message(Kernel::binomial(999)).contains("999"));
        assert!(message(Kernel::gaussian(9, 0.0)).contains("sigma = 0"));
        assert!(message(Kernel::gaussian(9, f64::NAN)).contains("sigma = NaN"));
    }

    #[test]
    fn a_kernel_fits_where_all_its_texels_exist() {
        let kernel = Kernel::uniform(5).unwrap();
        assert!(kernel.fits(5, 5, 2, 2) && !kernel.fits(5, 5, 1, 2) && !kernel.fits(5, 5, 2, 3));
    }
}
