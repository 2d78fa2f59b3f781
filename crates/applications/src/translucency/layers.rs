//! Surfaces along a light ray, the light that each takes, and moments by blending.

use thiserror::Error;

/// A surface that a light ray crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    depth: f64,
    opacity: f64,
}

/// A surface that none can be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LayerError {
    /// Opacity outside of [0, 1].
    #[error("opacity {opacity} at depth {depth}: must lie in [0, 1]")]
    Opacity {
        /// Its depth.
        depth: f64,
        /// The number.
        opacity: f64,
    },
    /// A depth that is no number.
    #[error("depth {depth} is not finite")]
    Depth {
        /// The number.
        depth: f64,
    },
    /// A list that does not say which texel owns which layer.
    #[error("offsets do not divide {layers} layers among {texels} texels")]
    Offsets {
        /// Number of texels.
        texels: usize,
        /// Number of layers.
        layers: usize,
    },
}

impl Layer {
    /// `opacity` is alpha: the share of the arriving light that the surface takes.
    ///
    /// # Errors
    /// [`LayerError`].
    pub fn new(depth: f64, opacity: f64) -> Result<Self, LayerError> {
        if !depth.is_finite() {
            return Err(LayerError::Depth { depth });
        }
        if !(0.0..=1.0).contains(&opacity) {
            return Err(LayerError::Opacity { depth, opacity });
        }
        Ok(Self { depth, opacity })
    }

    /// Depth.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Alpha.
    pub fn opacity(&self) -> f64 {
        self.opacity
    }
}

/// Nearest first; surfaces at one depth keep their order.
fn sorted(layers: &[Layer]) -> Vec<Layer> {
    let mut sorted = layers.to_vec();
    sorted.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    sorted
}

/// Depth and share of the light that is taken there, alpha_i prod (1 - alpha_j) over the nearer j, nearest first. What no
/// surface takes is the rest of 1: an opaque background, a last layer of opacity 1, takes it.
pub fn taken(layers: &[Layer]) -> Vec<(f64, f64)> {
    let mut left = 1.0;
    let take = |layer: Layer| {
        let share = left * layer.opacity;
        left *= 1.0 - layer.opacity;
        (layer.depth, share)
    };
    sorted(layers).into_iter().map(take).collect()
}

/// F(z_f) = 1 - prod (1 - alpha_j) over z_j < z_f: the shadow of a ray at a depth, whatever the order of its layers.
pub fn in_front(layers: &[Layer], z_f: f64) -> f64 {
    1.0 - layers.iter().filter(|layer| layer.depth < z_f).map(|layer| 1.0 - layer.opacity).product::<f64>()
}

/// The functions of depth of the light that is taken, by blending as a graphics processor does: from the farthest layer to the
/// nearest, each lets through what lies behind and adds its own, b = alpha b(z) + (1 - alpha) b. `round` is what storing a
/// value after each blend makes of it. `layers` are blended in their order, so that a wrong one can be tried.
pub fn blended(
    layers: &[Layer],
    background: Vec<f64>,
    mut functions: impl FnMut(f64, &mut [f64]),
    round: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let mut values = background;
    values.iter_mut().for_each(|value| *value = round(*value));
    let mut own = vec![0.0; values.len()];
    for layer in layers {
        functions(layer.depth, &mut own);
        for (value, own) in values.iter_mut().zip(&own) {
            *value = round(layer.opacity * own + (1.0 - layer.opacity) * *value);
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use random_stream::Random;

    fn powers(z: f64) -> [f64; 4] {
        [z, z * z, z * z * z, z * z * z * z]
    }

    #[test]
    fn blending_gives_the_moments_of_the_distribution() {
        let mut random = Random::new(21);
        for count in 0..12 {
            let mut layers: Vec<Layer> =
                (0..count).map(|_| Layer::new(random.unit(), random.unit()).unwrap()).collect();
            let distribution = taken(&layers);
            let rest = 1.0 - distribution.iter().map(|(_, share)| share).sum::<f64>();
            layers.sort_by(|a, b| b.depth.total_cmp(&a.depth));
            let functions = |z: f64, out: &mut [f64]| out.copy_from_slice(&powers(z));
            let blended = blended(&layers, powers(1.0).to_vec(), functions, |value| value);
            for (k, got) in blended.into_iter().enumerate() {
                let sum: f64 = distribution.iter().map(|&(z, share)| share * powers(z)[k]).sum();
                assert!((got - sum - rest).abs() < 1e-12);
            }
            let z_f = random.unit();
            let before: f64 = distribution.iter().filter(|(z, _)| *z < z_f).map(|(_, share)| share).sum();
            assert!((in_front(&layers, z_f) - before).abs() < 1e-14);
        }
    }

    #[test]
    fn opaque_layers_hide_what_is_behind_and_clear_ones_nothing() {
        let of = |depth, opacity| Layer::new(depth, opacity).unwrap();
        assert_eq!(taken(&[of(0.7, 1.0), of(0.2, 0.0), of(0.3, 1.0)]), [(0.2, 0.0), (0.3, 1.0), (0.7, 0.0)]);
        assert_eq!(in_front(&[of(0.2, 0.0)], 0.5), 0.0);
        assert!(Layer::new(0.5, 1.5).unwrap_err().to_string().contains("1.5"));
        assert!(Layer::new(0.5, f64::NAN).is_err() && Layer::new(f64::INFINITY, 0.5).is_err());
    }
}
