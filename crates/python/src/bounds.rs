//! Bounds with proofs, and optimal transforms.

use crate::{failed, input};
use moment_problem::{Basis, DepthDistribution, Interval, MomentError, Solver, method};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use quantization::{DepthInterval, Search, Structure, optimise};
use rayon::prelude::*;

/// Sharp bounds of the shadow intensity with a distribution that attains the lower one.
#[pyclass(frozen, get_all, module = "msm")]
pub(crate) struct Bounds {
    /// Least possible mass strictly before z_f.
    lower: f64,
    /// Largest possible mass up to and including z_f.
    upper: f64,
    /// Proved: no distribution has less mass strictly before z_f.
    lower_proved: f64,
    /// Proved: none has more mass up to and including z_f.
    upper_proved: f64,
    /// Depths of a distribution that attains the lower bound.
    support: Vec<f64>,
    /// Its weights.
    weights: Vec<f64>,
    /// What computed it.
    solver: String,
    /// Largest proved excess of a dual function over its step.
    worst_slack: f64,
}

#[pymethods]
impl Bounds {
    fn __repr__(&self) -> String {
        format!(
            "Bounds(lower={}, upper={}, lower_proved={}, upper_proved={})",
            self.lower, self.upper, self.lower_proved, self.upper_proved
        )
    }
}

fn of_moments(error: &MomentError) -> PyErr {
    if error.is_failure() { failed(error) } else { input(error) }
}

fn parsed(basis: &str, interval: &str, solver: Option<&str>) -> PyResult<(Basis, Interval, Option<Solver>)> {
    let basis = basis.parse().map_err(|error: moment_problem::BasisError| input(&error))?;
    let interval = interval.parse().map_err(|error: MomentError| of_moments(&error))?;
    let solver = solver.map(str::parse).transpose().map_err(|error: MomentError| of_moments(&error))?;
    Ok((basis, interval, solver))
}

/// Functions of a basis.
#[pyfunction]
pub(crate) fn basis_length(basis: &str) -> PyResult<usize> {
    Ok(parsed(basis, Interval::Unit.name(), None)?.0.len())
}

/// Of moments, or with `weights` of a distribution whose depths stand in `values`.
#[pyfunction]
pub(crate) fn bounds(
    py: Python<'_>,
    basis: &str,
    values: Vec<f64>,
    weights: Option<Vec<f64>>,
    z_f: f64,
    interval: &str,
    solver: Option<&str>,
) -> PyResult<Bounds> {
    let (basis, interval, solver) = parsed(basis, interval, solver)?;
    py.detach(|| {
        let method = method(&basis, interval, solver).map_err(|error| of_moments(&error))?;
        let found = match weights {
            None => method.bounds(&values, z_f),
            Some(weights) => {
                let distribution =
                    DepthDistribution::new(&values, &weights).map_err(|error| input(&error))?;
                method.bounds_of(&distribution, z_f)
            }
        };
        let found = found.map_err(|error| of_moments(&error))?;
        Ok(Bounds {
            // Adding zero turns a negative zero into zero.
            lower: found.lower + 0.0,
            upper: found.upper,
            lower_proved: found.certificate.lower_proved,
            upper_proved: found.certificate.upper_proved,
            worst_slack: found.certificate.worst_slack,
            support: found.support,
            weights: found.weights,
            solver: method.name().to_owned(),
        })
    })
}

type Pair<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Proved bounds of many vectors.
#[pyfunction]
pub(crate) fn certified<'py>(
    py: Python<'py>,
    basis: &str,
    moments: PyReadonlyArray1<'py, f64>,
    z_f: PyReadonlyArray1<'py, f64>,
    interval: &str,
    solver: Option<&str>,
) -> PyResult<Pair<'py>> {
    let (basis, interval, solver) = parsed(basis, interval, solver)?;
    let (moments, z_f) = (moments.as_slice()?, z_f.as_slice()?);
    let pairs = py.detach(|| {
        let method = method(&basis, interval, solver).map_err(|error| of_moments(&error))?;
        let order = basis.len();
        let each = |(number, (b, &z)): (usize, (&[f64], &f64))| {
            let found = method.bounds(b, z).map_err(|error| (number, error))?;
            Ok((found.certificate.lower_proved, found.certificate.upper_proved))
        };
        let vectors = moments.par_chunks_exact(order).zip(z_f).enumerate();
        let found: Result<Vec<(f64, f64)>, (usize, MomentError)> = vectors.map(each).collect();
        found.map_err(|(number, error)| {
            let named = format!("vector {number}: {error}");
            if error.is_failure() { PyRuntimeError::new_err(named) } else { PyValueError::new_err(named) }
        })
    })?;
    let (lower, upper) = pairs.into_iter().unzip();
    Ok((PyArray1::from_vec(py, lower), PyArray1::from_vec(py, upper)))
}

/// An optimal transform: gain, bound, range, and the matrix, its inverse and the offset.
#[pyclass(frozen, get_all, module = "msm")]
pub(crate) struct Quantization {
    order: usize,
    gain_bits: f64,
    bound_bits: f64,
    range_min: f64,
    range_max: f64,
    depths: (f64, f64),
    matrix: Vec<f64>,
    inverse: Vec<f64>,
    offset: Vec<f64>,
}

/// See `msm quantize`.
#[pyfunction]
pub(crate) fn quantize(
    py: Python<'_>,
    basis: &str,
    signed: bool,
    parity: bool,
    starts: Option<usize>,
    seed: u64,
) -> PyResult<Quantization> {
    let basis: Basis = basis.parse().map_err(|error: moment_problem::BasisError| input(&error))?;
    let interval = if signed { DepthInterval::SIGNED } else { DepthInterval::UNIT };
    let structure = if parity { Structure::Parity } else { Structure::Dense };
    let search = Search { structure, starts, seed };
    let optimum = py.detach(|| optimise(&basis, interval, &search)).map_err(|error| input(&error))?;
    Ok(Quantization {
        order: optimum.transform.order(),
        gain_bits: optimum.gain_bits,
        bound_bits: optimum.bound_bits,
        range_min: optimum.range_min,
        range_max: optimum.range_max,
        depths: (optimum.depths.start(), optimum.depths.end()),
        matrix: optimum.transform.matrix().to_vec(),
        inverse: optimum.transform.inverse().to_vec(),
        offset: optimum.transform.offset().to_vec(),
    })
}
