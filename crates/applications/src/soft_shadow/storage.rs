//! How the powers of a depth are stored: of z in \[0, 1\] as BHS16 publishes it, of 2 z - 1 as the author does since, or
//! of 2 z - 1 through his sparse transform (GDC16).

use moment_problem::arithmetic::Real;
use quantization::QuantizationError;
use quantization::published::Published;
use serde::{Deserialize, Serialize};

use crate::field::{MAX_CHANNELS, Means};

/// What is stored of powers of depth; every stored value lies in \[0, 1\].
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Storage {
    /// z^k.
    #[default]
    Unit,
    /// s^k with s = 2 z - 1, odd powers as (s^k + 1) / 2: near and far end are alike, and powers lose fewer digits.
    Signed,
    /// Four powers of s through the transform of GDC16, which keeps odd and even ones apart and fills the range.
    Sparse,
}

/// The transform's order.
const SPARSE: usize = 4;

/// Its name among the published ones.
const SPARSE_NAME: &str = "GDC16 four moments";

/// The transform in the precision of a shader.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Matrices<R> {
    matrix: [R; SPARSE * SPARSE],
    inverse: [R; SPARSE * SPARSE],
    offset: [R; SPARSE],
}

/// [`Storage`] with its numbers at hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StoredPowers<R> {
    storage: Storage,
    matrices: Option<Matrices<R>>,
}

impl<R: Real> StoredPowers<R> {
    pub(super) fn unit() -> Self {
        Self { storage: Storage::Unit, matrices: None }
    }

    pub(super) fn storage(&self) -> Storage {
        self.storage
    }

    /// `None` for a transform of another order than four.
    pub(super) fn new(storage: Storage, channels: usize) -> Result<Option<Self>, QuantizationError> {
        if storage != Storage::Sparse {
            return Ok(Some(Self { storage, matrices: None }));
        }
        let Some(published) = Published::named(SPARSE_NAME).filter(|_| channels == SPARSE) else {
            return Ok(None);
        };
        let transform = published.transform()?;
        let cast = |values: &[f64]| std::array::from_fn(|i| R::from_f64(values[i]));
        let matrices = Matrices {
            matrix: cast(transform.matrix()),
            inverse: cast(transform.inverse()),
            offset: std::array::from_fn(|i| R::from_f64(transform.offset()[i])),
        };
        Ok(Some(Self { storage, matrices: Some(matrices) }))
    }

    pub(super) fn cast<S: Real>(&self) -> StoredPowers<S> {
        let cast = |value: R| S::from_f64(value.to_f64());
        let matrices = self.matrices.map(|m| Matrices {
            matrix: m.matrix.map(cast),
            inverse: m.inverse.map(cast),
            offset: m.offset.map(cast),
        });
        StoredPowers { storage: self.storage, matrices }
    }

    /// What is stored of `channels` powers, as matrix, its inverse and offset: offset + matrix powers.
    pub(super) fn affine(&self, channels: usize) -> [Vec<f64>; 3] {
        let diagonal = |odd: f64| -> Vec<f64> {
            let entry = |i: usize| match (i / channels == i % channels, (i % channels).is_multiple_of(2)) {
                (false, _) => 0.0,
                (true, true) => odd,
                (true, false) => 1.0,
            };
            (0..channels * channels).map(entry).collect()
        };
        let offset = |odd: f64| (0..channels).map(|i| if i % 2 == 0 { odd } else { 0.0 }).collect();
        match (self.storage, &self.matrices) {
            (Storage::Sparse, Some(Matrices { matrix, inverse, offset })) => {
                [&matrix[..], inverse, offset].map(|values| values.iter().map(|v| v.to_f64()).collect())
            }
            (Storage::Signed, _) => [diagonal(0.5), diagonal(2.0), offset(0.5)],
            (Storage::Unit | Storage::Sparse, _) => [diagonal(1.0), diagonal(1.0), offset(0.0)],
        }
    }

