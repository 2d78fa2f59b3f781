//! Exact cases of all methods.

use super::*;
use crate::field::{MomentField, StoredSums, Table};
use crate::rays::Triangles;
use crate::{PlacedLight, errors, truths};
use moment_problem::MomentBound;
use scenes::Outline;
use shadow_filtering::DepthMap;

const SIZE: usize = 96;
const BLOCKER: f64 = 0.25;
const RECEIVER: f64 = 0.75;

/// The column at which the occluder ends.
const EDGE: usize = 48;

/// Moments lie 1e-7 beside the right ones in the table, so that a surface is some 1e-3 thick.
const BIAS: f64 = 0.02;

fn lamp(half: f64) -> Penumbra<f64> {
    Penumbra { half_size: [half, 0.6 * half], near: Some(1.0), depth_range: 4.0, texels_per_unit: [20.0; 2] }
}

/// An occluder over the left part of a plane.
fn step() -> DepthMap {
    let depth = |texel: usize| if texel % SIZE < EDGE { BLOCKER } else { RECEIVER };
    DepthMap::new(SIZE, SIZE, (0..SIZE * SIZE).map(|t| depth(t) as f32).collect()).unwrap()
}

/// What the light as seen through the occluder's plane loses at a map position.
fn covered(x: f64, light: &Penumbra<f64>) -> f64 {
    let width = light.filter(RECEIVER, BLOCKER)[0];
    ((EDGE as f64 - (x - 0.5 * width)) / width).clamp(0.0, 1.0)
}

fn techniques() -> Vec<Reconstruction<f64>> {
    let warps = [Warp::None, Warp::Exponential(3.0)];
    let bounds =
        [MomentBound::Hamburger2, MomentBound::Hamburger4, MomentBound::Hausdorff4, MomentBound::Hamburger6];
    let all = bounds.into_iter().flat_map(|bound| warps.map(|warp| (bound, warp)));
    all.map(|(bound, warp)| Reconstruction::new(bound, warp, bound.single_precision_bias()).unwrap())
        .collect()
}

fn summed(map: &DepthMap, technique: &Reconstruction<f64>, texels: u32) -> StoredSums {
    SoftMethod::field(Table::Uint32, map, technique, texels).unwrap()
}

fn fragment(x: f64, depth: f64) -> Fragment<f64> {
    Fragment { position: [x, 40.3], depth, bias: BIAS, noise: [0.5; 2] }
}

/// What the methods with moments make of a fragment.
fn soft(
    field: &StoredSums,
    technique: &Reconstruction<f64>,
    light: &Penumbra<f64>,
    epsilon: f64,
    at: &Fragment<f64>,
) -> f64 {
    let search = BlockerSearch { epsilon, bias_share: 0.0, ..BlockerSearch::published() };
    filterable_soft_shadow(field, technique, light, &search, &Filter::published(), at).unwrap()
}

/// Every texel asked.
fn exact(map: &DepthMap, light: &Penumbra<f64>, at: &Fragment<f64>) -> f64 {
    let search = BlockerSearch::percentage_closer();
    percentage_closer_soft_shadow(map, light, &search, &Filter::published(), at)
}

/// The largest error over a penumbra and its surroundings.
fn worst(light: &Penumbra<f64>, shade: impl Fn(&Fragment<f64>) -> f64) -> f64 {
    let errors = (0..400).map(|i| {
        let x = 30.0 + 0.1 * f64::from(i) - 0.003;
        (shade(&fragment(x, RECEIVER)) - covered(x, light)).abs()
    });
    errors.fold(0.0, f64::max)
}

/// One parallel occluder: PCSS is the covered part of the light, exactly, and two surfaces are what four moments know.
/// Two moments know them on the receiver only, not where the bias takes it.
#[test]
fn one_parallel_occluder_is_exact() {
    let (map, light) = (step(), lamp(1.0));
    let width = light.filter(RECEIVER, BLOCKER)[0];
    assert!((9.0..11.0).contains(&width), "{width}");
    let error = worst(&light, |at| exact(&map, &light, at));
    assert!(error < 1e-7, "{error}");
    for technique in techniques() {
        let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
        let error = worst(&light, |at| soft(&field, &technique, &light, 1e-6, at));
        let allowed = if technique.bound() == MomentBound::Hamburger2 { 0.15 } else { 3e-3 };
        assert!(error < allowed, "{technique:?}: {error}");
    }
}

/// Faults that the test above must see: a region moved by half a texel, and an epsilon that is too large.
#[test]
fn planted_faults_are_seen() {
    let (map, light) = (step(), lamp(1.0));
    let technique = techniques()[2];
    let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
    let moved = worst(&light, |at| {
        let position = [at.position[0] + 0.5, at.position[1]];
        soft(&field, &technique, &light, 1e-6, &Fragment { position, ..*at })
    });
    let hardened = worst(&light, |at| soft(&field, &technique, &light, 0.1, at));
    assert!(moved > 0.04 && hardened > 0.04, "{moved} {hardened}");
}

