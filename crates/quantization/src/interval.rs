//! Depth intervals.

use crate::error::QuantizationError;
use moment_problem::{Interval, MomentBound};
use std::fmt;

/// The depths on which a basis is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthInterval {
    start: f64,
    end: f64,
}

impl DepthInterval {
    /// Depths from 0 at the light to 1 at the far plane (MSM15).
    pub const UNIT: Self = Self { start: 0.0, end: 1.0 };
    /// Depths from -1 to 1 (GDC16).
    pub const SIGNED: Self = Self { start: -1.0, end: 1.0 };

    /// The values of [`MomentBound::variable`], the variable whose functions a shadow map stores.
    pub fn of_variable(bound: MomentBound) -> Self {
        match bound.interval() {
            Interval::Real => Self::SIGNED,
            Interval::Unit => Self::UNIT,
        }
    }

    /// Depths from `start` to `end`.
    ///
    /// # Errors
    /// [`QuantizationError::Interval`] unless both are finite and `start < end`.
    pub fn new(start: f64, end: f64) -> Result<Self, QuantizationError> {
        if start < end && (end - start).is_finite() {
            return Ok(Self { start, end });
        }
        Err(QuantizationError::Interval { start, end })
    }

    /// First depth.
    pub fn start(self) -> f64 {
        self.start
    }

    /// Last depth.
    pub fn end(self) -> f64 {
        self.end
    }

    /// Its length.
    pub fn length(self) -> f64 {
        self.end - self.start
    }

    /// The depth in the middle.
    pub fn centre(self) -> f64 {
        self.start + 0.5 * self.length()
    }

    /// The depth at t in \[-1, 1\], ends exact.
    pub fn at(self, t: f64) -> f64 {
        if t >= 0.0 {
            self.end - 0.5 * (1.0 - t) * self.length()
        } else {
            self.start + 0.5 * (1.0 + t) * self.length()
        }
    }
}

impl fmt::Display for DepthInterval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}, {}]", self.start, self.end)
    }
}
