//! From alpha to the test whether there is a surface.

use crate::{AlphaMask, AlphaTexture};

/// Opacity from which a blended surface casts a shadow where shadows are not translucent: what is closer to opaque than to
/// clear is opaque. Renderers without translucent shadow maps test at one half, or dither with this mean.
pub(crate) const OPAQUE_FROM: f64 = 0.5;

/// Absorbs the rounding of decimal cutoffs such as 0.2 = 51/255, in units of 1/255.
const SLACK: f64 = 1e-4;

/// The mask for texture alpha times `factor` tested against `cutoff`; `None` if the test never fails.
pub(crate) fn alpha_mask(texels: Option<&AlphaTexture>, factor: f64, cutoff: f64) -> Option<AlphaMask> {
    // Texel t passes where t / 255 * factor >= cutoff.
    let threshold = (255.0 * cutoff / factor - SLACK).ceil();
    let (width, height, mut alpha) = match texels {
        Some(texels) => (texels.width, texels.height, texels.alpha.clone()),
        None => (1, 1, vec![255]),
    };
    if width == 0 || height == 0 || cutoff <= 0.0 || threshold <= 0.0 {
        return None;
    }
    let mut cutoff = threshold as u8;
    // A factor of 0 makes the threshold infinite: nothing passes.
    if threshold > 255.0 {
        (alpha, cutoff) = (vec![0; alpha.len()], 1);
    }
    (alpha.iter().any(|&a| a < cutoff)).then_some(AlphaMask { width, height, alpha, cutoff })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> AlphaTexture {
        AlphaTexture { width: 256, height: 1, alpha: (0..=255).collect() }
    }

    #[test]
    fn the_cutoff_is_the_first_alpha_that_passes() {
        let cutoff = |factor, cutoff| alpha_mask(Some(&ramp()), factor, cutoff).unwrap().cutoff;
        assert_eq!(cutoff(1.0, 0.5), 128);
        assert_eq!(cutoff(1.0, 0.2), 51);
        assert_eq!(cutoff(0.5, 0.25), 128);
        assert_eq!(cutoff(1.0, 1.0), 255);
    }

    #[test]
    fn a_test_that_never_or_always_fails_is_no_cutoff() {
        assert_eq!(alpha_mask(Some(&ramp()), 1.0, 0.0), None);
        assert_eq!(alpha_mask(None, 1.0, 0.5), None);
        for (factor, cutoff) in [(0.25, 0.5), (0.0, 0.5), (1.0, 1.5)] {
            let mask = alpha_mask(Some(&ramp()), factor, cutoff).unwrap();
            assert!(mask.alpha.iter().all(|&a| a < mask.cutoff), "{factor} {cutoff}");
        }
        assert_eq!(alpha_mask(None, 0.2, 0.5).unwrap().alpha, [0]);
    }
}
