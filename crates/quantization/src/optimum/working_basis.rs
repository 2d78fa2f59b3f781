//! A basis in coordinates in which its rows can be optimised in machine precision: orthonormal, as Chebyshev series.

use super::chebyshev;
use crate::error::QuantizationError;
use crate::interval::DepthInterval;
use moment_problem::Basis;
use moment_problem::arithmetic::{DoubleDouble, Field, Real};
use moment_problem::dense::dot;
use std::f64::consts::PI;

/// A function that keeps less than this share of its norm when a constant and the functions before it are projected
/// out is taken for a combination of them. z^16 on \[0, 1\] keeps 1e-9; what keeps less than 1e-12 needs matrix entries
/// above 1e12, whose rounding alone moves the range by 1e-4.
const SMALLEST_SHARE: f64 = 1e-12;

/// Degrees of the Chebyshev series that are tried.
const DEGREES: [usize; 6] = [16, 32, 64, 128, 256, 512];

/// Largest relative error of a series, with room for the roundings of 512 terms above the 1e-16 of machine numbers.
const RESOLVED: f64 = 1e-12;

/// Last coefficients below this share of the largest one are rounding errors of some tens of terms and are dropped.
const NEGLIGIBLE: f64 = 1e-15;

/// Largest even part of an odd function and odd part of an even one, relative; orthonormalising leaves some 1e-14.
const PARITY_TOLERANCE: f64 = 1e-10;

/// Whether a function is even or odd about the middle of the interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parity {
    Even,
    Odd,
}

/// Functions w_1, ..., w_m that span what b_1, ..., b_m span next to the constants, orthonormal over Chebyshev points.
#[derive(Debug)]
pub(crate) struct WorkingBasis {
    pub(crate) interval: DepthInterval,
    pub(crate) basis: Basis,
    /// Row k holds the coefficients of w_k over 1, b_1, ..., b_m.
    pub(crate) rows: Vec<Vec<DoubleDouble>>,
    /// Chebyshev coefficients of w_k over t, which runs from -1 to 1 over the interval.
    pub(crate) series: Vec<Vec<f64>>,
}

impl WorkingBasis {
    /// For powers, which span the same on every interval, on \[-1, 1\] unless it is \[0, 1\] that is asked for.
    pub(crate) fn normalised(basis: &Basis, interval: DepthInterval) -> Result<Self, QuantizationError> {
        let powers = basis.power_order().is_some() && interval != DepthInterval::UNIT;
        Self::new(basis, if powers { DepthInterval::SIGNED } else { interval })
    }

    pub(crate) fn new(basis: &Basis, interval: DepthInterval) -> Result<Self, QuantizationError> {
        let mut miss = (0, f64::INFINITY);
        for degree in DEGREES {
            let mut working = Self { interval, basis: basis.clone(), rows: Vec::new(), series: Vec::new() };
            working.orthonormalise(degree)?;
            miss = working.worst_miss(degree)?;
            if miss.1 <= RESOLVED {
                return Ok(working);
            }
        }
        Err(QuantizationError::Unresolved {
            name: basis.functions()[miss.0].name().to_owned(),
            degree: DEGREES[DEGREES.len() - 1],
            miss: miss.1,
        })
    }

