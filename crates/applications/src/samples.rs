//! Points that cover a light or a filter evenly: Halton's sequence, randomised nets, and Poisson discs.

use random_stream::Random;

/// The index at which Halton's sequence is begun: index 0 is the corner (0, 0), the same in every base.
pub const HALTON_START: u64 = 1;

/// Digits of `index` in `base`, mirrored at the point: the van der Corput sequence, in \[0, 1).
pub fn radical_inverse(mut index: u64, base: u64) -> f64 {
    // The mirrored number is kept whole, so that only the last division rounds.
    let (mut mirrored, mut size) = (0u128, 1u128);
    while index > 0 {
        mirrored = mirrored * u128::from(base) + u128::from(index % base);
        size *= u128::from(base);
        index /= base;
    }
    mirrored as f64 / size as f64
}

/// Point of Halton's sequence in bases 2 and 3.
pub fn halton(index: u64) -> [f64; 2] {
    [radical_inverse(index, 2), radical_inverse(index, 3)]
}

/// Shirley and Chiu's map of \[-1, 1\]^2 onto the unit disc (A Low Distortion Map Between Disk and Square, 1997):
/// squares become circles, equal areas stay equal.
pub fn concentric_disc([x, y]: [f64; 2]) -> [f64; 2] {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let (radius, angle) = if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    } else if x.abs() > y.abs() {
        (x, FRAC_PI_4 * (y / x))
    } else {
        (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
    };
    [radius * angle.cos(), radius * angle.sin()]
}

/// Bits of a coordinate of a net.
const BITS: u32 = 32;

/// The first points of Sobol's (0, 2)-sequence under Owen's nested uniform scrambling: every dyadic rectangle of area
/// 2^-k holds one of each 2^k consecutive points, and each point alone is uniform. Nets of different `stream` are
/// independent.
#[derive(Clone, Debug)]
pub struct ScrambledNet {
    points: Vec<[u32; 2]>,
}

impl ScrambledNet {
    /// So many points.
    pub fn new(count: usize, seed: u64, stream: u64) -> Self {
        let mut random = Random::stream(seed, stream);
        let keys = [random.next_bits(), random.next_bits()];
        let scrambled = |index| {
            let point = sobol(index);
            [owen(point[0], keys[0]), owen(point[1], keys[1])]
        };
        Self { points: (0..count as u32).map(scrambled).collect() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// A point in \[0, 1)^2 after an exclusive or with the bits of `shift`, which leaves a net a net and makes nets of
    /// random shifts independent: a net a receiver at the price of two operations.
    pub fn shifted(&self, index: usize, shift: u64) -> [f64; 2] {
        let [x, y] = self.points[index];
        // Half a step off the lower left corner, so that no point lies on the outline.
        let unit = |bits: u32| (f64::from(bits) + 0.5) / 4_294_967_296.0;
        [unit(x ^ (shift >> 32) as u32), unit(y ^ shift as u32)]
    }
}

/// Sobol's first two dimensions: van der Corput's sequence, and Pascal's triangle modulo 2.
fn sobol(index: u32) -> [u32; 2] {
    let mut second = 0;
    let mut column = 1u32 << (BITS - 1);
    let mut rest = index;
    while rest > 0 {
        if rest & 1 == 1 {
            second ^= column;
        }
        column ^= column >> 1;
        rest >>= 1;
    }
    [index.reverse_bits(), second]
}

/// Flips each bit by a coin that depends on all bits before it.
fn owen(value: u32, key: u64) -> u32 {
    let mut flips = 0;
    for bit in 0..BITS {
        // A leading one tells prefixes of different lengths apart.
        let prefix = (u64::from(value) | 1 << BITS) >> (BITS - bit);
        flips |= ((Random::stream(key, prefix).next_bits() >> 63) as u32) << (BITS - 1 - bit);
    }
    value ^ flips
}

/// Where taps lie.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum TapShape {
    /// Within the unit disc.
    Disc,
    /// Within \[-1, 1\]^2.
    Square,
}

/// Points that keep their distance: each is the one of many candidates that is farthest from those before it (Mitchell's best
/// candidate), the first lies at random.
#[derive(Clone, Debug, PartialEq)]
pub struct PoissonTaps(Vec<[f64; 2]>);

/// Candidates a point and point before it.
const CANDIDATES: usize = 32;

impl PoissonTaps {
    /// So many points; those of different streams are independent.
    pub fn new(shape: TapShape, count: usize, seed: u64, stream: u64) -> Self {
        let mut random = Random::stream(seed, stream);
        let mut points: Vec<[f64; 2]> = Vec::with_capacity(count);
        while points.len() < count {
            let mut best = ([0.0; 2], f64::NEG_INFINITY);
            for _ in 0..CANDIDATES * (points.len() + 1) {
                let candidate = [random.within(-1.0, 1.0), random.within(-1.0, 1.0)];
                if shape == TapShape::Disc && candidate[0].hypot(candidate[1]) > 1.0 {
                    continue;
                }
                let distance = |p: &[f64; 2]| (p[0] - candidate[0]).hypot(p[1] - candidate[1]);
                let nearest = points.iter().map(distance).fold(f64::INFINITY, f64::min);
                if nearest > best.1 {
                    best = (candidate, nearest);
                }
            }
            points.push(best.0);
        }
        Self(points)
    }

