//! The estimate from n hard shadow tests and its standard error (TC09 section 3.1), and the penumbra's width on the
//! screen (TC09 equation 6).

use moment_problem::arithmetic::Real;

/// n tests of which rho found shadow. rho need not be whole: it may start as n times another estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowEstimate<R> {
    /// n.
    pub tests: R,
    /// rho.
    pub shadowed: R,
}

impl<R: Real> ShadowEstimate<R> {
    /// No test yet.
    pub fn none() -> Self {
        Self { tests: R::zero(), shadowed: R::zero() }
    }

    /// One more test.
    pub fn with(self, in_shadow: bool) -> Self {
        let tau = if in_shadow { R::one() } else { R::zero() };
        Self { tests: self.tests + R::one(), shadowed: self.shadowed + tau }
    }

    /// psi = rho / n (2); 0 before the first test.
    pub fn fraction(&self) -> R {
        if self.tests > R::zero() { self.shadowed / self.tests } else { R::zero() }
    }

    /// psi (1 - psi) / (n - 1) (3). After one test, where (3) is 0 / 0, it is 0 as in the paper's Table 1. It is 0 for
    /// unanimous tests too, however few: no certainty, see [`ShadowEstimate::cautious_error`].
    pub fn variance(&self) -> R {
        let psi = self.fraction();
        let freedom = self.tests - R::one();
        if freedom > R::zero() { (psi * (R::one() - psi)).max(R::zero()) / freedom } else { R::zero() }
    }

    /// Square root of the variance.
    pub fn standard_error(&self) -> R {
        self.variance().sqrt()
    }

    /// The standard error with one test added to either side, sqrt(p (1 - p) / (n + 2)) with p = (rho + 1) / (n + 2):
    /// never 0.
    pub fn cautious_error(&self) -> R {
        let count = self.tests + R::one() + R::one();
        let p = (self.shadowed + R::one()) / count;
        (p * (R::one() - p) / count).sqrt()
    }
}

/// w_penumbra on the screen: light size times (receiver - blocker) / blocker, scaled by near / depth_eye (6). Distances
/// from the light and from the eye.
pub fn penumbra_width<R: Real>(light_size: R, receiver: R, blocker: R, near: R, depth_eye: R) -> R {
    light_size * (receiver - blocker) / blocker * near / depth_eye
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_table() {
        let tests = [true, false, true, true, true, false, true];
        let mut estimate = ShadowEstimate::<f64>::none();
        assert_eq!((estimate.fraction(), estimate.variance()), (0.0, 0.0));
        let mut errors = Vec::new();
        for test in tests {
            estimate = estimate.with(test);
            errors.push((estimate.standard_error() * 100.0).round() / 100.0);
        }
        assert_eq!(errors, [0.0, 0.5, 0.33, 0.25, 0.2, 0.21, 0.18]);
        assert!((estimate.fraction() - 5.0 / 7.0).abs() < 1e-15);
        let unanimous = ShadowEstimate { tests: 4.0, shadowed: 4.0 };
        assert!(unanimous.standard_error() == 0.0 && unanimous.cautious_error() > 0.15);
    }
}
