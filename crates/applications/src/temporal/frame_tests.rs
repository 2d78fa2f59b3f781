use super::*;
use crate::samples::TapShape;
use quantization::NumberFormat;

const SCREEN: Screen = Screen { light_size: 1.0, pixels_per_unit: 100.0 };

fn taps() -> PoissonTaps {
    PoissonTaps::new(TapShape::Disc, 16, 1, 0)
}

fn pixel(x: usize, y: usize, in_shadow: bool) -> FramePixel {
    let before = [x as f64 + 0.5, y as f64 + 0.5, 10.0];
    FramePixel {
        depth: 10.0,
        before,
        followed: before,
        receiver: 8.0,
        in_shadow,
        hidden: in_shadow,
        map_distance: if in_shadow { 4.0 } else { 8.0 },
        moving: false,
    }
}

fn alone() -> TemporalMethod {
    let format = NumberFormat::F32;
    TemporalMethod { start_tests: 0.0, filter: FilterSource::Off, format, ..TemporalMethod::published() }
}

/// A column a pixel, in shadow for a third of the frames.
fn run(method: &TemporalMethod, frames: usize) -> Vec<Option<Shaded>> {
    let mut buffer = ShadowBuffer::empty(4, 1);
    let mut shaded = Vec::new();
    for frame in 0..frames {
        let pixels: Vec<_> = (0..4).map(|x| Some(pixel(x, 0, frame % 3 == 0))).collect();
        let start = |_: usize, _: bool| Start { fraction: 0.5, blocker: Some(4.0), moving: false };
        (buffer, shaded) = method.frame(&buffer, &pixels, &SCREEN, &taps(), &start);
    }
    shaded
}

#[test]
fn sampling_alone_is_equation_5() {
    let shaded = run(&alone(), 300)[2].unwrap();
    assert_eq!((shaded.tests, shaded.estimate, shaded.restarted), (300.0, 1.0 / 3.0, false));
    let expected = (1.0 / 3.0 * 2.0 / 3.0 / 299.0f64).sqrt();
    assert!((shaded.standard_error - expected).abs() < 1e-9);
    assert_eq!(shaded.lookups, 2);
}

#[test]
fn a_start_counts_as_its_tests() {
    let shaded =
        run(&TemporalMethod { format: NumberFormat::F32, ..TemporalMethod::published() }, 3)[0].unwrap();
    // The first frame's own test is not used: rho = 4 / 2, then tests of frames 1 and 2, both lit.
    assert_eq!((shaded.tests, shaded.estimate), (6.0, 2.0 / 6.0));
    assert!(shaded.filtered && shaded.lookups == 18);
}

#[test]
fn half_floats_stop_counting_and_a_cap_goes_on() {
    let half = TemporalMethod { format: NumberFormat::F16, ..alone() };
    let shaded = run(&half, 9000)[0].unwrap();
    // n stands still at 2048 while rho goes on: a third becomes everything.
    assert_eq!((shaded.tests, shaded.estimate), (2048.0, 1.0));
    let capped = TemporalMethod { most_tests: 512.0, ..half };
    let shaded = run(&capped, 9000)[0].unwrap();
    assert!(shaded.tests <= 512.0 && (shaded.estimate - 1.0 / 3.0).abs() < 0.05, "{shaded:?}");
}

#[test]
fn other_surfaces_and_moving_casters_begin_anew() {
    let start = |_: usize, _: bool| Start { fraction: 0.25, blocker: None, moving: true };
    let method = TemporalMethod { filter: FilterSource::Off, ..TemporalMethod::published() };
    let seen = |pixel: FramePixel, method: &TemporalMethod| {
        let frame =
            |buffer: &ShadowBuffer, pixel| method.frame(buffer, &[Some(pixel)], &SCREEN, &taps(), &start);
        let (buffer, _) = frame(&ShadowBuffer::empty(1, 1), pixel_at_rest());
        frame(&buffer, pixel).1[0].unwrap().restarted
    };
    assert!(!seen(pixel_at_rest(), &method));
    assert!(seen(FramePixel { before: [0.5, 0.5, 10.2], ..pixel_at_rest() }, &method));
    assert!(seen(FramePixel { before: [1.5, 0.5, 10.0], ..pixel_at_rest() }, &method));
    let moving = FramePixel { moving: true, ..pixel_at_rest() };
    assert!(seen(moving, &method));
    assert!(!seen(moving, &TemporalMethod { moving: MovingCasters::Ignored, ..method.clone() }));
    assert!(seen(pixel_at_rest(), &TemporalMethod { moving: MovingCasters::Search, ..method.clone() }));
    // A receiver that moved is found where it was, if anybody looks there.
    let followed = FramePixel { before: [0.5, 0.5, 12.0], followed: [0.5, 0.5, 10.0], ..pixel_at_rest() };
    assert!(seen(followed, &method) && !seen(followed, &TemporalMethod { follow: true, ..method }));
}

fn pixel_at_rest() -> FramePixel {
    pixel(0, 0, true)
}

#[test]
fn the_filter_is_as_wide_as_the_penumbra_and_keeps_to_the_surface() {
    // Left half in shadow, one test each; the penumbra is 1 x (8 - 4) / 4 x 100 / 10 = 10 pixels wide.
    let method =
        TemporalMethod { filter: FilterSource::Current, cautious: true, blockers_only: true, ..alone() };
    let wide = 40;
    let mut pixels: Vec<_> = (0..wide * wide).map(|i| Some(pixel(i % wide, i / wide, true))).collect();
    for (i, pixel) in pixels.iter_mut().enumerate() {
        if let Some(pixel) = pixel.as_mut().filter(|_| i % wide >= 20) {
            pixel.in_shadow = false;
        }
    }
    let start = |_: usize, _: bool| Start::default();
    let shown = |pixels: &[Option<FramePixel>]| {
        let shaded = method.frame(&ShadowBuffer::empty(wide, wide), pixels, &SCREEN, &taps(), &start).1;
        (0..wide).map(|x| shaded[20 * wide + x].unwrap().shadow).collect::<Vec<f64>>()
    };
    let row = shown(&pixels);
    assert_eq!((row[10], row[39]), (1.0, 0.0), "{row:?}");
    assert!(row[18] < 1.0 && row[18] > 0.4, "{row:?}");
    // What lies at another distance does not count.
    for (i, pixel) in pixels.iter_mut().enumerate() {
        if let Some(pixel) = pixel.as_mut().filter(|_| i % wide >= 20) {
            pixel.depth = 11.0;
        }
    }
    assert_eq!(shown(&pixels)[18], 1.0);
}

#[test]
fn settings_that_make_no_sense_are_named() {
    let error = |method: TemporalMethod| method.check().unwrap_err().to_string();
    let published = TemporalMethod::published();
    assert!(published.check().is_ok() && alone().check().is_ok());
    assert!(error(TemporalMethod { threshold: f64::NAN, ..published.clone() }).contains("threshold = NaN"));
    let beyond = error(TemporalMethod { most_tests: 4096.0, ..published.clone() });
    assert!(beyond.contains("most_tests = 4096 is more than the 2048 that f16 counts"), "{beyond}");
    assert!(error(TemporalMethod { most_tests: 4.0, ..published.clone() }).contains("most_tests = 4"));
    assert!(error(TemporalMethod { format: NumberFormat::Unorm16, ..published }).contains("cannot count"));
}
