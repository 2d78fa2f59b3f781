// A trilinear sample of a moment shadow map for each texel of the rectified map, as two depths (BHS16 Algorithm 1).

// All levels one behind the other, what is stored as floats.
@group(0) @binding(0) var<storage, read> levels: array<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4<f32>>;
@group(0) @binding(2) var<uniform> view: Scattering;

// Depths from here on are those of empty texels, cleared to 1, and rounded.
const EMPTY: f32 = 0.9999;

// Adds a bilinear sample of a level, at a point in texels of the first one.
fn add_level(level: u32, weight: f32, at: vec2<f32>, sum: array<f32, CHANNELS>) -> array<f32, CHANNELS> {
    var size = vec2<u32>(MAP_WIDTH, MAP_HEIGHT);
    var first = 0u;
    for (var i = 0u; i < level; i++) {
        first = first + size.x * size.y;
        size = max(size / 2u, vec2<u32>(1u));
    }
    let place = at * (vec2<f32>(size) / vec2<f32>(f32(MAP_WIDTH), f32(MAP_HEIGHT))) - 0.5;
    let base = floor(place);
    let share = place - base;
    var mean = sum;
    for (var corner = 0u; corner < 4u; corner++) {
        let step = vec2<f32>(f32(corner & 1u), f32(corner >> 1u));
        let texel = vec2<u32>(clamp(base + step, vec2<f32>(0.0), vec2<f32>(size) - 1.0));
        let shares = mix(vec2<f32>(1.0) - share, share, step);
        let start = (first + texel.y * size.x + texel.x) * CHANNELS;
        for (var k = 0u; k < CHANNELS; k++) {
            mean[k] = mean[k] + weight * shares.x * shares.y * levels[start + k];
        }
    }
    return mean;
}

@compute @workgroup_size(64)
fn resample_filtered(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= COLUMNS * ROWS {
        return;
    }
    let r = (f32(index % COLUMNS) + 0.5) * view.column_width;
    let direction = sine_cosine(view.phi_start + (f32(index / COLUMNS) + 0.5) / view.rows_per_radian);
    let at = view.origin + r * vec2<f32>(direction.y, direction.x) * view.scale;
    if any(at < vec2<f32>(0.0)) || any(at > vec2<f32>(f32(MAP_WIDTH), f32(MAP_HEIGHT))) {
        texels[index] = vec4<f32>(1.0, 1.0, 1.0, 0.0);
        return;
    }
    // As wide as the texel is on the map: the mean of both sides.
    let footprint = sqrt(view.column_width * r / view.rows_per_radian) * min(view.scale.x, view.scale.y);
    let lod = clamp(log2(footprint), 0.0, f32(LEVELS - 1u));
    let lower = floor(lod);
    var stored: array<f32, CHANNELS>;
    stored = add_level(u32(lower), 1.0 - (lod - lower), at, stored);
    if lod > lower {
        stored = add_level(u32(lower) + 1u, lod - lower, at, stored);
    }
    let b = dequantise(stored);
    // About the mean: the product of the roots is minus the variance, so that neither cancels.
    let variance = b[1] - b[0] * b[0];
    let skewness = (b[2] - b[0] * b[1] - 2.0 * b[0] * variance) / variance;
    var depths = vec2<f32>(b[0]);
    var second = 0.0;
    if variance > 0.0 && abs(skewness) < 3.4e38 {
        let half = 0.5 * skewness;
        let root = sqrt(half * half + variance);
        let far = select(half - root, half + root, half >= 0.0);
        let near = -variance / far;
        let roots = vec2<f32>(min(near, far), max(near, far));
        if roots.y > roots.x {
            second = clamp_unit(-roots.x / (roots.y - roots.x));
            depths = depths + roots;
        }
    }
    depths = (depths - START) / (END - START);
    var rectified = vec2<f32>(1.0);
    for (var k = 0u; k < 2u; k++) {
        if depths[k] < EMPTY {
            rectified[k] = clamp_unit(rectified_depth(view, r, view.near + depths[k] * view.range));
        }
    }
    texels[index] = vec4<f32>(rectified, 1.0 - second, second);
}
