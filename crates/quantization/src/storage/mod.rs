//! How moments are stored and restored.

mod encoding;
mod format;
mod range;
mod summed_area;
mod transform;

pub use encoding::Encoding;
pub use format::NumberFormat;
pub(crate) use range::ranges;
pub use range::{Range, plain, range};
pub use summed_area::{Rectangle, SummedAreaTable};
pub use transform::AffineTransform;
