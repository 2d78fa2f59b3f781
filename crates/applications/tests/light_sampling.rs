//! Sampling the light over frames converges to the share of it that shadow rays find.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use applications::PlacedLight;
use applications::rays::{Segment, Triangles};
use applications::samples::{HALTON_START, halton};
use applications::soft_shadow::{AreaTruth, TruthSettings};
use applications::temporal::ShadowEstimate;
use random_stream::Random;
use scenes::load_scene;
use scenes::vector::{cross, dot, minus};

const RECEIVERS: usize = 150;
const FRAMES: usize = 4096;

/// Errors of a frame count over all receivers: root mean squares of the true and of the believed one, and the share of
/// receivers that lie within the latter.
fn summary(pairs: &[(f64, f64)]) -> (f64, f64, f64) {
    let count = pairs.len() as f64;
    let square =
        |of: &dyn Fn(&(f64, f64)) -> f64| (pairs.iter().map(|p| of(p).powi(2)).sum::<f64>() / count).sqrt();
    let within = pairs.iter().filter(|(error, believed)| error.abs() <= *believed).count() as f64 / count;
    (square(&|p| p.0), square(&|p| p.1), within)
}

#[test]
fn sampling_alone_converges_within_its_own_standard_error() {
    for (number, name) in ["stairs", "grove"].into_iter().enumerate() {
        let scene = load_scene(name).unwrap();
        let triangles = Triangles::of_scene(&scene).unwrap();
        let view = scene.views.iter().find(|view| view.name == "lamp").unwrap();
        let light = PlacedLight::new(&view.light, [[0.0; 3]; 3]);
        let truth =
            AreaTruth::new(TruthSettings { standard_error: 1e-3, most_rays: 1 << 15, seed: 3 }).unwrap();
        let mut random = Random::stream(7, number as u64);
        let (mut early, mut late) = (Vec::new(), Vec::new());
        while early.len() < RECEIVERS {
            let index = random.below(scene.triangles.len());
            let corners = scene.triangles[index].map(|v| scene.vertices[v as usize].position.map(f64::from));
            let origin = [0, 1, 2].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
            let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
            if dot(normal, minus(light.middle, origin)) <= 0.0 {
                continue;
            }
            let from = Some(index as u32);
            let known = truth.occluded_fraction(&triangles, &light, origin, from, early.len() as u64);
            // Those in penumbrae alone say how errors fall.
            if !(0.05..=0.95).contains(&known.fraction) {
                continue;
            }
            let mut estimate = ShadowEstimate::<f64>::none();
            for frame in 0..FRAMES {
                let direction = light.towards(origin, halton(HALTON_START + frame as u64));
                let hidden = triangles.occludes(&Segment { origin, direction, endless: false, from });
                estimate = estimate.with(hidden);
                if frame + 1 == 256 || frame + 1 == FRAMES {
                    // The truth's own error counts, too.
                    let believed = estimate.cautious_error().hypot(known.standard_error);
                    let pair = (estimate.fraction() - known.fraction, believed);
                    if frame + 1 == 256 { early.push(pair) } else { late.push(pair) }
                }
            }
        }
        let ((error, believed, within), (least, least_believed, still_within)) =
            (summary(&early), summary(&late));
        assert!(error <= believed && within >= 0.68, "{name}, 256 frames: {error} {believed} {within}");
        assert!(
            least <= least_believed && still_within >= 0.68,
            "{name}: {least} {least_believed} {still_within}"
        );
        // Independent points would give a quarter; Halton's are more even.
        assert!(least < 0.5 * error, "{name}: {error} {least}");
    }
}
