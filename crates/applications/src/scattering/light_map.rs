//! Visibility as a directional light's shadow map knows it, exactly: piecewise constant along any ray.

use shadow_filtering::DepthMap;

use super::Medium;

/// A shadow map with its place in light space, where z is the way that light travels.
#[derive(Clone, Copy)]
pub struct LightMap<'a> {
    /// The map; depth 0 and 1 are at `near` and `near + range`.
    pub map: &'a DepthMap,
    /// x and y at the corner of texel (0, 0).
    pub corner: [f64; 2],
    /// Extent of a texel in x and y.
    pub texel: [f64; 2],
    /// z of depth 0.
    pub near: f64,
    /// Length of the range of depths in z.
    pub range: f64,
}

/// Where a ray is lit: from a distance to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitInterval {
    /// Where light begins.
    pub start: f64,
    /// Where it ends.
    pub end: f64,
}

impl LightMap<'_> {
    /// z up to which a point is lit; infinity outside of the map, and where it is empty: cleared to depth 1.
    pub fn occluder(&self, x: f64, y: f64) -> f64 {
        let at = |value: f64, k: usize| (value - self.corner[k]) / self.texel[k];
        let (column, row) = (at(x, 0).floor(), at(y, 1).floor());
        let inside =
            column >= 0.0 && row >= 0.0 && column < self.map.width() as f64 && row < self.map.height() as f64;
        if !inside {
            return f64::INFINITY;
        }
        let depth = self.map.depths()[row as usize * self.map.width() + column as usize];
        if depth < 1.0 { self.near + f64::from(depth) * self.range } else { f64::INFINITY }
    }

    /// Whether a point in light space is lit.
    pub fn is_lit(&self, [x, y, z]: [f64; 3]) -> bool {
        z <= self.occluder(x, y)
    }

    /// All distances at which a ray of some length, which may be infinite, is lit, ascending: from texel border to texel
    /// border, and within a texel from or to where the ray passes the occluder's depth.
    pub fn lit(&self, origin: [f64; 3], direction: [f64; 3], length: f64) -> Vec<LitInterval> {
        let mut borders = [0, 1].map(|k| self.borders(k, origin, direction, length).peekable());
        let mut lit: Vec<LitInterval> = Vec::new();
        let mut reached = 0.0;
        while reached < length {
            let [a, b] = &mut borders;
            let next = match (a.peek(), b.peek()) {
                (Some(first), Some(second)) if first > second => b.next(),
                (Some(_), _) => a.next(),
                (None, _) => b.next(),
            };
            let (start, end) = (reached, next.unwrap_or(length));
            reached = end;
            let has_length = end > start;
            if !has_length {
                continue;
            }
            let middle = if end.is_finite() { 0.5 * (start + end) } else { start + 1.0 };
            let at = |k: usize| origin[k] + middle * direction[k];
            let limit = self.occluder(at(0), at(1));
            // z <= limit.
            let passed = (limit - origin[2]) / direction[2];
            let (from, to) = if limit == f64::INFINITY {
                (start, end)
            } else if direction[2] == 0.0 {
                if origin[2] <= limit { (start, end) } else { (end, end) }
            } else if direction[2] > 0.0 {
                (start, end.min(passed))
            } else {
                (start.max(passed), end)
            };
            if to > from {
                match lit.last_mut() {
                    Some(last) if last.end == from => last.end = to,
                    _ => lit.push(LitInterval { start: from, end: to }),
                }
            }
        }
        lit
    }

    /// Distances at which a ray crosses the texels' borders of one axis, ascending, between its ends.
    fn borders(
        &self,
        axis: usize,
        origin: [f64; 3],
        direction: [f64; 3],
        length: f64,
    ) -> impl Iterator<Item = f64> + use<> {
        let size = [self.map.width(), self.map.height()][axis];
        let (corner, texel) = (self.corner[axis] - origin[axis], self.texel[axis]);
        let slope = direction[axis];
        let crossings = if slope == 0.0 { 0 } else { size + 1 };
        let border = move |i: usize| if slope > 0.0 { i } else { size - i };
        (0..crossings)
            .map(move |i| (corner + border(i) as f64 * texel) / slope)
            .filter(move |t| *t > 0.0 && *t < length)
    }

    /// Distance from which on a ray's visibility no longer changes: where it leaves the map or is above all occluders, or for
    /// one along the light, where it leaves the range of depths.
    pub fn settled(&self, origin: [f64; 3], direction: [f64; 3]) -> f64 {
        let leaves = [0, 1].map(|axis| self.borders(axis, origin, direction, f64::INFINITY).last());
        let across = [0, 1].map(|axis| match leaves[axis] {
            Some(distance) => distance,
            // Of a ray that moves along this axis all borders lie behind.
            None if direction[axis] != 0.0 => 0.0,
            None => f64::INFINITY,
        });
        let ends = [self.near, self.near + self.range].map(|z| (z - origin[2]) / direction[2]);
        let along = ends.into_iter().filter(|t| t.is_finite()).fold(0.0, f64::max);
        let first = across[0].min(across[1]);
        if direction[2] < 0.0 {
            first.min(ends[0].max(0.0))
        } else if first.is_finite() {
            first
        } else {
            along
        }
    }

    /// int_0^s e^(-sigma_t t) V dt, exactly.
    pub fn scattered(&self, medium: &Medium, origin: [f64; 3], direction: [f64; 3], length: f64) -> f64 {
        let lit = self.lit(origin, direction, length);
        lit.iter().map(|lit| medium.transmitted_length(lit.start, lit.end)).sum()
    }

    /// The same by the midpoint rule with equal steps, each moved by `offset` of a step from its middle.
    pub fn marched(
        &self,
        medium: &Medium,
        (origin, direction, length): ([f64; 3], [f64; 3], f64),
        steps: usize,
        offset: f64,
    ) -> f64 {
        let step = length / steps as f64;
        let sum: f64 = (0..steps)
            .map(|i| (i as f64 + 0.5 + offset) * step)
            .filter(|&t| self.is_lit([0, 1, 2].map(|k| origin[k] + t * direction[k])))
            .map(|t| medium.transmittance(t))
            .sum();
        sum * step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marching_converges_to_the_exact_integral() {
        let depths = (0..64).map(|i| if (i % 8 + i / 8) % 3 == 0 { 0.25 } else { 0.75 }).collect();
        let map = DepthMap::new(8, 8, depths).unwrap();
        let light = LightMap { map: &map, corner: [-1.0; 2], texel: [0.25; 2], near: -1.0, range: 2.0 };
        let medium = Medium::new(0.7, 1.0, 0.0).unwrap();
        let ray = ([-1.3, -0.9, -0.8], [0.7, 0.5, 0.51], 3.0);
        let exact = light.scattered(&medium, ray.0, ray.1, ray.2);
        let errors = [64, 4096].map(|steps| (light.marched(&medium, ray, steps, 0.0) - exact).abs());
        assert!(errors[0] > 1e-3 && errors[1] < 1e-3, "{errors:?}");
        // The midpoint rule meets each of the visibility's steps to one of its own: first order.
        let mean = |steps: usize| {
            let offsets = (0..32).map(|i| (f64::from(i) + 0.5) / 32.0 - 0.5);
            offsets.map(|offset| (light.marched(&medium, ray, steps, offset) - exact).abs()).sum::<f64>()
                / 32.0
        };
        let order = (mean(256) / mean(4096)).log2() / 4.0;
        assert!((0.8..1.2).contains(&order), "{order}");
        // Along a row, against the light, and away from the map.
        assert_eq!(light.lit([0.1, 0.1, -2.0], [1.0, 0.0, 0.0], 5.0), [LitInterval { start: 0.0, end: 5.0 }]);
        let lit = light.lit([0.1, 0.1, 3.0], [0.0, 0.0, -1.0], f64::INFINITY);
        assert_eq!(lit.len(), 1);
        assert!(lit[0].end.is_infinite() && (lit[0].start - 3.5).abs() < 1.01);
        assert_eq!(light.settled([0.0, 0.0, 5.0], [1.0, 0.0, 0.0]), 1.0);
        assert_eq!(light.settled([0.0, 0.0, 5.0], [0.0, 0.0, -1.0]), 6.0);
        assert_eq!(light.settled([0.0, 0.0, 0.5], [1e-9, 0.0, -1.0]), 1.5);
        assert_eq!(light.settled([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]), 0.5);
        assert_eq!(light.settled([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.0);
    }
}
