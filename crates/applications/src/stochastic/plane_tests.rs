use super::*;
use crate::samples::TapShape;
use crate::stochastic::{FilterPlane, Lens, LightRay, filtered};

const SIZE: usize = 48;
const SCALE: f64 = 40.0;
const PLANE: f64 = 4.0;
const LEAST: f64 = 1.2;

/// Rays onto a half plane at distance 2 over a receiver at distance 4, both parallel to the light.
fn map(half_size: f64, focus: f64) -> (LensMap, Vec<f32>) {
    let lens = Lens { size: [SIZE; 2], texels: [SCALE; 2], half_size: [half_size; 2] };
    let map = LensMap::trace(lens, focus, (1, 0), |[x, y], [u, v]| {
        let start = [2.0 * u - 1.0, 2.0 * v - 1.0].map(|c| half_size * c);
        // Slopes about the middle of the map.
        let at = |d: f64| start[0] * (1.0 - d / focus) + (x - 0.5 * SIZE as f64) / SCALE * d;
        let _ = y;
        (start, Some(if at(2.0) < 0.0 { 2.0 } else { PLANE }))
    });
    let values = map.samples().iter().map(|s| if s.distance < 3.0 { 1.0 } else { 0.0 }).collect();
    (map, values)
}

fn taps() -> PoissonTaps {
    PoissonTaps::new(TapShape::Disc, 12, 1, 0)
}

fn plain() -> PlaneFilter {
    PlaneFilter {
        centre: SampleCentre::Projected,
        edge_taps: 0,
        gather_radius: 16,
        coarse_levels: 0,
        interleaved: false,
        box_filter: false,
        // No sample lies at this distance of another one but for rounding.
        least_radius: LEAST,
        ..PlaneFilter::published()
    }
}

/// Without its approximations the filter is equation 7, which is computed elsewhere by asking every sample.
#[test]
fn one_level_gathers_what_equation_7_says() {
    // Circles of 40 x 0.3 x |1/2 - 1/4| = 3 texels.
    let (map, values) = map(0.3, PLANE);
    let plane = filter_plane(&map, PLANE, (&values, 1), &plain(), (&taps(), 1), None);
    let rays: Vec<LightRay> = map
        .samples()
        .iter()
        .enumerate()
        .map(|(i, sample)| {
            let origin = sample.start.map(|start| f64::from(start) / SCALE);
            let texel = [i % SIZE, i / SIZE].map(|t| (t as f64 + 0.5) / SCALE);
            // Through the texel's point on the plane: texel x distance / scale.
            let offset = [0, 1].map(|k| (texel[k] * PLANE - origin[k]) / PLANE);
            LightRay { origin, offset, depth: f64::from(sample.distance) }
        })
        .collect();
    let reference =
        FilterPlane { texels_per_unit: SCALE / PLANE, light_radius: 0.3, depth: PLANE, least_radius: LEAST };
    let samples: Vec<_> = reference
        .samples(&rays)
        .into_iter()
        // The search for edges is another matter.
        .map(|sample| crate::stochastic::PlaneSample { radius: sample.circle.max(LEAST), ..sample })
        .collect();
    for i in (0..SIZE * SIZE).step_by(7) {
        let at = [i % SIZE, i / SIZE].map(|t| t as f64 + 0.5);
        let shared = |depth: f64| [if depth < 3.0 { 1.0 } else { 0.0 }];
        let expected = filtered(&samples, at, shared).map(|[share]| share);
        let got = (plane.weights[i] > 0.0).then(|| f64::from(plane.values[i]));
        match (expected, got) {
            (Some(expected), Some(got)) => assert!((expected - got).abs() < 2e-3, "{at:?}: {expected} {got}"),
            (expected, got) => assert_eq!(expected, got, "{at:?}"),
        }
    }
}

/// The share of shadow across the penumbra of a half plane, by the published filter.
fn penumbra(filter: &PlaneFilter, half_size: f64, focus: f64) -> Vec<f32> {
    let (map, values) = map(half_size, focus);
    let plane = filter_plane(&map, PLANE, (&values, 1), filter, (&taps(), 1), None);
    let row = SIZE / 2 * SIZE;
    plane.values[row..row + SIZE].to_vec()
}

