//! What a solver returns, and the interface that all of them share.

use crate::arithmetic::DoubleDouble;
use crate::basis::Basis;
use crate::distribution::DepthDistribution;
use crate::error::MomentError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// The set I of admissible depths.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Interval {
    /// All real numbers.
    Real,
    /// \[0, 1\].
    #[default]
    Unit,
}

impl Interval {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Real, Self::Unit];

    /// The name in TOML and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Real => "real",
            Self::Unit => "unit",
        }
    }
}

impl FromStr for Interval {
    type Err = MomentError;

    fn from_str(name: &str) -> Result<Self, MomentError> {
        let known = Self::ALL.into_iter().find(|interval| interval.name() == name);
        known.ok_or_else(|| MomentError::Unsupported(format!("interval `{name}` is neither real nor unit")))
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Real => "the real line",
            Self::Unit => "[0, 1]",
        })
    }
}

/// Sharp bounds of the mass before z_f over all distributions with the given moments, with evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// G: least possible mass strictly before z_f (MSM15 Problem 1).
    pub lower: f64,
    /// Largest possible mass up to and including z_f.
    pub upper: f64,
    /// Depths of a distribution with the given moments that attains the lower bound, ascending.
    pub support: Vec<f64>,
    /// Its weights.
    pub weights: Vec<f64>,
    /// Proof that no distribution does better.
    pub certificate: Certificate,
}

/// Dual evidence: by weak duality, y . (1, b(z)) <= \[z < z_f\] on I proves that every distribution with the moments
/// b has at least the mass y . (1, b) before z_f.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// y over 1, b_1, ..., b_m, for the lower bound.
    pub lower_dual: Vec<f64>,
    /// The same for 1 minus the upper bound and the step \[z > z_f\].
    pub upper_dual: Vec<f64>,
    /// Largest proved excess of either dual function over its step on I; the proved bounds are weakened by it.
    pub worst_slack: f64,
    /// Proved: no distribution with these moments has less mass strictly before z_f.
    pub lower_proved: f64,
    /// Proved: none has more mass up to and including z_f.
    pub upper_proved: f64,
}

/// Answers whose attained and proved values differ by more than this are errors. Measured gaps are 1e-11.
pub(crate) const CERTIFIED_GAP: f64 = 1e-8;

impl Bounds {
    /// Largest distance between an attained and a proved value.
    pub fn gap(&self) -> f64 {
        (self.lower - self.certificate.lower_proved).max(self.certificate.upper_proved - self.upper)
    }

    /// The bounds without what rounding puts beyond a known distribution's own masses.
    pub(crate) fn containing(mut self, z: &DepthDistribution, z_f: f64) -> Self {
        let before = z.cdf(z_f);
        let is_depth = z.depths().binary_search_by(|depth| depth.total_cmp(&z_f)).is_ok();
        // Nothing at z_f: one sum serves both. Zeros of either sign are one depth.
        let up_to = if is_depth || z_f == 0.0 { z.cdf_inclusive(z_f) } else { before };
        self.lower = self.lower.min(before);
        self.upper = self.upper.max(up_to);
        self.certificate.lower_proved = self.certificate.lower_proved.min(self.lower);
        self.certificate.upper_proved = self.certificate.upper_proved.max(self.upper);
        self
    }

    /// The bounds if they are certified to `tolerance`, else an error with the gap.
    pub(crate) fn certified(self, tolerance: f64) -> Result<Self, MomentError> {
        let gap = self.gap();
        if gap <= tolerance { Ok(self) } else { Err(MomentError::Uncertified { gap }) }
    }
}

/// A method that turns moments into sharp bounds (MSM15 Problem 1).
pub trait LowerBound {
    /// Name of the method.
    fn name(&self) -> &'static str;

    /// The map b whose moments are expected.
    fn basis(&self) -> &Basis;

    /// The admissible depths I: \[0, 1\] unless the method works on the line.
    fn interval(&self) -> Interval {
        Interval::Unit
    }

    /// Bounds from E\[b\] in double-double precision. The numbers are taken for exact.
    ///
    /// Errors: wrong length, NaN or infinite numbers, z_f outside I, moments that no distribution has, or an answer
    /// that could not be certified.
    fn bounds_precise(&self, moments: &[DoubleDouble], z_f: f64) -> Result<Bounds, MomentError> {
        self.bounds_near(moments, z_f, &[])
    }

    /// [`LowerBound::bounds_precise`] where depths of a distribution with these moments are known: they may speed up
    /// the search, and are no evidence.
    fn bounds_near(&self, moments: &[DoubleDouble], z_f: f64, depths: &[f64]) -> Result<Bounds, MomentError>;

    /// Bounds from E\[b\]; see [`LowerBound::bounds_precise`].
    fn bounds(&self, moments: &[f64], z_f: f64) -> Result<Bounds, MomentError> {
        let precise: Vec<DoubleDouble> = moments.iter().map(|&b| DoubleDouble::from(b)).collect();
        self.bounds_precise(&precise, z_f)
    }

    /// Bounds for the moments of a known distribution, whose moments need not be rounded to `f64` on the way. The
    /// result depends on the moments alone, so it is the same as if Z were forgotten.
    fn bounds_of(&self, z: &DepthDistribution, z_f: f64) -> Result<Bounds, MomentError> {
        check_depths(z.depths(), self.interval())?;
        self.bounds_near(&z.moments(self.basis()), z_f, z.depths())
    }
}

/// A method that threads can share.
pub type BoundMethod = Box<dyn LowerBound + Send + Sync>;

/// Rejects wrong lengths, NaN, infinities and a z_f outside I.
pub(crate) fn check_input(
    basis: &Basis,
    interval: Interval,
    moments: &[DoubleDouble],
    z_f: f64,
) -> Result<(), MomentError> {
    if moments.len() != basis.len() {
        return Err(MomentError::Length { expected: basis.len(), got: moments.len() });
    }
    for (moment, function) in moments.iter().zip(basis.functions()) {
        if !moment.to_f64().is_finite() {
            let name = format!("the moment of {function}");
            return Err(MomentError::NotFinite { name, value: moment.to_f64() });
        }
    }
    if !z_f.is_finite() {
        return Err(MomentError::NotFinite { name: "the fragment depth z_f".to_owned(), value: z_f });
    }
    if interval == Interval::Unit && !(0.0..=1.0).contains(&z_f) {
        return Err(MomentError::OutsideInterval { name: "the fragment depth z_f".to_owned(), value: z_f });
    }
    Ok(())
}

pub(crate) fn check_depths(depths: &[f64], interval: Interval) -> Result<(), MomentError> {
    let outside = depths.iter().position(|z| interval == Interval::Unit && !(0.0..=1.0).contains(z));
    match outside {
        Some(index) => {
            Err(MomentError::OutsideInterval { name: format!("depth {index}"), value: depths[index] })
        }
        None => Ok(()),
    }
}

/// Sorts support points by depth and drops those whose weight is not above `least`, which are rounding of zero.
pub(crate) fn sorted_support(
    points: impl IntoIterator<Item = (f64, f64)>,
    least: f64,
) -> (Vec<f64>, Vec<f64>) {
    let mut points: Vec<(f64, f64)> = points.into_iter().filter(|&(_, w)| w > least).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.into_iter().unzip()
}

/// On \[0, 1\] a weight below this changes no moment by more than rounding.
pub(crate) const UNIT_WEIGHT_TOLERANCE: f64 = 1e-15;
