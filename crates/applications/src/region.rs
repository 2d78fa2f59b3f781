//! Rectangles of a map, and how they fall on its texels.

use moment_problem::arithmetic::Real;

/// A rectangle in texel coordinates: texel (i, j) covers \[i, i+1) x \[j, j+1). Low corner first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region<R> {
    /// Least x and y.
    pub low: [R; 2],
    /// Greatest x and y, not below `low`.
    pub high: [R; 2],
}

impl<R: Real> Region<R> {
    /// The rectangle of the given full widths about a point.
    pub fn around(centre: [R; 2], widths: [R; 2]) -> Self {
        let half = widths.map(|width| R::from_f64(0.5) * width);
        Self { low: [0, 1].map(|k| centre[k] - half[k]), high: [0, 1].map(|k| centre[k] + half[k]) }
    }

    /// Both ends t of each axis at floor(t + u).
    pub fn rounded(&self, u: [R; 2]) -> Self {
        let round = |corner: [R; 2]| [0, 1].map(|k| R::from_f64((corner[k] + u[k]).to_f64().floor()));
        Self { low: round(self.low), high: round(self.high) }
    }

    /// Area in texels.
    pub fn area(&self) -> R {
        (self.high[0] - self.low[0]) * (self.high[1] - self.low[1])
    }
}

/// Neighbouring texels of one axis, all covered alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// First texel.
    pub first: usize,
    /// Last texel, included.
    pub last: usize,
    /// Covered share of each, in (0, 1\].
    pub covered: f64,
}

impl Piece {
    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.last - self.first + 1
    }
}

/// At most three pieces: a part of a texel, whole texels, a part of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pieces {
    pieces: [Piece; 3],
    count: usize,
}

impl Pieces {
    /// All pieces, ascending.
    pub fn as_slice(&self) -> &[Piece] {
        &self.pieces[..self.count]
    }

    fn one(first: usize, last: usize, covered: f64) -> Self {
        Self { pieces: [Piece { first, last, covered }; 3], count: 1 }
    }

    /// The texels that an interval covers, and how much of each. What lies outside of the `size` texels is cut off; an
    /// interval without length, or outside altogether, is the texel that is nearest.
    pub fn covered(low: f64, high: f64, size: usize) -> Self {
        let (low, high) = clip(low, high, size);
        let (first, last) = (low.floor(), high.ceil());
        // Not of NaN either.
        let has_length = high > low;
        if !has_length {
            let texel = (first as usize).min(size - 1);
            return Self::one(texel, texel, 1.0);
        }
        if last - first <= 1.0 {
            return Self::one(first as usize, first as usize, high - low);
        }
        let mut found = Self { count: 0, ..Self::one(0, 0, 1.0) };
        let mut push = |first: f64, end: f64, covered: f64| {
            if end > first && covered > 0.0 {
                found.pieces[found.count] = Piece { first: first as usize, last: end as usize - 1, covered };
                found.count += 1;
            }
        };
        let (whole, end) = (low.ceil(), high.floor());
        push(first, whole, whole - low);
        push(whole, end, 1.0);
        push(end, last, high - end);
        found
    }

    /// All texels that an interval touches, whole (BHS16 section 3.5). Cut off as in [`Pieces::covered`].
    pub fn outwards(low: f64, high: f64, size: usize) -> Self {
        let (low, high) = clip(low, high, size);
        let first = (low.floor() as usize).min(size - 1);
        let last = (high.ceil() as usize).max(first + 1) - 1;
        Self::one(first, last, 1.0)
    }

    /// The interval with its ends moved to the nearest border between texels; at least one texel.
    pub fn nearest(low: f64, high: f64, size: usize) -> Self {
        let (low, high) = clip(low, high, size);
        let (first, end) = ((low + 0.5).floor(), (high + 0.5).floor());
        if end > first { Self::outwards(first, end, size) } else { Self::outwards(low, low, size) }
    }
}

fn clip(low: f64, high: f64, size: usize) -> (f64, f64) {
    let limit = size as f64;
    (low.clamp(0.0, limit), high.clamp(0.0, limit))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(pieces: Pieces) -> Vec<(usize, usize, f64)> {
        pieces.as_slice().iter().map(|p| (p.first, p.last, p.covered)).collect()
    }

    #[test]
    fn intervals_fall_on_texels() {
        assert_eq!(list(Pieces::covered(1.25, 4.5, 8)), [(1, 1, 0.75), (2, 3, 1.0), (4, 4, 0.5)]);
        assert_eq!(list(Pieces::covered(1.25, 2.5, 8)), [(1, 1, 0.75), (2, 2, 0.5)]);
        assert_eq!(list(Pieces::covered(1.25, 1.5, 8)), [(1, 1, 0.25)]);
        assert_eq!(list(Pieces::covered(1.0, 4.0, 8)), [(1, 3, 1.0)]);
        assert_eq!(list(Pieces::covered(1.0, 4.5, 8)), [(1, 3, 1.0), (4, 4, 0.5)]);
        assert_eq!(list(Pieces::covered(1.5, 2.0, 8)), [(1, 1, 0.5)]);
        assert_eq!(list(Pieces::covered(3.5, 3.5, 8)), [(3, 3, 1.0)]);
        assert_eq!(list(Pieces::outwards(1.25, 4.5, 8)), [(1, 4, 1.0)]);
        assert_eq!(list(Pieces::outwards(1.0, 4.0, 8)), [(1, 3, 1.0)]);
        assert_eq!(list(Pieces::outwards(3.5, 3.5, 8)), [(3, 3, 1.0)]);
        assert_eq!(list(Pieces::nearest(1.25, 4.5, 8)), [(1, 4, 1.0)]);
        assert_eq!(list(Pieces::nearest(1.5, 1.6, 8)), [(1, 1, 1.0)]);
    }

    #[test]
    fn what_lies_outside_is_cut_off() {
        assert_eq!(list(Pieces::covered(-3.0, 1.5, 8)), [(0, 0, 1.0), (1, 1, 0.5)]);
        assert_eq!(list(Pieces::covered(6.5, 30.0, 8)), [(6, 6, 0.5), (7, 7, 1.0)]);
        for (low, high, texel) in [(-5.0, -2.0, 0), (-5.0, 0.0, 0), (8.0, 9.0, 7), (9.0, 9.0, 7)] {
            for found in
                [Pieces::covered(low, high, 8), Pieces::outwards(low, high, 8), Pieces::nearest(low, high, 8)]
            {
                assert_eq!(list(found), [(texel, texel, 1.0)], "{low} {high}");
            }
        }
        let all = Pieces::outwards(f64::NEG_INFINITY, f64::INFINITY, 8);
        assert_eq!(list(all), [(0, 7, 1.0)]);
    }
}
