//! Inputs that are hard in a known way.

use super::exact::Polynomials;
use super::settings::Shape;
use moment_problem::arithmetic::{DoubleDouble, Real};
use random_stream::Random;

/// A distribution of depths and z_f, which is a multiple of 2^-24: single floats hold it and 2 z_f - 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct Input {
    /// Depths in \[0, 1\] with weights that sum to 1.
    pub(crate) atoms: Vec<(f64, f64)>,
    pub(crate) z_f: f64,
}

/// Moments in all variables, the first eight of each (four of waves).
pub(crate) struct Moments<R> {
    /// Powers of 2 z - 1.
    pub(crate) signed: [R; 8],
    /// Powers of z.
    pub(crate) unit: [R; 8],
    /// Sine and cosine of 2 pi z and 4 pi z.
    pub(crate) waves: [R; 8],
}

impl<R: Real> Moments<R> {
    fn of(input: &Input) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let (mut signed, mut unit, mut waves) = ([zero; 8], [zero; 8], [zero; 8]);
        let turn = R::from_double_double(DoubleDouble::pi() * DoubleDouble::from(2.0));
        // Weights sum to 1 to 16 digits only, but b_0 is 1.
        let total = input.atoms.iter().fold(zero, |sum, &(_, w)| sum + R::from_f64(w));
        for &(z, w) in &input.atoms {
            let (z, w) = (R::from_f64(z), R::from_f64(w) / total);
            for (sums, base) in [(&mut signed, z + z - one), (&mut unit, z)] {
                let mut power = w;
                for sum in sums {
                    power = power * base;
                    *sum = *sum + power;
                }
            }
            let (sine, cosine) = ((turn * z).sin(), (turn * z).cos());
            let double = [(sine * cosine) + (sine * cosine), (cosine - sine) * (cosine + sine)];
            for (sum, value) in waves.iter_mut().zip([sine, cosine, double[0], double[1]]) {
                *sum = *sum + w * value;
            }
        }
        Self { signed, unit, waves }
    }
}

impl Moments<DoubleDouble> {
    /// To 32 digits.
    pub(crate) fn exact(input: &Input) -> Self {
        Self::of(input)
    }
}

impl Moments<f64> {
    /// In double precision.
    pub(crate) fn plain(input: &Input) -> Self {
        Self::of(input)
    }
}

impl Input {
    /// Weights are divided by their sum, depths clamped to \[0, 1\], z_f rounded to its grid.
    pub(crate) fn new(mut atoms: Vec<(f64, f64)>, z_f: f64) -> Self {
        let total: f64 = atoms.iter().map(|a| a.1).sum();
        atoms.iter_mut().for_each(|(z, w)| (*z, *w) = (z.clamp(0.0, 1.0), *w / total));
        Self { atoms, z_f: on_grid(z_f) }
    }

    /// F: mass strictly before z_f.
    pub(crate) fn mass_before(&self) -> f64 {
        let front = self.atoms.iter().filter(|a| a.0 < self.z_f).map(|a| a.1);
        front.sum::<f64>().min(1.0)
    }

    pub(crate) fn distinct_depths(&self) -> usize {
        // Past the largest number that matters the count may be too large.
        let mut seen: [f64; 6] = [f64::NAN; 6];
        let mut count = 0;
        for &(z, _) in &self.atoms {
            if !seen[..count].contains(&z) {
                if count == seen.len() {
                    return self.atoms.len();
                }
                seen[count] = z;
                count += 1;
            }
        }
        count
    }
}

/// The nearest multiple of 2^-24 in \[0, 1\].
pub(crate) fn on_grid(z: f64) -> f64 {
    const STEPS: f64 = 16_777_216.0;
    (z.clamp(0.0, 1.0) * STEPS).round() / STEPS
}

/// Depths of a surface with a thickness.
const DEPTHS_PER_SURFACE: usize = 5;

/// Thickness of surfaces whose thickness is no knob.
const THIN: f64 = 1e-4;

/// Random numbers for inputs.
pub(crate) struct Draw(pub(crate) Random);

