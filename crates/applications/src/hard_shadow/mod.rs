//! Filtered hard shadows of a directional light (MSM15 section 3.2): the region is the filter's kernel around the
//! receiver's texel, the truth percentage-closer filtering with the receiver's plane.

mod estimate;
mod settings;
mod truth;

pub use estimate::{PreparedShadow, ShadowMethod};
pub use settings::BiasSetting;

use shadow_filtering::{DepthMap, Kernel, Receiver};

/// Filtered hard shadows on a lit view, under one pair of depth biases.
#[derive(Clone, Copy)]
pub struct HardShadow<'a> {
    /// The shadow map.
    pub map: &'a DepthMap,
    /// The filter.
    pub kernel: &'a Kernel,
    /// Unit of the constant biases, see [`shadow_filtering::DepthBias`].
    pub texel_depth: f64,
    /// Depth biases.
    pub bias: BiasSetting,
    /// Largest difference between the receiver's depth and its tangent plane at a tap, and largest slope that a bias
    /// takes into account.
    pub plane_limit: f64,
}

impl HardShadow<'_> {
    /// The depth that techniques compare at a receiver, in \[0, 1\]; they know no plane.
    pub fn compared(&self, receiver: &Receiver) -> f64 {
        self.bias.technique.compared(receiver, self.texel_depth, self.plane_limit)
    }

    /// F_Z at the depth that techniques compare: what a lower bound must not exceed.
    pub fn bounded(&self, receiver: &Receiver) -> f64 {
        self.kernel.percentage_closer(self.map, receiver.x, receiver.y, self.compared(receiver))
    }
}
