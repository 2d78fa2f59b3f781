//! What filtered moments say about blockers: how much lies in front of the receiver, and where on average.

use moment_problem::arithmetic::Real;
use moment_problem::{Interval, MomentBound};
use thiserror::Error;

use super::storage::{Storage, StoredPowers};
use crate::field::{MAX_CHANNELS, Means};

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

/// Power moments of warped depth, read by a bound: two for variance soft shadows, four for those of BHS16.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reconstruction<R> {
    warp: Warp<R>,
    bound: MomentBound,
    moment_bias: R,
    stored: StoredPowers<R>,
    /// b*.
    centre: [R; MAX_CHANNELS],
}

/// A reconstruction that makes no sense.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReconstructionError {
    /// No points to average.
    #[error("{name} gives no distribution of depths in which blockers could be searched")]
    NoPoints {
        /// The bound.
        name: &'static str,
    },
    /// A transform of other moments, or of depths that the bound does not take.
    #[error("storage = {storage:?} does not hold the {order} moments of {name}")]
    Storage {
        /// The storage.
        storage: Storage,
        /// Number of moments.
        order: usize,
        /// The bound.
        name: &'static str,
    },
    /// b* of another length.
    #[error("centre has {got} numbers where {name} has {order} moments")]
    Centre {
        /// How many.
        got: usize,
        /// Number of moments.
        order: usize,
        /// The bound.
        name: &'static str,
    },
    /// A number out of its range.
    #[error("{key} = {value}: must lie in {range}")]
    Parameter {
        /// Which.
        key: &'static str,
        /// The number.
        value: f64,
        /// Where it must lie.
        range: &'static str,
    },
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

/// Largest exponent of a warp: e^40 - 1 is 1 to 17 digits of e^40, and near depths keep four of them.
const MAX_EXPONENT: f64 = 40.0;

impl<R: Real> Reconstruction<R> {
    /// Powers of depth in \[0, 1\]. `moment_bias` is alpha: moments become (1 - alpha) b + alpha b*, where b* has half of its
    /// mass at each end of the range unless [`Reconstruction::centred`] says otherwise.
    ///
    /// # Errors
    /// [`ReconstructionError`] for a bound without points, an exponent outside (0, 40\] and a bias outside \[0, 1).
    pub fn new(bound: MomentBound, warp: Warp<R>, moment_bias: R) -> Result<Self, ReconstructionError> {
        if bound.in_front(&[R::zero(); MAX_CHANNELS], R::zero()).is_none() {
            return Err(ReconstructionError::NoPoints { name: bound.name() });
        }
        let alpha = moment_bias.to_f64();
        if !(0.0..1.0).contains(&alpha) {
            return Err(ReconstructionError::Parameter { key: "moment_bias", value: alpha, range: "[0, 1)" });
        }
        if let Warp::Exponential(c) = warp
            && !(c.to_f64() > 0.0 && c.to_f64() <= MAX_EXPONENT)
        {
            return Err(ReconstructionError::Parameter {
                key: "exponent",
                value: c.to_f64(),
                range: "(0, 40]",
            });
        }
        let stored = StoredPowers::unit();
        Ok(Self { warp, bound, moment_bias, stored, centre: stored.ends() })
    }

    /// The same with powers stored in another way, and b* with half of its mass at each end of their range.
    ///
    /// # Errors
    /// [`ReconstructionError::Storage`] for a transform of another number of moments, and for a bound that needs depths
    /// in \[0, 1\].
    pub fn stored(self, storage: Storage) -> Result<Self, ReconstructionError> {
        let (order, name) = (self.channels(), self.bound.name());
        let refused = ReconstructionError::Storage { storage, order, name };
        if storage != Storage::Unit && self.bound.interval() != Interval::Real {
            return Err(refused);
        }
        let stored = StoredPowers::new(storage, order).ok().flatten().ok_or(refused)?;
        Ok(Self { stored, centre: stored.ends(), ..self })
    }