/// Without epsilon the average of next to nothing decides: far from the occluder the filter is as good as random.
#[test]
fn epsilon_keeps_lit_fragments_sharp() {
    let (map, light) = (step(), lamp(1.0));
    let technique = Reconstruction::new(MomentBound::Hamburger4, Warp::None, 5e-6).unwrap();
    let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
    let widest = |epsilon: f64| {
        let widths = (0..100).map(|i| {
            let at = fragment(70.0 + 0.05 * f64::from(i), RECEIVER);
            let region = Region::around(at.position, light.search(RECEIVER));
            let blockers = technique.blockers(&field.means(&region, Fit::Outwards).unwrap(), RECEIVER - BIAS);
            light.filter(RECEIVER, blockers.average(RECEIVER, epsilon))[0]
        });
        widths.fold(0.0, f64::max)
    };
    assert!(widest(0.01) < 0.5 && widest(0.0) > 5.0, "{} {}", widest(0.01), widest(0.0));
}

/// The whole way: a map, shadow rays against the triangles that it shows, and every method against them.
#[test]
fn methods_are_estimates_of_the_truth() {
    let (map, penumbra) = (step(), lamp(1.0));
    // The light's middle is at the origin and shines along z; map texel x is 20 units of x / z, shifted by 48.
    let wall = |left: f32, right: f32, depth: f64| {
        let (z, far) = ((1.0 + 4.0 * depth) as f32, 40.0);
        [[left * z, -far, z], [right * z, -far, z], [left * z, far, z], [right * z, far, z]]
    };
    let edge = ((EDGE as f64 - 48.0) / 20.0) as f32;
    let positions = [wall(-9.0, edge, BLOCKER), wall(-9.0, 9.0, RECEIVER)].concat();
    let scene = Triangles::new(&positions, &[[0, 1, 2], [2, 1, 3], [4, 5, 6], [6, 5, 7]]).unwrap();
    let settings = TruthSettings { standard_error: 2e-3, most_rays: 1 << 14, seed: 1 };
    let truth = AreaTruth::new(settings).unwrap();
    let light = PlacedLight {
        outline: Outline::Rectangle,
        middle: [0.0; 3],
        half_axes: [[1.0, 0.0, 0.0], [0.0, 0.6, 0.0]],
        at_infinity: false,
    };
    let view = SoftShadow { scene: &scene, light, truth: &truth, map: &map, penumbra };
    let receivers: Vec<SoftReceiver> = (0..60)
        .map(|i| {
            let at = fragment(36.0 + 0.4 * f64::from(i), RECEIVER);
            let z = 1.0 + 4.0 * RECEIVER;
            let point = [0, 1].map(|k| (at.position[k] - 48.0) / 20.0 * z);
            let surface = scene.surface_near([point[0], point[1], z], [0.0, 0.0, 1.0], 0.01).unwrap();
            SoftReceiver { surface, fragment: at, stream: i as u64 }
        })
        .collect();
    for (receiver, truth) in receivers.iter().zip(truths(&view, &receivers)) {
        let expected = covered(receiver.fragment.position[0], &penumbra);
        assert!((truth - expected).abs() < 6.0 * settings.standard_error, "{receiver:?} {truth} {expected}");
    }
    let technique = techniques()[2];
    let field = summed(&map, &technique, penumbra.largest_region([SIZE; 2]));
    let filter = Filter::published();
    let search = BlockerSearch { epsilon: 1e-6, bias_share: 0.0, ..BlockerSearch::published() };
    let compared = BlockerSearch::percentage_closer();
    for (method, allowed) in [
        (SoftMethod::PercentageCloser(compared, filter), 0.015),
        (SoftMethod::Filterable(field.clone(), technique, search, filter), 0.015),
        (SoftMethod::FilteredHard(field, technique, [4.0; 2], filter), 0.35),
    ] {
        let worst = errors(&view, &method, &receivers).unwrap().into_iter().map(f64::abs).fold(0.0, f64::max);
        assert!(worst < allowed, "{worst} where {allowed} is allowed");
    }
}

/// A light without size: every method is the hard shadow of the same map.
#[test]
fn point_lights_cast_hard_shadows() {
    let map = step();
    for light in [lamp(0.0), Penumbra { near: None, ..lamp(0.0) }] {
        for technique in techniques() {
            let field = summed(&map, &technique, 1);
            for x in [3.2, 47.0, 47.999, 48.0, 48.4, 95.5] {
                let at = fragment(x, 0.5);
                let hard = if x < EDGE as f64 { 1.0 } else { 0.0 };
                let filtered =
                    filtered_hard_shadow(&field, &technique, [0.0; 2], &Filter::published(), &at).unwrap();
                for found in [soft(&field, &technique, &light, 0.01, &at), filtered] {
                    // A moment bias alpha leaves alpha / distance^2 of the light.
                    assert!((found - hard).abs() < 1e-3, "{technique:?} {x} {found}");
                }
                assert_eq!(exact(&map, &light, &at), hard);
            }
        }
    }
}

