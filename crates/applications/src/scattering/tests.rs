//! Methods against the exact walk on slats whose borders are those of texels, so that the shadow map knows everything.

use moment_problem::MomentBound;
use random_stream::Random;
use shadow_filtering::{DepthMap, Kernel, Technique, TechniqueSpec};

use super::*;
use crate::rays::Triangles;
use crate::soft_shadow::{AreaTruth, TruthSettings};
use crate::{Application, Estimate};

/// Slats over a floor: x and z from and to, in eighths of a unit, and their height.
const SLATS: [([i32; 4], f32); 5] = [
    ([-20, -12, -24, 24], 1.5),
    ([-8, 0, -24, 24], 1.0),
    ([2, 9, -24, 8], 1.75),
    ([12, 20, -24, 24], 0.5),
    ([-30, 30, -30, 30], -3.0),
];

/// Texels along an edge of the map, each an eighth of a unit wide.
const SIDE: usize = 64;

/// What light travelling down hits first; the lowest point is depth 1.
fn map() -> DepthMap {
    let depth = |i: usize| {
        let at = [i % SIDE, i / SIDE].map(|texel| texel as i32 - SIDE as i32 / 2);
        let covers = |&&([x0, x1, z0, z1], _): &&([i32; 4], f32)| {
            (x0..x1).contains(&at[0]) && (z0..z1).contains(&at[1])
        };
        SLATS.iter().filter(covers).map(|slat| (2.0 - slat.1) / 8.0).fold(1.0, f32::min)
    };
    DepthMap::new(SIDE, SIDE, (0..SIDE * SIDE).map(depth).collect()).unwrap()
}

fn triangles() -> Triangles {
    let corners = |&([x0, x1, z0, z1], y): &([i32; 4], f32)| {
        [[x0, z0], [x1, z0], [x1, z1], [x0, z1]].map(|[x, z]| [x as f32 / 8.0, y, z as f32 / 8.0])
    };
    let positions: Vec<[f32; 3]> = SLATS.iter().flat_map(corners).collect();
    let quads =
        (0..SLATS.len() as u32).flat_map(|i| [[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]]);
    Triangles::new(&positions, &quads.collect::<Vec<_>>()).unwrap()
}

fn view(map: &DepthMap, extinction: f64) -> SingleScattering<'_> {
    SingleScattering {
        light: LightMap { map, corner: [-4.0; 2], texel: [0.125; 2], near: -2.0, range: 8.0 },
        axes: LightAxes { x: [1.0, 0.0, 0.0], y: [0.0, 0.0, 1.0], light: [0.0, -1.0, 0.0] },
        medium: Medium::new(extinction, 1.0, 0.0).unwrap(),
        camera: [-3.6, -1.2, 0.3],
    }
}

/// Looks along +x, from below the slats.
fn frustum(view: &SingleScattering<'_>) -> Frustum {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corner = |[y, z]: [f64; 2]| {
        let far = [7.0, 7.0 * 0.7 * y, 7.0 * 0.9 * z];
        [0, 1, 2].map(|k| view.camera[k] + far[k])
    };
    Frustum { apex: view.camera, corners: corners.map(corner) }
}

fn rays(count: usize) -> Vec<ViewRay> {
    let mut random = Random::new(3);
    (0..count)
        .map(|stream| {
            let across = [1.4 * random.unit() - 0.7, 1.8 * random.unit() - 0.9];
            let direction = scenes::vector::normalize([1.0, across[0], across[1]]);
            let length = if stream % 5 == 0 { f64::INFINITY } else { (1.0 + 6.0 * random.unit()) / 1.0 };
            ViewRay {
                direction,
                length: length.min(7.0 / direction[0]),
                noise: random.unit(),
                stream: stream as u64,
            }
        })
        .collect()
}

fn technique(bound: MomentBound) -> Technique {
    TechniqueSpec { alpha: Some(1e-7), ..TechniqueSpec::from(bound) }.build().unwrap()
}

fn mean_error(
    view: &SingleScattering<'_>,
    estimate: &impl for<'v> Estimate<SingleScattering<'v>>,
    rays: &[ViewRay],
) -> f64 {
    let errors = rays.iter().map(|ray| (estimate.estimate(view, ray).unwrap() - view.truth(ray)).abs());
    errors.sum::<f64>() / rays.len() as f64
}

