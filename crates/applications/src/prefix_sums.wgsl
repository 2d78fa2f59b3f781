// A summed-area table in two passes of wrapping sums: along the rows, a workgroup each, then down the columns, a thread each.

@group(0) @binding(0) var depths: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> table: array<u32>;

const THREADS: u32 = 256u;
const SEGMENT: u32 = (WIDTH + THREADS - 1u) / THREADS;

var<workgroup> totals: array<array<u32, CHANNELS>, THREADS>;

// The upper half of a 64-bit product.
fn product_high(a: u32, b: u32) -> u32 {
    let low = vec2<u32>(a & 0xffffu, b & 0xffffu);
    let high = vec2<u32>(a >> 16u, b >> 16u);
    let carry = (low.x * low.y) >> 16u;
    let first = high.x * low.y + carry;
    let second = low.x * high.y + (first & 0xffffu);
    return high.x * high.y + (first >> 16u) + (second >> 16u);
}

// A product of which one factor or both are shares of 2^32, to nearest.
fn rounded_product(a: u32, b: u32) -> u32 {
    return product_high(a, b) + ((a * b) >> 31u);
}

// A number in [0, 1] as a share of 2^32 - 1: all bits of a single float in [2^-9, 1).
fn fixed(value: f32) -> u32 {
    if value >= 1.0 {
        return 0xffffffffu;
    }
    return u32(value * 4294967296.0);
}

// A share of 2^32 - 1 as a code: rounded to nearest, 1 becomes SCALE.
fn code(share: u32) -> u32 {
    if share == 0xffffffffu {
        return SCALE;
    }
    return rounded_product(share, SCALE);
}

// Powers in whole numbers: those of single floats would err by a hundred codes.
fn codes(depth: f32) -> array<u32, CHANNELS> {
    let base = fixed(warped(unit(depth)));
    var power = 0xffffffffu;
    var found: array<u32, CHANNELS>;
    for (var k = 0u; k < CHANNELS; k++) {
        power = select(rounded_product(power, base), base, power == 0xffffffffu);
        found[k] = code(power);
    }
    return found;
}

@compute @workgroup_size(THREADS)
fn rows(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let y = group.x;
    let start = min(thread * SEGMENT, WIDTH);
    let end = min(start + SEGMENT, WIDTH);
    var sums: array<u32, CHANNELS>;
    for (var x = start; x < end; x++) {
        let added = codes(textureLoad(depths, vec2<u32>(x, y), 0).x);
        for (var k = 0u; k < CHANNELS; k++) {
            sums[k] = sums[k] + added[k];
        }
    }
    totals[thread] = sums;
    workgroupBarrier();
    // Sums of the segments up to each, doubling the distance.
    for (var distance = 1u; distance < THREADS; distance = distance * 2u) {
        var before: array<u32, CHANNELS>;
        if thread >= distance {
            before = totals[thread - distance];
        }
        workgroupBarrier();
        for (var k = 0u; k < CHANNELS; k++) {
            totals[thread][k] = totals[thread][k] + before[k];
        }
        workgroupBarrier();
    }
    var running: array<u32, CHANNELS>;
    if thread > 0u {
        running = totals[thread - 1u];
    }
    for (var x = start; x < end; x++) {
        let added = codes(textureLoad(depths, vec2<u32>(x, y), 0).x);
        for (var k = 0u; k < CHANNELS; k++) {
            running[k] = running[k] + added[k];
            table[(y * WIDTH + x) * CHANNELS + k] = running[k];
        }
    }
}

@compute @workgroup_size(64)
fn columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let line = WIDTH * CHANNELS;
    if id.x >= line {
        return;
    }
    // No constant: a loop over all rows is not to be written out.
    let height = HEIGHT;
    var sum = 0u;
    for (var y = 0u; y < height; y++) {
        sum = sum + table[y * line + id.x];
        table[y * line + id.x] = sum;
    }
}
