//! The closed forms behind the common interface: exact support, weights, and dual evidence.

use super::bounds::{
    BoundMethod, Bounds, CERTIFIED_GAP, Certificate, Interval, LowerBound, UNIT_WEIGHT_TOLERANCE,
    check_depths, check_input, sorted_support,
};
use super::exact::exact_of;
use super::hamburger::{Chebyshev, Hamburger};
use super::semi_infinite::{Origin, PreparedBasis, solve_prepared};
use crate::arithmetic::{DoubleDouble, Field, Real};
use crate::basis::Basis;
use crate::closed_forms::{hausdorff, trigonometric};
use crate::distribution::DepthDistribution;
use crate::error::{BasisError, MomentError};

struct Claim {
    lower: f64,
    upper: f64,
    support: Vec<(f64, f64)>,
}

impl Claim {
    /// Certifies closed-form values: the exchange simplex starts from the claimed support and must arrive at the same
    /// values; its dual functions are the evidence.
    fn certified(
        self,
        prepared: &PreparedBasis,
        moments: &[DoubleDouble],
        z_f: f64,
        depths: &[f64],
    ) -> Result<Bounds, MomentError> {
        let start: Vec<f64> =
            self.support.iter().map(|&(z, _)| z.clamp(0.0, 1.0)).chain(depths.iter().copied()).collect();
        let proof = solve_prepared(prepared, (moments, Origin::of(depths)), z_f, &start)?;
        let difference = (self.lower - proof.lower).abs().max((self.upper - proof.upper).abs());
        if difference.is_nan() || difference > CERTIFIED_GAP {
            return Err(MomentError::Uncertified { gap: difference });
        }
        if self.support.is_empty() {
            return Ok(proof); // a trivial bound, attained by any distribution with the moments
        }
        let (support, weights) = sorted_support(self.support, UNIT_WEIGHT_TOLERANCE);
        Ok(Bounds { lower: self.lower, upper: self.upper, support, weights, certificate: proof.certificate })
    }
}

macro_rules! unit_interval_form {
    ($(#[$doc:meta])* $type:ident, $name:literal, $basis:expr) => {
        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub struct $type {
            prepared: PreparedBasis,
        }

        impl $type {
            /// Prepares the basis for proofs (some milliseconds; reuse it).
            pub fn new() -> Result<Self, BasisError> {
                Ok(Self { prepared: PreparedBasis::new(&$basis)? })
            }
        }

        impl LowerBound for $type {
            fn name(&self) -> &'static str {
                $name
            }

            fn basis(&self) -> &Basis {
                self.prepared.basis()
            }

            fn bounds_near(
                &self,
                moments: &[DoubleDouble],
                z_f: f64,
                depths: &[f64],
            ) -> Result<Bounds, MomentError> {
                check_input(self.basis(), Interval::Unit, moments, z_f)?;
                let array: [DoubleDouble; 4] = std::array::from_fn(|i| moments[i]);
                Self::claim(&array, z_f).certified(&self.prepared, moments, z_f, depths)
            }

            fn bounds_of(&self, z: &DepthDistribution, z_f: f64) -> Result<Bounds, MomentError> {
                check_depths(z.depths(), Interval::Unit)?;
                let result = self.bounds_near(&z.moments(self.basis()), z_f, z.depths());
                // Nearly equal depths, and z_f next to one, can be too much for double-double; not for exact arithmetic.
                result.or_else(|error| {
                    let exact = || exact_of(self.basis(), Interval::Unit, z, z_f);
                    error.is_unresolved().then(exact).flatten().unwrap_or(Err(error))
                })
            }
        }
    };
}

unit_interval_form!(
    /// Four power moments on \[0, 1\]: Hausdorff 4MSM (MSM15 section 4).
    Hausdorff4,
    "Hausdorff 4",
    Basis::power(4)
);

unit_interval_form!(
    /// Sine and cosine of 2 pi z and 4 pi z on \[0, 1\]: trigonometric moment shadow mapping (MSM15 section 4).
    Trigonometric4,
    "trigonometric 4",
    Basis::trigonometric(2)
);

impl Hausdorff4 {
    fn claim(moments: &[DoubleDouble; 4], z_f: f64) -> Claim {
        let fragment = DoubleDouble::from(z_f);
        let pair = hausdorff::hausdorff4(moments, fragment);
        let support = hausdorff::support(moments, fragment);
        let support = support.into_iter().map(|(z, w)| (z.to_f64(), w.to_f64())).collect();
        Claim { lower: pair.lower.to_f64(), upper: pair.upper.to_f64(), support }
    }
}

impl Trigonometric4 {
    fn claim(moments: &[DoubleDouble; 4], z_f: f64) -> Claim {
        let fragment = DoubleDouble::from(z_f);
        let pair = trigonometric::trigonometric4(moments, fragment);
        let mut support = Vec::new();
        if let Some(candidate) = trigonometric::lower_candidate(moments, fragment) {
            support.extend(candidate.free_points());
            support.push((z_f, candidate.at_z_f.to_f64()));
            support.push((1.0, candidate.at_seam.to_f64()));
        }
        Claim { lower: pair.lower.to_f64(), upper: pair.upper.to_f64(), support }
    }
}

