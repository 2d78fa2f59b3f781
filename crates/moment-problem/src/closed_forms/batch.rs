//! Many bounds at once in single precision, from separate arrays for each moment: see [`MomentBound::lower_bounds`].
//!
//! The bodies are written without branches so that the compiler vectorises them; each is compiled for several vector
//! widths and the widest that the machine has is chosen at run time. A result differs from the scalar function's by
//! rounding only, and depends neither on the vector width chosen (no fused operations are introduced) nor on the
//! position in the batch.

use super::moment_bound::MomentBound;

/// Moments as separate arrays ("structure of arrays"), all of one length.
struct Batch<'a, const M: usize> {
    /// `moments[k][i]` is moment k + 1 of element i.
    moments: [&'a [f32]; M],
    z_f: &'a [f32],
}

impl MomentBound {
    /// Lower bounds of many fragments, biased or not as the moments are: the fast path on one core.
    ///
    /// `moments[k][i]` is moment k + 1 of fragment i at `z_f[i]`, in the variable of [`MomentBound::bounds`]. Two, four
    /// and six moments on the line are vectorised, the others computed one after another. Results differ from
    /// [`MomentBound::bounds`] by rounding only and do not depend on `width`.
    ///
    /// # Panics
    /// If there are not [`MomentBound::order`] arrays, arrays have different lengths or the machine lacks that width.
    pub fn lower_bounds(self, width: VectorWidth, moments: &[&[f32]], z_f: &[f32], lower: &mut [f32]) {
        assert_eq!(moments.len(), self.order(), "moments for {}", self.name());
        let lengths = moments.iter().map(|moment| moment.len()).chain([z_f.len()]);
        assert!(lengths.into_iter().all(|length| length == lower.len()), "arrays of different lengths");
        match self {
            Self::Hamburger2 => chebyshev(width, &Batch::new(moments, z_f), lower),
            Self::Hamburger4 => hamburger4(width, &Batch::new(moments, z_f), lower),
            Self::Hamburger6 => hamburger6(width, &Batch::new(moments, z_f), lower),
            Self::Hamburger8 | Self::Hausdorff4 | Self::Trigonometric4 => {
                let mut b = [0.0; Self::MAX_ORDER];
                for (i, (lower, &z_f)) in lower.iter_mut().zip(z_f).enumerate() {
                    b.iter_mut().zip(moments).for_each(|(b, moment)| *b = moment[i]);
                    *lower = self.bounds(&b, z_f).lower;
                }
            }
        }
    }
}

