//! Prefiltered single scattering: prefix sums of an encoded rectified map, one look-up a view ray (BHS16 section 2).

use moment_problem::arithmetic::Real;
use rayon::prelude::*;
use shadow_filtering::{ChannelMap, FilteringError, Precision, Technique};

use super::{RectifiedMap, SingleScattering, ViewRay, adaptive_blend, prefix_means, relative_weights};
use crate::Estimate;
use std::f64::consts::TAU;

/// How the bounds on the shadowed share become an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blending {
    /// The same beta for all rays: 0 the lower bound, too bright, 1 the upper one, too dark.
    Fixed(f64),
    /// By the angle between ray and light, [`adaptive_blend`].
    Adaptive,
}

/// What a texel of the rectified map holds and how it is read.
#[derive(Clone, Copy)]
pub struct StoredPrefixes<'a> {
    /// Functions of depth, transform, number format, and the bound.
    pub technique: &'a Technique,
    /// How bounds are blended.
    pub blending: Blending,
    /// Depths are stored as margin + (1 - 2 margin) depth. Sines and cosines take depth 0 for depth 1, where clamped depths
    /// lie.
    pub margin: f64,
}

impl StoredPrefixes<'_> {
    fn depth(&self, depth: f64) -> f64 {
        self.margin + (1.0 - 2.0 * self.margin) * depth
    }
}

/// A rectified map after its prefix sums, for one medium.
pub struct Prefiltered<'a, P> {
    stored: StoredPrefixes<'a>,
    rectified: &'a RectifiedMap,
    /// One or two, with the inverse sine of the inclination that its spacing is right for, a row each.
    layers: Vec<(ChannelMap<P>, Vec<f64>)>,
}

/// The exact distribution of each prefix in place of anything that is stored: what rectification and spacing cost alone.
pub struct ExactPrefixes<'a> {
    rectified: &'a RectifiedMap,
    /// As for [`Prefiltered`]; none for the ray's own spacing.
    layers: Vec<Vec<f64>>,
}

/// Texels that a ray's end lies between.
struct LookUp {
    /// Azimuth rows with their shares.
    rows: [(usize, f64); 2],
    /// Prefixes with their shares.
    columns: [(usize, f64); 2],
    /// Normalised depth of the ray.
    depth: f64,
    /// 1 / sin of its inclination.
    inverse_sine: f64,
    /// Distance at which the look-up ends.
    end: f64,
}

/// Numbers that coordinates are computed with.
trait Angle: Real {
    /// The angle of (x, y) to the positive x axis.
    fn angle(y: Self, x: Self) -> Self;
}

impl Angle for f32 {
    fn angle(y: Self, x: Self) -> Self {
        y.atan2(x)
    }
}

impl Angle for f64 {
    fn angle(y: Self, x: Self) -> Self {
        y.atan2(x)
    }
}

impl LookUp {
    /// In the precision of what is looked up: a shader has single coordinates, too.
    fn of<P: Precision>(rectified: &RectifiedMap, view: &SingleScattering<'_>, ray: &ViewRay) -> Self {
        // Double precision rounds far below this.
        const SINGLE: f64 = 1e-10;
        if P::EPSILON > SINGLE {
            Self::new::<f32>(rectified, view, ray)
        } else {
            Self::new::<f64>(rectified, view, ray)
        }
    }

    fn new<F: Angle>(rectified: &RectifiedMap, view: &SingleScattering<'_>, ray: &ViewRay) -> Self {
        let rectification = &rectified.rectification;
        let [columns, rows] = rectification.size;
        let number = F::from_f64;
        let [x, y, z] = view.axes.direction(ray.direction).map(number);
        // A unit vector's r is its sine.
        let sine = (x * x + y * y).sqrt();
        let inverse_sine = 1.0 / sine.to_f64();
        let end = ray.length.min(rectification.r_max * inverse_sine);
        // Prefix u ends at the outer border of texel u.
        let r = number(ray.length.min(f64::from(f32::MAX))) * sine;
        let r = r.min(number(rectification.r_max));
        let place = (r / number(rectification.column_width()) - F::one()).to_f64();
        let place = if place > 0.0 { place.min((columns - 1) as f64) } else { 0.0 };
        let (column, share) = (place.floor() as usize, place.fract());
        let columns = [(column, 1.0 - share), ((column + 1).min(columns - 1), share)];
        let azimuth = F::angle(y, x) - number(rectification.phi_start);
        let turn = number(TAU);
        // phi_start lies in [0, 2 pi), the angle in [-pi, pi].
        let mut offset = azimuth;
        while offset < F::zero() {
            offset = offset + turn;
        }
        let place = (offset * number(rows as f64 / rectification.phi_extent)).to_f64() - 0.5;
        let (first, share) = (place.floor(), place - place.floor());
        let row = |offset: f64| {
            let row = first + offset;
            if rectification.wraps() {
                row.rem_euclid(rows as f64) as usize
            } else {
                row.clamp(0.0, (rows - 1) as f64) as usize
            }
        };
        let [least, most] = rectification.flipped;
        let depth = (F::angle(sine, -z) - number(least)) * number(1.0 / (most - least));
        Self {
            rows: [(row(0.0), 1.0 - share), (row(1.0), share)],
            columns,
            depth: depth.clamp_unit().to_f64(),
            inverse_sine,
            end,
        }
    }

