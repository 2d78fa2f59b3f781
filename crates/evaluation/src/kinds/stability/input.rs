//! A distribution of depths with a fragment, and its moments.

use moment_problem::arithmetic::{DoubleDouble, Real};
use serde::{Deserialize, Serialize};

/// A distribution of depths and z_f, which is a multiple of 2^-24: single floats hold it and 2 z_f - 1.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct Input {
    /// Depths in \[0, 1\] with weights that sum to 1.
    pub(crate) atoms: Vec<(f64, f64)>,
    pub(crate) z_f: f64,
}

/// Moments in all variables, the first eight of each (four of waves).
pub(crate) struct Moments<R> {
    /// Powers of 2 z - 1.
    pub(crate) signed: [R; 8],
    /// Powers of z.
    pub(crate) unit: [R; 8],
    /// Sine and cosine of 2 pi z and 4 pi z.
    pub(crate) waves: [R; 8],
}

impl<R: Real> Moments<R> {
    fn of(input: &Input) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let (mut signed, mut unit, mut waves) = ([zero; 8], [zero; 8], [zero; 8]);
        let turn = R::from_double_double(DoubleDouble::pi() * DoubleDouble::from(2.0));
        // Weights sum to 1 to 16 digits only, but b_0 is 1.
        let total = input.atoms.iter().fold(zero, |sum, &(_, w)| sum + R::from_f64(w));
        for &(z, w) in &input.atoms {
            let (z, w) = (R::from_f64(z), R::from_f64(w) / total);
            for (sums, base) in [(&mut signed, z + z - one), (&mut unit, z)] {
                let mut power = w;
                for sum in sums {
                    power = power * base;
                    *sum = *sum + power;
                }
            }
            let (sine, cosine) = ((turn * z).sin(), (turn * z).cos());
            let double = [(sine * cosine) + (sine * cosine), (cosine - sine) * (cosine + sine)];
            for (sum, value) in waves.iter_mut().zip([sine, cosine, double[0], double[1]]) {
                *sum = *sum + w * value;
            }
        }
        Self { signed, unit, waves }
    }
}

impl Moments<DoubleDouble> {
    /// To 32 digits.
    pub(crate) fn exact(input: &Input) -> Self {
        Self::of(input)
    }
}

impl Moments<f64> {
    /// In double precision.
    pub(crate) fn plain(input: &Input) -> Self {
        Self::of(input)
    }
}

impl Input {
    /// Weights are divided by their sum, depths clamped to \[0, 1\], z_f rounded to its grid.
    pub(crate) fn new(mut atoms: Vec<(f64, f64)>, z_f: f64) -> Self {
        let total: f64 = atoms.iter().map(|a| a.1).sum();
        atoms.iter_mut().for_each(|(z, w)| (*z, *w) = (z.clamp(0.0, 1.0), *w / total));
        Self { atoms, z_f: on_grid(z_f) }
    }

    /// F: mass strictly before z_f.
    pub(crate) fn mass_before(&self) -> f64 {
        let front = self.atoms.iter().filter(|a| a.0 < self.z_f).map(|a| a.1);
        front.sum::<f64>().min(1.0)
    }

    pub(crate) fn distinct_depths(&self) -> usize {
        // Past the largest number that matters the count may be too large.
        let mut seen: [f64; 6] = [f64::NAN; 6];
        let mut count = 0;
        for &(z, _) in &self.atoms {
            if !seen[..count].contains(&z) {
                if count == seen.len() {
                    return self.atoms.len();
                }
                seen[count] = z;
                count += 1;
            }
        }
        count
    }
}

/// The nearest multiple of 2^-24 in \[0, 1\].
pub(crate) fn on_grid(z: f64) -> f64 {
    const STEPS: f64 = 16_777_216.0;
    (z.clamp(0.0, 1.0) * STEPS).round() / STEPS
}
