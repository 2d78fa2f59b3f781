//! What a frame costs, modelled: memory traffic and arithmetic, the two things that graphics processors run out of.
//!
//! It orders candidates where no graphics processor is at hand, the same on every machine; it is no time. Per texel a map
//! is written when it is encoded, and read and written by both filter passes; the depth that it is made from is written
//! and read once. Each pixel reads a texel and computes the bound.

use super::settings::FrameSetting;

/// Reads and writes of a texel of the filtered map: encoding, two passes.
const ACCESSES: f64 = 5.0;

/// Bytes of a depth, written and read.
const DEPTH_BYTES: f64 = 8.0;

/// Single-precision operations that a graphics processor does in the time in which it moves a byte: 14 by the data sheet of
/// the one that MSM15 measured on (GTX 780: 4.0e12 operations and 2.9e11 bytes a second), more on later ones.
pub(crate) const OPERATIONS_PER_BYTE: f64 = 16.0;

/// A texture fetch of up to four channels, in operations.
pub(crate) const FETCH: f64 = shadow_filtering::SPECIAL as f64;

/// Modelled cost of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameCost {
    pub(crate) bytes: f64,
    pub(crate) operations: f64,
}

impl FrameCost {
    /// Of a filtered map of `side` x `side` texels.
    pub(crate) fn prefiltered(
        frame: FrameSetting,
        side: u32,
        (bits, channels): (usize, usize),
        kernel: usize,
        shading: f64,
    ) -> Self {
        let texel = bits as f64 / 8.0;
        let (texels, pixels) = (f64::from(side).powi(2), pixels(frame));
        let fetches = channels.div_ceil(4) as f64;
        // Each tap of both passes is a fetch, a product and a sum.
        let filtering = 2.0 * kernel as f64 * (fetches * FETCH + 2.0 * channels as f64);
        Self {
            bytes: texels * (DEPTH_BYTES + ACCESSES * texel) + pixels * texel,
            operations: texels * filtering + pixels * (fetches * FETCH + shading),
        }
    }

    /// Of percentage-closer filtering, whose neighbouring pixels find their taps in the cache.
    pub(crate) fn comparison(frame: FrameSetting, side: u32, kernel: usize) -> Self {
        let (texels, pixels) = (f64::from(side).powi(2), pixels(frame));
        let taps = (kernel * kernel) as f64;
        // Fetch, comparison, product and sum.
        Self {
            bytes: texels * DEPTH_BYTES / 2.0 + pixels * DEPTH_BYTES / 2.0,
            operations: pixels * taps * (FETCH + 3.0),
        }
    }

    /// One number, in bytes.
    pub(crate) fn total(self) -> f64 {
        self.bytes + self.operations / OPERATIONS_PER_BYTE
    }
}

fn pixels(frame: FrameSetting) -> f64 {
    f64::from(frame.width) * f64::from(frame.height)
}
