//! A filterable shadow map on arrays.

use crate::{failed, input};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use shadow_filtering::{ChannelMap, DepthMap, FilteringError, Kernel, Precision, TechniqueSpec};

/// Vectors that a thread takes at a time.
const CHUNK: usize = 4096;

/// A basis, an encoding and a bound.
#[pyclass(frozen, module = "msm")]
pub(crate) struct Technique {
    technique: shadow_filtering::Technique,
}

fn fault(error: FilteringError) -> PyErr {
    match &error {
        FilteringError::Moments(_) => failed(&error),
        _ => input(&error),
    }
}

impl Technique {
    fn encoded<P: Precision>(&self, depths: &[P]) -> Vec<P> {
        let channels = self.technique.channels();
        let mut out = vec![P::zero(); depths.len() * channels];
        let texels = out.par_chunks_mut(CHUNK * channels).zip(depths.par_chunks(CHUNK));
        texels.for_each(|(texels, depths)| {
            for (texel, &depth) in texels.chunks_exact_mut(channels).zip(depths) {
                self.technique.encode(depth, texel);
            }
        });
        out
    }

    fn filtered<P: Precision>(&self, map: &DepthMap, kernel: &Kernel) -> PyResult<Vec<P>> {
        let stored: ChannelMap<P> = self.technique.filtered(map, kernel).map_err(fault)?;
        let channels = self.technique.channels();
        let mut out = vec![P::zero(); stored.data().len()];
        out.par_chunks_exact_mut(channels)
            .zip(stored.data().par_chunks_exact(channels))
            .for_each(|(b, texel)| self.technique.restore(texel, b));
        Ok(out)
    }

    fn shaded<P: Precision>(&self, filtered: &[P], z_f: &[P]) -> PyResult<Vec<P>> {
        let channels = self.technique.channels();
        if filtered.len() != channels * z_f.len() {
            let lengths = format!("{} values and {} depths", filtered.len(), z_f.len());
            return Err(PyValueError::new_err(format!(
                "{lengths} do not belong together: {channels} a depth"
            )));
        }
        let each = filtered.par_chunks_exact(channels).zip(z_f);
        each.with_min_len(CHUNK)
            .map(|(b, &z)| self.technique.shade(b, z))
            .collect::<Result<_, _>>()
            .map_err(fault)
    }
}

fn map((width, height): (usize, usize), depths: &[f32]) -> PyResult<DepthMap> {
    DepthMap::new(width, height, depths.to_vec()).map_err(fault)
}

fn gaussian((size, sigma): (usize, f64)) -> PyResult<Kernel> {
    Kernel::gaussian(size, sigma).map_err(fault)
}

#[pymethods]
impl Technique {
    /// From the keys of an experiment's `method`, as JSON.
    #[new]
    fn new(py: Python<'_>, keys: &str) -> PyResult<Self> {
        let spec: TechniqueSpec = serde_json::from_str(keys).map_err(|error| {
            // The place in a text that the caller has not written says nothing.
            let text = error.to_string();
            PyValueError::new_err(text.split(" at line ").next().unwrap_or_default().to_owned())
        })?;
        let technique = py.detach(|| spec.build()).map_err(fault)?;
        Ok(Self { technique })
    }

    #[getter]
    fn name(&self) -> String {
        self.technique.name()
    }

    #[getter]
    fn channels(&self) -> usize {
        self.technique.channels()
    }

    #[getter]
    fn bits_per_texel(&self) -> usize {
        self.technique.bits_per_texel()
    }

    #[getter]
    fn is_lower_bound(&self) -> bool {
        self.technique.is_lower_bound()
    }

    fn encode_single<'py>(
        &self,
        py: Python<'py>,
        depths: PyReadonlyArray1<'py, f32>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let depths = depths.as_slice()?;
        Ok(PyArray1::from_vec(py, py.detach(|| self.encoded(depths))))
    }

    fn encode_double<'py>(
        &self,
        py: Python<'py>,
        depths: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let depths = depths.as_slice()?;
        Ok(PyArray1::from_vec(py, py.detach(|| self.encoded(depths))))
    }

    fn filter_single<'py>(
        &self,
        py: Python<'py>,
        depths: PyReadonlyArray1<'py, f32>,
        size: (usize, usize),
        kernel: (usize, f64),
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let depths = depths.as_slice()?;
        let found = py.detach(|| self.filtered(&map(size, depths)?, &gaussian(kernel)?))?;
        Ok(PyArray1::from_vec(py, found))
    }

    fn filter_double<'py>(
        &self,
        py: Python<'py>,
        depths: PyReadonlyArray1<'py, f32>,
        size: (usize, usize),
        kernel: (usize, f64),
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let depths = depths.as_slice()?;
        let found = py.detach(|| self.filtered(&map(size, depths)?, &gaussian(kernel)?))?;
        Ok(PyArray1::from_vec(py, found))
    }

    fn shade_single<'py>(
        &self,
        py: Python<'py>,
        filtered: PyReadonlyArray1<'py, f32>,
        z_f: PyReadonlyArray1<'py, f32>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let (filtered, z_f) = (filtered.as_slice()?, z_f.as_slice()?);
        Ok(PyArray1::from_vec(py, py.detach(|| self.shaded(filtered, z_f))?))
    }

    fn shade_double<'py>(
        &self,
        py: Python<'py>,
        filtered: PyReadonlyArray1<'py, f64>,
        z_f: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (filtered, z_f) = (filtered.as_slice()?, z_f.as_slice()?);
        Ok(PyArray1::from_vec(py, py.detach(|| self.shaded(filtered, z_f))?))
    }
}
