//! Filterable shadow maps of transmittance, drawn by blending (BHS16 section 4.2).

use rayon::prelude::*;
use shadow_filtering::{ChannelMap, FilteringError, Technique};

use super::{Layer, LayeredMap, blended};

/// Where blending rounds to the technique's format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// After every layer, as a render target does.
    #[default]
    EachLayer,
    /// Once, after the last layer.
    Once,
    /// Nowhere.
    Never,
}

/// What a texel of a technique holds once its layers have been blended: from the nearest opaque layer, else the far plane, to
/// the nearest layer. Without `ranks` layers are blended from the farthest on; with them, one a layer, from the largest rank on,
/// whatever their depths.
pub fn blended_texel(
    technique: &Technique,
    layers: &[Layer],
    ranks: Option<&[f32]>,
    rounding: Rounding,
) -> Vec<f64> {
    let channels = technique.channels();
    let mut b = vec![0.0; channels];
    // The transform is affine, so that blending commutes with it.
    let mut values = |depth: f64, out: &mut [f64]| {
        technique.evaluate(depth, &mut b);
        technique.encoding().transform().apply(&b, out);
    };
    let opaque = layers.iter().position(|layer| layer.opacity() == 1.0);
    let mut background = vec![0.0; channels];
    values(opaque.map_or(1.0, |place| layers[place].depth()), &mut background);
    let front = &layers[..opaque.unwrap_or(layers.len())];
    let mut order: Vec<usize> = (0..front.len()).rev().collect();
    if let Some(ranks) = ranks {
        order.sort_by(|&i, &j| ranks[j].total_cmp(&ranks[i]));
    }
    let ordered: Vec<Layer> = order.into_iter().map(|i| front[i]).collect();
    let format = technique.encoding().format();
    match rounding {
        Rounding::EachLayer => blended(&ordered, background, values, |value| format.round(value)),
        Rounding::Once | Rounding::Never => {
            let mut texel = blended(&ordered, background, values, |value| value);
            if rounding == Rounding::Once {
                texel.iter_mut().for_each(|value| *value = format.round(*value));
            }
            texel
        }
    }
}

/// The whole map, before it is filtered.
///
/// # Errors
/// [`FilteringError::NotFinite`] where a value has no number.
pub fn blended_map(
    map: &LayeredMap,
    technique: &Technique,
    ranks: Option<&[f32]>,
    rounding: Rounding,
) -> Result<ChannelMap<f64>, FilteringError> {
    let [width, height] = map.size();
    let channels = technique.channels();
    let mut data = vec![0.0; width * height * channels];
    let row = |(y, out): (usize, &mut [f64])| {
        for (x, out) in out.chunks_exact_mut(channels).enumerate() {
            let texel = y * width + x;
            let ranks = ranks.map(|ranks| &ranks[map.range(texel)]);
            out.copy_from_slice(&blended_texel(technique, map.layers(texel), ranks, rounding));
        }
    };
    data.par_chunks_mut(width * channels).enumerate().for_each(row);
    ChannelMap::new(width, height, channels, data)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::translucency::taken;
    use random_stream::Random;
    use shadow_filtering::{DepthMap, TechniqueSpec};

    fn technique(bound: &str, format: &str) -> Technique {
        let mut spec = TechniqueSpec::named(bound).unwrap();
        spec.format = Some(format.parse().unwrap());
        spec.transform = (format == "unorm16").then(|| "plain".to_owned());
        spec.build().unwrap()
    }

    fn layers(random: &mut Random, count: usize) -> Vec<Layer> {
        let mut depths: Vec<f64> = (0..count).map(|_| random.unit()).collect();
        depths.sort_by(f64::total_cmp);
        depths.into_iter().map(|depth| Layer::new(depth, random.unit()).unwrap()).collect()
    }

    /// The claim of BHS16 section 4.2, for every technique that is linear in its basis.
    #[test]
    fn blending_gives_the_values_of_the_transmittance_distribution() {
        let mut random = Random::new(31);
        for bound in ["hamburger4", "hamburger6", "trigonometric4", "hausdorff4"] {
            let technique = technique(bound, "f32");
            for count in 0..20 {
                let layers = layers(&mut random, count);
                let found = blended_texel(&technique, &layers, None, Rounding::Never);
                let mut atoms = taken(&layers);
                let rest = 1.0 - atoms.iter().map(|(_, share)| share).sum::<f64>();
                atoms.push((1.0, rest));
                let mut expected = vec![0.0; found.len()];
                let mut b = vec![0.0; found.len()];
                for (depth, share) in atoms {
                    technique.evaluate(depth, &mut b);
                    expected.iter_mut().zip(&b).for_each(|(sum, value)| *sum += share * value);
                }
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((found - expected).abs() < 1e-12, "{bound}, {count}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn opaque_layers_are_stored_as_a_shadow_map_is() {
        let depths = [0.25f32, 0.7, 1.0, 0.125];
        let map = DepthMap::new(2, 2, depths.to_vec()).unwrap();
        let lists = [(0.25, 1.0), (0.5, 0.5), (0.7, 1.0), (0.125, 1.0), (0.2, 0.9)];
        // The clear pane of the second texel is left out by a stack.
        let layered = LayeredMap::new(
            [2, 2],
            vec![0, 2, 3, 3, 5],
            lists.iter().map(|&(depth, opacity)| (f64::from(depth as f32), opacity)),
        )
        .unwrap();
        let technique = technique("hamburger4", "unorm16");
        let found = blended_map(&layered, &technique, None, Rounding::EachLayer).unwrap();
        assert_eq!(found.data(), technique.store::<f64>(&map).unwrap().data());
    }

    #[test]
    fn order_and_rounding_make_a_difference() {
        let technique = technique("hamburger4", "unorm16");
        let layers: Vec<Layer> = (1..9).map(|i| Layer::new(f64::from(i) / 10.0, 0.3).unwrap()).collect();
        let exact = blended_texel(&technique, &layers, None, Rounding::Never);
        let far = |other: &[f64]| -> f64 {
            exact.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let depths: Vec<f32> = layers.iter().map(|layer| layer.depth() as f32).collect();
        let sorted = blended_texel(&technique, &layers, Some(&depths), Rounding::Never);
        assert_eq!(far(&sorted), 0.0);
        let backwards: Vec<f32> = depths.iter().map(|depth| -depth).collect();
        assert!(far(&blended_texel(&technique, &layers, Some(&backwards), Rounding::Never)) > 0.05);
        let once = far(&blended_texel(&technique, &layers, None, Rounding::Once));
        let each = far(&blended_texel(&technique, &layers, None, Rounding::EachLayer));
        // Half a step once, and at most half a step over the opacity for each layer.
        let step = 1.0 / 65535.0;
        assert!(once <= 0.5 * step && each <= 0.5 * step / 0.3 && each > 0.0, "{once} {each}");
    }
}
