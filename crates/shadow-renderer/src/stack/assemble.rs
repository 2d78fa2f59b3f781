//! Sorted fragment keys to a stack: the last step, shared by both backends.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use crate::stack::FacingBits;
use crate::stack::fixed_point::depth_from_fixed;
use crate::stack::memory::zeroed;
use crate::stack::perspective;
use crate::stack::prepare::PreparedTriangles;
use crate::stack::veils::Veils;
use crate::{RenderError, ShadowMapStack};

/// A fragment: depth in units of 2^-24 in the upper, prepared triangle's index in the lower half. Keys are distinct
/// within a texel, so their order, and with it the stack, does not depend on who sorted them.
pub(crate) type Key = u64;

pub(crate) fn key(depth: u32, triangle: u32) -> Key {
    u64::from(depth) << 32 | u64::from(triangle)
}

/// Fragments of consecutive rows of the map.
pub(crate) struct Band {
    /// Fragments before each texel, counted from the band's start, one value a texel.
    pub starts: Vec<u32>,
    /// Keys, ascending within a texel.
    pub keys: Vec<Key>,
}

/// Joins bands, in the map's order, into a stack; with the scene's triangle of each fragment where some are translucent.
pub(crate) fn assemble(
    prepared: PreparedTriangles,
    bands: Vec<Band>,
) -> Result<(ShadowMapStack, Vec<u32>), RenderError> {
    let (bands, opacities, sources) = Veils::covered(&prepared, bands);
    let PreparedTriangles { mut triangles, surfaces, weights, width, height, .. } = prepared;
    let in_perspective = !weights.is_empty();
    if !in_perspective {
        // Makes room for the stack.
        triangles = Vec::new();
    }
    let fragments: usize = bands.iter().map(|b| b.keys.len()).sum();
    if fragments as u64 > u64::from(u32::MAX) {
        return Err(RenderError::TooManyFragments { at_least: fragments as u64 });
    }
    let texels = width as usize * height as usize;
    let mut offsets = zeroed::<u32>("the stack", texels + 1)?;
    let mut depths = zeroed::<f32>("the stack", fragments)?;
    let mut gradients = zeroed::<[f32; 2]>("the stack", fragments)?;
    let mut words: Vec<AtomicU32> = Vec::new();
    words.resize_with(fragments.div_ceil(32), || AtomicU32::new(0));
    offsets[texels] = fragments as u32;

    let mut parts = Vec::with_capacity(bands.len());
    let mut rest = (&mut offsets[..texels], &mut depths[..], &mut gradients[..]);
    let (mut first, mut first_texel) = (0, 0);
    for band in bands {
        let (offsets, later_offsets) = rest.0.split_at_mut(band.starts.len());
        let (depths, later_depths) = rest.1.split_at_mut(band.keys.len());
        let (gradients, later_gradients) = rest.2.split_at_mut(band.keys.len());
        rest = (later_offsets, later_depths, later_gradients);
        let (length, texels) = (band.keys.len(), band.starts.len());
        parts.push(((first, first_texel), band, offsets, depths, gradients));
        (first, first_texel) = (first + length, first_texel + texels);
    }
    parts.into_par_iter().for_each(|((first, first_texel), band, offsets, depths, gradients)| {
        for (offset, start) in offsets.iter_mut().zip(&band.starts) {
            *offset = first as u32 + start;
        }
        let mut word = 0u32;
        for (i, &key) in band.keys.iter().enumerate() {
            let surface = &surfaces[key as u32 as usize];
            depths[i] = depth_from_fixed((key >> 32) as u32);
            gradients[i] = surface.gradient;
            word |= surface.light_facing << ((first + i) % 32);
            if (first + i) % 32 == 31 || i + 1 == band.keys.len() {
                // Bands share their border words, each writes its own bits.
                words[(first + i) / 32].fetch_or(word, Ordering::Relaxed);
                word = 0;
            }
        }
        if in_perspective {
            perspective::gradients(&triangles, &weights, first_texel, width, &band, gradients);
        }
    });
    let words = words.into_iter().map(AtomicU32::into_inner).collect();
    let light_facing = FacingBits { words, len: fragments };
    Ok((ShadowMapStack { width, height, offsets, depths, gradients, light_facing, opacities }, sources))
}
