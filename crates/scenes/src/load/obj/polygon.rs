//! Polygons of OBJ faces, convex or not, with holes where a bridge leads to them, as triangles.

use earcut::Earcut;

/// Most corners of polygons that are not convex, as the sum of their squares over a file: clipping ears of one that crosses
/// itself throughout takes as many steps.
const MAX_SQUARED_CORNERS: u64 = 1 << 32;

/// Difference between a polygon's area and that of its triangles, as a share of it, that rounding explains.
const AREA_ROUNDING: f64 = 1e-6;

/// Cuts polygons into triangles.
pub(super) struct Triangulation {
    earcut: Earcut<f64>,
    triangles: Vec<u32>,
    flat: Vec<[f64; 2]>,
    squares_left: u64,
}

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Whole,
    /// It crosses itself, so that triangles cover something else than its signed area.
    Crossing,
    /// Too many corners were asked for.
    TooMany,
}

impl Triangulation {
    pub(super) fn new() -> Self {
        Self {
            earcut: Earcut::new(),
            triangles: Vec::new(),
            flat: Vec::new(),
            squares_left: MAX_SQUARED_CORNERS,
        }
    }

    /// Triangles of a polygon by its corners' numbers, turning as it turns. A convex one is a fan around its first corner.
    pub(super) fn of(&mut self, corners: &[[f64; 3]], mut each: impl FnMut([usize; 3])) -> Outcome {
        let fan = |each: &mut dyn FnMut([usize; 3])| (2..corners.len()).for_each(|i| each([0, i - 1, i]));
        if corners.len() == 3 || self.flatten(corners).is_none() {
            fan(&mut each);
            return Outcome::Whole;
        }
        if is_convex(&self.flat) {
            fan(&mut each);
            return Outcome::Whole;
        }
        let squared = (corners.len() as u64).saturating_mul(corners.len() as u64);
        match self.squares_left.checked_sub(squared) {
            Some(left) => self.squares_left = left,
            None => return Outcome::TooMany,
        }
        let holes: [u32; 0] = [];
        self.earcut.earcut_slice(&self.flat, &holes, &mut self.triangles);
        let corner = |i: u32| self.flat[i as usize];
        let doubled = |t: &[u32]| turn(corner(t[0]), corner(t[1]), corner(t[2]));
        let covered: f64 = self.triangles.chunks_exact(3).map(doubled).sum();
        for t in self.triangles.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| i as usize);
            each(if covered < 0.0 { [a, c, b] } else { [a, b, c] });
        }
        let area = (1..corners.len() - 1).map(|i| turn(self.flat[0], self.flat[i], self.flat[i + 1]));
        let area: f64 = area.sum();
        let off = (covered.abs() - area.abs()).abs();
        if off > AREA_ROUNDING * covered.abs().max(area.abs()) { Outcome::Crossing } else { Outcome::Whole }
    }

    /// The corners along the axes that their plane is seen best along, counter-clockwise; `None` for one without area.
    fn flatten(&mut self, corners: &[[f64; 3]]) -> Option<()> {
        let origin = corners[0];
        let relative = |i: usize| [0, 1, 2].map(|k| corners[i % corners.len()][k] - origin[k]);
        let mut normal = [0.0f64; 3];
        for i in 0..corners.len() {
            let (p, q) = (relative(i), relative(i + 1));
            for (k, along) in normal.iter_mut().enumerate() {
                let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                *along += (p[a] - q[a]) * (p[b] + q[b]);
            }
        }
        let largest = (0..3).max_by(|&a, &b| f64::total_cmp(&normal[a].abs(), &normal[b].abs()))?;
        if !(normal[largest].abs() > 0.0 && normal[largest].is_finite()) {
            return None;
        }
        let (a, b) = ((largest + 1) % 3, (largest + 2) % 3);
        let (a, b) = if normal[largest] > 0.0 { (a, b) } else { (b, a) };
        self.flat.clear();
        self.flat.extend((0..corners.len()).map(|i| {
            let p = relative(i);
            [p[a], p[b]]
        }));
        Some(())
    }
}

