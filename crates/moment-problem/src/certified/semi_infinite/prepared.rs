//! A basis made ready for linear programs on \[0, 1\]: orthonormal rows and a table of derivative bounds.

use crate::arithmetic::{Ball, DoubleDouble, Field, Jet, Real};
use crate::basis::Basis;
use crate::dense::dot;
use crate::error::{BasisError, MomentError};

/// Cells of the table; also the points over which the rows are made orthonormal. 512 cells leave a few dozen for the
/// slow path of a certificate at the default family's steepest functions.
const CELLS: usize = 512;

/// A row whose norm falls by this factor under projection is taken for a combination of the rows before it. The 37
/// functions of the default family keep more than 1e-20 (all of them together); rounding leaves less than 1e-28.
const DEPENDENCE_TOLERANCE: f64 = 1e-24;

/// Moments may miss the set of moment vectors by this much (in orthonormal coordinates) and are then projected onto
/// it: moments that were rounded to single precision miss it by about 1e-8, and to double by 1e-16.
pub(crate) const FEASIBILITY_TOLERANCE: f64 = 1e-9;

/// A basis on \[0, 1\] with everything that does not depend on moments or z_f.
///
/// Rows are the functions 1, b_1, ..., b_m, turned into rows a_0, ..., a_r orthonormal over a uniform grid
/// (Algorithm 1 of MSM15 fails on raw rows far more often, see the project's notes on solvers). Functions that are
/// linear combinations of earlier ones give no row; their moments are only checked.
#[derive(Clone, Debug)]
pub(crate) struct PreparedBasis {
    basis: Basis,
    /// Row k holds the coefficients of a_k over 1, b_1, ..., b_m.
    rows: Vec<Vec<DoubleDouble>>,
    /// Combinations of 1, b_1, ..., b_m that vanish identically.
    relations: Vec<Vec<DoubleDouble>>,
    pub(super) cells: Vec<Cell>,
}

/// One of the equal parts of \[0, 1\] with the rows' values, slopes and curvature bounds.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub centre: f64,
    /// (a_k, a_k') at the centre.
    pub values: Vec<(f64, f64)>,
    /// Enclosure of a_k'' over the cell.
    pub curvature: Vec<(f64, f64)>,
}

/// Half the width of a cell.
pub(super) const HALF_CELL: f64 = 0.5 / CELLS as f64;

impl PreparedBasis {
    /// Prepares any basis; fails where a function is not finite on \[0, 1\].
    pub(crate) fn new(basis: &Basis) -> Result<Self, BasisError> {
        let size = basis.len() + 1;
        let one = DoubleDouble::one();
        let grid: Vec<f64> = (0..=CELLS).map(|i| i as f64 / CELLS as f64).collect();
        let mut samples = vec![vec![one; grid.len()]; size];
        for (k, function) in basis.functions().iter().enumerate() {
            for (sample, &z) in samples[k + 1].iter_mut().zip(&grid) {
                *sample = function.evaluate(DoubleDouble::from(z));
                if !sample.is_finite() {
                    return Err(BasisError::NotFinite { name: function.name().to_owned(), z });
                }
            }
        }
        let mut prepared =
            Self { basis: basis.clone(), rows: Vec::new(), relations: Vec::new(), cells: Vec::new() };
        prepared.orthonormalise(samples);
        prepared.cells = (0..CELLS).map(|i| prepared.cell(i)).collect();
        Ok(prepared)
    }

    /// Gram-Schmidt with reorthogonalisation, keeping track of the coefficients.
    fn orthonormalise(&mut self, samples: Vec<Vec<DoubleDouble>>) {
        let size = samples.len();
        let scale = DoubleDouble::one() / DoubleDouble::from(samples[0].len() as f64);
        let norm = |v: &[DoubleDouble]| (dot(v, v) * scale).sqrt();
        let mut directions: Vec<Vec<DoubleDouble>> = Vec::new();
        for (k, mut sample) in samples.into_iter().enumerate() {
            let mut row = vec![DoubleDouble::zero(); size];
            row[k] = DoubleDouble::one();
            let before = norm(&sample);
            for _ in 0..2 {
                for (direction, other) in directions.iter().zip(&self.rows) {
                    let factor = dot(direction, &sample) * scale;
                    for (value, &d) in sample.iter_mut().zip(direction) {
                        *value = *value - factor * d;
                    }
                    for (value, &d) in row.iter_mut().zip(other) {
                        *value = *value - factor * d;
                    }
                }
            }
            let after = norm(&sample);
            if after.to_f64() <= DEPENDENCE_TOLERANCE * before.to_f64() {
                self.relations.push(row.into_iter().map(|c| c / before).collect());
                continue;
            }
            self.rows.push(row.into_iter().map(|c| c / after).collect());
            directions.push(sample.into_iter().map(|v| v / after).collect());
        }
    }

