//! Variance shadow maps: b(z) = (z, z^2) and Cantelli's inequality (MSM15 section 2, after Donnelly and Lauritzen).

use crate::error::FilteringError;
use crate::technique::{Technique, unit};
use moment_problem::hamburger::chebyshev;

/// Added to the variance, in units of the second moment: what rounding in two filter passes of up to 129 taps and in
/// the subtraction can take from it. Without it a kernel of depths that differ in their last bits, or a receiver at
/// exactly the one depth of its kernel, would be guessed from noise.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Cantelli's lower bound of the mass in front of `z_f` from mean and second moment in whatever warped depth.
pub(crate) fn cantelli(mean: f64, second: f64, z_f: f64) -> f64 {
    chebyshev(&[mean, second + ROUNDING * second.abs()], z_f).lower
}

/// Variance shadow map on \[0, 1\], sharp for depths on the whole line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Variance;

impl Technique for Variance {
    fn name(&self) -> String {
        "VSM".to_owned()
    }

    fn channels(&self) -> usize {
        2
    }

    fn encode(&self, depth: f64, out: &mut [f64]) {
        let z = unit(depth);
        out.copy_from_slice(&[z, z * z]);
    }

    fn shade(&self, filtered: &[f64], z_f: f64) -> Result<f64, FilteringError> {
        Ok(cantelli(filtered[0], filtered[1], unit(z_f)))
    }

    fn is_lower_bound(&self) -> bool {
        true
    }
}
