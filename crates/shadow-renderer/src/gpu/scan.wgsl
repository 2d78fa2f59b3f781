// Exclusive prefix sums of the counters of a band: starts and, as the same numbers, the first free slots.

struct Params {
    texels: u32,
    blocks: u32,
}

const THREADS: u32 = 256u;
const PER_THREAD: u32 = 4u;

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read_write> counters: array<u32>;
@group(0) @binding(2) var<storage, read_write> starts: array<u32>;
// One sum per block of 1024 texels and, last, the total.
@group(0) @binding(3) var<storage, read_write> block_sums: array<u32>;

var<workgroup> partial: array<u32, 256>;

// Exclusive prefix sum over the workgroup's values; the second component is the sum of all.
fn scan_workgroup(thread: u32, value: u32) -> vec2<u32> {
    partial[thread] = value;
    workgroupBarrier();
    for (var distance = 1u; distance < THREADS; distance *= 2u) {
        var before = 0u;
        if thread >= distance {
            before = partial[thread - distance];
        }
        workgroupBarrier();
        partial[thread] += before;
        workgroupBarrier();
    }
    let all = partial[THREADS - 1u];
    let inclusive = partial[thread];
    workgroupBarrier();
    return vec2<u32>(inclusive - value, all);
}

@compute @workgroup_size(256)
fn scan_blocks(@builtin(workgroup_id) block: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = (block.x * THREADS + thread) * PER_THREAD;
    var sum = 0u;
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < params.texels {
            sum += counters[first + i];
        }
    }
    let scanned = scan_workgroup(thread, sum);
    var start = scanned.x;
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < params.texels {
            starts[first + i] = start;
            start += counters[first + i];
        }
    }
    if thread == 0u {
        block_sums[block.x] = scanned.y;
    }
}

// One workgroup: sums of blocks to their starts.
@compute @workgroup_size(256)
fn scan_sums(@builtin(local_invocation_index) thread: u32) {
    var carry = 0u;
    for (var first = 0u; first < params.blocks; first += THREADS) {
        let block = first + thread;
        var sum = 0u;
        if block < params.blocks {
            sum = block_sums[block];
        }
        let scanned = scan_workgroup(thread, sum);
        if block < params.blocks {
            block_sums[block] = carry + scanned.x;
        }
        carry += scanned.y;
    }
    if thread == 0u {
        block_sums[params.blocks] = carry;
    }
}

@compute @workgroup_size(256)
fn add_sums(@builtin(workgroup_id) block: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let first = (block.x * THREADS + thread) * PER_THREAD;
    for (var i = 0u; i < PER_THREAD; i++) {
        if first + i < params.texels {
            let start = starts[first + i] + block_sums[block.x];
            starts[first + i] = start;
            counters[first + i] = start;
        }
    }
}