/// Twice the area of a triangle, positive where it turns left.
fn turn(p: [f64; 2], q: [f64; 2], r: [f64; 2]) -> f64 {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

/// Whether all corners turn left, and so do all triangles of the fan around the first: then it goes around but once.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let corner = |i: usize| flat[i % flat.len()];
    (0..flat.len()).all(|i| turn(corner(i), corner(i + 1), corner(i + 2)) >= 0.0)
        && (2..flat.len()).all(|i| turn(flat[0], flat[i - 1], flat[i]) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area of the triangles, and the sum of their absolute areas; alike where all turn as the polygon does.
    fn areas(corners: &[[f64; 3]]) -> ([f64; 2], Outcome) {
        let mut areas = [0.0; 2];
        let outcome = Triangulation::new().of(corners, |[a, b, c]| {
            let edge = |i: usize| [0, 1, 2].map(|k| corners[i][k] - corners[a][k]);
            let cross = crate::vector::cross(edge(b), edge(c));
            // All test polygons lie in planes whose normal has positive components only.
            areas[0] += 0.5 * cross.iter().sum::<f64>().signum() * crate::vector::norm(cross);
            areas[1] += 0.5 * crate::vector::norm(cross);
        });
        (areas, outcome)
    }

    fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
        points.iter().map(|p| [p[0], p[1], 7.0]).collect()
    }

    const C_SHAPE: [[f64; 2]; 8] =
        [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [3.0, 2.0], [3.0, 3.0], [0.0, 3.0]];

    #[test]
    fn concave_polygons_keep_their_area_and_side() {
        for start in 0..8 {
            let mut points = C_SHAPE;
            points.rotate_left(start);
            let ([signed, whole], outcome) = areas(&flat(&points));
            assert!((signed - 7.0).abs() < 1e-12 && (whole - 7.0).abs() < 1e-12, "{start}: {signed} {whole}");
            assert_eq!(outcome, Outcome::Whole);
            points.reverse();
            let ([signed, whole], _) = areas(&flat(&points));
            assert!((signed + 7.0).abs() < 1e-12 && (whole - 7.0).abs() < 1e-12, "{start}: {signed} {whole}");
        }
    }

    #[test]
    fn stars_rings_and_bridged_holes_do_not_fill_up() {
        let star: Vec<[f64; 2]> = (0..10)
            .map(|i| {
                let (radius, angle) =
                    (if i % 2 == 0 { 2.0 } else { 0.5 }, f64::from(i) * std::f64::consts::PI / 5.0);
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let expected = 10.0 * 0.5 * 2.0 * 0.5 * (std::f64::consts::PI / 5.0).sin();
        let ([signed, whole], outcome) = areas(&flat(&star));
        assert!((signed - expected).abs() < 1e-9 && (whole - expected).abs() < 1e-9, "{signed} {whole}");
        assert_eq!(outcome, Outcome::Whole);
        // A square with a square hole, reached over a bridge and left over the same.
        let ring = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let ([signed, whole], outcome) = areas(&flat(&ring));
        assert!((signed - 12.0).abs() < 1e-9 && (whole - 12.0).abs() < 1e-9, "{signed} {whole}");
        assert_eq!(outcome, Outcome::Whole);
        // Two holes, in a plane that leans.
        let holes = [
            [0.0, 0.0],
            [10.0, 0.0],
            [10.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [5.0, 1.0],
            [5.0, 3.0],
            [7.0, 3.0],
            [7.0, 1.0],
            [5.0, 1.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let leaning: Vec<[f64; 3]> = holes.iter().map(|p| [p[0], p[1], 20.0 - p[0] - p[1]]).collect();
        let ([signed, whole], outcome) = areas(&leaning);
        let expected = 32.0 * 3.0_f64.sqrt();
        assert!((signed - expected).abs() < 1e-9 && (whole - expected).abs() < 1e-9, "{signed} {whole}");
        assert_eq!(outcome, Outcome::Whole);
    }

    #[test]
    fn convex_polygons_are_fans_and_those_that_cross_themselves_are_told() {
        let mut fan = Vec::new();
        let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        Triangulation::new().of(&square, |t| fan.push(t));
        assert_eq!(fan, [[0, 1, 2], [0, 2, 3]]);
        let tie = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 3.0]]);
        assert_eq!(areas(&tie).1, Outcome::Crossing);
        let pentagram: Vec<[f64; 2]> = (0..5)
            .map(|i| {
                let angle = 0.8 * std::f64::consts::PI * f64::from(i);
                [angle.cos(), angle.sin()]
            })
            .collect();
        assert_eq!(areas(&flat(&pentagram)).1, Outcome::Crossing);
    }

    #[test]
    fn without_area_there_is_a_fan_and_too_many_corners_are_refused() {
        assert_eq!(areas(&[[1.0; 3]; 5]), ([0.0; 2], Outcome::Whole));
        let zigzag: Vec<[f64; 3]> = (0..70_000)
            .map(|i| [f64::from(i), f64::from(i % 2) + 1e-9 * f64::from(i).powi(2), 0.0])
            .collect();
        let mut triangulation = Triangulation::new();
        assert_eq!(triangulation.of(&zigzag, |_| ()), Outcome::TooMany);
    }
}