    fn cell(&self, index: usize) -> Cell {
        let centre = (2 * index + 1) as f64 * HALF_CELL;
        let jets = self.jets(Jet::variable(DoubleDouble::from(centre)));
        let values = jets.iter().map(|jet| (jet.value.to_f64(), jet.first.to_f64())).collect();
        let range = Ball::interval(centre - HALF_CELL, centre + HALF_CELL);
        let curvature = self
            .jets(Jet::variable(range))
            .iter()
            .map(|jet| (jet.second.lower(), jet.second.upper()))
            .collect();
        Cell { centre, values, curvature }
    }

    /// The basis.
    pub(crate) fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Rows a_k with derivatives at z.
    fn jets<T: Field>(&self, z: Jet<T>) -> Vec<Jet<T>> {
        let functions = self.basis.evaluate(z);
        self.rows
            .iter()
            .map(|row| {
                let constant = Jet::from_double_double(row[0]);
                row[1..]
                    .iter()
                    .zip(&functions)
                    .fold(constant, |sum, (&c, &f)| sum + f.scale(T::from_double_double(c)))
            })
            .collect()
    }

    /// Column a(z) of the linear program.
    pub(crate) fn column(&self, z: f64) -> Vec<DoubleDouble> {
        let functions = self.basis.evaluate(DoubleDouble::from(z));
        self.rows.iter().map(|row| row[0] + dot(&row[1..], &functions)).collect()
    }

    /// Right-hand side for moments of the basis; an error where a relation between the functions is violated.
    pub(crate) fn right_hand_side(&self, moments: &[DoubleDouble]) -> Result<Vec<DoubleDouble>, MomentError> {
        for relation in &self.relations {
            let residual = (relation[0] + dot(&relation[1..], moments)).to_f64().abs();
            if residual.is_nan() || residual > FEASIBILITY_TOLERANCE {
                return Err(MomentError::Infeasible { residual });
            }
        }
        Ok(self.rows.iter().map(|row| row[0] + dot(&row[1..], moments)).collect())
    }

    /// Coefficients over 1, b_1, ..., b_m of the function y . a(z).
    pub(crate) fn coefficients(&self, y: &[DoubleDouble]) -> Vec<DoubleDouble> {
        (0..=self.basis.len())
            .map(|j| self.rows.iter().zip(y).fold(DoubleDouble::zero(), |sum, (row, &y)| sum + row[j] * y))
            .collect()
    }

    /// The function with the given coefficients over 1, b_1, ..., b_m, with derivatives.
    pub(super) fn function<T: Field>(&self, coefficients: &[DoubleDouble], z: Jet<T>) -> Jet<T> {
        let constant = Jet::from_double_double(coefficients[0]);
        self.basis
            .functions()
            .iter()
            .zip(&coefficients[1..])
            .fold(constant, |sum, (function, &c)| sum + function.evaluate(z).scale(T::from_double_double(c)))
    }
}

/// Enclosure of the second derivative within `half` of a centre: directly, and by the mean value theorem, which does
/// not suffer where large coefficients cancel.
pub(super) fn curvature_range(centre: &Jet<Ball>, over: &Jet<Ball>, half: f64) -> (f64, f64) {
    let bend = over.third.lower().abs().max(over.third.upper().abs()) * half * (1.0 + 1e-15);
    let low = (centre.second.lower() - bend).max(over.second.lower());
    let high = (centre.second.upper() + bend).min(over.second.upper());
    (low, high)
}
