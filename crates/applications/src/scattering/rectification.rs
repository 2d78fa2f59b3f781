//! Rectified coordinates in which view rays are rows of constant depth (BHS16 section 2.2).
//!
//! With the camera as origin and z along the light's way: r = sqrt(x^2 + y^2) is the column, phi = atan2(y, x) the row, and the
//! stored depth is the angle to the negative light direction, pi - theta = atan2(r, -z), normalised to the frustum's range and
//! clamped. Looking at the light is pi - theta = 0.

use std::f64::consts::{PI, TAU};

use thiserror::Error;

use scenes::vector::{cross, dot, minus, norm};

/// A view that cannot be rectified.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RectificationError {
    /// No direction.
    #[error("light direction {direction:?} has no length")]
    NoDirection {
        /// As given.
        direction: [f64; 3],
    },
    /// All directions of the frustum agree, or are no numbers.
    #[error("the frustum's directions span {span} radians: it has no extent")]
    NoExtent {
        /// Largest angle between two of its corners.
        span: f64,
    },
    /// A map without texels.
    #[error("a rectified map of {columns} x {rows} texels has none")]
    NoTexels {
        /// Texels along r.
        columns: usize,
        /// Texels along phi.
        rows: usize,
    },
}

/// An orthonormal basis of light space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightAxes {
    /// x axis.
    pub x: [f64; 3],
    /// y axis.
    pub y: [f64; 3],
    /// z axis: the direction in which light travels.
    pub light: [f64; 3],
}

impl LightAxes {
    /// Any basis for a direction of travel, which need not be a unit vector.
    ///
    /// # Errors
    /// [`RectificationError::NoDirection`].
    pub fn new(direction: [f64; 3]) -> Result<Self, RectificationError> {
        let length = norm(direction);
        if !(length > 0.0 && length.is_finite()) {
            return Err(RectificationError::NoDirection { direction });
        }
        let light = direction.map(|value| value / length);
        // The world axis that is least parallel.
        let least = (0..3).fold(0, |least, k| if light[k].abs() < light[least].abs() { k } else { least });
        let axis = std::array::from_fn(|k| f64::from(u8::from(k == least)));
        let x = cross(axis, light);
        let x = x.map(|value| value / norm(x));
        Ok(Self { x, y: cross(light, x), light })
    }

    /// A direction in light space.
    pub fn direction(&self, world: [f64; 3]) -> [f64; 3] {
        [dot(world, self.x), dot(world, self.y), dot(world, self.light)]
    }
}

/// A point in rectified coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectified {
    /// Distance from the epipolar axis, in world units.
    pub r: f64,
    /// Azimuth in \[0, 2 pi); 0 on the axis, where it is none.
    pub phi: f64,
    /// pi - theta in \[0, pi\].
    pub flipped: f64,
}

impl Rectified {
    /// Of a point relative to the camera, in light space.
    pub fn of([x, y, z]: [f64; 3]) -> Self {
        let r = x.hypot(y);
        let azimuth = if r > 0.0 { y.atan2(x) } else { 0.0 };
        let phi = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        // The sum of a tiny negative angle and 2 pi rounds to 2 pi.
        Self { r, phi: if phi < TAU { phi } else { 0.0 }, flipped: r.atan2(-z) }
    }
}

/// What a camera sees: the pyramid from the camera through four corners, in order around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// The camera.
    pub apex: [f64; 3],
    /// The corners at the far end, in the world.
    pub corners: [[f64; 3]; 4],
}

