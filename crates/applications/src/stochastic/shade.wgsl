// The shadow of fragments from the two planes around each (SSSM15 section 6), a thread a fragment; -1 where no sample reaches.

// Position on the map in texels, depth, and depth that is compared.
@group(0) @binding(0) var<storage, read> fragments: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> plane_distances: array<f32>;
@group(0) @binding(2) var<storage, read> plane_values: array<u32>;
@group(0) @binding(3) var<storage, read> plane_weights: array<f32>;
@group(0) @binding(4) var<uniform> plane: FilterPlane;
@group(0) @binding(5) var<storage, read_write> shadows: array<f32>;

struct Mean {
    values: array<f32, CHANNELS>,
    weight: f32,
}

// Between the texels that have any values.
fn mean_at(number: u32, place: vec2<f32>) -> Mean {
    let size = vec2<f32>(f32(WIDTH), f32(HEIGHT));
    let at = clamp(place - 0.5, vec2<f32>(0.0), size - 1.0);
    let low = floor(at);
    let second = at - low;
    var mean: Mean;
    for (var part = 0u; part < 4u; part++) {
        let step = vec2<f32>(f32(part & 1u), f32(part >> 1u));
        let shares = select(1.0 - second, second, step == vec2<f32>(1.0));
        let share = shares.x * shares.y;
        let texel = number * COUNT + texel_of(min(low + step, size - 1.0));
        if share > 0.0 && plane_weights[texel] > 0.0 {
            mean.weight = mean.weight + share;
            let values = load(texel);
            for (var k = 0u; k < CHANNELS; k++) {
                mean.values[k] = mean.values[k] + share * values[k];
            }
        }
    }
    if mean.weight > 0.0 {
        for (var k = 0u; k < CHANNELS; k++) {
            mean.values[k] = mean.values[k] / mean.weight;
        }
    }
    return mean;
}

@compute @workgroup_size(256)
fn shade_planes(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= arrayLength(&fragments) {
        return;
    }
    let fragment = fragments[index];
    let between = between_planes(plane.near + fragment.z * plane.range);
    var near = mean_at(between.lower, fragment.xy);
    var far: Mean;
    if between.share > 0.0 {
        far = mean_at(between.lower + 1u, fragment.xy);
    }
    if near.weight > 0.0 && far.weight > 0.0 {
        if BLEND_SHADOWS {
            let first = shade(dequantise(near.values), fragment.w);
            let second = shade(dequantise(far.values), fragment.w);
            shadows[index] = first + between.share * (second - first);
            return;
        }
        for (var k = 0u; k < CHANNELS; k++) {
            near.values[k] = near.values[k] + between.share * (far.values[k] - near.values[k]);
        }
    } else if far.weight > 0.0 {
        near = far;
    } else if near.weight == 0.0 {
        shadows[index] = -1.0;
        return;
    }
    shadows[index] = shade(dequantise(near.values), fragment.w);
}