    /// Number m of functions.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    fn functions_at(&self, t: f64) -> Result<Vec<DoubleDouble>, QuantizationError> {
        let z = self.interval.at(t);
        let values = self.basis.evaluate(DoubleDouble::from(z));
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(values),
            Some(index) => Err(QuantizationError::NotFinite {
                name: self.basis.functions()[index].name().to_owned(),
                at: z,
                start: self.interval.start(),
                end: self.interval.end(),
            }),
        }
    }

    /// Gram-Schmidt with reorthogonalisation in double-double.
    fn orthonormalise(&mut self, degree: usize) -> Result<(), QuantizationError> {
        let points = chebyshev::points(degree);
        let values: Vec<Vec<DoubleDouble>> =
            points.iter().map(|&t| self.functions_at(t)).collect::<Result<_, _>>()?;
        let m = self.basis.len();
        let scale = DoubleDouble::one() / DoubleDouble::from(points.len() as f64);
        let norm = |v: &[DoubleDouble]| (dot(v, v) * scale).sqrt();
        let mut directions = vec![vec![DoubleDouble::one(); points.len()]];
        let mut rows = vec![unit_vector(0, m + 1)];
        for j in 0..m {
            let mut sample: Vec<DoubleDouble> = values.iter().map(|row| row[j]).collect();
            let mut row = unit_vector(j + 1, m + 1);
            let before = norm(&sample);
            for _ in 0..2 {
                for (direction, other) in directions.iter().zip(&rows) {
                    let factor = dot(direction, &sample) * scale;
                    sample.iter_mut().zip(direction).for_each(|(v, &d)| *v = *v - factor * d);
                    row.iter_mut().zip(other).for_each(|(v, &d)| *v = *v - factor * d);
                }
            }
            let after = norm(&sample);
            let share = after.to_f64() / before.to_f64();
            // A NaN (0 / 0: the function vanishes everywhere) is no share either.
            if share.is_nan() || share <= SMALLEST_SHARE {
                return Err(QuantizationError::Singular {
                    name: self.basis.functions()[j].name().to_owned(),
                    share: if share.is_nan() { 0.0 } else { share },
                    smallest: SMALLEST_SHARE,
                });
            }
            directions.push(sample.into_iter().map(|v| v / after).collect());
            rows.push(row.into_iter().map(|v| v / after).collect());
        }
        self.rows = rows.split_off(1);
        self.series = directions[1..].iter().map(|values| series(values)).collect();
        Ok(())
    }

    /// The function whose series errs most between its nodes, and by how much of its size.
    fn worst_miss(&self, degree: usize) -> Result<(usize, f64), QuantizationError> {
        let mut worst = (0, 0.0);
        let sizes: Vec<f64> = self.series.iter().map(|c| c.iter().map(|v| v.abs()).sum()).collect();
        for k in 0..degree {
            let t = (PI * (k as f64 + 0.5) / degree as f64).cos();
            let functions = self.functions_at(t)?;
            for (j, (row, series)) in self.rows.iter().zip(&self.series).enumerate() {
                let exact = (row[0] + dot(&row[1..], &functions)).to_f64();
                let miss = (exact - chebyshev::evaluate(series, t)).abs() / sizes[j];
                if miss.is_nan() || miss > worst.1 {
                    worst = (j, if miss.is_nan() { f64::INFINITY } else { miss });
                }
            }
        }
        Ok(worst)
    }

    /// Coefficients over 1, b_1, ..., b_m of the function with the given ones over w_1, ..., w_m.
    pub(crate) fn over_basis(&self, x: &[f64]) -> Vec<DoubleDouble> {
        let coefficient = |j: usize| {
            let terms = x.iter().zip(&self.rows);
            terms.fold(DoubleDouble::zero(), |sum, (&x, w)| sum + DoubleDouble::from(x) * w[j])
        };
        (0..=self.basis.len()).map(coefficient).collect()
    }

    /// Parity of each function about the middle of the interval.
    pub(crate) fn parities(&self) -> Result<Vec<Parity>, QuantizationError> {
        let part = |series: &[f64], odd: usize| -> f64 {
            series.iter().enumerate().filter(|(j, _)| j % 2 == odd).map(|(_, c)| c * c).sum::<f64>().sqrt()
        };
        let parity = |(j, series): (usize, &Vec<f64>)| {
            let (even, odd) = (part(series, 0), part(series, 1));
            if odd <= PARITY_TOLERANCE * even {
                Ok(Parity::Even)
            } else if even <= PARITY_TOLERANCE * odd {
                Ok(Parity::Odd)
            } else {
                let name = self.basis.functions()[j].name().to_owned();
                Err(QuantizationError::NoParity { name, centre: self.interval.centre() })
            }
        };
        self.series.iter().enumerate().map(parity).collect()
    }
}

fn unit_vector(index: usize, length: usize) -> Vec<DoubleDouble> {
    (0..length).map(|i| DoubleDouble::from(if i == index { 1.0 } else { 0.0 })).collect()
}

fn series(values: &[DoubleDouble]) -> Vec<f64> {
    let values: Vec<f64> = values.iter().map(|v| v.to_f64()).collect();
    let mut series = chebyshev::coefficients(&values);
    let largest = series.iter().fold(0.0, |max: f64, c| max.max(c.abs()));
    while series.len() > 1 && series.last().is_some_and(|c| c.abs() <= NEGLIGIBLE * largest) {
        series.pop();
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    fn working(basis: &str, interval: DepthInterval) -> Result<WorkingBasis, QuantizationError> {
        WorkingBasis::new(&basis.parse().unwrap(), interval)
    }

    #[test]
    fn powers_become_alternately_odd_and_even_and_keep_their_degree() {
        for interval in [DepthInterval::UNIT, DepthInterval::SIGNED, DepthInterval::new(-3.0, 2.5).unwrap()] {
            let working = working("power:16", interval).unwrap();
            let parities = working.parities().unwrap();
            for (j, parity) in parities.iter().enumerate() {
                assert_eq!(*parity, if j % 2 == 0 { Parity::Odd } else { Parity::Even });
                assert_eq!(working.series[j].len(), j + 2);
            }
        }
        assert!(working("trig:2", DepthInterval::UNIT).unwrap().parities().is_ok());
        let error = working("z,exp(-2z)", DepthInterval::UNIT).unwrap().parities().unwrap_err();
        assert!(error.to_string().contains("exp(-2z)"), "{error}");
    }

    #[test]
    fn flat_curves_and_unusable_functions_are_errors_with_their_names() {
        let message = |basis: &str, interval| working(basis, interval).unwrap_err().to_string();
        assert!(message("z, 1-z", DepthInterval::UNIT).contains("`1-z`"));
        assert!(message("0z, z", DepthInterval::UNIT).contains("`0z`"));
        assert!(message("sin(z)^2, cos(2z)", DepthInterval::UNIT).contains("cos(2z)"));
        assert!(message("z, ln(1+1z)", DepthInterval::SIGNED).contains("not finite at -1"));
        assert!(message("1/(1+1000000(z-1/2)^2)", DepthInterval::UNIT).contains("degree 512"));
        assert!(DepthInterval::new(1.0, 1.0).unwrap_err().to_string().contains("from 1 to 1"));
        assert!(DepthInterval::new(0.0, f64::NAN).is_err());
    }
}
