//! Regions of a shadow map over which filterable values are averaged, a file each: a stored map that is prepared for
//! them answers for the mean over any one.

mod kernel;
mod pyramid;
mod summed_area;

pub use kernel::{KernelField, Position, encode, filter};
pub use pyramid::{MipTexel, Pyramid, resolve};
use summed_area::BoxField;
pub use summed_area::SummedAreaField;

use crate::depth_map::DepthMap;
use crate::error::FilteringError;
use crate::kernel::Kernel;
use crate::technique::{MAX_CHANNELS, Precision, Technique};
use quantization::NumberFormat;

/// A stored map that answers for regions of one kind.
pub trait StoredField<P: Precision>: Sync {
    /// What is averaged over.
    type Region;

    /// Mean of the stored values over a region; `out` has one value a channel.
    ///
    /// # Errors
    /// [`FilteringError`] for regions that the map has no answer for.
    fn mean(&self, region: Self::Region, out: &mut [P]) -> Result<(), FilteringError>;
}

impl Technique {
    /// The filterable values b of a region, restored from a map that this technique has stored.
    ///
    /// # Errors
    /// As [`StoredField::mean`].
    pub fn moments<P: Precision, F: StoredField<P> + ?Sized>(
        &self,
        field: &F,
        region: F::Region,
        b: &mut [P],
    ) -> Result<(), FilteringError> {
        let mut mean = [P::zero(); MAX_CHANNELS];
        let mean = &mut mean[..b.len()];
        field.mean(region, mean)?;
        self.restore(mean, b);
        Ok(())
    }

    /// The map as the format stores it, for kernels around many texels: fixed point in a summed-area table, everything
    /// else in textures that two passes read and write.
    ///
    /// # Errors
    /// As [`Technique::check_kernel`].
    pub fn kernel_field<'a>(
        &'a self,
        map: &'a DepthMap,
        kernel: &'a Kernel,
    ) -> Result<Box<dyn StoredField<f64, Region = Position> + 'a>, FilteringError> {
        self.check_kernel(kernel)?;
        Ok(match self.encoding().format() {
            NumberFormat::U32Fixed { texels } => Box::new(BoxField::new(self, map, kernel, texels)?),
            NumberFormat::Unorm8
            | NumberFormat::Unorm10
            | NumberFormat::Unorm16
            | NumberFormat::F16
            | NumberFormat::F32 => Box::new(KernelField::stored(self, map, kernel)?),
        })
    }

    /// Rejects kernels that the storage cannot filter with.
    ///
    /// # Errors
    /// [`FilteringError::Parameter`] for fixed point with a kernel that is not uniform or has more texels than the format
    /// allows.
    pub fn check_kernel(&self, kernel: &Kernel) -> Result<(), FilteringError> {
        let format = self.encoding().format();
        let NumberFormat::U32Fixed { texels } = format else { return Ok(()) };
        let fail = |reason: &str| Err(FilteringError::parameter("format", format, reason));
        if kernel.weights().iter().any(|weight| *weight != kernel.weights()[0]) {
            return fail("a summed-area table needs a kernel of shape box");
        }
        if (kernel.size() * kernel.size()) as u64 > u64::from(texels) {
            return fail("the kernel has more texels than that");
        }
        Ok(())
    }
}
