//! The layered shadow map: every surface a light ray crosses, per texel, in order.

pub(crate) mod assemble;
pub(crate) mod edges;
pub(crate) mod file;
pub(crate) mod fixed_point;
mod glyphs;
pub(crate) mod memory;
mod perspective;
pub mod pictures;
pub(crate) mod prepare;
pub(crate) mod rasterize;
pub(crate) mod stage_times;
pub(crate) mod veils;

use crate::RenderError;

/// Opacity from which a surface casts a shadow where shadows are not translucent, as scenes have it.
const OPAQUE_FROM: f32 = 0.5;

/// All fragments of a light's view, exactly, without a limit on layers.
///
/// Texel (x, y) has index `t = y * width + x`; its fragments are `offsets[t]..offsets[t + 1]`, ascending in depth.
/// Equal depths stand in the order of the scene's triangles; coincident surfaces are all kept. An empty texel has no
/// fragments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadowMapStack {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// First fragment of each texel, row-major, and one final entry: the number of fragments.
    pub offsets: Vec<u32>,
    /// Depth of each fragment in [0, 1], 0 at the light; renderings hold multiples of 2^-24.
    pub depths: Vec<f32>,
    /// d depth / d texel x and d depth / d texel y of each fragment's surface at the texel's centre, in perspective as
    /// under directional lights; steep slivers may have huge values.
    pub gradients: Vec<[f32; 2]>,
    /// One bit a fragment: its surface's front side points to the light.
    pub light_facing: FacingBits,
    /// Share of the arriving light in (0, 1\] that each fragment takes; empty where all are 1.
    pub opacities: Vec<f32>,
}

/// A packed list of booleans, bit `i % 32` of word `i / 32`; bits beyond the length are zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FacingBits {
    pub(crate) words: Vec<u32>,
    pub(crate) len: usize,
}

impl FacingBits {
    /// Number of bits.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True without any bit.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Bit `index`.
    ///
    /// # Panics
    /// If `index` is not below the length.
    #[inline]
    pub fn get(&self, index: usize) -> bool {
        assert!(index < self.len, "bit {index} of {}", self.len);
        self.words[index / 32] >> (index % 32) & 1 == 1
    }

    /// All bits in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = bool> + '_ {
        (0..self.len).map(|i| self.get(i))
    }
}

impl FromIterator<bool> for FacingBits {
    fn from_iter<I: IntoIterator<Item = bool>>(bits: I) -> Self {
        let mut out = Self::default();
        for bit in bits {
            if out.len.is_multiple_of(32) {
                out.words.push(0);
            }
            if let Some(word) = out.words.last_mut() {
                *word |= u32::from(bit) << (out.len % 32);
            }
            out.len += 1;
        }
        out
    }
}

/// One fragment of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Depth in [0, 1].
    pub depth: f32,
    /// d depth / d texel x, d texel y.
    pub gradient: [f32; 2],
    /// The surface's front side points to the light.
    pub light_facing: bool,
    /// Share of the arriving light that it takes.
    pub opacity: f32,
}

/// How many layers the covered texels of a stack have; all zero without fragments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerStatistics {
    /// Texels with at least one fragment.
    pub covered_texels: usize,
    /// Fragments per covered texel.
    pub mean: f64,
    /// Least layer count that at least 95 % of the covered texels do not exceed.
    pub p95: u32,
    /// Largest layer count.
    pub max: u32,
}

impl ShadowMapStack {
    /// Number of fragments.
    pub fn fragments(&self) -> usize {
        self.depths.len()
    }

    /// Index range of the fragments of texel (x, y).
    ///
    /// # Panics
    /// If the texel lies outside of the map.
    #[inline]
    fn range(&self, x: u32, y: u32) -> std::ops::Range<usize> {
        assert!(x < self.width && y < self.height, "texel ({x}, {y}) of {}x{}", self.width, self.height);
        let texel = y as usize * self.width as usize + x as usize;
        self.offsets[texel] as usize..self.offsets[texel + 1] as usize
    }

