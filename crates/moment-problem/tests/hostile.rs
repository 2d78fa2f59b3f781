//! Whatever the moments are, the fast forms return two bounds in [0, 1] in order: no NaN, no panic.
//!
//! `MSM_HOSTILE_INPUTS=100000000` makes it thorough; the default is for every day.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use moment_problem::arithmetic::{FloatFloat, Real};
use moment_problem::hamburger::{Pair, chebyshev, hamburger, hamburger4};
use moment_problem::hausdorff::hausdorff4;
use moment_problem::trigonometric::trigonometric4;
use random_stream::Random;

/// 1 down to 1e-12, every power of ten as often.
fn small(random: &mut Random) -> f64 {
    10f64.powf(-12.0 * random.unit())
}

/// Eight power moments and four trigonometric ones of a kernel that is hard in some way, and z_f.
fn input(random: &mut Random) -> ([f64; 8], [f64; 4], f64) {
    let family = random.next_bits() % 8;
    let count = 1 + (random.next_bits() % 5) as usize;
    let centre = random.unit();
    let spread = small(random);
    let mut depths: Vec<f64> = (0..count)
        .map(|_| match family {
            // One thick surface, or surfaces close to each other, or at the ends of the range.
            0 | 1 => centre + spread * (random.unit() - 0.5),
            2 => (random.next_bits() % 2) as f64 + spread * (random.unit() - 0.5),
            _ => random.unit(),
        })
        .collect();
    if family == 3 {
        // Three surfaces at equal distances: c_3 vanishes at the middle one.
        depths = vec![centre - 0.5 * spread, centre, centre + 0.5 * spread];
    }
    let mut weights: Vec<f64> =
        depths.iter().map(|_| if family == 4 { small(random) } else { 0.01 + random.unit() }).collect();
    let total: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= total);
    let mean = |of: &dyn Fn(f64) -> f64| depths.iter().zip(&weights).map(|(&z, w)| w * of(z)).sum::<f64>();
    let mut powers: [f64; 8] = std::array::from_fn(|k| mean(&|z| z.powi(k as i32 + 1)));
    let wave = |k: f64, sine: bool| {
        let angle = move |z: f64| std::f64::consts::TAU * k * z;
        if sine { mean(&|z| angle(z).sin()) } else { mean(&|z| angle(z).cos()) }
    };
    let mut waves = [wave(1.0, true), wave(1.0, false), wave(2.0, true), wave(2.0, false)];
    let nothing = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e300, -1e-300, f64::MAX];
    for value in powers.iter_mut().chain(&mut waves) {
        match family {
            // Noise of any size, steps of a format, and no moments at all.
            5 => *value += small(random) * (random.unit() - 0.5),
            6 => *value = (*value * 1023.0).round() / 1023.0,
            7 if random.next_bits().is_multiple_of(4) => *value = nothing[(random.next_bits() % 8) as usize],
            7 => *value = 4.0 * random.unit() - 2.0,
            _ => {}
        }
    }
    let z_f = match random.next_bits() % 6 {
        0 => depths[0],
        1 => depths[0] + small(random) * (random.unit() - 0.5),
        2 => (random.next_bits() % 2) as f64,
        3 if family == 7 => nothing[(random.next_bits() % 8) as usize],
        _ => random.unit(),
    };
    (powers, waves, z_f)
}

fn check<R: Real>(powers: &[f64; 8], waves: &[f64; 4], z_f: f64, kind: &str) {
    let b = powers.map(R::from_f64);
    let four = [b[0], b[1], b[2], b[3]];
    let z = R::from_f64(z_f);
    let results: [(&str, Pair<R>); 6] = [
        ("Chebyshev", chebyshev(&[b[0], b[1]], z)),
        ("Hamburger 4", hamburger4(&four, z)),
        ("Hamburger 6", hamburger(&[b[0], b[1], b[2], b[3], b[4], b[5]], z)),
        ("Hamburger 8", hamburger(&b, z)),
        ("Hausdorff 4", hausdorff4(&four, z)),
        ("trigonometric 4", trigonometric4(&waves.map(R::from_f64), z)),
    ];
    for (name, pair) in results {
        let (lower, upper) = (pair.lower.to_f64(), pair.upper.to_f64());
        // A NaN fails every comparison.
        assert!(
            0.0 <= lower && lower <= upper && upper <= 1.0,
            "{kind} {name}: {lower} {upper} for {powers:?} {waves:?} at {z_f}"
        );
    }
}

#[test]
fn every_input_has_bounds_in_order_between_0_and_1() {
    let inputs: u64 =
        std::env::var("MSM_HOSTILE_INPUTS").ok().and_then(|text| text.parse().ok()).unwrap_or(200_000);
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get() as u64);
    std::thread::scope(|scope| {
        for thread in 0..threads {
            scope.spawn(move || {
                let mut random = Random::new(thread);
                for _ in 0..inputs / threads {
                    let (powers, waves, z_f) = input(&mut random);
                    check::<f32>(&powers, &waves, z_f, "f32");
                    check::<f64>(&powers, &waves, z_f, "f64");
                    check::<FloatFloat>(&powers, &waves, z_f, "pair");
                }
            });
        }
    });
}