/// One moment E\[e^(c z)\], c > 0, on the whole line: exponential shadow maps (Markov's inequality).
#[derive(Clone, Debug)]
pub struct Markov {
    basis: Basis,
    exponent: f64,
}

impl Markov {
    /// ESM with exponent c > 0. Beyond 700 doubles overflow; single precision ends at 88, and 42 if squares are kept.
    pub fn new(exponent: f64) -> Result<Self, BasisError> {
        if !(exponent > 0.0 && exponent <= 700.0) {
            return Err(BasisError::Formula {
                formula: format!("exp({exponent}z)"),
                reason: "an exponential shadow map needs an exponent above 0 and at most 700".to_owned(),
            });
        }
        let basis = format!("exp({exponent}z)").parse()?;
        Ok(Self { basis, exponent })
    }

    /// Bounds from E\[e^(c z)\] / e^(c z_f).
    fn bounds_at(&self, ratio: DoubleDouble, z_f: f64) -> Bounds {
        let lower = (DoubleDouble::one() - ratio).to_f64().max(0.0);
        // Attained in the limit: mass `lower` infinitely far in front. With ratio >= 1 all mass can lie behind z_f.
        let (support, weights) = if lower > 0.0 {
            (vec![z_f], vec![ratio.to_f64()])
        } else {
            (vec![z_f + ratio.ln().to_f64() / self.exponent], vec![1.0])
        };
        let at_z_f = (-(DoubleDouble::from(self.exponent) * DoubleDouble::from(z_f))).exp().to_f64();
        let lower_dual = if lower > 0.0 { vec![1.0, -at_z_f] } else { vec![0.0, 0.0] };
        let certificate = Certificate {
            lower_dual,
            upper_dual: vec![0.0, 0.0],
            worst_slack: 0.0,
            lower_proved: (lower - 4.0 * f64::EPSILON).max(0.0),
            upper_proved: 1.0,
        };
        Bounds { lower, upper: 1.0, support, weights, certificate }
    }
}

impl LowerBound for Markov {
    fn name(&self) -> &'static str {
        "Markov"
    }

    fn basis(&self) -> &Basis {
        &self.basis
    }

    fn interval(&self) -> Interval {
        Interval::Real
    }

    fn bounds_near(
        &self,
        moments: &[DoubleDouble],
        z_f: f64,
        _depths: &[f64],
    ) -> Result<Bounds, MomentError> {
        check_input(&self.basis, Interval::Real, moments, z_f)?;
        let moment = moments[0];
        if moment <= DoubleDouble::zero() {
            return Err(MomentError::Infeasible { residual: -moment.to_f64() });
        }
        // In logarithms, as e^(c z_f) may not be a double where the ratio is.
        let exponent = moment.ln() - DoubleDouble::from(self.exponent) * DoubleDouble::from(z_f);
        Ok(self.bounds_at(exponent.exp(), z_f))
    }

    /// From E\[e^(c (z - z_f))\], which does not overflow where it matters.
    fn bounds_of(&self, z: &DepthDistribution, z_f: f64) -> Result<Bounds, MomentError> {
        check_input(&self.basis, Interval::Real, &[DoubleDouble::one()], z_f)?;
        let power = |z: f64| DoubleDouble::from(self.exponent) * DoubleDouble::sum(z, -z_f);
        let terms = z.depths().iter().zip(z.weights()).map(|(&z, &w)| w * power(z).exp());
        Ok(self.bounds_at(terms.fold(DoubleDouble::zero(), |sum, term| sum + term), z_f))
    }
}

/// The closed form for this basis and interval, if there is one.
///
/// Power bases of order 2, 4, 6, 8 on the line, order 4 on \[0, 1\], the trigonometric basis of order 2 on \[0, 1\],
/// and one exponential e^(c z) on the line.
pub fn closed_form(basis: &Basis, interval: Interval) -> Result<Option<BoundMethod>, BasisError> {
    let order = basis.power_order();
    let exponent = if basis.len() == 1 { basis.functions()[0].exponential() } else { None };
    Ok(match interval {
        Interval::Real if order == Some(2) => Some(Box::new(Chebyshev::default())),
        Interval::Real if order == Some(4) => Some(Box::new(Hamburger::<4>::default())),
        Interval::Real if order == Some(6) => Some(Box::new(Hamburger::<6>::default())),
        Interval::Real if order == Some(8) => Some(Box::new(Hamburger::<8>::default())),
        Interval::Real => match exponent {
            Some(exponent) => Some(Box::new(Markov::new(exponent)?)),
            None => None,
        },
        Interval::Unit if order == Some(4) => Some(Box::new(Hausdorff4::new()?)),
        Interval::Unit if basis.is_trigonometric4() => Some(Box::new(Trigonometric4::new()?)),
        Interval::Unit => None,
    })
}
