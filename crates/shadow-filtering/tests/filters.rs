//! Properties of every filter.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use shadow_filtering::*;

fn kernels() -> impl Strategy<Value = Kernel> {
    (0usize..5, 0.3f64..4.0, 0..3).prop_map(|(radius, sigma, shape)| {
        let size = 2 * radius + 1;
        let spec = match shape {
            0 => KernelSpec::Gaussian { size, sigma },
            1 => KernelSpec::Box { size },
            _ => KernelSpec::Binomial { size },
        };
        spec.build().unwrap()
    })
}

fn maps() -> impl Strategy<Value = ChannelMap<f64>> {
    (1usize..14, 1usize..14, 1usize..6).prop_flat_map(|(width, height, channels)| {
        let values = prop::collection::vec(-2.0f64..2.0, width * height * channels);
        values.prop_map(move |values| ChannelMap::new(width, height, channels, values).unwrap())
    })
}

/// The definition: a weighted sum over all taps, reading the nearest texel beyond the border.
fn direct(map: &ChannelMap<f64>, kernel: &Kernel, x: usize, y: usize, channel: usize) -> f64 {
    let clamp = |i: isize, size: usize| i.clamp(0, size as isize - 1) as usize;
    let tap = |(i, j, w): (isize, isize, f64)| {
        let (x, y) = (clamp(x as isize + i, map.width()), clamp(y as isize + j, map.height()));
        w * map.texel(x, y)[channel]
    };
    kernel.taps().map(tap).sum()
}

proptest! {
    #[test]
    fn two_passes_are_the_direct_sum_in_both_precisions(map in maps(), kernel in kernels()) {
        let filtered = filter(&map, &kernel);
        let single: Vec<f32> = map.data().iter().map(|&value| value as f32).collect();
        let single = ChannelMap::new(map.width(), map.height(), map.channels(), single).unwrap();
        let single = filter(&single, &kernel);
        for y in 0..map.height() {
            for x in 0..map.width() {
                for channel in 0..map.channels() {
                    let exact = direct(&map, &kernel, x, y, channel);
                    prop_assert!((filtered.texel(x, y)[channel] - exact).abs() < 1e-13);
                    prop_assert!((f64::from(single.texel(x, y)[channel]) - exact).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn a_constant_stays_and_the_sum_of_a_spot_is_preserved(
        kernel in kernels(), value in -3.0f64..3.0, x in 4usize..8, y in 4usize..8,
    ) {
        let constant = ChannelMap::new(12, 12, 1, vec![value; 144]).unwrap();
        prop_assert!(filter(&constant, &kernel).data().iter().all(|v| (v - value).abs() < 1e-14));
        let mut spot = vec![0.0; 144];
        spot[y * 12 + x] = value;
        // The spot is as far from the border as the largest kernel reaches, so nothing is lost.
        let filtered = filter(&ChannelMap::new(12, 12, 1, spot).unwrap(), &kernel);
        prop_assert!((filtered.data().iter().sum::<f64>() - value).abs() < 1e-13);
    }

    #[test]
    fn the_mip_chain_preserves_the_mean(map in maps()) {
        let pyramid = Pyramid::new(&map);
        let chain = pyramid.levels();
        for channel in 0..map.channels() {
            let mean = |level: &ChannelMap<f64>| {
                let values = level.data().iter().skip(channel).step_by(level.channels());
                values.sum::<f64>() / (level.width() * level.height()) as f64
            };
            for level in chain {
                prop_assert!((mean(level) - mean(&map)).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let mut state = 7u64;
    let depths = (0..97 * 61).map(|_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    });
    let map = DepthMap::new(97, 61, depths.collect()).unwrap();
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let technique = TechniqueSpec::named("hamburger6").unwrap().build().unwrap();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| filter(&encode::<f64>(&map, &technique).unwrap(), &kernel))
    };
    let bits = |map: ChannelMap<f64>| map.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(run(1)), bits(run(2)));
}

#[test]
fn a_value_that_the_format_cannot_hold_is_an_error() {
    // e^(2 * 42 s) at s = 1 fits f32; f16's limit is checked by the technique, f32 overflow by the map.
    let map = DepthMap::new(1, 1, vec![1.0]).unwrap();
    let esm =
        |exponent| TechniqueSpec { exponent: Some(exponent), ..TechniqueSpec::named("esm").unwrap() }.build();
    assert!(encode::<f32>(&map, &esm(88.0).unwrap()).is_ok());
    assert!(esm(89.0).is_err());
}