    /// The fragments of texel (x, y) from the light outwards.
    ///
    /// # Panics
    /// If the texel lies outside of the map.
    pub fn layers(&self, x: u32, y: u32) -> impl ExactSizeIterator<Item = Fragment> + '_ {
        self.range(x, y).map(|i| Fragment {
            depth: self.depths[i],
            gradient: self.gradients[i],
            light_facing: self.light_facing.get(i),
            opacity: self.opacity(i),
        })
    }

    /// Opacity of a fragment by its index.
    #[inline]
    pub fn opacity(&self, fragment: usize) -> f32 {
        self.opacities.get(fragment).copied().unwrap_or(1.0)
    }

    /// What shadows that know no translucency take: fragments whose opacity is at least one half, as opaque ones, and no
    /// others. That is how scenes with such surfaces are rendered without their opacity.
    pub fn opaque(self) -> Self {
        if self.opacities.is_empty() {
            return self;
        }
        self.retain(|opacity| opacity >= OPAQUE_FROM).with_opacities(Vec::new())
    }

    /// Without fragments that take no light; those that take all of it need no opacities.
    fn settled(self) -> Self {
        let opacities = &self.opacities;
        if opacities.iter().all(|&opacity| opacity == 1.0) {
            return self.with_opacities(Vec::new());
        }
        if opacities.iter().all(|&opacity| opacity > 0.0) {
            return self;
        }
        self.retain(|opacity| opacity > 0.0).settled()
    }

    fn with_opacities(self, opacities: Vec<f32>) -> Self {
        Self { opacities, ..self }
    }

    /// The fragments with opacities that are wanted.
    fn retain(self, wanted: impl Fn(f32) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.fragments()).filter(|&i| wanted(self.opacity(i))).collect();
        // Of the fragments before a texel, those that are kept.
        let offsets =
            self.offsets.iter().map(|&offset| kept.partition_point(|&i| i < offset as usize) as u32);
        Self {
            offsets: offsets.collect(),
            depths: kept.iter().map(|&i| self.depths[i]).collect(),
            gradients: kept.iter().map(|&i| self.gradients[i]).collect(),
            light_facing: kept.iter().map(|&i| self.light_facing.get(i)).collect(),
            opacities: kept.iter().map(|&i| self.opacity(i)).collect(),
            ..self
        }
    }

    /// Number of layers of each texel, row-major.
    pub fn layer_counts(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.offsets.windows(2).map(|w| w[1] - w[0])
    }

    /// Mean, 95th percentile and maximum of the layer counts of covered texels.
    pub fn layer_statistics(&self) -> LayerStatistics {
        let max = self.layer_counts().max().unwrap_or(0);
        let mut histogram = vec![0usize; max as usize + 1];
        for count in self.layer_counts() {
            histogram[count as usize] += 1;
        }
        let covered = self.offsets.len().saturating_sub(1) - histogram[0];
        if covered == 0 {
            return LayerStatistics::default();
        }
        let mut below = 0;
        let p95 = (1..=max).find(|&count| {
            below += histogram[count as usize];
            below * 100 >= covered * 95
        });
        LayerStatistics {
            covered_texels: covered,
            mean: self.fragments() as f64 / covered as f64,
            p95: p95.unwrap_or(max),
            max,
        }
    }

    /// Layer 0, the ordinary shadow map, row-major; `None` where a texel is empty.
    pub fn shadow_map(&self) -> Vec<Option<f32>> {
        self.offsets.windows(2).map(|w| (w[0] < w[1]).then(|| self.depths[w[0] as usize])).collect()
    }

    /// Checks every invariant of the fields.
    ///
    /// # Errors
    /// [`RenderError::InvalidStack`] with the first violation: lengths that do not agree, offsets that do not start
    /// at 0, descend or do not end at the number of fragments, depths outside [0, 1] or descending within a texel,
    /// gradients that are not finite. [`RenderError::MapSize`] for a size that is not supported.
    pub fn validate(&self) -> Result<(), RenderError> {
        let fail = |array, what| Err(RenderError::InvalidStack { array, what });
        crate::light_frame::check_size(self.width, self.height)?;
        let (texels, fragments) = (self.width as usize * self.height as usize, self.depths.len());
        if self.offsets.len() != texels + 1 {
            let what = format!("has {} values for {}x{} texels", self.offsets.len(), self.width, self.height);
            return fail("offsets", what);
        }
        if self.offsets[0] != 0 || self.offsets[texels] as usize != fragments {
            let (first, last) = (self.offsets[0], self.offsets[texels]);
            return fail("offsets", format!("runs from {first} to {last} instead of 0 to {fragments}"));
        }
        if self.gradients.len() != fragments {
            return fail("gradients", format!("has {} pairs for {fragments} depths", self.gradients.len()));
        }
        if self.light_facing.len() != fragments {
            return fail(
                "light_facing",
                format!("has {} bits for {fragments} depths", self.light_facing.len()),
            );
        }
        if let Some(texel) = self.offsets.windows(2).position(|w| w[0] > w[1]) {
            let (from, to) = (self.offsets[texel], self.offsets[texel + 1]);
            return fail("offsets", format!("descends from {from} to {to} after texel {texel}"));
        }
        if let Some(i) = self.depths.iter().position(|d| !(0.0..=1.0).contains(d)) {
            return fail("depths", format!("holds {} at {i}, outside of [0, 1]", self.depths[i]));
        }
        for (texel, w) in self.offsets.windows(2).enumerate() {
            let depths = &self.depths[w[0] as usize..w[1] as usize];
            if let Some(i) = depths.windows(2).position(|d| d[0] > d[1]) {
                let what = format!("descends from {} to {} in texel {texel}", depths[i], depths[i + 1]);
                return fail("depths", what);
            }
        }
        if let Some(i) = self.gradients.iter().position(|g| !(g[0].is_finite() && g[1].is_finite())) {
            return fail("gradients", format!("holds {:?} at {i}", self.gradients[i]));
        }
        if !self.opacities.is_empty() && self.opacities.len() != fragments {
            return fail("opacities", format!("has {} values for {fragments} depths", self.opacities.len()));
        }
        if let Some(i) = self.opacities.iter().position(|opacity| !(0.0..=1.0).contains(opacity)) {
            return fail("opacities", format!("holds {} at {i}, outside of [0, 1]", self.opacities[i]));
        }
        Ok(())
    }
}
