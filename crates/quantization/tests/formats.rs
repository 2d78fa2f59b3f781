//! Encoding and decoding millions of random values.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use quantization::published::ALL;
use quantization::{Encoding, NumberFormat};
use random_stream::Random;

const FORMATS: [NumberFormat; 7] = [
    NumberFormat::Unorm8,
    NumberFormat::Unorm10,
    NumberFormat::Unorm16,
    NumberFormat::F16,
    NumberFormat::F32,
    NumberFormat::U32Fixed { texels: 81 },
    NumberFormat::U32Fixed { texels: 65536 },
];

/// Distance to the next larger stored value.
fn spacing(format: NumberFormat, value: f64) -> f64 {
    match format {
        NumberFormat::F16 => 2f64.powi((value.max(2f64.powi(-14)).log2().floor() as i32) - 10),
        NumberFormat::F32 => 2f64.powi((value.max(2f64.powi(-126)).log2().floor() as i32) - 23),
        fixed => fixed.step(),
    }
}

/// Half a code of rounding, and the rounding of the comparison itself.
const HALF_CODE: f64 = 0.5 + 1e-6;

#[test]
fn two_million_values_come_back_within_one_code_and_codes_come_back_as_they_are() {
    for (stream, format) in FORMATS.into_iter().enumerate() {
        let mut random = Random::stream(2, stream as u64);
        for i in 0..2_000_000 {
            // Uniform, and down to the smallest numbers.
            let value = random.unit() * if i % 4 == 0 { 2f64.powf(-30.0 * random.unit()) } else { 1.0 };
            let code = format.encode(value);
            let back = format.decode(code);
            assert!(
                (back - value).abs() <= HALF_CODE * spacing(format, value),
                "{format}: {value} -> {back}"
            );
            assert_eq!(format.encode(back), code, "{format}: {value}");
        }
        for special in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 1e300, -1e300] {
            assert!(format.round(special).is_finite(), "{format}: {special}");
        }
    }
}

#[test]
fn order_is_kept() {
    for format in FORMATS {
        let mut random = Random::stream(3, 0);
        for _ in 0..200_000 {
            let (a, b) = (random.unit(), random.unit());
            assert!((a <= b) <= (format.round(a) <= format.round(b)), "{format}: {a} {b}");
        }
    }
}

proptest! {
    /// Moments of random kernels through every published transform and every format: in stored coordinates, they
    /// come back within one code.
    #[test]
    fn moment_vectors_come_back_within_one_code(
        depths in prop::collection::vec(0.0..=1.0f64, 1..6),
        which in 0..ALL.len(),
        format in prop::sample::select(FORMATS.to_vec()),
    ) {
        let published = &ALL[which];
        let interval = published.interval();
        let mut b = vec![0.0; published.order];
        for z in &depths {
            let z = interval.start() + z * interval.length();
            b.iter_mut().enumerate().for_each(|(k, sum)| *sum += z.powi(k as i32 + 1) / depths.len() as f64);
        }
        let theta = published.transform().unwrap();
        let encoding = Encoding::new(theta.clone(), format);
        let codes = encoding.encode(&b).unwrap();
        let back = encoding.decode(&codes).unwrap();
        let (mut before, mut after) = (vec![0.0; b.len()], vec![0.0; b.len()]);
        theta.apply(&b, &mut before);
        theta.apply(&back, &mut after);
        for (before, after) in before.iter().zip(&after) {
            prop_assert!((before - after).abs() <= format.step() + 1e-12, "{}: {before} {after}", format);
        }
        prop_assert!(encoding.encode(&b[1..]).is_err());
    }
}
