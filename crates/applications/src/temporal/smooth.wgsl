// Where the standard error is too large neighbours are asked over the penumbra's width (TC09 section 3.3), as far as they are
// surfaces of like depth: a thread a pixel.

@group(0) @binding(0) var<storage, read> before: array<u32>;
@group(0) @binding(1) var<storage, read> after: array<u32>;
@group(0) @binding(2) var<storage, read> pixels: array<Pixel>;
@group(0) @binding(3) var<storage, read> shown: array<vec4<f32>>;
@group(0) @binding(4) var<uniform> screen: Screen;
@group(0) @binding(5) var<storage, read_write> shadows: array<f32>;

fn smoothed(index: u32, pixel: Pixel, estimate: f32) -> f32 {
    let blocker = max(load_after(index).blocker, LEAST_BLOCKER * pixel.receiver);
    // Equation 6.
    let width =
        screen.light_size * (pixel.receiver - blocker) / blocker * screen.pixels_per_unit / pixel.depth;
    if !(width > 0.0) {
        return estimate;
    }
    var place = vec3<f32>(f32(index % screen.width) + 0.5, f32(index / screen.width) + 0.5, pixel.depth);
    if PREVIOUS {
        place = pixel.before.xyz;
    }
    var taps = TAPS;
    var sum = estimate;
    var count = 1.0;
    for (var k = 0u; k < TAP_COUNT; k++) {
        let tap = place.xy + 0.5 * width * vec2<f32>(taps[2u * k], taps[2u * k + 1u]);
        if is_on(screen, tap) {
            var history: History;
            if PREVIOUS {
                history = load_before(pixel_of(screen, tap));
            } else {
                history = load_after(pixel_of(screen, tap));
            }
            if belongs_to(history, place.z, DEPTH_RANGE * place.z) {
                sum = sum + clamp_unit(fraction(history));
                count = count + 1.0;
            }
        }
    }
    return sum / count;
}

@compute @workgroup_size(64)
fn smooth_shadows(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = index_of(id, groups);
    if index >= screen.width * screen.height {
        return;
    }
    let found = shown[index];
    let pixel = pixels[index];
    var shadow = found.x;
    if FILTERED && is_flagged(pixel, SHOWN) && found.y > THRESHOLD {
        shadow = smoothed(index, pixel, shadow);
    }
    shadows[index] = shadow;
}
