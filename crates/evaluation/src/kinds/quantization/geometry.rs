//! The curve of three power moments and its hull, before and after the transform (MSM15 Figure 5), and histograms of
//! stored codes.

use super::records::{CodeRecord, HullRecord};
use super::stored_technique::StoredTechnique;
use crate::error::EvaluationError;
use crate::statistics::rounded;
use quantization::published::Published;

/// The transform of three moments in the constants.
const THIRD_ORDER: &str = "ours, order 3";

/// Both curves.
pub(crate) fn hull(points: usize) -> Result<Vec<HullRecord>, EvaluationError> {
    let fail = |reason: String| EvaluationError::Value(format!("hull: {reason}"));
    let published = Published::named(THIRD_ORDER).ok_or_else(|| fail(format!("no {THIRD_ORDER}")))?;
    let transform = published.transform().map_err(|error| fail(error.to_string()))?;
    let depth = |i: usize| i as f64 / (points - 1) as f64;
    let powers = |z: f64| [z, z * z, z * z * z];
    let original: Vec<[f64; 3]> = (0..points).map(|i| powers(depth(i))).collect();
    let stored = |i: usize| {
        let mut point = [0.0; 3];
        transform.apply(&powers(published.interval().at(2.0 * depth(i) - 1.0)), &mut point);
        point
    };
    let transformed: Vec<[f64; 3]> = (0..points).map(stored).collect();
    let mut records = Vec::new();
    for (curve, points) in [("original", original), ("transformed", transformed)] {
        let hull_volume = rounded(volume(&points));
        records.extend(points.iter().enumerate().map(|(i, p)| HullRecord {
            curve: curve.to_owned(),
            depth: rounded(depth(i)),
            x: rounded(p[0]),
            y: rounded(p[1]),
            z: rounded(p[2]),
            hull_volume,
        }));
    }
    Ok(records)
}

/// Volume of the convex hull of points in order along an affine image of the curve (z, z^2, z^3): its faces are fans
/// from both ends, so that it consists of the tetrahedra of the ends with one edge each (Gale's evenness condition).
fn volume(points: &[[f64; 3]]) -> f64 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return 0.0 };
    let minus = |a: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|k| a[k] - first[k]) };
    let axis = minus(last);
    let mut sum = 0.0;
    for edge in points.windows(2) {
        let (a, b) = (minus(&edge[0]), minus(&edge[1]));
        let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        sum += cross.iter().zip(axis).map(|(c, d)| c * d).sum::<f64>().abs() / 6.0;
    }
    sum
}

/// Histograms of the channels of filtered texels; values in \[0, 1\].
pub(crate) fn codes(variant: &StoredTechnique, texels: &[f64], bins: usize) -> Vec<CodeRecord> {
    let channels = variant.bound().order();
    let mut records = Vec::new();
    for channel in 0..channels {
        let mut counts = vec![0usize; bins];
        for value in texels.iter().skip(channel).step_by(channels) {
            counts[((value * bins as f64) as usize).min(bins - 1)] += 1;
        }
        let total = (texels.len() / channels).max(1) as f64;
        let shares: Vec<f64> = counts.iter().map(|&count| count as f64 / total).collect();
        let entropy = shares.iter().filter(|share| **share > 0.0).map(|p| -p * p.log2()).sum::<f64>();
        records.extend(shares.iter().enumerate().map(|(bin, &share)| CodeRecord {
            bound: variant.bound_name().to_owned(),
            transform: variant.transform.clone(),
            format: variant.format.clone(),
            channel,
            from: rounded(bin as f64 / bins as f64),
            share: rounded(share),
            entropy_bits: rounded(entropy),
        }));
    }
    records
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_are_those_of_the_paper() {
        let records = hull(4001).unwrap();
        let volume = |curve: &str| records.iter().find(|r| r.curve == curve).unwrap().hull_volume;
        // Karlin and Shapley: the moment space of z, z^2, z^3 on [0, 1] has volume 1/180.
        assert!((volume("original") - 1.0 / 180.0).abs() < 1e-8, "{}", volume("original"));
        let ratio = volume("transformed") / volume("original");
        assert!((ratio - 73.9).abs() < 0.05 && (volume("transformed") - 0.41).abs() < 5e-3, "{ratio}");
        for record in records.iter().filter(|r| r.curve == "transformed") {
            for value in [record.x, record.y, record.z] {
                assert!((-1e-9..=1.0 + 1e-9).contains(&value), "{record:?}");
            }
        }
    }
}
