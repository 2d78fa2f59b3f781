//! A filterable shadow map as a value (MSM15 section 3): a basis b(z), a storage encoding, and a bound G(b, z_f).

use crate::basis::AnyBasis;
use crate::bound::{AnyBound, RealTime, unit};
use crate::depth_map::{ChannelMap, DepthMap};
use crate::encoding::SingleEncoding;
use crate::error::FilteringError;
use moment_problem::arithmetic::Real;
use moment_problem::hamburger::Pair;
use quantization::{Encoding, NumberFormat};
use rayon::prelude::*;

/// Most values that a technique stores: 64 coefficients or layers of two channels.
pub(crate) const MAX_CHANNELS: usize = 128;

/// A basis, an encoding and a bound. b(z) of each texel's depth is stored, filtered linearly, restored and shaded.
///
/// Every method that computes is generic over the [`Precision`]: `f32` is what a shader does, `f64` leaves only the
/// error of storage, or none where nothing is stored.
pub struct Technique {
    basis: Box<dyn AnyBasis>,
    encoding: Encoding,
    single: Option<SingleEncoding>,
    bound: Box<dyn AnyBound>,
}

impl Technique {
    /// Combines the three.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for a transform of another order.
    pub fn new(
        basis: Box<dyn AnyBasis>,
        encoding: Encoding,
        bound: Box<dyn AnyBound>,
    ) -> Result<Self, FilteringError> {
        let (channels, order) = (basis.channels(), encoding.transform().order());
        if channels != order {
            let reason = format!("{} stores {channels} values", bound.name());
            return Err(FilteringError::parameter("order of the transform", order, reason));
        }
        let single = SingleEncoding::new(encoding.transform());
        Ok(Self { basis, encoding, single, bound })
    }

    /// The technique with its parameters.
    pub fn name(&self) -> String {
        self.bound.name()
    }

    /// Number m of stored values.
    pub fn channels(&self) -> usize {
        self.basis.channels()
    }

    /// What becomes of b(z) in a texel.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// The guess G.
    pub fn bound(&self) -> &dyn AnyBound {
        self.bound.as_ref()
    }

    /// Memory of a texel, with bits that the texture wastes.
    pub fn bits_per_texel(&self) -> usize {
        self.encoding.format().bits_per_texel(self.channels())
    }

    /// Whether G <= F_Z(z_f) is a theorem about this technique.
    pub fn is_lower_bound(&self) -> bool {
        self.bound.is_lower_bound()
    }

    /// The bound as a shader computes it; `None` where a linear program is solved.
    pub fn real_time(&self) -> Option<&dyn RealTime> {
        self.bound.real_time()
    }

    /// The transform as a shader computes it; `None` where values are stored as they are.
    pub(crate) fn single_encoding(&self) -> Option<&SingleEncoding> {
        self.single.as_ref()
    }

    /// Operations of [`Technique::restore`]: a product and a sum for each factor that is not zero.
    pub fn decode_operations(&self) -> u64 {
        self.single_encoding().map_or(0, SingleEncoding::operations)
    }

    /// b(z) of a depth, which is clamped to \[0, 1\]. `out` has [`Technique::channels`] values.
    pub fn evaluate<P: Precision>(&self, depth: P, out: &mut [P]) {
        P::evaluate(self.basis.as_ref(), unit(depth), out);
    }

    /// What a texel of one depth holds: b(z), transformed and rounded to the format.
    pub fn encode<P: Precision>(&self, depth: P, out: &mut [P]) {
        if self.single.is_none() {
            self.evaluate(depth, out);
        } else {
            let mut b = [P::zero(); MAX_CHANNELS];
            let b = &mut b[..out.len()];
            self.evaluate(depth, b);
            P::transform(self, b, out);
        }
        out.iter_mut().for_each(|value| *value = value.rounded(self.encoding.format()));
    }

    /// The filterable values of a mean of texels.
    pub fn restore<P: Precision>(&self, stored: &[P], b: &mut [P]) {
        P::restore(self, stored, b);
    }

    /// G(b, z_f) in \[0, 1\]: the approximate share of the kernel in front of z_f, which is clamped to \[0, 1\].
    ///
    /// # Errors
    /// Only techniques that solve a linear program fail; closed forms always have an answer.
    pub fn shade<P: Precision>(&self, b: &[P], z_f: P) -> Result<P, FilteringError> {
        P::shade(self.bound.as_ref(), b, z_f)
    }

    /// Both bounds before they are blended; twice [`Technique::shade`] where there is no upper one.
    ///
    /// # Errors
    /// As [`Technique::shade`].
    pub fn bounds<P: Precision>(&self, b: &[P], z_f: P) -> Result<Pair<P>, FilteringError> {
        P::bounds(self.bound.as_ref(), b, z_f)
    }

    /// A shadow map as it is stored, before filtering.
    ///
    /// # Errors
    /// None for depths in \[0, 1\].
    pub fn store<P: Precision>(&self, map: &DepthMap) -> Result<ChannelMap<P>, FilteringError> {
        each_texel(map, self.channels(), |depth, texel| self.encode(P::from_f64(f64::from(depth)), texel))
    }

