//! Transmittance-weighted prefix sums along the rows of a rectified shadow map (BHS16 section 2.2).

use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;

use super::Medium;

/// w_u = int e^(-sigma_t t) dt over the step about u delta, u = 1, 2, ... (BHS16's printed weights, half a step from the
/// camera; the shift scales all weights alike and cancels when they are normalised).
pub fn step_weights(medium: &Medium, delta: f64, count: usize) -> Vec<f64> {
    let weight = |u: usize| medium.transmitted_length((u as f64 - 0.5) * delta, (u as f64 + 0.5) * delta);
    (1..=count).map(weight).collect()
}

/// The same over the first: e^(-sigma_t u delta) with u from 0. No extinction makes all of them vanish.
pub fn relative_weights(medium: &Medium, delta: f64, count: usize) -> impl Iterator<Item = f64> + use<> {
    let medium = *medium;
    (0..count).map(move |u| medium.transmittance(u as f64 * delta))
}

/// Normalised prefix sums in place: texel u of a row, `channels` values each, becomes the weighted mean of texels 0 to u.
///
/// # Panics
/// If there are fewer weights than texels.
pub fn prefix_means<R: Real>(row: &mut [R], channels: usize, weights: impl IntoIterator<Item = f64>) {
    let mut weights = weights.into_iter();
    let mut sums = vec![R::zero(); channels];
    let mut total = R::zero();
    for texel in row.chunks_exact_mut(channels) {
        let Some(weight) = weights.next() else { panic!("a weight a texel") };
        let weight = R::from_f64(weight);
        total = total + weight;
        sums.iter_mut().zip(&*texel).for_each(|(sum, &value)| *sum = *sum + weight * value);
        texel.iter_mut().zip(&sums).for_each(|(value, &sum)| *value = sum / total);
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

    #[test]
    fn prefix_sums_are_weighted_means() {
        let medium = Medium::new(0.4, 1.0, 0.0).unwrap();
        let (delta, count) = (0.3, 40);
        let values: Vec<f64> =
            (0..2 * count).map(|i| f64::from(u8::from(i % 7 < 3)) + 0.1 * i as f64).collect();
        let weights = step_weights(&medium, delta, count);
        let mut row = values.clone();
        prefix_means(&mut row, 2, relative_weights(&medium, delta, count));
        for u in [0, 6, 39] {
            for c in 0..2 {
                let sum: f64 = (0..=u).map(|i| weights[i] * values[2 * i + c]).sum();
                let all: f64 = weights[..=u].iter().sum();
                assert!((row[2 * u + c] - sum / all).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn opaque_air_shows_the_nearest_texel() {
        let thick = Medium::new(1e6, 1.0, 0.0).unwrap();
        let mut row = [1.0f32, 0.0, 0.5];
        prefix_means(&mut row, 1, relative_weights(&thick, 0.3, 3));
        assert_eq!(row, [1.0; 3]);
        let mut none: [f64; 0] = [];
        prefix_means(&mut none, 4, []);
    }
}