impl<'a, const M: usize> Batch<'a, M> {
    fn new(moments: &[&'a [f32]], z_f: &'a [f32]) -> Self {
        Self { moments: std::array::from_fn(|k| moments[k]), z_f }
    }
}

/// A pivot counts as zero up to this many roundings of the moment it is computed from; see
/// [`hamburger`](crate::hamburger).
const PIVOT_FLOOR: f32 = 4.0 * f32::EPSILON;

/// Divisors are kept above this, so that no lane divides by zero.
const TINY: f32 = 1e-30;

/// a where the condition holds, else b, by masks: a branch here would keep the loop from being vectorised.
#[inline(always)]
fn select(condition: bool, a: f32, b: f32) -> f32 {
    let mask = u32::from(condition).wrapping_neg();
    f32::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
}

#[inline(always)]
fn clamp_unit(x: f32) -> f32 {
    // NaN compares false and becomes 0.
    let x = select(x > 0.0, x, 0.0);
    select(x < 1.0, x, 1.0)
}

/// Cantelli's inequality (variance shadow maps).
#[inline(always)]
fn chebyshev_lane([b1, b2]: [f32; 2], z_f: f32) -> f32 {
    let offset = z_f - b1;
    let variance = (b2 - b1 * b1).max(0.0);
    let square = offset * offset;
    let sum = variance + square;
    let far = select(sum > 0.0, square / sum.max(f32::MIN_POSITIVE), 1.0);
    select(offset > 0.0, clamp_unit(far), 0.0)
}

/// Hamburger 4 as in [`hamburger4`](crate::hamburger::hamburger4), with both degenerate cases folded in: a vanishing
/// second pivot is replaced by its rounding error, a vanishing first one selects Cantelli's inequality. Everything is
/// multiplied by the first pivot, so that three divisions remain.
#[inline(always)]
fn hamburger4_lane([b1, b2, b3, b4]: [f32; 4], z_f: f32) -> f32 {
    let d1 = b2 - b1 * b1;
    let regular = d1 > PIVOT_FLOOR * b2 + TINY;
    let d1 = select(regular, d1, 1.0);
    let e = b3 - b1 * b2;
    // d1 d2 and d1 P_2(z_f), d1 P_2'(z_f).
    let d2 = (d1 * (b4 - b2 * b2) - e * e).max(d1 * (0.25 * PIVOT_FLOOR * b4 + TINY));
    let p1 = z_f - b1;
    let p2 = d1 * (z_f * z_f - b2) - e * p1;
    let slope = d1 * (z_f + z_f) - e;
    let square = p1 * p1;
    let weight = d1 * d2;
    let q0 = weight + square * d2 + p2 * p2;
    let inverse = 1.0 / q0.max(f32::MIN_POSITIVE);
    // Half the linear and the constant coefficient of the monic w-quadratic.
    let half = 0.5 * (p1 * d2 + p2 * slope) * inverse;
    let constant = p2 * d1 * inverse;
    let root = (half * half - constant).max(0.0).sqrt();
    let far = select(half < 0.0, root - half, -(root + half));
    let near = constant / select(far == 0.0, 1.0, far);
    let (w1, w2) = (near.min(far), near.max(far));
    // One division serves the weight of the point in front and Cantelli's inequality.
    let variance = (b2 - b1 * b1).max(0.0);
    let cantelli = select(p1 > 0.0, square, 0.0);
    let numerator = select(regular, w1 * w1 * (p1 + (d1 + square) * w2), cantelli);
    let divisor = select(regular, w2 - w1, variance + square);
    let between = numerator / divisor.max(f32::MIN_POSITIVE);
    let behind = 1.0 - weight * inverse;
    let lower = select(w2 < 0.0, behind, between);
    let lower = select(w1 < 0.0, lower, 0.0);
    clamp_unit(select(regular, lower, between))
}

/// Hamburger 6: the cubic in w by the root of largest depressed size and deflation, as in [`roots`](super::roots).
#[inline(always)]
fn hamburger6_lane([b1, b2, b3, b4, b5, b6]: [f32; 6], z_f: f32) -> f32 {
    // LDL^T of the 4 x 4 Hankel matrix.
    let d1 = b2 - b1 * b1;
    let regular = d1 > PIVOT_FLOOR * b2 + TINY;
    let d1 = select(regular, d1, 1.0);
    let (e2, e3) = (b3 - b1 * b2, b4 - b1 * b3);
    let (l2, l3) = (e2 / d1, e3 / d1);
    let d2 = (b4 - b2 * b2 - l2 * e2).max(PIVOT_FLOOR * b4 + TINY);
    let f3 = b5 - b2 * b3 - l2 * e3;
    let m3 = f3 / d2;
    let d3 = (b6 - b3 * b3 - l3 * e3 - m3 * f3).max(PIVOT_FLOOR * b6 + TINY);
    // P_k at z_f + u as polynomials in u.
    let p1 = z_f - b1;
    let square = z_f * z_f;
    let (p2, p2_1) = (square - b2 - l2 * p1, z_f + z_f - l2);
    let p3 = square * z_f - b3 - l3 * p1 - m3 * p2;
    let p3_1 = 3.0 * square - l3 - m3 * p2_1;
    let p3_2 = 3.0 * z_f - m3;
    let (r1, r2, r3) = (p1 / d1, p2 / d2, p3 / d3);
    let q0 = 1.0 + p1 * r1 + p2 * r2 + p3 * r3;
    let inverse = 1.0 / q0;
    let a = (r1 + r2 * p2_1 + r3 * p3_1) * inverse;
    let b = (r2 + r3 * p3_2) * inverse;
    let c = r3 * inverse;
    let (w1, w2, w3) = cubic_lane(a, b, c);
    // Moments about z_f; E[w^j] stands for the moment of order 3 - j.
    let (s1, s2) = (-p1, select(regular, d1, 0.0) + p1 * p1);
    let s3 = b3 - z_f * (3.0 * b2 - z_f * (3.0 * b1 - z_f));
    // Weights of the points 1 / w by Lagrange's formula; those in front are summed.
    let weight = |w: f32, v1: f32, v2: f32| {
        let value = w * w * w * (s1 - (v1 + v2) * s2 + v1 * v2 * s3);
        let divisor = (w - v1) * (w - v2);
        value / select(divisor.abs() > TINY, divisor, f32::INFINITY)
    };
    let front = |w: f32, v1: f32, v2: f32| select(w < 0.0, weight(w, v1, v2), 0.0);
    let sum = front(w1, w2, w3) + front(w2, w1, w3) + front(w3, w1, w2);
    let all = (w1 < 0.0) & (w2 < 0.0) & (w3 < 0.0);
    let lower = clamp_unit(select(all, 1.0 - inverse, sum));
    select(regular, lower, chebyshev_lane([b1, b2], z_f))
}

#[inline(always)]
fn cubic_lane(a: f32, b: f32, c: f32) -> (f32, f32, f32) {
    let shift = a * (-1.0 / 3.0);
    let p = b + a * shift;
    let q = shift * (shift * (a + shift) + b) + c;
    let r = (p * (-1.0 / 3.0)).max(0.0).sqrt();
    let scale = 2.0 * r * r * r;
    let target = clamp_unit(q.abs() / scale.max(f32::MIN_POSITIVE));
    // cos(acos(target) / 3) by Newton's method from a chord; see `roots`.
    let mut x = 0.866_025_4 + 0.133_974_6 * target;
    x -= ((4.0 * x * x - 3.0) * x - target) / (12.0 * x * x - 3.0);
    x -= ((4.0 * x * x - 3.0) * x - target) / (12.0 * x * x - 3.0);
    let depressed = 2.0 * r * x;
    let mut first = shift + select(q > 0.0, -depressed, depressed);
    // One Newton step, then deflation from the end that does not cancel.
    let value = ((first + a) * first + b) * first + c;
    let slope = (3.0 * first + 2.0 * a) * first + b;
    first -= value / select(slope == 0.0, f32::INFINITY, slope);
    let safe = select(first == 0.0, 1.0, first);
    let backward_rest = -(c / safe);
    let backward = (first * first * first).abs() > c.abs();
    let linear = select(backward, (backward_rest - b) / safe, a + first);
    let rest = select(backward, backward_rest, b + first * linear);
    let half = 0.5 * linear;
    let root = (half * half - rest).max(0.0).sqrt();
    let far = select(half < 0.0, root - half, -(root + half));
    let near = rest / select(far == 0.0, 1.0, far);
    (first, near, far)
}

/// Elements handled together: several vectors of any width, small enough to stay in the first-level cache.
const BLOCK: usize = 128;

/// Vector instructions that a batch may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VectorWidth {
    /// Whatever the build allows (on x86-64: four lanes).
    Portable,
    /// Eight lanes.
    Avx2,
    /// Sixteen lanes.
    Avx512,
}

