//! What a graphics processor can do at most, measured beside what it does.

use std::time::Duration;

use graphics_device::DeviceError;
use shaders::count;

use super::compute_chain::{ComputeChain, ComputePass, Content};

const SOURCE: &str = include_str!("limits.wgsl");

/// Bytes that are copied: several times what caches hold.
const BYTES: u64 = 256 << 20;

/// Steps of each chain, and threads: milliseconds of work on a large processor.
const ROUNDS: usize = 1024;
const THREADS: u64 = 1 << 21;

/// Timed runs of each.
const RUNS: usize = 10;

/// Peak rates through compute shaders, from the medians of several runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceLimits {
    /// Bytes read and written in a second by a copy of 256 MiB.
    pub bytes_per_second: f64,
    /// Fused multiply-adds of single floats in a second.
    pub multiply_adds_per_second: f64,
}

impl DeviceLimits {
    /// Measures; `None` where the adapter has no timestamps.
    ///
    /// # Errors
    /// [`DeviceError`] where there is no adapter, too little memory, or the device fails.
    pub fn measure() -> Result<Option<Self>, DeviceError> {
        let mut chain = ComputeChain::open()?;
        chain.put("source", Content::Empty(BYTES))?;
        chain.put("target_", Content::Empty(BYTES))?;
        let source = format!("{}{SOURCE}", count("ROUNDS", ROUNDS));
        let source = source.as_str();
        let passes = [
            ComputePass { name: "copy", source, entry: "copy_all", groups: (BYTES / 16 / 256) as u32 },
            ComputePass { name: "fma", source, entry: "multiply_add", groups: (THREADS / 256) as u32 },
        ];
        let times = chain.time(&passes, Duration::from_millis(50), RUNS)?;
        let median = |index: usize| {
            let mut all: Vec<f64> =
                times.get(index).iter().flat_map(|pass| &pass.times).map(Duration::as_secs_f64).collect();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied().filter(|&time| time > 0.0)
        };
        let (Some(copy), Some(fma)) = (median(0), median(1)) else { return Ok(None) };
        Ok(Some(Self {
            bytes_per_second: 2.0 * BYTES as f64 / copy,
            multiply_adds_per_second: 4.0 * ROUNDS as f64 * THREADS as f64 / fma,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_are_valid() {
        let module = shaders::Module::new(&format!("{}{SOURCE}", count("ROUNDS", ROUNDS))).unwrap();
        for name in ["copy_all", "multiply_add"] {
            assert!(!module.entry_point(name).unwrap().bindings.is_empty());
        }
    }
}
