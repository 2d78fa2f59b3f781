//! Scenes and stacks of shadow maps as arrays.

use crate::{failed, input};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use scenes::{LightView, SceneError};
use shadow_renderer::{Backend, RenderError, render_view};

/// A scene in its pose.
#[pyclass(frozen, module = "msm")]
pub(crate) struct Scene {
    scene: scenes::Scene,
}

#[pymethods]
impl Scene {
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Names of the views with the directions in which their lights travel.
    #[getter]
    fn views(&self) -> Vec<(String, [f32; 3])> {
        self.scene.views.iter().map(|view| (view.name.clone(), view.direction)).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings.iter().map(ToString::to_string).collect()
    }

    /// World positions of corners.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let flat: Vec<f32> = self.scene.vertices.iter().flat_map(|vertex| vertex.position).collect();
        PyArray1::from_vec(py, flat).reshape([self.scene.vertices.len(), 3])
    }

    /// Corners of triangles.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let flat: Vec<u32> = self.scene.triangles.iter().flatten().copied().collect();
        PyArray1::from_vec(py, flat).reshape([self.scene.triangles.len(), 3])
    }

    fn __repr__(&self) -> String {
        format!(
            "Scene({}, {} triangles, {} views)",
            self.scene.name,
            self.scene.triangles.len(),
            self.scene.views.len()
        )
    }
}

/// Every surface that light rays cross, texel by texel.
#[pyclass(frozen, get_all, module = "msm")]
pub(crate) struct Stack {
    width: u32,
    height: u32,
    /// First fragment of each texel, and the number of fragments.
    offsets: Py<PyArray1<u32>>,
    /// Depths, ascending within a texel.
    depths: Py<PyArray1<f32>>,
    /// Change of depth from texel to texel along x and y.
    gradients: Py<PyArray2<f32>>,
    /// Whether the front side points to the light.
    light_facing: Py<PyArray1<bool>>,
}

fn of_scene(error: &SceneError) -> PyErr {
    input(error)
}

/// Reads or makes a scene.
#[pyfunction]
pub(crate) fn load_scene(py: Python<'_>, name: &str) -> PyResult<Scene> {
    let scene = py.detach(|| scenes::load_scene(name)).map_err(|error| of_scene(&error))?;
    Ok(Scene { scene })
}

fn backend(name: &str) -> PyResult<Backend> {
    match name {
        "cpu" => Ok(Backend::Cpu),
        "gpu" => Ok(Backend::Gpu),
        "auto" => Ok(Backend::Auto),
        other => Err(PyValueError::new_err(format!("backend `{other}` is none of cpu, gpu, auto"))),
    }
}

/// Renders the stack of a view.
#[pyfunction]
pub(crate) fn render_stack(
    py: Python<'_>,
    scene: &Scene,
    view: Option<&str>,
    direction: Option<[f32; 3]>,
    size: (u32, u32),
    backend_name: &str,
) -> PyResult<Stack> {
    let own = &scene.scene.views;
    let light = match (direction, view) {
        (Some(direction), _) => LightView::directional("light", direction),
        (None, None) => own[0].clone(),
        (None, Some(name)) => own.iter().find(|view| view.name == name).cloned().ok_or_else(|| {
            let names: Vec<&str> = own.iter().map(|view| view.name.as_str()).collect();
            PyValueError::new_err(format!(
                "`{}` has no view `{name}` (it has: {})",
                scene.scene.name,
                names.join(", ")
            ))
        })?,
    };
    let backend = backend(backend_name)?;
    let rendered = py.detach(|| render_view(&scene.scene, &light, size.0, size.1, backend));
    let (stack, _) = rendered.map_err(|error: RenderError| match &error {
        RenderError::MapSize { .. } | RenderError::Scene(_) => input(&error),
        _ => failed(&error),
    })?;
    let fragments = stack.depths.len();
    let facing: Vec<bool> = stack.light_facing.iter().collect();
    Ok(Stack {
        width: stack.width,
        height: stack.height,
        // The memory of the stack itself.
        offsets: PyArray1::from_vec(py, stack.offsets).unbind(),
        depths: PyArray1::from_vec(py, stack.depths).unbind(),
        gradients: PyArray1::from_vec(py, stack.gradients.into_flattened()).reshape([fragments, 2])?.unbind(),
        light_facing: PyArray1::from_vec(py, facing).unbind(),
    })
}
