//! How much memory a rendering may use, asked before it is allocated.

use crate::RenderError;
use crate::stack::prepare::PreparedTriangles;

/// Bytes per fragment at the peak of either backend: its key, its key in the buffer of a band in flight, depth,
/// gradient and bit.
const BYTES_PER_FRAGMENT: u64 = 8 + 4 + 12 + 1;
/// More where surfaces are translucent: opacity, and the triangle that it is of.
const BYTES_OF_OPACITY: u64 = 4 + 4;
/// Bytes per texel at the peak: final offsets and the bands' starts.
const BYTES_PER_TEXEL: u64 = 8;
/// Share of the available memory that is used at most, in percent.
const USABLE_PERCENT: u64 = 90;

/// Memory that can be allocated now, bytes: the least of the system's and the control group's free memory;
/// `u64::MAX` where the system does not tell.
pub(crate) fn available() -> u64 {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let free = match system.available_memory() {
        0 => u64::MAX,
        bytes => bytes,
    };
    match system.cgroup_limits() {
        Some(limits) if limits.total_memory > 0 => free.min(limits.free_memory),
        _ => free,
    }
}

/// The error for an allocation of `bytes` that cannot be made.
pub(crate) fn refused(what: &'static str, bytes: u64) -> RenderError {
    RenderError::OutOfMemory { what, needed_mib: bytes >> 20, available_mib: available() >> 20 }
}

/// A zeroed list, or a typed error where the allocator refuses. The pages are touched first by whoever fills them.
pub(crate) fn zeroed<T: bytemuck::Zeroable>(what: &'static str, len: usize) -> Result<Vec<T>, RenderError> {
    let list = bytemuck::allocation::try_zeroed_vec(len)
        .map_err(|()| refused(what, (len * size_of::<T>()) as u64))?;
    prefer_huge_pages(&list);
    Ok(list)
}

/// Asks for huge pages in a list about to be filled: the faults of small ones take a fifth of a rendering. Where the
/// system has none, or gives them anyway, nothing changes.
pub(crate) fn prefer_huge_pages<T>(list: &Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        const HUGE: usize = 2 << 20;
        let start = (list.as_ptr() as usize).next_multiple_of(HUGE);
        let end = (list.as_ptr() as usize + list.capacity() * size_of::<T>()) & !(HUGE - 1);
        if start < end {
            // SAFETY: the range lies within the list's own allocation, and MADV_HUGEPAGE changes neither contents nor
            // access, only which pages back them.
            unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = list;
}

/// Limit on fragments given the memory there is.
pub(crate) struct Budget {
    fixed_bytes: u64,
    fragment_bytes: u64,
    available: u64,
}

impl Budget {
    /// Checks the expected size of the stack of `prepared` and fixes the limit.
    ///
    /// # Errors
    /// [`RenderError::TooManyFragments`] or [`RenderError::OutOfMemory`] if the estimate, made from the triangles'
    /// areas and therefore too high only under alpha masks, lies clearly beyond what is possible.
    pub(crate) fn new(prepared: &PreparedTriangles, available: u64) -> Result<Self, RenderError> {
        let texels = u64::from(prepared.width) * u64::from(prepared.height);
        let of_opacity = if prepared.veils.is_empty() { 0 } else { BYTES_OF_OPACITY };
        let fragment_bytes = BYTES_PER_FRAGMENT + of_opacity;
        let budget = Self { fixed_bytes: texels * BYTES_PER_TEXEL, fragment_bytes, available };
        let estimate = prepared.estimated_fragments();
        // Masks only remove fragments; with them the exact count decides, on the way.
        let certain = if prepared.mask_planes.is_empty() { estimate - estimate / 20 } else { 0 };
        budget.check(certain)?;
        Ok(budget)
    }

    /// Fails if `fragments` cannot be held.
    pub(crate) fn check(&self, fragments: u64) -> Result<(), RenderError> {
        if fragments > u64::from(u32::MAX) {
            return Err(RenderError::TooManyFragments { at_least: fragments });
        }
        let needed = self.fixed_bytes + fragments * self.fragment_bytes;
        if needed > self.available / 100 * USABLE_PERCENT {
            return Err(RenderError::OutOfMemory {
                what: "the stack",
                needed_mib: needed >> 20,
                available_mib: self.available >> 20,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The map of a budget without fixed cost.
    fn budget(available: u64) -> Budget {
        Budget { fixed_bytes: 0, fragment_bytes: BYTES_PER_FRAGMENT, available }
    }

    #[test]
    fn limits_are_exact() {
        assert!(budget(u64::MAX).check(u64::from(u32::MAX)).is_ok());
        let too_many = budget(u64::MAX).check(1 << 32);
        assert!(matches!(too_many, Err(RenderError::TooManyFragments { at_least: 0x1_0000_0000 })));
        let million = 1_000_000 * BYTES_PER_FRAGMENT;
        assert!(budget(million * 2).check(1_000_000).is_ok());
        let refused = budget(million).check(1_000_000);
        let Err(RenderError::OutOfMemory { needed_mib, available_mib, .. }) = refused else {
            panic!("{refused:?}");
        };
        assert_eq!((needed_mib, available_mib), (million >> 20, million >> 20));
    }

    #[test]
    fn the_system_tells_its_memory() {
        assert!(available() > 1 << 20);
    }
}
