//! How long the steps to a stack take.

use std::time::Duration;

/// Wall-clock time of each step. On the CPU the steps inside the bands overlap; there `raster`, `group` and `sort`
/// are sums over threads and `total` is less than the sum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// Projection, snapping and plane setup, on the CPU for both backends.
    pub prepare: Duration,
    /// GPU only: finding an adapter and compiling shaders; zero once they are cached.
    pub device: Duration,
    /// CPU: coverage and depth of all fragments. GPU: counting them, upload included.
    pub raster: Duration,
    /// CPU: counting sort by texel. GPU: prefix sums and scatter.
    pub group: Duration,
    /// Sorting by depth within the texels; on the GPU including read-back.
    pub sort: Duration,
    /// Final arrays from sorted keys, on the CPU for both backends.
    pub assemble: Duration,
    /// The whole call.
    pub total: Duration,
}
