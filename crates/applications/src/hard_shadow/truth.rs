//! F: percentage-closer filtering, each tap compared with the receiver's tangent plane at that tap.

use super::HardShadow;
use crate::application::Application;
use shadow_filtering::{Receiver, Reference};

impl Application for HardShadow<'_> {
    type Receiver = Receiver;

    fn truth(&self, receiver: &Receiver) -> f64 {
        let reference = Reference { bias: self.bias.reference, plane_limit: self.plane_limit };
        reference.intensity(self.map, self.kernel, receiver, self.texel_depth)
    }
}
