//! Exact cases of all methods.

use super::*;
use crate::field::SummedMoments;
use moment_problem::MomentBound;
use shadow_filtering::DepthMap;

const SIZE: usize = 96;
const BLOCKER: f64 = 0.25;
const RECEIVER: f64 = 0.75;

/// A light of which half a texel is a thousandth.
fn lamp(half: f64) -> Penumbra<f64> {
    Penumbra { half_size: [half, 0.6 * half], near: Some(1.0), depth_range: 4.0, texels_per_unit: [20.0; 2] }
}

/// An occluder over the left part of a plane, in fractions of a texel by the share of that column.
fn step(edge: usize, blocker: f64, receiver: f64) -> DepthMap {
    let depth = |texel: usize| if texel % SIZE < edge { blocker } else { receiver };
    DepthMap::new(SIZE, SIZE, (0..SIZE * SIZE).map(|t| depth(t) as f32).collect()).unwrap()
}

fn techniques() -> Vec<Reconstruction<f64>> {
    let warps = [Warp::None, Warp::Exponential(3.0)];
    let bounds =
        [MomentBound::Hamburger2, MomentBound::Hamburger4, MomentBound::Hamburger6, MomentBound::Hausdorff4];
    let all = bounds.into_iter().flat_map(|bound| warps.map(|warp| (bound, warp)));
    all.map(|(bound, warp)| Reconstruction::new(bound, warp, 0.0).unwrap()).collect()
}

fn summed(map: &DepthMap, technique: &Reconstruction<f64>, texels: u32) -> SummedMoments {
    let encode = |depth: f64, out: &mut [f64]| technique.encode(depth, out);
    SummedMoments::new([SIZE; 2], map.depths(), technique.channels(), texels, encode).unwrap()
}

fn fragment(x: f64, y: f64, depth: f64) -> Fragment<f64> {
    Fragment { position: [x, y], depth, compared: depth }
}

/// One parallel occluder: PCSS is the covered part of the kernel, exactly.
#[test]
fn one_parallel_occluder_is_exact() {
    let (edge, light) = (48, lamp(0.7));
    let map = step(edge, BLOCKER, RECEIVER);
    let width = light.filter(RECEIVER, BLOCKER)[0];
    assert!((7.0..20.0).contains(&width), "{width}");
    let search = BlockerSearch::percentage_closer();
    let mut partial = 0;
    for i in 0..400 {
        let x = 30.0 + 0.1 * f64::from(i) - 0.003;
        let exact = ((edge as f64 - (x - 0.5 * width)) / width).clamp(0.0, 1.0);
        let at = fragment(x, 40.3, RECEIVER - 1e-9);
        let found = percentage_closer_soft_shadow(&map, &light, &search, Fit::Covered, &at);
        assert!((found - exact).abs() < 1e-7, "{x}: {found} against {exact}");
        partial += usize::from(exact > 0.0 && exact < 1.0);
        for technique in techniques() {
            let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
            let published = BlockerSearch { epsilon: 1e-9, umbra: 1.0, ..BlockerSearch::published() };
            let found = filterable_soft_shadow(&field, &technique, &light, &published, Fit::Covered, &at).unwrap();
            // The table's 22 bits, asked for the distance of two surfaces.
            assert!((found - exact).abs() < 2e-3, "{technique:?} {x}: {found} against {exact}");
        }
    }
    assert!(partial > 60, "{partial}");
}

/// Faults that the test above must see: a region moved by half a texel, and an epsilon that is too large.
#[test]
fn planted_faults_are_seen() {
    let (edge, light) = (48, lamp(0.7));
    let map = step(edge, BLOCKER, RECEIVER);
    let width = light.filter(RECEIVER, BLOCKER)[0];
    let technique = techniques()[2];
    let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
    let worst = |moved: f64, epsilon: f64| {
        let search = BlockerSearch { epsilon, umbra: 1.0, ..BlockerSearch::published() };
        let errors = (0..200).map(|i| {
            let x = 40.0 + 0.1 * f64::from(i);
            let exact = ((edge as f64 - (x - 0.5 * width)) / width).clamp(0.0, 1.0);
            let at = fragment(x + moved, 40.3, RECEIVER - 1e-9);
            let found = filterable_soft_shadow(&field, &technique, &light, &search, Fit::Covered, &at);
            (found.unwrap() - exact).abs()
        });
        errors.fold(0.0, f64::max)
    };
    assert!(worst(0.0, 1e-9) < 2e-3);
    assert!(worst(0.5, 1e-9) > 0.02 && worst(0.0, 0.1) > 0.02);
}

