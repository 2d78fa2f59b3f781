//! Closed forms over many moment vectors at once.

use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;
use numpy::{Element, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Vectors that a thread takes at a time: enough to hide what handing them out costs.
const CHUNK: usize = 4096;

type Pair<'py, T> = (Bound<'py, PyArray1<T>>, Bound<'py, PyArray1<T>>);

fn named(name: &str) -> PyResult<MomentBound> {
    let found =
        MomentBound::ALL.into_iter().find(|bound| bound.name().replace(' ', "").to_lowercase() == name);
    found.ok_or_else(|| PyValueError::new_err(format!("`{name}` is no closed form")))
}

/// Moments of a vector of a closed form.
#[pyfunction]
pub(crate) fn order(name: &str) -> PyResult<usize> {
    Ok(named(name)?.order())
}

fn batch<R: Real + Send + Sync>(
    name: &str,
    moments: &[R],
    z_f: &[R],
    alpha: f64,
) -> PyResult<(Vec<R>, Vec<R>)> {
    let bound = named(name)?;
    let order = bound.order();
    if moments.len() != order * z_f.len() {
        let lengths = format!("{} moments and {} depths", moments.len(), z_f.len());
        return Err(PyValueError::new_err(format!(
            "{lengths} do not belong together: {name} has {order} moments"
        )));
    }
    if !(0.0..=1.0).contains(&alpha) {
        return Err(PyValueError::new_err(format!("alpha = {alpha}: must lie in [0, 1]")));
    }
    let (mut lower, mut upper) = (vec![R::zero(); z_f.len()], vec![R::zero(); z_f.len()]);
    let out = lower.par_chunks_mut(CHUNK).zip(upper.par_chunks_mut(CHUNK));
    let given = moments.par_chunks(CHUNK * order).zip(z_f.par_chunks(CHUNK));
    out.zip(given).for_each(|((lower, upper), (moments, z_f))| {
        let out = lower.iter_mut().zip(upper.iter_mut());
        for ((lower, upper), (b, &z)) in out.zip(moments.chunks_exact(order).zip(z_f)) {
            let pair = match alpha {
                0.0 => bound.bounds(b, z),
                alpha => bound.biased_bounds(b, alpha, bound.centre(), z),
            };
            (*lower, *upper) = (pair.lower, pair.upper);
        }
    });
    Ok((lower, upper))
}

fn pair<'py, R: Real + Element + Send + Sync>(
    py: Python<'py>,
    name: &str,
    (moments, z_f): (&[R], &[R]),
    alpha: f64,
) -> PyResult<Pair<'py, R>> {
    let (lower, upper) = py.detach(|| batch(name, moments, z_f, alpha))?;
    Ok((PyArray1::from_vec(py, lower), PyArray1::from_vec(py, upper)))
}

/// Lower and upper bounds in single precision.
#[pyfunction]
pub(crate) fn closed_form_single<'py>(
    py: Python<'py>,
    name: &str,
    moments: PyReadonlyArray1<'py, f32>,
    z_f: PyReadonlyArray1<'py, f32>,
    alpha: f64,
) -> PyResult<Pair<'py, f32>> {
    pair(py, name, (moments.as_slice()?, z_f.as_slice()?), alpha)
}

/// The same in double precision.
#[pyfunction]
pub(crate) fn closed_form_double<'py>(
    py: Python<'py>,
    name: &str,
    moments: PyReadonlyArray1<'py, f64>,
    z_f: PyReadonlyArray1<'py, f64>,
    alpha: f64,
) -> PyResult<Pair<'py, f64>> {
    pair(py, name, (moments.as_slice()?, z_f.as_slice()?), alpha)
}