impl Frustum {
    /// Bounds of pi - theta over the frustum's directions of one azimuth; `None` where it has none.
    pub fn inclinations(&self, axes: &LightAxes, phi: f64) -> Option<[f64; 2]> {
        let corners = self.corners.map(|corner| axes.direction(minus(corner, self.apex)));
        // r = sin(f), -z = cos(f).
        let direction = |f: f64| [f.sin() * phi.cos(), f.sin() * phi.sin(), -f.cos()];
        let mut crossings: Vec<f64> = (0..4)
            .map(|k| {
                let n = cross(corners[k], corners[(k + 1) % 4]);
                // n . direction = 0.
                let (along, up) = (n[0] * phi.cos() + n[1] * phi.sin(), n[2]);
                up.atan2(along).rem_euclid(PI)
            })
            .chain([0.0, PI])
            .collect();
        crossings.sort_by(f64::total_cmp);
        let inside =
            crossings.windows(2).filter(|ends| contains(&corners, direction(0.5 * (ends[0] + ends[1]))));
        inside.fold(None, |all: Option<[f64; 2]>, ends| {
            Some(all.map_or([ends[0], ends[1]], |[low, high]| [low.min(ends[0]), high.max(ends[1])]))
        })
    }
}

/// Bounds that cover a frustum, and the grid over them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectification {
    /// The camera.
    pub camera: [f64; 3],
    /// Light space.
    pub axes: LightAxes,
    /// Texels along r and phi.
    pub size: [usize; 2],
    /// Largest r.
    pub r_max: f64,
    /// First azimuth, in \[0, 2 pi).
    pub phi_start: f64,
    /// Extent of azimuths, at most 2 pi.
    pub phi_extent: f64,
    /// Range of pi - theta that is normalised to \[0, 1\].
    pub flipped: [f64; 2],
}

/// Directions closer than this to the edge of a frustum count as inside: the rounding of their cross products.
const ON_EDGE: f64 = 1e-12;

impl Rectification {
    /// Bounds of r, phi and theta that cover a frustum, theta extended by a guard band on both sides that is this share of
    /// its extent. A row along the edge of the azimuths is kept on both sides, so that rows can be interpolated.
    ///
    /// theta is extreme at a corner, within an edge between corners, or at a pole that is seen; corners alone are not enough.
    ///
    /// # Errors
    /// [`RectificationError::NoExtent`] and [`RectificationError::NoTexels`].
    pub fn new(
        frustum: &Frustum,
        axes: LightAxes,
        size: [usize; 2],
        guard_band: f64,
    ) -> Result<Self, RectificationError> {
        if size.contains(&0) {
            return Err(RectificationError::NoTexels { columns: size[0], rows: size[1] });
        }
        let corners = frustum.corners.map(|corner| axes.direction(minus(corner, frustum.apex)));
        let r_max = corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max);
        let units = corners.map(|c| c.map(|value| value / norm(c)));
        let angle = |a: [f64; 3], b: [f64; 3]| norm(cross(a, b)).atan2(dot(a, b));
        let span = units.iter().flat_map(|&a| units.iter().map(move |&b| angle(a, b))).fold(0.0, f64::max);
        let has_extent = span > ON_EDGE && span.is_finite() && r_max > 0.0;
        if !has_extent {
            return Err(RectificationError::NoExtent { span });
        }
        let [toward, away] = [-1.0, 1.0].map(|z| contains(&units, [0.0, 0.0, z]));
        let mut extremes: Vec<f64> = units.iter().map(|&unit| Rectified::of(unit).flipped).collect();
        for k in 0..4 {
            extremes
                .extend(within_edge(units[k], units[(k + 1) % 4]).map(|unit| Rectified::of(unit).flipped));
        }
        extremes.extend(toward.then_some(0.0));
        extremes.extend(away.then_some(PI));
        let low = extremes.iter().copied().fold(PI, f64::min);
        let high = extremes.iter().copied().fold(0.0, f64::max);
        let band = guard_band * (high - low);
        let (phi_start, phi_extent) = if toward || away { (0.0, TAU) } else { azimuths(&units, size[1]) };
        Ok(Self {
            camera: frustum.apex,
            axes,
            size,
            r_max,
            phi_start,
            phi_extent,
            flipped: [(low - band).max(0.0), (high + band).min(PI)],
        })
    }

    /// A point of the world.
    pub fn rectify(&self, point: [f64; 3]) -> Rectified {
        Rectified::of(self.axes.direction(minus(point, self.camera)))
    }

    /// Normalised depth, not clamped.
    pub fn depth(&self, flipped: f64) -> f64 {
        (flipped - self.flipped[0]) / (self.flipped[1] - self.flipped[0])
    }

    /// Distance between columns.
    pub fn column_width(&self) -> f64 {
        self.r_max / self.size[0] as f64
    }

    /// The row of an azimuth.
    pub fn row(&self, phi: f64) -> usize {
        (self.row_place(phi) as usize).min(self.size[1] - 1)
    }

    /// The place of an azimuth between rows: the middle of the first is 0.5.
    fn row_place(&self, phi: f64) -> f64 {
        (phi - self.phi_start).rem_euclid(TAU) / self.phi_extent * self.size[1] as f64
    }

    /// Whether rows go around the camera, so that the last one is the first one's neighbour.
    pub fn wraps(&self) -> bool {
        self.phi_extent == TAU
    }

    /// Azimuth of the middle of a row.
    pub fn azimuth(&self, row: usize) -> f64 {
        self.phi_start + (row as f64 + 0.5) * self.phi_extent / self.size[1] as f64
    }

    /// Place of a texel's middle in light space, relative to the camera.
    pub fn texel(&self, column: usize, row: usize) -> [f64; 2] {
        let r = (column as f64 + 0.5) * self.column_width();
        let phi = self.azimuth(row);
        [r * phi.cos(), r * phi.sin()]
    }

    /// Distance between samples on a view ray of inclination pi - theta: columns are r apart, and r = t sin(theta).
    pub fn spacing(&self, flipped: f64) -> f64 {
        self.column_width() / flipped.sin()
    }

    /// The published spacing, one for all rays: that of the mean of the bounds of theta.
    pub fn mean_spacing(&self) -> f64 {
        self.spacing(0.5 * (self.flipped[0] + self.flipped[1]))
    }
}

