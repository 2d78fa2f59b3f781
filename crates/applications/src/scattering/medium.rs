//! A homogeneous medium: extinction, albedo, phase function.

use std::f64::consts::PI;

use thiserror::Error;

/// A number that no medium has.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} = {value}: must lie in {range}")]
pub struct MediumError {
    /// Which.
    pub key: &'static str,
    /// The number.
    pub value: f64,
    /// Where it must lie.
    pub range: &'static str,
}

/// A homogeneous medium that absorbs and scatters once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    extinction: f64,
    albedo: f64,
    anisotropy: f64,
}

/// Below, (1 - e^-x) / x, which cancels, is summed as a series whose terms fall below the last digit of 1 ...
const SERIES_BELOW: f64 = 0.5;

/// ... after so many: 0.5^15 / 16! is 1e-18.
const SERIES_TERMS: i32 = 15;

impl Medium {
    /// `extinction` is sigma_t per world unit, `albedo` the scattered share of it, `anisotropy` g of Henyey and Greenstein:
    /// 0 scatters alike in all directions, g > 0 forwards.
    ///
    /// # Errors
    /// [`MediumError`] for an extinction that is negative or infinite, an albedo outside \[0, 1\], g outside (-1, 1).
    pub fn new(extinction: f64, albedo: f64, anisotropy: f64) -> Result<Self, MediumError> {
        let fail = |key, value, range| Err(MediumError { key, value, range });
        if !(extinction >= 0.0 && extinction.is_finite()) {
            return fail("extinction", extinction, "[0, infinity)");
        }
        if !(0.0..=1.0).contains(&albedo) {
            return fail("albedo", albedo, "[0, 1]");
        }
        if !(anisotropy > -1.0 && anisotropy < 1.0) {
            return fail("anisotropy", anisotropy, "(-1, 1)");
        }
        Ok(Self { extinction, albedo, anisotropy })
    }

    /// sigma_t, per world unit.
    pub fn extinction(&self) -> f64 {
        self.extinction
    }

    /// sigma_s = albedo sigma_t, per world unit.
    pub fn scattering(&self) -> f64 {
        self.albedo * self.extinction
    }

    /// e^(-sigma_t s), which is 0 at infinity unless nothing is absorbed.
    pub fn transmittance(&self, distance: f64) -> f64 {
        if self.extinction == 0.0 { 1.0 } else { (-self.extinction * distance).exp() }
    }

    /// int e^(-sigma_t t) dt between two distances, a length; the end may be infinite, as may then be the result.
    pub fn transmitted_length(&self, start: f64, end: f64) -> f64 {
        let length = end - start;
        // Not of NaN either, which infinity less infinity is.
        let has_length = length > 0.0;
        if !has_length {
            return 0.0;
        }
        if length.is_infinite() {
            let rest = if self.extinction == 0.0 { length } else { 1.0 / self.extinction };
            return self.transmittance(start) * rest;
        }
        let depth = self.extinction * length;
        let lost = if depth < SERIES_BELOW {
            length * decay(depth)
        } else {
            (1.0 - (-depth).exp()) / self.extinction
        };
        self.transmittance(start) * lost
    }

    /// The distance before which a share `u` of [`Medium::transmitted_length`] from 0 to a finite `end` lies.
    pub fn distance(&self, u: f64, end: f64) -> f64 {
        let depth = self.extinction * end;
        if depth < 1e-9 {
            // Linear, but for a billionth.
            return u * end;
        }
        -(u * (-depth).exp_m1()).ln_1p() / self.extinction
    }

    /// The phase function of Henyey and Greenstein by the cosine between the directions in which light travels before
    /// and after; its integral over all directions is 1.
    pub fn phase(&self, cosine: f64) -> f64 {
        let g = self.anisotropy;
        (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5))
    }
}

/// (1 - e^-x) / x for 0 <= x < [`SERIES_BELOW`].
fn decay(x: f64) -> f64 {
    // 1 - x/2 (1 - x/3 (1 - x/4 (...))).
    (2..=SERIES_TERMS).rev().fold(1.0, |sum, k| 1.0 - x / f64::from(k) * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_those_of_thin_and_thick_media() {
        let of = |extinction| Medium::new(extinction, 1.0, 0.0).unwrap();
        assert_eq!(of(0.0).transmitted_length(1.0, 4.0), 3.0);
        assert!((of(1e-9).transmitted_length(0.0, 2.0) - (2.0 - 2e-9)).abs() < 1e-15);
        for extinction in [0.2, 0.249, 0.251, 1.0] {
            let expected = (1.0 - f64::exp(-2.0 * extinction)) / extinction;
            assert!(
                (of(extinction).transmitted_length(0.0, 2.0) / expected - 1.0).abs() < 1e-15,
                "{extinction}"
            );
        }
        assert_eq!(of(4.0).transmitted_length(0.0, f64::INFINITY), 0.25);
        assert_eq!(of(0.0).transmitted_length(0.0, f64::INFINITY), f64::INFINITY);
        assert_eq!(of(1.0).transmitted_length(f64::INFINITY, f64::INFINITY), 0.0);
        assert_eq!(of(1e300).transmitted_length(0.0, 1e300), 1e-300);
        for (extinction, u) in [(0.0, 0.3), (1e-12, 0.7), (0.5, 0.01), (40.0, 0.999)] {
            let medium = of(extinction);
            let share =
                medium.transmitted_length(0.0, medium.distance(u, 3.0)) / medium.transmitted_length(0.0, 3.0);
            assert!((share - u).abs() < 1e-9, "{extinction} {u}: {share}");
        }
    }

    #[test]
    fn phase_functions_have_integral_one() {
        for g in [-0.7, 0.0, 0.9] {
            let medium = Medium::new(1.0, 1.0, g).unwrap();
            let steps = 100_000;
            let cosines = (0..steps).map(|i| (2.0 * f64::from(i) + 1.0) / f64::from(steps) - 1.0);
            let sum: f64 = cosines.map(|cosine| medium.phase(cosine)).sum();
            assert!((sum * 4.0 * PI / f64::from(steps) - 1.0).abs() < 1e-5, "{g}");
        }
    }

    #[test]
    fn impossible_media_are_errors_with_their_number() {
        for (medium, key) in [
            (Medium::new(-1.0, 0.5, 0.0), "extinction = -1"),
            (Medium::new(f64::NAN, 0.5, 0.0), "extinction = NaN"),
            (Medium::new(1.0, 1.5, 0.0), "albedo = 1.5"),
            (Medium::new(1.0, 0.5, 1.0), "anisotropy = 1"),
        ] {
            assert!(medium.unwrap_err().to_string().starts_with(key));
        }
    }
}