    /// The points.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halton_starts_as_published() {
        assert_eq!(halton(HALTON_START), [0.5, 1.0 / 3.0]);
        assert_eq!(halton(6), [0.375, 2.0 / 9.0]);
        assert_eq!(radical_inverse(1 << 60, 2), 0.5f64.powi(61));
    }

    /// The property that gives nets their name, before and after scrambling and shifting.
    #[test]
    fn each_dyadic_rectangle_holds_one_point() {
        for (seed, shift) in [(1, 0), (2, 0x0123_4567_89ab_cdef)] {
            let net = ScrambledNet::new(256, seed, 5);
            for first in [0, 64, 128, 192] {
                for width in 0..=6 {
                    let mut seen = [false; 64];
                    for i in first..first + 64 {
                        let [x, y] = net.shifted(i, shift);
                        assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                        let cell = (x * f64::from(1 << width)) as usize;
                        let row = (y * f64::from(1 << (6 - width))) as usize;
                        let slot = cell * (1 << (6 - width)) + row;
                        assert!(!std::mem::replace(&mut seen[slot], true), "{width} {slot}");
                    }
                }
            }
        }
        assert_ne!(ScrambledNet::new(4, 1, 5).points, ScrambledNet::new(4, 1, 6).points);
        assert_ne!(ScrambledNet::new(4, 1, 5).points, ScrambledNet::new(4, 2, 5).points);
    }

    /// Scrambling must not be a shift alone: points of one prefix go their own ways below it.
    #[test]
    fn scrambling_is_nested() {
        let (a, b) = (owen(0x8000_0000, 3), owen(0x0000_0000, 3));
        assert_eq!((a ^ b) >> 31, 1);
        assert_ne!(a << 1, b << 1);
    }

    /// Rings of equal area hold equal shares of an even grid.
    #[test]
    fn discs_keep_areas() {
        let n = 400;
        let mut rings = [0usize; 4];
        let mut quarters = [0usize; 4];
        for i in 0..n * n {
            let at = |k: usize| (k as f64 + 0.5) / n as f64 * 2.0 - 1.0;
            let [x, y] = concentric_disc([at(i % n), at(i / n)]);
            let square = x * x + y * y;
            assert!(square <= 1.0 + 1e-12);
            rings[((square * 4.0) as usize).min(3)] += 1;
            quarters[usize::from(x > 0.0) + 2 * usize::from(y > 0.0)] += 1;
        }
        let quarter = (n * n / 4) as f64;
        // Squares of the grid become circles, and one of 200 may fall to either side of a ring's border.
        assert!(rings.iter().all(|&r| (r as f64 / quarter - 1.0).abs() < 0.02), "{rings:?}");
        assert!(quarters.iter().all(|&q| (q as f64 / quarter - 1.0).abs() < 0.001), "{quarters:?}");
    }

    #[test]
    fn taps_keep_their_distance_and_lie_inside() {
        for shape in [TapShape::Disc, TapShape::Square] {
            let taps = PoissonTaps::new(shape, 16, 1, 0);
            assert_eq!(taps.points().len(), 16);
            assert_ne!(taps, PoissonTaps::new(shape, 16, 1, 1));
            let mut nearest = f64::INFINITY;
            for (i, a) in taps.points().iter().enumerate() {
                assert!(shape == TapShape::Square || a[0].hypot(a[1]) <= 1.0);
                for b in &taps.points()[..i] {
                    nearest = nearest.min((a[0] - b[0]).hypot(a[1] - b[1]));
                }
            }
            // 16 random points of the disc come as near as 0.08 on average.
            assert!(nearest > 0.25, "{shape:?}: {nearest}");
        }
    }
}