/// Whether a direction lies in the pyramid of four directions.
fn contains(corners: &[[f64; 3]; 4], direction: [f64; 3]) -> bool {
    let sides = [0, 1, 2, 3].map(|k| dot(cross(corners[k], corners[(k + 1) % 4]), direction));
    let middle = [0, 1, 2].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>());
    let inside = sides.iter().all(|&side| side >= -ON_EDGE) || sides.iter().all(|&side| side <= ON_EDGE);
    inside && dot(middle, direction) > 0.0
}

/// Where the inclination is extreme within the arc between two directions: the poles projected to its plane.
fn within_edge(a: [f64; 3], b: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    let n = cross(a, b);
    let n = n.map(|value| value / norm(n));
    let projected = [0, 1, 2].map(|k| f64::from(u8::from(k == 2)) - n[2] * n[k]);
    [1.0, -1.0].into_iter().map(move |sign| projected.map(|value| sign * value)).filter(move |&c| {
        // Between a and b, on their side of the great circle.
        dot(cross(a, c), n) > 0.0 && dot(cross(c, b), n) > 0.0
    })
}

/// The smallest arc that holds the azimuths of directions around which no pole lies, one row wider on either side.
fn azimuths(units: &[[f64; 3]; 4], rows: usize) -> (f64, f64) {
    let mut sorted: Vec<f64> = units.iter().map(|&unit| Rectified::of(unit).phi).collect();
    sorted.sort_by(f64::total_cmp);
    let next = |i: usize| if i == 3 { sorted[0] + TAU } else { sorted[i + 1] };
    let (gap_end, gap) = (0..4).fold((0.0, -1.0), |best, i| {
        let gap = next(i) - sorted[i];
        if gap > best.1 { (next(i), gap) } else { best }
    });
    let seen = TAU - gap;
    // rows = rows of the arc + 2.
    let row = if rows > 2 { seen / (rows - 2) as f64 } else { 0.0 };
    let extent = (seen + 2.0 * row).min(TAU);
    ((gap_end - row).rem_euclid(TAU), extent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    /// A frustum with the given half-angle tangents, looking along a random direction.
    fn frustum(random: &mut Random) -> Frustum {
        let direction = std::array::from_fn(|_| random.unit() - 0.5);
        let axes = LightAxes::new(direction).unwrap();
        let (w, h) = (0.2 + random.unit(), 0.2 + random.unit());
        let apex = std::array::from_fn(|_| random.unit());
        let corners = [[-w, -h], [w, -h], [w, h], [-w, h]].map(|[x, y]| {
            std::array::from_fn(|k| apex[k] + 5.0 * (axes.light[k] + x * axes.x[k] + y * axes.y[k]))
        });
        Frustum { apex, corners }
    }

    fn inside(frustum: &Frustum, random: &mut Random) -> [f64; 3] {
        let (s, t, d) = (random.unit(), random.unit(), random.unit());
        let [a, b, c, e] = frustum.corners;
        std::array::from_fn(|k| {
            let far = (1.0 - t) * ((1.0 - s) * a[k] + s * b[k]) + t * ((1.0 - s) * e[k] + s * c[k]);
            frustum.apex[k] + d * (far - frustum.apex[k])
        })
    }

    #[test]
    fn bounds_cover_the_frustum_and_little_more() {
        let mut random = Random::new(20);
        let mut poles = 0;
        for _ in 0..300 {
            let frustum = frustum(&mut random);
            let axes = LightAxes::new(std::array::from_fn(|_| random.unit() - 0.5)).unwrap();
            let found = Rectification::new(&frustum, axes, [64, 64], 0.0).unwrap();
            poles += usize::from(found.phi_extent == TAU);
            let (mut low, mut high, mut far) = (PI, 0.0f64, 0.0f64);
            for _ in 0..4000 {
                let at = found.rectify(inside(&frustum, &mut random));
                (low, high, far) = (low.min(at.flipped), high.max(at.flipped), far.max(at.r));
                let offset = (at.phi - found.phi_start).rem_euclid(TAU);
                assert!(offset <= found.phi_extent || at.r < 1e-9, "{at:?} {found:?}");
                let of_row = frustum.inclinations(&axes, at.phi);
                let within = |[low, high]: [f64; 2]| (low - 1e-6..=high + 1e-6).contains(&at.flipped);
                assert!(of_row.is_some_and(within) || at.r < 1e-9, "{at:?} {of_row:?}");
            }
            let [least, most] = found.flipped;
            assert!(low >= least - 1e-9 && high <= most + 1e-9 && far <= found.r_max + 1e-9);
            assert!(low - least < 0.15 && most - high < 0.15, "{low} {high} {found:?}");
        }
        assert!(poles > 20 && poles < 200, "{poles}");
    }

    #[test]
    fn axes_are_orthonormal_and_rows_constant() {
        let axes = LightAxes::new([0.3, -2.0, 0.5]).unwrap();
        for (a, b) in [(axes.x, axes.y), (axes.y, axes.light), (axes.light, axes.x)] {
            assert!(dot(a, b).abs() < 1e-15 && (norm(a) - 1.0).abs() < 1e-15);
        }
        // Points of one view ray differ in r alone.
        let one = Rectified::of([0.3, 0.4, 0.2]);
        let two = Rectified::of([0.9, 1.2, 0.6]);
        assert!((one.phi - two.phi).abs() < 1e-15 && (one.flipped - two.flipped).abs() < 1e-15);
        assert!(LightAxes::new([0.0; 3]).is_err());
        let point = Frustum { apex: [0.0; 3], corners: [[0.0, 0.0, 1.0]; 4] };
        assert!(Rectification::new(&point, axes, [4, 4], 0.0).is_err());
    }
}