impl VectorWidth {
    /// The widths that this machine has, narrowest first.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut)]
        let mut widths = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if std::is_x86_feature_detected!("avx2") {
                widths.push(Self::Avx2);
            }
            if std::is_x86_feature_detected!("avx512f")
                && std::is_x86_feature_detected!("avx512vl")
                && std::is_x86_feature_detected!("avx512dq")
                && std::is_x86_feature_detected!("avx512bw")
            {
                widths.push(Self::Avx512);
            }
        }
        widths
    }

    /// The widest that this machine has (looked up once).
    pub fn widest() -> Self {
        static WIDEST: std::sync::OnceLock<VectorWidth> = std::sync::OnceLock::new();
        *WIDEST.get_or_init(|| Self::available().pop().unwrap_or(Self::Portable))
    }
}

macro_rules! batch {
    ($name:ident, $order:literal, $lane:ident) => {
        fn $name(width: VectorWidth, batch: &Batch<'_, $order>, lower: &mut [f32]) {
            #[inline(always)]
            fn body(batch: &Batch<'_, $order>, lower: &mut [f32]) {
                // A local block of results cannot overlap the inputs, which spares the vectoriser its run-time checks
                // (it gives up on those of six arrays).
                let (blocks, rest) = lower.as_chunks_mut::<BLOCK>();
                let z_f = batch.z_f.as_chunks::<BLOCK>();
                let moments = batch.moments.map(|moment| moment.as_chunks::<BLOCK>());
                for (j, out) in blocks.iter_mut().enumerate() {
                    let z_f = &z_f.0[j];
                    let moments = moments.map(|moment| &moment.0[j]);
                    let mut results = [0.0; BLOCK];
                    for i in 0..BLOCK {
                        results[i] = $lane(moments.map(|moment| moment[i]), z_f[i]);
                    }
                    *out = results;
                }
                for (i, out) in rest.iter_mut().enumerate() {
                    *out = $lane(moments.map(|moment| moment.1[i]), z_f.1[i]);
                }
            }
            assert!(
                width == VectorWidth::Portable || VectorWidth::available().contains(&width),
                "this machine has no {width:?}"
            );
            match width {
                VectorWidth::Portable => body(batch, lower),
                #[cfg(target_arch = "x86_64")]
                VectorWidth::Avx2 => {
                    #[target_feature(enable = "avx2")]
                    fn avx2(batch: &Batch<'_, $order>, lower: &mut [f32]) {
                        body(batch, lower);
                    }
                    // SAFETY: the machine has the feature, as asserted above.
                    unsafe { avx2(batch, lower) }
                }
                #[cfg(target_arch = "x86_64")]
                VectorWidth::Avx512 => {
                    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
                    fn avx512(batch: &Batch<'_, $order>, lower: &mut [f32]) {
                        body(batch, lower);
                    }
                    // SAFETY: the machine has the features, as asserted above.
                    unsafe { avx512(batch, lower) }
                }
                #[cfg(not(target_arch = "x86_64"))]
                VectorWidth::Avx2 | VectorWidth::Avx512 => body(batch, lower),
            }
        }
    };
}

