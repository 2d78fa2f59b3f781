//! The modules of a shadowed frame: written by whoever knows a technique, run by whoever has a graphics device.

/// How texels of a filtered map are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// Fixed point from 0 to 1.
    Unorm16,
    /// Half floats.
    F16,
    /// Single floats.
    F32,
}

/// WGSL modules of a technique. Each has one vertex shader, whose one triangle covers the targets, and one fragment shader;
/// resources are bound by their names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FrameShaders {
    /// A map that is filtered before it is read.
    Prefiltered {
        /// From `depths`, samples of depth, to stored texels.
        resolve: String,
        /// From `map0`, `map1` to the same filtered along x.
        rows: String,
        /// From `map0`, `map1` to the same filtered along y.
        columns: String,
        /// From `map0`, `map1` to the next mip level.
        halve: String,
        /// From `map0`, `map1` through the sampler `linear`, and `light`, `positions`, `normals`, `albedos`, to colour and
        /// shadow.
        shade: String,
        /// Channels of each texture, 1 to 4.
        textures: Vec<usize>,
        /// Format of all of them.
        format: TexelFormat,
        /// The same as compute passes.
        compute: ComputeShaders,
    },
    /// A depth map that is compared tap by tap.
    Comparison {
        /// From `depths` and `light`, `positions`, `normals`, `albedos` to colour and shadow.
        shade: String,
        /// The same as a compute pass, which writes `colour` and `shadow`.
        compute_shade: String,
    },
}

/// The passes of [`FrameShaders::Prefiltered`] as compute shaders, each with one entry point and a thread a texel or pixel.
/// They read what the fragment shaders read, and write storage textures: `out0_0` and `out0_1`, or `colour` and `shadow`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComputeShaders {
    /// Stored texels.
    pub resolve: String,
    /// Filtered along x.
    pub rows: String,
    /// Filtered along y.
    pub columns: String,
    /// Number n makes n + 1 levels at once, `out0_0` to `outn_0`, from twice as many texels a side as the first of them has.
    pub halve: Vec<String>,
    /// Colour and shadow.
    pub shade: String,
}

impl FrameShaders {
    /// Every module with the name of its pass.
    pub fn modules(&self) -> Vec<(&'static str, &str)> {
        match self {
            Self::Prefiltered { resolve, rows, columns, halve, shade, compute, .. } => {
                let mut modules = vec![
                    ("resolve", resolve.as_str()),
                    ("rows", rows),
                    ("columns", columns),
                    ("halve", halve),
                    ("shade", shade),
                    ("compute resolve", &compute.resolve),
                    ("compute rows", &compute.rows),
                    ("compute columns", &compute.columns),
                    ("compute shade", &compute.shade),
                ];
                modules.extend(compute.halve.iter().map(|module| ("compute halve", module.as_str())));
                modules
            }
            Self::Comparison { shade, compute_shade } => {
                vec![("shade", shade), ("compute shade", compute_shade)]
            }
        }
    }
}
