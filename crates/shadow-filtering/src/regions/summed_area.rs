//! Rectangles, by summed-area tables of fixed-point values: rounded once and filtered exactly (BHS16 section 3.2).

use super::{Position, StoredField};
use crate::depth_map::DepthMap;
use crate::error::FilteringError;
use crate::kernel::Kernel;
use crate::technique::Technique;
use quantization::{Rectangle, SummedAreaTable};

/// Sums over all texels above and to the left; regions are rectangles of at most as many texels as the format allows.
pub struct SummedAreaField {
    table: SummedAreaTable,
}

impl SummedAreaField {
    /// Stores a map for rectangles of at most so many texels.
    ///
    /// # Errors
    /// As [`SummedAreaTable::new`].
    pub fn new(technique: &Technique, map: &DepthMap, texels: u32) -> Result<Self, FilteringError> {
        let stored = technique.store::<f64>(map)?;
        let size = (map.width(), map.height(), technique.channels());
        Ok(Self { table: SummedAreaTable::new(size, stored.data(), texels)? })
    }
}

impl StoredField<f64> for SummedAreaField {
    type Region = Rectangle;

    fn mean(&self, rectangle: Rectangle, out: &mut [f64]) -> Result<(), FilteringError> {
        for (channel, value) in out.iter_mut().enumerate() {
            *value = self.table.mean(rectangle, channel)?;
        }
        Ok(())
    }
}

/// The same for a uniform kernel around the texel that a point lies in.
pub(super) struct BoxField {
    sums: SummedAreaField,
    radius: usize,
}

impl BoxField {
    /// Stores a map for kernels of at most so many texels.
    ///
    /// # Errors
    /// As [`SummedAreaField::new`].
    pub(super) fn new(
        technique: &Technique,
        map: &DepthMap,
        kernel: &Kernel,
        texels: u32,
    ) -> Result<Self, FilteringError> {
        Ok(Self { sums: SummedAreaField::new(technique, map, texels)?, radius: kernel.radius() })
    }
}

impl StoredField<f64> for BoxField {
    type Region = Position;

    fn mean(&self, at: Position, out: &mut [f64]) -> Result<(), FilteringError> {
        let (x, y) = (at.x as usize, at.y as usize);
        // Beyond the border the difference wraps around and the rectangle is refused.
        let first = (x.wrapping_sub(self.radius), y.wrapping_sub(self.radius));
        self.sums.mean(Rectangle { first, last: (x + self.radius, y + self.radius) }, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::TechniqueSpec;

    #[test]
    fn sums_are_the_box_filter_of_what_is_stored_once() {
        let depth = |t: usize| if t % 24 + t / 24 < 20 { 0.2 + 0.004 * (t % 24) as f32 } else { 0.7 };
        let map = DepthMap::new(24, 24, (0..24 * 24).map(depth).collect()).unwrap();
        let kernel = Kernel::uniform(9).unwrap();
        let spec: TechniqueSpec = toml::from_str("bound = 'hausdorff4'\nformat = 'u32/81'").unwrap();
        let technique = spec.build().unwrap();
        let field = technique.kernel_field(&map, &kernel).unwrap();
        let mut b = [0.0; 4];
        technique.moments(field.as_ref(), Position::of_texel(10, 12), &mut b).unwrap();
        let z = kernel.distribution(&map, 10, 12);
        for (k, value) in b.iter().enumerate() {
            let exact: f64 =
                z.depths().iter().zip(z.weights()).map(|(z, w)| z.powi(k as i32 + 1) * w.to_f64()).sum();
            assert!((value - exact).abs() <= technique.encoding().format().step(), "{value} {exact}");
        }
        assert!(technique.moments(field.as_ref(), Position::of_texel(1, 12), &mut b).is_err());
        assert!(technique.kernel_field(&map, &Kernel::gaussian(9, 2.4).unwrap()).is_err());
        assert!(technique.check_kernel(&Kernel::uniform(11).unwrap()).is_err());
    }
}