batch!(chebyshev, 2, chebyshev_lane);
batch!(hamburger4, 4, hamburger4_lane);
batch!(hamburger6, 6, hamburger6_lane);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_forms::hamburger::hamburger;

    const VECTORISED: [MomentBound; 3] =
        [MomentBound::Hamburger2, MomentBound::Hamburger4, MomentBound::Hamburger6];

    /// Moments of three to six surfaces, biased as single precision needs it, and awkward ones among them.
    fn inputs(count: usize) -> ([Vec<f32>; 6], Vec<f32>) {
        let mut state = 12345u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let mut moments: [Vec<f32>; 6] = Default::default();
        let mut z_f = Vec::new();
        for _ in 0..count {
            let atoms = 1 + (unit() * 6.0) as usize;
            let depths: Vec<f64> = (0..atoms).map(|_| 2.0 * unit() - 1.0).collect();
            let alpha = 1e-3;
            for (k, moment) in moments.iter_mut().enumerate() {
                let order = k as i32 + 1;
                let mean = depths.iter().map(|z| z.powi(order)).sum::<f64>() / atoms as f64;
                // Bias towards the moments of the uniform distribution on [-1, 1].
                let uniform = if order % 2 == 0 { 1.0 / f64::from(order + 1) } else { 0.0 };
                moment.push(((1.0 - alpha) * mean + alpha * uniform) as f32);
            }
            z_f.push((2.0 * unit() - 1.0) as f32);
        }
        (moments, z_f)
    }

    #[test]
    fn batches_agree_with_the_scalar_functions_in_double_precision() {
        let (moments, z_f) = inputs(4003);
        let columns = moments.each_ref().map(Vec::as_slice);
        let mut out = [vec![0.0; 4003], vec![0.0; 4003], vec![0.0; 4003]];
        for (out, bound) in out.iter_mut().zip(VECTORISED) {
            bound.lower_bounds(VectorWidth::widest(), &columns[..bound.order()], &z_f, out);
        }
        let mut errors = [vec![], vec![], vec![]];
        for i in 0..z_f.len() {
            let b: [f64; 6] = std::array::from_fn(|k| f64::from(moments[k][i]));
            let z = f64::from(z_f[i]);
            let exact = [
                hamburger(&[b[0], b[1]], z).lower,
                hamburger(&[b[0], b[1], b[2], b[3]], z).lower,
                hamburger(&b, z).lower,
            ];
            for k in 0..3 {
                assert!((0.0..=1.0).contains(&out[k][i]), "{} at {i} of method {k}", out[k][i]);
                errors[k].push((f64::from(out[k][i]) - exact[k]).abs());
            }
        }
        for (errors, limit) in errors.iter_mut().zip([1e-5, 2e-3, 2e-2]) {
            errors.sort_by(f64::total_cmp);
            let (median, high) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
            println!("median {median:e}, 99 % {high:e}, max {:e}", errors[errors.len() - 1]);
            assert!(median < 1e-5 && high < limit, "median {median}, 99 % {high}, limit {limit}");
        }
    }

    #[test]
    fn all_vector_widths_give_the_same_bits() {
        let (moments, z_f) = inputs(1003);
        let moments = moments.each_ref().map(Vec::as_slice);
        let results: Vec<Vec<u32>> = VectorWidth::available()
            .into_iter()
            .map(|width| {
                let mut lower = vec![0.0; z_f.len()];
                MomentBound::Hamburger6.lower_bounds(width, &moments, &z_f, &mut lower);
                lower.iter().map(|g| g.to_bits()).collect()
            })
            .collect();
        assert!(results.iter().all(|result| *result == results[0]));
    }

    #[test]
    fn bounds_without_lanes_are_those_of_the_scalar_functions() {
        let (moments, z_f) = inputs(50);
        let columns = moments.each_ref().map(|moment| &moment[..]);
        for bound in [MomentBound::Hausdorff4, MomentBound::Trigonometric4] {
            let mut lower = vec![f32::NAN; z_f.len()];
            bound.lower_bounds(VectorWidth::Portable, &columns[..4], &z_f, &mut lower);
            for (i, &g) in lower.iter().enumerate() {
                let b = columns.map(|moment| moment[i]);
                assert_eq!(g.to_bits(), bound.bounds(&b, z_f[i]).lower.to_bits(), "{bound:?} at {i}");
            }
        }
    }

    #[test]
    fn degenerate_lanes_are_defined() {
        let nasty = [0.0, 1.0, 0.5, f32::NAN, f32::INFINITY, -1.0, 1e-38, 3e38];
        let count = nasty.len();
        for shift in 0..count {
            let z_f: Vec<f32> = (0..count).map(|i| nasty[(i + shift) % count]).collect();
            for bound in MomentBound::ALL {
                let mut lower = vec![f32::NAN; count];
                let moments = vec![&nasty[..]; bound.order()];
                bound.lower_bounds(VectorWidth::widest(), &moments, &z_f, &mut lower);
                assert!(lower.iter().all(|g| (0.0..=1.0).contains(g)), "{bound:?} {lower:?}");
            }
        }
    }
}