    /// The lit share of the ray from the shadowed shares of one or two layers.
    fn answer(&self, view: &SingleScattering<'_>, ray: &ViewRay, layers: &[(f64, f64)]) -> f64 {
        let shadowed = match layers {
            [(near, a), (far, b)] if a != b => {
                let share = ((self.inverse_sine - a) / (b - a)).clamp(0.0, 1.0);
                near + share * (far - near)
            }
            [first, ..] => first.0,
            [] => 0.0,
        };
        view.joined(ray, (1.0 - shadowed).clamp(0.0, 1.0), self.end, true)
    }

    /// The mean of 1 / sin over both rows.
    fn inverse_sine_of(&self, inverse_sines: &[f64]) -> f64 {
        self.rows.iter().map(|&(row, share)| share * inverse_sines[row]).sum()
    }
}

impl<'a, P: Precision> Prefiltered<'a, P> {
    /// Encodes every texel, sums along rows, and rounds what is stored to the technique's format.
    ///
    /// # Errors
    /// [`FilteringError::NotFinite`] where a value is no number.
    pub fn new(
        stored: StoredPrefixes<'a>,
        rectified: &'a RectifiedMap,
        view: &SingleScattering<'_>,
        inverse_sines: &[Vec<f64>],
    ) -> Result<Self, FilteringError> {
        let layers = inverse_sines
            .iter()
            .map(|of_rows| Ok((prefix_map(stored, rectified, view, of_rows)?, of_rows.clone())));
        Ok(Self { stored, rectified, layers: layers.collect::<Result<_, FilteringError>>()? })
    }

    /// The map that is looked up, of the first spacing.
    pub fn map(&self) -> Option<&ChannelMap<P>> {
        self.layers.first().map(|(map, _)| map)
    }

    /// Filterable values at the end of a ray, as the bound gets them, and the ray's depth.
    pub fn values(&self, view: &SingleScattering<'_>, ray: &ViewRay) -> Option<(Vec<P>, f64)> {
        let at = LookUp::of::<P>(self.rectified, view, ray);
        let (map, _) = self.layers.first()?;
        Some((self.restored(&at, map), self.stored.depth(at.depth)))
    }

    fn restored(&self, at: &LookUp, map: &ChannelMap<P>) -> Vec<P> {
        let mut mean = vec![P::zero(); map.channels()];
        for (row, v) in at.rows {
            for (column, w) in at.columns {
                let weight = P::from_f64(v) * P::from_f64(w);
                let texel = map.texel(column, row);
                mean.iter_mut().zip(texel).for_each(|(sum, &value)| *sum = *sum + weight * value);
            }
        }
        let mut b = vec![P::zero(); mean.len()];
        self.stored.technique.restore(&mean, &mut b);
        b
    }

    /// The same with another technique in place of the bound that reads what is stored: another moment bias or blend.
    ///
    /// # Errors
    /// As [`Technique::bounds`].
    pub fn read_by(
        &self,
        technique: &Technique,
        view: &SingleScattering<'_>,
        ray: &ViewRay,
    ) -> Result<f64, FilteringError> {
        let at = LookUp::of::<P>(self.rectified, view, ray);
        let beta = match self.stored.blending {
            Blending::Fixed(beta) => beta,
            Blending::Adaptive => adaptive_blend(view.scattering_cosine(ray)),
        };
        let of_layer = |(map, inverse_sines): &(ChannelMap<P>, Vec<f64>)| {
            let b = self.restored(&at, map);
            let bounds = technique.bounds(&b, P::from_f64(self.stored.depth(at.depth)))?;
            let shadowed = bounds.blend(P::from_f64(beta)).to_f64();
            Ok((shadowed, at.inverse_sine_of(inverse_sines)))
        };
        let layers = self.layers.iter().map(of_layer).collect::<Result<Vec<_>, FilteringError>>()?;
        Ok(at.answer(view, ray, &layers))
    }
}

