//! What every technique has to do, whatever its basis, encoding and bound: one call for a new one.

use shadow_filtering::{DepthMap, FilteringError, Kernel, Technique, encode, filter};

/// Side of the maps in texels.
const SIZE: usize = 48;

/// A lower bound may exceed F_Z by no more: what double precision makes of moments of nearly singular kernels.
const VIOLATION: f64 = 1e-6;

/// Distance of a filtered value from the kernel's mean, relative to 1 and to its size: some hundred roundings.
const ROUNDING: f64 = 1e-13;

/// Numbers in \[0, 1\) that are the same on every machine.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// Kernels of every kind: flat, last-bit noise, tilted, two surfaces, leaves over ground, far plane, a thin slope, noise.
///
/// # Errors
/// None: all depths are finite.
pub fn maps() -> Result<Vec<DepthMap>, FilteringError> {
    let mut noise = Noise(3);
    let mut maps = Vec::new();
    for kind in 0..8 {
        let noise: Vec<f64> = (0..SIZE * SIZE).map(|_| noise.next()).collect();
        let depth = |t: usize| {
            let (x, y) = ((t % SIZE) as f64 / SIZE as f64, (t / SIZE) as f64 / SIZE as f64);
            match kind {
                0 => 0.6,
                1 => 0.6 + (noise[t] * 3.0).floor() / f64::from(1 << 24),
                2 => 0.2 + 0.5 * x + 0.1 * y,
                3 if x + 0.3 * y < 0.6 => 0.25,
                3 => 0.65,
                4 if noise[t] < 0.4 => 0.3 + 0.2 * noise[t],
                4 => 0.8 + 0.1 * x,
                5 if x < 0.4 => 0.1,
                5 => f64::from(u8::from(y < 0.5)),
                6 => 0.5 + 1e-5 * (x + noise[t]),
                _ => noise[t],
            }
        };
        maps.push(DepthMap::new(SIZE, SIZE, (0..SIZE * SIZE).map(|t| depth(t) as f32).collect())?);
    }
    Ok(maps)
}

/// Receivers of a map: column, row and z_f; each texel's own depth and others.
fn receivers(map: &DepthMap) -> Vec<(usize, usize, f64)> {
    let mut noise = Noise(11);
    let mut receivers = Vec::new();
    for (y, x) in (0..SIZE).step_by(5).flat_map(|y| (0..SIZE).step_by(5).map(move |x| (y, x))) {
        let own = f64::from(map.at(x as isize, y as isize));
        let other = f64::from(map.at((x + 3) as isize, (y + 2) as isize));
        let at = |z: f64| (x, y, z.clamp(0.0, 1.0));
        receivers.extend([own, other, own + 1e-7, own + 0.01, noise.next(), 0.0, 1.0].map(at));
    }
    receivers
}

/// Holds a technique to its word on [`maps`], in double precision and without storage; the number of comparisons.
///
/// - G lies in \[0, 1\], and does not exceed F_Z where the technique calls itself a bound.
/// - The filtered map holds the mean of b(z) over the kernel's distribution.
/// - Depths outside \[0, 1\], NaN included, are clamped; nothing becomes infinite.
///
/// # Errors
/// The first thing that is wrong, in one line with its numbers.
pub fn check(technique: &Technique) -> Result<usize, String> {
    let name = technique.name();
    let fail = |error: FilteringError| format!("{name}: {error}");
    let kernel = Kernel::gaussian(9, 2.4).map_err(fail)?;
    let mut compared = 0;
    for (number, map) in maps().map_err(fail)?.iter().enumerate() {
        let filtered = filter(&encode::<f64>(map, technique).map_err(fail)?, &kernel);
        for (x, y, z_f) in receivers(map) {
            let g = technique.shade(filtered.texel(x, y), z_f).map_err(fail)?;
            let f = kernel.percentage_closer(map, x, y, z_f);
            let place = format!("{name}, map {number} at ({x}, {y}), z_f {z_f}");
            if !(0.0..=1.0).contains(&g) {
                return Err(format!("{place}: {g} is no share"));
            }
            if technique.is_lower_bound() && g > f + VIOLATION {
                return Err(format!("{place}: {g} > {f}"));
            }
            compared += 1;
        }
        let (x, y) = (17, 22);
        let distribution = kernel.distribution(map, x, y);
        let mut mean = vec![0.0; technique.channels()];
        let mut b = mean.clone();
        for (&depth, &weight) in distribution.depths().iter().zip(distribution.weights()) {
            technique.evaluate(depth, &mut b);
            mean.iter_mut().zip(&b).for_each(|(sum, value)| *sum += weight.to_f64() * value);
        }
        for (channel, (mean, value)) in mean.iter().zip(filtered.texel(x, y)).enumerate() {
            if (mean - value).abs() > ROUNDING * (1.0 + mean.abs()) {
                return Err(format!(
                    "{name}, map {number}, channel {channel}: {value} is not the mean {mean}"
                ));
            }
            compared += 1;
        }
    }
    let (mut outside, mut inside) = (vec![0.0; technique.channels()], vec![0.0; technique.channels()]);
    for (far, near) in [(-7.0, 0.0), (1e300, 1.0), (f64::INFINITY, 1.0), (f64::NAN, 1.0)] {
        technique.evaluate(far, &mut outside);
        technique.evaluate(near, &mut inside);
        if outside != inside || outside.iter().any(|value| !value.is_finite()) {
            return Err(format!("{name}: b({far}) = {outside:?} is not b({near}) = {inside:?}"));
        }
        let [g, clamped] = [far, near].map(|z_f| technique.shade(&outside, z_f).map_err(fail));
        if g? != clamped? {
            return Err(format!("{name}: G at {far} is not that at {near}"));
        }
        compared += 1;
    }
    Ok(compared)
}
