//! What filtered moments say about blockers: how much lies in front of the receiver, and where on average.

use moment_problem::arithmetic::Real;
use moment_problem::in_front::{self, InFront};
use moment_problem::{hamburger, hausdorff};

use crate::field::{MAX_CHANNELS, Means};

/// The sharp bound by which moments are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MomentBound {
    /// Two moments on the line: variance soft shadow mapping (Yang et al. 2010). With G = 1 - P and the unblocked
    /// depth at z_f its blocker depth (E\[z\] - P z_f) / G is the other point of the two-point distribution.
    Chebyshev,
    /// Four moments on the line (BHS16 section 3.3).
    Hamburger4,
    /// Six moments on the line.
    Hamburger6,
    /// Four moments on \[0, 1\].
    Hausdorff4,
}

impl MomentBound {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Chebyshev, Self::Hamburger4, Self::Hamburger6, Self::Hausdorff4];

    /// Number of power moments.
    pub fn order(self) -> usize {
        match self {
            Self::Chebyshev => 2,
            Self::Hamburger4 | Self::Hausdorff4 => 4,
            Self::Hamburger6 => 6,
        }
    }

    /// G: least mass in front of `z`.
    fn lower<R: Real>(self, b: &Means<R>, z: R) -> R {
        match self {
            Self::Chebyshev => hamburger::chebyshev(&[b[0], b[1]], z).lower,
            Self::Hamburger4 => hamburger::hamburger4(&[b[0], b[1], b[2], b[3]], z).lower,
            Self::Hamburger6 => hamburger::hamburger(b, z).lower,
            Self::Hausdorff4 => hausdorff::hausdorff4(&[b[0], b[1], b[2], b[3]], z).lower,
        }
    }

    fn in_front<R: Real>(self, b: &Means<R>, z: R) -> InFront<R> {
        match self {
            Self::Chebyshev => in_front::chebyshev(&[b[0], b[1]], z),
            Self::Hamburger4 => in_front::hamburger(&[b[0], b[1], b[2], b[3]], z),
            Self::Hamburger6 => in_front::hamburger(b, z),
            Self::Hausdorff4 => in_front::hausdorff4(&[b[0], b[1], b[2], b[3]], z),
        }
    }
}

/// A monotone map of \[0, 1\] onto itself, taken of depths before their powers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Warp<R> {
    /// Depths as they are.
    None,
    /// (e^(c z) - 1) / (e^c - 1), c > 0: near depths move together, which is where one leak hides another.
    Exponential(R),
}

impl<R: Real> Warp<R> {
    /// The warped depth.
    pub fn apply(self, z: R) -> R {
        match self {
            Self::None => z,
            Self::Exponential(c) => ((c * z).exp() - R::one()) / (c.exp() - R::one()),
        }
    }

    /// The depth of a warped depth, which is clamped to \[0, 1\]: no logarithm of what no depth becomes.
    pub fn invert(self, warped: R) -> R {
        match self {
            Self::None => warped,
            Self::Exponential(c) => (warped.clamp_unit() * (c.exp() - R::one()) + R::one()).ln() / c,
        }
    }
}

/// Power moments of warped depth, read by a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reconstruction<R> {
    /// Before the powers.
    pub warp: Warp<R>,
    /// How moments are read.
    pub bound: MomentBound,
    /// alpha: moments become (1 - alpha) b + alpha b*, where b* has half of its mass at each end of \[0, 1\].
    pub moment_bias: R,
}

/// What a blocker search finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blockers<R> {
    /// Share of the region in front of the receiver.
    pub mass: R,
    /// Sum of the depths in front, each times its share.
    pub depth_sum: R,
}

impl<R: Real> Blockers<R> {
    /// Nothing in front.
    pub fn none() -> Self {
        Self { mass: R::zero(), depth_sum: R::zero() }
    }

    /// One more blocker.
    pub fn with(self, depth: R, weight: R) -> Self {
        Self { mass: self.mass + weight, depth_sum: self.depth_sum + weight * depth }
    }

    /// Average depth, drawn towards the receiver at `z` by a weight of `epsilon` there, so that few blockers make a
    /// small filter (BHS16 section 3.3); `z` where there is nothing to divide by. It is not clamped.
    pub fn average(&self, z: R, epsilon: R) -> R {
        let total = epsilon + self.mass;
        if total > R::zero() { (epsilon * z + self.depth_sum) / total } else { z }
    }
}