fn prefix_map<P: Precision>(
    stored: StoredPrefixes<'_>,
    rectified: &RectifiedMap,
    view: &SingleScattering<'_>,
    inverse_sines: &[f64],
) -> Result<ChannelMap<P>, FilteringError> {
    let rectification = &rectified.rectification;
    let [columns, rows] = rectification.size;
    let technique = stored.technique;
    let channels = technique.channels();
    let format = technique.encoding().format();
    let mut data = vec![P::zero(); columns * rows * channels];
    data.par_chunks_mut(columns * channels).enumerate().for_each_init(
        || (vec![P::zero(); channels], vec![P::zero(); channels]),
        |(b, mean), (row, out)| {
            for (texel, values) in rectified.row(row).iter().zip(out.chunks_exact_mut(channels)) {
                mean.fill(P::zero());
                for (&depth, &weight) in texel.depths.iter().zip(&texel.weights) {
                    if weight == 0.0 {
                        continue;
                    }
                    technique.evaluate(P::from_f64(stored.depth(depth)), b);
                    let weight = P::from_f64(weight);
                    mean.iter_mut().zip(&*b).for_each(|(sum, &value)| *sum = *sum + weight * value);
                }
                P::transform(technique, mean, values);
            }
            let delta = rectification.column_width() * inverse_sines[row];
            prefix_means(out, channels, relative_weights(&view.medium, delta, columns));
            out.iter_mut().for_each(|value| *value = value.rounded(format));
        },
    );
    ChannelMap::new(columns, rows, channels, data)
}

impl<'a> ExactPrefixes<'a> {
    /// Of a rectified map with the spacings of [`super::Spacing::inverse_sines`].
    pub fn new(rectified: &'a RectifiedMap, layers: Vec<Vec<f64>>) -> Self {
        Self { rectified, layers }
    }

    fn shadowed(&self, view: &SingleScattering<'_>, at: &LookUp, inverse_sines: Option<&[f64]>) -> f64 {
        let width = self.rectified.rectification.column_width();
        let of_row = |row: usize| {
            let delta = width * inverse_sines.map_or(at.inverse_sine, |all| all[row]);
            let texels = self.rectified.row(row);
            let last = at.columns[1].0;
            let weights = relative_weights(&view.medium, delta, last + 1);
            let (mut sum, mut total, mut answer) = (0.0, 0.0, 0.0);
            for (u, (texel, weight)) in texels.iter().zip(weights).enumerate() {
                let before = (0..2).filter(|&k| texel.depths[k] < at.depth).map(|k| texel.weights[k]);
                sum += weight * before.sum::<f64>();
                total += weight;
                for (column, share) in at.columns {
                    if column == u {
                        answer += share * sum / total;
                    }
                }
            }
            answer
        };
        at.rows.iter().map(|&(row, share)| share * of_row(row)).sum()
    }
}

impl<P: Precision> Estimate<SingleScattering<'_>> for Prefiltered<'_, P> {
    /// The lit share.
    fn estimate(&self, view: &SingleScattering<'_>, ray: &ViewRay) -> Result<f64, FilteringError> {
        self.read_by(self.stored.technique, view, ray)
    }
}

impl Estimate<SingleScattering<'_>> for ExactPrefixes<'_> {
    /// The lit share.
    fn estimate(&self, view: &SingleScattering<'_>, ray: &ViewRay) -> Result<f64, FilteringError> {
        let at = LookUp::new::<f64>(self.rectified, view, ray);
        if self.layers.is_empty() {
            let shadowed = self.shadowed(view, &at, None);
            return Ok(at.answer(view, ray, &[(shadowed, 0.0)]));
        }
        let of_layer = |layer: &Vec<f64>| (self.shadowed(view, &at, Some(layer)), at.inverse_sine_of(layer));
        let layers: Vec<(f64, f64)> = self.layers.iter().map(of_layer).collect();
        Ok(at.answer(view, ray, &layers))
    }
}