#[test]
fn the_published_filter_makes_the_penumbra_of_the_light() {
    // Circles of 6 texels: two levels.
    for focus in [PLANE, 3.0] {
        let row = penumbra(&PlaneFilter::published(), 0.6, focus);
        // The edge is seen at the middle of the map, whose texels there are half in shadow.
        assert!(row[8] > 0.97 && row[39] < 0.03, "{focus}: {row:?}");
        assert!((row[23] + row[24] - 1.0).abs() < 0.25, "{focus}: {row:?}");
        // The penumbra reaches about as far as the circles.
        assert!(row[20] < 0.97 && row[27] > 0.03, "{focus}: {row:?}");
    }
}

/// Samples that one level cannot gather whole are left to a coarser one; without it they are cut off.
#[test]
fn coarse_levels_reach_farther() {
    let (map, values) = map(1.2, PLANE);
    let with = |coarse_levels: usize| {
        let filter = PlaneFilter { coarse_levels, ..PlaneFilter::published() };
        filter_plane(&map, PLANE, (&values, 1), &filter, (&taps(), 1), None)
    };
    assert!(with(0).cut_off > 0.3 && with(2).cut_off == 0.0, "{} {}", with(0).cut_off, with(2).cut_off);
    let share = |plane: &FilteredPlane<f32>, x: usize| plane.values[SIZE / 2 * SIZE + x];
    // 12 texels to each side of the middle there is light yet.
    assert!(
        share(&with(2), 33) > share(&with(0), 33) + 0.01,
        "{} {}",
        share(&with(2), 33),
        share(&with(0), 33)
    );
}

#[test]
fn tiles_that_nobody_needs_change_nothing_where_they_are_needed() {
    let (map, values) = map(0.6, 3.0);
    let whole = filter_plane(&map, PLANE, (&values, 1), &PlaneFilter::published(), (&taps(), 1), None);
    let needed: Vec<bool> = (0..SIZE * SIZE).map(|i| i % SIZE < 4 && i / SIZE < 4).collect();
    let part =
        filter_plane(&map, PLANE, (&values, 1), &PlaneFilter::published(), (&taps(), 1), Some(&needed));
    assert!(part.active_tiles < 0.5 && whole.active_tiles == 1.0);
    for y in 0..5 {
        let row = y * SIZE..y * SIZE + 5;
        assert_eq!(whole.values[row.clone()], part.values[row]);
    }
    let mut out = [0.0];
    assert_eq!(part.at([47.0, 47.0], &mut out), None);
    assert!(whole.at([47.0, 47.0], &mut out).is_some() && out[0] < 0.05);
    // Off the focus several rays share a texel, and some texels have none.
    assert!(whole.merged > 1.2, "{}", whole.merged);
}

#[test]
fn filters_that_make_no_sense_are_named() {
    let error = |filter: PlaneFilter| filter.check().unwrap_err().to_string();
    assert!(PlaneFilter::published().check().is_ok() && plain().check().is_ok());
    assert!(error(PlaneFilter { gather_radius: 17, ..plain() }).contains("gather_radius = 17"));
    assert!(error(PlaneFilter { gather_radius: 0, ..plain() }).contains("gather_radius = 0"));
    assert!(error(PlaneFilter { least_radius: 9.0, ..plain() }).contains("least_radius = 9"));
    assert!(error(PlaneFilter { least_radius: f64::NAN, ..plain() }).contains("NaN"));
    assert!(error(PlaneFilter { coarse_levels: 13, ..plain() }).contains("coarse_levels = 13"));
}

/// Share of a disc of radius 1 about the origin that lies below `t`.
fn segment(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    0.5 + (t * (1.0 - t * t).sqrt() + t.asin()) / std::f64::consts::PI
}

