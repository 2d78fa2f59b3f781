// A summed-area table in two passes of wrapping sums: along the rows, a workgroup each, then down the columns, a workgroup for
// sixteen.

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
    if SIGNED {
        return transformed_codes(depth);
    }
    let base = fixed(warped(unit(depth)));
    var power = 0xffffffffu;
    var found: array<u32, CHANNELS>;
    for (var k = 0u; k < CHANNELS; k++) {
        power = select(rounded_product(power, base), base, power == 0xffffffffu);
        found[k] = code(power);
    }
    return found;
}

// a b / 2^bits to nearest, modulo 2^32; 0 < bits < 32.
fn shifted_product(a: u32, b: u32, bits: u32) -> u32 {
    let low = a * b;
    return (product_high(a, b) << (32u - bits)) + (low >> bits) + ((low >> (bits - 1u)) & 1u);
}

fn signed_product(a: i32, b: i32, bits: u32) -> i32 {
    let size = i32(shifted_product(u32(abs(a)), u32(abs(b)), bits));
    return select(size, -size, (a < 0) != (b < 0));
}

// Codes of OFFSET + MATRIX powers, given in units of 2^-28; powers and stored values are in units of 2^-30.
fn transformed_codes(depth: f32) -> array<u32, CHANNELS> {
    var matrix = MATRIX_28;
    var offset = OFFSET_28;
    let variable = i32(fixed(warped(unit(depth))) >> 1u) - (1 << 30u);
    var powers: array<i32, CHANNELS>;
    var power = 1 << 30u;
    for (var k = 0u; k < CHANNELS; k++) {
        power = signed_product(power, variable, 30u);
        powers[k] = power;
    }
    var found: array<u32, CHANNELS>;
    for (var i = 0u; i < CHANNELS; i++) {
        // Sums that leave the range on the way return: the stored value lies in [0, 1].
        var value = offset[i] << 2u;
        for (var j = 0u; j < CHANNELS; j++) {
            value = value + signed_product(powers[j], matrix[i * CHANNELS + j], 28u);
        }
        found[i] = shifted_product(u32(clamp(value, 0, 1 << 30u)), SCALE, 30u);
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

const COLUMNS: u32 = 16u;
const PARTS: u32 = 16u;
const PART: u32 = (HEIGHT + PARTS - 1u) / PARTS;

var<workgroup> part_sums: array<u32, PARTS * COLUMNS>;

// A workgroup takes neighbouring columns, and each thread a part of one: its sum, then those of the parts above, then prefixes.
@compute @workgroup_size(COLUMNS, PARTS)
fn columns(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
) {
    let line = WIDTH * CHANNELS;
    let column = group.x * COLUMNS + local.x;
    let counts = column < line;
    let start = min(local.y * PART, HEIGHT);
    let end = select(start, min(start + PART, HEIGHT), counts);
    var sum = 0u;
    for (var y = start; y < end; y++) {
        sum = sum + table[y * line + column];
    }
    part_sums[local.y * COLUMNS + local.x] = sum;
    workgroupBarrier();
    var running = 0u;
    for (var part = 0u; part < local.y; part++) {
        running = running + part_sums[part * COLUMNS + local.x];
    }
    for (var y = start; y < end; y++) {
        running = running + table[y * line + column];
        table[y * line + column] = running;
    }
}
