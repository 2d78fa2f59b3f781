//! Exact coverage: integer edge functions at texel centres with the top-left rule.

use crate::stack::prepare::{PreparedTriangle, SUBTEXELS};

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

/// Calls `covered(y, first..end)` with the covered texels of each row in `rows`; the range may be empty.
#[inline]
pub(crate) fn for_each_span(
    triangle: &PreparedTriangle,
    rows: std::ops::Range<u32>,
    mut covered: impl FnMut(u32, std::ops::Range<u32>),
) {
    match small_edges(triangle) {
        Some(edges) => small_spans(triangle, edges, rows, covered),
        // Through a pointer, so that the only direct call is inlined where rows are short.
        None => large_spans(triangle, rows, &mut covered),
    }
}

/// Distance in sub-texels from the first texel's centre that the corners of a small triangle stay below.
const SMALL: i32 = 64 * SUBTEXELS;

/// As [`edges`], over texels relative to the bounds and within 32 bits: `|a|, |b| < 2^15`, `|c| < 2^22`.
#[inline]
fn small_edges(triangle: &PreparedTriangle) -> Option<[[i32; 3]; 3]> {
    let [x0, y0, ..] = triangle.bounds.map(i32::from);
    let centre = [x0, y0].map(|first| first * SUBTEXELS + SUBTEXELS / 2);
    let corner = triangle.corners.map(|c| [c[0] - centre[0], c[1] - centre[1]]);
    // Any bit above those of numbers below 2 * SMALL tells of a coordinate out of range, negative ones included.
    let bits = corner.iter().flatten().fold(0, |bits, &c| bits | (c + SMALL));
    if bits as u32 >= 2 * SMALL as u32 {
        return None;
    }
    Some([0, 1, 2].map(|i| {
        let (p, q) = (corner[i], corner[(i + 1) % 3]);
        let (a, b) = (p[1] - q[1], q[0] - p[0]);
        let owns_centres = a > 0 || (a == 0 && b > 0);
        [a, b, -(a * p[0] + b * p[1] + i32::from(!owns_centres)) >> SUBTEXELS.ilog2()]
    }))
}

/// One end of a row's span of a small triangle in units of 2^-32 texel, rounded down by a shift.
#[derive(Clone, Copy)]
struct SmallEnd {
    at_row: i64,
    per_row: i64,
}

impl SmallEnd {
    /// First texel inside of an edge with `a > 0`, first texel beyond one with `a < 0`, at row `row`.
    ///
    /// With `m = b y + c` both are `(a - m - r) / a` rounded down for every `r` between 0 and 1. The middle,
    /// `r = 0.5`, lies `0.5 / |a| > 2^-16` from integers, and the errors of 64 rows sum up to less than `2^-25`.
    #[inline]
    fn new([a, b, c]: [i32; 3], row: i32) -> Self {
        const ONE: i64 = 1 << 32;
        let scale = -(ONE as f64) / f64::from(a);
        let per_row = (f64::from(b) * scale) as i64;
        let at_row_0 = ONE + ((f64::from(c) + 0.5) * scale) as i64;
        Self { at_row: at_row_0 + per_row * i64::from(row), per_row }
    }

    #[inline]
    fn step(&mut self) {
        self.at_row += self.per_row;
    }
}