impl<R: Real> Reconstruction<R> {
    /// Number of stored channels.
    pub fn channels(&self) -> usize {
        self.bound.order()
    }

    /// Stored values of a depth.
    pub fn encode(&self, depth: R, out: &mut [R]) {
        let warped = self.warp.apply(depth);
        let mut power = R::one();
        for value in out.iter_mut().take(self.channels()) {
            power = power * warped;
            *value = power;
        }
    }

    /// The share in front of depth `z`, at least; `means` are those of the stored values.
    pub fn intensity(&self, means: &Means<R>, z: R) -> R {
        self.bound.lower(&self.biased(means), self.warp.apply(z))
    }

    /// What lies in front of depth `z` if the distribution is the extremal one.
    pub fn blockers(&self, means: &Means<R>, z: R) -> Blockers<R> {
        let found = self.bound.in_front(&self.biased(means), self.warp.apply(z));
        found.points().iter().fold(Blockers::none(), |sum, &(depth, weight)| {
            sum.with(self.warp.invert(depth), weight)
        })
    }

    fn biased(&self, means: &Means<R>) -> Means<R> {
        let half = R::from_f64(0.5) * self.moment_bias;
        let mut biased = [R::zero(); MAX_CHANNELS];
        for (out, &mean) in biased.iter_mut().zip(means).take(self.channels()) {
            *out = (R::one() - self.moment_bias) * mean + half;
        }
        biased
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn means(reconstruction: &Reconstruction<f64>, atoms: &[(f64, f64)]) -> Means<f64> {
        let total: f64 = atoms.iter().map(|a| a.1).sum();
        let mut sum = [0.0; MAX_CHANNELS];
        for &(depth, weight) in atoms {
            let mut out = [0.0; MAX_CHANNELS];
            reconstruction.encode(depth, &mut out);
            (0..MAX_CHANNELS).for_each(|k| sum[k] += weight / total * out[k]);
        }
        sum
    }

    proptest! {
        /// All of them know two surfaces when asked on the farther one, and nothing in front of the nearer.
        #[test]
        fn a_blocker_over_a_receiver_is_found(
            blocker in 0.05..0.5f64, gap in 0.2..0.45f64, share in 0.1..0.9f64, exponent in 1.0..8.0f64,
        ) {
            let receiver = blocker + gap;
            let atoms = [(blocker, share), (receiver, 1.0 - share)];
            for bound in MomentBound::ALL {
                for warp in [Warp::None, Warp::Exponential(exponent)] {
                    let technique = Reconstruction { warp, bound, moment_bias: 0.0 };
                    let b = means(&technique, &atoms);
                    let found = technique.blockers(&b, receiver);
                    prop_assert!((found.mass - share).abs() < 1e-5, "{technique:?} {found:?}");
                    prop_assert!((found.average(receiver, 0.0) - blocker).abs() < 1e-5, "{technique:?} {found:?}");
                    prop_assert!((technique.intensity(&b, receiver) - found.mass).abs() < 1e-9);
                    prop_assert_eq!(technique.blockers(&b, 0.5 * blocker).average(0.3, 0.0), 0.3);
                }
            }
        }

        /// Yang et al. 2010, equation for z_occ, with the unblocked depth at the receiver.
        #[test]
        fn two_moments_are_variance_soft_shadows(
            atoms in prop::collection::vec((0.0..1.0f64, 0.1..1.0f64), 2..6), z in 0.0..1.0f64,
        ) {
            let technique = Reconstruction { warp: Warp::None, bound: MomentBound::Chebyshev, moment_bias: 0.0 };
            let b = means(&technique, &atoms);
            prop_assume!(z - b[0] > 0.01);
            let variance = b[1] - b[0] * b[0];
            let lit = variance / (variance + (z - b[0]).powi(2));
            let occluder = (b[0] - lit * z) / (1.0 - lit);
            prop_assert!((technique.blockers(&b, z).average(z, 0.0) - occluder).abs() < 1e-9);
        }
    }

    #[test]
    fn warps_are_inverted() {
        let warp = Warp::Exponential(5.0f64);
        assert_eq!((warp.apply(0.0), warp.apply(1.0)), (0.0, 1.0));
        for z in [0.0, 0.1, 0.5, 0.99, 1.0] {
            assert!((warp.invert(warp.apply(z)) - z).abs() < 1e-14);
        }
        assert_eq!((warp.invert(-3.0), warp.invert(7.0)), (0.0, 1.0));
    }
}
