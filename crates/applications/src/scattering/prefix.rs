//! Transmittance-weighted prefix sums along the rows of a rectified shadow map (BHS16 section 2.2).

use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;

use super::Medium;
use crate::field::{MAX_CHANNELS, Means};

/// w_u = int e^(-sigma_t t) dt over the step about u delta, u = 1, 2, ... (BHS16's printed weights, half a step from the
/// camera; the shift scales all weights alike and cancels when they are normalised).
pub fn step_weights(medium: &Medium, delta: f64, count: usize) -> Vec<f64> {
    let weight = |u: usize| medium.transmitted_length((u as f64 - 0.5) * delta, (u as f64 + 0.5) * delta);
    (1..=count).map(weight).collect()
}

/// A row of normalised prefix sums: entry u holds the weighted mean of the moments of texels 0 to u.
#[derive(Clone, Debug, PartialEq)]
pub struct PrefixRow<R> {
    means: Vec<Means<R>>,
}

impl<R: Real> PrefixRow<R> {
    /// From stored values, one vector a texel, and the weight of each texel.
    ///
    /// # Panics
    /// If there are more values than weights.
    pub fn new(values: &[Means<R>], weights: &[f64]) -> Self {
        assert!(values.len() <= weights.len(), "a weight a texel");
        let (mut sums, mut total) = ([R::zero(); MAX_CHANNELS], R::zero());
        let means = values.iter().zip(weights).map(|(value, &weight)| {
            let weight = R::from_f64(weight);
            total = total + weight;
            sums.iter_mut().zip(value).for_each(|(sum, &value)| *sum = *sum + weight * value);
            // Where extinction leaves no weight at all, the nearest texel has the most.
            if total > R::zero() { sums.map(|sum| sum / total) } else { values[0] }
        });
        Self { means: means.collect() }
    }

    /// Texels.
    pub fn len(&self) -> usize {
        self.means.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.means.is_empty()
    }

    /// The means up to a texel, or to the last one.
    pub fn up_to(&self, texel: usize) -> Option<&Means<R>> {
        self.means.get(texel.min(self.means.len().checked_sub(1)?))
    }
}

/// Light scattered towards the camera, as a share of what it would be without shadows: 1 less the blend lower + beta (upper -
/// lower) of the bounds on the shadowed share (BHS16 section 2.4; beta = 0 is too bright, 1 too dark).
pub fn scattered<R: Real>(bound: MomentBound, moments: &[R], z_f: R, beta: R) -> R {
    R::one() - bound.bounds(moments, z_f).blend(beta)
}

/// The adaptive blend of the authors' talk (GDC16), beta = (1 + cosine) / 2: the upper bound when looking into the light,
/// where light that shines through walls is worst. The cosine is that between the directions in which light travels before
/// and after it is scattered to the camera.
pub fn adaptive_blend(cosine: f64) -> f64 {
    (0.5 + 0.5 * cosine).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With the distribution itself in place of moments, the prefix sums are the marched result on the same samples.
    #[test]
    fn exact_distributions_give_the_marched_result() {
        let medium = Medium::new(0.4, 1.0, 0.0).unwrap();
        let (delta, count, z_f) = (0.3, 40, 0.5);
        let depths: Vec<f64> = (0..count).map(|i| if i % 7 < 3 { 0.2 } else { 0.8 }).collect();
        let weights = step_weights(&medium, delta, count);
        // One channel holds the shadow itself.
        let values: Vec<Means<f64>> = depths
            .iter()
            .map(|&depth| std::array::from_fn(|k| if k == 0 { f64::from(depth < z_f) } else { 0.0 }))
            .collect();
        let row = PrefixRow::new(&values, &weights);
        for end in [0, 6, 39, 100] {
            let last = end.min(count - 1);
            let lit: f64 = (0..=last).filter(|&i| depths[i] >= z_f).map(|i| weights[i]).sum();
            let all: f64 = weights[..=last].iter().sum();
            assert!((1.0 - row.up_to(end).unwrap()[0] - lit / all).abs() < 1e-14);
        }
        assert!(PrefixRow::<f64>::new(&[], &[]).up_to(0).is_none());
        // Opaque air: only the first texel counts.
        let thick = Medium::new(1e6, 1.0, 0.0).unwrap();
        let row = PrefixRow::new(&values, &step_weights(&thick, delta, count));
        assert!(row.up_to(39).unwrap()[0] == 1.0);
    }
}
