// Gives a level's samples to the next coarser one, as far as they are too wide for it (SSSM15 equation 8): a thread a coarser
// texel.

@group(0) @binding(0) var<storage, read_write> texels: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> values: array<f32>;

const WIDEST: f32 = 0.5 * GATHER_RADIUS;

fn coarser_weight(radius: f32) -> f32 {
    return clamp(1.0 - (WIDEST - radius) / (0.1 * GATHER_RADIUS), 0.0, 1.0);
}

@compute @workgroup_size(256)
fn split(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= COARSER_WIDTH * COARSER_HEIGHT {
        return;
    }
    let corner = 2u * vec2<u32>(index % COARSER_WIDTH, index / COARSER_WIDTH);
    var weight = 0.0;
    var radius = 0.0;
    var offset = vec2<f32>(0.0);
    var mean: array<f32, CHANNELS>;
    for (var part = 0u; part < 4u; part++) {
        let step = vec2<u32>(part & 1u, part >> 1u);
        let at = corner + step;
        if at.x < LEVEL_WIDTH && at.y < LEVEL_HEIGHT {
            let place = FIRST + at.y * LEVEL_WIDTH + at.x;
            let finer = texels[place];
            let coarser = coarser_weight(finer.y);
            let share = finer.x * coarser;
            if share > 0.0 {
                weight = weight + share;
                radius = radius + share * 0.5 * finer.y;
                if any(finer.zw != vec2<f32>(0.0)) {
                    offset = offset + share * 0.5 * (vec2<f32>(step) - 0.5 + finer.zw);
                }
                for (var k = 0u; k < CHANNELS; k++) {
                    mean[k] = mean[k] + share * values[place * CHANNELS + k];
                }
            }
            texels[place].x = finer.x * (1.0 - coarser);
        }
    }
    let inverse = select(0.0, 1.0 / weight, weight > 0.0);
    let to = COARSER_FIRST + index;
    texels[to] = vec4<f32>(weight, inverse * radius, inverse * offset);
    for (var k = 0u; k < CHANNELS; k++) {
        values[to * CHANNELS + k] = inverse * mean[k];
    }
}