    /// Rejects what no frame can be made with: bounds without a shader, and fixed point, which belongs into summed-area
    /// tables.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`].
    pub fn check_real_time(&self) -> Result<(), FilteringError> {
        if self.real_time().is_none() {
            return Err(FilteringError::parameter("bound", self.name(), "cannot be computed by a shader"));
        }
        match self.encoding.format() {
            format @ NumberFormat::U32Fixed { .. } => {
                Err(FilteringError::parameter("format", format, "needs a summed-area table"))
            }
            NumberFormat::Unorm8
            | NumberFormat::Unorm10
            | NumberFormat::Unorm16
            | NumberFormat::F16
            | NumberFormat::F32 => Ok(()),
        }
    }
}

/// A map of what `each` makes of the depth of every texel.
///
/// # Errors
/// [`FilteringError::NotFinite`] where it makes no number.
pub(crate) fn each_texel<P: Precision>(
    map: &DepthMap,
    channels: usize,
    each: impl Fn(f32, &mut [P]) + Sync,
) -> Result<ChannelMap<P>, FilteringError> {
    let mut data = vec![P::zero(); map.depths().len() * channels];
    let rows = data.par_chunks_mut(map.width() * channels).zip(map.depths().par_chunks(map.width()));
    rows.for_each(|(row, depths)| {
        for (texel, &depth) in row.chunks_exact_mut(channels).zip(depths) {
            each(depth, texel);
        }
    });
    ChannelMap::new(map.width(), map.height(), channels, data)
}

/// A number type that techniques are computed in.
pub trait Precision: Real + Send + Sync {
    /// b(z).
    fn evaluate(basis: &dyn AnyBasis, z: Self, out: &mut [Self]);

    /// The transform of a technique's encoding.
    fn transform(technique: &Technique, b: &[Self], out: &mut [Self]);

    /// Its inverse.
    fn restore(technique: &Technique, stored: &[Self], out: &mut [Self]);

    /// What is left of a value once it was stored.
    fn rounded(self, format: NumberFormat) -> Self;

    /// G(b, z_f).
    ///
    /// # Errors
    /// As [`Technique::shade`].
    fn shade(bound: &dyn AnyBound, b: &[Self], z_f: Self) -> Result<Self, FilteringError>;

    /// Both bounds.
    ///
    /// # Errors
    /// As [`Technique::shade`].
    fn bounds(bound: &dyn AnyBound, b: &[Self], z_f: Self) -> Result<Pair<Self>, FilteringError>;
}

impl Precision for f64 {
    fn evaluate(basis: &dyn AnyBasis, z: Self, out: &mut [Self]) {
        basis.evaluate_double(z, out);
    }

    fn transform(technique: &Technique, b: &[Self], out: &mut [Self]) {
        technique.encoding.transform().apply(b, out);
    }

    fn restore(technique: &Technique, stored: &[Self], out: &mut [Self]) {
        technique.encoding.transform().invert(stored, out);
    }

    fn rounded(self, format: NumberFormat) -> Self {
        format.round(self)
    }

    fn shade(bound: &dyn AnyBound, b: &[Self], z_f: Self) -> Result<Self, FilteringError> {
        bound.shade_double(b, z_f)
    }

    fn bounds(bound: &dyn AnyBound, b: &[Self], z_f: Self) -> Result<Pair<Self>, FilteringError> {
        bound.bounds_double(b, z_f)
    }
}

impl Precision for f32 {
    fn evaluate(basis: &dyn AnyBasis, z: Self, out: &mut [Self]) {
        basis.evaluate_single(z, out);
    }

    fn transform(technique: &Technique, b: &[Self], out: &mut [Self]) {
        match &technique.single {
            None => out.copy_from_slice(b),
            Some(single) => single.transform(b, out),
        }
    }

    fn restore(technique: &Technique, stored: &[Self], out: &mut [Self]) {
        match &technique.single {
            None => out.copy_from_slice(stored),
            Some(single) => single.restore(stored, out),
        }
    }

    fn rounded(self, format: NumberFormat) -> Self {
        format.round_single(self)
    }

    fn shade(bound: &dyn AnyBound, b: &[Self], z_f: Self) -> Result<Self, FilteringError> {
        match bound.real_time() {
            Some(bound) => Ok(bound.shade_single(b, z_f)),
            None => Ok(bound.shade_double(&double(b), f64::from(z_f))? as f32),
        }
    }

    fn bounds(bound: &dyn AnyBound, b: &[Self], z_f: Self) -> Result<Pair<Self>, FilteringError> {
        match bound.real_time() {
            Some(bound) => Ok(bound.bounds_single(b, z_f)),
            None => {
                let Pair { lower, upper } = bound.bounds_double(&double(b), f64::from(z_f))?;
                Ok(Pair { lower: lower as f32, upper: upper as f32 })
            }
        }
    }
}

fn double(b: &[f32]) -> Vec<f64> {
    b.iter().map(|&value| f64::from(value)).collect()
}
