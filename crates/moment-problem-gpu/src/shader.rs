//! The stages of the solver in WGSL, written out for four functions: no loop over rows is left, so that everything stays in
//! registers.
//!
//! All indices into workgroup memory are columns of the support, kept in range where they arise; indices into buffers are below
//! the sizes in `size`. The module may therefore be compiled without run-time checks; with them it is its own test twin.

mod factors;
mod pivots;

use factors::{factors, shift, sort};
use pivots::pivots;
use std::fmt::Write;

/// Invocations of a workgroup of the stages that walk through programs.
pub(crate) const INVOCATIONS: u32 = 128;

/// Programs of a workgroup of the stages that sum up.
pub(crate) const GROUP: u32 = 256;

/// Candidates whose moments are computed together.
pub(crate) const TOGETHER: u32 = 4;

/// Products that are summed before the sum is added to the others.
pub(crate) const CHAIN: u32 = 8;

/// Every so many columns are priced first.
const COARSE: u32 = 8;

/// How the module is to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Depths of the support.
    pub(crate) depths: u32,
    /// Dimensions of the span.
    pub(crate) dimensions: u32,
    /// Whether invocations of a subgroup may count each other.
    pub(crate) subgroups: bool,
}

/// Repeats lines for rows; `#` is the number, `+` the next one.
fn rows(text: &mut String, numbers: std::ops::Range<usize>, line: &str) {
    for i in numbers {
        let filled = line.replace('#', &i.to_string()).replace('@', &(i + 1).to_string());
        let _ = writeln!(text, "{filled}");
    }
}

/// The module.
pub(crate) fn source(options: Options) -> String {
    let Options { depths, dimensions, subgroups } = options;
    let coarse = depths.div_ceil(COARSE);
    let last = depths - 1;
    let mut text = format!(
        "struct Size {{ programs: u32, stride: u32, candidates: u32, share: u32, round: u32, capacity: u32, groups: u32, unused: u32 }}
const DEPTHS: i32 = {depths}i;
const LAST: i32 = {last}i;
const DIMENSIONS: u32 = {dimensions}u;
const CANDIDATE: u32 = {candidate}u;
@group(0) @binding(0) var<uniform> size: Size;
@group(0) @binding(1) var<storage, read> columns: array<vec2<f64>>;
@group(0) @binding(2) var<storage, read> transform: array<vec4<f64>>;
@group(0) @binding(3) var<storage, read> coordinates: array<f64>;
@group(0) @binding(4) var<storage, read> guesses: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> steps: array<i32>;
@group(0) @binding(6) var<storage, read> masses: array<vec2<f64>>;
@group(0) @binding(7) var<storage, read> weighting: array<vec4<f64>>;
@group(0) @binding(8) var<storage, read_write> moments: array<f64>;
@group(0) @binding(9) var<storage, read_write> supports: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read_write> bounds: array<f64>;
@group(0) @binding(11) var<storage, read_write> queues: array<u32>;
@group(0) @binding(12) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(13) var<storage, read_write> rest: array<vec4<u32>>;
@group(0) @binding(15) var<storage, read> kernels: array<vec2<u32>>;
@group(0) @binding(14) var<storage, read_write> sums: array<vec4<f64>>;
var<workgroup> a01: array<vec2<f64>, {depths}>;
var<workgroup> a23: array<vec2<f64>, {depths}>;
var<workgroup> coarse: array<vec4<f32>, {coarse}>;
var<workgroup> next: atomic<u32>;
struct Support {{ x0: i32, x1: i32, x2: i32, x3: i32, x4: i32 }}
struct Five {{ v0: f64, v1: f64, v2: f64, v3: f64, v4: f64 }}
",
        candidate = 2 * depths + 4,
    );
    text += if subgroups { COUNTED } else { ALONE };
    text += &factors();
    text += &shift();
    text += &sort();
    text += STAGES;
    text += &pivots(coarse);
    text
}

/// Lanes wait until a quarter of the subgroup has nothing to do, and share one access to a counter.
const COUNTED: &str = "
fn is_time(idle: bool) -> bool {
    let waiting = subgroupAdd(select(0u, 1u, idle));
    let all = subgroupAdd(1u);
    return waiting * 4u >= all;
}
fn place(counter: u32, wanted: bool) -> u32 {
    let one = select(0u, 1u, wanted);
    let before = subgroupExclusiveAdd(one);
    let all = subgroupAdd(one);
    var start = 0u;
    if (subgroupExclusiveAdd(1u) == 0u && all > 0u) { start = atomicAdd(&counts[counter], all); }
    return subgroupBroadcastFirst(start) + before;
}
fn least_step(step: i32) -> i32 { return subgroupMin(step); }
fn largest_step(step: i32) -> i32 { return subgroupMax(step); }
";

/// Each lane for itself.
const ALONE: &str = "
fn is_time(idle: bool) -> bool { return idle; }
fn place(counter: u32, wanted: bool) -> u32 {
    if (wanted) { return atomicAdd(&counts[counter], 1u); }
    return 0u;
}
fn least_step(step: i32) -> i32 { return 0i; }
fn largest_step(step: i32) -> i32 { return DEPTHS; }
";

const STAGES: &str = include_str!("stages.wgsl");
