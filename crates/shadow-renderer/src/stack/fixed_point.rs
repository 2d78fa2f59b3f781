//! Planes over the texel grid in 64-bit fixed point, and the alpha masks read through them.
//!
//! A float plane `d0 + gx * x + gy * y` may be contracted to fused operations by a shader compiler, and WGSL
//! cannot forbid that. Integers leave no such freedom: the CPU in `i64` and the shader in pairs of `u32` compute
//! the same bits on every device.

use scenes::{AlphaMask, InvalidScene, Scene};

use crate::stack::veils::Casters;

/// Fractional bits of a plane.
const PLANE_BITS: u32 = 40;
/// Fractional bits of the planes of a [`Quotient`]: numerator and denominator lie near 1, and their errors grow with the
/// ratio of the farthest to the nearest depth.
const QUOTIENT_BITS: u32 = 48;
/// Depths are multiples of 2^-24 in [0, 1], exact in `f32`.
pub(crate) const DEPTH_BITS: u32 = 24;
/// Fractional bits that a depth loses when it is stored.
const DEPTH_SHIFT: u32 = PLANE_BITS - DEPTH_BITS;

/// A value, linear over texels: `base` at a reference texel's centre, plus a step per texel in x and y.
/// All arithmetic wraps, as it does in the shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Zeroable)]
pub(crate) struct Plane {
    pub base: i64,
    pub step: [i64; 2],
}

impl Plane {
    pub(crate) fn new(base: f64, step: [f64; 2]) -> Self {
        Self::with_bits(base, step, PLANE_BITS)
    }

    /// Numerator or denominator of a [`Quotient`].
    pub(crate) fn of_quotient(base: f64, step: [f64; 2]) -> Self {
        Self::with_bits(base, step, QUOTIENT_BITS)
    }

    fn with_bits(base: f64, step: [f64; 2], bits: u32) -> Self {
        let fixed = |v: f64| (v * (1u64 << bits) as f64 + f64::copysign(0.5, v)) as i64;
        Self { base: fixed(base), step: step.map(fixed) }
    }

    /// Value `x`, `y` texels from the reference texel.
    #[inline]
    pub(crate) fn at(&self, x: u32, y: u32) -> i64 {
        let along = |step: i64, n: u32| step.wrapping_mul(i64::from(n));
        self.base.wrapping_add(along(self.step[0], x)).wrapping_add(along(self.step[1], y))
    }

    /// The values along a row from texel `x`, `y` on as depths clamped to `low..=high`.
    #[inline]
    pub(crate) fn depths_from(&self, x: u32, y: u32, low: u32, high: u32) -> Depths {
        let half = 1 << (DEPTH_SHIFT - 1);
        let [low, high] = [low, high].map(i64::from);
        Depths { rounded: self.at(x, y).wrapping_add(half), step: self.step[0], low, high }
    }

    /// The value at a texel as a number. In perspective the value is divided by a weight.
    #[inline]
    pub(crate) fn number_at(&self, weight: Option<&Self>, x: u32, y: u32) -> f64 {
        match weight.map(|weight| weight.at(x, y)) {
            None => self.at(x, y) as f64 / (1u64 << PLANE_BITS) as f64,
            // A sliver's far side may have none.
            Some(weight) => self.at(x, y) as f64 / weight.max(1) as f64,
        }
    }

    /// The index of the texel that holds the value in a repeating row of `size` texels, `size` < 2^16. In perspective the
    /// value is divided by a weight.
    #[inline]
    pub(crate) fn wrapped_texel_at(&self, weight: Option<&Self>, x: u32, y: u32, size: u32) -> u32 {
        let fraction = match weight {
            None => (self.at(x, y) >> (PLANE_BITS - 32)) as u32,
            Some(weight) => Quotient { value: self.at(x, y), weight: weight.at(x, y) }.fraction(),
        };
        ((u64::from(fraction) * u64::from(size)) >> 32) as u32
    }
}

/// What is linear over texels in perspective are values divided by the distance, and the reciprocal distance itself, the
/// weight; the value is the quotient of both. It is rounded as a whole number is, so that no device disagrees.
#[derive(Clone, Copy)]
pub(crate) struct Quotient {
    pub value: i64,
    pub weight: i64,
}