/// One depth everywhere, also that of the fragment: nothing is in front.
#[test]
fn constant_depth_is_lit() {
    let light = lamp(1.0);
    for depth in [0.0, 0.3, 1.0] {
        let map = DepthMap::new(SIZE, SIZE, vec![depth as f32; SIZE * SIZE]).unwrap();
        let at = fragment(31.3, f64::from(depth as f32));
        assert_eq!(exact(&map, &light, &at), 0.0);
        for technique in techniques() {
            let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
            let found = soft(&field, &technique, &light, 0.01, &at);
            assert!((0.0..0.02).contains(&found), "{technique:?} {depth} {found}");
        }
    }
}

/// Single precision is close to double precision where two surfaces are far apart.
#[test]
fn single_precision_follows() {
    let (map, light) = (step(), lamp(1.0));
    let small = light.cast::<f32>();
    for technique in techniques().into_iter().filter(|t| t.bound() != MomentBound::Hamburger6) {
        let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
        let single = technique.cast::<f32>();
        for i in 0..100 {
            let at = fragment(38.0 + 0.2 * f64::from(i), 0.7);
            let expected = soft(&field, &technique, &light, 0.01, &at);
            let at = at.cast::<f32>();
            let search = BlockerSearch { bias_share: 0.0, ..BlockerSearch::published() };
            let filter = Filter::published();
            let found = filterable_soft_shadow(&field, &single, &small, &search, &filter, &at).unwrap();
            let error = (f64::from(found) - expected).abs();
            assert!(error < 0.02, "{technique:?} {at:?}: {found} against {expected}");
        }
    }
}

/// Small filters take less of the bias, none less than a tenth.
#[test]
fn biases_grow_with_the_filter() {
    let filter = Filter { full_bias_width: 10.0, least_width: 0.5, ..Filter::published() };
    let compared = |width: f64| filter.applied(&fragment(8.0, 0.5), [width; 2]).1;
    assert_eq!(compared(10.0), 0.5 - BIAS);
    assert_eq!(compared(40.0), 0.5 - BIAS);
    assert!((compared(5.0) - (0.5 - 0.5 * BIAS)).abs() < 1e-15);
    assert!((compared(0.0) - (0.5 - 0.1 * BIAS)).abs() < 1e-15);
    assert_eq!(filter.applied(&fragment(8.0, 0.5), [0.0; 2]).0.high[0], 8.25);
}

/// Corners rounded by every noise alike are interpolated on average; no region is lost.
#[test]
fn dithered_corners_are_interpolated_on_average() {
    let (map, light) = (step(), lamp(0.6));
    let technique = techniques()[2];
    let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
    let filter = Filter { dithered: true, fit: Fit::Nearest, ..Filter::published() };
    for x in [46.3, 48.0, 49.1] {
        let at = fragment(x, RECEIVER);
        let widths = [5.3, 4.2];
        let of = |filter: &Filter<f64>, at: &Fragment<f64>| {
            filtered_hard_shadow(&field, &technique, widths, filter, at).unwrap()
        };
        let count = 40;
        let noises =
            (0..count * count).map(|i| [i % count, i / count].map(|k| (k as f64 + 0.5) / count as f64));
        let mean =
            noises.map(|noise| of(&filter, &Fragment { noise, ..at })).sum::<f64>() / (count * count) as f64;
        let expected = of(&Filter::published(), &at);
        assert!((mean - expected).abs() < 0.02, "{x}: {mean} {expected}");
    }
}

/// Every method under every option sees a light without size as a hard shadow, and nothing in front of one depth.
#[test]
fn options_keep_the_exact_cases() {
    let map = step();
    let flat = DepthMap::new(SIZE, SIZE, vec![0.5; SIZE * SIZE]).unwrap();
    let four = Reconstruction::new(MomentBound::Hamburger4, Warp::None, 5e-6).unwrap();
    for storage in [Storage::Unit, Storage::Signed, Storage::Sparse] {
        let technique = four.stored(storage).unwrap();
        for table in [Table::Uint32, Table::Float64] {
            for dithered in [false, true] {
                let filter = Filter { dithered, full_bias_width: 12.0, ..Filter::published() };
                let shade = |map: &DepthMap, light: &Penumbra<f64>, at: &Fragment<f64>| {
                    let texels = light.largest_region([SIZE; 2]);
                    let field = SoftMethod::field(table, map, &technique, texels).unwrap();
                    let search = BlockerSearch::published();
                    filterable_soft_shadow(&field, &technique, light, &search, &filter, at).unwrap()
                };
                for (x, hard) in [(20.2, 1.0), (47.4, 1.0), (48.6, 0.0), (90.0, 0.0)] {
                    let at = Fragment { noise: [0.0; 2], ..fragment(x, 0.5) };
                    let found = shade(&map, &lamp(0.0), &at);
                    assert!((found - hard).abs() < 2e-3, "{storage:?} {table:?} {dithered} {x}: {found}");
                }
                let lit = shade(&flat, &lamp(1.0), &fragment(31.3, 0.5));
                assert!((0.0..0.02).contains(&lit), "{storage:?} {table:?} {dithered}: {lit}");
            }
        }
    }
}