/// Relies on the order of [`clockwise`](crate::stack::prepare::clockwise) corners.
#[inline]
fn small_spans(
    triangle: &PreparedTriangle,
    [right, middle, left]: [[i32; 3]; 3],
    rows: std::ops::Range<u32>,
    mut covered: impl FnMut(u32, std::ops::Range<u32>),
) {
    let [x0, y0, x1, y1] = triangle.bounds.map(u32::from);
    let (top, mut bottom) = (rows.start.max(y0), rows.end.min(y1));
    let width = i64::from(x1 - x0);
    let row = top as i32 - y0 as i32;
    let still = |x: i64| SmallEnd { at_row: x << 32, per_row: 0 };
    // The last edge is a left one. The first one, unless it is a top edge that the bounds stand for, is a right one.
    let mut first = SmallEnd::new(left, row);
    let mut end = if right[0] < 0 { SmallEnd::new(right, row) } else { still(width) };
    let (mut second_first, mut second_end) = (still(0), still(width));
    match middle[0] {
        0 => bottom = bottom.min((i64::from(y0) + 1 + i64::from(middle[2].div_euclid(-middle[1]))) as u32),
        a => *(if a > 0 { &mut second_first } else { &mut second_end }) = SmallEnd::new(middle, row),
    }
    for y in top..bottom {
        let from = (first.at_row.max(second_first.at_row).max(0) >> 32).min(width);
        let to = (end.at_row.min(second_end.at_row) >> 32).min(width).max(from);
        covered(y, x0 + from as u32..x0 + to as u32);
        for end in [&mut first, &mut second_first, &mut end, &mut second_end] {
            end.step();
        }
    }
}

/// One end of a row's span of any triangle as a linear function of the row, good for truncation to an integer.
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

fn large_spans(
    triangle: &PreparedTriangle,
    rows: std::ops::Range<u32>,
    covered: &mut dyn FnMut(u32, std::ops::Range<u32>),
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
        covered(y as u32, first.min(x1)..end.max(first.min(x1)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stack::fixed_point::Plane;
    use crate::stack::prepare::{NO_MASK, area_twice, clockwise};

    /// Random triangles, half of them on a coarse grid for edges through centres, with bounds that cut some off.
    #[test]
    fn both_kinds_of_spans_agree_with_the_edges() {
        let mut state = 1u32;
        let mut random = |end: i32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as i32 % end
        };
        let mut covered = 0;
        for case in 0..20_000 {
            let grid = if case % 2 == 0 { 1 } else { 128 };
            let corners = [0; 3].map(|_| [0; 2].map(|_| random(6000 / grid) * grid - 1000));
            let (area, bounds) = (area_twice(corners), bounds(corners));
            if area == 0 || bounds[0] >= bounds[2] || bounds[1] >= bounds[3] {
                continue;
            }
            let triangle = PreparedTriangle {
                corners: clockwise(corners, area),
                depth: Plane { base: 0, step: [0; 2] },
                depth_low: 0,
                depth_high: 0,
                bounds: bounds.map(|v| v as u16),
                mask: NO_MASK,
            };
            let [x0, y0, x1, y1] = triangle.bounds.map(u32::from);
            let edges = edges(&triangle);
            let inside =
                |x: u32, y: u32| edges.iter().all(|e| e.a * i64::from(x) + e.b * i64::from(y) + e.c >= 0);
            let exact: Vec<_> =
                (y0..y1).flat_map(|y| (x0..x1).filter(move |&x| inside(x, y)).map(move |x| (x, y))).collect();
            let (mut small, mut large) = (Vec::new(), Vec::new());
            let small_edges = small_edges(&triangle).expect("corners within 64 texels");
            small_spans(&triangle, small_edges, 0..64, |y, span| small.extend(span.map(|x| (x, y))));
            large_spans(&triangle, 0..64, &mut |y, span| large.extend(span.map(|x| (x, y))));
            assert_eq!((&small, &large), (&exact, &exact), "{corners:?}");
            covered += exact.len();
        }
        assert!(covered > 100_000);
    }

    /// As in preparation, for a map of 16 x 64 texels.
    fn bounds(corners: [[i32; 2]; 3]) -> [i32; 4] {
        let of = |k: usize, size: i32| {
            let [low, high] = [i32::min, i32::max].map(|f| f(f(corners[0][k], corners[1][k]), corners[2][k]));
            [(low + 127).div_euclid(256).max(0), ((high - 128).div_euclid(256) + 1).min(size)]
        };
        let ([x0, x1], [y0, y1]) = (of(0, 16), of(1, 64));
        [x0, y0, x1, y1]
    }
}
