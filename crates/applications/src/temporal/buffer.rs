//! A pixel of the shadow buffer over frames (TC09 section 3).

use moment_problem::arithmetic::Real;

use super::ShadowEstimate;

/// What a pixel remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct History<R = f64> {
    /// n and rho.
    pub estimate: ShadowEstimate<R>,
    /// Depth from the eye at which it was taken.
    pub depth: R,
    /// Average depth of what the shadow maps saw.
    pub blocker: R,
    /// Samples that the average holds besides the first estimate's.
    samples: R,
}

/// How a history begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restart<R = f64> {
    /// The share of shadow that percentage-closer soft shadows find ...
    pub fraction: R,
    /// ... and their average blocker depth ...
    pub blocker: R,
    /// ... count as so many samples, n_0 ...
    pub tests: R,
    /// ... and as so many in the average of depths, k.
    pub blockers: R,
}

/// One new shadow test of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSample<R = f64> {
    /// Depth of the pixel from the eye.
    pub depth: R,
    /// tau: whether the new shadow map's light point is hidden.
    pub in_shadow: bool,
    /// What that map saw at the pixel.
    pub map_depth: R,
}

impl<R: Real> History<R> {
    /// A disoccluded pixel starts from percentage-closer soft shadows; the frame's own test is not used.
    pub fn restarted(start: &Restart<R>, depth: R) -> Self {
        let estimate = ShadowEstimate { tests: start.tests, shadowed: start.tests * start.fraction };
        Self { estimate, depth, blocker: start.blocker, samples: R::zero() }
    }

    /// What a buffer holds. `samples` are those of the average depth besides the first estimate's.
    pub fn stored(estimate: ShadowEstimate<R>, depth: R, blocker: R, samples: R) -> Self {
        Self { estimate, depth, blocker, samples }
    }

    /// Whether this history is that of a surface seen at a depth.
    pub fn belongs_to(&self, depth: R, tolerance: R) -> bool {
        (depth - self.depth).abs() < tolerance
    }

    /// The history with one more test: rho and n (2), and the average depth (7), which averages whatever the map saw, as
    /// published, or blockers alone, without which it drifts towards the receiver.
    pub fn with(&self, sample: &FrameSample<R>, start: &Restart<R>, blockers_only: bool) -> Self {
        let counts = sample.in_shadow || !blockers_only;
        let (before, added) = (start.blockers + self.samples, if counts { R::one() } else { R::zero() });
        let sum = before * self.blocker + added * sample.map_depth;
        let blocker = if before + added > R::zero() { sum / (before + added) } else { self.blocker };
        Self {
            estimate: self.estimate.with(sample.in_shadow),
            depth: sample.depth,
            blocker,
            samples: self.samples + added,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_averages_drift_to_what_is_no_blocker() {
        let start = Restart { fraction: 0.3, blocker: 0.4, tests: 4.0, blockers: 32.0 };
        let mut published = History::restarted(&start, 0.6);
        let mut mended = published;
        for frame in 0..1000 {
            let in_shadow = frame % 10 < 3;
            let map_depth = if in_shadow { 0.4 } else { 0.6 };
            let sample = FrameSample { depth: 0.6, in_shadow, map_depth };
            published = published.with(&sample, &start, false);
            mended = mended.with(&sample, &start, true);
        }
        assert!(published.blocker > 0.53 && (mended.blocker - 0.4).abs() < 1e-12);
        assert_eq!(published.estimate.tests, 1004.0);
        assert!(published.belongs_to(0.6001, 1e-3) && !published.belongs_to(0.61, 1e-3));
    }
}
