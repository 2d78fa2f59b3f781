//! What can go wrong, with the numbers in it.

use thiserror::Error;

/// A basis, a family file or a formula that cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BasisError {
    /// The text is not a formula in z.
    #[error("basis function `{formula}`: {reason}")]
    Formula {
        /// The offending text.
        formula: String,
        /// What is wrong with it.
        reason: String,
    },
    /// `power:M` or `trig:N` with a useless order.
    #[error("basis `{basis}`: the order must be a whole number from 1 to {largest}")]
    Order {
        /// The offending text.
        basis: String,
        /// Largest accepted order.
        largest: usize,
    },
    /// No function at all.
    #[error("a basis needs at least one function")]
    Empty,
    /// More functions than any solver here accepts.
    #[error("a basis of {count} functions is too large: at most {largest} are accepted")]
    TooLarge {
        /// Functions given.
        count: usize,
        /// Largest accepted number.
        largest: usize,
    },
    /// The same function twice.
    #[error("basis function `{name}` appears twice")]
    Duplicate {
        /// The repeated function.
        name: String,
    },
    /// A function without a finite value somewhere on the interval.
    #[error("basis function `{name}` is not finite at z = {z}")]
    NotFinite {
        /// The function.
        name: String,
        /// Where.
        z: f64,
    },
}

/// A depth distribution that is none.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DistributionError {
    /// No atom.
    #[error("a depth distribution needs at least one atom")]
    Empty,
    /// A depth that is not a finite number.
    #[error("depth {index} is {value}, which is not a finite number")]
    Depth {
        /// Position in the input.
        index: usize,
        /// The value.
        value: f64,
    },
    /// A weight that is negative or not finite.
    #[error("weight {index} is {value}; weights must be finite and not negative")]
    Weight {
        /// Position in the input.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Weights that are no probabilities.
    #[error("the weights sum to {sum}, not to 1 (tolerance {tolerance:e})")]
    Sum {
        /// Their sum.
        sum: f64,
        /// Accepted deviation.
        tolerance: f64,
    },
    /// Depths and weights of different lengths.
    #[error("{depths} depths but {weights} weights")]
    Length {
        /// Number of depths.
        depths: usize,
        /// Number of weights.
        weights: usize,
    },
}

/// Why there is no bound.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MomentError {
    /// The moment vector has the wrong length.
    #[error("{got} moments given, the basis has {expected} functions")]
    Length {
        /// Functions in the basis.
        expected: usize,
        /// Moments given.
        got: usize,
    },
    /// A moment or the fragment depth is NaN or infinite.
    #[error("{name} is {value}, which is not a finite number")]
    NotFinite {
        /// Which number.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A depth outside the interval of the problem.
    #[error("{name} = {value} lies outside the interval [0, 1]")]
    OutsideInterval {
        /// Which depth.
        name: String,
        /// Its value.
        value: f64,
    },
    /// No distribution on the interval has these moments.
    #[error(
        "no distribution on the interval has these moments (they miss the set of moments by {residual:e})"
    )]
    Infeasible {
        /// Distance to the set of moment vectors in orthonormal coordinates, or the violated quantity.
        residual: f64,
    },
    /// The Hankel (or Toeplitz) matrix has a negative pivot, so no distribution has these moments.
    #[error("no distribution has these moments: pivot {index} of the moment matrix is {pivot:e}")]
    NotPositiveDefinite {
        /// Which pivot, counted from 1.
        index: usize,
        /// Its value.
        pivot: f64,
    },
    /// Primal and dual values differ by more than a certified answer may.
    #[error("the bound could not be certified: proved and attained value differ by {gap:e}")]
    Uncertified {
        /// The difference.
        gap: f64,
    },
    /// A solver failed.
    #[error("solver {name}: {message}")]
    Solver {
        /// The solver.
        name: String,
        /// Its message.
        message: String,
    },
    /// The combination has no method here.
    #[error("{0}")]
    Unsupported(String),
    /// The basis itself is at fault.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// The distribution itself is at fault.
    #[error(transparent)]
    Distribution(#[from] DistributionError),
}

/// What an error blames.
#[derive(PartialEq)]
enum Blame {
    Method,
    Moments,
    Input,
}

impl MomentError {
    fn blame(&self) -> Blame {
        match self {
            Self::Uncertified { .. } | Self::Solver { .. } => Blame::Method,
            Self::Infeasible { .. } | Self::NotPositiveDefinite { .. } => Blame::Moments,
            Self::Length { .. }
            | Self::NotFinite { .. }
            | Self::OutsideInterval { .. }
            | Self::Unsupported(_)
            | Self::Basis(_)
            | Self::Distribution(_) => Blame::Input,
        }
    }

    /// Whether a method failed; else the input is at fault.
    pub fn is_failure(&self) -> bool {
        self.blame() == Blame::Method
    }

    /// Whether it says that no distribution has the moments: where they are those of one, the method has failed.
    pub fn denies_moments(&self) -> bool {
        self.blame() == Blame::Moments
    }

    /// Whether double-double may be at fault instead of the input: exact arithmetic is asked next.
    pub(crate) fn is_unresolved(&self) -> bool {
        self.is_failure() || matches!(self, Self::Infeasible { .. })
    }
}