/// Mean distance of a filtered plane in focus from what is expected across the penumbra of a half plane, at a side of so many
/// texels; `expected` is asked at distances from the edge of the shadow in radii of the penumbra.
fn distance_from(
    filter: &PlaneFilter,
    taps: &PoissonTaps,
    size: usize,
    expected: impl Fn(f64) -> f64,
) -> f64 {
    let (radius, scale) = (0.6, SCALE * size as f64 / SIZE as f64);
    let lens = Lens { size: [size; 2], texels: [scale; 2], half_size: [radius; 2] };
    let slope = |x: f64| (x - 0.5 * size as f64) / scale;
    let map = LensMap::trace(lens, PLANE, (1, 0), |[x, _], [u, v]| {
        let start = crate::samples::concentric_disc([2.0 * u - 1.0, 2.0 * v - 1.0]).map(|c| radius * c);
        let at_two = start[0] * (1.0 - 2.0 / PLANE) + slope(x) * 2.0;
        (start, Some(if at_two < 0.0 { 2.0 } else { PLANE }))
    });
    let values: Vec<f32> = map.samples().iter().map(|s| if s.distance < 3.0 { 1.0 } else { 0.0 }).collect();
    let plane = filter_plane(&map, PLANE, (&values, 1), filter, (taps, 1), None);
    let border = size / 6;
    let mut errors = Vec::new();
    for y in border..size - border {
        for x in border..size - border {
            let expected = expected(slope(x as f64 + 0.5) * PLANE / radius);
            errors.push((f64::from(plane.values[y * size + x]) - expected).abs());
        }
    }
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// Hidden is the part of the light beyond the edge as seen through it.
fn hidden(distance: f64) -> f64 {
    segment(-distance)
}

/// No search for edges, no approximation.
fn exact(least_radius: f64) -> PlaneFilter {
    PlaneFilter {
        centre: SampleCentre::Projected,
        least_radius,
        edge_taps: 0,
        edge_smoothing: false,
        gather_radius: 16,
        coarse_levels: 4,
        interleaved: false,
        box_filter: false,
        ..PlaneFilter::published()
    }
}

/// On one plane in focus the filter converges to the area light with the number of samples if receivers reach more and more
/// texels, but less and less of the plane.
#[test]
fn errors_fall_with_the_number_of_samples() {
    let errors = [24, 48, 96, 192].map(|size: usize| {
        let filter = exact(0.4 * (size as f64).sqrt());
        distance_from(&filter, &taps(), size, hidden)
    });
    // Then the coarser levels' own error is left, about 1 %.
    assert!(errors[1] < errors[0] && errors[2] < errors[1], "{errors:?}");
    assert!(errors[2] < 0.4 * errors[0] && errors[3] < 0.02, "{errors:?}");
}

/// Receivers of a fixed number of texels keep their noise, whatever the resolution.
#[test]
fn a_fixed_radius_keeps_its_noise() {
    let errors = [48, 192].map(|size| distance_from(&exact(1.0), &taps(), size, hidden));
    assert!(errors[1] > 0.8 * errors[0] && errors[1] > 0.05, "{errors:?}");
}

/// Where c_l gives receivers the reach of their blockers, as published, the hidden share h becomes h / (h + mean of 1 - h within
/// that reach, over the penumbra): the weights of blockers are right at a point, those of receivers on average around it.
#[test]
fn the_reach_of_blockers_biases_receivers() {
    // Circles of 8 texels: one level gathers them whole.
    let filter = PlaneFilter { edge_taps: 512, edge_reach: 8.0, coarse_levels: 0, ..exact(1.0) };
    let many = PoissonTaps::new(TapShape::Disc, 512, 1, 0);
    let biased = |distance: f64| {
        const STEPS: usize = 200;
        let (mut lit, mut area) = (0.0, 0.0);
        for step in 0..STEPS {
            let t = (step as f64 + 0.5) / STEPS as f64 * 2.0 - 1.0;
            let width = (1.0 - t * t).sqrt();
            // Beyond the penumbra no blocker's circle holds a receiver, which then reaches its texel alone.
            if distance + t < 1.0 {
                lit += width * (1.0 - hidden(distance + t));
            }
            area += width;
        }
        let hidden = hidden(distance);
        if hidden > 0.0 { hidden / (hidden + lit / area) } else { 0.0 }
    };
    let from_truth = distance_from(&filter, &many, 64, hidden);
    let from_biased = distance_from(&filter, &many, 64, biased);
    println!("{from_truth} {from_biased}");
    assert!(from_biased < 0.4 * from_truth && from_biased < 0.02, "{from_truth} {from_biased}");
}
