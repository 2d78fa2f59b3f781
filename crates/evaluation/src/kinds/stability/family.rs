//! Inputs that are hard in a known way.

use super::exact::Polynomials;
use super::input::{Input, on_grid};
use super::settings::Shape;
use moment_problem::arithmetic::DoubleDouble;
use random_stream::Random;

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
