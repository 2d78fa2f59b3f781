//! What methods cost a frame, modelled as for hard shadows: memory traffic and arithmetic, no time.
//!
//! Prefix sums read the shadow map, and write what is looked up once for each texel; each pixel looks up one texel and reads
//! the bound, whatever the scene. Ray marching reads a depth for each sample of each pixel.

use super::method::ScatteringMethod;
use super::records::ScatteringCost;
use super::run::Plan;
use crate::kinds::speed_accuracy::{FETCH, FrameCost};
use crate::statistics::rounded_to;
use applications::scattering::Spacing;
use shadow_filtering::{SPECIAL, Technique};

/// Bytes of a depth of the shadow map.
const DEPTH_BYTES: f64 = 2.0;

/// Operations that place a texel of the rectified map on the shadow map: sine, cosine and two products and sums, then the
/// angle of a depth: a root, a division, an arc tangent, and its normalisation.
const PLACED: f64 = 2.0 * SPECIAL as f64 + 8.0;
const ANGLE: f64 = 3.0 * SPECIAL as f64 + 4.0;

/// Two mip levels of four channels, mixed; two depths of moments.
const TRILINEAR: f64 = 2.0 * FETCH + 8.0;
const TWO_DEPTHS: f64 = 3.0 * SPECIAL as f64 + 20.0;

/// The weight of a step.
const WEIGHT: f64 = SPECIAL as f64 + 2.0;

/// Of a sample: its place, the comparison, its weight and the sum.
const SAMPLE: f64 = FETCH + 13.0;

/// Depths of the row at which bounds are read for their number of operations.
const NODES: usize = 16;

/// Operations and bytes a texel and a pixel.
struct Parts {
    texel: FrameCost,
    pixel: FrameCost,
}

fn parts(method: &ScatteringMethod, technique: Option<&Technique>, source: &Technique) -> Option<Parts> {
    if let Some(steps) = method.steps {
        let samples = steps as f64;
        let pixel = FrameCost { bytes: samples * DEPTH_BYTES, operations: samples * SAMPLE };
        return Some(Parts { texel: FrameCost { bytes: 0.0, operations: 0.0 }, pixel });
    }
    let technique = technique?;
    let layers = if method.spacing == Spacing::Two { 2.0 } else { 1.0 };
    let channels = technique.channels() as f64;
    let bytes = layers * technique.bits_per_texel() as f64 / 8.0;
    let depths = if method.filtered { 2.0 } else { 1.0 };
    // Sums, their norm, and the transform, which takes as many products as its inverse.
    let summed = channels * (2.0 + SPECIAL as f64) + WEIGHT + technique.decode_operations() as f64;
    let read = if method.filtered { 2.0 * source.bits_per_texel() as f64 / 8.0 } else { DEPTH_BYTES };
    let sampled = if method.filtered { TRILINEAR + TWO_DEPTHS } else { FETCH };
    let texel = FrameCost {
        bytes: read + bytes,
        operations: PLACED + sampled + depths * (ANGLE + 2.0 * channels) + layers * summed,
    };
    let fetches = layers * (channels / 4.0).ceil();
    let pixel = FrameCost {
        bytes,
        operations: PLACED
            + ANGLE
            + fetches * FETCH
            + layers * (technique.decode_operations() as f64 + bound(technique)),
    };
    Some(Parts { texel, pixel })
}

/// Operations of reading a bound from the moments of many depths.
fn bound(technique: &Technique) -> f64 {
    let mut mean = vec![0.0f32; technique.channels()];
    let mut b = vec![0.0f32; technique.channels()];
    for node in 0..NODES {
        technique.evaluate((node as f32 + 0.5) / NODES as f32, &mut b);
        mean.iter_mut().zip(&b).for_each(|(sum, value)| *sum += value / NODES as f32);
    }
    technique.real_time().map_or(0.0, |bound| bound.operations(&mean, 0.4) as f64)
}

/// A row a technique that can be computed in a frame.
pub(super) fn records(plan: &Plan<'_>) -> Vec<ScatteringCost> {
    let [width, height, side] = plan.experiment.frame.map(f64::from);
    let (texels, pixels) = (side * side, width * height);
    let row = |(technique, stored): (&super::ScatteringTechnique, &Option<Technique>)| {
        let Parts { texel, pixel } = parts(&technique.method, stored.as_ref(), &plan.source)?;
        let frame = FrameCost {
            bytes: texels * texel.bytes + pixels * pixel.bytes,
            operations: texels * texel.operations + pixels * pixel.operations,
        };
        let digits = |value: f64| rounded_to(value, 1e3);
        let bound = technique.method.stored.as_ref().and_then(|spec| spec.moment_bound());
        Some(ScatteringCost {
            technique: technique.name.clone(),
            moments: bound.map_or(0, |bound| bound.order()),
            steps: technique.method.steps.unwrap_or_default(),
            bytes_per_texel: digits(texel.bytes),
            bytes_per_pixel: digits(pixel.bytes),
            operations_per_texel: digits(texel.operations),
            operations_per_pixel: digits(pixel.operations),
            megabytes: digits(frame.bytes / 1e6),
            megaoperations: digits(frame.operations / 1e6),
            total: digits(frame.total() / 1e6),
        })
    };
    plan.experiment.technique.iter().zip(&plan.techniques).filter_map(row).collect()
}
