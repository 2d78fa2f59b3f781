//! A ray against the eight boxes of a node of the tree.

use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;

/// Who asks the boxes. All give the same answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoxTest {
    /// The tree's own, four boxes at once where there are vectors.
    Portable,
    /// Eight boxes at once.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl BoxTest {
    /// The fastest that this machine has.
    #[inline(always)]
    pub fn fastest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2") {
            return Self::Avx2;
        }
        Self::Portable
    }
}

/// The part of the ray's parameter below which the tree knows no boxes.
#[cfg(target_arch = "x86_64")]
const LEAST_PARAMETER: f32 = 1e-4;

/// The children that a ray meets, as the traversal wants them; the arithmetic is that of [`CwBvhNode::intersect_ray`], to
/// the order of its roundings.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
pub(super) fn intersect_avx2(node: &CwBvhNode, ray: &Ray, oct_inv4: u32) -> u32 {
    use std::arch::x86_64::*;
    let widen = |bytes: &[u8; 8]| {
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(i64::from_le_bytes(*bytes))))
    };
    let extent = node.compute_extent() * ray.inv_direction;
    let origin = (glam::Vec3A::from(node.p) - ray.origin) * ray.inv_direction;
    let along = |low: &[u8; 8], high: &[u8; 8], backwards: bool, extent: f32, origin: f32| {
        let (first, last) = if backwards { (high, low) } else { (low, high) };
        let (extent, origin) = (_mm256_set1_ps(extent), _mm256_set1_ps(origin));
        [first, last].map(|face| _mm256_add_ps(_mm256_mul_ps(widen(face), extent), origin))
    };
    let back = [ray.direction.x < 0.0, ray.direction.y < 0.0, ray.direction.z < 0.0];
    let [in_x, out_x] = along(&node.child_min_x, &node.child_max_x, back[0], extent.x, origin.x);
    let [in_y, out_y] = along(&node.child_min_y, &node.child_max_y, back[1], extent.y, origin.y);
    let [in_z, out_z] = along(&node.child_min_z, &node.child_max_z, back[2], extent.z, origin.z);
    let enter =
        _mm256_max_ps(_mm256_max_ps(in_x, in_y), _mm256_max_ps(in_z, _mm256_set1_ps(LEAST_PARAMETER)));
    let leave = _mm256_min_ps(_mm256_min_ps(out_x, out_y), _mm256_min_ps(out_z, _mm256_set1_ps(ray.tmax)));
    let mut met = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave)) as u32;
    let (child_bits, bit_index) = node.get_child_and_index_bits(oct_inv4);
    let mut hits = 0;
    while met != 0 {
        let shift = 8 * met.trailing_zeros();
        met &= met - 1;
        hits |= ((child_bits >> shift) as u32 & 0xff) << ((bit_index >> shift) as u32 & 0xff);
    }
    hits
}
