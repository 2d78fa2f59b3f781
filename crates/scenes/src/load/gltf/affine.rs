//! Affine maps in double precision.

use crate::error::FileFault;
use crate::vector::{cross, dot};

/// Rows of an affine map: world = linear · local + translation (last column).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine([[f64; 4]; 3]);

/// Translation, rotation as a quaternion (x, y, z, w) and scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trs {
    pub translation: [f64; 3],
    pub rotation: [f64; 4],
    pub scale: [f64; 3],
}

impl Default for Trs {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
    }
}

/// How far the bottom row of a matrix may be from (0, 0, 0, 1): exporters compute in single precision.
const BOTTOM_ROUNDING: f64 = 1e-5;

/// Shortest quaternion that still says which way it turns.
const SHORTEST_ROTATION: f64 = 1e-6;

impl Affine {
    pub(super) const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    pub(super) fn translation(by: [f64; 3]) -> Self {
        let mut map = Self::IDENTITY;
        (0..3).for_each(|row| map.0[row][3] = by[row]);
        map
    }

    /// From a glTF matrix, column by column.
    pub(super) fn of_matrix(m: &[f64; 16], at: &dyn Fn() -> String) -> Result<Self, FileFault> {
        check(m, "matrix", at)?;
        let bottom = [m[3], m[7], m[11], m[15]];
        if bottom.iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(c, wanted)| (c - wanted).abs() > BOTTOM_ROUNDING) {
            return Err(FileFault::invalid(at(), format!("matrix with bottom row {bottom:?} is not affine")));
        }
        Ok(Self(std::array::from_fn(|row| std::array::from_fn(|column| m[4 * column + row]))))
    }

    pub(super) fn of_trs(trs: &Trs, at: &dyn Fn() -> String) -> Result<Self, FileFault> {
        let Trs { translation, rotation, scale } = trs;
        check(translation, "translation", at)?;
        check(scale, "scale", at)?;
        check(rotation, "rotation", at)?;
        let length = rotation.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length < SHORTEST_ROTATION {
            return Err(FileFault::invalid(at(), format!("rotation {rotation:?} is no unit quaternion")));
        }
        // Exporters write quaternions with few digits: without this the mesh would be scaled.
        let [x, y, z, w] = rotation.map(|c| c / length);
        let rotate = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Ok(Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| match column {
                3 => translation[row],
                _ => rotate[row][column] * scale[column],
            })
        })))
    }

    pub(super) fn then_inner(&self, inner: &Self) -> Self {
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let sum: f64 = (0..3).map(|k| self.0[row][k] * inner.0[k][column]).sum();
                if column == 3 { sum + self.0[row][3] } else { sum }
            })
        }))
    }

    /// The sum of maps with weights.
    pub(super) fn blend(weighted: impl Iterator<Item = (f64, Self)>) -> Self {
        let mut sum = [[0.0; 4]; 3];
        for (weight, map) in weighted {
            for (row, of) in sum.iter_mut().zip(map.0) {
                row.iter_mut().zip(of).for_each(|(c, of)| *c += weight * of);
            }
        }
        Self(sum)
    }

    pub(super) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    pub(super) fn direction(&self, d: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
    }

    fn linear_row(&self, row: usize) -> [f64; 3] {
        [self.0[row][0], self.0[row][1], self.0[row][2]]
    }

    /// Whether the map reverses orientation, so that counter-clockwise becomes clockwise.
    pub(super) fn mirrors(&self) -> bool {
        dot(self.linear_row(0), cross(self.linear_row(1), self.linear_row(2))) < 0.0
    }

    /// Maps a normal (by the cofactors, which exist for singular maps too); the result has any length.
    pub(super) fn normal(&self, n: [f64; 3]) -> [f64; 3] {
        let sign = if self.mirrors() { -1.0 } else { 1.0 };
        std::array::from_fn(|row| {
            sign * dot(cross(self.linear_row((row + 1) % 3), self.linear_row((row + 2) % 3)), n)
        })
    }
}

fn check(values: &[f64], key: &str, at: &dyn Fn() -> String) -> Result<(), FileFault> {
    if values.iter().all(|v| (*v as f32).is_finite()) {
        return Ok(());
    }
    Err(FileFault::invalid(at(), format!("{key} {values:?} is not finite or exceeds single precision")))
}
