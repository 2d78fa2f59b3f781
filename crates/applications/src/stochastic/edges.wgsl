// Samples behind an edge become as wide as the least circle in front of them (SSSM15 section 5.2), a thread a texel.

@group(0) @binding(0) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> distances: array<f32>;
@group(0) @binding(3) var<uniform> plane: FilterPlane;
// What was found, then the same smoothed along rows.
@group(0) @binding(4) var<storage, read_write> circles: array<f32>;

const GAUSSIAN_TAPS: u32 = 5u;
const TURN: f32 = 6.28318531;

fn least_circle(texel: u32) -> f32 {
    let sample = texels[texel];
    if sample.x <= 0.0 {
        return 0.0;
    }
    let middle = centre_of(texel);
    let own = middle + sample.zw;
    let turned = sine_cosine(rays[texel].w * TURN);
    var taps = TAPS;
    var least = FAR;
    for (var k = 0u; k < TAP_COUNT; k++) {
        let tap = vec2<f32>(taps[2u * k], taps[2u * k + 1u]);
        let along = vec2<f32>(turned.y * tap.x - turned.x * tap.y, turned.x * tap.x + turned.y * tap.y);
        let place = middle + EDGE_REACH * along;
        if is_inside(place) {
            let other = texel_of(place);
            let found = texels[other];
            let apart = (floor(place) + 0.5 + found.zw - own) / plane.aspect;
            let is_nearer = found.x > 0.0 && distances[other] < distances[texel];
            if is_nearer && apart.x * apart.x + apart.y * apart.y < found.y * found.y {
                least = min(least, found.y);
            }
        }
    }
    return select(0.0, least, least < FAR);
}

@compute @workgroup_size(256)
fn find_edges(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let texel = id.y * groups.x * 256u + id.x;
    if texel < COUNT {
        circles[texel] = least_circle(texel);
    }
}

// The place of a tap along an axis, two texels to each side at most.
fn tap_place(t: u32, k: u32, size: u32) -> u32 {
    return min(max(t + k, 2u) - 2u, size - 1u);
}

@compute @workgroup_size(256)
fn smooth_rows(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let texel = id.y * groups.x * 256u + id.x;
    if texel >= COUNT {
        return;
    }
    var weights = GAUSSIAN;
    var sum = 0.0;
    for (var k = 0u; k < GAUSSIAN_TAPS; k++) {
        sum = sum + weights[k] * circles[texel / WIDTH * WIDTH + tap_place(texel % WIDTH, k, WIDTH)];
    }
    circles[COUNT + texel] = sum;
}

@compute @workgroup_size(256)
fn widen(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let texel = id.y * groups.x * 256u + id.x;
    if texel >= COUNT {
        return;
    }
    var weights = GAUSSIAN;
    var circle = 0.0;
    if SMOOTHED {
        for (var k = 0u; k < GAUSSIAN_TAPS; k++) {
            let row = tap_place(texel / WIDTH, k, HEIGHT);
            circle = circle + weights[k] * circles[COUNT + row * WIDTH + texel % WIDTH];
        }
    } else if TAP_COUNT > 0u {
        circle = circles[texel];
    }
    texels[texel].y = max(max(texels[texel].y, circle), LEAST_RADIUS);
}