    /// Moments of half of the mass at each end of the range: b* of BHS16 section 3.4, and its like for s.
    pub(super) fn ends(&self) -> [R; MAX_CHANNELS] {
        std::array::from_fn(|i| match self.storage {
            Storage::Unit => R::from_f64(0.5),
            Storage::Signed | Storage::Sparse => R::from_f64(if i % 2 == 0 { 0.0 } else { 1.0 }),
        })
    }

    /// The variable of which powers are taken, of a depth in \[0, 1\].
    pub(super) fn variable(&self, z: R) -> R {
        match self.storage {
            Storage::Unit => z,
            Storage::Signed | Storage::Sparse => z + z - R::one(),
        }
    }

    /// The depth of the variable.
    pub(super) fn depth(&self, variable: R) -> R {
        match self.storage {
            Storage::Unit => variable,
            Storage::Signed | Storage::Sparse => R::from_f64(0.5) * (variable + R::one()),
        }
    }

    /// Stored values of a depth, as many as `out` has.
    pub(super) fn encode(&self, z: R, out: &mut [R]) {
        let variable = self.variable(z);
        let mut power = R::one();
        let mut powers = [R::zero(); MAX_CHANNELS];
        for value in powers.iter_mut().take(out.len()) {
            power = power * variable;
            *value = power;
        }
        let half = R::from_f64(0.5);
        match (self.storage, &self.matrices) {
            (Storage::Sparse, Some(Matrices { matrix, offset, .. })) => {
                for (i, value) in out.iter_mut().enumerate() {
                    *value = (0..SPARSE).fold(offset[i], |sum, j| sum + matrix[SPARSE * i + j] * powers[j]);
                }
            }
            (Storage::Signed, _) => {
                for (i, value) in out.iter_mut().enumerate() {
                    *value = if i % 2 == 0 { half * (powers[i] + R::one()) } else { powers[i] };
                }
            }
            (Storage::Unit | Storage::Sparse, _) => out.copy_from_slice(&powers[..out.len()]),
        }
    }

    /// Moments of the variable from means of stored values.
    pub(super) fn decode(&self, means: &Means<R>) -> Means<R> {
        match (self.storage, &self.matrices) {
            (Storage::Sparse, Some(Matrices { inverse, offset, .. })) => {
                let mut moments = [R::zero(); MAX_CHANNELS];
                for (i, moment) in moments.iter_mut().enumerate().take(SPARSE) {
                    *moment = (0..SPARSE)
                        .fold(R::zero(), |sum, j| sum + inverse[SPARSE * i + j] * (means[j] - offset[j]));
                }
                moments
            }
            (Storage::Signed, _) => {
                std::array::from_fn(|i| if i % 2 == 0 { means[i] + means[i] - R::one() } else { means[i] })
            }
            (Storage::Unit | Storage::Sparse, _) => *means,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_values_fill_the_range_and_come_back() {
        for (storage, channels) in
            [(Storage::Unit, 6), (Storage::Signed, 6), (Storage::Signed, 2), (Storage::Sparse, 4)]
        {
            let stored: StoredPowers<f64> = StoredPowers::new(storage, channels).unwrap().unwrap();
            let (mut least, mut most) = (1.0f64, 0.0f64);
            for i in 0..=100 {
                let z = f64::from(i) / 100.0;
                let mut out = [0.0; MAX_CHANNELS];
                stored.encode(z, &mut out[..channels]);
                out[..channels].iter().for_each(|&v| (least, most) = (least.min(v), most.max(v)));
                let moments = stored.decode(&out);
                let x = stored.variable(z);
                for (k, moment) in moments.iter().enumerate().take(channels) {
                    assert!((moment - x.powi(k as i32 + 1)).abs() < 1e-14, "{storage:?} {z} {k} {moment}");
                }
                assert!((stored.depth(x) - z).abs() < 1e-15);
            }
            assert!(least > -1e-14 && least < 0.01 && most > 0.99 && most < 1.0 + 1e-14, "{storage:?}");
        }
        assert!(StoredPowers::<f64>::new(Storage::Sparse, 6).unwrap().is_none());
    }
}