impl Draw {
    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.unit()
    }

    fn sign(&mut self) -> f64 {
        if self.0.unit() < 0.5 { -1.0 } else { 1.0 }
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.0.unit() * count as f64) as usize).min(count - 1)
    }

    /// Adds a surface of a weight.
    fn surface(&mut self, atoms: &mut Vec<(f64, f64)>, middle: f64, thickness: f64, weight: f64) {
        let first = atoms.len();
        for _ in 0..DEPTHS_PER_SURFACE {
            atoms.push((middle + thickness * self.between(-0.5, 0.5), self.between(0.2, 1.0)));
        }
        let total: f64 = atoms[first..].iter().map(|a| a.1).sum();
        atoms[first..].iter_mut().for_each(|a| a.1 *= weight / total);
    }

    /// An input of a family at given values of its knobs.
    ///
    /// Scenes have none; theirs come from [`scenes`](super::scenes).
    pub(crate) fn input(&mut self, shape: Shape, x: f64, y: f64) -> Input {
        let mut atoms = Vec::new();
        let z_f = on_grid(self.between(0.05, 0.95));
        match shape {
            Shape::OneSurface => {
                let middle = z_f + self.sign() * y;
                self.surface(&mut atoms, middle, x, 1.0);
            }
            Shape::TwoSurfaces | Shape::LightSurface => {
                // z_f from before the first to behind the second.
                let first = z_f - y * self.between(-0.5, 2.0);
                let is_light = shape == Shape::LightSurface;
                let (thickness, second) =
                    if is_light { (THIN * y, x) } else { (x, self.between(0.05, 0.95)) };
                let step = self.sign() * y;
                self.surface(&mut atoms, first, thickness, 1.0 - second);
                self.surface(&mut atoms, first + step, thickness, second);
            }
            Shape::AtSurface => {
                let weight = self.between(0.05, 0.95);
                self.surface(&mut atoms, z_f, y, weight);
                let chosen = atoms[self.below(DEPTHS_PER_SURFACE)].0;
                let shift = z_f - chosen + self.sign() * x;
                atoms.iter_mut().for_each(|a| a.0 += shift);
                let other = self.between(0.02, 0.98);
                self.surface(&mut atoms, other, y, 1.0 - weight);
            }
            Shape::ThreeSurfaces => {
                let middle = z_f + self.sign() * x;
                atoms.extend([-1.0, 0.0, 1.0].map(|step| (middle + step * y, 1.0)));
            }
            Shape::Pole => {
                let z_f = self.at_pole(&mut atoms, x, y);
                return Input::new(atoms, z_f);
            }
            Shape::SqueezedRange | Shape::Scenes => {
                let middle = if self.sign() < 0.0 { y } else { 1.0 - y };
                for _ in 0..2 + self.below(3) {
                    let place = middle + x * self.between(-0.5, 0.5);
                    let weight = self.between(0.1, 1.0);
                    self.surface(&mut atoms, place, 0.02 * x, weight);
                }
                return Input::new(atoms, middle + x * self.between(-0.5, 0.5));
            }
        }
        Input::new(atoms, z_f)
    }

    /// Surfaces that are moved so that an orthogonal polynomial of degree 2, 3 or 4 vanishes at a distance x from z_f:
    /// there c_n of 4, 6 or 8 moments vanishes. Returns z_f.
    fn at_pole(&mut self, atoms: &mut Vec<(f64, f64)>, x: f64, thickness: f64) -> f64 {
        let degree = 2 + [0, 0, 1, 2][self.below(4)];
        for _ in 0..2 + self.below(3) {
            let (place, weight) = (self.between(0.25, 0.75), self.between(0.1, 1.0));
            self.surface(atoms, place, thickness, weight);
        }
        let total: f64 = atoms.iter().map(|a| a.1).sum();
        let wide: Vec<_> =
            atoms.iter().map(|&(z, w)| (DoubleDouble::from(z), DoubleDouble::from(w / total))).collect();
        let polynomials = Polynomials::new(&wide, degree);
        let value = |z: f64| polynomials.values(DoubleDouble::from(z))[degree].to_f64();
        // The roots lie between the outermost depths; a grid shows those that are far enough apart.
        const STEPS: usize = 64;
        let step = |i: usize| 0.2 + 0.6 * i as f64 / STEPS as f64;
        let brackets: Vec<usize> =
            (0..STEPS).filter(|&i| (value(step(i)) > 0.0) != (value(step(i + 1)) > 0.0)).collect();
        let root = match brackets.len() {
            0 => 0.5,
            count => {
                let bracket = brackets[self.below(count)];
                let (mut low, mut high) = (step(bracket), step(bracket + 1));
                let rising = value(high) > 0.0;
                for _ in 0..52 {
                    let middle = 0.5 * (low + high);
                    if (value(middle) > 0.0) == rising { high = middle } else { low = middle }
                }
                0.5 * (low + high)
            }
        };
        let z_f = on_grid(root);
        let shift = z_f - root + self.sign() * x;
        atoms.iter_mut().for_each(|a| a.0 += shift);
        z_f
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_distributions_on_the_unit_interval_at_their_knobs() {
        let mut draw = Draw(Random::substream(1, 2, 3));
        for shape in [
            Shape::OneSurface,
            Shape::TwoSurfaces,
            Shape::LightSurface,
            Shape::AtSurface,
            Shape::ThreeSurfaces,
            Shape::Pole,
            Shape::SqueezedRange,
        ] {
            for _ in 0..50 {
                let input = draw.input(shape, 1e-3, 1e-2);
                let total: f64 = input.atoms.iter().map(|a| a.1).sum();
                assert!((total - 1.0).abs() < 1e-12, "{shape:?}");
                assert!(input.atoms.iter().all(|a| (0.0..=1.0).contains(&a.0) && a.1 > 0.0), "{shape:?}");
                assert_eq!(f64::from(input.z_f as f32), input.z_f);
            }
        }
    }

    #[test]
    fn leading_coefficients_vanish_at_poles() {
        let mut draw = Draw(Random::substream(4, 0, 0));
        let mut near = 0;
        for _ in 0..100 {
            let input = draw.input(Shape::Pole, 1e-7, 0.05);
            let atoms: Vec<_> = input
                .atoms
                .iter()
                .map(|&(z, w)| (DoubleDouble::from(z) - DoubleDouble::from(input.z_f), DoubleDouble::from(w)))
                .collect();
            let p = |degree: usize, u: f64| {
                Polynomials::new(&atoms, degree).values(DoubleDouble::from(u))[degree].to_f64()
            };
            // A sign change within 2e-7 for one of the degrees.
            near += usize::from((2..=4).any(|degree| (p(degree, -2e-7) > 0.0) != (p(degree, 2e-7) > 0.0)));
        }
        assert!(near > 90, "{near}");
    }
}