impl Quotient {
    /// As a depth in units of 2^-24, rounded and clamped; `high` where the weight, that of a sliver's far side, is none.
    #[inline]
    pub(crate) fn depth(self, low: u32, high: u32) -> u32 {
        let Self { value, weight } = self;
        if weight <= 0 || value >= weight {
            return high;
        }
        if value <= 0 {
            return low;
        }
        // Below 2^25 as the quotient is below 1; half a unit more rounds.
        let doubled = ((value as u128) << (DEPTH_BITS + 1)) / weight as u128;
        (((doubled + 1) >> 1) as u32).max(low).min(high)
    }

    /// The first 32 bits after the binary point; 0 without a weight.
    #[inline]
    pub(crate) fn fraction(self) -> u32 {
        if self.weight <= 0 {
            return 0;
        }
        let rest = self.value.rem_euclid(self.weight);
        (((rest as u128) << 32) / self.weight as u128) as u32
    }
}

/// Depths of neighbouring texels.
#[derive(Clone, Copy)]
pub(crate) struct Depths {
    rounded: i64,
    step: i64,
    low: i64,
    high: i64,
}

impl Depths {
    /// This texel's depth in units of 2^-24, rounded and clamped; goes on to the right neighbour.
    #[inline]
    pub(crate) fn next(&mut self) -> u32 {
        let depth = (self.rounded >> DEPTH_SHIFT).max(self.low).min(self.high) as u32;
        self.rounded = self.rounded.wrapping_add(self.step);
        depth
    }
}

/// Depth in [0, 1] as stored in a stack.
#[inline]
pub(crate) fn depth_from_fixed(depth: u32) -> f32 {
    depth as f32 / (1u32 << DEPTH_BITS) as f32
}

/// Texture coordinates of an alpha-tested triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaskPlanes {
    pub u: Plane,
    pub v: Plane,
    /// Index into [`Masks::entries`].
    pub mask: u32,
}

/// Place of one mask in [`Masks::bits`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MaskEntry {
    pub width: u32,
    pub height: u32,
    pub first_bit: u32,
}

/// All alpha masks of a scene after the alpha test, one bit a texel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Masks {
    pub bits: Vec<u32>,
    pub entries: Vec<MaskEntry>,
    /// For each material the index of its mask, or `u32::MAX`.
    pub of_material: Vec<u32>,
}

impl Masks {
    pub(crate) fn new(scene: &Scene) -> Result<Self, InvalidScene> {
        Self::of_casters(scene, Casters::Opaque)
    }

    /// Translucent surfaces that are blended are there wherever they are not clear, which no mask tells.
    pub(crate) fn of_casters(scene: &Scene, casters: Casters) -> Result<Self, InvalidScene> {
        let mut masks = Self::default();
        let mut first_bit = 0u64;
        for material in &scene.materials {
            let is_tested = match (casters, &material.opacity) {
                (Casters::Opaque, _) | (Casters::Translucent(_), None) => true,
                (Casters::Translucent(_), Some(opacity)) => opacity.tested,
            };
            let Some(mask) = material.mask.as_ref().filter(|_| is_tested) else {
                masks.of_material.push(u32::MAX);
                continue;
            };
            masks.of_material.push(masks.entries.len() as u32);
            let fail = |what: String| {
                scene.inconsistent(format!("alpha mask of material '{}' {what}", material.name))
            };
            if let Some(fault) = mask.fault() {
                return Err(fail(fault));
            }
            let AlphaMask { width, height, ref alpha, cutoff } = **mask;
            let end = first_bit + alpha.len() as u64;
            // The shader addresses bits with 32 bits and at most 128 MiB.
            if end > 1 << 30 {
                return Err(fail(format!("brings all masks to {end} texels, more than 2^30")));
            }
            masks.entries.push(MaskEntry { width, height, first_bit: first_bit as u32 });
            masks.bits.resize(end.div_ceil(32) as usize, 0);
            for (bit, &a) in (first_bit..).zip(alpha) {
                if a >= cutoff {
                    masks.bits[(bit / 32) as usize] |= 1 << (bit % 32);
                }
            }
            first_bit = end;
        }
        Ok(masks)
    }

    /// Alpha test `x`, `y` texels from the planes' reference texel; in perspective they are divided by a weight.
    #[inline]
    pub(crate) fn passes(&self, planes: &MaskPlanes, weight: Option<&Plane>, x: u32, y: u32) -> bool {
        let entry = self.entries[planes.mask as usize];
        let u = planes.u.wrapped_texel_at(weight, x, y, entry.width);
        let v = planes.v.wrapped_texel_at(weight, x, y, entry.height);
        let bit = entry.first_bit + v * entry.width + u;
        self.bits[(bit / 32) as usize] >> (bit % 32) & 1 == 1
    }
}
