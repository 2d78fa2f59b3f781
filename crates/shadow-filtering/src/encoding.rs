//! The affine transform of an encoding in single precision, as a shader computes it.

use quantization::AffineTransform;

/// An affine transform and its inverse.
pub(crate) struct SingleEncoding {
    matrix: Vec<f32>,
    offset: Vec<f32>,
    inverse: Vec<f32>,
    /// -inverse offset, multiplied in double precision.
    inverse_offset: Vec<f32>,
    is_diagonal: bool,
}

impl SingleEncoding {
    /// `None` for the identity: values are stored as they are.
    pub(crate) fn new(transform: &AffineTransform) -> Option<Self> {
        if *transform == AffineTransform::identity(transform.order()) {
            return None;
        }
        let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        let rows = transform.inverse().chunks_exact(transform.order());
        let constant =
            rows.map(|row| -row.iter().zip(transform.offset()).map(|(a, o)| a * o).sum::<f64>() as f32);
        Some(Self {
            matrix: single(transform.matrix()),
            offset: single(transform.offset()),
            inverse: single(transform.inverse()),
            inverse_offset: constant.collect(),
            is_diagonal: (0..transform.order() * transform.order())
                .all(|k| k % (transform.order() + 1) == 0 || transform.matrix()[k] == 0.0),
        })
    }

    /// matrix b + offset.
    pub(crate) fn transform(&self, b: &[f32], out: &mut [f32]) {
        affine(&self.matrix, &self.offset, b, out, self.is_diagonal);
    }

    /// Operations of [`SingleEncoding::restore`]: a product and a sum for each factor that is not zero.
    pub(crate) fn operations(&self) -> u64 {
        2 * self.inverse.iter().filter(|&&factor| factor != 0.0).count() as u64
    }

    /// The b that [`SingleEncoding::transform`] maps to `stored`.
    pub(crate) fn restore(&self, stored: &[f32], out: &mut [f32]) {
        affine(&self.inverse, &self.inverse_offset, stored, out, self.is_diagonal);
    }
}

/// matrix values + offset; a diagonal matrix is worth a shorter way.
fn affine(matrix: &[f32], offset: &[f32], values: &[f32], out: &mut [f32], is_diagonal: bool) {
    if is_diagonal {
        let factors = matrix.iter().step_by(values.len() + 1);
        for (((out, &factor), &value), &offset) in out.iter_mut().zip(factors).zip(values).zip(offset) {
            *out = factor * value + offset;
        }
        return;
    }
    for ((out, row), &offset) in out.iter_mut().zip(matrix.chunks_exact(values.len())).zip(offset) {
        *out = row.iter().zip(values).fold(0.0, |sum, (m, v)| sum + m * v) + offset;
    }
}

/// See [`Technique::transform_wgsl`](crate::Technique::transform_wgsl).
pub(crate) fn wgsl(transform: Option<&SingleEncoding>) -> [String; 2] {
    let function = |name: &str, values: &str| {
        format!(
            "fn {name}(values: array<f32, CHANNELS>) -> array<f32, CHANNELS> {{\n    return {values};\n}}\n"
        )
    };
    let Some(transform) = transform else {
        return ["quantise", "dequantise"].map(|name| function(name, "values"));
    };
    let affine = |name: &str, matrix: &[f32], offset: &[f32]| {
        let rows = matrix.chunks_exact(offset.len()).zip(offset).map(|(row, offset)| {
            let factors = row.iter().enumerate().filter(|(_, factor)| **factor != 0.0);
            let terms: Vec<String> =
                factors.map(|(j, factor)| format!("{factor:?}f * values[{j}]")).collect();
            format!("{} + {offset:?}f", terms.join(" + "))
        });
        let rows: Vec<String> = rows.collect();
        function(name, &format!("array<f32, CHANNELS>({})", rows.join(", ")))
    };
    [
        affine("quantise", &transform.matrix, &transform.offset),
        affine("dequantise", &transform.inverse, &transform.inverse_offset),
    ]
}
