//! SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
//!
//! Scenes, searches and records depend on its numbers, so that no dependency may change them.

/// A stream of random numbers that is the same on every platform.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// SplitMix64 from this state.
    pub fn new(state: u64) -> Self {
        Self(state)
    }

    /// A stream of a seed; those of one seed are independent of each other.
    pub fn stream(seed: u64, stream: u64) -> Self {
        let mixed = Self(seed).next_bits() ^ stream.wrapping_mul(0xd1b5_4a32_d192_ed03);
        Self(Self(mixed).next_bits())
    }

    /// A part of [`Random::stream`], independent of its other parts.
    pub fn substream(seed: u64, stream: u64, part: u64) -> Self {
        Self(Self::stream(seed, stream).0 ^ part.wrapping_mul(0x8cb9_2ba7_2f3d_8dd7))
    }

    /// 64 random bits.
    pub fn next_bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Uniform in \[0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next_bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in \[low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// One of 0 to `count` - 1, by the remainder: as good as uniform for counts far below 2^64.
    ///
    /// # Panics
    /// If `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next_bits() % count as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published stream, and those derived from it as committed results have them.
    #[test]
    fn the_numbers_are_those_of_the_records() {
        let first = |mut random: Random| [random.next_bits(), random.next_bits()];
        assert_eq!(first(Random::new(0)), [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
        assert_eq!(first(Random::stream(7, 3)), STREAM);
        assert_eq!(first(Random::substream(7, 3, 5)), SUBSTREAM);
        assert_eq!(Random::substream(7, 3, 0).next_bits(), Random::stream(7, 3).next_bits());
    }
    const STREAM: [u64; 2] = [0xa23c_e36a_952f_3aa3, 0xa093_2389_bb30_0308];
    const SUBSTREAM: [u64; 2] = [0x3efb_9371_e281_bd61, 0xc7b0_8781_4c48_c9ab];
}
