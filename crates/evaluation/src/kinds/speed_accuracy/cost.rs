//! What a frame costs, modelled: memory traffic and arithmetic, the two things that graphics processors run out of.
//!
//! It orders candidates where no graphics processor is at hand, the same on every machine; it is no time. Per texel a map
//! is written when it is encoded, and read and written by both filter passes; the depth that it is made from is written
//! and read once. Each pixel reads a texel and computes the bound.

use super::settings::FrameSetting;

/// Reads and writes of a texel of the filtered map: encoding, two passes.
const ACCESSES: f64 = 5.0;

/// Writes of a texel of a summed-area table by both passes, and the read of the second.
const SUM_ACCESSES: f64 = 3.0;

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
        let made = Self::made((bits, channels), side, kernel);
        Self {
            bytes: made.bytes + texels * DEPTH_BYTES + pixels * texel,
            operations: made.operations + pixels * (fetches * FETCH + shading),
        }
    }

    /// Of making a filtered map from a depth map, without the depth map and without what reads it.
    pub(crate) fn made((bits, channels): (usize, usize), side: u32, kernel: usize) -> Self {
        let texels = f64::from(side).powi(2);
        let fetches = channels.div_ceil(4) as f64;
        // Each tap of both passes is a fetch, a product and a sum.
        let filtering = 2.0 * kernel as f64 * (fetches * FETCH + 2.0 * channels as f64);
        Self { bytes: texels * ACCESSES * bits as f64 / 8.0, operations: texels * filtering }
    }

    /// Of percentage-closer filtering.
    pub(crate) fn comparison(frame: FrameSetting, side: u32, kernel: usize) -> Self {
        Self::compared(frame, side, (kernel * kernel) as f64)
    }

    /// Of a summed-area table: read and written by both passes, the second in place, beside the depth that it is made from.
    /// Each pixel reads so many corners of regions and does so many operations.
    pub(crate) fn summed(
        frame: FrameSetting,
        side: u32,
        (bits, channels): (usize, usize),
        (corners, shading): (f64, f64),
    ) -> Self {
        let texel = bits as f64 / 8.0;
        let (texels, pixels) = (f64::from(side).powi(2), pixels(frame));
        let fetches = channels.div_ceil(4) as f64;
        // Powers by products, a sum in each pass.
        let summing = 3.0 * channels as f64;
        Self {
            bytes: texels * (DEPTH_BYTES + SUM_ACCESSES * texel) + pixels * corners * texel,
            operations: texels * summing
                + pixels * (corners * (fetches * FETCH + 2.0 * channels as f64) + shading),
        }
    }

    /// Of comparing depths with so many texels a pixel, whose neighbouring pixels find them in the cache.
    pub(crate) fn compared(frame: FrameSetting, side: u32, taps: f64) -> Self {
        let (texels, pixels) = (f64::from(side).powi(2), pixels(frame));
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
