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
        Edge { a, b, c: k.div_euclid(i64::from(SUBTEXELS)) }
    })
}

/// Triangles at most this wide are tested texel by texel, wider ones solve for the ends of each row's span.
const TESTED_WIDTH: u16 = 16;

/// Calls `covered(x, y)` for every covered texel in rows `rows`, by rows, each row from left to right.
#[inline]
pub(crate) fn for_each_covered(
    triangle: &PreparedTriangle,
    rows: std::ops::Range<u32>,
    mut covered: impl FnMut(u32, u32),
) {
    let edges = edges(triangle);
    let [x0, y0, x1, y1] = triangle.bounds.map(u32::from);
    let rows = rows.start.max(y0)..rows.end.min(y1);
    if x1 - x0 <= u32::from(TESTED_WIDTH) {
        for y in rows {
            let mut e = edges.map(|e| e.a * i64::from(x0) + e.b * i64::from(y) + e.c);
            for x in x0..x1 {
                if e[0] | e[1] | e[2] >= 0 {
                    covered(x, y);
                }
                for i in 0..3 {
                    e[i] += edges[i].a;
                }
            }
        }
        return;
    }
    for y in rows {
        let (mut first, mut last) = (i64::from(x0), i64::from(x1) - 1);
        for Edge { a, b, c } in edges {
            let at_zero = b * i64::from(y) + c;
            match a {
                0 if at_zero < 0 => last = first - 1,
                0 => {}
                1.. => first = first.max(-at_zero.div_euclid(a)),
                _ => last = last.min(at_zero.div_euclid(-a)),
            }
        }
        for x in first..=last {
            covered(x as u32, y);
        }
    }
}
