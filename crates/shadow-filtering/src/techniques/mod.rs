//! One file a technique, with its basis, its bound and what it takes from a [`TechniqueSpec`].

mod certified;
mod convolution;
mod exponential;
mod exponential_variance;
mod layered_variance;
mod moments;
mod two_surfaces;
mod variance;

pub use moments::BiasedMoments;

use crate::basis::AnyBasis;
use crate::bound::AnyBound;
use crate::error::FilteringError;
use crate::spec::TechniqueSpec;
use moment_problem::MomentBound;
use quantization::NumberFormat;

/// What is known of a bound by its name.
pub(crate) struct Family {
    /// Name in experiments.
    pub(crate) name: &'static str,
    /// Keys of a [`TechniqueSpec`] that it takes, beside those of its storage.
    pub(crate) keys: &'static [&'static str],
    /// The inequality or bound, and where it stands.
    pub(crate) equations: &'static str,
    source: Source,
}

enum Source {
    Own(fn(&TechniqueSpec) -> Result<Parts, FilteringError>),
    Moments(MomentBound),
}

/// All of them; a new one is a line here.
pub(crate) const FAMILIES: &[Family] = &[
    own(
        "vsm",
        &[],
        "Cantelli's inequality for mean and second moment: MSM15 section 2, after Donnelly and Lauritzen 2006",
        variance::parts,
    ),
    own(
        "esm",
        &["exponent"],
        "Markov's inequality for e^(c z), 1 - E[e^(c z)] e^(-c z_f): MSM15 section 2, after Annen et al. 2008 and Salvi 2008",
        exponential::parts,
    ),
    own(
        "evsm",
        &["exponent", "negative_exponent"],
        "Cantelli's inequality for e^(c s) and -e^(-d s), the darker of both: MSM15 section 2, after Lauritzen 2007",
        exponential_variance::parts,
    ),
    own(
        "lvsm",
        &["layers"],
        "Cantelli's inequality in the layer of z_f: MSM15 section 2, after Lauritzen and McCool 2008",
        layered_variance::parts,
    ),
    own(
        "csm",
        &["coefficients"],
        "Fourier series of the shadow test, biased to a lower bound: MSM15 section 2, after Annen et al. 2007",
        convolution::parts,
    ),
    own(
        "fourier",
        &["coefficients"],
        "Fourier series of the shadow test as it is: after Annen et al. 2007",
        convolution::series_parts,
    ),
    own("certified", &["basis"], "Problem 1 of MSM15 by a linear program", certified::parts),
    moments(
        "hamburger2",
        "Cantelli's inequality for biased moments: MSM15 sections 2 and 4.2",
        MomentBound::Hamburger2,
    ),
    moments("hamburger4", "Hamburger 4MSM, MSM15 Algorithm 3; bias, section 4.2", MomentBound::Hamburger4),
    moments(
        "hamburger6",
        "MSM15 Algorithm 2 for six moments, after BHS16 section 2.4",
        MomentBound::Hamburger6,
    ),
    moments("hamburger8", "MSM15 Algorithm 2 for eight moments", MomentBound::Hamburger8),
    moments("hausdorff4", "Hausdorff 4MSM, MSM15 section 4; bias, section 4.2", MomentBound::Hausdorff4),
    moments(
        "trigonometric4",
        "Trigonometric 4MSM (TMSM), MSM15 section 4; bias, section 4.2",
        MomentBound::Trigonometric4,
    ),
];

const fn own(
    name: &'static str,
    keys: &'static [&'static str],
    equations: &'static str,
    parts: fn(&TechniqueSpec) -> Result<Parts, FilteringError>,
) -> Family {
    Family { name, keys, equations, source: Source::Own(parts) }
}

const fn moments(name: &'static str, equations: &'static str, bound: MomentBound) -> Family {
    let keys = &["alpha", "beta", "centre", "range"];
    Family { name, keys, equations, source: Source::Moments(bound) }
}

impl Family {
    pub(crate) fn parts(&self, spec: &TechniqueSpec) -> Result<Parts, FilteringError> {
        match self.source {
            Source::Own(parts) => parts(spec),
            Source::Moments(bound) => moments::parts(bound, spec),
        }
    }

    /// Which moments are bounded, where the bound is that of moments.
    pub(crate) fn moments(&self) -> Option<MomentBound> {
        match self.source {
            Source::Own(_) => None,
            Source::Moments(bound) => Some(bound),
        }
    }
}

/// A technique without its storage.
pub(crate) struct Parts {
    pub(crate) basis: Box<dyn AnyBasis>,
    pub(crate) bound: Box<dyn AnyBound>,
}

impl Parts {
    fn new(basis: impl AnyBasis + 'static, bound: impl AnyBound + 'static) -> Self {
        Self { basis: Box::new(basis), bound: Box::new(bound) }
    }
}

/// Largest exponents c in half and single floats such that e^(c z) on \[0, 1\] is stored without overflow, rounded down
/// to what is in use.
const LARGEST_EXPONENT: [f64; 2] = [11.08, 88.0];

/// The same where the square is stored too. Single floats keep a margin for sums of many texels.
const LARGEST_EXPONENT_WITH_SQUARE: [f64; 2] = [5.54, 42.0];

/// An exponent that is given, positive, and does not overflow the format.
fn exponent_of(
    key: &'static str,
    value: Option<f64>,
    format: NumberFormat,
    [half, single]: [f64; 2],
) -> Result<f64, FilteringError> {
    let exponent = value.unwrap_or(f64::NAN);
    if !(exponent.is_finite() && exponent > 0.0) {
        return Err(FilteringError::parameter(key, exponent, "must be positive and finite"));
    }
    let limit = match format {
        NumberFormat::F16 => half,
        NumberFormat::F32 => single,
        NumberFormat::Unorm8
        | NumberFormat::Unorm10
        | NumberFormat::Unorm16
        | NumberFormat::U32Fixed { .. } => {
            let reason = "cannot hold exponential warps, f16 and f32 can";
            return Err(FilteringError::parameter("format", format, reason));
        }
    };
    if exponent > limit {
        let reason = format!("overflows {format}, which holds exponents up to {limit} here");
        return Err(FilteringError::parameter(key, exponent, reason));
    }
    Ok(exponent)
}

/// A number that is given and lies between 1 and a limit.
fn count_of(key: &'static str, value: Option<usize>, most: usize) -> Result<usize, FilteringError> {
    let count = value.unwrap_or_default();
    if !(1..=most).contains(&count) {
        return Err(FilteringError::parameter(key, count, format!("must be 1 to {most}")));
    }
    Ok(count)
}