#[test]
fn shadow_rays_find_what_the_map_knows() {
    let (map, triangles) = (map(), triangles());
    let nets = AreaTruth::new(TruthSettings { standard_error: 2e-3, most_rays: 1 << 14, seed: 2 }).unwrap();
    for extinction in [0.0, 0.4, 30.0] {
        let view = view(&map, extinction);
        for ray in rays(60) {
            let (exact, found) = (view.truth(&ray), view.traced(&triangles, &nets, &ray));
            assert!(
                (found.fraction - exact).abs() < 5.0 * found.standard_error + 1e-9,
                "{ray:?}: {exact} {found:?}"
            );
        }
    }
}

/// The reference of the task: samples on the view ray, each compared with the rectified texel that it falls into.
#[test]
fn exact_distributions_are_ray_marching_on_rectified_data() {
    let map = map();
    let view = view(&map, 0.4);
    let frustum = frustum(&view);
    let rectification = Rectification::new(&frustum, view.axes, [48, 32], 0.05).unwrap();
    let rectified = RectifiedMap::nearest(rectification, &view.light);
    let exact = ExactPrefixes::new(&rectified, Vec::new());
    let mut random = Random::new(8);
    for _ in 0..300 {
        let (row, last) = (random.below(32), random.below(48));
        let flipped = 1.0 + random.unit();
        let phi = rectification.azimuth(row);
        let light_space = [flipped.sin() * phi.cos(), flipped.sin() * phi.sin(), -flipped.cos()];
        let [x, y, z] = light_space;
        let direction = [x, -z, y];
        let step = rectification.column_width() / flipped.sin();
        let length = (last + 1) as f64 * step;
        let ray = ViewRay { direction, length, noise: 0.0, stream: 0 };
        let z_f = rectification.depth(flipped).clamp(0.0, 1.0);
        let (mut lit, mut all) = (0.0, 0.0);
        for i in 0..=last {
            let t = (i as f64 + 0.5) * step;
            let at = rectification.rectify([0, 1, 2].map(|k| view.camera[k] + t * direction[k]));
            let texel =
                rectified.row(rectification.row(at.phi))[(at.r / rectification.column_width()) as usize];
            let weight = view.medium.transmittance(t);
            all += weight;
            lit += if texel.depths[0] < z_f { 0.0 } else { weight };
        }
        let found = exact.estimate(&view, &ray).unwrap();
        assert!((found - lit / all).abs() < 1e-6, "{found} {}", lit / all);
    }
}

#[test]
fn finer_rectified_maps_and_more_steps_approach_the_exact_integral() {
    let map = map();
    let view = view(&map, 0.4);
    let (frustum, rays) = (frustum(&view), rays(200));
    let of_size = |size: usize| {
        let rectification = Rectification::new(&frustum, view.axes, [size; 2], 0.05).unwrap();
        let rectified = RectifiedMap::nearest(rectification, &view.light);
        mean_error(&view, &ExactPrefixes::new(&rectified, Vec::new()), &rays)
    };
    let errors = [64, 512].map(of_size);
    assert!(errors[1] < 0.3 * errors[0] && errors[1] < 0.004, "{errors:?}");
    let of_steps = |steps: usize| mean_error(&view, &Marched { steps, jitter: Jitter::Ray, seed: 1 }, &rays);
    let errors = [16, 64, 256, 1024].map(of_steps);
    // First order: four times the steps, a quarter of the error.
    assert!(errors.windows(2).all(|pair| (2.5..6.5).contains(&(pair[0] / pair[1]))), "{errors:?}");
}

#[test]
fn more_moments_err_less_and_single_precision_follows() {
    let map = map();
    let view = view(&map, 0.4);
    let (frustum, rays) = (frustum(&view), rays(200));
    let rectification = Rectification::new(&frustum, view.axes, [128; 2], 0.05).unwrap();
    let rectified = RectifiedMap::nearest(rectification, &view.light);
    let spacing = Spacing::Row.inverse_sines(&rectified, &frustum, &view, &rays);
    let errors =
        [MomentBound::Hamburger2, MomentBound::Hamburger4, MomentBound::Hamburger6, MomentBound::Hamburger8]
            .map(|bound| {
                let technique = technique(bound);
                let method =
                    StoredPrefixes { technique: &technique, blending: Blending::Fixed(0.5), margin: 0.0 };
                let double = Prefiltered::<f64>::new(method, &rectified, &view, &spacing).unwrap();
                let single = Prefiltered::<f32>::new(method, &rectified, &view, &spacing).unwrap();
                for ray in &rays {
                    let [a, b] =
                        [double.estimate(&view, ray), single.estimate(&view, ray)].map(Result::unwrap);
                    assert!((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b), "{a} {b}");
                }
                mean_error(&view, &double, &rays)
            });
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
}

