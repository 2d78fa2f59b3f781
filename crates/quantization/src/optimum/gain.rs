//! What a transform gains.

use crate::interval::DepthInterval;
use moment_problem::Basis;

/// Bits of entropy that a transform gains: log2 |det theta| (MSM15 Proposition 6), for powers of depth in the units of
/// depths in \[0, 1\], whatever the interval.
///
/// Powers on an interval of length L are powers on \[0, 1\] times a triangular matrix of determinant L^(m(m+1)/2); so
/// transforms for \[-1, 1\] and for \[0, 1\] can be compared. For other bases it is log2 |det theta| as it stands.
pub fn gain_bits(basis: &Basis, interval: DepthInterval, log2_determinant: f64) -> f64 {
    match basis.power_order() {
        Some(m) => log2_determinant + 0.5 * (m * (m + 1)) as f64 * interval.length().log2(),
        None => log2_determinant,
    }
}
