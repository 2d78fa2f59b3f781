// Encoded rectified texels to normalised prefix sums, a workgroup a row of a map: sums of segments, their prefix sums, then each texel.

@group(0) @binding(0) var<storage, read> texels: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> stored: array<u32>;
@group(0) @binding(2) var<uniform> view: Scattering;
// 1 / sin(theta) that a row's spacing is right for; those of a second map stand behind, as does that map.
@group(0) @binding(3) var<storage, read> inverse_sines: array<f32>;

const SEGMENT: u32 = (COLUMNS + THREADS - 1u) / THREADS;
// The sum of weights stands behind the channels.
const SUMMED: u32 = CHANNELS + 1u;

var<workgroup> totals: array<array<f32, SUMMED>, THREADS>;

fn weighted(index: u32, weight: f32) -> array<f32, CHANNELS> {
    let texel = texels[index];
    var mean = encode(stored_depth(texel.x));
    for (var k = 0u; k < CHANNELS; k++) {
        mean[k] = texel.z * mean[k];
    }
    if texel.w != 0.0 {
        let second = encode(stored_depth(texel.y));
        for (var k = 0u; k < CHANNELS; k++) {
            mean[k] = mean[k] + texel.w * second[k];
        }
    }
    var value = quantise(mean);
    for (var k = 0u; k < CHANNELS; k++) {
        value[k] = weight * value[k];
    }
    return value;
}

// e^(-sigma_t u delta): relative to the first texel's.
fn weight_of(u: u32, optical_depth: f32) -> f32 {
    let exponent = f32(u) * optical_depth;
    return select(exponential(-exponent), 0.0, exponent > 87.0);
}

@compute @workgroup_size(THREADS)
fn prefix(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let row = group.x % ROWS;
    let optical_depth = view.extinction * view.column_width * inverse_sines[group.x];
    let start = min(thread * SEGMENT, COLUMNS);
    let end = min(start + SEGMENT, COLUMNS);
    var sums: array<f32, SUMMED>;
    for (var u = start; u < end; u++) {
        let weight = weight_of(u, optical_depth);
        let added = weighted(row * COLUMNS + u, weight);
        for (var k = 0u; k < CHANNELS; k++) {
            sums[k] = sums[k] + added[k];
        }
        sums[CHANNELS] = sums[CHANNELS] + weight;
    }
    totals[thread] = sums;
    workgroupBarrier();
    // Sums of the segments up to each, doubling the distance.
    for (var distance = 1u; distance < THREADS; distance = distance * 2u) {
        var before: array<f32, SUMMED>;
        if thread >= distance {
            before = totals[thread - distance];
        }
        workgroupBarrier();
        for (var k = 0u; k < SUMMED; k++) {
            totals[thread][k] = totals[thread][k] + before[k];
        }
        workgroupBarrier();
    }
    var running: array<f32, SUMMED>;
    if thread > 0u {
        running = totals[thread - 1u];
    }
    for (var u = start; u < end; u++) {
        let weight = weight_of(u, optical_depth);
        let added = weighted(row * COLUMNS + u, weight);
        for (var k = 0u; k < CHANNELS; k++) {
            running[k] = running[k] + added[k];
        }
        running[CHANNELS] = running[CHANNELS] + weight;
        var mean: array<f32, CHANNELS>;
        for (var k = 0u; k < CHANNELS; k++) {
            mean[k] = running[k] / running[CHANNELS];
        }
        store(group.x * COLUMNS + u, mean);
    }
}