#[test]
fn blends_are_ordered_and_the_adaptive_one_lies_between() {
    let map = map();
    let view = view(&map, 0.4);
    let (frustum, rays) = (frustum(&view), rays(100));
    let rectification = Rectification::new(&frustum, view.axes, [64; 2], 0.05).unwrap();
    let rectified = RectifiedMap::nearest(rectification, &view.light);
    let technique = technique(MomentBound::Hamburger4);
    let spacing = Spacing::Mean.inverse_sines(&rectified, &frustum, &view, &rays);
    let blends = [Blending::Fixed(0.0), Blending::Adaptive, Blending::Fixed(1.0)].map(|blending| {
        Prefiltered::<f64>::new(
            StoredPrefixes { technique: &technique, blending, margin: 0.0 },
            &rectified,
            &view,
            &spacing,
        )
        .unwrap()
    });
    for ray in &rays {
        let [bright, adaptive, dark] = [0, 1, 2].map(|i| blends[i].estimate(&view, ray).unwrap());
        assert!(bright >= adaptive && adaptive >= dark, "{bright} {adaptive} {dark}");
        // Looking up into light that travels down: the upper bound on shadow counts more.
        let beta = (bright - adaptive) / (bright - dark);
        if bright - dark > 1e-3 {
            assert!((beta - 0.5 * (1.0 + ray.direction[1])).abs() < 1e-9, "{beta} {ray:?}");
        }
    }
}

/// A filtered sample of a map without edges is the map; at edges it holds two depths.
#[test]
fn filtered_resampling_keeps_surfaces() {
    let map = map();
    let view = view(&map, 0.4);
    let frustum = frustum(&view);
    let rectification = Rectification::new(&frustum, view.axes, [96; 2], 0.05).unwrap();
    let nearest = RectifiedMap::nearest(rectification, &view.light);
    let technique = technique(MomentBound::Hamburger4);
    let stored = technique.filtered::<f64>(&map, &Kernel::uniform(3).unwrap()).unwrap();
    let depths = FilteredDepths::new(&technique, &stored).unwrap();
    let filtered = RectifiedMap::filtered(rectification, &view.light, &depths).unwrap();
    let (mut same, mut two) = (0, 0);
    for (a, b) in nearest.texels.iter().zip(&filtered.texels) {
        assert!((b.weights[0] + b.weights[1] - 1.0).abs() < 1e-12);
        let main = usize::from(b.weights[1] > b.weights[0]);
        same += usize::from((a.depths[0] - b.depths[main]).abs() < 1e-3);
        two += usize::from(b.weights[1 - main] > 0.05 && (b.depths[0] - b.depths[1]).abs() > 0.01);
    }
    assert!(same > nearest.texels.len() * 8 / 10 && two > nearest.texels.len() / 50, "{same} {two}");
    assert!(FilteredDepths::new(&TechniqueSpec::named("vsm").unwrap().build().unwrap(), &stored).is_err());
}

#[test]
fn extreme_rays_and_media_give_numbers() {
    let map = map();
    let technique = technique(MomentBound::Hamburger6);
    for extinction in [0.0, 1e-12, 1e3, 1e12] {
        let view = view(&map, extinction);
        let frustum = frustum(&view);
        let rectification = Rectification::new(&frustum, view.axes, [32; 2], 0.0).unwrap();
        let rectified = RectifiedMap::nearest(rectification, &view.light);
        for direction in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [1e-9, 1.0, 0.0]] {
            for length in [0.0, 1e-9, 5.0, f64::INFINITY] {
                let ray = ViewRay { direction, length, noise: 0.5, stream: 0 };
                let spacing = Spacing::Rays.inverse_sines(&rectified, &frustum, &view, &[ray]);
                let method = Prefiltered::<f32>::new(
                    StoredPrefixes { technique: &technique, blending: Blending::Adaptive, margin: 0.0 },
                    &rectified,
                    &view,
                    &spacing,
                )
                .unwrap();
                let all = [
                    view.truth(&ray),
                    method.estimate(&view, &ray).unwrap(),
                    ExactPrefixes::new(&rectified, spacing).estimate(&view, &ray).unwrap(),
                    Marched { steps: 8, jitter: Jitter::Step, seed: 1 }.estimate(&view, &ray).unwrap(),
                ];
                assert!(all.iter().all(|value| (0.0..=1.0).contains(value)), "{extinction} {ray:?}: {all:?}");
            }
        }
    }
}