    /// The same with b* given, moments of the variable whose powers are stored; GDC16 takes (0, 0.63, 0, 0.63) for depths
    /// in \[-1, 1\], the best for the worst case.
    ///
    /// # Errors
    /// [`ReconstructionError::Centre`] for another number of moments.
    pub fn centred(self, centre: &[f64]) -> Result<Self, ReconstructionError> {
        let (order, name) = (self.channels(), self.bound.name());
        if centre.len() != order {
            return Err(ReconstructionError::Centre { got: centre.len(), order, name });
        }
        let mut padded = [R::zero(); MAX_CHANNELS];
        padded.iter_mut().zip(centre).for_each(|(out, &c)| *out = R::from_f64(c));
        Ok(Self { centre: padded, ..self })
    }

    /// How moments are read.
    pub fn bound(&self) -> MomentBound {
        self.bound
    }

    /// What is taken of depths before their powers.
    pub fn warp(&self) -> Warp<R> {
        self.warp
    }

    /// alpha.
    pub fn moment_bias(&self) -> R {
        self.moment_bias
    }

    /// The same in another precision.
    pub fn cast<S: Real>(&self) -> Reconstruction<S> {
        let cast = |value: R| S::from_f64(value.to_f64());
        let warp = match self.warp {
            Warp::None => Warp::None,
            Warp::Exponential(c) => Warp::Exponential(cast(c)),
        };
        Reconstruction {
            warp,
            bound: self.bound,
            moment_bias: cast(self.moment_bias),
            stored: self.stored.cast(),
            centre: self.centre.map(cast),
        }
    }

    /// Which powers are stored.
    pub fn storage(&self) -> Storage {
        self.stored.storage()
    }

    /// What is stored of the powers: matrix, inverse and offset, see [`StoredPowers::affine`].
    pub(super) fn affine(&self) -> [Vec<f64>; 3] {
        self.stored.affine(self.channels())
    }

    /// b*.
    pub fn centre(&self) -> &[R] {
        &self.centre[..self.channels()]
    }

    /// Number of stored channels.
    pub fn channels(&self) -> usize {
        self.bound.order()
    }

    /// Stored values of a depth.
    pub fn encode(&self, depth: R, out: &mut [R]) {
        let channels = self.channels();
        self.stored.encode(self.warp.apply(depth), &mut out[..channels]);
    }

    /// The share in front of depth `z`, at least; `means` are those of the stored values.
    pub fn intensity(&self, means: &Means<R>, z: R) -> R {
        self.bound.bounds(&self.biased(means), self.variable(z)).lower
    }

    /// What lies in front of depth `z` if the distribution is the extremal one.
    pub fn blockers(&self, means: &Means<R>, z: R) -> Blockers<R> {
        let found = self.bound.in_front(&self.biased(means), self.variable(z));
        let points = found.iter().flat_map(|found| found.points());
        points.fold(Blockers::none(), |sum, &(depth, weight)| {
            sum.with(self.warp.invert(self.stored.depth(depth)), weight)
        })
    }

    fn variable(&self, z: R) -> R {
        self.stored.variable(self.warp.apply(z))
    }

    fn biased(&self, means: &Means<R>) -> Means<R> {
        let alpha = self.moment_bias;
        let mut biased = [R::zero(); MAX_CHANNELS];
        let moments = self.stored.decode(means);
        for ((out, &mean), &centre) in biased.iter_mut().zip(&moments).zip(&self.centre).take(self.channels())
        {
            *out = (R::one() - alpha) * mean + alpha * centre;
        }
        biased
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Those in use.
    const BOUNDS: [MomentBound; 4] =
        [MomentBound::Hamburger2, MomentBound::Hamburger4, MomentBound::Hamburger6, MomentBound::Hausdorff4];

    fn plain(bound: MomentBound, warp: Warp<f64>) -> Reconstruction<f64> {
        Reconstruction::new(bound, warp, 0.0).unwrap()
    }

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
            // Six unbiased moments of two surfaces have a singular matrix: rounding enters under a root, up to 1e-2.
            for bound in BOUNDS.into_iter().filter(|&bound| bound != MomentBound::Hamburger6) {
                for warp in [Warp::None, Warp::Exponential(exponent)] {
                    let technique = plain(bound, warp);
                    let b = means(&technique, &atoms);
                    let found = technique.blockers(&b, receiver);
                    prop_assert!((found.mass - share).abs() < 1e-5, "{technique:?} {found:?}");
                    prop_assert!((found.average(receiver, 0.0) - blocker).abs() < 1e-5, "{technique:?} {found:?}");
                    prop_assert!((technique.intensity(&b, receiver) - found.mass).abs() < 1e-9);
                    // A node of no weight may lie anywhere, which epsilon forgives.
                    let nothing = technique.blockers(&b, 0.5 * blocker);
                    prop_assert!(nothing.mass < 1e-9, "{technique:?} {nothing:?}");
                    prop_assert!((nothing.average(0.3, 0.01) - 0.3).abs() < 1e-6, "{technique:?} {nothing:?}");
                }
            }
        }

