//! The Python module `msm._msm`: what `msm` on the command line does, on arrays. Shapes are checked and broadcast by the package
//! around it (`python/msm`); here arrays are contiguous and flat. The interpreter's lock is released while Rust computes.

mod bounds;
mod closed_forms;
mod experiments;
mod scenes;
mod technique;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use std::error::Error;

/// An error of input with its causes on one line, as the binary prints it.
fn input(error: &dyn Error) -> PyErr {
    PyValueError::new_err(line(error))
}

/// An error of work that failed.
fn failed(error: &dyn Error) -> PyErr {
    PyRuntimeError::new_err(line(error))
}

fn line(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        // Most errors name their cause already.
        let inner_text = inner.to_string();
        if !text.contains(&inner_text) {
            text = format!("{text}: {inner_text}");
        }
        cause = inner.source();
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[pymodule]
fn _msm(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<bounds::Bounds>()?;
    module.add_class::<scenes::Scene>()?;
    module.add_class::<scenes::Stack>()?;
    module.add_class::<technique::Technique>()?;
    module.add_class::<bounds::Quantization>()?;
    module.add_function(wrap_pyfunction!(bounds::basis_length, module)?)?;
    module.add_function(wrap_pyfunction!(bounds::bounds, module)?)?;
    module.add_function(wrap_pyfunction!(bounds::certified, module)?)?;
    module.add_function(wrap_pyfunction!(bounds::quantize, module)?)?;
    module.add_function(wrap_pyfunction!(closed_forms::closed_form_single, module)?)?;
    module.add_function(wrap_pyfunction!(closed_forms::closed_form_double, module)?)?;
    module.add_function(wrap_pyfunction!(closed_forms::order, module)?)?;
    module.add_function(wrap_pyfunction!(scenes::load_scene, module)?)?;
    module.add_function(wrap_pyfunction!(scenes::render_stack, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::advise, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::error, module)?)?;
    module.add_function(wrap_pyfunction!(experiments::run_files, module)?)?;
    Ok(())
}