/// A light without size: every method is the hard shadow of the same map.
#[test]
fn point_lights_cast_hard_shadows() {
    let map = step(40, BLOCKER, RECEIVER);
    for light in [lamp(0.0), Penumbra { near: None, ..lamp(0.0) }] {
        for technique in techniques() {
            let field = summed(&map, &technique, 1);
            for x in [3.2, 39.0, 39.999, 40.0, 40.4, 95.5] {
                let at = fragment(x, 20.7, 0.5);
                let hard = if x < 40.0 { 1.0 } else { 0.0 };
                let soft = filterable_soft_shadow(
                    &field,
                    &technique,
                    &light,
                    &BlockerSearch::published(),
                    Fit::Covered,
                    &at,
                );
                let filtered = filtered_hard_shadow(&field, &technique, [0.0; 2], Fit::Covered, &at);
                let exact = percentage_closer_soft_shadow(
                    &map,
                    &light,
                    &BlockerSearch::percentage_closer(),
                    Fit::Covered,
                    &at,
                );
                assert_eq!((soft, filtered, exact), (Ok(hard), Ok(hard), hard), "{technique:?} {x}");
            }
        }
    }
}

/// One depth everywhere, also that of the fragment: nothing is in front.
#[test]
fn constant_depth_is_lit() {
    let light = lamp(0.7);
    for depth in [0.0, 0.3, 1.0] {
        let map = DepthMap::new(SIZE, SIZE, vec![depth as f32; SIZE * SIZE]).unwrap();
        let depth = f64::from(depth as f32);
        // A bias of what the table rounds.
        let at = Fragment { compared: depth - 1e-4, ..fragment(31.3, 50.1, depth) };
        let search = BlockerSearch::percentage_closer();
        assert_eq!(percentage_closer_soft_shadow(&map, &light, &search, Fit::Covered, &at), 0.0);
        for technique in techniques() {
            let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
            for fit in [Fit::Covered, Fit::Outwards, Fit::Nearest] {
                let search = BlockerSearch { bias: 1e-4, ..BlockerSearch::published() };
                let found = filterable_soft_shadow(&field, &technique, &light, &search, fit, &at);
                assert_eq!(found, Ok(0.0), "{technique:?} {depth}");
            }
        }
    }
}

/// Single precision is close to double precision where two surfaces are far apart.
#[test]
fn single_precision_follows() {
    let map = step(48, BLOCKER, RECEIVER);
    let light = lamp(0.7);
    let small = Penumbra {
        half_size: light.half_size.map(|v| v as f32),
        near: Some(1.0f32),
        depth_range: 4.0,
        texels_per_unit: [20.0; 2],
    };
    for technique in techniques().into_iter().filter(|t| t.bound() != MomentBound::Hamburger6) {
        let field = summed(&map, &technique, light.largest_region([SIZE; 2]));
        let double = Reconstruction::new(technique.bound(), technique.warp(), 5e-6).unwrap();
        let single = double.cast::<f32>();
        for i in 0..100 {
            let at = fragment(38.0 + 0.2 * f64::from(i), 40.3, 0.7);
            let expected = filterable_soft_shadow(
                &field,
                &double,
                &light,
                &BlockerSearch::published(),
                Fit::Covered,
                &at,
            );
            let at = Fragment { position: at.position.map(|c| c as f32), depth: 0.7f32, compared: 0.7 };
            let found =
                filterable_soft_shadow(&field, &single, &small, &BlockerSearch::published(), Fit::Covered, &at);
            let (found, expected) = (f64::from(found.unwrap()), expected.unwrap());
            assert!((found - expected).abs() < 0.02, "{technique:?} {at:?}: {found} against {expected}");
        }
    }
}