        /// Yang et al. 2010, equation for z_occ, with the unblocked depth at the receiver.
        #[test]
        fn two_moments_are_variance_soft_shadows(
            atoms in prop::collection::vec((0.0..1.0f64, 0.1..1.0f64), 2..6), z in 0.0..1.0f64,
        ) {
            let technique = plain(MomentBound::Hamburger2, Warp::None);
            let b = means(&technique, &atoms);
            prop_assume!(z - b[0] > 0.01);
            let variance = b[1] - b[0] * b[0];
            let lit = variance / (variance + (z - b[0]).powi(2));
            let occluder = (b[0] - lit * z) / (1.0 - lit);
            prop_assert!((technique.blockers(&b, z).average(z, 0.0) - occluder).abs() < 1e-9);
        }
    }

    #[test]
    fn impossible_reconstructions_are_named() {
        let error = |bound, warp, alpha| Reconstruction::new(bound, warp, alpha).unwrap_err().to_string();
        let four = MomentBound::Hamburger4;
        assert!(error(MomentBound::Trigonometric4, Warp::None, 0.0).starts_with("Trigonometric 4 gives no"));
        assert!(error(four, Warp::None, -0.1).contains("moment_bias = -0.1"));
        assert!(error(four, Warp::Exponential(0.0), 0.0).contains("exponent = 0"));
        assert!(error(four, Warp::Exponential(f64::NAN), 0.0).contains("exponent = NaN"));
    }

    #[test]
    fn storages_say_the_same_of_the_same_depths() {
        let atoms = [(0.2, 0.3), (0.5, 0.2), (0.8, 0.5)];
        let unit = plain(MomentBound::Hamburger4, Warp::None);
        let expected = unit.blockers(&means(&unit, &atoms), 0.7);
        for storage in [Storage::Signed, Storage::Sparse] {
            let other = unit.stored(storage).unwrap();
            let found = other.blockers(&means(&other, &atoms), 0.7);
            assert!((found.mass - expected.mass).abs() < 1e-9, "{storage:?} {found:?} {expected:?}");
            assert!((found.depth_sum - expected.depth_sum).abs() < 1e-9, "{storage:?}");
        }
        let biased = Reconstruction::new(MomentBound::Hamburger4, Warp::None, 0.5).unwrap();
        let signed = biased.stored(Storage::Signed).unwrap();
        let b = means(&signed, &atoms);
        let ends = signed.intensity(&b, 0.7);
        let (same, inner) = (signed.centred(&[0.0, 1.0, 0.0, 1.0]), signed.centred(&[0.0, 0.63, 0.0, 0.63]));
        assert_eq!(same.unwrap().intensity(&b, 0.7), ends);
        assert!(inner.unwrap().intensity(&b, 0.7) != ends);
        let error = |found: Result<Reconstruction<f64>, ReconstructionError>| found.unwrap_err().to_string();
        assert!(error(signed.centred(&[0.0])).contains("centre has 1 numbers"));
        let hausdorff = plain(MomentBound::Hausdorff4, Warp::None);
        assert!(error(hausdorff.stored(Storage::Signed)).contains("storage = Signed"));
        let six = plain(MomentBound::Hamburger6, Warp::None);
        assert!(error(six.stored(Storage::Sparse)).contains("6 moments"));
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
