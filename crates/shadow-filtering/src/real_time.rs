//! Techniques as shaders compute them: in single precision, with a twin in WGSL, at a known number of operations.

use crate::technique::Technique;

/// A technique that a shader can evaluate for every pixel.
pub trait RealTime: Technique {
    /// [`Technique::encode`] in single precision. `out` has [`Technique::channels`] values.
    fn encode_single(&self, depth: f32, out: &mut [f32]);

    /// [`Technique::shade`] in single precision. Moments are biased as much as single precision needs, unless the
    /// user has chosen a bias.
    fn shade_single(&self, filtered: &[f32], z_f: f32) -> f32;

    /// Both bounds, lower and upper, before they are blended; twice [`RealTime::shade_single`] where a technique has no
    /// upper bound.
    fn bounds_single(&self, filtered: &[f32], z_f: f32) -> [f32; 2] {
        [self.shade_single(filtered, z_f); 2]
    }

    /// The same two functions in WGSL, or `None` for a bound without a shader:
    /// `const CHANNELS`, `fn encode(depth: f32) -> array<f32, CHANNELS>` and
    /// `fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32`, with everything that they need.
    fn shader(&self) -> Option<String>;

    /// Operations of shading one fragment, in units of one addition; a division, root or elementary
    /// function counts as [`SPECIAL`](crate::SPECIAL).
    fn operations(&self, filtered: &[f32], z_f: f32) -> u64;
}

/// Implements [`RealTime`] by `encode_in` and `shade_in`, which are generic over the number type.
macro_rules! in_real_time {
    ($type:ty, |$technique:pat_param| $shader:expr $(, $more:item)?) => {
        impl RealTime for $type {
            fn encode_single(&self, depth: f32, out: &mut [f32]) {
                self.encode_in(depth, out);
            }

            fn shade_single(&self, filtered: &[f32], z_f: f32) -> f32 {
                self.shade_in(filtered, z_f)
            }

            $($more)?

            fn shader(&self) -> Option<String> {
                #[allow(unused_imports, reason = "a technique may have no shader")]
                use crate::shaders;
                let $technique = self;
                $shader
            }

            fn operations(&self, filtered: &[f32], z_f: f32) -> u64 {
                use crate::operations::{Counted, count};
                let filtered: Vec<Counted> = filtered.iter().map(|&value| Counted(value)).collect();
                count(|| self.shade_in(&filtered, Counted(z_f)))
            }
        }
    };
}

pub(crate) use in_real_time;
