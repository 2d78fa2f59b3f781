//! Exact coverage: integer edge functions at texel centres with the top-left rule.

use crate::prepare::{PreparedTriangle, SUBTEXELS};

/// An edge function divided by the sub-texel resolution: texel (x, y) lies inside where `a x + b y + c >= 0`.
///
/// At texel centres the edge function is `256 (a x + b y) + k`, the top-left rule included in `k`. Its sign does not
/// change when `k` is divided by 256 and rounded down, which saves 8 bits and loses nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    pub a: i64,
    pub b: i64,
    pub c: i64,
}

/// The three edges of a prepared triangle, over map texels.
pub(crate) fn edges(triangle: &PreparedTriangle) -> [Edge; 3] {
    let corner = triangle.corners.map(|c| c.map(i64::from));
    let half = i64::from(SUBTEXELS / 2);
    [0, 1, 2].map(|i| {
        let (p, q) = (corner[i], corner[(i + 1) % 3]);
        let (a, b) = (p[1] - q[1], q[0] - p[0]);
        // Corners run clockwise with y downwards: a > 0 has the inside to its right (a left edge), a = 0 and b > 0
        // has it below (a top edge). Centres on other edges belong to the neighbour.
        let owns_centres = a > 0 || (a == 0 && b > 0);
        let k = a * (half - p[0]) + b * (half - p[1]) - i64::from(!owns_centres);
        Edge { a, b, c: k >> SUBTEXELS.ilog2() }
    })
}

/// One end of a row's span as a linear function of the row, good for truncation to an integer.
#[derive(Clone, Copy)]
struct SpanEnd {
    at_row_0: f64,
    per_row: f64,
}

impl SpanEnd {
    /// First texel inside of an edge with `a > 0`, first texel beyond one with `a < 0`, rounded down.
    ///
    /// The quotient `(a x_0 + r) / |a|` with integer `r` is moved away from integers by half a unit of `r`, that is
    /// by `0.5 / |a|`. Rounding errors are below `2^-50 |c / a|` with `|c| < 2^38`, so truncation is exact.
    fn new(edge: Edge) -> Self {
        let sign = if edge.a > 0 { -1.0 } else { 1.0 };
        let size = edge.a.abs() as f64;
        let scale = 1.0 / size;
        Self {
            at_row_0: (size + sign * (0.5 + edge.c as f64)) * scale,
            per_row: sign * edge.b as f64 * scale,
        }
    }

    #[inline]
    fn at(&self, row: f64) -> u32 {
        // The cast maps everything negative to 0.
        (self.at_row_0 + self.per_row * row) as u32
    }
}

/// Calls `covered(y, first..end)` for the covered texels of each row in `rows`, where there are any.
#[inline]
pub(crate) fn for_each_span(
    triangle: &PreparedTriangle,
    rows: std::ops::Range<u32>,
    mut covered: impl FnMut(u32, std::ops::Range<u32>),
) {
    let [x0, y0, x1, y1] = triangle.bounds.map(u32::from);
    let (mut top, mut bottom) = (i64::from(rows.start.max(y0)), i64::from(rows.end.min(y1)));
    // Unused ends stay at the bounds.
    let mut firsts = [SpanEnd { at_row_0: f64::from(x0), per_row: 0.0 }; 2];
    let mut ends = [SpanEnd { at_row_0: f64::from(x1), per_row: 0.0 }; 2];
    let (mut first_count, mut end_count) = (0, 0);
    for edge in edges(triangle) {
        if edge.a > 0 {
            firsts[first_count] = SpanEnd::new(edge);
            first_count += 1;
        } else if edge.a < 0 {
            ends[end_count] = SpanEnd::new(edge);
            end_count += 1;
        } else if edge.b > 0 {
            top = top.max(-edge.c.div_euclid(edge.b));
        } else {
            bottom = bottom.min(edge.c.div_euclid(-edge.b) + 1);
        }
    }
    for y in top..bottom {
        let row = y as f64;
        let first = firsts[0].at(row).max(firsts[1].at(row)).max(x0);
        let end = ends[0].at(row).min(ends[1].at(row)).min(x1);
        if first < end {
            covered(y as u32, first..end);
        }
    }
}
